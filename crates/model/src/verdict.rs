//! Whether a model may be flown by.

use std::fmt;

use super::signs::WrongSign;
use super::state_space::StateSpace;

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

/// How the source of an identified model begins.
pub const IDENTIFIED: &str = "identified by prediction error";

/// Why a model is not to be flown by.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unflyable {
    /// It says so itself.
    #[error("found the verdict \"do not fly\" ({}), expected a model to fly by", .reasons.join("; "))]
    Verdict {
        /// The verdict's reasons.
        reasons: Vec<String>,
    },
    /// It was identified and says nothing: whatever identifies writes a verdict.
    #[error(
        "found {found} and no verdict, expected the verdict that `hovernav identify` wrote with it, or a model \
         written by hand, which has no {key}"
    )]
    NoVerdict {
        /// What tells that it was identified.
        found: &'static str,
        /// The key that has it, which in a model written by hand is absent.
        key: &'static str,
    },
    /// A derivative has a sign that none has.
    #[error("{0}")]
    Sign(WrongSign),
}

impl StateSpace {
    /// Why it is not to be flown by: its verdict says so, it was identified and has no verdict, or a derivative has
    /// a sign that none has, as [`StateSpace::wrong_signs`] finds them. A model written by hand has no verdict and
    /// needs none.
    #[must_use]
    pub fn unflyable(&self) -> Option<Unflyable> {
        match self.verdict() {
            Some(Verdict { grade: Grade::DoNotFly, reasons }) => {
                return Some(Unflyable::Verdict { reasons: reasons.clone() });
            }
            Some(_) => {}
            None => {
                let signs = [
                    (
                        self.covariance().is_some(),
                        "the covariance of identified parameters",
                        "parameter_covariance",
                    ),
                    (!self.slopes().is_empty(), "the slopes of identified parameters", "slopes"),
                    (
                        self.source().starts_with(IDENTIFIED),
                        "a source that says it was identified",
                        "such source",
                    ),
                ];
                let told = signs.into_iter().find(|(is, ..)| *is);
                if let Some((_, found, key)) = told {
                    return Some(Unflyable::NoVerdict { found, key });
                }
            }
        }
        self.wrong_signs().into_iter().next().map(Unflyable::Sign)
    }
}
