//! `--velocity`: set-points of velocity during the autopilot flight.

use std::str::FromStr;

use hovernav::autopilot::{Mode, SetPoint};
use hovernav_sim::{Flight, FlightConfig, FlightEvent};
use serde::Serialize;

use crate::arguments::{finite, second};

/// Start of the first set-point, s.
const FIRST_S: f64 = 30.0;
/// Time between set-points, s.
const APART_S: f64 = 30.0;
/// Time after a set-point from which on the velocity is judged, s. Within it an acceleration of 1 m/s² reaches 15 m/s,
/// the largest speed that guidance permits.
const REACHED_S: f64 = 15.0;

/// Set-point in the form `FORWARD[,RIGHT[,DOWN[,TURN]]][@SECOND]`, or `hold[@SECOND]`.
#[derive(Clone, Copy, Debug)]
pub struct TimedVelocity {
    set_point: SetPoint,
    at_s: Option<f64>,
}

impl FromStr for TimedVelocity {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "found \"{text}\", expected FORWARD[,RIGHT[,DOWN[,TURN]]][@SECOND] in m/s and °/s, or hold[@SECOND], \
                 with SECOND from 0 to a day"
            )
        };
        let (motion, at_s) = match text.split_once('@') {
            None => (text, None),
            Some((motion, at)) => (motion, Some(second(at).ok_or_else(expected)?)),
        };
        if motion == "hold" {
            return Ok(Self { set_point: SetPoint::Hold, at_s });
        }
        let numbers: Option<Vec<f64>> = motion.split(',').map(finite).collect();
        let numbers = numbers.filter(|numbers| numbers.len() <= 4).ok_or_else(expected)?;
        let number = |place: usize| numbers.get(place).copied().unwrap_or(0.0);
        let set_point = SetPoint::Velocity {
            forward_mps: number(0),
            right_mps: number(1),
            down_mps: number(2),
            yaw_rate_radps: number(3).to_radians(),
        };
        Ok(Self { set_point, at_s })
    }
}

/// The start time, s, of each of `velocities`, with its event.
pub fn events(velocities: &[TimedVelocity]) -> Vec<(f64, FlightEvent)> {
    let mut next_s = FIRST_S;
    let timed = velocities.iter().map(|velocity| {
        let at_s = velocity.at_s.unwrap_or(next_s);
        next_s = at_s + APART_S;
        (at_s, FlightEvent::SetPoint(velocity.set_point))
    });
    timed.collect()
}

/// Velocity of a flight while a set-point of velocity was active.
#[derive(Debug, Serialize)]
pub struct VelocitySummary {
    /// Time of the set-point, s.
    time_s: f64,
    /// Commanded velocity forward, to the right and down, m/s.
    wanted_mps: [f64; 3],
    /// Time at which the autopilot left the modes that hold velocity, and thus the set-point, s; `None` where it did not.
    lost_s: Option<f64>,
    /// Root mean square of the deviation from it, from 15 s after the set-point until the next one or until it was lost;
    /// `None` where that time is shorter.
    deviation_rms_mps: Option<[f64; 3]>,
}

impl VelocitySummary {
    /// The set-points of velocity of `config`, each with the deviation of `flight` from it.
    pub fn of(config: &FlightConfig, flight: &Flight) -> Vec<Self> {
        let set_points = config.events.iter().filter_map(|(at_s, event)| match event {
            FlightEvent::SetPoint(set_point) => Some((*at_s, *set_point)),
            _ => None,
        });
        let set_points: Vec<(f64, SetPoint)> = set_points.collect();
        let ends = set_points.iter().skip(1).map(|(at_s, _)| *at_s).chain([f64::INFINITY]);
        let each = set_points.iter().zip(ends);
        each.filter_map(|((time_s, set_point), end_s)| match *set_point {
            SetPoint::Velocity { forward_mps, right_mps, down_mps, .. } => {
                let wanted_mps = [forward_mps, right_mps, down_mps];
                let lost = flight.transitions.iter().find(|change| {
                    let at_s = change.time.seconds();
                    at_s > *time_s
                        && at_s < end_s
                        && !matches!(change.to, Mode::Position | Mode::Velocity)
                });
                let lost_s = lost.map(|change| change.time.seconds());
                let judged = time_s + REACHED_S..lost_s.unwrap_or(end_s);
                let deviation_rms_mps = flight.velocity_deviation_mps(judged, wanted_mps);
                Some(Self { time_s: *time_s, wanted_mps, lost_s, deviation_rms_mps })
            }
            _ => None,
        })
        .collect()
    }

    /// The deviation in one line.
    pub fn in_words(&self) -> String {
        let [forward, right, down] = self.wanted_mps;
        let found = self.deviation_rms_mps.map_or_else(
            || format!("no statistics: it ended within {REACHED_S:.0} s"),
            |[forward, right, down]| {
                format!("within {forward:.2}, {right:.2}, {down:.2} m/s RMS of it")
            },
        );
        let lost = self.lost_s.map_or_else(String::new, |at_s| {
            format!("; the autopilot left the set-point at {at_s:.0} s")
        });
        format!(
            "from {:.0} s on at {forward}, {right}, {down} m/s forward, right, down: {found}{lost}",
            self.time_s
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_velocity_is_read_and_anything_else_is_refused() {
        let read = |text: &str| text.parse::<TimedVelocity>().map(|own| (own.set_point, own.at_s));
        let velocity = |forward_mps, right_mps, down_mps, yaw_rate_radps| SetPoint::Velocity {
            forward_mps,
            right_mps,
            down_mps,
            yaw_rate_radps,
        };
        assert_eq!(read("5"), Ok((velocity(5.0, 0.0, 0.0, 0.0), None)));
        assert_eq!(read("-2,1.5@40"), Ok((velocity(-2.0, 1.5, 0.0, 0.0), Some(40.0))));
        let turning = velocity(3.0, 0.0, -0.5, 10f64.to_radians());
        assert_eq!(read("3,0,-0.5,10@0"), Ok((turning, Some(0.0))));
        assert_eq!(read("hold@60"), Ok((SetPoint::Hold, Some(60.0))));
        for text in ["", "@3", "5@", "5@-1", "nan", "1,2,3,4,5", "5,", "stop@3", "1e400"] {
            assert!(read(text).unwrap_err().contains("expected FORWARD"), "{text}");
        }
    }
}
