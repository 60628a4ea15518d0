//! Reasons why a model must not be flown.

use super::signs::WrongSign;
use super::state_space::StateSpace;
use super::verdict::{Grade, Verdict};

/// Beginning of the source text of every identified model.
pub const IDENTIFIED: &str = "identified by prediction error";

/// Reasons why a model must not be flown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unflyable {
    /// The verdict in the model is "do not fly".
    #[error("found the verdict \"do not fly\" ({}), expected a flyable model", .reasons.join("; "))]
    Verdict {
        /// The verdict's reasons.
        reasons: Vec<String>,
    },
    /// An identified model without a verdict. Identification always writes a verdict.
    #[error(
        "found {found} and no verdict, expected the verdict that `hovernav identify` writes; a model written by hand \
         has no {key}"
    )]
    NoVerdict {
        /// Evidence that the model was identified.
        found: &'static str,
        /// Key of the evidence; a model written by hand does not have this key.
        key: &'static str,
    },
    /// A derivative has an impossible sign.
    #[error("{0}")]
    Sign(WrongSign),
}

impl StateSpace {
    /// The reason why the model must not be flown, or `None` if it may be flown. The reason is a verdict "do not fly",
    /// an identified model without a verdict, or an impossible sign according to [`StateSpace::wrong_signs`]. A model
    /// written by hand needs no verdict.
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
                        "a source that states identification",
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
