//! Groups of measurements that are accepted or rejected together.

/// Group of measurements that the filter rejects together, and is reset to together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::ekf) enum Group {
    HorizontalPosition,
    VerticalPosition,
    HorizontalVelocity,
    VerticalVelocity,
    Tilt,
    Heading,
    Baro,
    RestRate,
    RestVelocity,
    Range,
    BaselineHeading,
    /// A user's own sensors. They have no gate: a rejection has no history, and the filter is never reset to them.
    Own,
}

impl Group {
    /// Number of groups with a gate.
    pub const COUNT: usize = Self::Own as usize;
    /// Number of groups that observe height.
    pub const HEIGHTS: usize = 3;
    /// Number of GPS groups; they come first.
    pub const GPS: usize = 4;

    /// Whether the group is one of a fix.
    pub const fn is_of_fix(self) -> bool {
        (self as usize) < Self::GPS
    }

    /// Index of the group among those that have one axis and observe height; `None` for other groups.
    pub const fn height(self) -> Option<usize> {
        match self {
            Self::VerticalPosition => Some(0),
            Self::VerticalVelocity => Some(1),
            Self::Baro => Some(2),
            _ => None,
        }
    }

    /// Whether the group has one axis and observes height.
    pub const fn is_height(self) -> bool {
        self.height().is_some()
    }
}
