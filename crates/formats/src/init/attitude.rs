//! The columns of an attitude.

use super::columns::Reader;
use super::quantity::Quantity;
use crate::text::{AngleUnit, AttitudeColumns, AttitudeRole};

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
        let role = role(columns[0]);
        let columns = self.scalar_first(columns);
        let quaternion = columns.map(|column| self.name(column)).to_vec();
        Some(AttitudeColumns { quaternion, signs: [1.0; 3], role, ..Default::default() })
    }

    /// The columns of a quaternion, scalar first. Numbered columns may have the scalar last. They do if the specific
    /// force is then clearly closer to the vertical.
    fn scalar_first(&self, columns: [usize; 4]) -> [usize; 4] {
        /// Largest ratio of two horizontal fractions of the specific force, scalar last to scalar first, at which the
        /// scalar is last.
        const CLEARLY: f64 = 0.5;
        let [first, second, third, fourth] = columns;
        let last = [fourth, first, second, third];
        let is_numbered = |column: &usize| {
            let name = self.look.layout.names[*column].trim_end_matches([']', ')']);
            name.ends_with(|letter: char| letter.is_ascii_digit())
        };
        let Some(accel) = self.known.all([0, 1, 2].map(Quantity::Accel)) else { return columns };
        let is_last = columns.iter().all(is_numbered)
            && self.horizontal_share(last, accel) < CLEARLY * self.horizontal_share(columns, accel);
        if is_last { last } else { columns }
    }

    /// Horizontal fraction of the squared specific force if the columns `quaternion` are the attitude.
    fn horizontal_share(&self, quaternion: [usize; 4], accel: [usize; 3]) -> f64 {
        let (mut horizontal, mut all) = (0.0, 0.0);
        for row in 0..self.look.columns[accel[0]].len() {
            let at = |column: usize| self.look.columns[column][row];
            let ([w, x, y, z], force) = (quaternion.map(at), accel.map(at));
            let vertical =
                [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z];
            let vertical: f64 = vertical.iter().zip(&force).map(|(a, b)| a * b).sum();
            let square = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
            let whole = square(&force) * square(&[w, x, y, z]).powi(2);
            if whole.is_finite() {
                horizontal += whole - vertical * vertical;
                all += whole;
            }
        }
        horizontal / all
    }
}
