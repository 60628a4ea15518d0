//! Rest: a vehicle at rest has no velocity, and turns with the Earth.
#![expect(clippy::indexing_slicing, reason = "axes count from 0 to 5, in arrays of six or three")]

use super::update::ScalarMeasurement;
use crate::earth::LocalEarth;
use crate::ekf::filter::Ekf;
use crate::ekf::kernel::covariance::Sensitivity;
use crate::ekf::kernel::layout::{GYRO_BIAS, Layout, VELOCITY};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::innovation::Channel;
use crate::ekf::outcome::report::Report;
use crate::matrix::square;
use crate::scalar::Scalar;

/// One-sigma of the rate of a vehicle at rest over a second, rad/s, due to wind, hands and warming up.
const RATE_SIGMA_RADPS: f64 = 0.003;
/// One-sigma of the velocity of a vehicle at rest, m/s.
const VELOCITY_SIGMA_MPS: f64 = 0.1;

const CHANNELS: [Channel; 6] = [
    Channel::RestRateX,
    Channel::RestRateY,
    Channel::RestRateZ,
    Channel::RestVelocityNorth,
    Channel::RestVelocityEast,
    Channel::RestVelocityDown,
];

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Fuses zero velocity and the Earth's rate while the vehicle rests. Samples and fixes must have shown rest for two
    /// seconds. Call it after [`predict`](Self::predict); it acts once a second. `None` if the vehicle does not rest.
    ///
    /// # Source
    /// Equation (M11) of docs/equations.md.
    pub fn update_at_rest(&mut self, trace: &mut impl Trace<T, N>) -> Option<Report> {
        if self.samples.rest.moves_off() && self.config.mechanisms.rested_bias {
            let assumed = square(self.config.imu.gyro_bias_sigma_radps);
            self.raise_gyro_bias_variance(self.memory.bias_shift.variance(assumed), trace);
            self.memory.bias_shift.rests = false;
        }
        let rate =
            self.samples.resting_rate_radps.take().filter(|_| self.config.mechanisms.rest)?;
        self.relax(trace);
        let earth = LocalEarth::about(&self.state.position).earth_rate_radps;
        let off = (rate - self.state.body_to_ned.inverse() * earth).to_array();
        if !core::mem::replace(&mut self.memory.bias_shift.rests, true) {
            let bias = self.block(GYRO_BIAS);
            let stepped = off.iter().zip(bias).map(|(&rate, bias)| square((rate - bias).wide()));
            self.memory.bias_shift.learn(stepped.fold(0.0, f64::max));
        }
        let velocity = self.state.velocity_mps.to_array();
        // A vehicle may glide as smoothly as a vehicle at rest. So the noise of the zero velocity includes the mean
        // velocity of the fixes.
        let fixes_mps = self.samples.rest.fixes_mean_mps();
        let axes = core::array::from_fn(|index| {
            let axis = index % 3;
            let (state, innovation, sigma_squared) = if index < 3 {
                let state = GYRO_BIAS + axis;
                (state, off[axis] - self.estimate(state), square(RATE_SIGMA_RADPS))
            } else {
                let fixes = square(f64::from(fixes_mps[axis]));
                (VELOCITY + axis, -velocity[axis], square(VELOCITY_SIGMA_MPS) + fixes)
            };
            let sensitivity = Sensitivity::default().with(state, T::ONE);
            let noise = T::of(sigma_squared);
            Some(ScalarMeasurement::new(CHANNELS[index], innovation, noise, sensitivity))
        });
        Some(self.update_axes(self.state.time, &axes, trace))
    }
}
