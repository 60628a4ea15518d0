//! Contents of a log, as text for a terminal of 80 columns.

use std::fmt;

use crate::clock::{Gap, gaps};
use crate::dataset::Dataset;
use crate::statistics::median_interval_s;
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;

/// Description of a dataset as text, by its [`Display`](fmt::Display): sensors, rates, spans, gaps, vibration, notes
/// and warnings.
#[derive(Clone, Copy, Debug)]
pub struct Info<'a>(pub &'a Dataset);

/// Width of the terminal, characters.
const WIDTH: usize = 80;
/// Number of gaps of one sensor that are listed; further ones are only counted.
const GAPS_NAMED: usize = 5;

impl fmt::Display for Info<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let dataset = self.0;
        let manifest = &dataset.manifest;
        writeln!(f, "{}", manifest.name)?;
        for (what, text) in [
            ("vehicle", &manifest.vehicle),
            ("kind", &manifest.kind),
            ("origin", &manifest.origin),
            ("licence", &manifest.licence),
        ] {
            if !text.is_empty() {
                paragraph(f, &format!("  {what:<9} "), text)?;
            }
        }
        writeln!(f)?;
        let sensors = sensors(dataset);
        writeln!(
            f,
            "  {:<13}{:>9}{:>12}{:>12}{:>11}{:>11}{:>10}",
            "sensor", "samples", "from s", "to s", "rate Hz", "interval s", "longest s"
        )?;
        for (name, times) in &sensors {
            write_sensor(f, name, times)?;
        }
        for (name, times) in &sensors {
            write_gaps(f, name, &gaps(times))?;
        }
        write_imu(f, dataset)?;
        write_fixes(f, dataset)?;
        for (title, sentences) in [("notes", &dataset.notes), ("warnings", &dataset.warnings)] {
            if !sentences.is_empty() {
                writeln!(f, "\n{title}")?;
            }
            for sentence in sentences {
                paragraph(f, "  ", sentence)?;
            }
        }
        Ok(())
    }
}

/// Names of the sensors present, with the times of their samples.
pub(crate) fn sensors(dataset: &Dataset) -> Vec<(&'static str, Vec<Time>)> {
    let mut controls = Vec::new();
    // If the file can no longer be read, the rows before the error count.
    dataset.each_control(|time, _| controls.push(time)).ok();
    let mut sensors = vec![
        ("imu", dataset.samples().map(|sample| sample.time).collect::<Vec<_>>()),
        ("gps", dataset.fixes.iter().map(|fix| fix.time).collect()),
        ("baro", dataset.baro.iter().map(|row| row.0).collect()),
        ("magnetometer", dataset.magnetometer.iter().map(|row| row.0).collect()),
        ("second antenna", dataset.headings.iter().map(|heading| heading.time).collect()),
        ("rangefinder", dataset.ranges.iter().map(|reading| reading.time).collect()),
        ("rotor", dataset.rotor.iter().map(|row| row.0).collect()),
        ("controls", controls),
    ];
    sensors.retain(|(_, times)| !times.is_empty());
    sensors
}

fn write_sensor(f: &mut fmt::Formatter<'_>, name: &str, times: &[Time]) -> fmt::Result {
    let (Some(first), Some(last)) = (times.first(), times.last()) else { return Ok(()) };
    write!(f, "  {name:<13}{:>9}{:>12.3}{:>12.3}", times.len(), first.seconds(), last.seconds())?;
    if let Some(interval_s) = median_interval_s(times) {
        let longest_s = times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        write!(f, "{:>11.2}{interval_s:>11.4}{longest_s:>10.3}", 1.0 / interval_s)?;
    }
    writeln!(f)
}

fn write_gaps(f: &mut fmt::Formatter<'_>, name: &str, gaps: &[Gap]) -> fmt::Result {
    if gaps.is_empty() {
        return Ok(());
    }
    let named: Vec<String> = gaps
        .iter()
        .take(GAPS_NAMED)
        .map(|gap| format!("{:.3} s after {}", gap.length_s, gap.after))
        .collect();
    let more = match gaps.len().saturating_sub(GAPS_NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    writeln!(f)?;
    paragraph(f, &format!("  gaps in {name}: "), &format!("{}{more}", named.join(", ")))
}

fn write_imu(f: &mut fmt::Formatter<'_>, dataset: &Dataset) -> fmt::Result {
    let Some(first) = dataset.samples().next() else { return Ok(()) };
    let form = match first.motion {
        Motion::Rates { .. } => "rates",
        Motion::Increments { .. } => "increments",
    };
    let of_all = |has: fn(&ImuSample) -> bool| {
        counted(dataset.samples().filter(has).count(), dataset.sample_count())
    };
    writeln!(f, "\nimu")?;
    writeln!(f, "  form      {form}")?;
    writeln!(f, "  attitude  {}", of_all(|sample| sample.attitude.is_some()))?;
    writeln!(f, "  magnetic  {}", of_all(|sample| sample.magnetic_field_gauss.is_some()))?;
    writeln!(f, "  at        {} m from the CG", arm(dataset.manifest.imu.lever_arm_m.to_array()))?;
    let rates = rates(dataset.samples());
    let mean =
        |pick: fn(&[f64; 6]) -> f64| rates.iter().map(pick).sum::<f64>() / rates.len() as f64;
    if rates.is_empty() {
        return Ok(());
    }
    writeln!(f, "\n  {:<34}{:>12}{:>12}{:>12}", "", "x", "y", "z")?;
    let mut line =
        |what: &str, [x, y, z]: [f64; 3]| writeln!(f, "  {what:<34}{x:>12.4}{y:>12.4}{z:>12.4}");
    line("mean rate, rad/s", [mean(|r| r[0]), mean(|r| r[1]), mean(|r| r[2])])?;
    line("mean specific force, m/s²", [mean(|r| r[3]), mean(|r| r[4]), mean(|r| r[5])])?;
    if let Some([p, q, r, x, y, z]) = vibration(&rates) {
        line("vibration (high-pass rms), rad/s", [p, q, r])?;
        line("vibration (high-pass rms), m/s²", [x, y, z])?;
    }
    Ok(())
}

fn write_fixes(f: &mut fmt::Formatter<'_>, dataset: &Dataset) -> fmt::Result {
    let Some(first) = dataset.fixes.first() else { return Ok(()) };
    let of_all = |has: fn(&Fix) -> bool| share(&dataset.fixes, has);
    let gps = &dataset.manifest.gps;
    writeln!(f, "\ngps")?;
    let horizontal = of_all(|fix| fix.horizontal_velocity_mps.is_some());
    let all = of_all(|fix| fix.velocity_mps().is_some());
    match horizontal == all {
        true => writeln!(f, "  velocity  {all}")?,
        false => writeln!(f, "  velocity  horizontal {horizontal}, vertical too {all}")?,
    }
    writeln!(f, "  sigmas    position {}", of_all(|fix| fix.position_sigma_m.is_some()))?;
    writeln!(f, "            velocity {}", of_all(|fix| fix.velocity_sigma_mps.is_some()))?;
    writeln!(f, "  antenna   {} m from the CG", arm(gps.antenna_lever_arm_m.to_array()))?;
    writeln!(f, "  latency   {:.3} s", gps.latency_s)?;
    writeln!(
        f,
        "  first     {:.7}°, {:.7}°, {:.2} m",
        first.position.latitude_deg(),
        first.position.longitude_deg(),
        first.position.height_m
    )?;
    let mut least = [0.0; 3];
    let mut most = [0.0; 3];
    for fix in &dataset.fixes {
        let from_first = fix.position.displacement_from(&first.position).to_array();
        for axis in 0..3 {
            least[axis] = f64::min(least[axis], from_first[axis]);
            most[axis] = f64::max(most[axis], from_first[axis]);
        }
    }
    writeln!(
        f,
        "  extent    north {:.1} to {:.1} m, east {:.1} to {:.1} m, up {:.1} to {:.1} m",
        least[0], most[0], least[1], most[1], -most[2], -least[2]
    )
}

/// Angular rate, rad/s, and specific force, m/s², of each sample.
pub(crate) fn rates(samples: impl IntoIterator<Item = ImuSample>) -> Vec<[f64; 6]> {
    let rates = crate::rates::rates(samples);
    let six = |at: &crate::rates::Rates| {
        let ([p, q, r], [x, y, z]) = (at.turn_radps, at.force_mps2);
        [p, q, r, x, y, z]
    };
    rates.iter().map(six).collect()
}

/// Root mean square of second differences over √6, per component: the standard deviation of white
/// noise; slow motion cancels. `None` of fewer than three samples.
pub(crate) fn vibration(rates: &[[f64; 6]]) -> Option<[f64; 6]> {
    let count = rates.len().checked_sub(2).filter(|count| *count > 0)?;
    Some(std::array::from_fn(|component| {
        let square_sum: f64 = rates
            .windows(3)
            .map(|three| three[0][component] - 2.0 * three[1][component] + three[2][component])
            .map(|difference| difference * difference)
            .sum();
        (square_sum / (6.0 * count as f64)).sqrt()
    }))
}

/// Number of `items` for which `has` holds, in words.
fn share<T>(items: &[T], has: fn(&T) -> bool) -> String {
    counted(items.iter().filter(|item| has(item)).count(), items.len())
}

/// `some` of `all`, in words.
fn counted(some: usize, all: usize) -> String {
    match some {
        0 => "none".into(),
        some if some == all => "all".into(),
        some => format!("{some} of {all}"),
    }
}

fn arm([forward, right, down]: [f64; 3]) -> String {
    format!("forward {forward}, right {right}, down {down}")
}

/// Writes `text` wrapped to 80 columns after `lead`; further lines are indented by its width.
///
/// # Errors
/// Errors of the formatter.
pub fn paragraph(f: &mut fmt::Formatter<'_>, lead: &str, text: &str) -> fmt::Result {
    let indent = lead.chars().count();
    f.write_str(lead)?;
    let mut column = indent;
    for (index, word) in text.split_whitespace().enumerate() {
        let length = word.chars().count();
        if index > 0 && column + 1 + length > WIDTH {
            write!(f, "\n{:indent$}", "")?;
            column = indent;
        } else if index > 0 {
            f.write_str(" ")?;
            column += 1;
        }
        f.write_str(word)?;
        column += length;
    }
    writeln!(f)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use hovernav::frames::Vector;

    fn heli_hover() -> Dataset {
        let dir = concat!(env!("CARGO_MANIFEST_DIR"), "/../../datasets/heli-hover");
        Dataset::open(dir.as_ref()).unwrap()
    }

    /// Reproducible pseudo-random numbers, uniform, of unit variance.
    fn noise() -> impl Iterator<Item = f64> {
        let mut state = 1u64;
        std::iter::repeat_with(move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            ((state >> 11) as f64 / (1u64 << 53) as f64 - 0.5) * 12f64.sqrt()
        })
    }

    #[test]
    fn the_hover_flight_is_described_within_the_terminal() {
        let mut dataset = heli_hover();
        dataset.imu.drain(3000..3100);
        dataset.warnings.push("gps.csv: ".to_string() + &"some words ".repeat(20));
        let text = Info(&dataset).to_string();
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
    fn vibration_is_noise_and_not_motion() {
        let noise: Vec<f64> = noise().take(20_000).collect();
        let of = |value: &dyn Fn(f64, f64) -> f64| {
            let rows = noise.iter().enumerate();
            let rows: Vec<[f64; 6]> =
                rows.map(|(index, noise)| [value(index as f64 * 0.01, *noise); 6]).collect();
            vibration(&rows).unwrap()[0]
        };
        assert_abs_diff_eq!(of(&|_, noise| 0.3 * noise), 0.3, epsilon = 0.01);
        assert!(of(&|time_s, _| 5.0 * (0.5 * time_s).sin()) < 1e-3);
        assert_eq!(vibration(&[[0.0; 6]; 2]), None);
    }

    #[test]
    fn increments_are_described_as_rates() {
        let samples: Vec<ImuSample> = (0..3)
            .map(|index| {
                ImuSample::new(
                    Time::from_nanoseconds(index * 10_000_000),
                    Motion::Increments {
                        angle_rad: Vector::new(0.001, 0.0, 0.0),
                        velocity_mps: Vector::new(0.0, 0.0, -0.0981),
                    },
                )
            })
            .collect();
        let rates = rates(samples);
        assert_eq!(rates.len(), 2);
        assert_abs_diff_eq!(rates[0][0], 0.1, epsilon = 1e-12);
        assert_abs_diff_eq!(rates[0][5], -9.81, epsilon = 1e-12);
    }

    #[test]
    fn a_dataset_of_nothing_is_described_too() {
        assert!(Info(&Dataset::default()).to_string().contains("sensor"));
    }
}
