//! `--excite`: test inputs during the autopilot flight.

use std::str::FromStr;

use hovernav::autopilot::{Excitation, ExcitationAbort, ExcitationLimits, Maneuver};
use hovernav::controls::Sticks;
use hovernav_sim::FlightEvent;

use crate::arguments::{finite, second};

/// Start of the first test input, s.
const FIRST_S: f64 = 30.0;
/// Pause after each test input, s.
const PAUSE_S: f64 = 8.0;

/// Test input in the form `STICK=KIND[:SIZE[:S]][@SECOND]`.
#[derive(Clone, Debug)]
pub struct TestInput {
    excitations: Vec<Excitation>,
    at_s: Option<f64>,
}

impl FromStr for TestInput {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "found \"{text}\", expected STICK=KIND[:SIZE[:S]][@SECOND] with STICK one of lateral, \
                 longitudinal, collective, pedal, all and KIND one of step, doublet, 3211, sweep, SECOND from 0 to a day"
            )
        };
        let (stick, rest) = text.split_once('=').ok_or_else(expected)?;
        let (rest, at_s) = match rest.split_once('@') {
            None => (rest, None),
            Some((rest, at)) => (rest, Some(second(at).ok_or_else(expected)?)),
        };
        let mut parts = rest.split(':');
        let kind = parts.next().unwrap_or_default();
        let mut number = || parts.next().map(|part| finite(part).ok_or_else(expected)).transpose();
        let (amplitude, lasts_s) = (number()?.unwrap_or(0.1), number()?);
        if amplitude == 0.0 {
            return Err(format!("found \"{text}\" with size 0, expected a SIZE other than 0"));
        }
        if parts.next().is_some() {
            return Err(expected());
        }
        let maneuver = match kind {
            "step" => Maneuver::Step { amplitude, hold_s: lasts_s.unwrap_or(1.5) },
            "doublet" => Maneuver::Doublet { amplitude, hold_s: lasts_s.unwrap_or(1.0) },
            "3211" => Maneuver::ThreeTwoOneOne { amplitude, unit_s: lasts_s.unwrap_or(0.5) },
            "sweep" => {
                let duration_s = lasts_s.unwrap_or(60.0);
                let fade_s = 0.05 * duration_s;
                Maneuver::Sweep { amplitude, first_hz: 0.1, last_hz: 3.0, duration_s, fade_s }
            }
            _ => return Err(expected()),
        };
        let sticks = Sticks::NAMES.iter().enumerate();
        let excitations: Vec<Excitation> = sticks
            .filter(|(_, name)| **name == stick || stick == "all")
            .map(|(index, _)| {
                let mut direction = [0.0; 4];
                direction[index] = 1.0;
                let direction = Sticks::from_array(direction);
                Excitation { direction, maneuver, limits: ExcitationLimits::default() }
            })
            .collect();
        let Some(first) = excitations.first() else { return Err(expected()) };
        first.check().map_err(|error| error.to_string())?;
        Ok(Self { excitations, at_s })
    }
}

/// The start time, s, of each of `inputs`, with its event.
pub fn events(inputs: &[TestInput]) -> Vec<(f64, FlightEvent)> {
    let mut next_s = FIRST_S;
    let mut events = Vec::new();
    for input in inputs {
        next_s = input.at_s.unwrap_or(next_s);
        for excitation in &input.excitations {
            events.push((next_s, FlightEvent::Excite(*excitation)));
            next_s += excitation.maneuver.duration_s() + PAUSE_S;
        }
    }
    events
}

/// The reason for the early end of a test input.
pub fn in_words(abort: ExcitationAbort) -> &'static str {
    match abort {
        ExcitationAbort::Mode => "the autopilot left the modes that hold velocity",
        ExcitationAbort::Tilt => "roll or pitch exceeded its limit",
        ExcitationAbort::Rate => "an angular rate exceeded its limit",
        ExcitationAbort::Speed => "the deviation from the commanded velocity exceeded its limit",
        _ => "a limit was exceeded",
    }
}
