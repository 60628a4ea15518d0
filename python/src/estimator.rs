//! `Estimator`: the filter for one measurement at a time.

use std::sync::Mutex;

use hovernav::earth::Geodetic;
use hovernav::ekf::{Estimator as Core, Notice as CoreNotice, Report, Verdict};
use hovernav::event::{BaroReading, Event, MagneticReading};
use hovernav::frames::{EulerAngles, Vector};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Notch};
use hovernav::time::Time;
use hovernav_dataset::{Manifest, Reading};
use pyo3::prelude::*;

use crate::columns::{time, times, triple, triples, vector};
use crate::error::{Error, Result};
use crate::settings::Settings;
use crate::solution::{State, solution_table};

/// An event that the estimator reports: a measurement that was accepted or rejected, an alignment, a gap.
#[pyclass(frozen, get_all, module = "hovernav")]
pub struct Notice {
    /// Time of the measurement or the event, s; `None` for an update without axes.
    time_s: Option<f64>,
    /// `aligned`, `set-up suspect`, `updated`, `not used`, `sample refused`, `sample suspect`, `gap bridged`,
    /// `covariance reset`, `heading found`, `heading reset`, `heading doubted`, `heading missing`, `field disturbed`,
    /// `field usual`, `antenna elsewhere`, `on wheels`, `off wheels` or `other`.
    kind: &'static str,
    /// Whether the measurement corrected the state; `None` for an event that is not a measurement.
    accepted: Option<bool>,
    /// The event in one sentence.
    words: String,
}

#[pymethods]
impl Notice {
    fn __repr__(&self) -> String {
        format!("<{}: {}>", self.kind, self.words)
    }
}

impl From<CoreNotice> for Notice {
    fn from(notice: CoreNotice) -> Self {
        let plain = |time: Time, kind, words: String| Self {
            time_s: Some(time.seconds()),
            kind,
            accepted: None,
            words,
        };
        let degrees = |angle_rad: f64| format!("{:.1}°", angle_rad.to_degrees());
        match notice {
            CoreNotice::Aligned(alignment) => {
                let sigma = degrees(alignment.start.attitude_sigma_rad.z());
                let words = format!("aligned, one-sigma of the heading {sigma}");
                plain(alignment.start.state.time, "aligned", words)
            }
            CoreNotice::SetupSuspect { time, fault } => {
                plain(time, "set-up suspect", format!("set-up: {fault}"))
            }
            CoreNotice::HeadingFound { time, turn_rad, sigma_rad } => {
                let (turn, sigma) = (degrees(turn_rad), degrees(sigma_rad));
                plain(
                    time,
                    "heading found",
                    format!("heading found: turned by {turn}, one-sigma {sigma}"),
                )
            }
            CoreNotice::HeadingReset { time, turn_rad, sigma_rad } => {
                let (turn, sigma) = (degrees(turn_rad), degrees(sigma_rad));
                plain(time, "heading reset", format!("heading reset by {turn}, one-sigma {sigma}"))
            }
            CoreNotice::HeadingSuspect { time, off_rad, sigma_rad } => {
                let (off, sigma) = (degrees(off_rad), degrees(sigma_rad));
                let words = format!("heading differs from the fixes by {off}, one-sigma {sigma}");
                plain(time, "heading doubted", words)
            }
            CoreNotice::MagneticFieldDisturbed { time, share, .. } => {
                let words = format!("magnetic field disturbed by {:.0} %", 100.0 * share);
                plain(time, "field disturbed", words)
            }
            CoreNotice::MagneticFieldUsual { time, .. } => {
                plain(time, "field usual", "magnetic field as usual again".into())
            }
            CoreNotice::AntennaOffsetFound { time, offset_m, sigma_m } => {
                let off_m = offset_m.norm();
                let words =
                    format!("antenna {off_m:.2} m from its lever arm, one-sigma {sigma_m:.2} m");
                plain(time, "antenna elsewhere", words)
            }
            CoreNotice::WheelConstraintOn { time, .. } => {
                plain(time, "on wheels", "the vehicle rolls on wheels".into())
            }
            CoreNotice::WheelConstraintOff { time } => {
                plain(time, "off wheels", "the vehicle does not roll on wheels".into())
            }
            CoreNotice::HeadingMissing { time } => {
                plain(time, "heading missing", "alignment waits for a heading".into())
            }
            CoreNotice::Updated(report) => Self::of_report(&report),
            CoreNotice::NotUsed { time, aid, reason } => {
                let words = format!("{aid} not used: {reason}");
                Self { accepted: Some(false), ..plain(time, "not used", words) }
            }
            CoreNotice::GapBridged { time, length_s } => {
                let words = format!("gap of {length_s:.3} s in the inertial samples bridged");
                plain(time, "gap bridged", words)
            }
            CoreNotice::CovarianceReset { time, cause } => {
                plain(time, "covariance reset", cause.to_string())
            }
            CoreNotice::SampleSuspect { time, suspicion } => {
                plain(time, "sample suspect", format!("inertial samples suspect: {suspicion}"))
            }
            CoreNotice::SampleRejected { time, fault } => {
                plain(time, "sample refused", format!("inertial sample not used: {fault}"))
            }
            other => {
                Self { time_s: None, kind: "other", accepted: None, words: format!("{other:?}") }
            }
        }
    }
}

impl Notice {
    fn of_report(report: &Report) -> Self {
        let axes: Vec<String> = report
            .innovations()
            .map(|axis| {
                let verdict = match axis.verdict {
                    Verdict::Accepted => "accepted",
                    Verdict::Rejected => "rejected",
                    _ => "accepted by a reset",
                };
                let name = axis.channel.name();
                format!(
                    "{name} {verdict}: innovation {:.3}, sigma {:.3}",
                    axis.innovation, axis.sigma
                )
            })
            .collect();
        Self {
            time_s: report.time().map(|time| time.seconds()),
            kind: "updated",
            accepted: Some(report.any_accepted()),
            words: axes.join("; "),
        }
    }
}

/// The estimator as in flight: it takes measurements in the order of their arrival, and gives a solution at any time.
///
/// Times are seconds on one clock. Vectors are three numbers, forward, right, down unless `[imu] axes` in the settings
/// names other axes. Every method returns the notices that its measurement caused. A fix waits for inertial samples up
/// to 0.06 s after it, so a later inertial sample returns the notice of the fix.
///
/// Parameters
/// ----------
/// config : path or dict, optional
///     Settings in the form of `dataset.toml`. With a magnetometer give `[imu] magnetic_declination_deg`, because the
///     estimator has no position from which to derive it.
///
/// Raises
/// ------
/// ConfigError
///     If a setting is unknown or out of range.
#[pyclass(frozen, module = "hovernav")]
pub struct Estimator(Mutex<Inner>);

struct Inner {
    core: Box<Core>,
    reading: Reading,
    notch: Option<Notch>,
    latency_s: f64,
}

impl Inner {
    fn push(&mut self, event: &Event) -> Vec<Notice> {
        let mut notices = Vec::new();
        self.core.push(event, |notice| keep(&mut notices, notice));
        notices
    }

    fn sample(&mut self, sample: ImuSample) -> Event {
        let sample = self.reading.applied(sample);
        Event::Imu(self.notch.as_mut().map_or(sample, |notch| notch.filter(&sample)))
    }
}

/// Stores a notice, unless it reports a measurement that is skipped by design.
fn keep(notices: &mut Vec<Notice>, notice: CoreNotice) {
    let is_by_design = matches!(notice, CoreNotice::NotUsed { reason, .. } if !reason.is_fault());
    if !is_by_design {
        notices.push(notice.into());
    }
}

impl Estimator {
    fn with<T>(&self, call: impl FnOnce(&mut Inner) -> T) -> T {
        // No call panics while it holds the lock.
        call(&mut self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner))
    }

    fn push(&self, event: &Event) -> Vec<Notice> {
        self.with(|inner| inner.push(event))
    }
}

/// A one-sigma or velocity from Python; `None` if unknown.
fn known(value: Option<&Bound<'_, PyAny>>, name: &str) -> Result<Option<[f64; 3]>> {
    value.map(|value| triple(value, name)).transpose()
}

#[pymethods]
impl Estimator {
    #[new]
    #[pyo3(signature = (config=None))]
    fn new(config: Option<&Bound<'_, PyAny>>) -> Result<Self> {
        let mut manifest = Manifest::default();
        if let Some(config) = config {
            let Settings { text, name } = Settings::of(config)?;
            let (set, unknown) = Manifest::parse(&text, &name)?;
            if let Some(unknown) = unknown.first() {
                return Err(Error::Config(unknown.clone()));
            }
            manifest = set;
        }
        let reading = manifest.imu.take_reading();
        let has_declination = manifest.imu.magnetic_declination_deg.is_some();
        let (config, _) = manifest.settings(has_declination, None)?;
        Ok(Self(Mutex::new(Inner {
            core: Box::new(Core::new(config)),
            reading,
            notch: manifest.imu.notch.map(Notch::new),
            latency_s: manifest.gps.latency_s,
        })))
    }

    /// An inertial sample: angular rate, rad/s, and specific force, m/s²; optionally the inertial unit's own roll, pitch
    /// and yaw, °, and the magnetic field, gauss. A sample with NaN, or with a time that is not later than the
    /// previous one, is rejected with a notice.
    #[pyo3(signature = (time_s, gyro_radps, accel_mps2, *, attitude_deg=None, mag_gauss=None))]
    fn imu(
        &self,
        time_s: f64,
        gyro_radps: &Bound<'_, PyAny>,
        accel_mps2: &Bound<'_, PyAny>,
        attitude_deg: Option<&Bound<'_, PyAny>>,
        mag_gauss: Option<&Bound<'_, PyAny>>,
    ) -> Result<Vec<Notice>> {
        let gyro = triple(gyro_radps, "gyro_radps")?.into();
        let accel = triple(accel_mps2, "accel_mps2")?.into();
        let mut sample = ImuSample::from_rates(time(time_s)?, gyro, accel);
        sample.attitude = known(attitude_deg, "attitude_deg")?
            .map(|[roll, pitch, yaw]| EulerAngles::from_degrees(roll, pitch, yaw));
        sample.magnetic_field_gauss = known(mag_gauss, "mag_gauss")?.map(Into::into);
        Ok(self.with(|inner| {
            let event = inner.sample(sample);
            inner.push(&event)
        }))
    }

    /// Many inertial samples: times of shape (n,), strictly increasing, rates and specific forces of shape (n, 3).
    ///
    /// Returns a `Table` with the columns of `solution.csv` and one row for each sample that was used after the
    /// alignment, and the notices.
    ///
    /// Raises
    /// ------
    /// ArrayError
    ///     For wrong shapes, or times that do not increase.
    #[pyo3(signature = (time_s, gyro_radps, accel_mps2))]
    fn imu_batch<'py>(
        &self,
        py: Python<'py>,
        time_s: &Bound<'py, PyAny>,
        gyro_radps: &Bound<'py, PyAny>,
        accel_mps2: &Bound<'py, PyAny>,
    ) -> Result<(Bound<'py, PyAny>, Vec<Notice>)> {
        let times = times(&vector(time_s, "time_s")?, "imu_batch")?;
        let (gyro, accel) =
            (triples(gyro_radps, "gyro_radps")?, triples(accel_mps2, "accel_mps2")?);
        for (name, rows) in [("gyro_radps", gyro.len()), ("accel_mps2", accel.len())] {
            if rows != times.len() {
                let expected = times.len();
                return Err(Error::Array(format!(
                    "{name}: found {rows} rows, expected {expected}, as in time_s"
                )));
            }
        }
        let (states, notices) = py.detach(|| {
            self.with(|inner| {
                let (mut states, mut notices) = (Vec::with_capacity(times.len()), Vec::new());
                for ((time, gyro), accel) in times.into_iter().zip(gyro).zip(accel) {
                    let sample = ImuSample::from_rates(time, gyro.into(), accel.into());
                    let event = inner.sample(sample);
                    inner.core.push(&event, |notice| keep(&mut notices, notice));
                    states.extend(inner.core.solution().filter(|solution| solution.time == time));
                }
                (states, notices)
            })
        });
        Ok((solution_table(py, &states)?, notices))
    }

    /// A fix: latitude and longitude, °, height above the ellipsoid, m. `time_s` is the time of arrival; the estimator
    /// subtracts `[gps] latency_s` of the settings from it. Optional: velocity north, east, down, m/s, and the
    /// one-sigmas that the receiver reports, north, east, down.
    ///
    /// Raises
    /// ------
    /// ArrayError
    ///     For a position that is not valid on Earth.
    #[pyo3(signature = (time_s, latitude_deg, longitude_deg, height_m, *, velocity_mps=None,
                        position_sigma_m=None, velocity_sigma_mps=None))]
    #[expect(clippy::too_many_arguments, reason = "named in Python")]
    fn gps(
        &self,
        time_s: f64,
        latitude_deg: f64,
        longitude_deg: f64,
        height_m: f64,
        velocity_mps: Option<&Bound<'_, PyAny>>,
        position_sigma_m: Option<&Bound<'_, PyAny>>,
        velocity_sigma_mps: Option<&Bound<'_, PyAny>>,
    ) -> Result<Vec<Notice>> {
        let position = Geodetic::from_degrees(latitude_deg, longitude_deg, height_m);
        let position = position.ok_or_else(|| {
            Error::Array(format!(
                "gps: found {latitude_deg}°, {longitude_deg}°, {height_m} m, expected a position on Earth"
            ))
        })?;
        let arrival = time(time_s)?;
        let [velocity, position_sigma, velocity_sigma] = [
            known(velocity_mps, "velocity_mps")?,
            known(position_sigma_m, "position_sigma_m")?,
            known(velocity_sigma_mps, "velocity_sigma_mps")?,
        ]
        .map(|value| value.map(Vector::from));
        Ok(self.with(|inner| {
            let mut fix = Fix::at(arrival.offset_by(-inner.latency_s), position);
            if let Some(velocity) = velocity {
                fix = fix.with_velocity_mps(velocity);
            }
            (fix.position_sigma_m, fix.velocity_sigma_mps) = (position_sigma, velocity_sigma);
            inner.push(&Event::Gps(fix))
        }))
    }

    /// A barometric height above any fixed level, m.
    fn baro(&self, time_s: f64, height_m: f64) -> Result<Vec<Notice>> {
        Ok(self.push(&Event::Baro(BaroReading::new(time(time_s)?, height_m))))
    }

    /// A magnetic field in body axes forward, right, down, gauss.
    fn magnetometer(&self, time_s: f64, mag_gauss: &Bound<'_, PyAny>) -> Result<Vec<Notice>> {
        let field = triple(mag_gauss, "mag_gauss")?.into();
        Ok(self.push(&Event::Magnetometer(MagneticReading::new(time(time_s)?, field))))
    }

    /// The latest `State`; `None` before the end of the alignment.
    #[getter]
    fn solution(&self) -> Option<State> {
        self.with(|inner| inner.core.solution().map(State))
    }

    fn __repr__(&self) -> String {
        match self.solution() {
            Some(State(state)) => format!("<Estimator at {:.3} s>", state.time.seconds()),
            None => "<Estimator before the end of its alignment>".into(),
        }
    }
}
