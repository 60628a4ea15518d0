//! Valid widths of servo pulses.

/// The shortest pulse of a receiver or servo, ms.
///
/// The standard of radio control is 1 to 2 ms; makers' extended ranges end at 0.5 and 2.5 ms.
pub const SHORTEST_MS: f64 = 0.5;
/// The longest pulse of a receiver or servo, ms.
pub const LONGEST_MS: f64 = 2.5;

/// Whether the width, ms, is valid for a servo pulse; false for NaN.
#[must_use]
pub fn is_plausible(width_ms: f64) -> bool {
    (SHORTEST_MS..=LONGEST_MS).contains(&width_ms)
}
