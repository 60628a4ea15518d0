//! Contents of a log, for programs and for a terminal of 80 columns.

use std::fmt;

use serde::{Serialize, Serializer};

use crate::clock::{Gap, gaps};
use crate::dataset::Dataset;
use crate::paragraph::paragraph;
use crate::rates::{Vibration, with_rates};
use crate::statistics::{median_interval_s, quantile};
use crate::vibration_lines::{VibrationLine, vibration_lines};
use hovernav::earth::Geodetic;
use hovernav::gps::Fix;
use hovernav::imu::Motion;
use hovernav::time::Time;

/// Contents of a log, without a run of the filter: sensors with rates, spans and gaps; means and vibration of the
/// inertial unit; quality of the fixes; notes and warnings. [`Display`](fmt::Display) writes it for a terminal,
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
    /// Median interval, s; `None` of a single sample.
    pub interval_s: Option<f64>,
    /// Sample rate from the median interval, Hz; `None` of a single sample.
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
    /// Time of the last sample before it.
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
    /// Samples with the unit's own attitude.
    pub attitude: Share,
    /// Samples with a magnetic field.
    pub magnetic_field: Share,
    /// Position of the unit from the centre of gravity, m.
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
    /// Position of the antenna from the centre of gravity, m; axes forward, right, down.
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
    /// Greatest speed over ground, m/s.
    pub fastest_mps: f64,
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
            fastest_mps: speeds.map(|[north, east]| north.hypot(east)).fold(0.0, f64::max),
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

/// Number of gaps of one sensor that are listed; further ones are only counted.
const GAPS_NAMED: usize = 5;

impl fmt::Display for Contents {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.name)?;
        for (what, text) in [
            ("vehicle", &self.vehicle),
            ("kind", &self.kind),
            ("origin", &self.origin),
            ("licence", &self.licence),
        ] {
            if !text.is_empty() {
                paragraph(f, &format!("  {what:<9} "), text)?;
            }
        }
        writeln!(
            f,
            "\n  {:<13}{:>9}{:>12}{:>12}{:>11}{:>11}{:>10}",
            "sensor", "samples", "from s", "to s", "rate Hz", "interval s", "longest s"
        )?;
        self.sensors.iter().try_for_each(|sensor| sensor.write_row(f))?;
        self.sensors.iter().try_for_each(|sensor| sensor.write_gaps(f))?;
        self.imu.write(f)?;
        self.gps.write(f)?;
        section(f, "notes", &self.notes)?;
        section(f, "warnings", &self.warnings)?;
        self.imu.write_lines(f)?;
        self.gps.write_quality(f)
    }
}

impl SensorContents {
    fn write_row(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, samples, from_s, to_s, longest_interval_s, .. } = self;
        write!(f, "  {name:<13}{samples:>9}{from_s:>12.3}{to_s:>12.3}")?;
        if let Some((interval_s, rate_hz)) = self.interval_s.zip(self.rate_hz) {
            write!(f, "{rate_hz:>11.2}{interval_s:>11.4}{longest_interval_s:>10.3}")?;
        }
        writeln!(f)
    }

    fn write_gaps(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.gaps.is_empty() {
            return Ok(());
        }
        let named = self.gaps.iter().take(GAPS_NAMED);
        let named: Vec<String> =
            named.map(|gap| format!("{:.3} s after {}", gap.length_s, gap.after)).collect();
        let more = match self.gaps.len().saturating_sub(GAPS_NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        writeln!(f)?;
        let lead = format!("  gaps in {}: ", self.name);
        paragraph(f, &lead, &format!("{}{more}", named.join(", ")))
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self { samples: 0, .. } => f.write_str("none"),
            Self { samples, of } if samples == of => f.write_str("all"),
            Self { samples, of } => write!(f, "{samples} of {of}"),
        }
    }
}

impl ImuContents {
    fn write(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(form) = self.form else { return Ok(()) };
        writeln!(f, "\nimu")?;
        writeln!(f, "  form      {form}")?;
        writeln!(f, "  attitude  {}", self.attitude)?;
        writeln!(f, "  magnetic  {}", self.magnetic_field)?;
        writeln!(f, "  at        {} m from the CG", arm(self.lever_arm_m))?;
        let means = self.mean_rate_radps.zip(self.mean_specific_force_mps2);
        let Some((rate_radps, force_mps2)) = means else { return Ok(()) };
        writeln!(f, "\n  {:<34}{:>12}{:>12}{:>12}", "", "x", "y", "z")?;
        let mut row = |what: &str, [x, y, z]: [f64; 3]| {
            writeln!(f, "  {what:<34}{x:>12.4}{y:>12.4}{z:>12.4}")
        };
        row("mean rate, rad/s", rate_radps)?;
        row("mean specific force, m/s²", force_mps2)?;
        if let Some([p, q, r, x, y, z]) = self.vibration_radps_and_mps2 {
            row("vibration (high-pass rms), rad/s", [p, q, r])?;
            row("vibration (high-pass rms), m/s²", [x, y, z])?;
        }
        Ok(())
    }

    fn write_lines(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.lines.is_empty() {
            let title = "vibration, strongest lines as sampled (a faster one shows at its alias)";
            writeln!(f, "\n{title}")?;
        }
        self.lines.iter().try_for_each(|VibrationLine { axis, frequency_hz, amplitude, unit }| {
            writeln!(f, "  {axis:<16}{frequency_hz:>8.2} Hz{amplitude:>10.3} {unit}")
        })
    }
}

impl GpsContents {
    fn write(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(first) = self.first else { return Ok(()) };
        let Self { velocity, horizontal_velocity, .. } = self;
        writeln!(f, "\ngps")?;
        match horizontal_velocity.samples == velocity.samples {
            true => writeln!(f, "  velocity  {velocity}")?,
            false => {
                writeln!(
                    f,
                    "  velocity  horizontal {horizontal_velocity}, vertical too {velocity}"
                )?;
            }
        }
        writeln!(f, "  sigmas    position {}", self.position_sigma)?;
        writeln!(f, "            velocity {}", self.velocity_sigma)?;
        writeln!(f, "  antenna   {} m from the CG", arm(self.antenna_lever_arm_m))?;
        writeln!(f, "  latency   {:.3} s", self.latency_s)?;
        writeln!(
            f,
            "  first     {:.7}°, {:.7}°, {:.2} m",
            first.latitude_deg(),
            first.longitude_deg(),
            first.height_m
        )?;
        let [[south, north], [west, east], [top, bottom]] = self.extent_m;
        writeln!(
            f,
            "  extent    north {south:.1} to {north:.1} m, east {west:.1} to {east:.1} m, up {:.1} to {:.1} m",
            -bottom, -top
        )
    }

    fn write_quality(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.first.is_none() {
            return Ok(());
        }
        let stated = |median: Option<f64>, unit: &str| {
            median.map_or("not stated".into(), |median| format!("{median:.1}{unit}"))
        };
        writeln!(f, "\ngps quality")?;
        writeln!(f, "  one-sigma   {} (median, horizontal)", stated(self.position_sigma_m, " m"))?;
        writeln!(f, "  satellites  {} (median)", stated(self.satellites, ""))?;
        writeln!(f, "  fastest     {:.1} m/s", self.fastest_mps)
    }
}

fn arm([forward, right, down]: [f64; 3]) -> String {
    format!("forward {forward}, right {right}, down {down}")
}

/// Writes sentences below a title; nothing without sentences.
pub(crate) fn section(
    f: &mut fmt::Formatter<'_>,
    title: &str,
    sentences: &[String],
) -> fmt::Result {
    if sentences.is_empty() {
        return Ok(());
    }
    writeln!(f, "\n{title}")?;
    sentences.iter().try_for_each(|sentence| paragraph(f, "  ", sentence))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paragraph::WIDTH;

    #[test]
    fn the_hover_flight_is_described_within_the_terminal() {
        let dir = concat!(env!("CARGO_MANIFEST_DIR"), "/../../datasets/heli-hover");
        let mut dataset = Dataset::open(dir.as_ref()).unwrap();
        dataset.imu.drain(3000..3100);
        dataset.warnings.push("gps.csv: ".to_string() + &"some words ".repeat(20));
        let text = Contents::of(&dataset).to_string();
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH), "{text}");
        for line in [
            "  imu               9799       0.050     299.989      33.00     0.0303     3.061",
            "  gps                299       1.000     299.000       1.00     1.0000     1.000",
            "  gaps in imu: 3.061 s after 90.928790 s",
            "  attitude  all",
            "  antenna   forward -0.35, right 0, down 0.2 m from the CG",
            "  extent    north -1.9 to 84.6 m, east -1.5 to 48.5 m, up -1.1 to 17.6 m",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}\n{text}");
        }
    }

    #[test]
    fn a_dataset_of_nothing_is_described_too() {
        assert!(Contents::of(&Dataset::default()).to_string().contains("sensor"));
    }
}
