//! Rule that decides whether a row of a log is a fix, the same for every format.
//!
//! A reader passes each fix as its log states it. The gate uses its plausible values, and counts the others by reason.

use std::path::Path;

use crate::clock::Rows;
use crate::clock::steps::ClockSteps;
use crate::error::LogError;
use crate::sensors::two_receivers::TwoReceivers;
use crate::statistics::{median_interval_s, quantile};
use crate::table::remarks::Remarks;
use hovernav::earth::Geodetic;
use hovernav::frames::{Ned, Vector};
use hovernav::gps::Fix;
use hovernav::time::Time;

/// Largest plausible velocity, m/s.
pub(crate) const FASTEST_MPS: f64 = 1000.0;
/// Largest one-sigma of a position, m, that states an accuracy. Receivers send larger ones for unknown.
const LARGEST_POSITION_SIGMA_M: f64 = 1e4;
/// Largest one-sigma of a velocity, m/s, that states an accuracy. Receivers send larger ones for unknown.
const LARGEST_VELOCITY_SIGMA_MPS: f64 = 1e3;
/// Largest latitude and longitude, degrees, that count as zero, the output of a receiver without a fix. Loggers round
/// it. Two such positions are within 0.2 m of each other.
const NULL_ISLAND_DEG: f64 = 1e-6;
/// Largest latitude of a flight, degrees. The filter navigates up to 89.9°; the margin is 11 km.
pub const HIGHEST_LATITUDE_DEG: f64 = 89.8;
/// Largest speed, m/s, at which receivers leave the course empty.
const AT_REST_MPS: f64 = 1.0;
/// Smallest one-sigma of a velocity at rest, m/s.
const AT_REST_SIGMA_MPS: f64 = 0.1;
/// Smallest interval between new fixes, in intervals between rows, at which the other rows are repetitions.
const REPEATING: f64 = 1.5;
/// Smallest number of new fixes from which their interval is measured.
const MIN_NEW: usize = 5;
/// Quantile of the intervals between new fixes that is used as the receiver's own interval. It is low, because a
/// receiver at rest may repeat its values.
const SHORT: f64 = 0.1;
/// Smallest receiver interval for a search of repetitions, as a fraction of the median interval between new fixes.
const EVEN: f64 = 0.5;
/// Smallest receiver interval for a search of repetitions, in intervals between rows; either limit is sufficient.
const MANY_ROWS: f64 = 10.0;
/// Smallest height, m, after a height of exactly 0 that shows that the 0 was not measured.
const MIN_JUMP_M: f64 = 20.0;
/// Largest vertical speed, m/s, between a measured height of 0 and the next height.
const FASTEST_CLIMB_MPS: f64 = 30.0;
/// Longest time, s, for which rows repeat a fix in a log that is known to repeat fixes: one missing fix at 1 Hz.
const LONGEST_HELD_S: f64 = 2.5;
/// Values that loggers write instead of an unknown one: round numbers, and the ends of 16 and 32 bits.
const UNKNOWN: [f64; 8] =
    [-9999.0, 9999.0, -99_999.0, 99_999.0, -999.0, -32_768.0, 32_767.0, 65_535.0];

/// Velocities, m/s, that loggers write instead of an unknown one: the ends of 16 bits in cm/s, and nines.
const UNKNOWN_MPS: [f64; 3] = [655.35, 327.67, 999.99];

/// Whether a velocity or speed, m/s, is one that loggers write instead of an unknown one.
#[must_use]
pub fn is_unknown_velocity(value: f64) -> bool {
    /// Rounding of single precision, m/s.
    const ROUNDING: f64 = 1e-4;
    is_unknown(value) || UNKNOWN_MPS.iter().any(|one| (value.abs() - one).abs() < ROUNDING)
}

/// Whether `value` is one that loggers write instead of an unknown one.
#[must_use]
pub fn is_unknown(value: f64) -> bool {
    // The ends of 32 bits, signed and unsigned, in units, thousandths and 1e-7 of units.
    let is_end = |scale: f64| {
        let count = (value * scale).abs();
        (count - 2_147_483_647.5).abs() < 0.6 || (count - 4_294_967_295.5).abs() < 0.6
    };
    !value.is_finite() || UNKNOWN.contains(&value) || [1.0, 1e3, 1e7].into_iter().any(is_end)
}

/// Dimensions of a fix, as its log states them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Dimensions {
    /// No fix.
    None,
    /// Latitude and longitude; the height is held or assumed.
    Two,
    /// A position with a height, also if the log does not state the dimensions.
    #[default]
    Three,
    /// A fix type of unknown meaning. 0 is no fix. In a log with fixes of type 3, 1 is no fix and 2 is two-dimensional,
    /// as in UBX and MAVLink. In other logs the types have the meaning of NMEA 0183.
    Type(f64),
}

impl Dimensions {
    /// Dimensions for a fix type of u-blox, MAVLink, PX4 and ArduPilot: two for 2, three from 3 on. An unknown type
    /// counts as three.
    #[must_use]
    pub fn of_type(fix_type: f64) -> Self {
        match fix_type {
            fix_type if fix_type >= 3.0 => Self::Three,
            fix_type if fix_type >= 2.0 => Self::Two,
            fix_type if fix_type.is_nan() => Self::Three,
            _ => Self::None,
        }
    }
}

/// A fix as its log states it; unknown numbers are NaN.
#[derive(Clone, Copy, Debug)]
pub struct StatedFix {
    /// Time of validity.
    pub time: Option<Time>,
    /// Dimensions of the position.
    pub dimensions: Dimensions,
    /// Latitude and longitude, degrees, and height, m.
    pub position: [f64; 3],
    /// One-sigma of the position, north, east and down, m.
    pub position_sigma_m: [f64; 3],
    /// Velocity north, east and down, m/s.
    pub velocity_mps: [f64; 3],
    /// Speed over ground, m/s, of a receiver that leaves its course empty at rest.
    pub ground_speed_mps: f64,
    /// One-sigma of the velocity, m/s.
    pub velocity_sigma_mps: [f64; 3],
    /// Number of satellites used.
    pub satellites: f64,
}

impl StatedFix {
    /// A fix with only a position: latitude and longitude, degrees, and height, m.
    #[must_use]
    pub const fn at(time: Option<Time>, position: [f64; 3]) -> Self {
        Self {
            time,
            dimensions: Dimensions::Three,
            position,
            position_sigma_m: [f64::NAN; 3],
            velocity_mps: [f64::NAN; 3],
            ground_speed_mps: f64::NAN,
            velocity_sigma_mps: [f64::NAN; 3],
            satellites: f64::NAN,
        }
    }

    /// This fix with a speed over ground, m/s, and a course, rad, as its horizontal velocity. Phones write a negative
    /// speed for an unknown one.
    #[must_use]
    pub fn moving(mut self, speed_mps: f64, course_rad: f64) -> Self {
        let is_known = speed_mps >= 0.0 && !is_unknown_velocity(speed_mps);
        let speed_mps = if is_known { speed_mps } else { f64::NAN };
        let (east, north) = course_rad.sin_cos();
        [self.velocity_mps[0], self.velocity_mps[1]] = [speed_mps * north, speed_mps * east];
        Self { ground_speed_mps: speed_mps, ..self }
    }

    /// The values of `fix`, which has passed the gate.
    #[must_use]
    pub fn of(fix: &Fix) -> Self {
        let vector = |of: Option<Vector<Ned>>| of.map_or([f64::NAN; 3], Vector::to_array);
        let [north, east] = fix.horizontal_velocity_mps.unwrap_or([f64::NAN; 2]);
        // Only a fix without a measured height has a vertical velocity and is two-dimensional.
        let (is_heightless, is_flat) = match fix.down_velocity_mps {
            Some(_) => (fix.two_dimensional, false),
            None => (false, fix.two_dimensional),
        };
        let height_m = if is_heightless { f64::NAN } else { fix.position.height_m };
        Self {
            dimensions: if is_flat { Dimensions::Two } else { Dimensions::Three },
            position_sigma_m: vector(fix.position_sigma_m),
            velocity_mps: [north, east, fix.down_velocity_mps.unwrap_or(f64::NAN)],
            velocity_sigma_mps: vector(fix.velocity_sigma_mps),
            satellites: fix.satellites.map_or(f64::NAN, f64::from),
            ..Self::at(
                Some(fix.time),
                [fix.position.latitude_deg(), fix.position.longitude_deg(), height_m],
            )
        }
    }

    /// Whether the fix has a position that is used.
    #[must_use]
    pub fn is_fix(&self) -> bool {
        self.fault().is_none()
    }

    /// Reason why this is not a fix; `None` if it is one.
    fn fault(&self) -> Option<&'static str> {
        let [lat, lon, height] = self.position;
        let latitude = |degrees: f64| degrees.abs() <= 90.0;
        let is_at_zero = |degrees: f64| degrees.abs() <= NULL_ISLAND_DEG;
        Some(if self.time.is_none() {
            "skipped: no time"
        } else if matches!(self.dimensions, Dimensions::None | Dimensions::Type(0.0)) {
            "skipped: no fix"
        } else if is_at_zero(lat) && is_at_zero(lon) {
            "skipped: no fix, latitude and longitude are 0"
        } else if lat.is_nan() || lon.is_nan() {
            "skipped: a coordinate is missing"
        } else if is_unknown(lat) || is_unknown(lon) {
            "skipped: no fix, a coordinate has a value for unknown ones, such as -9999"
        } else if Geodetic::from_degrees(lat, lon, if height.is_nan() { 0.0 } else { height })
            .is_none()
        {
            no_place(self.position)
        } else if latitude(lat) && lat.abs() > HIGHEST_LATITUDE_DEG {
            "rejected: beyond the latitude limit of 89.8°, north is not defined well enough near a pole"
        } else {
            return None;
        })
    }
}

/// Reason why a latitude and a longitude, °, and a height are not a position on Earth.
pub(crate) fn no_place([lat, lon, _]: [f64; 3]) -> &'static str {
    let latitude = |degrees: f64| degrees.abs() <= 90.0;
    match (latitude(lat), latitude(lon)) {
        (false, true) => {
            "rejected: not a position on Earth, the latitude is beyond 90° (latitude and longitude swapped?)"
        }
        (false, false) => {
            "rejected: not a position on Earth, the latitude is beyond 90° (expected degrees, not 1e-7 degrees)"
        }
        _ if lon.abs() > 360.0 => {
            "rejected: not a position on Earth, the longitude is beyond 360° (expected degrees)"
        }
        _ => "rejected: not a position on Earth, the height is too large (expected metres)",
    }
}

/// Fixes of a log in the order found, selected by the rule of this module.
#[derive(Debug, Default)]
pub struct FixGate {
    rows: Rows<Row>,
    /// Whether any fix is of type 3.
    has_type_3: bool,
    /// Whether any fix has satellites; otherwise 0 satellites are an unknown number.
    has_satellites: bool,
    /// Whether rows are known to repeat the last fix.
    is_held: bool,
    last: Option<Fix>,
}

#[derive(Debug)]
struct Row {
    fix: Fix,
    has_height: bool,
    /// Type of the fix; NaN if unknown.
    fix_type: f64,
}

impl FixGate {
    /// Declares that rows repeat the last fix until there is a new one.
    pub fn hold(&mut self) {
        self.is_held = true;
    }

    /// Adds the fixes of another gate, with times `later_s` later.
    pub fn append(&mut self, other: Self, later_s: f64) {
        for (place, mut row) in other.rows.into_rows() {
            row.fix.time = row.fix.time.offset_by(later_s);
            self.rows.push(place, row);
        }
        self.has_type_3 |= other.has_type_3;
        self.has_satellites |= other.has_satellites;
    }

    /// Adds the fix found at `place`, a line or byte offset, without its implausible values. Returns whether it is a
    /// fix; `remarks` counts unused values.
    pub fn push(&mut self, place: u64, mut stated: StatedFix, remarks: &mut Remarks) -> bool {
        if is_unknown(stated.position[2]) {
            stated.position[2] = f64::NAN;
        }
        if let Some(fault) = stated.fault() {
            remarks.count(fault, place);
            return false;
        }
        let [lat, lon, height] = stated.position;
        let (has_height, is_flat) = (!height.is_nan(), stated.dimensions == Dimensions::Two);
        if is_flat || !has_height {
            remarks
                .count("without a measured height: used for the horizontal position only", place);
        }
        let last_m = self.last.map_or(0.0, |last| last.position.height_m);
        let height_m = if has_height { height } else { last_m };
        let (Some(time), Some(position)) =
            (stated.time, Geodetic::from_degrees(lat, lon, height_m))
        else {
            return false;
        };
        let fix_type = match stated.dimensions {
            Dimensions::Type(number) => number,
            _ => f64::NAN,
        };
        self.has_type_3 |= fix_type == 3.0;
        self.has_satellites |= stated.satellites > 0.0;
        let (horizontal, velocity_sigma) = at_rest(&stated);
        let known = |sigma: [f64; 3]| sigma.iter().all(|s| s.is_finite()).then(|| sigma.into());
        let fix = Fix {
            two_dimensional: is_flat || !has_height,
            // A receiver that holds its height does not measure the vertical velocity either.
            position_sigma_m: known(stated.position_sigma_m),
            horizontal_velocity_mps: finite(horizontal),
            down_velocity_mps: finite([stated.velocity_mps[2]])
                .filter(|_| !is_flat)
                .map(|[down]| down),
            velocity_sigma_mps: known(velocity_sigma),
            satellites: (0.0..=255.0)
                .contains(&stated.satellites)
                .then_some(stated.satellites as u8),
            ..Fix::at(time, position)
        };
        let fix = plausible(fix, place, remarks);
        let is_repeated = |last: &Fix| {
            values(last) == values(&fix) && (0.0..LONGEST_HELD_S).contains(&(fix.time - last.time))
        };
        if !(self.is_held && self.last.as_ref().is_some_and(is_repeated)) {
            self.last = Some(fix);
            self.rows.push(place, Row { fix, has_height, fix_type });
        }
        true
    }

    /// The fixes in time order, without repetitions. Fixes before the first measured height get that height.
    ///
    /// # Errors
    /// As [`Rows::in_time_order`].
    pub fn finish(
        self,
        path: &Path,
        steps: &mut ClockSteps,
        remarks: &mut Remarks,
    ) -> Result<Vec<Fix>, LogError> {
        let mut known = Rows::new();
        for (line, row) in self.rows.into_rows() {
            if self.has_type_3 && row.fix_type == 1.0 {
                remarks.count("skipped: no fix, type 1 in a log with type 3", line);
            } else if self.has_satellites && row.fix.satellites == Some(0) {
                remarks.count("skipped: no fix, 0 satellites", line);
            } else {
                known.push(line, row);
            }
        }
        let (mut rows, lines) =
            known.in_time_order(|row| &mut row.fix.time, path, steps, remarks)?;
        for index in zero_heights(&rows) {
            remarks.count("with a height of 0, far from the others: height ignored", lines[index]);
            (rows[index].has_height, rows[index].fix.two_dimensional) = (false, true);
        }
        let first_m = rows.iter().find(|row| row.has_height).map(|row| row.fix.position.height_m);
        if first_m.is_none() && !rows.is_empty() {
            remarks.say("no fix has a height: 0 m is assumed, and the height is unknown".into());
        }
        let is_flat = |row: &Row| self.has_type_3 && row.fix_type == 2.0;
        let held = rows.iter().filter(|row| is_flat(row)).count();
        if held > 0 {
            remarks.say(format!(
                "fixes of type 2, {held} of them: two-dimensional, used for the horizontal alone"
            ));
        }
        let mut height_m = first_m;
        let mut fixes = Vec::with_capacity(rows.len());
        for mut row in rows {
            match height_m {
                Some(height_m) if !row.has_height => row.fix.position.height_m = height_m,
                _ => height_m = Some(row.fix.position.height_m),
            }
            if is_flat(&row) {
                (row.fix.two_dimensional, row.fix.down_velocity_mps) = (true, None);
            }
            fixes.push(row.fix);
        }
        let mut repeats = repeats(&fixes).into_iter().zip(lines);
        fixes.retain(|_| match repeats.next() {
            Some((true, line)) => {
                remarks.count("skipped: repeats the last fix until there is a new one", line);
                false
            }
            _ => true,
        });
        if let Some(TwoReceivers { apart_m, is_other }) = TwoReceivers::of(&fixes) {
            let count = fixes.len();
            let mut is_other = is_other.into_iter();
            fixes.retain(|_| is_other.next() == Some(false));
            remarks.say(format!(
                "fixes alternate between two positions {apart_m:.1} m apart: two receivers; {} of {count} fixes are \
                 used, those of one receiver; to use the other, give each its own file",
                fixes.len()
            ));
        }
        Ok(fixes)
    }
}

/// Indices of the rows whose height of exactly 0 no receiver measured: the heights before and after them are further from
/// 0 than a vehicle climbs in between.
fn zero_heights(rows: &[Row]) -> Vec<usize> {
    let known: Vec<usize> = (0..rows.len()).filter(|&index| rows[index].has_height).collect();
    let is_zero = |&index: &usize| rows[index].fix.position.height_m == 0.0;
    let is_far = |zero: usize, other: usize| {
        let Row { fix, .. } = &rows[known[other]];
        let interval_s = (fix.time - rows[known[zero]].fix.time).abs();
        fix.position.height_m.abs() > MIN_JUMP_M.max(FASTEST_CLIMB_MPS * interval_s)
    };
    let mut start = 0;
    let runs = known.chunk_by(|a, b| is_zero(a) == is_zero(b)).filter(|run| {
        let (first, end) = (start, start + run.len());
        start = end;
        let is_alone = first == 0 && end == known.len();
        let before = first == 0 || is_far(first, first - 1);
        let after = end == known.len() || is_far(end - 1, end);
        is_zero(&run[0]) && !is_alone && before && after
    });
    runs.flatten().copied().collect()
}

fn finite<const N: usize>(values: [f64; N]) -> Option<[f64; N]> {
    values.iter().all(|value| value.is_finite()).then_some(values)
}

/// Horizontal velocity, and one-sigma of the velocity, m/s. Without a course, a ground speed up to `AT_REST_MPS` counts
/// as rest: the velocity is zero, and the one-sigma at least the ground speed and `AT_REST_SIGMA_MPS`.
fn at_rest(stated: &StatedFix) -> ([f64; 2], [f64; 3]) {
    let [north, east, _] = stated.velocity_mps;
    let is_at_rest = !(north.is_finite() && east.is_finite())
        && (0.0..=AT_REST_MPS).contains(&stated.ground_speed_mps);
    if !is_at_rest {
        return ([north, east], stated.velocity_sigma_mps);
    }
    let min_mps = stated.ground_speed_mps.max(AT_REST_SIGMA_MPS);
    ([0.0; 2], stated.velocity_sigma_mps.map(|sigma| sigma.max(min_mps)))
}

/// `fix` without an implausible velocity and without invalid sigmas; each is counted in `remarks` against `place`.
fn plausible(mut fix: Fix, place: u64, remarks: &mut Remarks) -> Fix {
    let is_motion = |speed: f64| speed.abs() <= FASTEST_MPS && !is_unknown_velocity(speed);
    if !fix.horizontal_velocity_mps.is_none_or(|v| v.into_iter().all(is_motion)) {
        remarks.count("with a velocity beyond any vehicle's: velocity ignored", place);
        (fix.horizontal_velocity_mps, fix.down_velocity_mps) = (None, None);
    }
    if !fix.down_velocity_mps.is_none_or(is_motion) {
        remarks.count("with a vertical velocity beyond any vehicle's: ignored", place);
        fix.down_velocity_mps = None;
    }
    let mut known = |sigma: Option<Vector<Ned>>, largest: f64| {
        let is_one =
            |sigma: &Vector<Ned>| sigma.to_array().iter().all(|s| *s > 0.0 && *s <= largest);
        if sigma.is_some_and(|sigma| !is_one(&sigma)) {
            remarks.count("with an invalid sigma: sigma ignored", place);
        }
        sigma.filter(is_one)
    };
    fix.position_sigma_m = known(fix.position_sigma_m, LARGEST_POSITION_SIGMA_M);
    fix.velocity_sigma_mps = known(fix.velocity_sigma_mps, LARGEST_VELOCITY_SIGMA_MPS);
    fix
}

/// Values in which a new fix differs from the previous one.
fn values(fix: &Fix) -> impl PartialEq {
    (fix.position, fix.horizontal_velocity_mps, fix.down_velocity_mps)
}

/// For each fix, whether it repeats an earlier one, because rows come more often than the receiver computes. Equal
/// fixes at more than the usual interval come from a receiver at rest, and are no repetitions. Equal fixes at irregular
/// intervals come from a receiver at rest with coarse numbers, and are no repetitions either.
fn repeats(fixes: &[Fix]) -> Vec<bool> {
    let times: Vec<Time> = fixes.iter().map(|fix| fix.time).collect();
    let is_new = |pair: &&[Fix]| values(&pair[0]) != values(&pair[1]);
    let new: Vec<Time> = fixes.windows(2).filter(is_new).map(|pair| pair[1].time).collect();
    let row_s = median_interval_s(&times).unwrap_or(0.0);
    let mut intervals_s: Vec<f64> = new.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let short_s = quantile(&mut intervals_s, SHORT);
    let mut repeats = vec![false; fixes.len()];
    if let (Some(short_s), Some(usual_s)) = (short_s, quantile(&mut intervals_s, 0.5))
        && new.len() >= MIN_NEW
        && short_s > REPEATING * row_s
        && (short_s > EVEN * usual_s || short_s > MANY_ROWS * row_s)
    {
        let longest_s = REPEATING * short_s;
        let mut kept = 0;
        for (index, repeats) in repeats.iter_mut().enumerate().skip(1) {
            *repeats = values(&fixes[index]) == values(&fixes[kept])
                && fixes[index].time - fixes[kept].time < longest_s;
            kept = if *repeats { kept } else { index };
        }
    }
    repeats
}
