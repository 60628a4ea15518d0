//! A value for the horizontal axes and one for the vertical.

/// A size along the horizontal axes, each, and along the vertical.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HorizontalVertical {
    /// North, and east.
    pub horizontal: f64,
    /// Down.
    pub vertical: f64,
}

impl HorizontalVertical {
    /// Of `horizontal` along north and east each, and `vertical` along down.
    #[must_use]
    pub const fn new(horizontal: f64, vertical: f64) -> Self {
        Self { horizontal, vertical }
    }
}
