//! The verdict at the top of a page.

use std::io::{self, Write};

use serde::Serialize;

use crate::html::Escaped;

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
        self.class()
    }

    /// The CSS class.
    pub(crate) const fn class(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Care => "care",
            Self::Bad => "bad",
        }
    }

    /// A sign in addition to the colour, for colour-blind readers.
    pub(crate) const fn sign(self) -> &'static str {
        match self {
            Self::Good => "✓",
            Self::Care => "!",
            Self::Bad => "✗",
        }
    }
}

/// A verdict with its main reasons, plain text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// The reliability.
    pub level: Level,
    /// The verdict in one sentence.
    pub words: String,
    /// The main reasons, one sentence each.
    pub points: Vec<String>,
}

impl Verdict {
    pub(crate) fn write_to(&self, out: &mut impl Write) -> io::Result<()> {
        let (class, sign) = (self.level.class(), self.level.sign());
        let words = Escaped(&self.words);
        write!(
            out,
            "<div class=\"verdict {class}\"><p><span class=\"sign\" aria-hidden=\"true\">{sign}</span> \
             <strong>{words}</strong></p>"
        )?;
        if !self.points.is_empty() {
            write!(out, "<ul>")?;
            for point in &self.points {
                write!(out, "<li>{}</li>", Escaped(point))?;
            }
            write!(out, "</ul>")?;
        }
        writeln!(out, "</div>")
    }
}
