//! Contents of a log, for programs and for a terminal of 80 columns.

mod text;

use serde::{Serialize, Serializer};

use crate::rates::{Vibration, with_rates};
use crate::vibration_lines::{VibrationLine, vibration_lines};
use hovernav::earth::Geodetic;
use hovernav::gps::Fix;
use hovernav::imu::Motion;
use hovernav::time::Time;
use hovernav_dataset::statistics::{median_interval_s, quantile};
use hovernav_dataset::{Dataset, Gap, gaps};

/// Contents of a log, without a run of the filter: sensors with rates, spans and gaps; means and vibration of the
/// inertial unit; quality of the fixes; notes and warnings. [`Display`](std::fmt::Display) writes it for a terminal,
/// [`Serialize`] for programs.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Contents {
    tool: &'static str,
    version: &'static str,
    /// Name of the log.
    pub name: String,
    /// The vehicle; empty if unknown.
    pub vehicle: String,
    /// Kind of vehicle; empty if unknown.
    pub kind: String,
    /// Origin of the log; empty if unknown.
    pub origin: String,
    /// Licence of the log; empty if unknown.
    pub licence: String,
    /// The sensors present.
    #[serde(serialize_with = "by_name")]
    pub sensors: Vec<SensorContents>,
    /// The inertial unit.
    pub imu: ImuContents,
    /// The fixes.
    pub gps: GpsContents,
    /// Choices and assumptions while reading.
    pub notes: Vec<String>,
    /// Repairs and skipped rows while reading.
    pub warnings: Vec<String>,
}

/// One sensor.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct SensorContents {
    /// Name of the sensor.
    #[serde(skip)]
    pub name: &'static str,
    /// Number of samples.
    pub samples: usize,
    /// First sample, s on the log's clock.
    pub from_s: f64,
    /// Last sample, s on the log's clock.
    pub to_s: f64,
    /// Median interval, s; `None` for a single sample.
    pub interval_s: Option<f64>,
    /// Sample rate from the median interval, Hz; `None` for a single sample.
    pub rate_hz: Option<f64>,
    /// Longest interval, s.
    pub longest_interval_s: f64,
    /// Gaps.
    pub gaps: Vec<GapContents>,
}

/// One gap in the samples of a sensor.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct GapContents {
    /// Time of the last sample before the gap.
    #[serde(rename = "after_s", serialize_with = "seconds")]
    pub after: Time,
    /// Time to the next sample, s.
    pub length_s: f64,
}

/// Number of samples with some property.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Share {
    /// Samples with the property.
    pub samples: usize,
    /// All samples.
    #[serde(skip)]
    pub of: usize,
}

/// The inertial unit; axes forward, right, down.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct ImuContents {
    /// `rates` or `increments`; `None` without samples.
    pub form: Option<&'static str>,
    /// Samples with the inertial unit's own attitude.
    pub attitude: Share,
    /// Samples with a magnetic field.
    pub magnetic_field: Share,
    /// Position of the inertial unit relative to the centre of gravity, m.
    pub lever_arm_m: [f64; 3],
    /// Mean angular rate, rad/s.
    pub mean_rate_radps: Option<[f64; 3]>,
    /// Mean specific force, m/s².
    pub mean_specific_force_mps2: Option<[f64; 3]>,
    /// Vibration between samples, rms, rad/s and m/s².
    pub vibration_radps_and_mps2: Option<[f64; 6]>,
    /// Strongest vibration lines.
    pub lines: Vec<VibrationLine>,
}

/// The fixes.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct GpsContents {
    /// Fixes with velocity north, east and down.
    pub velocity: Share,
    /// Fixes with velocity north and east.
    pub horizontal_velocity: Share,
    /// Fixes with a stated one-sigma of position.
    pub position_sigma: Share,
    /// Fixes with a stated one-sigma of velocity.
    pub velocity_sigma: Share,
    /// Position of the antenna relative to the centre of gravity, m; axes forward, right, down.
    pub antenna_lever_arm_m: [f64; 3],
    /// Declared latency, s.
    pub latency_s: f64,
    /// Position of the first fix; `None` without fixes.
    #[serde(serialize_with = "position")]
    pub first: Option<Geodetic>,
    /// Smallest and largest distance from the first fix, m; axes north, east, down.
    pub extent_m: [[f64; 2]; 3],
    /// Median of the stated horizontal one-sigma, m.
    pub position_sigma_m: Option<f64>,
    /// Median of the satellites used.
    pub satellites: Option<f64>,
    /// Greatest speed over ground, m/s; `None` without velocities.
    pub fastest_mps: Option<f64>,
}

impl Contents {
    /// Contents of `dataset`.
    #[must_use]
    pub fn of(dataset: &Dataset) -> Self {
        let manifest = &dataset.manifest;
        Self {
            tool: "hovernav",
            version: env!("CARGO_PKG_VERSION"),
            name: manifest.name.clone(),
            vehicle: manifest.vehicle.clone(),
            kind: manifest.kind.clone(),
            origin: manifest.origin.clone(),
            licence: manifest.licence.clone(),
            sensors: sensors(dataset),
            imu: ImuContents::of(dataset),
            gps: GpsContents::of(dataset),
            notes: dataset.notes.clone(),
            warnings: dataset.warnings.clone(),
        }
    }
}

fn sensors(dataset: &Dataset) -> Vec<SensorContents> {
    let mut controls = Vec::new();
    // If the file can no longer be read, the rows before the error count.
    dataset.each_control(|time, _| controls.push(time)).ok();
    let sensors: [(&str, Vec<Time>); 8] = [
        ("imu", dataset.samples().map(|sample| sample.time).collect()),
        ("gps", dataset.fixes.iter().map(|fix| fix.time).collect()),
        ("baro", dataset.baro.iter().map(|row| row.0).collect()),
        ("magnetometer", dataset.magnetometer.iter().map(|row| row.0).collect()),
        ("second antenna", dataset.headings.iter().map(|heading| heading.time).collect()),
        ("rangefinder", dataset.ranges.iter().map(|reading| reading.time).collect()),
        ("rotor", dataset.rotor.iter().map(|row| row.0).collect()),
        ("controls", controls),
    ];
    sensors.into_iter().filter_map(|(name, times)| SensorContents::of(name, &times)).collect()
}

impl SensorContents {
    fn of(name: &'static str, times: &[Time]) -> Option<Self> {
        let gap = |gap: Gap| GapContents { after: gap.after, length_s: gap.length_s };
        let interval_s = median_interval_s(times);
        Some(Self {
            name,
            samples: times.len(),
            from_s: times.first()?.seconds(),
            to_s: times.last()?.seconds(),
            interval_s,
            rate_hz: interval_s.map(|interval_s| 1.0 / interval_s),
            longest_interval_s: times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max),
            gaps: gaps(times).into_iter().map(gap).collect(),
        })
    }
}

impl ImuContents {
    fn of(dataset: &Dataset) -> Self {
        let of = dataset.sample_count();
        let (mut form, mut attitude, mut magnetic) = (None, 0, 0);
        let (mut rates, mut sums, mut vibration) = (Vec::new(), [0.0; 6], Vibration::default());
        for (sample, at) in with_rates(dataset.samples()) {
            form.get_or_insert(match sample.motion {
                Motion::Rates { .. } => "rates",
                Motion::Increments { .. } => "increments",
            });
            attitude += usize::from(sample.attitude.is_some());
            magnetic += usize::from(sample.magnetic_field_gauss.is_some());
            if let Some(at) = at {
                sums.iter_mut().zip(at.six()).for_each(|(sum, value)| *sum += value);
                vibration.push(&at);
                rates.push(at);
            }
        }
        let [p, q, r, x, y, z] = sums.map(|sum| sum / rates.len() as f64);
        let has_rates = !rates.is_empty();
        Self {
            form,
            attitude: Share { samples: attitude, of },
            magnetic_field: Share { samples: magnetic, of },
            lever_arm_m: dataset.manifest.imu.lever_arm_m.to_array(),
            mean_rate_radps: has_rates.then_some([p, q, r]),
            mean_specific_force_mps2: has_rates.then_some([x, y, z]),
            vibration_radps_and_mps2: vibration.rms(),
            lines: vibration_lines(&rates),
        }
    }
}

impl GpsContents {
    fn of(dataset: &Dataset) -> Self {
        let (fixes, gps) = (&dataset.fixes, &dataset.manifest.gps);
        let share = |has: fn(&&Fix) -> bool| Share {
            samples: fixes.iter().filter(has).count(),
            of: fixes.len(),
        };
        let first = fixes.first().map(|fix| fix.position);
        let mut extent_m = [[0.0; 2]; 3];
        for (fix, first) in fixes.iter().zip(first.iter().cycle()) {
            let from_first_m = fix.position.displacement_from(first).to_array();
            for ([least, most], at) in extent_m.iter_mut().zip(from_first_m) {
                (*least, *most) = (f64::min(*least, at), f64::max(*most, at));
            }
        }
        let horizontal = |fix: &Fix| {
            let [north, east, _] = fix.position_sigma_m?.to_array();
            Some(north.hypot(east) / std::f64::consts::SQRT_2)
        };
        let mut sigmas: Vec<f64> = fixes.iter().filter_map(horizontal).collect();
        let mut satellites: Vec<f64> =
            fixes.iter().filter_map(|fix| fix.satellites.map(f64::from)).collect();
        let speeds = fixes.iter().filter_map(|fix| fix.horizontal_velocity_mps);
        Self {
            velocity: share(|fix| fix.velocity_mps().is_some()),
            horizontal_velocity: share(|fix| fix.horizontal_velocity_mps.is_some()),
            position_sigma: share(|fix| fix.position_sigma_m.is_some()),
            velocity_sigma: share(|fix| fix.velocity_sigma_mps.is_some()),
            antenna_lever_arm_m: gps.antenna_lever_arm_m.to_array(),
            latency_s: gps.latency_s,
            first,
            extent_m,
            position_sigma_m: quantile(&mut sigmas, 0.5),
            satellites: quantile(&mut satellites, 0.5),
            fastest_mps: speeds.map(|[north, east]| north.hypot(east)).reduce(f64::max),
        }
    }
}

fn by_name<S: Serializer>(sensors: &[SensorContents], to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(sensors.iter().map(|sensor| (sensor.name, sensor)))
}

fn seconds<S: Serializer>(time: &Time, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_f64(time.seconds())
}

fn position<S: Serializer>(position: &Option<Geodetic>, to: S) -> Result<S::Ok, S::Error> {
    let parts = |at: &Geodetic| {
        [("lat_deg", at.latitude_deg()), ("lon_deg", at.longitude_deg()), ("height_m", at.height_m)]
    };
    match position {
        Some(at) => to.collect_map(parts(at)),
        None => to.serialize_none(),
    }
}
