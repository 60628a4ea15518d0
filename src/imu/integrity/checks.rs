//! Choice of the checks on single axes.

/// Faults of single axes that the monitor looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Checks {
    /// Readings at full scale.
    pub clipping: bool,
    /// Shocks.
    pub shocks: bool,
    /// Axes that repeat one reading.
    pub stuck_axes: bool,
}

impl Checks {
    /// All faults.
    pub const ALL: Self = Self { clipping: true, shocks: true, stuck_axes: true };
}
