//! Measurements: GPS position and velocity, attitude and heading references, barometric height.

use core::fmt;

use glam::{DMat3, DVec3};

use super::covariance::Sensitivity;
use super::filter::{Ekf, Trace, square};
use super::gate::Group;
use super::history::LookBack;
use super::innovation::{Channel, Innovation, Verdict};
use super::layout::{ACCEL_BIAS, ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use super::scalar::Scalar;
use crate::frames::{Body, Ned, Rotation, Vector};
use crate::gps::Fix;
use crate::time::Time;

/// A scalar measurement ready to be compared: innovation, sensitivity, variance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scalarized<T> {
    pub channel: Channel,
    pub group: Group,
    pub innovation: f64,
    pub noise: f64,
    pub sensitivity: Sensitivity<T>,
}

/// White variances of a fix, north, east, down.
struct GpsNoise {
    position_variance: [f64; 3],
    velocity_variance: [f64; 3],
}

/// What happened to the axes of one measurement, in the order they were taken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    axes: [Option<Innovation>; 6],
}

impl Report {
    /// The innovations, each with its verdict. Each is what was left after the axes before it, so
    /// they are uncorrelated, and their normalised squares add up to the fix's own.
    pub fn innovations(&self) -> impl Iterator<Item = &Innovation> {
        self.axes.iter().flatten()
    }

    /// Whether any axis corrected the state.
    #[must_use]
    pub fn any_accepted(&self) -> bool {
        self.innovations().any(|axis| axis.verdict != Verdict::Rejected)
    }

    /// Whether any axis was refused.
    #[must_use]
    pub fn any_rejected(&self) -> bool {
        self.innovations().any(|axis| axis.verdict == Verdict::Rejected)
    }

    /// Whether the filter had to be reopened for any axis.
    #[must_use]
    pub fn any_reopened(&self) -> bool {
        self.innovations().any(|axis| axis.verdict == Verdict::Reopened)
    }

    /// Sum of the squared normalised innovations and of the logarithms of their variances: minus
    /// twice the logarithm of the measurement's likelihood, but for a constant.
    #[must_use]
    pub fn surprise(&self) -> f64 {
        self.innovations().map(|axis| square(axis.normalised()) + 2.0 * libm::log(axis.sigma)).sum()
    }

    fn push(&mut self, innovation: Innovation) {
        if let Some(slot) = self.axes.iter_mut().find(|slot| slot.is_none()) {
            *slot = Some(innovation);
        }
    }
}

/// Why a measurement could not be compared at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unusable {
    /// A value is NaN or infinite, or the place is none.
    NotFinite,
    /// Older than the filter's memory of the way that led here.
    TooOld,
    /// Later than the inertial samples by more than two of their intervals.
    AheadOfImu,
    /// Sooner after the last use than the reference's own noise allows to be worth anything.
    TooSoon,
    /// The layout has no state for it.
    NoState,
}

impl fmt::Display for Unusable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "no place, or not finite",
            Self::TooOld => "older than the filter's memory",
            Self::AheadOfImu => "ahead of the inertial samples",
            Self::TooSoon => "too soon after the last to be worth anything",
            Self::NoState => "the filter has no state for it",
        })
    }
}

/// Greatest and least learned variance against the configured.
const LEARNED_MOST: f64 = 9.0;
const LEARNED_LEAST: f64 = 0.1;

/// The direction of a rotation of the heading, north, east, down.
const DOWN: [f64; 3] = [0.0, 0.0, 1.0];

/// No barometer of a vehicle of this kind tells a height beyond this, m.
const HIGHEST_M: f64 = 1e5;

/// A fix may be this far ahead of the last inertial sample, s.
const LEAD_S: f64 = 0.1;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Takes in a satellite fix: position, and velocity where it has any, at the antenna, at the
    /// time the fix was true.
    ///
    /// # Errors
    /// [`Unusable`] when it cannot be compared with the state. A fix that is compared and refused is
    /// no error: the [`Report`] says so for each axis.
    pub fn update_gps(&mut self, fix: &Fix) -> Result<Report, Unusable> {
        self.update_gps_traced(fix, &mut ())
    }

    /// [`update_gps`](Self::update_gps), watched by `trace`.
    ///
    /// # Errors
    /// As [`update_gps`](Self::update_gps).
    pub fn update_gps_traced(
        &mut self,
        fix: &Fix,
        trace: &mut impl Trace<T, N>,
    ) -> Result<Report, Unusable> {
        if !fix.is_finite() {
            return Err(Unusable::NotFinite);
        }
        if fix.time - self.state.time > LEAD_S {
            return Err(Unusable::AheadOfImu);
        }
        let look_back = |latency_s: f64| {
            let past = fix.time.offset_by(-latency_s);
            self.history.look_back(&self.state, past).ok_or(Unusable::TooOld)
        };
        let velocity_then = look_back(0.0)?;
        let position_then = match L::LATENCY {
            Some(state) => look_back(self.parameter(state))?,
            None => velocity_then,
        };
        let noise = self.gps_noise(fix);
        let position = self.position_axes(fix, &position_then, &noise);
        let velocity = self.velocity_axes(fix, &velocity_then, &noise);
        let mut axes: [Option<Scalarized<T>>; 6] = [None; 6];
        // Velocity first: it is the tighter, and what it corrects helps the position's linearity.
        for (slot, axis) in axes.iter_mut().zip(velocity.into_iter().chain(position.map(Some))) {
            *slot = axis;
        }
        let report = self.take_in(fix.time, &axes, trace);
        self.learn_gps(&report);
        Ok(report)
    }

    /// Moves the learned size of the GPS errors, used where fixes state none, by what this fix's
    /// innovations were against what was expected of them.
    fn learn_gps(&mut self, report: &Report) {
        for axis in report.innovations() {
            let learned = match axis.channel {
                Channel::PositionNorth | Channel::PositionEast => &mut self.gps_learned[0],
                Channel::VelocityNorth | Channel::VelocityEast => &mut self.gps_learned[1],
                _ => continue,
            };
            let surprise = square(axis.normalised()).min(LEARNED_MOST);
            *learned *= 1.0 + self.config.gps.learning_rate * (surprise - 1.0);
            *learned = learned.clamp(LEARNED_LEAST, LEARNED_MOST);
        }
    }

    /// Splits a fix's one-sigma into what is white and what wanders, and sets the wandering states to
    /// match; the first fix opens them.
    fn gps_noise(&mut self, fix: &Fix) -> GpsNoise {
        let model = self.config.gps;
        let [learned_m, learned_mps] = self.gps_learned.map(libm::sqrt);
        let position = fix
            .position_sigma_m
            .map_or(model.position_sigma_m().map(|sigma| sigma * learned_m), Vector::to_array);
        let velocity = fix
            .velocity_sigma_mps
            .map_or(model.velocity_sigma_mps().map(|sigma| sigma * learned_mps), Vector::to_array);
        let split = |state: Option<usize>, share: f64, sigma: [f64; 3], floor: f64| {
            let slow = if state.is_some() { share } else { 0.0 };
            let white = sigma.map(|sigma| ((1.0 - slow * slow) * square(sigma)).max(square(floor)));
            ([slow * sigma[0].max(sigma[1]), slow * sigma[2]], white)
        };
        let ([position_h, position_v], position_variance) =
            split(L::GPS_POSITION, model.position_wander_share, position, model.position_floor_m);
        let ([velocity_h, velocity_v], velocity_variance) =
            split(L::GPS_VELOCITY, model.velocity_wander_share, velocity, model.velocity_floor_mps);
        if self.gps_wander.is_none() {
            if let Some(first) = L::GPS_POSITION {
                self.open(first, [position_h, position_h, position_v]);
            }
            if let Some(first) = L::GPS_VELOCITY {
                self.open(first, [velocity_h, velocity_h, velocity_v]);
            }
        }
        self.gps_wander = Some([position_h, position_v, velocity_h, velocity_v]);
        GpsNoise { position_variance, velocity_variance }
    }

    fn position_axes(&self, fix: &Fix, back: &LookBack, noise: &GpsNoise) -> [Scalarized<T>; 3] {
        let wander: Vector<Ned> =
            L::GPS_POSITION.map_or([0.0; 3], |first| self.block(first)).into();
        let arm_body = self.antenna_from_imu();
        let arm = back.state.body_to_ned * arm_body;
        let antenna = back.state.position.displaced(arm);
        let innovation = (fix.position.displacement_from(&antenna) - wander).to_array();
        // δz = δp − L δv − (∫ΔV × ) ψ − [arm ×] ψ, ψ then = ψ now + (∫C) δb_g.
        let arm_turn = skew(-arm.components()) * back.turn_s;
        let swing = back.state.body_to_ned * back.angular_rate_radps.cross(arm_body);
        let velocity = (back.state.velocity_mps + swing).to_array();
        core::array::from_fn(|axis| {
            let mut sensitivity = Sensitivity::default()
                .with(POSITION + axis, 1.0)
                .with(VELOCITY + axis, -back.age_s)
                .with_block(ATTITUDE, row(skew(-back.force_m - arm.components()), axis))
                .with_block(ACCEL_BIAS, row(back.turn_s * (-0.5 * back.age_s), axis))
                .with_block(GYRO_BIAS, row(arm_turn, axis));
            if let Some(first) = L::GPS_POSITION {
                sensitivity = sensitivity.with(first + axis, 1.0);
            }
            if let Some(state) = L::LATENCY {
                sensitivity = sensitivity.with(state, -velocity[axis]);
            }
            Scalarized {
                channel: [Channel::PositionNorth, Channel::PositionEast, Channel::PositionDown]
                    [axis],
                group: [
                    Group::HorizontalPosition,
                    Group::HorizontalPosition,
                    Group::VerticalPosition,
                ][axis],
                innovation: innovation[axis],
                noise: noise.position_variance[axis] + self.lag_noise(back.age_s, back.age_s),
                sensitivity,
            }
        })
    }

    fn velocity_axes(
        &self,
        fix: &Fix,
        back: &LookBack,
        noise: &GpsNoise,
    ) -> [Option<Scalarized<T>>; 3] {
        let wander: Vector<Ned> =
            L::GPS_VELOCITY.map_or([0.0; 3], |first| self.block(first)).into();
        let arm_body = self.antenna_from_imu();
        let body_to_ned = back.state.body_to_ned;
        let swing = body_to_ned * back.angular_rate_radps.cross(arm_body);
        let predicted = (back.state.velocity_mps + swing + wander).to_array();
        let measured = [
            fix.horizontal_velocity_mps.map(|velocity| velocity[0]),
            fix.horizontal_velocity_mps.map(|velocity| velocity[1]),
            fix.down_velocity_mps,
        ];
        // δz = δv + [ΔV ×] ψ + (∫C) δb_a − [swing ×] ψ + C [arm ×] δb_g.
        let attitude = skew(back.force_mps - swing.components());
        let gyro = body_to_ned.matrix() * skew(arm_body.components());
        core::array::from_fn(|axis| {
            let mut sensitivity = Sensitivity::default()
                .with(VELOCITY + axis, 1.0)
                .with_block(ATTITUDE, row(attitude, axis))
                .with_block(ACCEL_BIAS, row(back.turn_s, axis))
                .with_block(GYRO_BIAS, row(gyro, axis));
            if let Some(first) = L::GPS_VELOCITY {
                sensitivity = sensitivity.with(first + axis, 1.0);
            }
            Some(Scalarized {
                channel: [Channel::VelocityNorth, Channel::VelocityEast, Channel::VelocityDown]
                    [axis],
                group: [
                    Group::HorizontalVelocity,
                    Group::HorizontalVelocity,
                    Group::VerticalVelocity,
                ][axis],
                innovation: measured[axis]? - predicted[axis],
                noise: noise.velocity_variance[axis] + self.lag_noise(back.age_s, 1.0),
                sensitivity,
            })
        })
    }

    /// Variance that the inertial sensors' noise added to velocity over `age_s`, times the square of
    /// `lever`.
    fn lag_noise(&self, age_s: f64, lever: f64) -> f64 {
        square(self.config.imu.velocity_random_walk_mps) * age_s.max(0.0) * square(lever)
    }

    fn antenna_from_imu(&self) -> Vector<Body> {
        self.config.antenna_lever_arm_m - self.config.imu_lever_arm_m
    }

    /// Takes in an attitude from elsewhere, the unit's own: roll, pitch and heading from true north.
    ///
    /// # Errors
    /// [`Unusable`] when it cannot be compared, or comes too soon after the last one used.
    pub fn update_attitude(
        &mut self,
        time: Time,
        reference: Rotation<Body, Ned>,
        trace: &mut impl Trace<T, N>,
    ) -> Result<Report, Unusable> {
        let heading = self.state.body_to_ned.euler().yaw_rad;
        let (sin, cos) = libm::sincos(heading);
        let axes = [
            (Channel::Roll, [cos, sin, 0.0], [cos, sin, 0.0]),
            (Channel::Pitch, [-sin, cos, 0.0], [-sin, cos, 0.0]),
            (Channel::Yaw, DOWN, DOWN),
        ];
        self.update_reference(time, reference, &axes, trace)
    }

    /// Takes in a magnetic field, gauss: heading from magnetic north, `declination_rad` east of true
    /// north, levelled by the filter's own roll and pitch.
    ///
    /// # Errors
    /// [`Unusable`] when it cannot be compared, or comes too soon after the last one used.
    pub fn update_magnetic_heading(
        &mut self,
        time: Time,
        field_gauss: Vector<Body>,
        declination_rad: f64,
        trace: &mut impl Trace<T, N>,
    ) -> Result<Report, Unusable> {
        let field = self.state.body_to_ned * field_gauss;
        let horizontal = libm::hypot(field.x(), field.y());
        if !(field.is_finite() && horizontal > 0.02 * field.norm()) {
            return Err(Unusable::NotFinite);
        }
        let error = libm::atan2(field.y(), field.x()) - declination_rad;
        let turn = Vector::new(0.0, 0.0, -error);
        let reference = self.state.body_to_ned.turned_in_to(turn);
        // Levelled by an attitude that is off by ψ, the field's dip turns its horizontal part.
        let dip = field.z() / horizontal;
        let seen = [-dip * field.x() / horizontal, -dip * field.y() / horizontal, 1.0];
        self.update_reference(time, reference, &[(Channel::Yaw, seen, DOWN)], trace)
    }

    /// Compares a reference about some axes: each with its channel, its sensitivity to the attitude
    /// error, and the direction of the innovation, which is also its sensitivity to the slow error.
    fn update_reference(
        &mut self,
        time: Time,
        reference: Rotation<Body, Ned>,
        axes: &[(Channel, [f64; 3], [f64; 3])],
        trace: &mut impl Trace<T, N>,
    ) -> Result<Report, Unusable> {
        let first = L::ATTITUDE_REFERENCE.ok_or(Unusable::NoState)?;
        if !reference.quaternion().is_finite() {
            return Err(Unusable::NotFinite);
        }
        let model = self.config.attitude;
        if self.attitude_used.is_some_and(|used| time - used < model.interval_s) {
            return Err(Unusable::TooSoon);
        }
        self.attitude_used = Some(time);
        let error = (reference * self.state.body_to_ned.inverse()).rotation_vector();
        let wander: Vector<Ned> = self.block(first).into();
        let left = error - wander;
        let mut scalars: [Option<Scalarized<T>>; 6] = [None; 6];
        for (slot, &(channel, seen, direction)) in scalars.iter_mut().zip(axes) {
            *slot = Some(Scalarized {
                channel,
                group: Group::Attitude,
                innovation: left.dot(direction.into()),
                noise: square(model.noise_rad),
                sensitivity: Sensitivity::default()
                    .with_block(ATTITUDE, seen)
                    .with_block(first, direction),
            });
        }
        Ok(self.take_in(time, &scalars, trace))
    }

    /// Takes in a barometric height, m, above any fixed level: the first one sets the level.
    ///
    /// # Errors
    /// [`Unusable`] when it cannot be compared.
    pub fn update_baro(
        &mut self,
        time: Time,
        height_m: f64,
        trace: &mut impl Trace<T, N>,
    ) -> Result<Report, Unusable> {
        let state = L::BARO.ok_or(Unusable::NoState)?;
        if !height_m.is_finite() || libm::fabs(height_m) > HIGHEST_M {
            return Err(Unusable::NotFinite);
        }
        let own_m = self.state.position.height_m;
        let offset_m = *self.baro_offset_m.get_or_insert(height_m - own_m);
        let mut scalars: [Option<Scalarized<T>>; 6] = [None; 6];
        scalars[0] = Some(Scalarized {
            channel: Channel::BaroHeight,
            group: Group::Baro,
            innovation: height_m - offset_m - own_m - self.parameter(state),
            noise: square(self.config.baro.noise_m),
            sensitivity: Sensitivity::default().with(POSITION + 2, -1.0).with(state, 1.0),
        });
        Ok(self.take_in(time, &scalars, trace))
    }

    /// Compares, gates, corrects: axis after axis, each group refused or taken as a whole.
    fn take_in(
        &mut self,
        time: Time,
        axes: &[Option<Scalarized<T>>; 6],
        trace: &mut impl Trace<T, N>,
    ) -> Report {
        let mut report = Report::default();
        let mut correction = [T::ZERO; N];
        let mut done: Option<Group> = None;
        for axis in axes.iter().flatten() {
            if done == Some(axis.group) {
                continue;
            }
            done = Some(axis.group);
            let group = || axes.iter().flatten().filter(|other| other.group == axis.group);
            let fits = group().all(|axis| {
                let variance =
                    self.covariance.projected_variance(&axis.sensitivity).wide().max(0.0);
                let innovation = axis.innovation - axis.sensitivity.dot(&correction).wide();
                square(innovation) <= square(self.config.gate.sigmas) * (variance + axis.noise)
            });
            let verdict = if fits {
                self.lockouts.accepted(axis.group);
                Verdict::Accepted
            } else if self.lockouts.refused(axis.group, time, self.config.gate.lockout_s) {
                for axis in group() {
                    self.reopen(axis);
                }
                Verdict::Reopened
            } else {
                Verdict::Rejected
            };
            for axis in group() {
                report.push(self.take_axis(time, axis, verdict, &mut correction, trace));
            }
        }
        self.correct(&correction);
        report
    }

    /// P Hᵀ and H P Hᵀ of an axis; where rounding made the latter negative, which takes a covariance
    /// that gaps have opened beyond all bounds, the axis sees nothing.
    fn seen(&self, axis: &Scalarized<T>) -> ([T; N], T) {
        let (projected, variance) = self.covariance.project(&axis.sensitivity);
        if variance >= T::ZERO { (projected, variance) } else { ([T::ZERO; N], T::ZERO) }
    }

    fn take_axis(
        &mut self,
        time: Time,
        axis: &Scalarized<T>,
        verdict: Verdict,
        correction: &mut [T; N],
        trace: &mut impl Trace<T, N>,
    ) -> Innovation {
        let (projected, variance) = self.seen(axis);
        let left = axis.innovation - axis.sensitivity.dot(correction).wide();
        if verdict != Verdict::Rejected {
            let noise = T::of(axis.noise);
            let gain = self.covariance.update(&axis.sensitivity, &projected, variance, noise);
            for (value, &factor) in correction.iter_mut().zip(&gain.gain) {
                *value += factor * T::of(left);
            }
            trace.updated(&axis.sensitivity, &gain, left);
        }
        Innovation {
            time,
            channel: axis.channel,
            innovation: left,
            sigma: libm::sqrt(variance.wide() + axis.noise),
            verdict,
        }
    }

    /// Opens the states an axis speaks of by the size of its innovation.
    fn reopen(&mut self, axis: &Scalarized<T>) {
        let opened = square(axis.innovation);
        match axis.channel {
            Channel::PositionNorth => self.covariance.add_variance(POSITION, opened),
            Channel::PositionEast => self.covariance.add_variance(POSITION + 1, opened),
            Channel::PositionDown => self.covariance.add_variance(POSITION + 2, opened),
            Channel::VelocityNorth | Channel::VelocityEast | Channel::VelocityDown => {
                let state = match axis.channel {
                    Channel::VelocityNorth => VELOCITY,
                    Channel::VelocityEast => VELOCITY + 1,
                    _ => VELOCITY + 2,
                };
                self.covariance.add_variance(state, opened);
                // A velocity this far off came through the attitude.
                self.covariance.add_variance(ATTITUDE, square(REOPENED_TILT_RAD));
                self.covariance.add_variance(ATTITUDE + 1, square(REOPENED_TILT_RAD));
                self.covariance.add_variance(ATTITUDE + 2, square(REOPENED_HEADING_RAD));
            }
            Channel::Roll | Channel::Pitch | Channel::Yaw => {
                for state in 0..3 {
                    self.covariance.add_variance(ATTITUDE + state, opened);
                }
            }
            Channel::BaroHeight => {
                if let Some(state) = L::BARO {
                    self.covariance.add_variance(state, opened);
                }
            }
        }
    }
}

const REOPENED_TILT_RAD: f64 = 0.05;
const REOPENED_HEADING_RAD: f64 = 0.3;

/// [v ×]: the matrix whose product with w is v × w.
fn skew(v: DVec3) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(0.0, v.z, -v.y),
        DVec3::new(-v.z, 0.0, v.x),
        DVec3::new(v.y, -v.x, 0.0),
    )
}

fn row(matrix: DMat3, index: usize) -> [f64; 3] {
    let columns = matrix.to_cols_array_2d();
    columns.map(|column| column.get(index).copied().unwrap_or(0.0))
}

#[cfg(test)]
mod tests;
