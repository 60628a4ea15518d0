//! The verdict at the top of a page.

use std::io::{self, Write};

use hovernav_score::{Level, Verdict};

use crate::html::Escaped;

/// A sign in addition to the colour, for colour-blind readers.
pub const fn sign(level: Level) -> &'static str {
    match level {
        Level::Good => "✓",
        Level::Care => "!",
        Level::Bad => "✗",
    }
}

/// Writes `verdict` to `out` as HTML, each reason by `item`. The name of its level is its CSS class.
pub fn write<W: Write>(
    verdict: &Verdict,
    out: &mut W,
    item: impl Fn(&str, &mut W) -> io::Result<()>,
) -> io::Result<()> {
    let Verdict { level, words, reasons } = verdict;
    let (class, sign, words) = (level.name(), sign(*level), Escaped(words));
    write!(
        out,
        "<div class=\"verdict {class}\"><p><span class=\"sign\" aria-hidden=\"true\">{sign}</span> \
         <strong>{words}</strong></p>"
    )?;
    if !reasons.is_empty() {
        write!(out, "<ul>")?;
        reasons.iter().try_for_each(|reason| item(reason, out))?;
        write!(out, "</ul>")?;
    }
    writeln!(out, "</div>")
}
