//! Alignment: the first attitude, velocity and position, and their uncertainty.
//!
//! Position and velocity come from the first fix. Roll and pitch come from the inertial unit's own attitude, if it
//! computes one, otherwise from levelling on the mean specific force. A vehicle that accelerates cannot be levelled:
//! the change of velocity from fix to fix gives the direction of its specific force. Every result has a matching
//! uncertainty, so a vehicle in flight aligns like one at rest, only less accurately. Gyro bias is measured when the
//! vehicle is at rest. Heading comes from the source that configuration and sensors allow. Without a source it stays
//! unknown until the filter finds it in motion.

mod orientation;
mod pull;

use crate::earth::STANDARD_GRAVITY_MPS2;
use crate::event::{Event, MagneticReading};
use crate::frames::{Body, EulerAngles, Ned, Vector};
use crate::gps::Fix;
use crate::imu::{ImuSample, MeanRates, SecondDifference, Vibration, noise_variance};
use crate::ins::{Mounting, NavState};
use crate::scalar::Scalar;
use crate::time::Time;
use pull::SinceFix;

/// Source of the first heading.
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
    /// The attitude computed by the inertial unit.
    Attitude,
    /// The magnetometer, with tilt from levelling, and the declination.
    Magnetometer,
    /// The course over ground; only for vehicles whose nose points along their course.
    Course,
    /// No source: the heading is found in motion.
    Unknown,
}

/// Settings of the alignment.
///
/// To change some settings, write them before `..Default::default()`, or use the `with_` methods.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct AlignmentConfig {
    /// The only heading source to use. Without it, the first available source is used, in the order two antennas,
    /// attitude, magnetometer, unknown. Course is used only if named here.
    pub heading: Option<HeadingSource>,
    /// Vector from the first GPS antenna to the second, body axes, m. `None` if the receiver reports the heading of the
    /// vehicle itself.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub baseline_m: Option<Vector<Body>>,
    /// Required length of inertial data, s.
    pub duration_s: f64,
    /// Angle to add to the inertial unit's yaw for true heading, rad: the declination if its yaw is magnetic.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub attitude_declination_rad: f64,
    /// Magnetic declination, east positive, rad, for the magnetometer.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub declination_rad: f64,
    /// One-sigma of the inertial unit's own roll and pitch, rad.
    pub attitude_tilt_sigma_rad: f64,
    /// One-sigma of the inertial unit's own heading or of the magnetic heading, rad.
    pub heading_sigma_rad: f64,
    /// One-sigma of levelling at rest, rad: the accelerometer bias divided by gravity.
    pub level_sigma_rad: f64,
    /// One-sigma of levelling in motion, rad.
    pub moving_level_sigma_rad: f64,
    /// One-sigma of position, used where a fix states no accuracy of its own, m.
    pub position_sigma_m: f64,
    /// One-sigma of velocity, used where a fix states no accuracy of its own, m/s.
    pub velocity_sigma_mps: f64,
    /// Minimum speed at which the course gives the heading, m/s.
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

/// Initial state of a filter: the result of alignment.
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
    /// One-sigma of the gyro bias, rad/s, if alignment measured it; `None` for the configured one.
    pub gyro_bias_sigma_radps: Option<f64>,
}

/// Result of an alignment, and its sources.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Alignment {
    /// Initial state of the filter.
    pub start: Start,
    /// Source of the heading.
    pub heading: HeadingSource,
    /// Whether roll and pitch come from the inertial unit's own attitude; otherwise from levelling.
    pub attitude_given: bool,
    /// Whether the vehicle was at rest, so that the gyro bias could be measured.
    pub at_rest: bool,
    /// Length of the inertial data used, s.
    pub duration_s: f64,
    /// Unit vector about which the attitude is unknown without a heading. It points down, or opposite to the specific
    /// force for a vehicle that accelerates.
    pub axis: Vector<Ned>,
}

/// Collects events until they give an alignment.
#[derive(Clone, Debug)]
pub struct Aligner {
    config: AlignmentConfig,
    mounting: Mounting,
    window: Window,
    attitude: Option<EulerAngles>,
    field_gauss: Option<Vector<Body>>,
    /// Time, value, rad, and one-sigma, rad, of the last two-antenna heading.
    antenna_heading: Option<(Time, f32, f32)>,
    /// Time of the first fix in the present run of fixes without a height; [`NEVER`] if the last fix had a height.
    heightless_since: Time,
}

/// Running means of the inertial samples since the start of the window.
#[derive(Clone, Copy, Debug, Default)]
struct Window {
    /// Times of the window's first and last sample.
    span: Option<(Time, Time)>,
    count: u32,
    since_fix: SinceFix,
    rate: Vector<Body>,
    force: Vector<Body>,
    rate_variance: f64,
    force_change: SecondDifference<f64>,
    force_vibration: Vibration,
}

/// Longest window, s.
const LONGEST_WINDOW_S: f64 = 5.0;
/// Longest gap between samples of one window, s.
const LONGEST_GAP_S: f64 = 0.5;
/// Largest time between a fix and the last inertial sample, s, for the fix to end the alignment.
pub(crate) const ALIGNABLE_S: f64 = 2.0;
/// Later than every possible time.
const NEVER: Time = Time::from_nanoseconds(i64::MAX);
/// Time, s, for which fixes without a height are skipped before one of them ends the alignment.
const HEIGHT_WAIT_S: f64 = 10.0;
/// One-sigma of a height without a measurement, m: aircraft altitudes lie within three one-sigmas.
pub(crate) const UNKNOWN_HEIGHT_M: f64 = 1000.0;
/// Largest GPS speed at rest, m/s.
const REST_SPEED_MPS: f64 = 0.25;
/// Largest mean rate at rest, rad/s.
const REST_RATE_RADPS: f64 = 0.02;
/// Largest scatter of the rate at rest, rad/s.
const REST_RATE_SCATTER_RADPS: f64 = 0.06;
/// Largest vibration at rest, m/s².
const REST_VIBRATION_MPS2: f64 = 0.3;
/// Largest difference of the mean force from gravity in steady motion, m/s². A larger one is a manoeuvre.
const MANOEUVRE_MPS2: f64 = 0.7;
/// Largest turn rate in steady motion, rad/s. A faster turn is a manoeuvre.
const MANOEUVRE_RADPS: f64 = 0.15;

impl Window {
    fn push<const WEIGH: bool>(&mut self, sample: &ImuSample, longest_s: f64) {
        let restarted = Self { span: Some((sample.time, sample.time)), ..Self::default() };
        let Some((first, last)) = self.span else {
            *self = restarted;
            return;
        };
        let interval_s = sample.time - last;
        // A clock set back by more than [`LONGEST_GAP_S`] must restart the window; otherwise it would reject every
        // later sample.
        let out_of_order = (-LONGEST_GAP_S..=0.0).contains(&interval_s);
        if out_of_order || !sample.motion.is_finite() {
            return;
        }
        if libm::fabs(interval_s) > LONGEST_GAP_S {
            *self = restarted;
            return;
        }
        let mean = sample.motion.mean_rates(interval_s);
        if WEIGH {
            self.since_fix.observe_sample(mean, interval_s);
        }
        // A full window halves its count and length: old samples lose weight, and a fix still finds a long window.
        let is_long = last - first > longest_s;
        let first = if is_long { last + (-0.5 * longest_s) } else { first };
        self.count /= if is_long { 2 } else { 1 };
        let MeanRates { angular_rate_radps: rate, specific_force_mps2: force } = mean;
        self.span = Some((first, sample.time));
        self.count = self.count.saturating_add(1);
        let count = f64::from(self.count);
        let off = rate - self.rate;
        self.rate += off * (1.0 / count);
        self.force += (force - self.force) * (1.0 / count);
        self.rate_variance += (off.dot(rate - self.rate) - self.rate_variance) / count;
        if let Some(change) = self.force_change.push(force) {
            self.force_vibration.push(noise_variance(change), interval_s);
        }
    }

    fn last(&self) -> Option<Time> {
        self.span.map(|(_, last)| last)
    }

    fn length_s(&self) -> f64 {
        self.span.map_or(0.0, |(first, last)| last - first)
    }

    /// Whether turn rate or force exceed those of steady motion.
    fn is_manoeuvring(&self) -> bool {
        let beyond = libm::fabs(self.force.norm() - STANDARD_GRAVITY_MPS2);
        beyond > MANOEUVRE_MPS2 || self.rate.norm() > MANOEUVRE_RADPS
    }

    fn is_at_rest(&self) -> bool {
        let vibration = self.force_vibration.variance().iter().fold(0.0, |a: f64, &b| a.max(b));
        self.rate.norm() < REST_RATE_RADPS
            && self.rate_variance < REST_RATE_SCATTER_RADPS * REST_RATE_SCATTER_RADPS
            && vibration < REST_VIBRATION_MPS2 * REST_VIBRATION_MPS2
    }
}

impl Aligner {
    /// An aligner without events yet.
    #[must_use]
    pub fn new(config: AlignmentConfig, mounting: Mounting) -> Self {
        Self {
            config,
            mounting,
            window: Window::default(),
            attitude: None,
            field_gauss: None,
            antenna_heading: None,
            heightless_since: NEVER,
        }
    }

    /// The settings.
    #[must_use]
    pub const fn config(&self) -> &AlignmentConfig {
        &self.config
    }

    /// Clears all collected data.
    pub(crate) fn restart(&mut self) {
        (self.window, self.attitude) = (Window::default(), None);
        (self.field_gauss, self.antenna_heading) = (None, None);
        self.heightless_since = NEVER;
    }

    /// Whether no recent fix exists from which a change of velocity could give the force.
    pub(crate) fn lacks_fix(&self) -> bool {
        self.window.since_fix.is_old()
    }

    /// Restarts at a fix, after the sample at `time`. A fix later by the required length of inertial data can then end
    /// the alignment.
    pub(crate) fn restart_at(&mut self, fix: &Fix, time: Time) {
        self.restart();
        self.window.span = Some((time + -BEFORE_S, time));
        self.window.since_fix = SinceFix::begin(fix);
    }

    /// Feeds the next event. `Some` ends the alignment, always on a fix, with a start at the time of the last inertial
    /// sample.
    ///
    /// A fix that is not finite, or comes with too little inertial data, is ignored. Fixes without a height are ignored
    /// until ten seconds passed without a height. The height of a start on such a fix is unknown, with a one-sigma of a
    /// kilometre.
    pub fn push(&mut self, event: &Event) -> Option<Alignment> {
        self.push_as::<true>(event)
    }

    /// [`push`](Self::push), by levelling alone unless `WEIGH`: without the acceleration from fixes, for programs with
    /// little memory.
    pub(crate) fn push_as<const WEIGH: bool>(&mut self, event: &Event) -> Option<Alignment> {
        match event {
            Event::Imu(sample) => {
                // Twice the required length, so that a fix meets a window that is long enough.
                let longest_s = LONGEST_WINDOW_S.max(2.0 * self.config.duration_s);
                self.window.push::<WEIGH>(sample, longest_s);
                self.attitude =
                    sample.attitude.filter(|angles| angles.is_finite()).or(self.attitude);
                self.field_gauss = sample
                    .magnetic_field_gauss
                    .filter(|field| field.is_finite())
                    .or(self.field_gauss);
                None
            }
            Event::Magnetometer(MagneticReading { field_gauss, .. }) => {
                if field_gauss.is_finite() {
                    self.field_gauss = Some(*field_gauss);
                }
                None
            }
            Event::Gps(fix) if fix.is_finite() => {
                self.heightless_since =
                    if fix.two_dimensional { self.heightless_since.min(fix.time) } else { NEVER };
                let alignment = self.align::<WEIGH>(fix);
                // The last fix is kept as long as it is usable. Over a longer time, the acceleration between two fixes
                // is more accurate.
                if WEIGH && alignment.is_none() && self.window.since_fix.is_old() {
                    self.window.since_fix = SinceFix::begin(fix);
                }
                alignment
            }
            Event::AntennaHeading(heading) => {
                if heading.is_finite() {
                    let sigma_rad = heading.sigma_rad.unwrap_or(0.0) as f32;
                    self.antenna_heading =
                        Some((heading.time, heading.heading_rad as f32, sigma_rad));
                }
                None
            }
            Event::Gps(_) | Event::Baro(_) | Event::Range(_) => None,
        }
    }

    /// Whether a sample at `time` is not later than the last one.
    pub(crate) fn is_late(&self, time: Time) -> bool {
        self.window.last().is_some_and(|last| time <= last)
    }

    /// Age of a fix relative to the last inertial sample, s; `None` before the first sample.
    pub(crate) fn age_s(&self, fix: &Fix) -> Option<f64> {
        self.window.last().map(|last| last - fix.time)
    }

    /// Equation (A3) of docs/equations.md.
    fn align<const WEIGH: bool>(&self, fix: &Fix) -> Option<Alignment> {
        let config = &self.config;
        let time = self.window.last()?;
        let age_s = self.age_s(fix)?;
        let is_far = libm::fabs(age_s) > ALIGNABLE_S;
        // A receiver reports the height some seconds after the position; a receiver that never does is used without
        // height.
        let waits_for_height =
            fix.two_dimensional && fix.time - self.heightless_since < HEIGHT_WAIT_S;
        if self.window.length_s() < config.duration_s || waits_for_height || is_far {
            return None;
        }
        let has_down_velocity = fix.measured_down_mps().is_some();
        let speed = fix.horizontal_velocity_mps.map(|[north, east]| Scalar::hypot(north, east));
        let at_rest = self.window.is_at_rest() && speed.is_none_or(|speed| speed < REST_SPEED_MPS);
        let velocity_sigma = fix
            .axes_velocity_sigma_mps()
            .unwrap_or(Vector::new(1.0, 1.0, 2.0) * config.velocity_sigma_mps)
            .to_array();
        let oriented = self.orient::<WEIGH>(fix, at_rest, velocity_sigma[0])?;
        let body_to_ned = oriented.body_to_ned;

        let gyro_bias = if at_rest { self.window.rate } else { Vector::ZERO };
        let rate = self.window.rate - gyro_bias;
        let imu_from_antenna = self.mounting.imu_from_antenna();
        let [north, east] = fix.horizontal_velocity_mps.unwrap_or_default();
        let antenna_velocity = Vector::new(
            north,
            east,
            fix.down_velocity_mps.filter(|_| has_down_velocity).unwrap_or(0.0),
        );
        let velocity_mps = imu_from_antenna.velocity(antenna_velocity, body_to_ned, rate)
            + oriented.acceleration_mps2 * age_s;
        let position =
            imu_from_antenna.position(&fix.position, body_to_ned).displaced(velocity_mps * age_s);
        let state = NavState { time, position, velocity_mps, body_to_ned };
        if !state.is_valid() {
            return None;
        }

        // A velocity component without a measurement gets a larger one-sigma.
        let unknown = |known: bool, sigma: f64| if known { sigma } else { 5.0 + 2.0 * sigma };
        let velocity_sigma_mps = Vector::new(
            unknown(fix.horizontal_velocity_mps.is_some(), velocity_sigma[0]),
            unknown(fix.horizontal_velocity_mps.is_some(), velocity_sigma[1]),
            unknown(has_down_velocity, velocity_sigma[2]),
        );
        let [north_m, east_m, down_m] = fix
            .position_sigma_m
            .unwrap_or(Vector::new(1.0, 1.0, 2.0) * config.position_sigma_m)
            .to_array();
        let down_m = if fix.two_dimensional { UNKNOWN_HEIGHT_M } else { down_m };
        // Acceleration that may have continued or changed since the fix.
        let changed_mps2 = (0.5 * oriented.acceleration_mps2.norm()).max(1.0);
        let age_s = libm::fabs(age_s);
        let each = Vector::new(1.0, 1.0, 1.0);
        let velocity_sigma_mps = velocity_sigma_mps + each * (changed_mps2 * age_s);
        Some(Alignment {
            start: Start {
                state,
                attitude_sigma_rad: Vector::new(
                    oriented.tilt_sigma_rad,
                    oriented.tilt_sigma_rad,
                    oriented.heading_sigma_rad,
                ),
                velocity_sigma_mps,
                // The velocity, with this one-sigma, has moved the position since the fix.
                position_sigma_m: Vector::new(north_m, east_m, down_m) + velocity_sigma_mps * age_s,
                gyro_bias_radps: gyro_bias,
                gyro_bias_sigma_radps: at_rest.then(|| {
                    let scatter = Scalar::sqrt(self.window.rate_variance.max(0.0));
                    (scatter / Scalar::sqrt(self.window.length_s().max(1.0) * 3.0))
                        .max(REST_BIAS_RADPS)
                }),
            },
            heading: oriented.heading,
            attitude_given: self.attitude.is_some(),
            at_rest,
            duration_s: self.window.length_s(),
            axis: oriented.axis,
        })
    }
}

/// Time, s, by which a window that begins at a fix starts before the fix.
const BEFORE_S: f64 = 0.05;
/// Minimum one-sigma of a gyro bias measured at rest, rad/s (0.03°/s).
const REST_BIAS_RADPS: f64 = 5e-4;
