//! The process model: the transition of the error state over one step, and the noise it adds.
#![expect(clippy::indexing_slicing, reason = "axes count from 0 to 2, in arrays of three")]

use super::{Ekf, MAX_HIDDEN_RAD};
use crate::earth::STANDARD_GRAVITY_MPS2;
use crate::ekf::kernel::covariance::{Relaxation, Transition};
use crate::ekf::kernel::layout::{ACCEL_BIAS, ATTITUDE, GYRO_BIAS, Layout};
use crate::ekf::kernel::motion_sum::{MotionSum, sum};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::watch::level_force::AVERAGED_S;
use crate::imu::{Checks, FullScale, ImuSample, Motion};
use crate::ins::{Advance, Increment};
use crate::matrix::square;
use crate::scalar::{Scalar, single};

/// Estimated slow error of an attitude reference, in one-sigmas, above which its one-sigma is raised.
const UNUSUAL: f64 = 1.5;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    pub(in crate::ekf) fn watch_samples(
        &mut self,
        sample: &ImuSample,
        motion: &Motion<T>,
        interval_s: T,
        gap: bool,
    ) {
        if gap {
            self.samples.integrity.interrupt();
        }
        let mean = motion.mean_rates(interval_s);
        let scale = FullScale {
            gyro_radps: self.config.imu.gyro_range_radps,
            accel_mps2: self.config.imu.accel_range_mps2,
        };
        let mechanisms = &self.config.mechanisms;
        let checks = Checks {
            clipping: mechanisms.clipping,
            shocks: mechanisms.shocks,
            stuck_axes: mechanisms.stuck_axes,
        };
        let momentary = matches!(motion, Motion::Rates { .. });
        let integrity = &mut self.samples.integrity;
        self.samples.suspicion =
            integrity.push((&mean, momentary), &sample.clipped, interval_s, (&scale, checks));
        let vibration = self.samples.integrity.accel_vibration();
        self.samples.rectification.push(
            vibration,
            interval_s,
            self.config.imu.accel_bias_sigma_mps2,
        );
        self.samples.resting_rate_radps = self.samples.rest.push(sample.time, &mean, interval_s);
    }

    /// Decay of the parameters over `interval_s`, and the noise that drives them.
    ///
    /// # Source
    /// Equation (K5) of docs/equations.md.
    pub(in crate::ekf) fn relaxation(&self, interval_s: T) -> Relaxation<T, N> {
        let imu = &self.config.imu;
        let Relaxation { mut decay, mut noise } = Relaxation::default();
        let mut markov = |first: usize, sigmas: &[f64], time_s: f64| {
            // A time of -0 is within the accepted range; without `abs` its quotient would be −∞ and the decay would
            // grow.
            let lost = interval_s / T::of(time_s.abs());
            // Below this limit the third-order series is exact to 1e-8, at a tenth of the cost of the exponential.
            let left = if lost < T::of(0.02) {
                T::ONE - lost * (T::ONE - lost * (T::of(0.5) - lost * T::of(1.0 / 6.0)))
            } else {
                (-lost).exp()
            };
            for (axis, &sigma) in sigmas.iter().enumerate() {
                if let (Some(decay), Some(noise)) =
                    (decay.get_mut(first + axis), noise.get_mut(first + axis))
                {
                    *decay = left;
                    *noise = square(T::of(sigma)) * (T::ONE - left * left);
                }
            }
        };
        let excess = self.memory.excess.factor();
        markov(GYRO_BIAS, &[imu.gyro_bias_sigma_radps; 3], imu.gyro_bias_time_s / excess);
        markov(ACCEL_BIAS, &[imu.accel_bias_sigma_mps2; 3], imu.accel_bias_time_s / excess);
        let [position_h, position_v, velocity_h, velocity_v] =
            self.memory.gps_wander.unwrap_or_default().map(f64::from);
        if let Some(first) = L::GPS_POSITION {
            let sigmas = [position_h, position_h, position_v];
            markov(first, &sigmas, self.config.gps.position_wander_time_s);
        }
        if let Some(first) = L::GPS_VELOCITY {
            let sigmas = [velocity_h, velocity_h, velocity_v];
            markov(first, &sigmas, self.config.gps.velocity_wander_time_s);
        }
        if let Some(state) = L::LATENCY {
            markov(state, &[self.config.gps.position_latency_sigma_s], DELAY_TIME_S);
        }
        if let Some(state) = L::GPS_DELAY {
            markov(state, &[self.config.gps.delay_sigma_s], DELAY_TIME_S);
        }
        if let Some(first) = L::ATTITUDE_REFERENCE {
            let attitude = &self.config.attitude;
            // An estimate far above the usual one-sigma raises the one-sigma.
            let found = |axis: usize| self.estimate(first + axis).abs().wide() / UNUSUAL;
            let tilt = [0, 1].map(|axis| attitude.tilt_wander_rad.max(found(axis)));
            markov(first, &tilt, attitude.wander_time_s);
            let [heading, time_s] = self.memory.heading_wander;
            markov(first + 2, &[heading.max(found(2))], time_s);
        }
        if let Some(state) = L::BARO {
            // The level of a barometer is unknown, so its error is a random walk. The walk reaches in half the wander
            // time the same spread as a Gauss-Markov process.
            let walk = square(self.config.baro.wander_m) / self.config.baro.wander_time_s;
            let rate = 4.0 * (1.0 - HALF_TIME_LEFT) * walk;
            if let Some(noise) = noise.get_mut(state) {
                *noise = T::of(rate) * interval_s;
            }
        }
        let [.., down] = self.state.body_to_ned.rows();
        if self.config.mechanisms.rectification {
            let rectified = self.samples.rectification.variance(down, interval_s);
            for (noise, rectified) in noise.iter_mut().skip(ACCEL_BIAS).zip(rectified) {
                *noise += rectified;
            }
        }
        Relaxation { decay, noise }
    }

    /// Time, s, over which the parameters relax if `interval_s` is added. `None` until [`RELAXED_EVERY_S`] has
    /// accumulated: earlier, the change is too small to justify a pass over the covariance.
    fn relaxation_due_s(&mut self, interval_s: T) -> Option<T> {
        let since_s = self.memory.unrelaxed_s + interval_s;
        let due = since_s >= T::of(RELAXED_EVERY_S);
        self.memory.unrelaxed_s = if due { T::ZERO } else { since_s };
        due.then_some(since_s)
    }

    /// The transition over a gap. Angular rate and specific force are unknown, so errors of attitude and bias do not
    /// enter velocity. Instead, any motion within the vehicle's limits may have happened.
    ///
    /// # Source
    /// Equation (K13) of docs/equations.md.
    pub(in crate::ekf) fn coasting(&mut self, interval_s: T) -> Transition<T, N> {
        let relaxation = self.relaxation_due_s(interval_s).map(|due_s| self.relaxation(due_s));
        let interval_s = interval_s.wide();
        let imu = &self.config.imu;
        let velocity = imu.gap_acceleration_mps2 * interval_s;
        let turn = imu.gap_rate_radps * interval_s;
        let (tilt, heading) = (turn.min(MAX_HIDDEN_TILT_RAD), turn.min(MAX_HIDDEN_RAD));
        let diagonal = |n: f64, e: f64, d: f64| {
            [n, 0.0, 0.0, e, 0.0, d].map(|sigma: f64| T::of(square(sigma)))
        };
        Transition {
            interval_s: T::of(interval_s),
            attitude_noise: diagonal(tilt, tilt, heading),
            velocity_noise: diagonal(velocity, velocity, velocity),
            position_noise: [T::of(square(0.5 * velocity * interval_s)); 3],
            relaxation,
            ..Transition::NONE
        }
    }

    /// Adds a mechanization step, and propagates the covariance once enough steps have accumulated.
    pub(in crate::ekf) fn sum_up(
        &mut self,
        increment: &Increment<T>,
        advance: &Advance<T>,
        trace: &mut impl Trace<T, N>,
    ) {
        let (angle_variance, velocity_variance) = self.noise(increment);
        let mean = |[x, y, z]: [T; 3]| (x + y + z) * T::of(1.0 / 3.0);
        self.memory.step_variances = [mean(angle_variance), mean(velocity_variance)];
        self.memory.level_force.push(advance.from_specific_force_mps, increment.interval_s);
        let mut motion = MotionSum {
            interval_s: increment.interval_s,
            body_to_ned_rows: advance.body_to_ned_rows,
            force_mps: self.memory.level_force.of_motion(advance.from_specific_force_mps),
            angle_variance,
            velocity_variance,
        };
        if let Some(before) = &self.memory.unpropagated {
            motion.add_before(before);
        }
        // The error hidden by a sensor at full scale grows within the interval. So the covariance is propagated at once
        // after a clipped sample.
        let waits = !self.samples.suspicion.clipped.any();
        if waits && motion.interval_s < T::of(self.config.imu.covariance_interval_s) {
            self.memory.unpropagated = Some(motion);
        } else {
            self.memory.unpropagated = None;
            let transition = self.transition(&motion);
            self.propagate(&transition, trace);
        }
    }

    /// Propagates the covariance to the present. Needed before the covariance is read or raised for a measurement, and
    /// before the state changes by anything except a mechanization step.
    pub(in crate::ekf) fn catch_up(&mut self, trace: &mut impl Trace<T, N>) {
        if let Some(motion) = self.memory.unpropagated.take() {
            let transition = self.transition(&motion);
            self.propagate(&transition, trace);
        }
    }

    pub(in crate::ekf) fn propagate(
        &mut self,
        transition: &Transition<T, N>,
        trace: &mut impl Trace<T, N>,
    ) {
        self.covariance.propagate(transition);
        if let Some(relaxation) = &transition.relaxation {
            self.decay(relaxation);
        }
        trace.propagated(transition);
    }

    pub(in crate::ekf) fn decay(&mut self, relaxation: &Relaxation<T, N>) {
        if let Some(first) = L::GPS_POSITION {
            let lost = |state: usize| {
                let decay = relaxation.decay.get(state).copied().unwrap_or(T::ONE);
                single((decay - T::ONE) * self.estimate(state))
            };
            self.memory.gates.drift.add([lost(first), lost(first + 1)]);
        }
        let (_, parameters) = self.parameters.split_at_mut(GYRO_BIAS);
        let (_, decays) = relaxation.decay.split_at(GYRO_BIAS);
        for (parameter, &decay) in parameters.iter_mut().zip(decays) {
            *parameter = *parameter * decay;
        }
    }

    /// Brings covariance and parameters to the present, ready for a measurement.
    #[inline(never)]
    pub(in crate::ekf) fn relax(&mut self, trace: &mut impl Trace<T, N>) {
        self.catch_up(trace);
        if self.memory.unrelaxed_s > T::ZERO {
            self.judge_level_force();
            let relaxation = self.relaxation(self.memory.unrelaxed_s);
            self.memory.unrelaxed_s = T::ZERO;
            self.apply(relaxation, trace);
        }
    }

    /// Lets covariance and parameters relax, without a step of the motion.
    pub(in crate::ekf) fn apply(
        &mut self,
        relaxation: Relaxation<T, N>,
        trace: &mut impl Trace<T, N>,
    ) {
        self.covariance.relax(&relaxation);
        self.decay(&relaxation);
        trace.propagated(&Transition::of_relaxation(relaxation));
    }

    /// Updates the variance of the mean horizontal force's error. It is called at intervals, because the variance
    /// changes slowly.
    ///
    /// # Source
    /// Equation (K23) of docs/equations.md.
    fn judge_level_force(&mut self) {
        if !self.config.mechanisms.level_force {
            self.memory.level_force.variance = T::ZERO;
            return;
        }
        let [north, east, _] = self.state.body_to_ned.rows();
        let over_s = T::of(2.0 * AVERAGED_S);
        let sensed = self.accel_noise(over_s) * T::of(2.0 / 3.0);
        let gravity = T::of(STANDARD_GRAVITY_MPS2);
        let north = self.level_variance(&north, ATTITUDE + 1, -gravity);
        let east = self.level_variance(&east, ATTITUDE, gravity);
        self.memory.level_force.variance = sensed + (north + east).max(T::ZERO);
    }

    /// Variance of the horizontal force along an axis with the body components `row`, (m/s²)². It comes from
    /// accelerometer biases and from the tilt, which projects `gravity` into the axis.
    fn level_variance(&self, row: &[T; 3], tilt: usize, gravity: T) -> T {
        let value = |one: usize, other: usize| self.covariance.value(one, other);
        let mut variance = square(gravity) * value(tilt, tilt);
        // Iterations: 3.
        for axis in 0..3 {
            let bias = ACCEL_BIAS + axis;
            let next = (axis + 1) % 3;
            let twice = T::of(2.0) * row[axis];
            variance += square(row[axis]) * value(bias, bias)
                + twice * row[next] * value(bias, ACCEL_BIAS + next)
                - twice * gravity * value(tilt, bias);
        }
        variance
    }

    /// Variance of the accelerometers' mean error over `over_s`, (m/s²)², summed over the three axes.
    ///
    /// # Source
    /// Equation (K4) of docs/equations.md.
    pub(in crate::ekf) fn accel_noise(&self, over_s: T) -> T {
        self.accel_density(T::ZERO).into_iter().fold(T::ZERO, |sum, density| sum + density) / over_s
    }

    /// Variance per second that noise adds to the velocity, by axis, for samples every `interval_s`.
    fn accel_density(&self, interval_s: T) -> [T; 3] {
        let imu = &self.config.imu;
        density(
            imu.velocity_random_walk_mps,
            imu.accel_vibration_share,
            T::of(imu.accel_vibration_time_s).max(interval_s),
            self.samples.integrity.accel_vibration(),
        )
    }

    /// Variances that the inertial sensors add over one step, in body axes: of rotation, rad², and of velocity change,
    /// (m/s)². The step is added to the net turn.
    ///
    /// # Source
    /// Equation (K4) of docs/equations.md.
    fn noise(&mut self, increment: &Increment<T>) -> ([T; 3], [T; 3]) {
        let Increment { interval_s, rotation_rad, .. } = *increment;
        let imu = &self.config.imu;
        let net_turn =
            self.memory.net_turn.push(rotation_rad, interval_s, T::of(imu.net_turn_memory_s));
        let over_s = T::of(self.memory.excess.factor()) * interval_s;
        let gyro = density(
            imu.angle_random_walk_rad,
            imu.gyro_vibration_share,
            interval_s,
            self.samples.integrity.gyro_vibration(),
        )
        .map(|density| density * over_s);
        let accel = self.accel_density(interval_s).map(|density| density * over_s);
        let own = square(T::of(imu.turn_error_share)) * T::of(imu.turn_error_time_s);
        let across = T::of(square(ACROSS)) * own;
        // The product of rates from two different samples, so that vibration does not count as turning.
        let [x, y, z] = rotation_rad.to_array();
        let [rate_x, rate_y, rate_z] = self.memory.angular_rate_radps.to_array();
        let [x, y, z] = [x * rate_x, y * rate_y, z * rate_z].map(|turned| turned.max(T::ZERO));
        let turning =
            [own * x + across * (y + z), own * y + across * (z + x), own * z + across * (x + y)];
        let share = square(T::of(imu.net_turn_error_share));
        let gyro = sum(sum(gyro, turning), net_turn.map(|grown| share * grown));
        let suspicion = &self.samples.suspicion;
        (sum(gyro, suspicion.angle_variance), sum(accel, suspicion.velocity_variance))
    }

    /// The transition over one or several steps of the mechanization.
    ///
    /// # Source
    /// Equations (K2) and (K4) of docs/equations.md.
    // Inlined: the transition of a single step is then built from values in registers.
    #[inline(always)]
    fn transition(&mut self, motion: &MotionSum<T>) -> Transition<T, N> {
        let &MotionSum { interval_s, body_to_ned_rows: ref c, force_mps, .. } = motion;
        let mut transition = Transition {
            interval_s,
            turn: c.map(|[x, y, z]| [x * interval_s, y * interval_s, z * interval_s]),
            force: force_mps.to_array(),
            attitude_noise: turned(c, motion.angle_variance),
            velocity_noise: turned(c, motion.velocity_variance),
            position_noise: [T::ZERO; 3],
            relaxation: None,
        };
        // Assigned in place: the relaxation is large, and moving even a `None` copies it.
        if let Some(due_s) = self.relaxation_due_s(interval_s) {
            transition.relaxation = Some(self.relaxation(due_s));
            self.judge_level_force();
        }
        transition
    }
}

/// Interval, s, at which the parameters relax between measurements. It is short compared to their default correlation
/// times of 15 s and more.
const RELAXED_EVERY_S: f64 = 0.2;
/// Correlation time of the fixes' delays, s. The delays are unobservable at rest, so their estimates decay over hours.
const DELAY_TIME_S: f64 = 10_800.0;
/// e^(−1/2): decay over half a correlation time.
const HALF_TIME_LEFT: f64 = 0.606_530_659_712_633_4;

/// Ratio of gyro errors across the axis of a turn to errors about it: IMUs are aligned to half a degree.
const ACROSS: f64 = 2.5;

/// Largest one-sigma, rad, that a gap adds to roll and pitch. It suits controlled flight near hover.
const MAX_HIDDEN_TILT_RAD: f64 = 0.3;

/// Variance per second that noise adds to the integral of a triad, by axis. It is the larger of two values: `walk`²,
/// and the product of `share`², the variance `vibration` and its correlation time `alike_s`, s.
#[inline(always)]
fn density<T: Scalar>(walk: f64, share: f64, alike_s: T, vibration: [T; 3]) -> [T; 3] {
    let (walk, share) = (square(T::of(walk)), square(T::of(share)));
    vibration.map(|variance| {
        let shaken = share * variance * alike_s;
        // A comparison is enough: neither value is NaN, which `max` would check for.
        if shaken > walk { shaken } else { walk }
    })
}

/// C diag(v) Cᵀ, upper triangle by rows. The columns of C are orthonormal, so it equals v₂ I + (v₀ − v₂) c₀ c₀ᵀ + (v₁ −
/// v₂) c₁ c₁ᵀ.
fn turned<T: Scalar>(c: &[[T; 3]; 3], [v0, v1, v2]: [T; 3]) -> [T; 6] {
    let (d0, d1) = (v0 - v2, v1 - v2);
    let entry = |i: usize, j: usize| d0 * c[i][0] * c[j][0] + d1 * c[i][1] * c[j][1];
    [v2 + entry(0, 0), entry(0, 1), entry(0, 2), v2 + entry(1, 1), entry(1, 2), v2 + entry(2, 2)]
}
