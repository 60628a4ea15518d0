//! Whether a model may be flown by.

use std::fmt;

/// How far a model can be trusted, best first.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Deserialize, serde::Serialize,
)]
pub enum Grade {
    /// Everything a control design leans on is known.
    #[serde(rename = "good")]
    Good,
    /// It can be designed for by somebody who has read the reasons.
    #[serde(rename = "care")]
    Care,
    /// A control design leans on something that is not known.
    #[serde(rename = "do not fly")]
    DoNotFly,
}

impl Grade {
    /// As files spell it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Care => "care",
            Self::DoNotFly => "do not fly",
        }
    }
}

impl fmt::Display for Grade {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What whoever made a model says of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// How far it can be trusted.
    pub grade: Grade,
    /// Why not further, one sentence each.
    pub reasons: Vec<String>,
}
