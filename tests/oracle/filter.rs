//! The textbook filter: nominal state, parameters and a dense covariance, propagated by samples.

use std::marker::PhantomData;

use hovernav::ekf::layout::{ACCEL_BIAS, ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use hovernav::ekf::{EkfConfig, Learned};
use hovernav::imu::ImuSample;
use hovernav::ins::Mounting;
use nalgebra::SVector;

use crate::history::History;
use crate::mechanization::{Earth, Increment, Nominal, Previous, UnitErrors, Vector};
use crate::noise::{self, NetTurn, Relaxation};
use crate::transition::{Matrix, Sums, with_position};

/// Time, s, after which decay and noise are applied to the parameters. A measurement applies them earlier.
const RELAXED_EVERY_S: f64 = 0.2;
/// Longest gap that the filter bridges, s.
const LONGEST_BRIDGE_S: f64 = 60.0;

/// An error-state filter in textbook form.
#[derive(Clone, Debug)]
pub struct Filter<L, const N: usize> {
    pub config: EkfConfig,
    pub mounting: Mounting,
    pub nominal: Nominal,
    /// Estimates of the states from the gyro biases on.
    pub parameters: SVector<f64, N>,
    pub covariance: Matrix<N>,
    pub history: History,
    /// Last used sample, and its angular rate of the body relative to the ground, rad/s.
    previous: Option<Previous>,
    pub rate_radps: Vector,
    /// Steps not yet propagated into the covariance.
    pub pending: Option<Sums>,
    /// Time since decay and noise were last applied to the parameters, s.
    pub unrelaxed_s: f64,
    net_turn: NetTurn,
    layout: PhantomData<L>,
}

/// Effect of a sample on the filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    Stepped,
    Coasted,
    Reset,
}

impl<L: Layout<N>, const N: usize> Filter<L, N> {
    pub fn new(config: EkfConfig, mounting: Mounting, nominal: Nominal) -> Self {
        Self {
            config,
            mounting,
            nominal,
            parameters: SVector::zeros(),
            covariance: Matrix::zeros(),
            history: History::default(),
            previous: None,
            rate_radps: Vector::zeros(),
            pending: None,
            unrelaxed_s: 0.0,
            net_turn: NetTurn::NONE,
            layout: PhantomData,
        }
    }

    /// Three consecutive parameters.
    pub fn block(&self, first: usize) -> Vector {
        self.parameters.fixed_rows::<3>(first).into_owned()
    }

    fn unit_errors(&self) -> UnitErrors {
        UnitErrors { bias: [self.block(GYRO_BIAS), self.block(ACCEL_BIAS)] }
    }

    /// Propagates state and covariance to the next sample. `learned` holds the learned quantities after this sample.
    pub fn predict(&mut self, sample: &ImuSample, learned: &Learned) -> Step {
        let errors = self.unit_errors();
        let before = self.previous;
        let last = before.map_or(self.nominal.time, |before| before.time);
        let seconds = sample.time - last;
        let mut step = Increment::between(before.as_ref(), sample, seconds, &errors);
        self.previous = Some(Previous::of(sample, before.as_ref()));
        if seconds > LONGEST_BRIDGE_S {
            self.nominal.time = sample.time;
            self.reset();
            return Step::Reset;
        }
        let withheld = Vector::from(learned.suspicion.withheld_mps2.to_array());
        step.velocity_mps -= withheld * seconds;
        let is_gap = seconds > self.config.imu.gap_s;
        let frame_rate_radps =
            if is_gap { self.coast(sample, learned) } else { self.step(sample, &step, learned) };
        let against_ground = self.nominal.attitude.inverse() * frame_rate_radps;
        self.rate_radps = step.last_rate_radps - against_ground;
        if is_gap { Step::Coasted } else { Step::Stepped }
    }

    fn step(&mut self, sample: &ImuSample, step: &Increment, learned: &Learned) -> Vector {
        let advance = self.nominal.advance(sample.time, step);
        let [angle_variance, velocity_variance] =
            noise::of_sensors(&self.config, learned, step, &self.rate_radps, &mut self.net_turn);
        let share = learned.level_share;
        let sums = Sums {
            seconds: step.seconds,
            cosines: advance.cosines,
            force_mps: advance.force_mps.component_mul(&Vector::new(share, share, 1.0)),
            angle_variance,
            velocity_variance,
        };
        let sums = self.pending.take().map_or(sums, |before| sums.after(&before));
        self.pending = Some(sums);
        let is_due = sums.seconds >= self.config.imu.covariance_interval_s;
        if is_due || learned.suspicion.clipped.any() {
            self.catch_up(learned);
        }
        self.history.push(sample.time, step, &advance);
        advance.frame_rate_radps
    }

    /// Propagation over a gap in the samples: (S14) and (K13).
    fn coast(&mut self, sample: &ImuSample, learned: &Learned) -> Vector {
        self.catch_up(learned);
        let seconds = sample.time - self.nominal.time;
        let rotation_rad = self.nominal.coast(sample.time, &self.rate_radps);
        let phi = with_position(Matrix::identity(), seconds);
        self.propagate(&phi, &noise::of_gap(&self.config, seconds));
        self.unrelaxed_s += seconds;
        self.relax_when_due(learned);
        self.history.coast(sample.time, seconds, &rotation_rad);
        let earth = Earth::at(&self.nominal.place);
        earth.rate_radps + earth.transport_rate(&self.nominal.velocity_mps)
    }

    /// P⁺ = Φ P Φᵀ + Q (K3).
    pub fn propagate(&mut self, phi: &Matrix<N>, noise: &Matrix<N>) {
        self.covariance = phi * self.covariance * phi.transpose() + noise;
    }

    /// Propagates the covariance over the steps since it was last propagated.
    pub fn catch_up(&mut self, learned: &Learned) {
        if let Some(sums) = self.pending.take() {
            self.propagate(&sums.transition(), &sums.noise());
            self.unrelaxed_s += sums.seconds;
            self.relax_when_due(learned);
        }
    }

    fn relax_when_due(&mut self, learned: &Learned) {
        if self.unrelaxed_s >= RELAXED_EVERY_S {
            self.relax(learned);
        }
    }

    /// Applies decay and noise to the parameters for the time since the last call (K5).
    pub fn relax(&mut self, learned: &Learned) {
        let down = self.nominal.cosines().row(2).transpose();
        let relaxation = Relaxation::of_parameters::<L>(
            &self.config,
            learned,
            &self.parameters,
            &down,
            self.unrelaxed_s,
        );
        self.unrelaxed_s = 0.0;
        self.apply(&relaxation);
    }

    /// P⁺ = D P D + Q, and the parameters likewise.
    pub fn apply(&mut self, Relaxation { decay, noise }: &Relaxation<N>) {
        self.propagate(&Matrix::from_diagonal(decay), &Matrix::from_diagonal(noise));
        self.parameters.component_mul_assign(decay);
    }

    /// Sets the variance of a state and clears its correlations.
    pub fn open(&mut self, state: usize, sigma: f64) {
        self.covariance.row_mut(state).fill(0.0);
        self.covariance.column_mut(state).fill(0.0);
        self.covariance[(state, state)] = sigma * sigma;
    }

    /// Sets the covariance so large that the next fixes determine the state. Estimates keep their values, and so does
    /// the barometer's variance.
    pub fn reset(&mut self) {
        let baro = L::BARO.map(|state| (state, self.covariance[(state, state)].sqrt()));
        self.covariance = Matrix::zeros();
        self.pending = None;
        self.history.clear();
        let (imu, gps, attitude) = (self.config.imu, self.config.gps, self.config.attitude);
        let mut blocks = vec![
            (Some(ATTITUDE), 0.5),
            (Some(VELOCITY), 50.0),
            (Some(POSITION), 1e4),
            (Some(GYRO_BIAS), imu.gyro_bias_sigma_radps),
            (Some(ACCEL_BIAS), imu.accel_bias_sigma_mps2),
        ];
        blocks.push((L::ATTITUDE_REFERENCE, attitude.tilt_wander_rad));
        for (first, sigma) in blocks {
            for axis in 0..3 {
                if let Some(first) = first {
                    self.open(first + axis, sigma);
                }
            }
        }
        for (state, sigma) in
            [(L::LATENCY, gps.position_latency_sigma_s), (L::GPS_DELAY, gps.delay_sigma_s)]
        {
            if let Some(state) = state {
                self.open(state, sigma);
            }
        }
        if let Some((state, sigma)) = baro {
            self.open(state, sigma);
        }
    }

    /// Sets the heading variance of the attitude reference after a [`reset`](Self::reset) to its last value.
    pub fn open_heading_reference(&mut self, learned: &Learned) {
        if let Some(first) = L::ATTITUDE_REFERENCE {
            self.open(first + 2, learned.heading_wander[0]);
        }
    }
}
