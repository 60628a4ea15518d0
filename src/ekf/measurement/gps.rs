//! GPS: position and velocity of the antenna, at the time when the fix is valid.
#![expect(clippy::indexing_slicing, reason = "axes count from 0 to 2, in arrays of three")]

use super::update::{Compared, ScalarMeasurement};
use super::wander::GpsNoise;
use crate::earth::LocalEarth;
use crate::ekf::filter::Ekf;
use crate::ekf::gate::{Contradiction, PositionDrift};
use crate::ekf::kernel::covariance::{AxesSensitivity, FixSensitivity, Sensitivities, Sensitivity};
use crate::ekf::kernel::history::{ABOUT_NS, LookBack};
use crate::ekf::kernel::layout::{Layout, VELOCITY};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::group::Group;
use crate::ekf::outcome::innovation::{Channel, Verdict};
use crate::ekf::outcome::report::{Report, Unusable};
use crate::ekf::watch::OUTLIER_SIGMAS;
use crate::ekf::watch::antenna::AntennaOffset;
use crate::ekf::watch::excess::Stepped;
use crate::ekf::watch::self_contradiction::FixSigmas;
use crate::frames::{Ned, Vector};
use crate::gps::Fix;
use crate::ins::LeverArm;
use crate::matrix::{product, skew, square};
use crate::scalar::{Scalar, single};
use crate::time::Time;

/// Largest learned variance, relative to the stated or configured one.
const LEARNED_MAX: f64 = 100.0;
/// Smallest learned variance, relative to the stated or configured one.
const LEARNED_MIN: f64 = 0.1;

/// Ratio of learned to stated one-sigma up to which the stated one is unchanged. Larger ratios are divided by this
/// value.
const UNCHANGED_RATIO: f64 = 1.15;

/// Factor on the position's one-sigma σ in the limit above which a shift is a drift: √((`MAX_SHIFT_SIGMAS` σ)² + `MAX_SHIFT_M`²).
const MAX_SHIFT_SIGMAS: f32 = 2.0 * core::f32::consts::SQRT_2;
/// Constant part of the largest position shift that is not a drift, m.
const MAX_SHIFT_M: f32 = 5.0;

/// Cosine of the largest tilt of a nearly level vehicle.
const NEARLY_LEVEL_COSINE: f32 = 0.8;

/// Largest time by which a fix may be ahead of the last inertial sample, s.
const LEAD_S: f64 = 0.1;
/// Largest time by which a fix may be valid after its time stamp, s.
const MAX_AHEAD_S: f64 = 0.3;

/// The three axes of a fix to compare, empty without a measurement, and their sensitivity.
type Axes<T> = ([Option<Compared<T>>; 3], AxesSensitivity<T>);

/// One-sigma of the vertical velocity of a vehicle without a measured height, m/s.
const CLIMB_MPS: f64 = 5.0;

/// Channels of the axes, north, east, down.
const POSITIONS: [Channel; 3] =
    [Channel::PositionNorth, Channel::PositionEast, Channel::PositionDown];
const VELOCITIES: [Channel; 3] =
    [Channel::VelocityNorth, Channel::VelocityEast, Channel::VelocityDown];

/// Factor by which stated one-sigmas are enlarged, at least 1. `learned` is the ratio of the learned to the stated
/// one-sigma.
fn stated_times(learned: f64) -> f64 {
    (learned / UNCHANGED_RATIO).max(1.0)
}

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Factors by which the filter enlarges the one-sigmas that fixes state, for position and horizontal velocity: 1 to
    /// 2.6.
    ///
    /// # Source
    /// Equation (M7) of docs/equations.md.
    #[must_use]
    pub fn stated_times(&self) -> [f64; 2] {
        let [position, level, _] = self.memory.gps_learned;
        [position, level].map(|variance| stated_times(Scalar::sqrt(f64::from(variance))))
    }

    /// Fuses a satellite fix: position, and velocity if present, at the antenna and at the time when the fix was valid.
    ///
    /// # Errors
    /// [`Unusable`] if the fix cannot be compared with the state. A fix that is compared and rejected is no error: the
    /// [`Report`] contains the verdict for each axis.
    pub fn update_gps(&mut self, fix: &Fix) -> Result<Report, Unusable> {
        self.update_gps_traced(fix, &mut ())
    }

    /// [`update_gps`](Self::update_gps), observed by `trace`.
    ///
    /// # Errors
    /// As [`update_gps`](Self::update_gps).
    pub fn update_gps_traced(
        &mut self,
        fix: &Fix,
        trace: &mut impl Trace<T, N>,
    ) -> Result<Report, Unusable> {
        let mut report = Report::default();
        self.fuse_gps(fix, &mut report, trace).map(|()| report)
    }

    /// [`update_gps`](Self::update_gps), reported in the empty `report`.
    pub(in crate::ekf) fn fuse_gps(
        &mut self,
        fix: &Fix,
        report: &mut Report,
        trace: &mut impl Trace<T, N>,
    ) -> Result<(), Unusable> {
        if !fix.is_finite() {
            return Err(Unusable::NotFinite);
        }
        if fix.time - self.state.time > LEAD_S {
            return Err(Unusable::AheadOfImu);
        }
        let earth = LocalEarth::about(&self.state.position);
        let [delay_s, latency_s] = self.gps_delays_s();
        let look_back = |latency_s: T, with_acceleration| {
            let time = fix.time.offset_by(-latency_s);
            self.history.look_back(&self.state, &earth, time, with_acceleration)
        };
        // The estimated delay never excludes a fix that came in time: without motion the estimate drifts.
        let reach_s = self.history.reach_s(fix.time);
        let is_beyond = delay_s.max(latency_s) > reach_s;
        // By reference: a copy of each would cost a sixth of the time to look back.
        let velocity_then = &look_back(delay_s.min(reach_s), true);
        let position_then = match L::LATENCY {
            Some(_) => &look_back(latency_s.min(reach_s), false),
            None => velocity_then,
        };
        let (Some(velocity_then), Some(position_then)) = (velocity_then, position_then) else {
            return Err(Unusable::TooOld);
        };
        self.relax(trace);
        let sigmas = self.fix_sigmas(fix);
        if self.config.mechanisms.position_scatter && fix.horizontal_velocity_mps.is_none() {
            let agility_mps2 = self.samples.self_contradiction.agility_mps2();
            self.memory.position_scatter.push(fix, sigmas.0, agility_mps2);
        }
        let noise = self.gps_noise(fix, sigmas, trace);
        self.judge_readings(fix, sigmas, earth.gravity_mps2.wide());
        if velocity_then.hidden_s > T::ZERO {
            // The fix is valid within a gap of the samples. Until the next fix the contradiction check has no complete
            // velocity change of the inertial unit.
            self.samples.self_contradiction.add(Vector::ZERO, false);
        }
        let down_mps = fix.measured_down_mps().unwrap_or_default();
        let velocity = fix.horizontal_velocity_mps.map(|[north, east]| [north, east, down_mps]);
        self.samples.rest.fix(fix.time, velocity);
        // Velocity first: it is the more accurate one, and its correction reduces the position's nonlinearity.
        let ([mut vn, mut ve, vd], velocity) = self.velocity_axes(fix, velocity_then, &noise);
        if self.config.mechanisms.antenna_offset
            && !self.samples.self_contradiction.is_proven()
            && let (Some(north), Some(east)) = (&mut vn, &mut ve)
        {
            self.watch_antenna(north, east, velocity_then);
        }
        let ([n, e, d], position) = self.position_axes(&earth, fix, position_then, &noise);
        let mut sensitivity = FixSensitivity { velocity, position, age_s: position_then.age_s };
        if is_beyond {
            // Beyond the history the delay is not observable.
            sensitivity.velocity.delay = [T::ZERO; 3];
            sensitivity.position.delay = [T::ZERO; 3];
        }
        let axes = [vn, ve, vd, n, e, d];
        let sensitivities = Sensitivities::Fix(&sensitivity);
        let is_absent = self.memory.gates.is_absent(Group::HorizontalPosition, fix.time);
        let moved_m = self.compare(fix.time, &axes, sensitivities, report, trace);
        self.memory.gates.shift_position(moved_m);
        if is_absent {
            // No position came recently. Meanwhile the vehicle's own motion moved the expected position.
            self.memory.gates.drift = PositionDrift::NONE;
        } else if self.config.mechanisms.drifting_positions && L::GPS_POSITION.is_some() {
            report.position_drift_m = self.note_position_drift(fix, [moved_m[0], moved_m[1]]);
        }
        report.contradicts = self.samples.self_contradiction.is_proven() && report.any_rejected();
        if report.contradicts {
            // Nothing is learned from a contradictory fix.
            return Ok(());
        }
        if fix.two_dimensional {
            self.bound_climb(fix.time, trace);
        }
        let places_alone = fix.horizontal_velocity_mps.is_none();
        if self.config.mechanisms.fix_errors {
            self.learn_gps(report, fix.position_sigma_m.is_some());
        }
        // Velocity errors left by clipping or a gap do not indicate a step of a bias.
        let mechanisms = self.config.mechanisms;
        let mut stepped = self.memory.excess.learn(fix.time, report);
        if !mechanisms.excess_noise {
            self.memory.excess.forget_factor();
        }
        // From positions alone, the only evidence of a step is that the filter diverged.
        stepped.far |= places_alone && report.any_reset();
        // A height that a barometer confirms is right, and so are the biases behind it.
        stepped.down_far =
            stepped.down_far.filter(|_| !self.memory.gates.agrees(Group::Baro, fix.time));
        let is_far = stepped.far || stepped.down_far.is_some();
        let otherwise = self.memory.gates.is_filter_suspect(fix.time)
            || self.samples.self_contradiction.is_suspected()
            || (self.memory.gates.has_velocity_diverged(fix.time) && !is_far);
        if mechanisms.bias_steps && stepped != Stepped::default() && !otherwise {
            self.raise_bias_sigmas(stepped, trace);
            report.biases_opened = true;
        }
        Ok(())
    }

    /// Bounds the vertical velocity of a filter without height measurements. Once its one-sigma exceeds 5 m/s, a
    /// measurement of 0 ± 5 m/s is fused. Otherwise the vertical channel would diverge with the accelerometers' bias.
    ///
    /// # Source
    /// Equation (M19) of docs/equations.md.
    #[inline(never)]
    fn bound_climb(&mut self, time: Time, trace: &mut impl Trace<T, N>) {
        let state = VELOCITY + 2;
        if self.covariance.variance(state) < square(CLIMB_MPS) {
            return;
        }
        let climb = ScalarMeasurement::new(
            Channel::RestVelocityDown,
            -self.state.velocity_mps.z(),
            T::of(square(CLIMB_MPS)),
            Sensitivity::default().with(state, T::ONE),
        );
        self.update_one(time, Some(climb), trace);
    }

    /// Time, s, by which a fix's velocity and position are valid before its time stamp, as estimated.
    fn gps_delays_s(&self) -> [T; 2] {
        let delay_s = L::GPS_DELAY.map_or(T::ZERO, |state| self.estimate(state));
        let latency_s = L::LATENCY.map_or(T::ZERO, |state| delay_s + self.estimate(state));
        [delay_s, latency_s].map(|late_s| late_s.max(-T::of(MAX_AHEAD_S)))
    }

    /// The latest time of a fix whose motion the inertial samples cover, given the estimated delay.
    ///
    /// # Source
    /// Equation (M14) of docs/equations.md.
    pub(in crate::ekf) fn due_until(&self) -> Time {
        let [delay_s, latency_s] = self.gps_delays_s();
        let about_s = if L::GPS_DELAY.is_some() { T::of_nanoseconds(ABOUT_NS) } else { T::ZERO };
        let since_s = (delay_s - about_s).min(latency_s).min(T::ZERO);
        self.state.time.offset_by(since_s)
    }

    /// Compares a fix, with these one-sigmas of position and velocity, with the previous fixes.
    fn judge_readings(
        &mut self,
        fix: &Fix,
        (position_m, velocity_mps): ([f64; 3], [f64; 3]),
        gravity_mps2: f64,
    ) {
        if !self.config.mechanisms.self_contradiction {
            return;
        }
        let own_mps = self.state.velocity_mps.cast();
        let watch = &mut self.samples.self_contradiction;
        watch.push(fix, own_mps, &FixSigmas { position_m, velocity_mps, gravity_mps2 });
        self.memory.gates.contradiction =
            Contradiction { suspected: watch.is_suspected(), proven: watch.is_proven() };
    }

    /// Notifies the gates of the shift `moved_m`, north and east, of the expected position by a fix. Returns the drift
    /// of positions away from their own velocity, m; zero without a drift.
    ///
    /// # Source
    /// Equation (K25) of docs/equations.md.
    fn note_position_drift(&mut self, fix: &Fix, moved_m: [f32; 2]) -> f32 {
        // The learned size grows with a drift, so only a learned reduction counts.
        let assumed = || {
            let [level_m, ..] = self.config.gps.position_sigma_m();
            level_m as f32 * libm::sqrtf(self.memory.gps_learned[0].min(1.0))
        };
        let stated = |sigma: Vector<Ned>| sigma.x().max(sigma.y()) as f32;
        let sigma_m = fix.position_sigma_m.map_or_else(assumed, stated);
        let least_m = libm::hypotf(MAX_SHIFT_SIGMAS * sigma_m, MAX_SHIFT_M);
        self.memory.gates.observe_position_shift(fix.time, moved_m, least_m)
    }

    /// Adapts the learned size of the GPS errors to the innovations of this fix, relative to their expected size. If
    /// fixes state the accuracy of their positions, only accepted position innovations count. A jump does not show the
    /// error of other fixes.
    ///
    /// # Source
    /// Equation (M7) of docs/equations.md.
    fn learn_gps(&mut self, report: &Report, states_places: bool) {
        for axis in report.innovations() {
            let learned = match axis.channel {
                Channel::PositionNorth | Channel::PositionEast
                    if states_places && axis.verdict != Verdict::Accepted =>
                {
                    continue;
                }
                Channel::PositionNorth | Channel::PositionEast => &mut self.memory.gps_learned[0],
                Channel::VelocityNorth | Channel::VelocityEast => &mut self.memory.gps_learned[1],
                Channel::VelocityDown => &mut self.memory.gps_learned[2],
                _ => continue,
            };
            let surprise = square(axis.normalised()).min(square(OUTLIER_SIGMAS));
            let share = 1.0 + self.config.gps.learning_rate * (surprise - 1.0);
            *learned = (f64::from(*learned) * share).clamp(LEARNED_MIN, LEARNED_MAX) as f32;
        }
    }

    /// One-sigmas, NED, of a fix's position, m, and of its velocity, m/s. The stated or assumed one-sigmas are
    /// multiplied by factors from the learned variances.
    pub(in crate::ekf) fn fix_sigmas(&self, fix: &Fix) -> ([f64; 3], [f64; 3]) {
        let model = &self.config.gps;
        let [learned_m, level, vertical] =
            self.memory.gps_learned.map(|variance| T::of(variance.into()).sqrt().wide());
        let learned_mps = [level, level, vertical];
        let position = match fix.position_sigma_m {
            Some(stated) => stated.to_array().map(|sigma| sigma * stated_times(learned_m)),
            None => model.position_sigma_m().map(|sigma| sigma * learned_m),
        };
        let stated_mps = fix.axes_velocity_sigma_mps().map(Vector::to_array);
        let velocity: [f64; 3] = core::array::from_fn(|axis| match stated_mps {
            Some(stated) => stated[axis] * stated_times(learned_mps[axis]),
            // The vertical velocity is assumed no more accurate than the horizontal velocity, which is far better
            // observable.
            None => model.velocity_sigma_mps()[axis] * learned_mps[axis].max(level),
        });
        (position, velocity)
    }

    /// The axes of a position, at the antenna and at the time when it was valid. The height is omitted if it is not
    /// measured.
    ///
    /// # Source
    /// Equation (M3) of docs/equations.md.
    #[inline(never)]
    fn position_axes(
        &self,
        earth: &LocalEarth<T>,
        fix: &Fix,
        back: &LookBack<T>,
        noise: &GpsNoise,
    ) -> Axes<T> {
        let wander: Vector<Ned, T> =
            L::GPS_POSITION.map_or([T::ZERO; 3], |first| self.block(first)).into();
        let antenna_arm = self.antenna_arm();
        let arm = back.state.body_to_ned * antenna_arm.0;
        let off = earth.displacement(&back.state.position, &fix.position) - arm;
        let innovation = (off - wander).to_array();
        let accelerated = T::of(-0.5) * back.age_s;
        let swing = back.state.body_to_ned * antenna_arm.relative_velocity(back.angular_rate_radps);
        let axes_measured = if fix.two_dimensional { 2 } else { 3 };
        let lag_noise = self.lag_noise(back, back.age_s);
        let axes = core::array::from_fn(|axis| {
            let (channel, innovation) = (POSITIONS[axis], innovation[axis]);
            let noise = T::of(noise.position_variance[axis]) + lag_noise;
            (axis < axes_measured).then_some(Compared { channel, innovation, noise })
        });
        let velocity_variance = (VELOCITY..VELOCITY + 3)
            .fold(T::ZERO, |sum, state| sum + self.covariance.value(state, state));
        // δz = δp − L δv − (∫ΔV × ) ψ − [arm ×] ψ, with the age L and ψ then = ψ now + (∫C) δb_g; ∫ΔV is reduced (K23).
        let sensitivity = AxesSensitivity {
            turning: (-self.memory.level_force.of_motion(back.force_m) - arm).to_array(),
            gyro_bias: product(&skew((-arm).to_array()), &back.turn_s),
            accel_bias: back.turn_s.map(|row| row.map(|turn_s| turn_s * accelerated)),
            delay: significant(-(back.state.velocity_mps + swing), velocity_variance).to_array(),
        };
        (axes, sensitivity)
    }

    /// The axes of a velocity, at the antenna and at the time when it was valid. Components that the fix does not
    /// report stay empty.
    ///
    /// # Source
    /// Equation (M4) of docs/equations.md.
    #[inline(never)]
    fn velocity_axes(&self, fix: &Fix, back: &LookBack<T>, noise: &GpsNoise) -> Axes<T> {
        let wander: Vector<Ned, T> =
            L::GPS_VELOCITY.map_or([T::ZERO; 3], |first| self.block(first)).into();
        let antenna_arm = self.antenna_arm();
        let body_to_ned = back.state.body_to_ned;
        let swing = body_to_ned * antenna_arm.relative_velocity(back.angular_rate_radps);
        let predicted = (back.state.velocity_mps + swing + wander).to_array();
        let measured = [
            fix.horizontal_velocity_mps.map(|velocity| T::of(velocity[0])),
            fix.horizontal_velocity_mps.map(|velocity| T::of(velocity[1])),
            fix.measured_down_mps().map(T::of),
        ];
        let acceleration = back.acceleration_mps2.to_array();
        let acceleration_variance = self.accel_noise(back.acceleration_over_s);
        let lag_noise = self.lag_noise(back, T::ONE);
        let axes = core::array::from_fn(|axis| {
            let noise = T::of(noise.velocity_variance[axis])
                + lag_noise
                + square(T::of(self.config.gps.velocity_smoothing_s) * acceleration[axis]);
            let innovation = measured[axis]? - predicted[axis];
            Some(Compared { channel: VELOCITIES[axis], innovation, noise })
        });
        // δz = δv + [ΔV ×] ψ + (∫C) δb_a − [swing ×] ψ + C [arm ×] δb_g.
        let sensitivity = AxesSensitivity {
            turning: (self.memory.level_force.of_motion(back.force_mps) - swing).to_array(),
            gyro_bias: product(&body_to_ned.rows(), &skew(antenna_arm.0.to_array())),
            accel_bias: back.turn_s,
            delay: significant(-back.acceleration_mps2, acceleration_variance).to_array(),
        };
        (axes, sensitivity)
    }

    /// Feeds a horizontal velocity to the estimator of the antenna's position, and adds the uncertainty of that
    /// position to the noise.
    #[inline(never)]
    fn watch_antenna(
        &mut self,
        north: &mut Compared<T>,
        east: &mut Compared<T>,
        back: &LookBack<T>,
    ) {
        let body_to_ned = back.state.body_to_ned;
        let turning_radps = single((body_to_ned * back.angular_rate_radps).z());
        let down_cosine = single(body_to_ned.rows()[2][2]);
        // The levelled components equal those of the body only if it is nearly level.
        if !AntennaOffset::is_turn(turning_radps) || down_cosine < NEARLY_LEVEL_COSINE {
            return;
        }
        let (sin, cos) = body_to_ned.heading_sincos();
        let (n, e) = (north.innovation, east.innovation);
        let ahead = [cos * n + sin * e, cos * e - sin * n].map(single);
        let level_mps2 = single(back.acceleration_mps2.x().hypot(back.acceleration_mps2.y()));
        let expected = |axis: &Compared<T>, state| axis.noise + self.covariance.value(state, state);
        let variance = single(expected(north, VELOCITY) + expected(east, VELOCITY + 1)) * 0.5;
        let unsure = T::of(f64::from(self.memory.antenna.velocity_variance(turning_radps)));
        self.memory.antenna.observe_innovation(turning_radps, level_mps2, ahead, variance);
        north.noise += unsure;
        east.noise += unsure;
    }

    /// From the inertial unit to the estimated position of the antenna.
    fn antenna_arm(&self) -> LeverArm<T> {
        LeverArm(
            self.mounting.antenna_from_imu().cast::<T>().0 + self.memory.antenna.offset_m().cast(),
        )
    }

    /// Variance of the velocity error since the time of `back`, times the square of `lever`. It comes from the inertial
    /// sensors' noise, and from a gap in their samples.
    ///
    /// # Source
    /// Equation (M6) of docs/equations.md.
    pub(super) fn lag_noise(&self, back: &LookBack<T>, lever: T) -> T {
        let imu = &self.config.imu;
        let walk = square(T::of(imu.velocity_random_walk_mps)) * back.age_s.max(T::ZERO);
        (walk + square(T::of(imu.gap_acceleration_mps2) * back.hidden_s)) * square(lever)
    }
}

/// The vector `v` by which fixes observe their delay, reduced by the likely contribution of its own error. `variance`
/// is the variance of all axes together. That error is correlated with the innovation. At rest, where there is no other
/// signal, each fix would move the delay in the same direction.
///
/// # Source
/// Equation (M14) of docs/equations.md.
fn significant<T: Scalar>(v: Vector<Ned, T>, variance: T) -> Vector<Ned, T> {
    let squared = v.dot(v);
    // The condition is written so that a NaN gives zero.
    if squared > variance { v * (T::ONE - variance / squared) } else { Vector::ZERO }
}
