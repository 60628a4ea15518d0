//! Numbers that loggers write instead of unknown positions.

use super::known::Known;
use super::look::Look;
use super::quantity::Quantity;

/// Largest longitude in degrees, as ddmm.mmmm, and in degrees × 10⁷.
const SCALES: [f64; 3] = [360.0, 18_000.0, 3.6e9];

/// Replaces impossible and unknown positions by NaN, and the same numbers in other columns of their rows. Returns the
/// numbers that mean an unknown position. Latitude and longitude both have them, on several rows, at least about a
/// degree from every other position.
pub(super) fn forget_unknown(look: &mut Look, known: &Known) -> Vec<f64> {
    let Some([lat, lon]) = known.all([Quantity::Latitude, Quantity::Longitude]) else {
        return Vec::new();
    };
    let rows = look.columns[lat].iter().copied().zip(look.columns[lon].iter().copied());
    let rows = rows.filter(|(lat, lon)| lat.is_finite() && lon.is_finite());
    let (mut alike, others): (Vec<_>, Vec<_>) = rows.partition(|(lat, lon)| lat == lon);
    let typical = |of: fn(&(f64, f64)) -> f64| {
        let mut values: Vec<f64> = others.iter().map(|row| of(row).abs()).collect();
        values.sort_unstable_by(f64::total_cmp);
        // Each number that means an unknown position is listed once.
        values.dedup();
        values.get(values.len().saturating_sub(1) / 2).copied().unwrap_or(f64::INFINITY)
    };
    let typical = typical(|row| row.0).max(typical(|row| row.1));
    let most = SCALES.into_iter().find(|most| typical <= *most).unwrap_or(f64::INFINITY);
    let degree = most / 360.0;
    alike.retain(|(lat, _)| *lat != 0.0);
    alike.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let repeated = alike.chunk_by(|a, b| a == b).filter(|rows| rows.len() > 1);
    let is_far = |value: &f64| {
        others.iter().all(|(lat, lon)| (lat - value).abs() + (lon - value).abs() > degree)
    };
    let unknown: Vec<f64> = match others.is_empty() {
        true => Vec::new(),
        false => repeated.map(|rows| rows[0].0).filter(is_far).collect(),
    };
    for row in 0..look.columns[lat].len() {
        let place = [look.columns[lat][row], look.columns[lon][row]];
        if place.iter().any(|angle| angle.abs() > most || unknown.contains(angle)) {
            let columns = look.columns.iter_mut().map(|column| &mut column[row]);
            columns.filter(|value| place.contains(value)).for_each(|value| *value = f64::NAN);
        }
    }
    unknown
}
