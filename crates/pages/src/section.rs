//! A section of a page: figures, tables and notes below a heading.

use std::borrow::Cow;
use std::io::{self, Write};

use crate::figure::Figure;
use crate::html::Escaped;
use crate::table::Table;

/// A section: a heading, with the figures, tables and notes below it.
pub struct Section {
    /// Target of links: short, unique on the page, without spaces.
    pub(crate) anchor: Cow<'static, str>,
    pub(crate) title: Cow<'static, str>,
    /// One or two sentences for a reader who does not know such a plot.
    pub(crate) explanation: String,
    /// The summary line, if figures, tables and notes are folded.
    pub(crate) folded: Option<&'static str>,
    parts: Vec<Part>,
}

/// Content of a section: a figure, a table or notes.
pub enum Part {
    Figure(Figure),
    Table(Table),
    /// A list of sentences.
    Notes(Vec<String>),
}

impl From<Figure> for Part {
    fn from(figure: Figure) -> Self {
        Self::Figure(figure)
    }
}

impl From<Table> for Part {
    fn from(table: Table) -> Self {
        Self::Table(table)
    }
}

impl From<Vec<String>> for Part {
    fn from(notes: Vec<String>) -> Self {
        Self::Notes(notes)
    }
}

impl Section {
    /// An empty section. `anchor` is short, unique on the page and without spaces. `explanation` is for a reader who
    /// does not know such a plot.
    pub fn new(
        anchor: impl Into<Cow<'static, str>>,
        title: impl Into<Cow<'static, str>>,
        explanation: impl Into<String>,
    ) -> Self {
        let (anchor, title) = (anchor.into(), title.into());
        Self { anchor, title, explanation: explanation.into(), folded: None, parts: Vec::new() }
    }

    /// Adds a figure, a table or a list of notes.
    pub fn with(mut self, part: impl Into<Part>) -> Self {
        self.parts.push(part.into());
        self
    }

    /// Folds the content of the section behind the words `what`.
    pub const fn folded(mut self, what: &'static str) -> Self {
        self.folded = Some(what);
        self
    }

    /// The figures with data, each with its name on the page.
    pub(crate) fn figures(&self) -> impl Iterator<Item = (String, &Figure)> {
        let figures = self.parts.iter().filter_map(|part| match part {
            Part::Figure(figure) if !figure.rows.is_empty() => Some(figure),
            _ => None,
        });
        figures.enumerate().map(|(index, figure)| (self.name(index), figure))
    }

    /// The name of the figure at `index`: the anchor for the first one, numbered for the others.
    fn name(&self, index: usize) -> String {
        if index == 0 { self.anchor.to_string() } else { format!("{}-{}", self.anchor, index + 1) }
    }

    pub(crate) fn write_parts(&self, out: &mut impl Write) -> io::Result<()> {
        let mut figures = 0;
        for part in &self.parts {
            match part {
                Part::Figure(figure) => {
                    if let Some(caption) = &figure.caption {
                        write!(out, "<h3>{}</h3>", Escaped(caption))?;
                    }
                    if figure.rows.is_empty() {
                        write!(out, "<p class=\"quiet\">No data in the log.</p>")?;
                        continue;
                    }
                    let (name, height_px) = (self.name(figures), figure.height_px());
                    figures += 1;
                    write!(
                        out,
                        "<div class=\"figure\" role=\"figure\" tabindex=\"0\" data-figure=\"{name}\" \
                         aria-label=\"{}\" style=\"height:{height_px}px\"></div>",
                        Escaped(&figure.described(&self.title))
                    )?;
                }
                Part::Table(table) => {
                    write!(out, "<div class=\"tables\">")?;
                    table.write_to(out)?;
                    write!(out, "</div>")?;
                }
                Part::Notes(notes) => {
                    write!(out, "<ul class=\"notes\">")?;
                    for note in notes {
                        write!(out, "<li>{}</li>", Escaped(note))?;
                    }
                    write!(out, "</ul>")?;
                }
            }
        }
        Ok(())
    }
}
