//! Read access to a filter: its state, the estimated errors of the sensors, and its health.

use super::Ekf;
use crate::ekf::kernel::covariance::Covariance;
use crate::ekf::kernel::layout::{ACCEL_BIAS, GYRO_BIAS, Layout};
use crate::ekf::settings::config::EkfConfig;
use crate::imu::ImuErrors;
use crate::ins::NavState;
use crate::scalar::Scalar;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// The estimated errors of the inertial unit.
    #[must_use]
    pub fn imu_errors(&self) -> ImuErrors<T> {
        ImuErrors {
            gyro_bias_radps: self.block(GYRO_BIAS).into(),
            accel_bias_mps2: self.block(ACCEL_BIAS).into(),
        }
    }

    /// The estimates of three consecutive parameters.
    pub(in crate::ekf) fn block(&self, first: usize) -> [T; 3] {
        core::array::from_fn(|axis| self.estimate(first + axis))
    }

    pub(in crate::ekf) fn set_block(&mut self, first: usize, values: [T; 3]) {
        for (axis, value) in values.into_iter().enumerate() {
            if let Some(parameter) = self.parameters.get_mut(first + axis) {
                *parameter = value;
            }
        }
    }

    /// The estimate of one parameter: a bias, a latency. Zero for a state that is not a parameter or
    /// does not exist.
    #[must_use]
    pub fn parameter(&self, state: usize) -> f64 {
        self.estimate(state).wide()
    }

    /// [`parameter`](Self::parameter), in the filter's numeric type.
    pub(in crate::ekf) fn estimate(&self, state: usize) -> T {
        self.parameters.get(state).copied().unwrap_or(T::ZERO)
    }

    /// The state of the inertial unit.
    #[must_use]
    pub const fn state(&self) -> &NavState<T> {
        &self.state
    }

    /// Distances, horizontal and vertical, m, to a previous position that may still be right.
    ///
    /// # Source
    /// Equation (K9) of docs/equations.md.
    pub(in crate::ekf) fn ambiguity_m(&self) -> [f32; 2] {
        self.memory.gates.ambiguity_m()
    }

    /// The covariance of the error state, up to `covariance_interval_s` old. It does not include the ambiguity of a
    /// position: see [`solution`](Self::solution).
    #[must_use]
    pub const fn covariance(&self) -> &Covariance<T, N> {
        &self.covariance
    }

    /// Ratio of the variance of the inertial unit's noise to the assumed variance, 1 to 10. It is learned from
    /// successive innovations of the same sign. A large ratio may also come from a wrong axis or sign.
    #[must_use]
    pub fn noise_excess(&self) -> f64 {
        self.memory.excess.factor()
    }

    /// The settings.
    #[must_use]
    pub const fn config(&self) -> &EkfConfig {
        &self.config
    }

    /// Whether state and covariance are finite and in range. They stay so for any input that the filter accepts; a
    /// flight computer checks it nevertheless.
    #[must_use]
    pub fn is_healthy(&self) -> bool {
        self.state.is_valid() && self.covariance.is_valid()
    }
}
