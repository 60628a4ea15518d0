//! The columns of an attitude.

use super::columns::Reader;
use super::quantity::Quantity;
use crate::text::{AngleUnit, AttitudeColumns, AttitudeRole, Mapping, TableMapping};
use hovernav::frames::{Body, Ned, Rotation};
use hovernav_dataset::Dataset;
use hovernav_dataset::statistics::quantile;

impl Reader<'_> {
    /// Whether each of the columns has one value on every row, as drivers write that measure nothing.
    fn are_constant(&self, columns: &[usize]) -> bool {
        let is_constant = |&column: &usize| {
            let mut values = self.look.known(column);
            values.next().is_none_or(|first| values.all(|value| value == first))
        };
        columns.iter().all(is_constant)
    }

    /// The columns of the attitude: angles, otherwise a quaternion that changes.
    pub(super) fn attitude(&mut self, checks: &mut Vec<String>) -> Option<AttitudeColumns> {
        let role = |column: usize| match self.known.is_estimated(column) {
            true => AttitudeRole::Onboard,
            false => AttitudeRole::Unit,
        };
        if let Some(columns) = self.known.all([0, 1, 2].map(Quantity::Attitude)) {
            let largest = columns.map(|column| self.look.largest(column)).into_iter();
            let unit = match self.known.unit(columns[0]) {
                Some("deg") => AngleUnit::Degrees,
                Some("rad") => AngleUnit::Radians,
                _ if largest.fold(0.0, f64::max) > 6.3 => AngleUnit::Degrees,
                _ => AngleUnit::Radians,
            };
            let role = role(columns[0]);
            let columns = columns.map(|column| self.name(column)).to_vec();
            let signs = [1.0; 3];
            return Some(AttitudeColumns { columns, unit, signs, role, ..Default::default() });
        }
        let columns = self.known.all([0, 1, 2, 3].map(Quantity::Quaternion))?;
        if self.are_constant(&columns) {
            checks.push(format!("attitude of {}: the same on every row: ignored", self.file));
            return None;
        }
        let [least, most] = [0.01, 0.99].map(|part| self.norm_quantile(columns, part));
        if most.is_nan() || most > MAX_SPREAD * least {
            checks.push(format!(
                "attitude of {}: the length of the quaternion changes from {least:.3} to {most:.3}, \
                 expected a constant: ignored",
                self.file
            ));
            return None;
        }
        if !(0.9..1.1).contains(&least) || !(0.9..1.1).contains(&most) {
            checks.push(format!(
                "attitude of {}: the quaternion has a length of {least:.3} to {most:.3}, expected 1: \
                 normalised",
                self.file
            ));
        }
        let role = role(columns[0]);
        let columns = self.scalar_first(columns);
        let quaternion = columns.map(|column| self.name(column)).to_vec();
        Some(AttitudeColumns { quaternion, signs: [1.0; 3], role, ..Default::default() })
    }

    /// The quantile `part` of the length of a quaternion.
    fn norm_quantile(&self, columns: [usize; 4], part: f64) -> f64 {
        let rows = 0..self.look.columns[columns[0]].len();
        let square = |row: usize| columns.map(|column| self.look.columns[column][row].powi(2));
        let mut norms: Vec<f64> = rows
            .map(|row| square(row).iter().sum::<f64>().sqrt())
            .filter(|norm| *norm > 0.0)
            .collect();
        quantile(&mut norms, part).unwrap_or(f64::NAN)
    }

    /// The columns of a quaternion, scalar first. Numbered columns may have the scalar last, which the specific force
    /// of the file shows.
    fn scalar_first(&self, columns: [usize; 4]) -> [usize; 4] {
        let names = columns.map(|column| self.look.layout.names[column].as_str());
        let Some(accel) = self.known.all([0, 1, 2].map(Quantity::Accel)) else { return columns };
        let at = |column: usize, row: usize| self.look.columns[column][row];
        let rows = (0..self.look.columns[accel[0]].len()).map(|row| {
            (columns.map(|column| at(column, row)), accel.map(|column| at(column, row)))
        });
        let [first, second, third, fourth] = columns;
        let is_last = are_numbered(&names) && is_scalar_last(rows);
        if is_last { [fourth, first, second, third] } else { columns }
    }
}

/// Largest ratio of two lengths of a quaternion.
const MAX_SPREAD: f64 = 1.5;

/// Puts the scalar of a quaternion with numbered columns first, if the specific force of another file shows that it is
/// last. Returns whether it is.
pub(super) fn settle_scalar(mapping: &mut Mapping, dataset: &Dataset) -> bool {
    let apart = |table: &&mut TableMapping| table.accel.is_none();
    let mut tables = mapping.table.iter_mut().filter(apart);
    let Some(attitude) = tables.find_map(|table| table.attitude.as_mut()) else { return false };
    let names: Vec<&str> = attitude.quaternion.iter().map(String::as_str).collect();
    let rows = dataset.imu.windows(2).filter_map(|pair| {
        let rates = pair[1].motion.mean_rates(pair[1].time - pair[0].time);
        let [x, y, z, w] = Rotation::<Body, Ned>::from_euler(pair[1].attitude?).to_array();
        Some(([w, x, y, z], rates.specific_force_mps2.to_array()))
    });
    let is_last = are_numbered(&names) && is_scalar_last(rows);
    if is_last {
        attitude.quaternion.rotate_right(1);
    }
    is_last
}

fn are_numbered(names: &[&str]) -> bool {
    let is_numbered = |name: &&str| {
        let name = name.trim_end_matches([']', ')']);
        name.ends_with(|letter: char| letter.is_ascii_digit())
    };
    names.len() == 4 && names.iter().all(is_numbered)
}

/// Whether quaternions, each with the specific force, have the scalar last: the force is then clearly closer to the
/// vertical than with the scalar first.
fn is_scalar_last(rows: impl Iterator<Item = ([f64; 4], [f64; 3])>) -> bool {
    /// Largest ratio of two horizontal fractions of the specific force, scalar last to scalar first, at which the
    /// scalar is last.
    const CLEARLY: f64 = 0.5;
    let (mut first, mut last) = (0.0, 0.0);
    for (quaternion, force) in rows {
        let [a, b, c, d] = quaternion;
        let horizontal = [horizontal([a, b, c, d], force), horizontal([d, a, b, c], force)];
        if horizontal.iter().all(|part| part.is_finite()) {
            first += horizontal[0];
            last += horizontal[1];
        }
    }
    last < CLEARLY * first
}

/// Square of the horizontal specific force, (m/s²)², if `[w, x, y, z]` is the attitude, of any length.
fn horizontal([w, x, y, z]: [f64; 4], force: [f64; 3]) -> f64 {
    let vertical = [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z];
    let vertical: f64 = vertical.iter().zip(&force).map(|(a, b)| a * b).sum();
    let square = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
    square(&force) - (vertical / square(&[w, x, y, z])).powi(2)
}
