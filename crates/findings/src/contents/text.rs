//! The contents of a log as text.

use std::fmt;

use super::{Contents, GpsContents, ImuContents, SensorContents, Share};
use crate::paragraph::{paragraph, section};
use crate::vibration_lines::VibrationLine;

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
        writeln!(f, "  fastest     {}", stated(self.fastest_mps, " m/s"))
    }
}

fn arm([forward, right, down]: [f64; 3]) -> String {
    format!("forward {forward}, right {right}, down {down}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paragraph::WIDTH;
    use hovernav_dataset::Dataset;

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
