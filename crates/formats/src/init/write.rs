//! Writes a mapping as a commented file.

use std::fmt::{Display, Write as _};
use std::path::{Component, Path, PathBuf};

use crate::text::{
    AttitudeColumns, GpsColumns, MAPPING_FILE, Mapping, TableMapping, TimeScale, Triad,
};
use hovernav_dataset::LogError;
use hovernav_toml::write_whole;

/// Writes the mapping and a commented manifest into `directory`.
pub(crate) fn write(
    mapping: &Mapping,
    checks: &[String],
    directory: &Path,
    force: bool,
) -> Result<(), LogError> {
    std::fs::create_dir_all(directory).map_err(LogError::io(directory))?;
    let path = directory.join(MAPPING_FILE);
    if path.exists() && !force {
        let reason = "exists and may contain your changes; use --force to replace it";
        return Err(LogError::Unusable { path, reason: reason.into() });
    }
    let mut mapping = mapping.clone();
    for table in &mut mapping.table {
        table.file = relative(&table.file, directory)?;
    }
    write_whole(&path, text(&mapping, checks)).map_err(LogError::io(&path))?;
    let manifest = directory.join("dataset.toml");
    if !manifest.exists() {
        write_whole(&manifest, MANIFEST).map_err(LogError::io(&manifest))?;
    }
    Ok(())
}

/// The relative path from `directory` to `file`; the absolute path if both share only the root.
fn relative(file: &Path, directory: &Path) -> Result<PathBuf, LogError> {
    let file = file.canonicalize().map_err(LogError::io(file))?;
    let from = directory.canonicalize().map_err(LogError::io(directory))?;
    let shared = from.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    if shared <= 1 {
        return Ok(file);
    }
    let up = from.components().skip(shared).map(|_| Component::ParentDir);
    Ok(up.chain(file.components().skip(shared)).collect())
}

/// The mapping as TOML text; reading it returns the same mapping.
pub(crate) fn text(mapping: &Mapping, checks: &[String]) -> String {
    let mut lines = Lines(String::new());
    lines.line(
        "# Columns, units and axes of these files, as proposed by `hovernav init`. Correct any \
         errors;",
    );
    lines.line("# `hovernav config mapping.toml` explains every key.");
    for check in checks {
        // A column name may contain control characters; a TOML comment may not.
        let check = check.replace(char::is_control, " ");
        lines.line(format_args!("# Check: {check}"));
    }
    for table in &mapping.table {
        lines.table(table);
    }
    lines.0
}

/// A string as TOML spells it.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => out.extend(['\\', letter]),
            letter if letter.is_control() => {
                let _ = write!(out, "\\u{:04X}", u32::from(letter));
            }
            letter => out.push(letter),
        }
    }
    out.push('"');
    out
}

fn list(texts: &[String]) -> String {
    format!("[{}]", texts.iter().map(|text| quoted(text)).collect::<Vec<_>>().join(", "))
}

/// A number that TOML reads as a float.
fn float(value: &f64) -> String {
    format!("{value:?}")
}

fn floats(values: &[f64]) -> String {
    format!("[{}]", values.iter().map(float).collect::<Vec<_>>().join(", "))
}

/// The text of a mapping while it is written.
struct Lines(String);

impl Lines {
    /// Appends a line and its line end.
    fn line(&mut self, line: impl Display) {
        let _ = writeln!(self.0, "{line}");
    }

    /// Appends an empty line and the heading of a section of a table.
    fn part(&mut self, name: &str) {
        self.line(format_args!("\n[table.{name}]"));
    }

    fn key(&mut self, key: &str, value: impl Display) {
        self.line(format_args!("{key} = {value}"));
    }

    /// Appends a key with a trailing comment.
    fn remarked(&mut self, key: &str, value: impl Display, remark: &str) {
        self.line(format_args!("{key} = {value}  # {remark}"));
    }

    fn table(&mut self, table: &TableMapping) {
        self.line("\n[[table]]");
        self.key("file", quoted(&table.file.to_string_lossy()));
        if table.capture {
            self.remarked("capture", true, "NMEA 0183, UBX or TSIP of a receiver, in UTC");
            self.part("time");
            return self.line("# offset_s = 0.0  # added to the times of this file");
        }
        let delimiter = quoted(table.delimiter.name());
        self.remarked("delimiter", delimiter, "comma, semicolon, tab or spaces");
        if table.decimal_comma {
            self.key("decimal_comma", true);
        }
        let header_line = table.header_line;
        self.remarked(
            "header_line",
            header_line,
            "line number of the names; 0: no names, columns \
                                                   by number",
        );
        if let Some(instance) = table.instance {
            self.key("instance_column", quoted(&table.instance_column));
            self.remarked("instance", instance, "rows of other sensors are ignored");
        }
        self.part("time");
        self.key("column", quoted(&table.time.column));
        let unit = quoted(table.time.unit.name());
        self.remarked(
            "unit",
            unit,
            "s, ms, us, ns, 0.1ms, days, excel, datenum, mjd, filetime, ticks, clock, hhmmss for a time of day as one \
             number, or count",
        );
        if let Some(rate_hz) = &table.time.rate_hz {
            self.remarked("rate_hz", float(rate_hz), "counts per second");
        }
        if !table.time.date.is_empty() {
            self.key("date", quoted(&table.time.date));
        }
        if !table.time.nanoseconds.is_empty() {
            self.key("nanoseconds", quoted(&table.time.nanoseconds));
        }
        if !table.time.week.is_empty() {
            self.key("week", quoted(&table.time.week));
        }
        let scale = match table.time.scale {
            TimeScale::Own => "# scale = \"gps\"",
            TimeScale::Gps => "scale = \"gps\"",
        };
        let remark = "# seconds of GPS time since 1980, converted to UTC with the leap seconds";
        self.line(format_args!("{scale}  {remark}"));
        self.line(
            "# offset_s = 0.0  # added to the times of this file to match the clock of the \
                   others",
        );
        if let Some(gyro) = &table.gyro {
            let units = "rad/s, deg/s; rad, deg for increments";
            self.triad("gyro", gyro, gyro.unit.name(), units);
        }
        if let Some(accel) = &table.accel {
            let units = "m/s2, g, mg; m/s for increments";
            self.triad("accel", accel, accel.unit.name(), units);
        }
        if let Some(gravity) = &table.gravity {
            self.triad("gravity", gravity, gravity.unit.name(), "m/s2, g, mg");
        }
        if let Some(mag) = &table.mag {
            self.triad("mag", mag, mag.unit.name(), "gauss, mG, uT, nT, T");
        }
        if let Some(attitude) = &table.attitude {
            self.attitude(attitude);
        }
        if let Some(gps) = &table.gps {
            self.gps(gps);
        }
        if let Some(velocity) = &table.velocity {
            self.part("velocity");
            self.remarked("columns", list(&velocity.columns), "of the fixes of another file");
            self.key("unit", quoted(velocity.unit.name()));
            self.remarked("world", quoted(velocity.world.name()), "ned or enu");
        }
        if let Some(baro) = &table.baro {
            self.part("baro");
            self.key("column", quoted(&baro.column));
            self.remarked("unit", quoted(baro.unit.name()), "m, ft, cm, Pa, hPa, kPa");
            self.key("held", baro.held);
        }
        if let Some(controls) = &table.controls {
            self.part("controls");
            let columns = list(&controls.columns);
            self.remarked("columns", columns, "lateral, longitudinal, collective, pedal");
            self.remarked("unit", quoted(controls.unit.name()), "fraction or percent");
            self.key("signs", floats(&controls.signs));
        }
    }

    fn triad<U>(&mut self, sensor: &str, triad: &Triad<U>, unit: &str, units: &str) {
        self.part(sensor);
        let axes: [String; 3] = triad.axes.into();
        self.key("columns", list(&triad.columns));
        self.remarked("unit", quoted(unit), units);
        if triad.counts_per_unit != 1.0 {
            self.key("counts_per_unit", float(&triad.counts_per_unit));
        }
        self.remarked("axes", list(&axes), "the axes that point forward, right, down");
        if triad.held {
            self.remarked("held", true, "rows repeat the last value");
        }
    }

    fn attitude(&mut self, attitude: &AttitudeColumns) {
        self.part("attitude");
        if attitude.quaternion.is_empty() {
            self.key("columns", list(&attitude.columns));
            self.remarked("unit", quoted(attitude.unit.name()), "deg or rad");
            self.remarked("signs", floats(&attitude.signs), "of roll, pitch, yaw");
            self.key("yaw_offset_deg", float(&attitude.yaw_offset_deg));
        } else {
            self.remarked("quaternion", list(&attitude.quaternion), "scalar first");
            self.remarked("world", quoted(attitude.world.name()), "ned or enu");
        }
        let role = quoted(attitude.role.name());
        self.remarked("role", role, "unit: a measurement; onboard: for comparison only");
    }

    fn gps(&mut self, gps: &GpsColumns) {
        self.part("gps");
        for (key, name) in [
            ("latitude", &*gps.latitude),
            ("longitude", &gps.longitude),
            ("unit", gps.unit.name()),
            ("north_south", &gps.north_south),
            ("east_west", &gps.east_west),
            ("height", &gps.height),
            ("height_unit", gps.height_unit.name()),
            ("height_above", gps.height_above.name()),
            ("geoid_separation", &gps.geoid_separation),
            ("north", &gps.north),
            ("east", &gps.east),
            ("down", &gps.down),
            ("up", &gps.up),
            ("speed", &gps.speed),
            ("course", &gps.course),
            ("course_unit", if gps.course.is_empty() { "" } else { gps.course_unit.name() }),
            ("speed_unit", gps.speed_unit.name()),
            ("vertical_unit", gps.vertical_unit.map_or("", |unit| unit.name())),
            ("sigma_horizontal", &gps.sigma_horizontal),
            ("sigma_vertical", &gps.sigma_vertical),
            ("sigma_north", &gps.sigma_north),
            ("sigma_east", &gps.sigma_east),
            ("sigma_down", &gps.sigma_down),
            ("sigma_unit", gps.sigma_unit.name()),
            ("sigma_speed", &gps.sigma_speed),
            ("sigma_vertical_speed", &gps.sigma_vertical_speed),
            ("sigma_velocity_north", &gps.sigma_velocity_north),
            ("sigma_velocity_east", &gps.sigma_velocity_east),
            ("sigma_velocity_down", &gps.sigma_velocity_down),
            ("sigma_speed_unit", gps.sigma_speed_unit.map_or("", |unit| unit.name())),
            ("fix_type", &gps.fix_type),
            ("satellites", &gps.satellites),
        ] {
            if !name.is_empty() {
                self.key(key, quoted(name));
            }
        }
        if !gps.unknown.is_empty() {
            self.key("unknown", floats(&gps.unknown));
        }
        self.key("geoid_separation_m", float(&gps.geoid_separation_m));
        self.remarked("held", gps.held, "whether rows repeat the last fix");
    }
}

/// The manifest for a new log.
const MANIFEST: &str = r#"# The vehicle and its sensors. Every key has a default.
# The most useful keys are listed here with their defaults, commented out.
# All keys: `hovernav config dataset.toml`.

# name = "first flight"
# vehicle = "the vehicle and its flight"
# vehicle_kind = "multirotor"            # helicopter, multirotor, fixed-wing, wheeled, boat or handheld
# date = 2026-01-31        # for the magnetic declination

[imu]
# lever_arm_m = [0.0, 0.0, 0.0]          # IMU position from the centre of gravity: forward, right, down, m
# heading_reference = "true"             # north of the IMU's own yaw: true or magnetic
# angle_random_walk_deg_per_sqrt_h = 0.5 # this and the keys below: from the data sheet
# velocity_random_walk_mps_per_sqrt_h = 0.1
# gyro_bias_sigma_degps = 0.25
# accel_bias_sigma_mps2 = 0.1
# gyro_range_degps = 500.0
# accel_range_g = 8.0

[gps]
# antenna_lever_arm_m = [0.0, 0.0, 0.0]  # antenna position from the centre of gravity, m
# latency_s = 0.0                        # delay from the measurement of a fix to the time in its row, s

[solution]
# point = "cg"                           # point whose position and velocity the solution contains: cg or imu
"#;
