//! Files with rows of several sensors of one kind, as mavlogdump writes them.

use super::known::Known;
use super::look::Look;
use super::quantity::Quantity;

/// Largest number that a sensor may have.
const LARGEST: u32 = 9;

/// The column with the number of the sensor, `I` or `instance`, and the first sensor number that has about as many
/// readings as any other. `None` for a file with one sensor.
pub(super) fn found(look: &Look, known: &Known) -> Option<(usize, u32)> {
    /// Smallest number of readings of a sensor, relative to the sensor with the most readings.
    const MANY: f64 = 0.5;
    let is_instance = |column: &usize| {
        let name = look.layout.names[*column].rsplit(['.', '/', ' ']).next().unwrap_or_default();
        name == "I" || name.eq_ignore_ascii_case("instance")
    };
    let column = (0..look.columns.len()).find(is_instance)?;
    let is_number = |value: f64| (0..=LARGEST).any(|number| f64::from(number) == value);
    if look.known(column).any(|value| !is_number(value)) {
        return None;
    }
    let is_read = |other: &usize| {
        let quantity = known.meanings[*other].map(|meaning| meaning.quantity);
        quantity.is_some_and(|quantity| quantity != Quantity::Time)
    };
    let read: Vec<&Vec<f64>> =
        (0..look.columns.len()).filter(is_read).map(|other| &look.columns[other]).collect();
    let readings = |number: u32| {
        let rows = look.columns[column].iter().enumerate();
        let rows = rows.filter(|(_, found)| **found == f64::from(number));
        let is_reading = |value: f64| value.is_finite() && value != 0.0;
        rows.map(|(row, _)| read.iter().filter(|values| is_reading(values[row])).count()).sum()
    };
    let counts: Vec<(u32, usize)> = (0..=LARGEST)
        .filter(|number| look.known(column).any(|found| found == f64::from(*number)))
        .map(|number| (number, readings(number)))
        .collect();
    let most = counts.iter().map(|(_, count)| *count).max()?;
    let first = counts.iter().find(|(_, count)| *count as f64 >= MANY * most as f64)?;
    (counts.len() > 1).then_some((column, first.0))
}
