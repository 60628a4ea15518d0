//! Why a model is not to be flown by.

use super::signs::WrongSign;
use super::state_space::StateSpace;
use super::verdict::{Grade, Verdict};

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
