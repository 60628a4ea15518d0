//! Proposes a mapping for foreign text files from their column names and values.

mod attitude;
mod axis_names;
mod baro;
mod columns;
mod gps;
mod instance;
mod known;
mod look;
mod names;
mod numbered;
mod place;
mod quantity;
mod rates;
mod report;
mod sigma_names;
mod time;
mod together;
mod travel;
mod turn;
mod unit_names;
mod units;
mod unknown_places;
mod unnamed;
mod words;
mod write;

use std::path::{Path, PathBuf};

use crate::directory::files;
use crate::text::{Mapping, TableMapping, TimeScale, TimeUnit, World};
use columns::Understood;
use hovernav_dataset::{Dataset, LogError, Manifest};
use travel::StatedUnits;
use turn::Turn;

/// The result of `hovernav init` for foreign text files.
#[derive(Debug)]
pub struct Proposal {
    /// The columns of each quantity, with units and axes; file paths as given.
    mapping: Mapping,
    /// A description of each file, one paragraph each.
    tables: Vec<String>,
    /// Conclusions from the data, one sentence each.
    findings: Vec<String>,
    /// Assumptions that the user should check, one sentence each.
    checks: Vec<String>,
}

impl Proposal {
    /// Proposes columns, units, axes and signs for the files `named`. The evidence is column names, magnitudes, gravity, and
    /// rotation shared by gyro, attitude and magnetic field. If several axis choices remain, the filter runs with each,
    /// and the one with the smallest innovations is chosen.
    ///
    /// # Errors
    /// [`LogError`] if a file cannot be read, or no sensor is recognised in it.
    pub fn of(named: &[PathBuf]) -> Result<Self, LogError> {
        let files = expanded(named)?;
        let (mut understood, mut checks, mut first_error) = (Vec::new(), Vec::new(), None);
        for path in &files {
            match columns::understand(path, path) {
                Ok(one) => understood.push(one),
                // A directory of a logger also contains its settings.
                Err(error) if !named.contains(path) => {
                    checks.push(format!("ignored: {error}"));
                    first_error.get_or_insert(error);
                }
                Err(error) => return Err(error),
            }
        }
        if let Some(error) = first_error.filter(|_| understood.is_empty()) {
            return Err(error);
        }
        understood.sort_by_key(|one| one.is_without_gravity);
        keep_the_first(&mut understood, &mut checks);
        let mut findings = Vec::from_iter(add_gravity(&mut understood));
        let has_any = understood.iter().any(|one| {
            let table = &one.mapping;
            table.gyro.is_some() || table.accel.is_some() || table.gps.is_some()
        });
        if understood.iter().all(|one| one.mapping.capture) {
            let reason =
                "found a capture of raw bytes, which needs no mapping, expected text in columns";
            let path = files.first().cloned().unwrap_or_default();
            return Err(LogError::Unusable { path, reason: reason.to_owned() });
        }
        if !has_any {
            let reason =
                "found no gyro, no accelerometer and no latitude, longitude and height among the \
                 columns: name them, as in gyro_x, accel_x, lat, lon, height"
                    .to_owned();
            return Err(LogError::Unusable {
                path: files.first().cloned().unwrap_or_default(),
                reason,
            });
        }
        checks.extend(understood.iter().flat_map(|one| one.checks.iter().cloned()));
        let tables = understood.iter().map(|one| one.mapping.clone()).collect();
        let mut mapping = Mapping { table: tables };
        time::settle_units(&mut mapping, &understood, &mut findings, &mut checks)?;
        units::settle_gyro_columns(&mut mapping, &understood, &mut findings, &mut checks)?;
        let mut dataset = read(&mapping)?;
        if judge_velocity(&mut mapping, &dataset, &mut checks) {
            dataset = read(&mapping)?;
        }
        if report::are_apart(&dataset)
            && let Some((undated, met)) = without_dates(&mapping, &mut findings)?
        {
            (mapping, dataset) = (undated, met);
        }
        let mut stated = stated_units(&understood);
        let is_scalar_moved = attitude::settle_scalar(&mut mapping, &dataset);
        let is_rate_found =
            settle_rate(&mut mapping, &dataset, stated, &understood, &mut findings, &mut checks);
        if is_scalar_moved || is_rate_found {
            dataset = read(&mapping)?;
        }
        let before = mapping.clone();
        if units::settle_gyro(&mut mapping, &dataset, stated, &mut findings, &mut checks) {
            stated.gyro = true;
            checks.retain(|check| !check.starts_with(rates::GYRO_UNSTATED));
        }
        settle_speed_unit(&mut mapping, &dataset, stated, &mut findings, &mut checks)?;
        stated.height = units::settle_height(&mut mapping, &dataset, stated, &mut findings);
        if mapping != before {
            dataset = read(&mapping)?;
        }
        units::settle_vertical(&mut mapping, &mut dataset, stated, &mut findings);
        let found = units::settle_by_filter(
            &mut mapping,
            &mut dataset,
            understood.iter().any(|one| one.is_of_phone),
            &mut stated,
            &mut findings,
            &mut checks,
        );
        units::settle_vertical(&mut mapping, &mut dataset, stated, &mut findings);
        if let Some(gps) = mapping.table.iter().find_map(|table| table.gps.as_ref()) {
            travel::judge_climb(gps, &dataset.fixes, stated, &mut checks);
        }
        units::settle_baro(&mut mapping, &dataset, stated, &mut findings, &mut checks);
        turn_axes(&mut mapping, &found.turn);
        findings.extend(found.findings);
        checks.extend(found.checks);
        let unused = understood.iter().flat_map(|one| one.unused.iter().map(String::as_str));
        report::spans(&dataset, &Vec::from_iter(unused), &mut findings, &mut checks);
        let tables = mapping.table.iter().zip(&understood);
        let tables =
            tables.map(|(table, one)| report::table(table, &one.unused, &dataset)).collect();
        Ok(Self { mapping, tables, findings, checks })
    }

    /// Whether there are a gyro and an accelerometer, which the estimator needs.
    #[must_use]
    pub fn has_motion(&self) -> bool {
        let has = |has: fn(&TableMapping) -> bool| self.mapping.table.iter().any(has);
        has(|table| table.gyro.is_some()) && has(|table| table.accel.is_some())
    }

    /// Whether there are fixes, which the estimator needs.
    #[must_use]
    pub fn has_fixes(&self) -> bool {
        self.mapping.table.iter().any(|table| table.gps.is_some() || table.capture)
    }

    /// Writes `mapping.toml` and a commented `dataset.toml` into `directory`, and creates the directory if it
    /// is missing. An existing `dataset.toml` is kept.
    ///
    /// # Errors
    /// [`LogError::Io`]; [`LogError::Unusable`] if a mapping exists and `force` is not set.
    pub fn write(&self, directory: &Path, force: bool) -> Result<(), LogError> {
        write::write(&self.mapping, &self.checks, directory, force)
    }
}

impl std::fmt::Display for Proposal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        report::write(f, &self.tables, &self.findings, &self.checks)
    }
}

/// `files`, with the text files and captures in each directory instead of the directory.
fn expanded(named: &[PathBuf]) -> Result<Vec<PathBuf>, LogError> {
    let mut expanded = Vec::new();
    for path in named {
        if !path.is_dir() {
            expanded.push(path.clone());
            continue;
        }
        let found = files(path)?;
        if found.is_empty() {
            let reason = "found no text file here or below, expected one that ends in csv, txt, tsv, dat or pos";
            return Err(LogError::Unusable { path: path.clone(), reason: reason.into() });
        }
        expanded.extend(found);
    }
    Ok(expanded)
}

/// Removes the velocities of a file without positions if the positions do not move along them: those of a filter in the
/// vehicle's axes, for example. Otherwise determines their unit. Returns whether it changes the mapping.
fn judge_velocity(mapping: &mut Mapping, dataset: &Dataset, checks: &mut Vec<String>) -> bool {
    let gps = mapping.table.iter().find_map(|table| table.gps.as_ref());
    let is_needed = gps.is_some_and(|gps| gps.north.is_empty() && gps.speed.is_empty());
    let Some(table) = mapping.table.iter_mut().find(|table| table.velocity.is_some()) else {
        return false;
    };
    if !is_needed {
        table.velocity = None;
        return false;
    }
    let Some(velocity) = &mut table.velocity else { return false };
    let file = table.file.display();
    let travelled = travel::travel(&dataset.fixes);
    if travelled.is_some_and(|travelled| travelled.cosine < travel::MIN_COSINE) {
        checks
            .push(format!("the velocity of {file} is ignored: the positions do not move along it"));
        table.velocity = None;
        return true;
    }
    let before = velocity.unit;
    velocity.unit = travelled.and_then(|one| travel::fitting(before, one)).unwrap_or(before);
    let world = match velocity.world {
        World::Enu => "east, north and up",
        World::Ned => "north, east and down",
    };
    checks.push(format!(
        "the velocity of {file} is read as {world} in {}, and as that of the fixes",
        velocity.unit.name()
    ));
    velocity.unit != before
}

/// Determines the rate of a counter from the speed of the receiver in the same file and the distances between its
/// positions. Returns whether it does.
fn settle_rate(
    mapping: &mut Mapping,
    dataset: &Dataset,
    stated: StatedUnits,
    understood: &[Understood],
    findings: &mut Vec<String>,
    checks: &mut Vec<String>,
) -> bool {
    let travelled = travel::travel(&dataset.fixes);
    let Some(travelled) = travelled.filter(|one| one.cosine >= travel::DECISIVE_COSINE) else {
        return false;
    };
    let mut tables = mapping.table.iter_mut().zip(understood);
    let Some((table, one)) = tables.find(|(table, _)| table.gps.is_some()) else { return false };
    let Some(assumed_hz) = one.count_hz else { return false };
    // Three significant digits: positions scatter.
    let rate_hz = assumed_hz / travelled.ratio;
    let digits = 10f64.powf(2.0 - rate_hz.log10().floor());
    let rate_hz = (rate_hz * digits).round() / digits;
    (table.time.unit, table.time.rate_hz) = (TimeUnit::Count, Some(rate_hz));
    checks.retain(|check| !check.starts_with(time::COUNTED));
    let column = &table.time.column;
    findings.push(format!(
        "the speeds agree with the distances between the fixes if {column} counts at {rate_hz} Hz"
    ));
    if !stated.speed {
        checks.push(format!(
            "time: the rate of {column} is from speeds in m/s, a unit that no name states: check rate_hz \
             under [table.time]"
        ));
    }
    true
}

/// The stated units of all sensors, each from the file that has the sensor.
fn stated_units(understood: &[Understood]) -> StatedUnits {
    let of = |has: fn(&TableMapping) -> bool| {
        let one = understood.iter().find(|one| has(&one.mapping));
        one.map_or_else(StatedUnits::default, |one| one.stated)
    };
    StatedUnits {
        baro: of(|table| table.baro.is_some()).baro,
        gyro: of(|table| table.gyro.is_some()).gyro,
        is_gyro_whole: of(|table| table.gyro.is_some()).is_gyro_whole,
        ..of(|table| table.gps.is_some())
    }
}

fn read(mapping: &Mapping) -> Result<Dataset, LogError> {
    let here = Path::new("");
    Ok(crate::text::dataset(here, mapping, Manifest::default(), Vec::new())?.0)
}

/// The mapping without its date and week columns, and its dataset, if the files overlap in time only then. Example: one
/// file has times of day, the other has dates as well.
fn without_dates(
    mapping: &Mapping,
    findings: &mut Vec<String>,
) -> Result<Option<(Mapping, Dataset)>, LogError> {
    let mut undated = mapping.clone();
    let mut left = Vec::new();
    for time in undated.table.iter_mut().map(|table| &mut table.time) {
        left.extend([std::mem::take(&mut time.date), std::mem::take(&mut time.week)]);
        time.scale = TimeScale::Own;
    }
    left.retain(|name| !name.is_empty());
    if left.is_empty() {
        return Ok(None);
    }
    let dataset = read(&undated)?;
    if report::are_apart(&dataset) {
        return Ok(None);
    }
    findings.push(format!(
        "the files overlap in time only without {}, which is ignored: not every file has a date",
        left.join(", ")
    ));
    Ok(Some((undated, dataset)))
}

/// Keeps each sensor of the first file that has it and removes it from later files.
fn keep_the_first(understood: &mut [Understood], checks: &mut Vec<String>) {
    let mut seen = [false; 6];
    for one in understood {
        let table = &mut one.mapping;
        let file = table.file.display().to_string();
        let mut once = |which: usize, name: &str, is_there: bool| {
            let again = is_there && seen[which];
            if again {
                checks.push(format!(
                    "{name} of {file} is ignored: an earlier file has the same sensor"
                ));
            }
            seen[which] |= is_there;
            !again
        };
        table.gyro = table.gyro.take().filter(|_| once(0, "gyro", true));
        table.accel = table.accel.take().filter(|_| once(1, "accel", true));
        table.mag = table.mag.take().filter(|_| once(2, "mag", true));
        table.attitude = table.attitude.take().filter(|_| once(3, "attitude", true));
        table.gps = table.gps.take().filter(|_| once(4, "gps", true));
        table.baro = table.baro.take().filter(|_| once(5, "baro", true));
    }
}

/// Keeps columns of gravity only if the accelerometer does not measure gravity. Then both have one unit, and a sentence
/// reports the sum.
fn add_gravity(understood: &mut [Understood]) -> Option<String> {
    let linear = understood.iter().position(|one| one.mapping.accel.is_some());
    let linear = linear.filter(|at| understood[*at].is_without_gravity);
    let gravity = understood.iter().position(|one| one.mapping.gravity.is_some());
    for (at, one) in understood.iter_mut().enumerate() {
        let is_needed = Some(at) == gravity && linear.is_some();
        one.mapping.gravity = one.mapping.gravity.take().filter(|_| is_needed);
    }
    let TableMapping { gravity, file, .. } = understood[gravity?].mapping.clone();
    let gravity = gravity?;
    let one = &mut understood[linear?];
    one.checks.retain(|check| !check.starts_with("accel: found a median"));
    let accel = one.mapping.accel.as_mut()?;
    accel.unit = gravity.unit;
    Some(format!(
        "{} of {} is without gravity: {} of {} is added, and the sum is the specific force",
        accel.columns.join(" "),
        one.mapping.file.display(),
        gravity.columns.join(" "),
        file.display()
    ))
}

/// Determines the units of the receiver's speed and course from its positions, if `stated` says that neither name nor
/// format states them.
fn settle_speed_unit(
    mapping: &mut Mapping,
    dataset: &Dataset,
    stated: StatedUnits,
    findings: &mut Vec<String>,
    checks: &mut Vec<String>,
) -> Result<(), LogError> {
    let gps_of = |mapping: &Mapping| mapping.table.iter().position(|table| table.gps.is_some());
    let Some(table) = gps_of(mapping) else { return Ok(()) };
    let mut travelled = travel::travel(&dataset.fixes);
    let is_scattered = travelled.is_some_and(|travel| travel.cosine < travel::DECISIVE_COSINE);
    if !stated.course && is_scattered {
        let mut trial = mapping.clone();
        for unit in travel::COURSE_UNITS {
            let Some(gps) = trial.table[table].gps.as_mut() else { continue };
            gps.course_unit = unit;
            let found = travel::travel(&read(&trial)?.fixes);
            if let Some(found) = found.filter(|found| found.cosine >= travel::DECISIVE_COSINE) {
                let course = trial.table[table].gps.as_ref().map_or("", |gps| &gps.course);
                findings.push(format!(
                    "{course} agrees with the direction between the positions if it is in {}",
                    unit.name()
                ));
                *mapping = trial;
                travelled = Some(found);
                break;
            }
        }
    }
    let gps = mapping.table[table].gps.as_mut();
    if let Some(gps) = gps.filter(|gps| !gps.north.is_empty() || !gps.speed.is_empty()) {
        travel::settle_speed(gps, travelled, stated, findings, checks);
    }
    Ok(())
}

fn turn_axes(mapping: &mut Mapping, turn: &Turn) {
    for table in &mut mapping.table {
        if let Some(gyro) = &mut table.gyro {
            gyro.axes = turn.gyro;
        }
        if let Some(accel) = &mut table.accel {
            accel.axes = turn.accel;
        }
        if let Some(gravity) = &mut table.gravity {
            gravity.axes = turn.accel;
        }
        if let Some(mag) = &mut table.mag {
            mag.axes = turn.mag;
        }
        if let Some(attitude) = &mut table.attitude {
            if attitude.quaternion.is_empty() {
                attitude.signs = turn.attitude_signs;
                attitude.yaw_offset_deg = turn.yaw_offset_deg;
            } else if turn.attitude_signs[1] < 0.0 {
                attitude.world = World::Enu;
            }
        }
    }
}
