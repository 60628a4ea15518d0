//! Wheels: a vehicle that rolls on wheels moves only along its road, which serves as a measurement.

use super::update::ScalarMeasurement;
use crate::ekf::filter::Ekf;
use crate::ekf::kernel::covariance::Sensitivity;
use crate::ekf::kernel::layout::{ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::innovation::Channel;
use crate::ekf::outcome::report::Report;
use crate::ekf::watch::wheels::{SLOWEST_MPS, VelocityAcross, WheelWatch};
use crate::frames::{Body, Vector};
use crate::matrix::square;
use crate::scalar::{Scalar, single};

/// Possible velocity error, m/s, of a vehicle that left its road during the wheel constraint.
const OFF_ROAD_MPS: f64 = 2.0;

/// Velocity across the direction of travel of a vehicle on wheels.
struct Slip<T> {
    seen: VelocityAcross,
    /// Residual velocity across, m/s, and its variance, (m/s)², if the vehicle rolls on wheels.
    left_mps: T,
    variance: f32,
    sensitivity: Sensitivity<T>,
}

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Feeds the state after a fix to the monitor of `wheels`.
    #[inline(never)]
    pub(in crate::ekf) fn watch_wheels(&mut self, wheels: &mut WheelWatch) {
        let forward = self.state.body_to_ned.inverse() * self.state.velocity_mps;
        if single(forward.x()).abs() < SLOWEST_MPS {
            return;
        }
        let seen = [false, true].map(|is_down| {
            let Slip { mut seen, sensitivity, .. } = self.slip(wheels, is_down);
            seen.own_variance = single(self.covariance.project(&sensitivity).1);
            seen
        });
        let [.., [_, bank, _]] = self.state.body_to_ned.rows();
        wheels.observe_velocity(self.state.time, &seen, single(bank));
    }

    /// Applies the constraint of `wheels` while fixes are absent; call it after [`predict`](Self::predict). `None` if
    /// the constraint is not due, or if the motion is impossible on wheels.
    ///
    /// # Source
    /// Equation (M17) of docs/equations.md.
    pub(in crate::ekf) fn update_on_wheels(
        &mut self,
        wheels: &mut WheelWatch,
        trace: &mut impl Trace<T, N>,
    ) -> Option<Report> {
        let time = self.state.time;
        if !(self.memory.gates.lack_fixes(time) && wheels.is_due(time)) {
            return None;
        }
        self.relax(trace);
        let mut axes = [None; 6];
        let mut normalised = [0.0; 2];
        let channels = [(false, Channel::WheelsRight), (true, Channel::WheelsDown)];
        let slots = axes.iter_mut().zip(&mut normalised);
        for ((slot, size), (is_down, channel)) in slots.zip(channels) {
            let Slip { left_mps, variance, sensitivity, .. } = self.slip(wheels, is_down);
            let noise = T::of(variance.into());
            let own = self.covariance.project(&sensitivity).1;
            *size = single(-left_mps / (own + noise).sqrt());
            *slot = Some(ScalarMeasurement::new(channel, -left_mps, noise, sensitivity));
        }
        if wheels.is_violated(normalised, self.config.gate.sigmas as f32) {
            // The constraint of the last seconds was wrong.
            for axis in 0..3 {
                self.covariance.add_variance(VELOCITY + axis, square(OFF_ROAD_MPS));
            }
            self.reopen_tilt();
            trace.reset(ATTITUDE..POSITION);
            return None;
        }
        Some(self.update_axes(time, &axes, trace))
    }

    /// The velocity to the right or, if `is_down`, downwards, beyond that of the direction of travel.
    fn slip(&self, wheels: &WheelWatch, is_down: bool) -> Slip<T> {
        let velocity = self.state.body_to_ned.inverse() * self.state.velocity_mps;
        let [_, rate_y, rate_z] = self.memory.angular_rate_radps.to_array();
        let [force_x, force_y] = wheels.force_mps2();
        let (across_mps, rate, force_mps2, gyro, [right, down]) = if is_down {
            (velocity.z(), rate_y, force_x, GYRO_BIAS + 1, [T::ZERO, T::ONE])
        } else {
            (velocity.y(), rate_z, force_y, GYRO_BIAS + 2, [T::ONE, T::ZERO])
        };
        let seen = VelocityAcross {
            forward_mps: single(velocity.x()),
            rate_radps: single(rate),
            force_mps2,
            across_mps: single(across_mps),
            own_variance: 0.0,
        };
        let line = wheels.line(is_down, &seen);
        let (slope, arm_m) = (T::of(line.slope.into()), T::of(line.arm_m.into()));
        let square_to_line = Vector::<Body, T>::new(-slope, right, down);
        // δz = d · (δv + v × ψ) + arm δb_g, d the direction across in NED.
        let direction = self.state.body_to_ned * square_to_line;
        let mut sensitivity = Sensitivity::default();
        sensitivity.add_block(VELOCITY, direction.to_array());
        sensitivity.add_block(ATTITUDE, direction.cross(self.state.velocity_mps).to_array());
        sensitivity.add(gyro, arm_m);
        Slip {
            seen,
            left_mps: square_to_line.dot(velocity) - arm_m * rate,
            variance: line.variance,
            sensitivity,
        }
    }
}
