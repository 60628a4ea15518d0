//! Pairs of a horizontal and a vertical value.

/// A value for each horizontal axis and one for the vertical axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HorizontalVertical {
    /// Value for north and for east.
    pub horizontal: f64,
    /// Value for down.
    pub vertical: f64,
}

impl HorizontalVertical {
    /// `horizontal` for north and for east, and `vertical` for down.
    #[must_use]
    pub const fn new(horizontal: f64, vertical: f64) -> Self {
        Self { horizontal, vertical }
    }
}
