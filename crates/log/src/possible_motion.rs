//! Check whether the motion in a trajectory's rows is possible for a vehicle.

use crate::fix_gate::no_place;
use crate::remarks::Remarks;
use hovernav::earth::Geodetic;

/// Remark on a row whose velocity is too large.
pub(crate) const TOO_FAST: &str = "with a velocity beyond any vehicle's: velocity ignored";

/// Replaces impossible values among the twelve quantities of a row by NaN, and counts the row in `remarks` at `line`.
/// The quantities are in the order of [`COLUMNS`](crate::reference::COLUMNS) after the time.
///
/// # Errors
/// Reason to reject the row: its position is not on Earth.
pub(crate) fn ensure_motion(
    values: &mut [f64],
    fastest_mps: f64,
    line: u64,
    remarks: &mut Remarks,
) -> Result<(), &'static str> {
    let [lat, lon, height, vn, ve, vd, roll, pitch, yaw, u, v, w, ..] = values else {
        return Ok(());
    };
    // An unknown coordinate passes this check.
    let known = |value: f64| if value.is_nan() { 0.0 } else { value };
    if Geodetic::from_degrees(known(*lat), known(*lon), known(*height)).is_none() {
        return Err(no_place([known(*lat), known(*lon), known(*height)]));
    }
    let mut within = |quantity: [&mut f64; 3], most: f64, what| {
        if quantity.iter().any(|value| value.abs() > most) {
            remarks.count(what, line);
            quantity.into_iter().for_each(|value| *value = f64::NAN);
        }
    };
    within([vn, ve, vd], fastest_mps, TOO_FAST);
    within([u, v, w], fastest_mps, TOO_FAST);
    within([roll, pitch, yaw], 360.0, "with an angle beyond 360°: attitude ignored");
    Ok(())
}
