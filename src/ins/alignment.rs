//! Alignment: the first attitude, velocity and position, and how sure they are.
//!
//! Position and velocity come from the first fix. Roll and pitch come from the unit's own attitude
//! where it has one, else from levelling on the mean specific force, which on a moving vehicle is
//! off by its acceleration over g; both are given the uncertainty to match, so a vehicle already in
//! flight aligns like one at rest, only less surely. Gyro bias is measured when the vehicle is at
//! rest. Heading has the source that the configuration or the sensors allow; with none it stays
//! open, for the filter to find in motion.

use crate::event::Event;
use crate::frames::{Body, EulerAngles, Ned, Rotation, Vector, wrap_angle};
use crate::gps::{AntennaHeading, Fix};
use crate::imu::{ImuSample, MeanRates, SecondDifference, Vibration, noise_variance};
use crate::ins::{Mounting, NavState};
use crate::scalar::Scalar;
use crate::time::Time;

/// Where the first heading comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(rename_all = "lowercase")
)]
pub enum HeadingSource {
    /// Two GPS antennas.
    #[cfg_attr(feature = "serde", serde(rename = "second_antenna"))]
    SecondAntenna,
    /// The unit's own attitude.
    Attitude,
    /// The magnetometer, levelled, and the declination.
    Magnetometer,
    /// The course over ground; only for vehicles that point where they go.
    Course,
    /// Nothing: found in motion.
    Unknown,
}

/// Settings of the alignment.
///
/// To change some, take the default and assign to its fields, or use the methods that take it over.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct AlignmentConfig {
    /// The one source of heading to use; `None` takes the first there is of two antennas, attitude,
    /// magnetometer, nothing. Course is only used when named.
    pub heading: Option<HeadingSource>,
    /// The second GPS antenna from the first, body axes, m; `None` where the receiver tells the heading of
    /// the vehicle itself.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub baseline_m: Option<Vector<Body>>,
    /// Length of inertial data needed, s.
    pub duration_s: f64,
    /// What to add to the unit's yaw for true heading: the declination where it is magnetic, rad.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub attitude_declination_rad: f64,
    /// Magnetic declination, east positive, rad, for the magnetometer.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub declination_rad: f64,
    /// One-sigma of the unit's own roll and pitch, rad.
    pub attitude_tilt_sigma_rad: f64,
    /// One-sigma of the unit's own or the magnetic heading, rad.
    pub heading_sigma_rad: f64,
    /// One-sigma of levelling at rest, rad: the accelerometer bias over g.
    pub level_sigma_rad: f64,
    /// One-sigma of levelling in motion, rad.
    pub moving_level_sigma_rad: f64,
    /// One-sigma of position and velocity where the fix does not say, m and m/s.
    pub position_sigma_m: f64,
    /// See `position_sigma_m`.
    pub velocity_sigma_mps: f64,
    /// Speed at which the course gives the heading, m/s.
    pub course_speed_mps: f64,
}

impl Default for AlignmentConfig {
    fn default() -> Self {
        Self {
            heading: None,
            baseline_m: None,
            duration_s: 1.0,
            attitude_declination_rad: 0.0,
            declination_rad: 0.0,
            attitude_tilt_sigma_rad: 1.5f64.to_radians(),
            heading_sigma_rad: 4f64.to_radians(),
            level_sigma_rad: 1f64.to_radians(),
            moving_level_sigma_rad: 4f64.to_radians(),
            position_sigma_m: 1.5,
            velocity_sigma_mps: 0.5,
            course_speed_mps: 3.0,
        }
    }
}

impl AlignmentConfig {
    /// With `heading` as the only source of heading.
    #[must_use]
    pub const fn with_heading(mut self, heading: HeadingSource) -> Self {
        self.heading = Some(heading);
        self
    }

    /// With the second GPS antenna at `baseline_m` from the first, body axes, m.
    #[must_use]
    pub const fn with_baseline_m(mut self, baseline_m: Vector<Body>) -> Self {
        self.baseline_m = Some(baseline_m);
        self
    }

    /// With `duration_s` seconds of inertial data.
    #[must_use]
    pub const fn with_duration_s(mut self, duration_s: f64) -> Self {
        self.duration_s = duration_s;
        self
    }

    /// With a magnetic declination, east positive, rad: of the magnetometer, and of the unit's own yaw
    /// where `attitude_is_magnetic`.
    #[must_use]
    pub const fn with_declination_rad(
        mut self,
        declination_rad: f64,
        attitude_is_magnetic: bool,
    ) -> Self {
        self.declination_rad = declination_rad;
        self.attitude_declination_rad = if attitude_is_magnetic { declination_rad } else { 0.0 };
        self
    }
}

/// What a filter starts from: the end of alignment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Position, velocity and attitude of the inertial unit.
    pub state: NavState,
    /// One-sigma of the attitude error about north, east and down, rad.
    pub attitude_sigma_rad: Vector<Ned>,
    /// One-sigma of velocity, m/s.
    pub velocity_sigma_mps: Vector<Ned>,
    /// One-sigma of position, m.
    pub position_sigma_m: Vector<Ned>,
    /// Gyro bias, rad/s.
    pub gyro_bias_radps: Vector<Body>,
    /// One-sigma of the gyro bias, rad/s, where alignment measured it; else the configured one.
    pub gyro_bias_sigma_radps: Option<f64>,
}

/// How an alignment came about.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Alignment {
    /// What the filter starts from.
    pub start: Start,
    /// Where the heading comes from.
    pub heading: HeadingSource,
    /// Whether roll and pitch are the unit's own; else they were levelled.
    pub attitude_given: bool,
    /// Whether the vehicle was at rest, so that the gyro bias could be measured.
    pub at_rest: bool,
    /// Inertial data it rests on, s.
    pub duration_s: f64,
}

/// Collects events until they make an alignment.
#[derive(Clone, Debug)]
pub struct Aligner {
    config: AlignmentConfig,
    mounting: Mounting,
    window: Window,
    attitude: Option<EulerAngles>,
    field_gauss: Option<Vector<Body>>,
    antenna_heading: Option<AntennaHeading>,
}

/// Running means of the inertial samples since the window began.
#[derive(Clone, Copy, Debug, Default)]
struct Window {
    first: Option<Time>,
    last: Option<Time>,
    count: f64,
    rate: Vector<Body>,
    force: Vector<Body>,
    rate_variance: f64,
    force_change: SecondDifference<f64>,
    force_vibration: Vibration,
}

/// Windows longer than this start anew, s: the vehicle may have moved since.
const LONGEST_WINDOW_S: f64 = 5.0;
/// Samples further apart than this, s, do not belong to one window.
const LONGEST_GAP_S: f64 = 0.5;
/// A fix further than this, s, from the last inertial sample does not end the alignment.
pub(crate) const ALIGNABLE_S: f64 = 2.0;
/// At rest: GPS speed, m/s; mean rate, rad/s; scatter of the rate, rad/s; vibration, m/s².
const REST_SPEED_MPS: f64 = 0.25;
const REST_RATE_RADPS: f64 = 0.02;
const REST_RATE_SCATTER_RADPS: f64 = 0.06;
const REST_VIBRATION_MPS2: f64 = 0.3;
/// One-sigma of an angle that could be any.
const ANY_ANGLE_RAD: f64 = core::f64::consts::PI / 1.732_050_807_568_877_2;

impl Window {
    fn push(&mut self, sample: &ImuSample, longest_s: f64) {
        let Some(last) = self.last else {
            self.first = Some(sample.time);
            self.last = Some(sample.time);
            return;
        };
        let interval_s = sample.time - last;
        // A clock that was set back would let no sample in any more.
        let out_of_order = (-LONGEST_GAP_S..=0.0).contains(&interval_s);
        if out_of_order || !sample.motion.is_finite() {
            return;
        }
        let is_torn = libm::fabs(interval_s) > LONGEST_GAP_S;
        if is_torn || self.first.is_some_and(|first| last - first > longest_s) {
            *self = Self { first: Some(sample.time), last: Some(sample.time), ..Self::default() };
            return;
        }
        let MeanRates { angular_rate_radps: rate, specific_force_mps2: force } =
            sample.motion.mean_rates(interval_s);
        self.last = Some(sample.time);
        self.count += 1.0;
        let off = rate - self.rate;
        self.rate += off * (1.0 / self.count);
        self.force += (force - self.force) * (1.0 / self.count);
        self.rate_variance += (off.dot(rate - self.rate) - self.rate_variance) / self.count;
        if let Some(change) = self.force_change.push(force) {
            self.force_vibration.push(noise_variance(change), interval_s);
        }
    }

    fn length_s(&self) -> f64 {
        match (self.first, self.last) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    fn is_at_rest(&self) -> bool {
        let vibration = self.force_vibration.variance().iter().fold(0.0, |a: f64, &b| a.max(b));
        self.rate.norm() < REST_RATE_RADPS
            && self.rate_variance < REST_RATE_SCATTER_RADPS * REST_RATE_SCATTER_RADPS
            && vibration < REST_VIBRATION_MPS2 * REST_VIBRATION_MPS2
    }
}

impl Aligner {
    /// An aligner that has seen nothing yet.
    #[must_use]
    pub fn new(config: AlignmentConfig, mounting: Mounting) -> Self {
        Self {
            config,
            mounting,
            window: Window::default(),
            attitude: None,
            field_gauss: None,
            antenna_heading: None,
        }
    }

    /// The settings.
    #[must_use]
    pub const fn config(&self) -> &AlignmentConfig {
        &self.config
    }

    /// Takes in the next event; `Some` ends the alignment, always on a fix, with a start at the time
    /// of the last inertial sample. A fix that is not finite or finds too little inertial data is
    /// passed over.
    pub fn push(&mut self, event: &Event) -> Option<Alignment> {
        match event {
            Event::Imu(sample) => {
                // Twice what is needed, so that a fix meets a window that is long enough.
                let longest_s = LONGEST_WINDOW_S.max(2.0 * self.config.duration_s);
                self.window.push(sample, longest_s);
                self.attitude =
                    sample.attitude.filter(|angles| angles.is_finite()).or(self.attitude);
                self.field_gauss = sample
                    .magnetic_field_gauss
                    .filter(|field| field.is_finite())
                    .or(self.field_gauss);
                None
            }
            Event::Magnetometer { field_gauss, .. } => {
                if field_gauss.is_finite() {
                    self.field_gauss = Some(*field_gauss);
                }
                None
            }
            Event::Gps(fix) => self.align(fix),
            Event::AntennaHeading(heading) => {
                if heading.is_finite() {
                    self.antenna_heading = Some(*heading);
                }
                None
            }
            Event::Baro { .. } | Event::Range(_) => None,
        }
    }

    /// Heading by the two antennas at a given roll and pitch, and its one-sigma, rad, where they told one
    /// of late.
    fn antenna_heading(&self, time: Time, tilt: EulerAngles) -> Option<(f64, f64)> {
        let found = self.antenna_heading.filter(|found| libm::fabs(time - found.time) < 1.0)?;
        let level: Rotation<Body, Ned> = Rotation::from_euler(EulerAngles { yaw_rad: 0.0, ..tilt });
        let baseline = self.config.baseline_m.unwrap_or(Vector::new(1.0, 0.0, 0.0));
        let sigma_rad = found.sigma_rad.unwrap_or(0.0).max(LEAST_ANTENNA_SIGMA_RAD);
        Some((found.heading_rad - (level * baseline).azimuth_rad(), sigma_rad))
    }

    /// Whether a sample of `time` is not later than the last.
    pub(crate) fn is_late(&self, time: Time) -> bool {
        self.window.last.is_some_and(|last| time <= last)
    }

    /// How much older than the last inertial sample a fix is, s; `None` before the first sample.
    pub(crate) fn age_s(&self, fix: &Fix) -> Option<f64> {
        self.window.last.map(|last| last - fix.time)
    }

    /// Equation (A3) of docs/equations.md.
    fn align(&self, fix: &Fix) -> Option<Alignment> {
        let config = &self.config;
        let time = self.window.last?;
        let age_s = self.age_s(fix)?;
        let is_far = libm::fabs(age_s) > ALIGNABLE_S;
        let unusable = !fix.is_finite() || fix.two_dimensional || is_far;
        if self.window.length_s() < config.duration_s || unusable {
            return None;
        }
        let speed = fix.horizontal_velocity_mps.map(|[north, east]| Scalar::hypot(north, east));
        let at_rest = self.window.is_at_rest() && speed.is_none_or(|speed| speed < REST_SPEED_MPS);
        let allowed = |source| config.heading.is_none_or(|only| only == source);

        let levelled = level(self.window.force);
        let given = self.attitude.map(|angles| EulerAngles {
            yaw_rad: angles.yaw_rad + config.attitude_declination_rad,
            ..angles
        });
        let tilt = given.unwrap_or(levelled);
        let tilt_sigma = match given {
            Some(_) => config.attitude_tilt_sigma_rad,
            None if at_rest => config.level_sigma_rad,
            None => config.moving_level_sigma_rad,
        };
        let (heading, yaw_rad, yaw_sigma) = if let Some(found) =
            self.antenna_heading(time, tilt).filter(|_| allowed(HeadingSource::SecondAntenna))
        {
            (HeadingSource::SecondAntenna, found.0, found.1)
        } else if let Some(given) = given.filter(|_| allowed(HeadingSource::Attitude)) {
            (HeadingSource::Attitude, given.yaw_rad, config.heading_sigma_rad)
        } else if let Some(yaw) = self
            .field_gauss
            .filter(|_| allowed(HeadingSource::Magnetometer))
            .and_then(|field| magnetic_heading(field, tilt))
        {
            let yaw = yaw + config.declination_rad;
            (HeadingSource::Magnetometer, yaw, config.heading_sigma_rad + tilt_sigma)
        } else if config.heading == Some(HeadingSource::Course) {
            let [north, east] = fix.horizontal_velocity_mps?;
            if Scalar::hypot(north, east) < config.course_speed_mps {
                return None;
            }
            (HeadingSource::Course, libm::atan2(east, north), config.heading_sigma_rad)
        } else {
            (HeadingSource::Unknown, 0.0, ANY_ANGLE_RAD)
        };
        let body_to_ned =
            Rotation::from_euler(EulerAngles { yaw_rad: wrap_angle(yaw_rad), ..tilt });

        let gyro_bias = if at_rest { self.window.rate } else { Vector::ZERO };
        let rate = self.window.rate - gyro_bias;
        let imu_from_antenna = self.mounting.imu_from_antenna();
        let [north, east] = fix.horizontal_velocity_mps.unwrap_or_default();
        let antenna_velocity = Vector::new(north, east, fix.down_velocity_mps.unwrap_or(0.0));
        let velocity_mps = imu_from_antenna.velocity(antenna_velocity, body_to_ned, rate);
        let position =
            imu_from_antenna.position(&fix.position, body_to_ned).displaced(velocity_mps * age_s);
        let state = NavState { time, position, velocity_mps, body_to_ned };
        if !state.is_valid() {
            return None;
        }

        // A level attitude ages with the acceleration that may have gone on since the fix.
        let unknown = |known: bool, sigma: f64| if known { sigma } else { 5.0 + 2.0 * sigma };
        let velocity_sigma = fix
            .axes_velocity_sigma_mps()
            .unwrap_or(Vector::new(1.0, 1.0, 2.0) * config.velocity_sigma_mps)
            .to_array();
        let velocity_sigma_mps = Vector::new(
            unknown(fix.horizontal_velocity_mps.is_some(), velocity_sigma[0]),
            unknown(fix.horizontal_velocity_mps.is_some(), velocity_sigma[1]),
            unknown(fix.down_velocity_mps.is_some(), velocity_sigma[2]),
        );
        let aged = Vector::new(1.0, 1.0, 1.0) * libm::fabs(age_s);
        Some(Alignment {
            start: Start {
                state,
                attitude_sigma_rad: Vector::new(tilt_sigma, tilt_sigma, yaw_sigma),
                velocity_sigma_mps: velocity_sigma_mps + aged,
                position_sigma_m: fix
                    .position_sigma_m
                    .unwrap_or(Vector::new(1.0, 1.0, 2.0) * config.position_sigma_m)
                    + aged,
                gyro_bias_radps: gyro_bias,
                gyro_bias_sigma_radps: at_rest.then(|| {
                    let scatter = Scalar::sqrt(self.window.rate_variance.max(0.0));
                    (scatter / Scalar::sqrt(self.window.length_s().max(1.0) * 3.0))
                        .max(REST_BIAS_RADPS)
                }),
            },
            heading,
            attitude_given: given.is_some(),
            at_rest,
            duration_s: self.window.length_s(),
        })
    }
}

/// Least one-sigma of a heading of two antennas at the start, rad: the vehicle may have turned since.
const LEAST_ANTENNA_SIGMA_RAD: f64 = 0.02;

/// Least one-sigma of a gyro bias measured at rest, rad/s (0.03°/s).
const REST_BIAS_RADPS: f64 = 5e-4;

/// Roll and pitch by which the mean specific force points straight up (Groves 5.101).
///
/// # Source
/// Equation (A1) of docs/equations.md.
fn level(force: Vector<Body>) -> EulerAngles {
    let [x, y, z] = force.to_array();
    EulerAngles {
        roll_rad: libm::atan2(-y, -z),
        pitch_rad: libm::atan2(x, Scalar::hypot(y, z)),
        yaw_rad: 0.0,
    }
}

/// Heading from magnetic north of a field in body axes at a given roll and pitch; `None` where the
/// horizontal field is under 2 % of the whole.
///
/// # Source
/// Equation (A2) of docs/equations.md.
fn magnetic_heading(field: Vector<Body>, tilt: EulerAngles) -> Option<f64> {
    let level = Rotation::from_euler(EulerAngles { yaw_rad: 0.0, ..tilt });
    let field: Vector<Ned> = level * field;
    let horizontal = Scalar::hypot(field.x(), field.y());
    (horizontal > 0.02 * field.norm()).then(|| -libm::atan2(field.y(), field.x()))
}
