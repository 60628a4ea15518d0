//! Suitability of a model for flight control design.

use std::fmt;

/// Suitability of a model for a control design, best first.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Deserialize, serde::Serialize,
)]
pub enum Grade {
    /// Everything that a control design depends on is known.
    #[serde(rename = "good")]
    Good,
    /// Usable for a control design that considers the reasons.
    #[serde(rename = "care")]
    Care,
    /// The model lacks something that a control design depends on.
    #[serde(rename = "do not fly")]
    DoNotFly,
}

impl Grade {
    /// Spelling in files.
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

/// Verdict of a model's author.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Suitability of the model for a control design.
    pub grade: Grade,
    /// Reasons against a better grade, one sentence each.
    pub reasons: Vec<String>,
}
