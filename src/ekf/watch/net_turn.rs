//! Recent net turn of the inertial unit about each axis, which scales the effect of gyro scale errors.

use crate::frames::{Body, Vector};
use crate::scalar::Scalar;

/// Net turn about each axis, with exponential decay, and its greatest square.
///
/// A scale factor error causes an attitude error proportional to the net turn, at any rate of turn. The error vanishes
/// when the vehicle turns back. Measurements correct the error over time, so the effect of an older turn decays.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct NetTurn<T> {
    pub(in crate::ekf) angle_rad: [T; 3],
    greatest: [T; 3],
}

impl<T: Scalar> NetTurn<T> {
    /// State before the first turn.
    pub const NONE: Self = Self { angle_rad: [T::ZERO; 3], greatest: [T::ZERO; 3] };

    /// Adds a rotation. Returns for each axis the growth of the squared net turn beyond its recent maximum, rad².
    ///
    /// # Source
    /// Equation (K21) of docs/equations.md.
    pub fn push(&mut self, rotation_rad: Vector<Body, T>, interval_s: T, memory_s: T) -> [T; 3] {
        let left = (T::ONE - interval_s / memory_s).max(T::ZERO);
        let mut grown = [T::ZERO; 3];
        let axes = self.angle_rad.iter_mut().zip(&mut self.greatest).zip(&mut grown);
        for (((angle, greatest), grown), turn) in axes.zip(rotation_rad.to_array()) {
            *angle = *angle * left + turn;
            *greatest = *greatest * left * left;
            let square = *angle * *angle;
            if square > *greatest {
                *grown = square - *greatest;
                *greatest = square;
            }
        }
        grown
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::earth::Geodetic;
    use crate::ekf::BaseEkf;
    use crate::ekf::settings::config::EkfConfig;
    use crate::frames::Rotation;
    use crate::imu::{ImuSample, Motion};
    use crate::ins::{Mounting, NavState, Start};
    use crate::time::Time;

    const STEP_S: f64 = 0.02;

    /// Sum of the growth of the squared net turn, rad², over successive turns by these angles about the down axis.
    fn grown(turns_rad: &[f64], memory_s: f64) -> f64 {
        let mut net_turn = NetTurn::<f64>::NONE;
        let mut push = |turn: &f64| {
            let [_, _, grown] = net_turn.push(Vector::new(0.0, 0.0, *turn), STEP_S, memory_s);
            grown
        };
        turns_rad.iter().map(&mut push).sum()
    }

    #[test]
    fn a_turn_counts_by_its_angle_however_fast_and_not_again_when_turned_back() {
        const FOREVER_S: f64 = 1e9;
        for steps in [10, 100, 1000] {
            let step_rad = 2.0 / f64::from(steps);
            let mut turns = vec![step_rad; steps as usize];
            assert!((grown(&turns, FOREVER_S) - 4.0).abs() < 1e-6);
            turns.extend(vec![-step_rad; steps as usize]);
            turns.extend(vec![step_rad; steps as usize]);
            assert!((grown(&turns, FOREVER_S) - 4.0).abs() < 1e-6);
        }
    }

    #[test]
    fn vibration_adds_little_to_a_turn_and_a_later_turn_counts_anew() {
        let still = vec![0.0; 20_000];
        let turn = vec![0.01; 200];
        let again = [&turn[..], &still, &turn].concat();
        assert!((grown(&again, 30.0) - 8.0).abs() < 0.4);
        let shaken: Vec<f64> = again
            .iter()
            .enumerate()
            .map(|(k, turn)| turn + if k % 2 == 0 { 0.01 } else { -0.01 })
            .collect();
        assert!((grown(&shaken, 30.0) / grown(&again, 30.0) - 1.0).abs() < 0.05);
    }

    #[test]
    fn a_slow_full_turn_makes_the_heading_less_sure_by_its_share() {
        let place = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
        let sure = Vector::new(1e-3, 1e-3, 1e-3);
        let heading_sigma_rad = |share: f64| {
            let mut config = EkfConfig::default();
            config.imu.net_turn_error_share = share;
            config.imu.gyro_bias_sigma_radps = 1e-5;
            let start = Start {
                state: NavState {
                    time: Time::ZERO,
                    position: place,
                    velocity_mps: Vector::ZERO,
                    body_to_ned: Rotation::IDENTITY,
                },
                attitude_sigma_rad: sure,
                velocity_sigma_mps: Vector::new(0.1, 0.1, 0.1),
                position_sigma_m: Vector::new(1.0, 1.0, 1.0),
                gyro_bias_radps: Vector::ZERO,
                gyro_bias_sigma_radps: None,
            };
            let mut filter = BaseEkf::new(config, Mounting::default(), start);
            for k in 1..=900 {
                let motion = Motion::Rates {
                    angular_rate_radps: Vector::new(0.0, 0.0, core::f64::consts::TAU / 18.0),
                    specific_force_mps2: Vector::new(0.0, 0.0, -9.81),
                };
                let time = Time::from_nanoseconds(k * 20_000_000);
                filter.predict(&ImuSample::new(time, motion)).unwrap();
            }
            filter.solution().attitude_sigma_rad[2]
        };
        let (without, with) = (heading_sigma_rad(0.0), heading_sigma_rad(0.003));
        let added_rad = (with * with - without * without).sqrt();
        // Part of the turn decays within its 18 s.
        assert!(
            (added_rad / (0.003 * core::f64::consts::TAU) - 0.9).abs() < 0.05,
            "{added_rad} rad"
        );
    }
}
