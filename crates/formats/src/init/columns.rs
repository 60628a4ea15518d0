//! Derives the mapping of one file from its column names and first rows, without changing axes.

use std::collections::BTreeMap;
use std::path::Path;

use super::instance;
use super::known::Known;
use super::look::Look;
use super::names::meaning;
use super::numbered;
use super::quantity::Quantity;
use super::rates::{self, GYRO_UNSTATED, Rate};
use super::travel::StatedUnits;
use super::unknown_places;
use super::unnamed;
use crate::format::Format;
use crate::recognise::{format_of, head_of};
use crate::text::{
    Axes, ForceUnit, GpsColumns, MagneticUnit, RateUnit, SpeedUnit, StickColumns, StickUnit,
    TableMapping, TimeUnit, Triad, VelocityColumns, World,
};
use hovernav_dataset::LogError;

/// The mapping of one file, with messages.
pub(crate) struct Understood {
    pub mapping: TableMapping,
    /// Whether the file states the units of velocity, height, barometer and gyros.
    pub stated: StatedUnits,
    /// Names of the unused columns.
    pub unused: Vec<String>,
    /// Assumptions that the user should check, one sentence each.
    pub checks: Vec<String>,
    /// Whether the accelerometer does not measure gravity, as with the linear acceleration of a phone.
    pub is_without_gravity: bool,
    /// Assumed rate, Hz, of a time column that counts rows and states no unit; `None` without such a column.
    pub count_hz: Option<f64>,
    /// The other triples of unnamed columns that may be the gyro, and the check of the unit of each.
    pub other_gyros: Vec<(Triad<RateUnit>, String)>,
    /// Whether the axes are those of a phone: right, to the upper edge, and out of the screen.
    pub is_of_phone: bool,
    /// Plausible units of the time, the one of the mapping first.
    pub time_units: Vec<TimeUnit>,
    /// Least and largest time of the examined rows, and the time between rows, in units of the time.
    pub span: [f64; 2],
    pub step: f64,
}

/// Derives the mapping of the file at `path`, which the mapping refers to as `file`.
pub(crate) fn understand(path: &Path, file: &Path) -> Result<Understood, LogError> {
    if is_capture(path) {
        return Ok(Understood {
            mapping: TableMapping { file: file.to_path_buf(), capture: true, ..Default::default() },
            stated: StatedUnits::default(),
            unused: Vec::new(),
            checks: Vec::new(),
            is_without_gravity: false,
            count_hz: None,
            other_gyros: Vec::new(),
            is_of_phone: false,
            time_units: Vec::new(),
            span: [f64::NAN; 2],
            step: f64::NAN,
        });
    }
    let mut look = Look::at(path)?;
    let below = |index: usize| {
        let below = look.layout.below_names.get(index).map_or("", String::as_str);
        if below.is_empty() { &look.cell_units[index] } else { below }
    };
    let named = look.layout.header_line > 0;
    let count = look.columns.len();
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let names = numbered::lettered(&look.layout.names, &name);
    let is_of_phone = numbered::is_of_phone(&look.layout.names, &name);
    let (meanings, other_gyros) = match named {
        true => ((0..count).map(|i| meaning(&names[i], below(i))).collect(), Vec::new()),
        false => unnamed::meanings(&look),
    };
    let mut known = Known { meanings };
    known.prefer_measured(&look, &names);
    known.add_down_of_ardupilot(&names);
    known.add_earth_centred(&look, &names);
    let one_receiver = known.keep_one_receiver(&look.layout.names);
    let instance = instance::found(&look, &known);
    if let Some((column, number)) = instance {
        look.keep_rows_of(column, f64::from(number));
    }
    let unknown = unknown_places::forget_unknown(&mut look, &known);
    let mut table = TableMapping {
        file: file.to_path_buf(),
        delimiter: look.layout.delimiter,
        decimal_comma: look.layout.decimal_comma,
        header_line: look.layout.header_line,
        instance_column: instance
            .map_or_else(String::new, |(column, _)| look.layout.names[column].clone()),
        instance: instance.map(|(_, number)| number),
        ..TableMapping::default()
    };
    let mut checks = repeated(&look.layout.names);
    checks.extend(one_receiver);
    if let Some(number) = table.instance {
        checks.push(format!(
            "{name} has rows of several sensors: those with {} = {number} are read; for others \
             set `instance`",
            table.instance_column
        ));
    }
    let mut reader = Reader {
        file: name,
        look: &look,
        known: &known,
        used: vec![false; count],
        is_counted: false,
        time_units: Vec::new(),
        span: [f64::NAN; 2],
        step: f64::NAN,
    };
    table.gyro = reader.gyro(&mut checks);
    let other_gyros = other_gyros.into_iter().map(|columns| reader.other_gyro(columns)).collect();
    table.accel = reader.accel(&mut checks);
    table.gravity = reader.gravity();
    table.mag = reader.mag(&mut checks);
    table.attitude = reader.attitude(&mut checks);
    let gps = reader.gps(table.gyro.is_some() || table.accel.is_some(), &mut checks);
    let stated = gps.as_ref().map_or_else(StatedUnits::default, |(_, stated)| *stated);
    let is_gyro_stated = !checks.iter().any(|check| check.starts_with(GYRO_UNSTATED));
    let rates = known.all([0, 1, 2].map(Quantity::Gyro)).filter(|_| !is_gyro_stated);
    let is_gyro_whole = rates.is_some_and(|rates| rates.iter().all(|&rate| look.is_whole(rate)));
    if gps.is_some() && !unknown.is_empty() {
        checks.push(format!(
            "gps: rows with latitude and longitude of {unknown:?} are read as rows without a fix; \
             for true positions remove `unknown` under [table.gps]"
        ));
    }
    table.gps = gps.map(|(columns, _)| GpsColumns { unknown, ..columns });
    let (baro, is_baro_stated) = reader.baro(table.gps.is_some(), &mut checks).unzip();
    table.baro = baro;
    let stated = StatedUnits {
        gyro: is_gyro_stated,
        is_gyro_whole,
        baro: is_baro_stated.unwrap_or(true),
        ..stated
    };
    table.controls = reader.controls();
    if table.gps.is_none() && table.gyro.is_none() {
        table.velocity = reader.velocity_alone(table.attitude.is_some());
    }
    let has_motion =
        [table.gyro.is_some(), table.accel.is_some(), table.gravity.is_some()].contains(&true);
    table.time = reader.time(has_motion, &mut checks).ok_or_else(|| LogError::Unusable {
        path: path.to_path_buf(),
        reason: reader.missing_time(),
    })?;
    let count_hz = reader.is_counted.then(|| 1.0 / table.time.unit.seconds());
    let (time_units, span, step) =
        (std::mem::take(&mut reader.time_units), reader.span, reader.step);
    let unused = reader.used.iter().zip(&look.layout.names).filter(|(used, _)| !**used);
    let unused = unused.map(|(_, name)| name.clone()).collect();
    let is_linear = known.all([0, 1, 2].map(Quantity::Accel)).is_some_and(|accel| {
        /// Smallest length of the mean vector, relative to the root mean square of the norm, of an accelerometer that
        /// measures gravity.
        const STEADY: f64 = 0.5;
        look.steadiness(accel) < STEADY
    });
    let is_without_gravity =
        is_linear || checks.iter().any(|check| check.starts_with("accel: found a median"));
    Ok(Understood {
        mapping: table,
        stated,
        unused,
        checks,
        is_without_gravity,
        count_hz,
        other_gyros,
        is_of_phone,
        time_units,
        span,
        step,
    })
}

/// Whether a file is a capture of a receiver, whose fixes need no mapping.
pub(super) fn is_capture(path: &Path) -> bool {
    path.is_file() && head_of(path).is_ok_and(|head| format_of(&head) == Some(Format::Raw))
}

/// One sentence for each name that several columns have.
fn repeated(names: &[String]) -> Vec<String> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    names.iter().for_each(|name| *counts.entry(name).or_default() += 1);
    let repeated = counts.into_iter().filter(|(name, count)| *count > 1 && !name.is_empty());
    repeated
        .map(|(name, count)| format!("{count} columns are called {name}: only the first is used"))
        .collect()
}

/// Assigns the columns of a file to its sensors and marks them as used.
pub(super) struct Reader<'a> {
    /// The file's name without its directory.
    pub file: String,
    pub look: &'a Look,
    pub known: &'a Known,
    used: Vec<bool>,
    /// Whether the time is a counter of unknown rate.
    pub is_counted: bool,
    /// Plausible units of a time without a stated one.
    pub time_units: Vec<TimeUnit>,
    /// Least and largest time, and the time between rows, in units of the time.
    pub span: [f64; 2],
    pub step: f64,
}

impl Reader<'_> {
    /// Marks a column as used and returns its name.
    pub fn name(&mut self, column: usize) -> String {
        self.used[column] = true;
        self.look.layout.names[column].clone()
    }

    /// The name of the column of a quantity; empty if there is no such column.
    pub fn optional(&mut self, quantity: Quantity) -> String {
        self.known.column(quantity).map(|column| self.name(column)).unwrap_or_default()
    }

    fn triad<U>(&mut self, columns: [usize; 3], unit: U, with_others: bool) -> Triad<U> {
        let held = with_others && self.look.is_held(&columns);
        let columns = columns.map(|column| self.name(column));
        Triad { columns, unit, counts_per_unit: 1.0, axes: Axes::FORWARD_RIGHT_DOWN, held }
    }

    fn gyro(&mut self, checks: &mut Vec<String>) -> Option<Triad<RateUnit>> {
        let rates = self.known.all([0, 1, 2].map(Quantity::Gyro));
        if let Some(columns) = rates {
            let high = self.look.high_norm(columns);
            let unit = match self.known.unit(columns[0]) {
                Some("rad/s") => RateUnit::RadiansPerSecond,
                Some("deg/s") => RateUnit::DegreesPerSecond,
                Some("mrad/s") => RateUnit::MilliradiansPerSecond,
                Some("mdeg/s") => RateUnit::MillidegreesPerSecond,
                Some("cdeg/s") => RateUnit::CentidegreesPerSecond,
                Some("deg/h") => RateUnit::DegreesPerHour,
                Some("rpm") => RateUnit::RevolutionsPerMinute,
                // Betaflight and its relatives.
                None if self.look.layout.names[columns[0]].starts_with("gyroADC") => {
                    let counts_per_unit = self.look.layout.gyro_counts_per_degps.get();
                    checks.push(format!(
                        "gyro: gyroADC is read as {counts_per_unit} counts per deg/s: the gyro_scale of the header, \
                         or 1 where it is missing"
                    ));
                    let triad = self.triad(columns, RateUnit::DegreesPerSecond, false);
                    return Some(Triad { counts_per_unit, ..triad });
                }
                None if self.are_counts(columns) => {
                    checks.push(rates::unstated(high, Rate::WIDEST));
                    let mut triad = self.triad(columns, RateUnit::DegreesPerSecond, false);
                    Rate::WIDEST.give(&mut triad);
                    return Some(triad);
                }
                _ => {
                    let unit = rates::by_size(high);
                    checks.push(rates::unstated(high, Rate::plain(unit)));
                    unit
                }
            };
            return Some(self.triad(columns, unit, false));
        }
        let columns = self.known.all([0, 1, 2].map(Quantity::AngleIncrement))?;
        let unit = match self.known.unit(columns[0]) {
            Some("deg") => RateUnit::Degrees,
            _ => RateUnit::Radians,
        };
        Some(self.triad(columns, unit, false))
    }

    /// A triple of unnamed columns that may be the gyro, and the check of its unit.
    fn other_gyro(&self, columns: [usize; 3]) -> (Triad<RateUnit>, String) {
        let high = self.look.high_norm(columns);
        let unit = rates::by_size(high);
        let triad = Triad {
            columns: columns.map(|column| self.look.layout.names[column].clone()),
            unit,
            counts_per_unit: 1.0,
            axes: Axes::FORWARD_RIGHT_DOWN,
            held: false,
        };
        (triad, rates::unstated(high, Rate::plain(unit)))
    }

    fn accel(&mut self, checks: &mut Vec<String>) -> Option<Triad<ForceUnit>> {
        if let Some(columns) = self.known.all([0, 1, 2].map(Quantity::Accel)) {
            let norm = self.look.median_norm(columns);
            if let Some((counts_per_unit, by)) = self.counts_per_g(columns, norm) {
                checks.push(format!(
                    "accel: {} of {} are read as counts, {counts_per_unit} per g, by {by}; correct \
                     counts_per_unit under [table.accel] if it is another number",
                    columns.map(|column| self.look.layout.names[column].as_str()).join(" "),
                    self.file
                ));
                let triad = self.triad(columns, ForceUnit::Gravity, false);
                return Some(Triad { counts_per_unit, ..triad });
            }
            let unit = match self.known.unit(columns[0]) {
                // Gravity overrides a wrong unit in the name.
                Some("m/s2") if !(0.8..1.2).contains(&norm) => ForceUnit::MetresPerSecondSquared,
                Some("g") if !(8.0..12.0).contains(&norm) => ForceUnit::Gravity,
                Some("mg") => ForceUnit::Milligravity,
                Some("cm/s2") => ForceUnit::CentimetresPerSecondSquared,
                Some("ft/s2") if norm > 20.0 => ForceUnit::FeetPerSecondSquared,
                _ if (28.0..37.0).contains(&norm) => ForceUnit::FeetPerSecondSquared,
                _ if (0.5..2.0).contains(&norm) => ForceUnit::Gravity,
                _ if (500.0..2000.0).contains(&norm) => ForceUnit::Milligravity,
                _ => ForceUnit::MetresPerSecondSquared,
            };
            let norm_mps2 = norm * unit.factor();
            if !(7.0..13.0).contains(&norm_mps2) {
                checks.push(format!(
                    "accel: found a median of {norm_mps2:.2} m/s² as {}, expected about 9.8: check \
                     the unit, and whether the values include gravity",
                    unit.name()
                ));
            }
            return Some(self.triad(columns, unit, false));
        }
        let columns = self.known.all([0, 1, 2].map(Quantity::VelocityIncrement))?;
        Some(self.triad(columns, ForceUnit::MetresPerSecond, false))
    }

    /// Whether the rates are counts: whole numbers, next to an accelerometer in counts.
    fn are_counts(&self, rates: [usize; 3]) -> bool {
        let accel = self.known.all([0, 1, 2].map(Quantity::Accel));
        let counts =
            accel.and_then(|columns| self.counts_per_g(columns, self.look.median_norm(columns)));
        counts.is_some() && rates.iter().all(|&column| self.look.is_whole(column))
    }

    /// The counts per g of an accelerometer without a unit, and their source: `acc_1G` above the names, otherwise the
    /// power of two that is nearest to gravity. `norm` is the median norm.
    fn counts_per_g(&self, columns: [usize; 3], norm: f64) -> Option<(f64, &'static str)> {
        /// Smallest number of counts per g of a sensor.
        const MIN: f64 = 64.0;
        /// A power of two that is confused with 981 cm/s² and 1000 mg.
        const OF_UNITS: f64 = 1024.0;
        /// Largest ratio of the norm to the power of two, or its inverse.
        const NEAR: f64 = 1.2;
        let is_bare =
            columns.iter().all(|&c| self.known.unit(c).is_none() && self.look.is_whole(c));
        if !is_bare {
            return None;
        }
        let near = |counts: f64| (norm / counts).max(counts / norm) < NEAR;
        let stated = self.look.layout.acc_counts_per_g.map(f64::from);
        if let Some(counts) = stated.filter(|counts| near(*counts)) {
            return Some((counts, "acc_1G of the file"));
        }
        let power = 2f64.powf(norm.log2().round());
        (power >= MIN && power != OF_UNITS && near(power)).then_some((power, "the size of gravity"))
    }

    /// The columns of gravity alone, as phones compute it, in m/s² unless the values have the size of g.
    fn gravity(&mut self) -> Option<Triad<ForceUnit>> {
        let columns = self.known.all([0, 1, 2].map(Quantity::Gravity))?;
        let unit = match self.look.median_norm(columns) {
            norm if norm < 2.0 => ForceUnit::Gravity,
            _ => ForceUnit::MetresPerSecondSquared,
        };
        Some(self.triad(columns, unit, false))
    }

    fn mag(&mut self, checks: &mut Vec<String>) -> Option<Triad<MagneticUnit>> {
        let columns = self.known.all([0, 1, 2].map(Quantity::Mag))?;
        let norm = self.look.median_norm(columns);
        let named = match self.known.unit(columns[0]) {
            Some("gauss") | Some("g") => Some(MagneticUnit::Gauss),
            Some("mg") => Some(MagneticUnit::Milligauss),
            Some("ut") => Some(MagneticUnit::Microtesla),
            Some("nt") => Some(MagneticUnit::Nanotesla),
            Some("t") => Some(MagneticUnit::Tesla),
            _ => None,
        };
        let by_size = match norm {
            norm if norm < 1e-3 => MagneticUnit::Tesla,
            norm if norm < 2.0 => MagneticUnit::Gauss,
            norm if norm < 150.0 => MagneticUnit::Microtesla,
            norm if norm < 5e3 => MagneticUnit::Milligauss,
            _ => MagneticUnit::Nanotesla,
        };
        // The size of the Earth's field overrides a wrong unit in the name.
        let is_earths = |unit: &MagneticUnit| (0.15..0.8).contains(&(norm * unit.factor()));
        let unit = named.filter(is_earths).unwrap_or(by_size);
        if named.is_some_and(|named| named != unit) {
            checks.push(format!(
                "mag: the magnitude does not fit the unit in the name: {} is used",
                unit.name()
            ));
        }
        let gauss = norm * unit.factor();
        if !is_earths(&unit) {
            checks.push(format!(
                "mag: found {gauss:.3} gauss as {}, expected the Earth's field of 0.2 to 0.7 \
                 gauss: ignored; calibrate it first",
                unit.name()
            ));
            return None;
        }
        Some(self.triad(columns, unit, true))
    }

    /// The columns of a velocity in a file without positions, as ROS exports `TwistStamped`, or of a receiver that writes
    /// its velocities apart; not those of a command, and not those of a filter, which has an attitude.
    fn velocity_alone(&mut self, has_attitude: bool) -> Option<VelocityColumns> {
        const COMMANDS: [&str; 3] = ["cmd", "setpoint", "target"];
        let file = self.file.to_lowercase();
        if COMMANDS.iter().any(|part| file.contains(part)) {
            return None;
        }
        let is_measured = |columns: &[usize; 3]| {
            !has_attitude && !columns.iter().any(|&column| self.known.is_estimated(column))
        };
        let twist = self.known.all([0, 1, 2].map(Quantity::Twist));
        let receiver = self.known.all([0, 1, 2].map(Quantity::Velocity)).filter(is_measured);
        let (columns, unit, world) = match (twist, receiver) {
            (Some(columns), _) => (columns, SpeedUnit::MetresPerSecond, World::Enu),
            (None, Some(columns)) => (columns, self.speed_unit_alone(columns[0]), World::Ned),
            (None, None) => return None,
        };
        let columns = columns.map(|column| self.name(column));
        Some(VelocityColumns { columns, unit, world })
    }

    fn controls(&mut self) -> Option<StickColumns> {
        let columns = self.known.all([0, 1, 2, 3].map(Quantity::Stick))?;
        let largest = columns.map(|column| self.look.largest(column)).into_iter();
        let unit = match self.known.unit(columns[0]) {
            Some("percent") => StickUnit::Percent,
            _ if largest.fold(0.0, f64::max) > 2.0 => StickUnit::Percent,
            _ => StickUnit::Fraction,
        };
        Some(StickColumns { columns: columns.map(|c| self.name(c)), unit, signs: [1.0; 4] })
    }
}
