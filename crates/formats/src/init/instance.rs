//! Files with rows of several sensors of one kind, as mavlogdump writes them.

use super::known::Known;
use super::look::Look;
use super::quantity::Quantity;
use crate::receivers::{PART_S, Tracks};

/// Largest number that a sensor may have.
const LARGEST: u32 = 9;
/// Number of rows of a receiver in the parts of a file that are searched for static hold: 10 s at 5 Hz. The unit of the
/// time is unknown here.
const PART_ROWS: f64 = 50.0;
/// Smallest latitude or longitude that is in 1e-7 degrees.
const MIN_SCALED: f64 = 1e4;

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
    let readings = |number: u32| -> usize {
        let rows = look.columns[column].iter().enumerate();
        let rows = rows.filter(|(_, found)| **found == f64::from(number));
        let is_reading = |value: f64| value.is_finite() && value != 0.0;
        rows.map(|(row, _)| read.iter().filter(|values| is_reading(values[row])).count()).sum()
    };
    let tracks = tracks(look, known, column);
    let counts: Vec<(u32, usize)> = (0..=LARGEST)
        .filter(|number| look.known(column).any(|found| found == f64::from(*number)))
        .map(|number| (number, readings(number).saturating_sub(read.len() * tracks.held(&number))))
        .collect();
    let most = counts.iter().map(|(_, count)| *count).max()?;
    let first = counts.iter().find(|(_, count)| *count as f64 >= MANY * most as f64)?;
    (counts.len() > 1).then_some((column, first.0))
}

/// Positions and speeds of the receivers, whose numbers are in `column`, with the number of the receiver's row as time.
fn tracks(look: &Look, known: &Known, column: usize) -> Tracks<u32> {
    let mut tracks = Tracks::default();
    let Some(place) = known.all([Quantity::Latitude, Quantity::Longitude]) else { return tracks };
    let degrees = |column: usize, row: usize| {
        let is_scaled = look.largest(column) > MIN_SCALED;
        look.columns[column][row] * if is_scaled { 1e-7 } else { 1.0 }
    };
    let velocity = known.all([0, 1].map(Quantity::Velocity));
    let speed = velocity.or(known.column(Quantity::Speed).map(|speed| [speed; 2]));
    let mut rows = [0.0; LARGEST as usize + 1];
    for (row, number) in look.columns[column].iter().enumerate() {
        let number = *number as u32;
        let Some(of_receiver) = rows.get_mut(number as usize) else { continue };
        let time_s = *of_receiver * PART_S / PART_ROWS;
        *of_receiver += 1.0;
        let velocity_mps = speed.map_or([f64::NAN; 2], |at| at.map(|at| look.columns[at][row]));
        tracks.push(number, time_s, place.map(|at| degrees(at, row)), velocity_mps);
    }
    tracks
}
