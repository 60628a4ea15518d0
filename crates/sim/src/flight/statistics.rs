//! Statistics of a flight.

use std::ops::Range;

use super::record::{Flight, FlightSample};
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, wrap_angle};
use hovernav_dataset::Truth;

/// Quality of a hover from a given sample on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HoverStatistics {
    /// Root mean square of u, v, w, m/s.
    pub velocity_rms_mps: [f64; 3],
    /// Root mean square of roll and pitch about their means, °.
    pub attitude_rms_deg: [f64; 2],
    /// Largest deviation from the initial heading, °.
    pub heading_worst_deg: f64,
    /// Root mean square of the deviation from the initial position, north, east, down, m.
    pub position_rms_m: [f64; 3],
    /// Root mean square of the estimator's error of north, east and down velocity, m/s; NaN if any sample has no
    /// solution.
    pub velocity_error_rms_mps: [f64; 3],
    /// Root mean square of the estimator's error of roll, pitch and heading, °; NaN if any sample has no solution.
    pub attitude_error_rms_deg: [f64; 3],
    /// Root mean square of the commands about their means.
    pub sticks_rms: [f64; 4],
    /// Means of the commands: the sticks at which this vehicle is in trim.
    pub sticks_mean: [f64; 4],
}

/// Extremes of a part of a flight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Excursion {
    /// Steepest tilt, √(roll² + pitch²), rad.
    pub tilt_rad: f64,
    /// Fastest motion over the ground, m/s.
    pub speed_mps: f64,
}

impl Flight {
    /// Extremes during `duration_s` from `from_s` on; zero where the flight ended before.
    #[must_use]
    pub fn excursion(&self, from_s: f64, duration_s: f64) -> Excursion {
        let truths = self.samples.iter().map(|sample| sample.truth);
        let within =
            truths.filter(|truth| (0.0..duration_s).contains(&(truth.time.seconds() - from_s)));
        within.fold(Excursion::default(), |worst, truth| {
            let [roll, pitch, _] = angles(&truth.body_to_ned);
            Excursion {
                tilt_rad: worst.tilt_rad.max(roll.hypot(pitch)),
                speed_mps: worst.speed_mps.max(truth.velocity_mps.norm()),
            }
        })
    }

    /// As [`velocity_deviation_mps`], at the times of `span_s`.
    #[must_use]
    pub fn velocity_deviation_mps(
        &self,
        span_s: Range<f64>,
        wanted_mps: [f64; 3],
    ) -> Option<[f64; 3]> {
        velocity_deviation_mps(self.samples.iter().map(|sample| sample.truth), span_s, wanted_mps)
    }

    /// Quality of the hover from `from_s` on, relative to the vehicle's state at that time; all zero where the flight
    /// ended before.
    #[must_use]
    pub fn statistics(&self, from_s: f64) -> HoverStatistics {
        let held = self.samples.partition_point(|sample| sample.truth.time.seconds() < from_s);
        let held = self.samples.get(held..).unwrap_or_default();
        let Some(first) = held.first().map(|sample| sample.truth) else {
            return HoverStatistics::default();
        };
        let [_, _, heading] = angles(&first.body_to_ned);
        let rms = |value: &dyn Fn(&FlightSample) -> f64| {
            let squares: f64 = held.iter().map(|sample| value(sample).powi(2)).sum();
            (squares / held.len() as f64).sqrt()
        };
        let spread = |value: &dyn Fn(&FlightSample) -> f64| {
            let mean = held.iter().map(value).sum::<f64>() / held.len() as f64;
            rms(&|sample| value(sample) - mean)
        };
        let axes = [0, 1, 2];
        HoverStatistics {
            velocity_rms_mps: axes.map(|axis| {
                rms(&|sample| {
                    let truth = &sample.truth;
                    (truth.body_to_ned.inverse() * truth.velocity_mps).to_array()[axis]
                })
            }),
            attitude_rms_deg: [
                spread(&|sample| angles(&sample.truth.body_to_ned)[0].to_degrees()),
                spread(&|sample| angles(&sample.truth.body_to_ned)[1].to_degrees()),
            ],
            heading_worst_deg: held
                .iter()
                .map(|sample| {
                    let [_, _, yaw] = angles(&sample.truth.body_to_ned);
                    wrap_angle(yaw - heading).abs().to_degrees()
                })
                .fold(0.0, f64::max),
            position_rms_m: axes.map(|axis| {
                rms(&|sample| {
                    sample.truth.position.displacement_from(&first.position).to_array()[axis]
                })
            }),
            velocity_error_rms_mps: axes.map(|axis| {
                rms(&|sample| {
                    sample.solution.map_or(f64::NAN, |solution| {
                        (solution.velocity_mps - sample.truth.velocity_mps).to_array()[axis]
                    })
                })
            }),
            attitude_error_rms_deg: axes.map(|axis| {
                rms(&|sample| {
                    sample.solution.map_or(f64::NAN, |solution| {
                        let found = angles(&solution.body_to_ned)[axis];
                        wrap_angle(found - angles(&sample.truth.body_to_ned)[axis]).to_degrees()
                    })
                })
            }),
            sticks_rms: [0, 1, 2, 3].map(|stick| spread(&|m| m.sticks.to_array()[stick])),
            sticks_mean: [0, 1, 2, 3].map(|stick| {
                held.iter().map(|m| m.sticks.to_array()[stick]).sum::<f64>() / held.len() as f64
            }),
        }
    }
}

/// Root mean square deviation of the velocity of `truths` from `wanted_mps`, m/s, at the times of `span_s`. Axes:
/// forward, right and down with a level horizon. `None` without a sample in this time.
#[must_use]
pub fn velocity_deviation_mps(
    truths: impl Iterator<Item = Truth>,
    span_s: Range<f64>,
    wanted_mps: [f64; 3],
) -> Option<[f64; 3]> {
    let (mut squares, mut count) = ([0.0; 3], 0.0);
    for truth in truths.filter(|truth| span_s.contains(&truth.time.seconds())) {
        let (sin, cos) = truth.body_to_ned.heading_sincos();
        let [north, east, down] = truth.velocity_mps.to_array();
        let level = [cos * north + sin * east, cos * east - sin * north, down];
        for ((square, level), wanted) in squares.iter_mut().zip(level).zip(wanted_mps) {
            *square += (level - wanted).powi(2);
        }
        count += 1.0;
    }
    (count > 0.0).then(|| squares.map(|square| (square / count).sqrt()))
}

/// Roll, pitch and yaw, rad.
fn angles(body_to_ned: &Rotation<Body, Ned>) -> [f64; 3] {
    let EulerAngles { roll_rad, pitch_rad, yaw_rad } = body_to_ned.euler();
    [roll_rad, pitch_rad, yaw_rad]
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::autopilot::Mode;
    use hovernav::controls::Sticks;
    use hovernav::earth::Geodetic;
    use hovernav::frames::Vector;
    use hovernav::time::Time;
    use hovernav_dataset::{Manifest, Truth};

    #[test]
    fn an_excursion_is_the_worst_of_its_own_stretch() {
        let sample = |second: f64, roll_rad: f64, pitch_rad: f64, speed_mps: f64| FlightSample {
            truth: Truth {
                time: Time::ZERO + second,
                position: Geodetic::from_degrees(1.0, 103.0, 30.0).unwrap(),
                velocity_mps: Vector::new(speed_mps, 0.0, 0.0),
                body_to_ned: Rotation::from_euler(EulerAngles {
                    roll_rad,
                    pitch_rad,
                    yaw_rad: 1.0,
                }),
                angular_rate_radps: Vector::ZERO,
            },
            solution: None,
            mode: Mode::Manual,
            sticks: Sticks::NEUTRAL,
            injected: Sticks::NEUTRAL,
            servos: Sticks::NEUTRAL,
            wind_mps: Vector::ZERO,
        };
        let flight = Flight {
            manifest: Manifest::default(),
            imu: Vec::new(),
            fixes: Vec::new(),
            baro: Vec::new(),
            ranges: Vec::new(),
            headings: Vec::new(),
            samples: vec![
                sample(9.0, 0.9, 0.0, 9.0),
                sample(10.0, 0.03, 0.04, 1.0),
                sample(11.0, 0.0, 0.01, 2.0),
                sample(12.0, 0.9, 0.0, 9.0),
            ],
            transitions: Vec::new(),
            aborted: Vec::new(),
            crashed_s: None,
            crash: None,
        };
        let worst = flight.excursion(10.0, 2.0);
        assert!((worst.tilt_rad - 0.05).abs() < 1e-12 && worst.speed_mps == 2.0, "{worst:?}");
        assert_eq!(flight.excursion(20.0, 5.0), Excursion::default());
    }
}
