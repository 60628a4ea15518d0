//! The filter's output: the vehicle's motion and its one-sigma.
#![expect(
    clippy::indexing_slicing,
    reason = "axes count from 0 to 2 in arrays of three, rows from 0 to 8 in three such arrays"
)]

use crate::earth::Geodetic;
use crate::ekf::filter::Ekf;
use crate::ekf::kernel::layout::{ACCEL_BIAS, ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use crate::ekf::watch::OUTLIER_SIGMAS;
use crate::frames::{Body, EulerAngles, Ned, Rotation, Vector};
use crate::ins::LeverArm;
use crate::scalar::Scalar;
use crate::time::Time;

/// Position, velocity and attitude at one moment, with one-sigma and the removed biases.
///
/// Position and velocity are those of the configured point: the centre of gravity, or the inertial unit. One-sigmas
/// date from the last propagation of the covariance. For an inertial unit faster than 133 Hz that may be
/// `covariance_interval_s` ago.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<T = f64> {
    /// Time of the inertial sample at which the solution is valid.
    pub time: Time,
    /// Position of the solution's point.
    pub position: Geodetic,
    /// Velocity of the solution's point over ground, m/s.
    pub velocity_mps: Vector<Ned, T>,
    /// Attitude.
    pub body_to_ned: Rotation<Body, Ned, T>,
    /// Angular rate p, q, r of the body relative to the NED axes, rad/s, less bias.
    pub angular_rate_radps: Vector<Body, T>,
    /// Sum of the heading corrections made because the heading sensor was in error, rad. The vehicle did not turn by
    /// this angle: controllers that hold a heading shift their setpoint by it. 0 if unknown, and after smoothing.
    pub heading_revision_rad: T,
    /// One-sigma of position, m.
    pub position_sigma_m: Vector<Ned, T>,
    /// One-sigma of velocity, m/s.
    pub velocity_sigma_mps: Vector<Ned, T>,
    /// One-sigma of roll, pitch and yaw, rad.
    pub attitude_sigma_rad: [T; 3],
    /// Gyro bias removed, rad/s.
    pub gyro_bias_radps: Vector<Body, T>,
    /// Accelerometer bias removed, m/s².
    pub accel_bias_mps2: Vector<Body, T>,
    /// One-sigma of the gyro bias, rad/s.
    pub gyro_bias_sigma_radps: Vector<Body, T>,
    /// One-sigma of the accelerometer bias, m/s².
    pub accel_bias_sigma_mps2: Vector<Body, T>,
}

impl Solution {
    /// A solution at rest at `position`, level, heading north, without error or uncertainty. Struct update fills in
    /// other values.
    #[must_use]
    pub fn at_rest(time: Time, position: Geodetic) -> Self {
        Self {
            time,
            position,
            velocity_mps: Vector::ZERO,
            body_to_ned: Rotation::from_euler(EulerAngles::default()),
            angular_rate_radps: Vector::ZERO,
            heading_revision_rad: 0.0,
            position_sigma_m: Vector::ZERO,
            velocity_sigma_mps: Vector::ZERO,
            attitude_sigma_rad: [0.0; 3],
            gyro_bias_radps: Vector::ZERO,
            accel_bias_mps2: Vector::ZERO,
            gyro_bias_sigma_radps: Vector::ZERO,
            accel_bias_sigma_mps2: Vector::ZERO,
        }
    }
}

impl<T: Scalar> Solution<T> {
    /// Whether the speed exceeds `min_mps` plus three one-sigmas of the velocity.
    pub(in crate::ekf) fn moves(&self, min_mps: f64) -> bool {
        let [north, east, down] = self.velocity_sigma_mps.to_array();
        let still_mps = T::of(min_mps) + T::of(OUTLIER_SIGMAS) * north.max(east).max(down);
        !self.velocity_mps.is_shorter_than(still_mps)
    }

    /// Enlarges the one-sigma of position by further possible errors, horizontal and vertical, m.
    // Inlined: for most samples there is nothing to do, and the call would cost more than that.
    #[inline(always)]
    pub(in crate::ekf) fn widen(&mut self, [level_m, vertical_m]: [f32; 2]) {
        if level_m <= 0.0 && vertical_m <= 0.0 {
            return;
        }
        let [north, east, down] = self.position_sigma_m.to_array();
        let wider = |sigma: T, by_m: f32| Scalar::hypot(sigma, T::of(f64::from(by_m)));
        self.position_sigma_m =
            Vector::new(wider(north, level_m), wider(east, level_m), wider(down, vertical_m));
    }

    /// Velocity of the solution's point in body axes, u, v, w, m/s.
    #[must_use]
    pub fn velocity_body_mps(&self) -> Vector<Body, T> {
        self.body_to_ned.inverse() * self.velocity_mps
    }

    /// The same solution in another numeric type; time and position stay exact.
    #[must_use]
    pub fn cast<U: Scalar>(&self) -> Solution<U> {
        Solution {
            time: self.time,
            position: self.position,
            velocity_mps: self.velocity_mps.cast(),
            body_to_ned: self.body_to_ned.cast(),
            angular_rate_radps: self.angular_rate_radps.cast(),
            heading_revision_rad: U::of(self.heading_revision_rad.wide()),
            position_sigma_m: self.position_sigma_m.cast(),
            velocity_sigma_mps: self.velocity_sigma_mps.cast(),
            attitude_sigma_rad: self.attitude_sigma_rad.map(|sigma| U::of(sigma.wide())),
            gyro_bias_radps: self.gyro_bias_radps.cast(),
            accel_bias_mps2: self.accel_bias_mps2.cast(),
            gyro_bias_sigma_radps: self.gyro_bias_sigma_radps.cast(),
            accel_bias_sigma_mps2: self.accel_bias_sigma_mps2.cast(),
        }
    }
}

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Position, velocity, attitude and their one-sigma now, at the point of the solution.
    ///
    /// After a position that jumped was accepted without other evidence, the previous one may still be right. Then the
    /// one-sigma of position reaches back to it (equation K9), further than that of the covariance.
    #[must_use]
    pub fn solution(&self) -> Solution<T> {
        let mut solution = self.unambiguous_solution();
        solution.widen(self.ambiguity_m());
        solution
    }

    /// [`solution`](Self::solution), with the one-sigma of position from the covariance alone.
    pub(in crate::ekf) fn unambiguous_solution(&self) -> Solution<T> {
        let lever_arm = self.mounting.solution_from_imu().cast::<T>();
        let (state, errors) = (&self.state, self.imu_errors());
        let rate_radps = self.memory.angular_rate_radps;
        let [position, velocity, attitude] = self.solution_terms(&lever_arm);
        let [position, velocity, attitude] =
            [self.sigmas(&position), self.sigmas(&velocity), self.sigmas(&attitude)];
        Solution {
            time: state.time,
            position: lever_arm.position(&state.position, state.body_to_ned),
            velocity_mps: lever_arm.velocity(state.velocity_mps, state.body_to_ned, rate_radps),
            body_to_ned: state.body_to_ned,
            angular_rate_radps: rate_radps,
            heading_revision_rad: self.memory.heading_revision.total_rad,
            position_sigma_m: position.into(),
            velocity_sigma_mps: velocity.into(),
            attitude_sigma_rad: attitude.map(|sigma| sigma.min(T::of(core::f64::consts::PI))),
            gyro_bias_radps: errors.gyro_bias_radps,
            accel_bias_mps2: errors.accel_bias_mps2,
            gyro_bias_sigma_radps: self.sigma_block(GYRO_BIAS),
            accel_bias_sigma_mps2: self.sigma_block(ACCEL_BIAS),
        }
    }

    /// Covariance of the solution at its point: position north, east, down, m, velocity, m/s, then roll, pitch and yaw,
    /// rad. Its diagonal is the square of the solution's one-sigmas, with two exceptions. The one-sigmas of position
    /// also contain an ambiguity (equation K9), and the one-sigma of an undefined yaw is limited to π.
    ///
    /// # Source
    /// Equations (K11) and (K12) of docs/equations.md.
    #[must_use]
    pub fn solution_covariance(&self) -> [[T; 9]; 9] {
        let blocks = self.solution_terms(&self.mounting.solution_from_imu().cast());
        let terms = |row: usize| &blocks[row / 3][row % 3];
        core::array::from_fn(|row| {
            core::array::from_fn(|column| self.form(terms(row), terms(column)))
        })
    }

    /// Errors of position, velocity and roll, pitch and yaw at a point, as sums of the filter's states.
    #[inline(always)]
    fn solution_terms(&self, point: &LeverArm<T>) -> [[Terms<T>; 3]; 3] {
        let turned = |vector: Vector<Body, T>| (self.state.body_to_ned * vector).to_array();
        [
            point_terms(POSITION, turned(point.0)),
            point_terms(VELOCITY, turned(point.relative_velocity(self.memory.angular_rate_radps))),
            euler_terms(self.state.body_to_ned),
        ]
    }

    /// One-sigmas of three sums of errors. Each is written out: the compiler then knows the states of each sum.
    #[inline(always)]
    fn sigmas(&self, [x, y, z]: &[Terms<T>; 3]) -> [T; 3] {
        [self.form(x, x), self.form(y, y), self.form(z, z)].map(|square| square.max(T::ZERO).sqrt())
    }

    /// Covariance of two sums of errors.
    #[inline(always)]
    fn form(&self, first: &Terms<T>, second: &Terms<T>) -> T {
        let mut sum = T::ZERO;
        for &(i, a) in first {
            for &(j, b) in second {
                sum += a * b * self.covariance.value(i, j);
            }
        }
        sum
    }

    fn sigma_block(&self, first: usize) -> Vector<Body, T> {
        let sigma = |state| self.covariance.value(state, state).max(T::ZERO).sqrt();
        Vector::new(sigma(first), sigma(first + 1), sigma(first + 2))
    }
}

/// A sum of errors: states, and their factors.
type Terms<T> = [(usize, T); 3];

/// Errors of a point's position or velocity, whose states begin at `first`: δ(point) = δ(IMU) − [arm ×] ψ, with `arm`
/// in NED.
///
/// # Source
/// Equation (K11) of docs/equations.md.
#[inline(always)]
fn point_terms<T: Scalar>(first: usize, arm: [T; 3]) -> [Terms<T>; 3] {
    core::array::from_fn(|axis| {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        [(first + axis, T::ONE), (ATTITUDE + next, arm[last]), (ATTITUDE + last, -arm[next])]
    })
}

/// Errors of roll, pitch and yaw.
///
/// # Source
/// Equation (K12) of docs/equations.md.
#[inline(always)]
fn euler_terms<T: Scalar>(body_to_ned: Rotation<Body, Ned, T>) -> [Terms<T>; 3] {
    // Sines and cosines come from the direction of the forward axis.
    let [[north, ..], [east, ..], [down, ..]] = body_to_ned.rows();
    let level = (north * north + east * east).sqrt();
    // With the forward axis vertical, yaw is undefined; the limit bounds the effect of 1/cos on roll and yaw.
    let (sin_yaw, cos_yaw) =
        if level > T::of(1e-6) { (east / level, north / level) } else { (T::ZERO, T::ONE) };
    let cos_pitch = level.max(T::of(0.02));
    let tan_pitch = -down / cos_pitch;
    [
        [cos_yaw / cos_pitch, sin_yaw / cos_pitch, T::ZERO],
        [-sin_yaw, cos_yaw, T::ZERO],
        [cos_yaw * tan_pitch, sin_yaw * tan_pitch, T::ONE],
    ]
    .map(|[north, east, down]| [(ATTITUDE, north), (ATTITUDE + 1, east), (ATTITUDE + 2, down)])
}
