//! Conversion of inertial samples of any form to mean rates.

use crate::limits::vibration_mps;
use hovernav::imu::{ImuAxes, ImuSample, Motion};
use hovernav::time::Time;

/// Axes of the inertial unit, in the order of [`Rates::six`].
pub(crate) const AXES: [&str; 6] =
    ["gyro x", "gyro y", "gyro z", "accelerometer x", "accelerometer y", "accelerometer z"];

/// A sample as mean rates since the previous one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rates {
    pub time: Time,
    /// Time since the previous sample, s; zero for the first.
    pub interval_s: f64,
    /// Angular rate, rad/s.
    pub turn_radps: [f64; 3],
    /// Specific force, m/s².
    pub force_mps2: [f64; 3],
    /// The inertial unit's own full-scale marks.
    pub clipped: ImuAxes,
}

impl Rates {
    /// Angular rate, rad/s, and specific force, m/s², in the order of [`AXES`].
    pub fn six(&self) -> [f64; 6] {
        let ([p, q, r], [x, y, z]) = (self.turn_radps, self.force_mps2);
        [p, q, r, x, y, z]
    }
}

/// Each sample with its angular rate and specific force. Increments are divided by their interval. The first increment
/// has no rates, because its interval is unknown.
pub(crate) fn with_rates(
    samples: impl IntoIterator<Item = ImuSample>,
) -> impl Iterator<Item = (ImuSample, Option<Rates>)> {
    let mut before: Option<Time> = None;
    samples.into_iter().map(move |sample| {
        let interval_s = before.replace(sample.time).map(|before| sample.time - before);
        // The interval of the first increment is unknown.
        let is_known = interval_s.is_some() || matches!(sample.motion, Motion::Rates { .. });
        let interval_s = interval_s.unwrap_or_default();
        let rates = is_known.then(|| {
            let mean = sample.motion.mean_rates(interval_s);
            Rates {
                time: sample.time,
                interval_s,
                turn_radps: mean.angular_rate_radps.to_array(),
                force_mps2: mean.specific_force_mps2.to_array(),
                clipped: sample.clipped,
            }
        });
        (sample, rates)
    })
}

/// Vibration between samples: second differences, in which slow motion cancels.
#[derive(Clone, Debug, Default)]
pub(crate) struct Vibration {
    before: [Option<[f64; 6]>; 2],
    squares: [f64; 6],
    count: usize,
}

impl Vibration {
    /// Adds the sample after the previous one.
    pub fn push(&mut self, at: &Rates) {
        let now = at.six();
        if let [Some(first), Some(second)] = self.before {
            for (axis, squares) in self.squares.iter_mut().enumerate() {
                let bend = first[axis] - 2.0 * second[axis] + now[axis];
                *squares += bend * bend;
            }
            self.count += 1;
        }
        self.before = [self.before[1], Some(now)];
    }

    /// Root mean square of the second differences over √6, per component: the standard deviation of white noise.
    /// `None` for fewer than three samples.
    pub fn rms(&self) -> Option<[f64; 6]> {
        let count = (self.count > 0).then_some(self.count as f64)?;
        Some(self.squares.map(|squares| (squares / (6.0 * count)).sqrt()))
    }

    /// Velocity error, m/s after a second, from the vibration of one accelerometer, by its index among the axes.
    pub fn velocity_error_mps(&self, axis: usize, interval_s: f64) -> f64 {
        vibration_mps(self.squares[axis], self.count as f64, interval_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use hovernav::frames::Vector;

    /// Reproducible pseudo-random numbers, uniform, of unit variance.
    fn noise() -> impl Iterator<Item = f64> {
        let mut state = 1u64;
        std::iter::repeat_with(move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            ((state >> 11) as f64 / (1u64 << 53) as f64 - 0.5) * 12f64.sqrt()
        })
    }

    #[test]
    fn vibration_is_noise_and_not_motion() {
        let of = |count: usize, value: &dyn Fn(f64, f64) -> f64| {
            let mut vibration = Vibration::default();
            for (index, noise) in noise().take(count).enumerate() {
                let value = value(index as f64 * 0.01, noise);
                vibration.push(&Rates {
                    time: Time::ZERO,
                    interval_s: 0.01,
                    turn_radps: [value; 3],
                    force_mps2: [value; 3],
                    clipped: ImuAxes::NONE,
                });
            }
            vibration.rms().map(|rms| rms[0])
        };
        assert_abs_diff_eq!(of(20_000, &|_, noise| 0.3 * noise).unwrap(), 0.3, epsilon = 0.01);
        assert!(of(20_000, &|time_s, _| 5.0 * (0.5 * time_s).sin()).unwrap() < 1e-3);
        assert_eq!(of(2, &|_, _| 0.0), None);
    }

    #[test]
    fn increments_are_divided_by_their_interval() {
        let samples = (0..3).map(|index| {
            let motion = Motion::Increments {
                angle_rad: Vector::new(0.001, 0.0, 0.0),
                velocity_mps: Vector::new(0.0, 0.0, -0.0981),
            };
            ImuSample::new(Time::from_nanoseconds(index * 10_000_000), motion)
        });
        let rates: Vec<Rates> = with_rates(samples).filter_map(|(_, rates)| rates).collect();
        assert_eq!(rates.len(), 2);
        assert_abs_diff_eq!(rates[0].turn_radps[0], 0.1, epsilon = 1e-12);
        assert_abs_diff_eq!(rates[0].force_mps2[2], -9.81, epsilon = 1e-12);
    }
}
