//! Rest: what does not move has no velocity, and turns with the Earth.

use super::super::covariance::Sensitivity;
use super::super::filter::Ekf;
use super::super::gate::Group;
use super::super::innovation::Channel;
use super::super::layout::{GYRO_BIAS, Layout, VELOCITY};
use super::super::scalar::Scalar;
use super::super::square;
use super::super::trace::Trace;
use super::{Report, ScalarMeasurement};
use crate::earth::Local;

/// One-sigma of the rate of a vehicle at rest over a second, rad/s: wind, hands, warming up.
const RATE_SIGMA_RADPS: f64 = 0.003;
/// One-sigma of its velocity, m/s.
const VELOCITY_SIGMA_MPS: f64 = 0.05;

const RATES: [Channel; 3] = [Channel::RestRateX, Channel::RestRateY, Channel::RestRateZ];
const VELOCITIES: [Channel; 3] =
    [Channel::RestVelocityNorth, Channel::RestVelocityEast, Channel::RestVelocityDown];

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Takes in that the vehicle rests, where the samples up to the last and the fixes have said so for two
    /// seconds; once a second, and after [`predict`](Self::predict). `None` where it does not rest.
    ///
    /// # Source
    /// Equation (M11) of docs/equations.md.
    pub fn update_at_rest(&mut self, trace: &mut impl Trace<T, N>) -> Option<Report> {
        let rate = self.samples.resting_rate_radps.take()?;
        self.relax(trace);
        let earth = Local::at(&self.state.position).earth_rate_radps;
        let off = (rate - self.state.body_to_ned.inverse() * earth).to_array();
        let velocity = self.state.velocity_mps.to_array();
        let mut axes = [const { None }; 6];
        let (rates, velocities) = axes.split_at_mut(3);
        for axis in 0..3 {
            let (Some(slot), Some(&channel), Some(&off)) =
                (rates.get_mut(axis), RATES.get(axis), off.get(axis))
            else {
                continue;
            };
            *slot = Some(ScalarMeasurement {
                channel,
                group: Group::RestRate,
                innovation: off - self.parameter(GYRO_BIAS + axis),
                noise: square(RATE_SIGMA_RADPS),
                sensitivity: Sensitivity::default().with(GYRO_BIAS + axis, 1.0),
            });
            let (Some(slot), Some(&channel), Some(&velocity)) =
                (velocities.get_mut(axis), VELOCITIES.get(axis), velocity.get(axis))
            else {
                continue;
            };
            *slot = Some(ScalarMeasurement {
                channel,
                group: Group::RestVelocity,
                innovation: -velocity,
                noise: square(VELOCITY_SIGMA_MPS),
                sensitivity: Sensitivity::default().with(VELOCITY + axis, 1.0),
            });
        }
        Some(self.update_sequentially(self.state.time, &axes, trace))
    }
}
