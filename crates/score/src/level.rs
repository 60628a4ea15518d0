//! Reliability of a result.

use serde::Serialize;

/// Reliability, worst last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Usable as it is.
    Good,
    /// Usable, after a look at the reasons.
    Care,
    /// Not to be relied on.
    Bad,
}

impl Level {
    /// All levels, best first.
    pub const ALL: [Self; 3] = [Self::Good, Self::Care, Self::Bad];

    /// Name: `good`, `care` or `bad`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Care => "care",
            Self::Bad => "bad",
        }
    }
}
