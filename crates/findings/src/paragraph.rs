//! Text for a terminal of 80 columns.

use std::fmt;

/// Width of the terminal, characters.
pub(crate) const WIDTH: usize = 80;

/// Writes `text` wrapped to 80 columns after `lead`; further lines are indented by its width.
///
/// # Errors
/// Errors of the formatter.
pub fn paragraph(f: &mut fmt::Formatter<'_>, lead: &str, text: &str) -> fmt::Result {
    let indent = lead.chars().count();
    f.write_str(lead)?;
    let mut column = indent;
    for (index, word) in text.split_whitespace().enumerate() {
        let length = word.chars().count();
        if index > 0 && column + 1 + length > WIDTH {
            write!(f, "\n{:indent$}", "")?;
            column = indent;
        } else if index > 0 {
            f.write_str(" ")?;
            column += 1;
        }
        f.write_str(word)?;
        column += length;
    }
    writeln!(f)
}

/// Writes sentences below a title; nothing without sentences.
pub(crate) fn section(
    f: &mut fmt::Formatter<'_>,
    title: &str,
    sentences: &[String],
) -> fmt::Result {
    if sentences.is_empty() {
        return Ok(());
    }
    writeln!(f, "\n{title}")?;
    sentences.iter().try_for_each(|sentence| paragraph(f, "  ", sentence))
}
