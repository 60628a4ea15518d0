//! Which widths a servo pulse can have.

/// The shortest pulse that a receiver sends or a servo takes, ms.
///
/// Radio control means 1 to 2 ms; makers' extended ranges end at 0.5 and 2.5 ms.
pub const SHORTEST_MS: f64 = 0.5;
/// The longest such pulse, ms.
pub const LONGEST_MS: f64 = 2.5;

/// Whether a servo's pulse can have this width, ms; NaN cannot.
#[must_use]
pub fn is_plausible(width_ms: f64) -> bool {
    (SHORTEST_MS..=LONGEST_MS).contains(&width_ms)
}
