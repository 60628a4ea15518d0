//! Checks of a flight before identification: warnings about sticks, kinematics and missing data.

use super::flight::{FlightRecord, MOTION};
use super::gaps::Gap;
use crate::methods::excitation::{InputFault, check_inputs};
use crate::methods::structure::Structure;
use crate::record::STICKS;
use crate::record::preprocess::{KinematicChannels, check_kinematics};

/// Fraction of missing data in the interval of a still stick above which no warning reports the stick.
const UNRECORDED: f64 = 0.9;

/// Warnings about the sticks and the motion of `flight`, one sentence each. They report sticks that do not move or move
/// together, and attitude, rates and velocity that are kinematically inconsistent.
///
/// Only the sticks and outputs of `structure` are checked. Times are those of the flight. [`FlightRecord::gaps`]
/// reports the parts without data.
#[must_use]
pub fn flight_warnings(flight: &FlightRecord, structure: &Structure) -> Vec<String> {
    let record = &flight.experiment;
    let names = |names: &[String]| -> Vec<&'static str> {
        let known = STICKS.into_iter().chain(MOTION);
        known.filter(|known| names.iter().any(|name| name == known)).collect()
    };
    let mut warnings = Vec::new();
    if let Ok(used) = record.select(&names(&structure.inputs), &names(&structure.outputs)) {
        let faults = check_inputs(&used).faults.into_iter();
        let faults = faults.filter_map(|fault| match fault {
            InputFault::Still { input, rows, span_s } => {
                let span_s = span_s.map(|own| own + flight.start.seconds());
                let is_recorded =
                    unrecorded_s(flight, span_s) < UNRECORDED * (span_s[1] - span_s[0]);
                is_recorded.then_some(InputFault::Still { input, rows, span_s })
            }
            other => Some(other),
        });
        warnings.extend(faults.map(|fault| fault.to_string()));
    }
    let every = KinematicChannels {
        roll: Some("phi"),
        pitch: Some("theta"),
        p: Some("p"),
        q: Some("q"),
        r: Some("r"),
        u: Some("u"),
        v: Some("v"),
        w: Some("w"),
        specific_force: None,
    };
    // The gyros alone give no attitude.
    let has_attitude = record.signal("phi").is_ok_and(|phi| phi.amax() > 0.0);
    if has_attitude && let Ok(report) = check_kinematics(record, &every) {
        warnings.extend(report.faults.iter().map(|fault| format!("kinematics: {fault}")));
    }
    warnings
}

/// Time without data between `from` and `to`, s.
fn unrecorded_s(flight: &FlightRecord, [from, to]: [f64; 2]) -> f64 {
    let within = |gap: &Gap| (gap.to.seconds().min(to) - gap.from.seconds().max(from)).max(0.0);
    flight.gaps.iter().map(within).sum()
}
