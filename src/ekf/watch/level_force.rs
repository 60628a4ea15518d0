//! Fraction of the horizontal specific force that is motion and makes the heading observable.

use crate::frames::{Ned, Vector};
use crate::scalar::Scalar;

/// Averaging time of the horizontal specific force, s.
pub(in crate::ekf) const AVERAGED_S: f64 = 1.0;
/// Smallest squared mean force that counts as motion, in multiples of the variance of its error.
const VARIANCES: f64 = 2.0;

/// Recent mean of the horizontal specific force, and the fraction of it that is motion.
///
/// A heading error rotates every measured change of velocity. It also rotates noise, and the gravity component from an
/// unknown tilt, but fixes cannot observe that rotation. If both counted as motion, the filter's heading would become
/// more certain every second in a calm hover, without any information.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct LevelForce<T> {
    mean_mps2: [T; 2],
    /// Variance of the mean's error, both axes together, (m/s²)².
    pub variance: T,
    share: T,
}

impl<T: Scalar> LevelForce<T> {
    /// State before the first sample: the whole force counts as motion.
    pub const NONE: Self = Self { mean_mps2: [T::ZERO; 2], variance: T::ZERO, share: T::ONE };

    /// Feeds the velocity change by specific force over a sample interval, NED, m/s.
    pub fn push(&mut self, force_mps: Vector<Ned, T>, interval_s: T) {
        let averaged_s = T::of(AVERAGED_S);
        let left = (T::ONE - interval_s / averaged_s).max(T::ZERO);
        let [north, east, _] = force_mps.to_array();
        let north = self.mean_mps2[0] * left + north / averaged_s;
        let east = self.mean_mps2[1] * left + east / averaged_s;
        self.mean_mps2 = [north, east];
        let squared = north * north + east * east;
        let unsure = T::of(VARIANCES) * self.variance;
        // The comparison also maps NaN to zero.
        self.share = if squared > unsure { T::ONE - unsure / squared } else { T::ZERO };
    }

    /// Change of velocity or position by specific force, `force`, reduced horizontally to the fraction that makes the
    /// heading observable.
    ///
    /// # Source
    /// Equation (K23) of docs/equations.md.
    pub fn of_motion(&self, force: Vector<Ned, T>) -> Vector<Ned, T> {
        let [north, east, down] = force.to_array();
        Vector::new(north * self.share, east * self.share, down)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::earth::Geodetic;
    use crate::ekf::BaseEkf;
    use crate::ekf::settings::config::EkfConfig;
    use crate::frames::{Body, Rotation};
    use crate::gps::Fix;
    use crate::imu::{ImuSample, Motion};
    use crate::ins::{Mounting, NavState, Start};
    use crate::matrix::square;
    use crate::time::Time;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng as _;
    use rand_distr::{Distribution as _, StandardNormal};

    const GYRO_BIAS_SIGMA_RADPS: f64 = 0.0015;
    const FORCE_SIGMA_MPS2: f64 = 0.4;
    const STEP_S: f64 = 0.02;

    /// Heading error and its one-sigma, rad, after a motionless hover of 240 s, with all errors drawn from the filter's
    /// assumptions.
    fn hovered(seed: u64) -> [f64; 2] {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        let mut vector = |sigma: f64| {
            let mut drawn = || {
                let normal: f64 = StandardNormal.sample(&mut generator);
                sigma * normal
            };
            [drawn(), drawn(), drawn()]
        };
        let mut config = EkfConfig::default();
        config.imu.gyro_bias_sigma_radps = GYRO_BIAS_SIGMA_RADPS;
        config.imu.gyro_bias_time_s = 1e6;
        config.imu.velocity_random_walk_mps = FORCE_SIGMA_MPS2 * STEP_S.sqrt();
        config.imu.accel_vibration_share = 0.0;
        config.imu.gyro_vibration_share = 0.0;
        let place = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
        let sure = Vector::new(0.01, 0.01, 0.02);
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
        let off = Vector::<Ned>::from(vector(0.01));
        let heading = Vector::new(0.0, 0.0, 2.0 * off.z());
        let off = Vector::new(off.x(), off.y(), 0.0);
        let truth = Rotation::IDENTITY.turned_in_to(off + heading);
        let down = truth.inverse() * Vector::new(0.0, 0.0, -9.807);
        let bias = Vector::<Body>::from(vector(GYRO_BIAS_SIGMA_RADPS));
        let mut filter = BaseEkf::new(config, Mounting::default(), start);
        for k in 1..=12_000_i64 {
            let time = Time::from_nanoseconds(k * 20_000_000);
            let motion = Motion::Rates {
                angular_rate_radps: bias,
                specific_force_mps2: down + Vector::from(vector(FORCE_SIGMA_MPS2)),
            };
            filter.predict(&ImuSample::new(time, motion)).unwrap();
            if k % 10 == 0 {
                let [north, east, fall] = vector(0.1);
                let place = place.displaced(Vector::from(vector(1.0)));
                let fix = Fix {
                    horizontal_velocity_mps: Some([north, east]),
                    down_velocity_mps: Some(fall),
                    ..Fix::at(time, place)
                };
                filter.update_gps(&fix).unwrap();
            }
        }
        let solution = filter.solution();
        let error_rad = solution.body_to_ned.euler().yaw_rad - truth.euler().yaw_rad;
        [error_rad, solution.attitude_sigma_rad[2]]
    }

    /// Forty hovers: the heading drifts with the yaw gyro's bias, and the filter's one-sigma covers it.
    #[test]
    fn a_calm_hover_tells_no_heading() {
        let squares: f64 = (1..=40).map(hovered).map(|[error, sigma]| square(error / sigma)).sum();
        let normalised = (squares / 40.0).sqrt();
        let [error, sigma] = hovered(1);
        println!("{normalised:.2} of its one-sigma, {error:.3} and {sigma:.3} rad in the first");
        assert!((0.6..1.4).contains(&normalised), "{normalised}");
    }

    /// Force beyond its own error counts almost fully and at once as motion.
    #[test]
    fn a_manoeuvre_is_motion_within_a_tenth_of_a_second() {
        let mut force = LevelForce::<f64> { variance: 0.002, ..LevelForce::NONE };
        for _ in 0..5 {
            force.push(Vector::new(0.06, 0.0, -0.196), STEP_S);
        }
        assert!(force.of_motion(Vector::new(1.0, 1.0, 1.0)).x() > 0.95);
        force.push(Vector::new(f64::NAN, 0.0, 0.0), STEP_S);
        assert!(force.of_motion(Vector::new(1.0, 1.0, 1.0)) == Vector::new(0.0, 0.0, 1.0));
    }
}
