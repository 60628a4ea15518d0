//! The update by a user's own sensor.

use super::own::{Expected, Measurement, Row, Rows};
use super::update::ScalarMeasurement;
use crate::earth::LocalEarth;
use crate::ekf::filter::Ekf;
use crate::ekf::kernel::covariance::Sensitivity;
use crate::ekf::kernel::history::LookBack;
use crate::ekf::kernel::layout::{ACCEL_BIAS, ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::innovation::Channel;
use crate::ekf::outcome::report::{Report, Unusable};
use crate::frames::{Body, Ned, Vector};
use crate::ins::LeverArm;
use crate::matrix::{combined, square};
use crate::scalar::Scalar;
use crate::time::Time;

/// Largest time, s, by which a reading may be valid after the last inertial sample.
const AHEAD_S: f64 = 0.1;
/// Largest time, s, by which a reading may be valid before the last inertial sample.
const LATE_S: f64 = 0.5;
/// Longest lever arm, m.
const LONGEST_ARM_M: f64 = 1e3;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Fuses a reading of a user's own sensor. Its time of validity `time` is at most 0.5 s before and 0.1 s after the
    /// last inertial sample.
    ///
    /// All its rows are accepted or rejected together, within [`GateConfig::sigmas`](crate::ekf::GateConfig). A
    /// rejected reading changes nothing, however long the sensor is rejected: it never resets the filter.
    ///
    /// # Errors
    /// [`Unusable`] if the reading cannot be compared: [`NotFinite`](Unusable::NotFinite) for a row with impossible
    /// numbers, a lever arm beyond 1 km or more than six rows, [`OutOfRange`](Unusable::OutOfRange) without any row,
    /// and [`TooOld`](Unusable::TooOld) or [`AheadOfImu`](Unusable::AheadOfImu). A reading that is compared and
    /// rejected is no error.
    ///
    /// # Source
    /// Equation (M20) of docs/equations.md.
    // Not inlined, so that its stack frame is not part of a caller's that updates several sensors.
    #[inline(never)]
    pub fn update(
        &mut self,
        measurement: &(impl Measurement + ?Sized),
        time: Time,
        trace: &mut impl Trace<T, N>,
    ) -> Result<Report, Unusable> {
        if time - self.state.time > AHEAD_S {
            return Err(Unusable::AheadOfImu);
        }
        let earth = LocalEarth::about(&self.state.position);
        let back = self.history.look_back(&self.state, &earth, time, false);
        // Within a gap of the samples the motion since the reading is unknown.
        let is_known = |back: &LookBack<T>| back.age_s <= T::of(LATE_S) && back.hidden_s == T::ZERO;
        let back = back.filter(is_known).ok_or(Unusable::TooOld)?;
        let arm = LeverArm(measurement.lever_arm_m() - self.mounting.imu_lever_arm_m);
        if !(0.0..=LONGEST_ARM_M).contains(&arm.0.norm()) {
            return Err(Unusable::NotFinite);
        }
        let mut rows = Rows::default();
        measurement.compare(&back.expected(time, &arm), &mut rows);
        if rows.is_empty() {
            return Err(Unusable::OutOfRange);
        }
        if !rows.are_possible() {
            return Err(Unusable::NotFinite);
        }
        self.relax(trace);
        let mut axes = [None; 6];
        let channel = Channel::Own(measurement.sensor());
        for (axis, row) in axes.iter_mut().zip(rows.iter()) {
            let noise = T::of(square(row.sigma)) + self.aged_noise(row, &back);
            let sensitivity = self.own_sensitivity(row, &back, arm.0.cast());
            *axis = Some(ScalarMeasurement::new(channel, T::of(row.residual), noise, sensitivity));
        }
        Ok(self.update_axes(time, &axes, trace))
    }

    /// Variance that the inertial sensors' noise since the reading adds to its innovation.
    fn aged_noise(&self, row: &Row, back: &LookBack<T>) -> T {
        let (position, velocity) = (row.position.cast(), row.velocity.cast());
        self.lag_noise(back, back.age_s) * position.dot(position)
            + self.lag_noise(back, T::ONE) * velocity.dot(velocity)
    }

    /// Sensitivity of a row to the present states, for a sensor at `arm` from the inertial unit.
    ///
    /// # Source
    /// Equation (M20) of docs/equations.md.
    #[inline(never)]
    fn own_sensitivity(
        &self,
        row: &Row,
        back: &LookBack<T>,
        arm: Vector<Body, T>,
    ) -> Sensitivity<T> {
        let (position, velocity) = (row.position.cast::<T>(), row.velocity.cast::<T>());
        let body_to_ned = back.state.body_to_ned;
        let swing = body_to_ned * LeverArm(arm).relative_velocity(back.angular_rate_radps);
        let attitude =
            row.attitude.cast() + (body_to_ned * arm).cross(position) + swing.cross(velocity);
        let [force_m, force_mps] =
            [back.force_m, back.force_mps].map(|force| self.memory.level_force.of_motion(force));
        // The rows of the integral of the direction cosines, combined by a vector in NED.
        let turned = |by: Vector<Ned, T>| {
            Vector::<Body, T>::from(combined(by.to_array(), back.turn_s.each_ref()))
        };
        let gyro_bias = turned(attitude) - row.angular_rate.cast()
            + (body_to_ned.inverse() * velocity).cross(arm);
        let accel_bias = turned(velocity - position * (T::of(0.5) * back.age_s));
        let now = attitude + force_m.cross(position) + velocity.cross(force_mps);
        Sensitivity::default()
            .with_block(ATTITUDE, now.to_array())
            .with_block(VELOCITY, (velocity - position * back.age_s).to_array())
            .with_block(POSITION, position.to_array())
            .with_block(GYRO_BIAS, gyro_bias.to_array())
            .with_block(ACCEL_BIAS, accel_bias.to_array())
    }
}

impl<T: Scalar> LookBack<T> {
    /// Motion of a point at `arm` from the inertial unit, at the moment of this look-back.
    fn expected(&self, time: Time, arm: &LeverArm) -> Expected {
        let (body_to_ned, rate) = (self.state.body_to_ned.cast(), self.angular_rate_radps.cast());
        Expected {
            time,
            position: arm.position(&self.state.position, body_to_ned),
            velocity_mps: arm.velocity(self.state.velocity_mps.cast(), body_to_ned, rate),
            body_to_ned,
            angular_rate_radps: rate,
        }
    }
}
