//! Text of a proposal for the terminal.

use std::fmt;

use super::turn::name;
use crate::text::{AttitudeRole, GpsColumns, HeightAbove, TableMapping, TimeColumn};
use hovernav::time::Time;
use hovernav_dataset::Dataset;
use hovernav_findings::SampleRates;

/// Largest number of unused columns whose names are listed.
const UNUSED_SHOWN: usize = 12;

/// The paragraph about one file.
pub(crate) fn table(table: &TableMapping, unused: &[String], dataset: &Dataset) -> String {
    if table.capture {
        let (file, fixes) = (table.file.display(), dataset.fixes.len());
        return format!("{file}: capture of a receiver\n  gps       {fixes} fixes, in UTC");
    }
    let mut lines = Vec::new();
    let mut line = |what: &str, columns: &str, rest: String| {
        lines.push(format!("  {what:<9} {columns:<34} {rest}"));
    };
    let names = match table.header_line {
        0 => "no column names, columns by number".to_owned(),
        line => format!("names on line {line}"),
    };
    let TimeColumn { date, week, column, nanoseconds, .. } = &table.time;
    let time = named([date, week, column, nanoseconds]);
    line("time", &time, table.time.unit.name().to_owned());
    let held = |held: bool| if held { ", rows repeat the last value" } else { "" };
    if let Some(gyro) = &table.gyro {
        let rest = format!("{}, {}{}", gyro.unit.name(), name(gyro.axes), held(gyro.held));
        line("gyro", &gyro.columns.join(" "), rest);
    }
    if let Some(accel) = &table.accel {
        let rest = format!("{}, {}{}", accel.unit.name(), name(accel.axes), held(accel.held));
        line("accel", &accel.columns.join(" "), rest);
    }
    if let Some(gravity) = &table.gravity {
        let rest = format!("{}, {}", gravity.unit.name(), name(gravity.axes));
        line("gravity", &gravity.columns.join(" "), rest);
    }
    if let Some(mag) = &table.mag {
        let rest = format!("{}, {}{}", mag.unit.name(), name(mag.axes), held(mag.held));
        line("mag", &mag.columns.join(" "), rest);
    }
    if let Some(attitude) = &table.attitude {
        let role = match attitude.role {
            AttitudeRole::Unit => "from the IMU",
            AttitudeRole::Onboard => "from an estimator, for comparison",
        };
        let columns = [&attitude.columns[..], &attitude.quaternion[..]].concat().join(" ");
        let signs = attitude.signs.map(|sign| if sign < 0.0 { '-' } else { '+' });
        let signs: String = signs.into_iter().collect();
        line("attitude", &columns, format!("{}, {role}, signs {signs}", attitude.unit.name()));
    }
    if let Some(gps) = &table.gps {
        let above = match gps.height_above {
            HeightAbove::Ellipsoid => "above the ellipsoid",
            HeightAbove::Sea => "above the sea",
        };
        let place =
            named([&gps.latitude, &gps.north_south, &gps.longitude, &gps.east_west, &gps.height]);
        let rest = format!(
            "{}, {} {above}, {} fixes{}",
            gps.unit.name(),
            gps.height_unit.name(),
            dataset.fixes.len(),
            held(gps.held)
        );
        line("gps", &place, rest);
        let velocity = named([&gps.north, &gps.east, &gps.speed, &gps.course, &gps.down, &gps.up]);
        if !velocity.is_empty() {
            let course = match gps.course.as_str() {
                "" => String::new(),
                _ => format!(", {}", gps.course_unit.name()),
            };
            let vertical =
                gps.vertical_unit.map_or_else(String::new, |unit| format!(", {}", unit.name()));
            line("", &velocity, format!("{}{course}{vertical}", gps.speed_unit.name()));
        }
        let GpsColumns { sigma_horizontal, sigma_vertical, sigma_north, .. } = gps;
        let position = [sigma_north, &gps.sigma_east, &gps.sigma_down];
        let position = named(position) + &named([sigma_horizontal, sigma_vertical]);
        if !position.is_empty() {
            line("", &position, format!("{}, one-sigma", gps.sigma_unit.name()));
        }
        let GpsColumns { sigma_velocity_north, sigma_velocity_east, sigma_velocity_down, .. } = gps;
        let velocity = [sigma_velocity_north, sigma_velocity_east, sigma_velocity_down];
        let velocity = named(velocity) + &named([&gps.sigma_speed, &gps.sigma_vertical_speed]);
        if !velocity.is_empty() {
            let unit = gps.sigma_speed_unit.unwrap_or(gps.speed_unit);
            line("", &velocity, format!("{}, one-sigma", unit.name()));
        }
    }
    if let Some(velocity) = &table.velocity {
        let rest = format!("{}, {}, of the fixes", velocity.unit.name(), velocity.world.name());
        line("velocity", &velocity.columns.join(" "), rest);
    }
    if let Some(baro) = &table.baro {
        line("baro", &baro.column, format!("{}{}", baro.unit.name(), held(baro.held)));
    }
    if let Some(controls) = &table.controls {
        line("controls", &controls.columns.join(" "), controls.unit.name().to_owned());
    }
    if !unused.is_empty() {
        let shown = &unused[..unused.len().min(UNUSED_SHOWN)];
        let more = unused.len() - shown.len();
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        line("unused", &(shown.join(" ") + &more), String::new());
    }
    let decimal = if table.decimal_comma { ", decimal commas" } else { "" };
    let head = format!("{}: {}{decimal}, {names}", table.file.display(), table.delimiter.name());
    format!("{head}\n{}", lines.iter().map(|l| l.trim_end()).collect::<Vec<_>>().join("\n"))
}

/// The names of the columns that exist, separated by spaces.
fn named<const N: usize>(columns: [&String; N]) -> String {
    let there = columns.into_iter().filter(|name| !name.is_empty());
    there.map(String::as_str).collect::<Vec<_>>().join(" ")
}

/// Whether the fixes and the inertial samples do not overlap in time.
pub(crate) fn are_apart(dataset: &Dataset) -> bool {
    let (fixes, imu) = (&dataset.fixes, &dataset.imu);
    let fixes = fixes.first().zip(fixes.last()).map(|(first, last)| (first.time, last.time));
    let imu = imu.first().zip(imu.last()).map(|(first, last)| (first.time, last.time));
    fixes.zip(imu).is_some_and(|(fixes, imu)| fixes.1 < imu.0 || fixes.0 > imu.1)
}

/// Reports the sensors' rates and time spans, and whether the spans overlap. `unused` are the names of unused columns.
pub(crate) fn spans(
    dataset: &Dataset,
    unused: &[&str],
    findings: &mut Vec<String>,
    checks: &mut Vec<String>,
) {
    let imu: Vec<Time> = dataset.imu.iter().map(|sample| sample.time).collect();
    let fixes: Vec<Time> = dataset.fixes.iter().map(|fix| fix.time).collect();
    for (name, times) in [("inertial samples", &imu), ("fixes", &fixes)] {
        if let [first, .., last] = times[..] {
            findings.push(format!(
                "{} {name} from {:.3} to {:.3} s, {:.2} Hz",
                times.len(),
                first.seconds(),
                last.seconds(),
                (times.len() - 1) as f64 / (last - first)
            ));
        }
    }
    if imu.is_empty() {
        checks.push(
            "no gyro with accelerometer: the log cannot be estimated, only shown or used for \
             scoring"
                .into(),
        );
        return;
    }
    if fixes.is_empty() {
        checks.push(format!(
            "no fixes: the filter needs at least one to start from{}",
            local_positions(unused)
        ));
        return;
    }
    if are_apart(dataset) {
        checks.push(format!(
            "the fixes and the inertial samples do not overlap in time: check unit and scale under \
             each [table.time], or set its offset_s. GPS time counts from 1980 and is 18 s ahead \
             of UTC. If both began at the same moment, offset_s = {:.3} for the inertial samples",
            fixes[0] - imu[0]
        ));
    }
    let rate_hz = (imu.len() - 1) as f64 / (imu[imu.len() - 1] - imu[0]);
    let rates = SampleRates::of(&dataset.imu[0].motion);
    if rate_hz < rates.least_hz {
        checks.push(format!(
            "inertial samples: found {rate_hz:.1} Hz, expected at least {:.0} Hz to navigate",
            rates.least_hz
        ));
    } else if rate_hz < rates.poor_hz {
        checks.push(format!(
            "inertial samples: found {rate_hz:.1} Hz; navigation is poor below {:.0} Hz",
            rates.poor_hz
        ));
    }
}

/// The next step, as the end of a sentence, if two columns are positions in metres: projected ones, or those from a
/// local origin. Otherwise empty.
fn local_positions(unused: &[&str]) -> String {
    const PROJECTED: [&str; 2] = ["easting", "northing"];
    const LOCAL: [[&str; 2]; 6] = [
        ["east", "north"],
        ["e", "n"],
        ["tx", "ty"],
        ["px", "py"],
        ["pos x", "pos y"],
        ["position x", "position y"],
    ];
    let named = |part: &str| {
        unused.iter().find(|name| {
            let words: Vec<String> = name
                .to_lowercase()
                .split(|letter: char| !letter.is_ascii_alphanumeric())
                .map(str::to_owned)
                .collect();
            let part: Vec<&str> = part.split(' ').collect();
            words.windows(part.len()).any(|found| found == part)
        })
    };
    let pair = |parts: [&str; 2]| named(parts[0]).zip(named(parts[1]));
    if let Some((east, north)) = pair(PROJECTED) {
        return format!(
            ". {east} and {north} are projected coordinates: convert them to latitude and longitude, those of UTM with \
             `cs2cs EPSG:326ZZ EPSG:4326` (ZZ: zone; 327ZZ in the south), and run `hovernav init` again"
        );
    }
    let Some((x, y)) = LOCAL.into_iter().find_map(pair) else { return String::new() };
    format!(
        ". {x} and {y} are positions from a local origin: write columns lat = LAT + north / 111200 and lon = LON + \
         east / (111300 cos LAT), with LAT and LON of the origin in degrees, and run `hovernav init` again"
    )
}

/// Writes the description of each file, then the findings and the points to check.
pub(crate) fn write(
    f: &mut fmt::Formatter<'_>,
    tables: &[String],
    findings: &[String],
    checks: &[String],
) -> fmt::Result {
    for table in tables {
        writeln!(f, "{table}\n")?;
    }
    for finding in findings {
        writeln!(f, "found: {finding}")?;
    }
    for check in checks {
        writeln!(f, "check: {check}")?;
    }
    Ok(())
}
