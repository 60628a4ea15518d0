//! Rest: a vehicle at rest has no velocity, and turns with the Earth.

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

/// One-sigma of the rate of a vehicle at rest over a second, rad/s, due to wind, hands and warming up.
const RATE_SIGMA_RADPS: f64 = 0.003;
/// One-sigma of the velocity of a vehicle at rest, m/s.
const VELOCITY_SIGMA_MPS: f64 = 0.1;

/// One-sigma of the change of a gyro bias when a vehicle starts to move, rad/s. The assumed one-sigma of the bias
/// applies if it is smaller. Vibration is rectified, and motors warm the inertial unit. The bias since power-on was
/// measured during the rest.
const SHAKEN_RADPS: f64 = 0.003;

const RATES: [Channel; 3] = [Channel::RestRateX, Channel::RestRateY, Channel::RestRateZ];
const VELOCITIES: [Channel; 3] =
    [Channel::RestVelocityNorth, Channel::RestVelocityEast, Channel::RestVelocityDown];

/// Change of gyro biases between rest and motion. Its variance is limited by the assumed variance of the biases and by
/// the effect of vibration. A rest after a motion may show a smaller variance.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct BiasShift {
    /// Variance, (rad/s)²; infinite before the first rest after a motion.
    learned: f32,
    /// Whether the vehicle has stayed at rest since the last update at rest; true before the first one.
    rests: bool,
}

impl BiasShift {
    /// State before the first rest.
    pub const UNKNOWN: Self = Self { learned: f32::INFINITY, rests: true };

    /// Variance to which the bias variances are raised when a rest ends, (rad/s)².
    fn variance(&self, assumed: f64) -> f64 {
        f64::from(self.learned).min(assumed).min(square(SHAKEN_RADPS))
    }

    /// Learns from the largest square of the bias errors found in a rest.
    fn learn(&mut self, found: f64) {
        let before = if self.learned.is_finite() { f64::from(self.learned) } else { found };
        self.learned = (before + NEWEST * (found - before)) as f32;
    }
}

/// Weight of the newest rest.
const NEWEST: f64 = 0.5;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Fuses zero velocity and the Earth's rate while the vehicle rests. Samples and fixes must have shown rest for two
    /// seconds. Call it after [`predict`](Self::predict); it acts once a second. `None` if the vehicle does not rest.
    ///
    /// # Source
    /// Equation (M11) of docs/equations.md.
    pub fn update_at_rest(&mut self, trace: &mut impl Trace<T, N>) -> Option<Report> {
        if self.samples.rest.moves_off() && self.config.mechanisms.rested_bias {
            let assumed = square(self.config.imu.gyro_bias_sigma_radps);
            self.open_gyro_bias(self.bias_shift.variance(assumed), trace);
            self.bias_shift.rests = false;
        }
        let rate =
            self.samples.resting_rate_radps.take().filter(|_| self.config.mechanisms.rest)?;
        self.relax(trace);
        let earth = Local::about(&self.state.position).earth_rate_radps;
        let off = (rate - self.state.body_to_ned.inverse() * earth).to_array();
        if !core::mem::replace(&mut self.bias_shift.rests, true) {
            let bias = self.block(GYRO_BIAS);
            let stepped = off.iter().zip(bias).map(|(&rate, bias)| square((rate - bias).wide()));
            self.bias_shift.learn(stepped.fold(0.0, f64::max));
        }
        let velocity = self.state.velocity_mps.to_array();
        // A vehicle may glide as smoothly as a vehicle at rest. So the noise of the zero velocity includes the mean
        // velocity of the fixes.
        let fixes_mps = self.samples.rest.fixes_mean_mps();
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
                innovation: off - self.estimate(GYRO_BIAS + axis),
                noise: T::of(square(RATE_SIGMA_RADPS)),
                sensitivity: Sensitivity::default().with(GYRO_BIAS + axis, T::ONE),
            });
            let (Some(slot), Some(&channel), Some(&velocity), Some(&fixes_mps)) = (
                velocities.get_mut(axis),
                VELOCITIES.get(axis),
                velocity.get(axis),
                fixes_mps.get(axis),
            ) else {
                continue;
            };
            *slot = Some(ScalarMeasurement {
                channel,
                group: Group::RestVelocity,
                innovation: -velocity,
                noise: T::of(square(VELOCITY_SIGMA_MPS) + square(f64::from(fixes_mps))),
                sensitivity: Sensitivity::default().with(VELOCITY + axis, T::ONE),
            });
        }
        let mut report = Report::default();
        self.update_sequentially(self.state.time, &axes, &mut report, trace);
        Some(report)
    }
}
