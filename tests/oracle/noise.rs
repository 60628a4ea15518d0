//! Process noise: of the inertial sensors (K4, K13, K21) and of the parameters (K5, K24).

use hovernav::ekf::layout::{ACCEL_BIAS, ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use hovernav::ekf::{EkfConfig, Learned};
use nalgebra::{Matrix3, SVector};

use crate::mechanization::{Increment, Vector};
use crate::transition::{Matrix, Sums, set};

/// Net turn about each gyro's axis, rad, and its greatest square, both decaying (K21).
#[derive(Clone, Copy, Debug)]
pub struct NetTurn {
    angle_rad: Vector,
    greatest: Vector,
}

impl NetTurn {
    pub const NONE: Self =
        Self { angle_rad: Vector::new(0.0, 0.0, 0.0), greatest: Vector::new(0.0, 0.0, 0.0) };

    /// Growth of the squares beyond their recent maximum.
    fn push(&mut self, step: &Increment, memory_s: f64) -> Vector {
        let left = (1.0 - step.seconds / memory_s).max(0.0);
        self.angle_rad = self.angle_rad * left + step.rotation_rad;
        let faded = self.greatest * (left * left);
        let squares = self.angle_rad.component_mul(&self.angle_rad);
        self.greatest = faded.sup(&squares);
        self.greatest - faded
    }
}

/// Variance that a sensor of random walk `walk` adds per axis and second. A fraction `share` of its vibration counts as
/// noise correlated over `alike_s`.
pub fn density(walk: f64, share: f64, alike_s: f64, vibration: &[f64; 3]) -> Vector {
    Vector::from(vibration.map(|variance| (share * share * variance * alike_s).max(walk * walk)))
}

/// Variances that one step adds to rotation and velocity change about each body axis (K4). `rate_radps` is the angular
/// rate at the previous sample.
pub fn of_sensors(
    config: &EkfConfig,
    learned: &Learned,
    step: &Increment,
    rate_radps: &Vector,
    net_turn: &mut NetTurn,
) -> [Vector; 2] {
    let imu = &config.imu;
    let [gyro_vibration, accel_vibration] = &learned.vibration;
    let over_s = learned.excess * step.seconds;
    let gyro_walk = imu.angle_random_walk_rad;
    let gyro = density(gyro_walk, imu.gyro_vibration_share, step.seconds, gyro_vibration);
    let alike_s = imu.accel_vibration_time_s.max(step.seconds);
    let accel_walk = imu.velocity_random_walk_mps;
    let accel = density(accel_walk, imu.accel_vibration_share, alike_s, accel_vibration);
    let mut angle = gyro * over_s + Vector::from(learned.suspicion.angle_variance);
    let turned = step.rotation_rad.component_mul(rate_radps).sup(&Vector::zeros());
    let about = imu.turn_error_time_s * imu.turn_error_share.powi(2);
    let across = about * 2.5 * 2.5;
    angle += turned * about + (Vector::repeat(turned.sum()) - turned) * across;
    let grown = net_turn.push(step, imu.net_turn_memory_s);
    angle += grown * imu.net_turn_error_share.powi(2);
    [angle, accel * over_s + Vector::from(learned.suspicion.velocity_variance)]
}

impl Sums {
    /// Q over the step: C diag(Σ σ²) Cᵀ for attitude and velocity (K4).
    pub fn noise<const N: usize>(&self) -> Matrix<N> {
        let mut q = Matrix::zeros();
        for (first, variance) in
            [(ATTITUDE, self.angle_variance), (VELOCITY, self.velocity_variance)]
        {
            let in_body = Matrix3::from_diagonal(&variance);
            set(&mut q, first, first, &(self.cosines * in_body * self.cosines.transpose()));
        }
        q
    }
}

/// Q over a gap of the given seconds (K13).
pub fn of_gap<const N: usize>(config: &EkfConfig, seconds: f64) -> Matrix<N> {
    let velocity = config.imu.gap_acceleration_mps2 * seconds;
    let turn = config.imu.gap_rate_radps * seconds;
    let mut sigmas = SVector::<f64, N>::zeros();
    for axis in 0..3 {
        sigmas[ATTITUDE + axis] = turn.min(if axis < 2 { 0.3 } else { 0.5 });
        sigmas[VELOCITY + axis] = velocity;
        sigmas[POSITION + axis] = 0.5 * velocity * seconds;
    }
    Matrix::from_diagonal(&sigmas.component_mul(&sigmas))
}

/// Decay factor of each state and its added variance: y⁺ = D y, P⁺ = D P D + Q.
#[derive(Clone, Copy, Debug)]
pub struct Relaxation<const N: usize> {
    pub decay: SVector<f64, N>,
    pub noise: SVector<f64, N>,
}

/// Remaining fraction after `lost` correlation times: e^(−lost). Below 0.02 the shipped filter uses the series to third
/// order. Its error is lost⁴/24, at most 7e-9, which is up to 1e-8 of the variance regained by a slow GPS error. The
/// oracle uses the same series, so that everything else can be compared to 1e-9.
pub fn left(lost: f64) -> f64 {
    if lost < 0.02 { 1.0 - lost + lost.powi(2) / 2.0 - lost.powi(3) / 6.0 } else { (-lost).exp() }
}

impl<const N: usize> Relaxation<N> {
    pub fn none() -> Self {
        Self { decay: SVector::repeat(1.0), noise: SVector::zeros() }
    }

    /// Makes a state a Gauss–Markov process of this one-sigma and correlation time (K5).
    fn markov(&mut self, state: usize, seconds: f64, sigma: f64, time_s: f64) {
        let left = left(seconds / time_s);
        self.decay[state] = left;
        self.noise[state] = sigma * sigma * (1.0 - left * left);
    }

    /// Relaxation of all parameters over the given seconds (K5, K24). `down` is the last row of C.
    pub fn of_parameters<L: Layout<N>>(
        config: &EkfConfig,
        learned: &Learned,
        parameters: &SVector<f64, N>,
        down: &Vector,
        seconds: f64,
    ) -> Self {
        let (imu, gps) = (&config.imu, &config.gps);
        let mut all = Self::none();
        let [position_h, position_v, velocity_h, velocity_v] =
            learned.gps_wander.unwrap_or_default().map(f64::from);
        for axis in 0..3 {
            let gyro_time_s = imu.gyro_bias_time_s / learned.excess;
            all.markov(GYRO_BIAS + axis, seconds, imu.gyro_bias_sigma_radps, gyro_time_s);
            let accel_time_s = imu.accel_bias_time_s / learned.excess;
            all.markov(ACCEL_BIAS + axis, seconds, imu.accel_bias_sigma_mps2, accel_time_s);
            // The shipped filter uses single precision for the vibration.
            let along = 0.25 + 0.75 * (down[axis] * down[axis]) as f32;
            all.noise[ACCEL_BIAS + axis] +=
                f64::from(along * learned.rectification[axis] as f32) * seconds;
            if let Some(first) = L::GPS_POSITION {
                let sigma = if axis < 2 { position_h } else { position_v };
                all.markov(first + axis, seconds, sigma, gps.position_wander_time_s);
            }
            if let Some(first) = L::GPS_VELOCITY {
                let sigma = if axis < 2 { velocity_h } else { velocity_v };
                all.markov(first + axis, seconds, sigma, gps.velocity_wander_time_s);
            }
            if let Some(first) = L::ATTITUDE_REFERENCE {
                let found = parameters[first + axis].abs() / 1.5;
                let [heading, heading_time_s] = learned.heading_wander;
                let (usual, time_s) = if axis < 2 {
                    (config.attitude.tilt_wander_rad, config.attitude.wander_time_s)
                } else {
                    (heading, heading_time_s)
                };
                all.markov(first + axis, seconds, usual.max(found), time_s);
            }
        }
        for (state, sigma) in
            [(L::LATENCY, gps.position_latency_sigma_s), (L::GPS_DELAY, gps.delay_sigma_s)]
        {
            if let Some(state) = state {
                all.markov(state, seconds, sigma, 3.0 * 3600.0);
            }
        }
        if let Some(state) = L::BARO {
            // A random walk (M10).
            let rate = 4.0 * (1.0 - (-0.5f64).exp()) * config.baro.wander_m.powi(2)
                / config.baro.wander_time_s;
            all.noise[state] = rate * seconds;
        }
        all
    }
}

#[test]
fn the_series_of_a_short_decay_is_off_by_no_more_than_it_says() {
    for lost in (0..200).map(|k| f64::from(k) * 1e-4) {
        let off = (left(lost) - (-lost).exp()).abs();
        assert!(off <= lost.powi(4) / 24.0 + 1e-16, "{lost}: {off:e}");
    }
}
