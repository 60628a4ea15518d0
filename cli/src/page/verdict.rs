//! What a page comes to, in its head.

use std::io::{self, Write};

use serde::Serialize;

use super::html::Escaped;

/// How far something can be relied on, worst last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    Good,
    Care,
    Bad,
}

/// A verdict with the reasons that weigh most, plain text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    pub level: Level,
    pub words: String,
    pub points: Vec<String>,
}

impl Verdict {
    pub(super) fn write_to(&self, out: &mut impl Write) -> io::Result<()> {
        // A sign beside the colour, for those who see no colours.
        let (class, sign) = match self.level {
            Level::Good => ("good", "✓"),
            Level::Care => ("care", "!"),
            Level::Bad => ("bad", "✗"),
        };
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
