//! A mapping as a commented file.

use std::fmt::Write as _;
use std::path::{Component, Path, PathBuf};

use crate::text::{MAPPING_FILE, Mapping, TableMapping, Triad};
use hovernav_log::LogError;

/// Writes the mapping and a commented manifest into `directory`.
pub(crate) fn write(
    mapping: &Mapping,
    doubts: &[String],
    directory: &Path,
    force: bool,
) -> Result<(), LogError> {
    std::fs::create_dir_all(directory).map_err(LogError::io(directory))?;
    let path = directory.join(MAPPING_FILE);
    if path.exists() && !force {
        let reason = "is there already, and may hold your changes; expected --force to replace it";
        return Err(LogError::Unusable { path, reason: reason.into() });
    }
    let mut mapping = mapping.clone();
    for table in &mut mapping.table {
        table.file = relative(&table.file, directory)?;
    }
    std::fs::write(&path, text(&mapping, doubts)).map_err(LogError::io(&path))?;
    let manifest = directory.join("dataset.toml");
    if !manifest.exists() {
        std::fs::write(&manifest, MANIFEST).map_err(LogError::io(&manifest))?;
    }
    Ok(())
}

/// The path that leads from `directory` to `file`; the whole path where nothing shorter does.
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

/// The mapping as text that reads back as the same.
pub(crate) fn text(mapping: &Mapping, doubts: &[String]) -> String {
    let mut out = String::from(
        "# What the columns of these files are, as `hovernav init` understood them. Change what is\n\
         # wrong; every key is explained by `hovernav config mapping.toml`.\n",
    );
    for doubt in doubts {
        let _ = writeln!(out, "# Check: {doubt}");
    }
    for table in &mapping.table {
        write_table(&mut out, table);
    }
    out
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

/// A number that TOML takes for one with a fraction.
fn float(value: f64) -> String {
    format!("{value:?}")
}

fn write_table(out: &mut String, table: &TableMapping) {
    let mut put = |line: String| {
        out.push_str(&line);
        out.push('\n');
    };
    put("\n[[table]]".into());
    put(format!("file = {}", quoted(&table.file.to_string_lossy())));
    put(format!(
        "delimiter = {}  # comma, semicolon, tab or spaces",
        quoted(table.delimiter.name())
    ));
    if table.decimal_comma {
        put("decimal_comma = true".into());
    }
    put(format!("header_line = {}  # line of the names; 0: columns by number", table.header_line));
    put("\n[table.time]".into());
    put(format!("column = {}", quoted(&table.time.column)));
    put(format!("unit = {}  # s, ms, us, ns, or clock", quoted(table.time.unit.name())));
    put(
        "# scale = \"gps\"  # seconds of GPS time since 1980, brought to UTC with the leap seconds"
            .into(),
    );
    put("# offset_s = 0.0  # added, to bring this file to the clock of the others".into());
    if let Some(gyro) = &table.gyro {
        put("\n[table.gyro]".into());
        let unit = gyro.unit.name();
        put_triad(&mut put, gyro, unit, "rad/s, deg/s; rad, deg for increments");
    }
    if let Some(accel) = &table.accel {
        put("\n[table.accel]".into());
        let unit = accel.unit.name();
        put_triad(&mut put, accel, unit, "m/s2, g, mg; m/s for increments");
    }
    if let Some(mag) = &table.mag {
        put("\n[table.mag]".into());
        put_triad(&mut put, mag, mag.unit.name(), "gauss, mG, uT, nT, T");
    }
    if let Some(attitude) = &table.attitude {
        put("\n[table.attitude]".into());
        if attitude.quaternion.is_empty() {
            put(format!("columns = {}", list(&attitude.columns)));
            put(format!("unit = {}  # deg or rad", quoted(attitude.unit.name())));
            let signs = attitude.signs.map(float).join(", ");
            put(format!("signs = [{signs}]  # of roll, pitch, yaw"));
            put(format!("yaw_offset_deg = {}", float(attitude.yaw_offset_deg)));
        } else {
            put(format!("quaternion = {}  # scalar first", list(&attitude.quaternion)));
            put(format!("world = {}  # ned or enu", quoted(attitude.world.name())));
        }
        put(format!(
            "role = {}  # unit: a measurement; onboard: to compare with",
            quoted(attitude.role.name())
        ));
    }
    if let Some(gps) = &table.gps {
        put("\n[table.gps]".into());
        let mut named = |key: &str, name: &str| {
            if !name.is_empty() {
                put(format!("{key} = {}", quoted(name)));
            }
        };
        named("latitude", &gps.latitude);
        named("longitude", &gps.longitude);
        named("unit", gps.unit.name());
        named("height", &gps.height);
        named("height_unit", gps.height_unit.name());
        named("height_above", gps.height_above.name());
        named("north", &gps.north);
        named("east", &gps.east);
        named("down", &gps.down);
        named("up", &gps.up);
        named("speed", &gps.speed);
        named("course", &gps.course);
        named("speed_unit", gps.speed_unit.name());
        named("sigma_horizontal", &gps.sigma_horizontal);
        named("sigma_vertical", &gps.sigma_vertical);
        named("sigma_unit", gps.sigma_unit.name());
        named("sigma_speed", &gps.sigma_speed);
        named("sigma_vertical_speed", &gps.sigma_vertical_speed);
        named("fix_type", &gps.fix_type);
        named("satellites", &gps.satellites);
        put(format!("geoid_separation_m = {}", float(gps.geoid_separation_m)));
        put(format!("held = {}  # whether rows repeat the last fix", gps.held));
    }
    if let Some(baro) = &table.baro {
        put("\n[table.baro]".into());
        put(format!("column = {}", quoted(&baro.column)));
        put(format!("unit = {}  # m, ft, Pa, hPa, kPa", quoted(baro.unit.name())));
        put(format!("held = {}", baro.held));
    }
    if let Some(controls) = &table.controls {
        put("\n[table.controls]".into());
        put(format!(
            "columns = {}  # lateral, longitudinal, collective, pedal",
            list(&controls.columns)
        ));
        put(format!("unit = {}  # fraction or percent", quoted(controls.unit.name())));
        put(format!("signs = [{}]", controls.signs.map(float).join(", ")));
    }
}

fn put_triad<U>(put: &mut impl FnMut(String), triad: &Triad<U>, unit: &str, units: &str) {
    let axes: [String; 3] = triad.axes.into();
    put(format!("columns = {}", list(&triad.columns)));
    put(format!("unit = {}  # {units}", quoted(unit)));
    put(format!("axes = {}  # which of them point forward, right, down", list(&axes)));
    if triad.held {
        put("held = true  # rows repeat the last value".into());
    }
}

/// The manifest that a new log begins with.
const MANIFEST: &str = r#"# What the vehicle and its sensors are. Every key has a default; what is worth setting stands here
# with it, commented out. All of them: `hovernav config dataset.toml`.

# name = "first flight"
# vehicle = "which vehicle, and what it did"
# date = 2026-01-31        # for the magnetic declination

[imu]
# lever_arm_m = [0.0, 0.0, 0.0]          # the unit from the centre of gravity: forward, right, down, m
# heading_reference = "true"             # what the unit's own yaw is measured from: true or magnetic
# angle_random_walk_deg_per_sqrt_h = 0.5 # from the data sheet, as are the keys below
# velocity_random_walk_mps_per_sqrt_h = 0.1
# gyro_bias_sigma_degps = 0.25
# accel_bias_sigma_mps2 = 0.1
# gyro_range_degps = 500.0
# accel_range_g = 8.0

[gps]
# antenna_lever_arm_m = [0.0, 0.0, 0.0]  # the antenna from the centre of gravity, m
# latency_s = 0.0                        # how much earlier than its row a fix was true, s

[solution]
# point = "cg"                           # whose position and velocity the solution gives: cg or imu
"#;
