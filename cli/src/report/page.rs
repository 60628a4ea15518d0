//! The page itself: one HTML file that holds its text, its data and the script that draws them.

use std::borrow::Cow;
use std::fmt::{self, Write as _};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use anyhow::Context as _;
use serde::Serialize;

use super::Fact;
use super::series::Figure;

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("style.css");
const FIGURES: &str = include_str!("figures.js");
const PLOTLY: &str = include_str!("../../assets/plotly-basic.min.js");

/// A heading and what stands below it.
pub struct Section {
    /// Short, unique on the page and free of spaces: the target of a link.
    anchor: Cow<'static, str>,
    title: Cow<'static, str>,
    /// One line for a reader who has never seen such a plot.
    explanation: String,
    parts: Vec<Part>,
}

/// What a section is made of.
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
    /// A section with nothing in it yet. `anchor` is short, unique on the page and free of spaces;
    /// `explanation` is for a reader who has never seen such a plot.
    pub fn new(
        anchor: impl Into<Cow<'static, str>>,
        title: impl Into<Cow<'static, str>>,
        explanation: impl Into<String>,
    ) -> Self {
        let (anchor, title) = (anchor.into(), title.into());
        Self { anchor, title, explanation: explanation.into(), parts: Vec::new() }
    }

    /// With one more figure, table or list of notes.
    pub fn with(mut self, part: impl Into<Part>) -> Self {
        self.parts.push(part.into());
        self
    }

    /// The figures that have something to draw, each with its name on the page.
    fn figures(&self) -> impl Iterator<Item = (String, &Figure)> {
        let figures = self.parts.iter().filter_map(|part| match part {
            Part::Figure(figure) if !figure.rows.is_empty() => Some(figure),
            _ => None,
        });
        figures.enumerate().map(|(index, figure)| (self.name(index), figure))
    }

    /// The name of the figure at `index`: the first has the section's own.
    fn name(&self, index: usize) -> String {
        if index == 0 { self.anchor.to_string() } else { format!("{}-{}", self.anchor, index + 1) }
    }

    fn write_parts(&self, out: &mut impl Write) -> io::Result<()> {
        let mut figures = 0;
        for part in &self.parts {
            match part {
                Part::Figure(figure) => {
                    if let Some(caption) = &figure.caption {
                        write!(out, "<h3>{}</h3>", Escaped(caption))?;
                    }
                    if figure.rows.is_empty() {
                        write!(out, "<p class=\"quiet\">Nothing to draw: the log has none.</p>")?;
                        continue;
                    }
                    let (name, height_px) = (self.name(figures), figure.height_px());
                    figures += 1;
                    write!(
                        out,
                        "<div class=\"figure\" data-figure=\"{name}\" \
                         style=\"height:{height_px}px\"></div>"
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

/// A table of numbers with a line of heads, the first head above the names.
pub struct Table {
    pub caption: String,
    pub heads: Vec<String>,
    pub rows: Vec<TableRow>,
}

impl Table {
    fn write_to(&self, out: &mut impl Write) -> io::Result<()> {
        let Self { caption, heads, rows } = self;
        let caption = Escaped(caption);
        write!(out, "<table class=\"numbers\"><caption>{caption}</caption><thead><tr>")?;
        for head in heads {
            write!(out, "<th scope=\"col\">{}</th>", Escaped(head))?;
        }
        writeln!(out, "</tr></thead><tbody>")?;
        for TableRow { name, numbers } in rows {
            write!(out, "<tr><th scope=\"row\">{}</th>", Escaped(name))?;
            for number in numbers {
                write!(out, "<td>{}</td>", Escaped(number))?;
            }
            writeln!(out, "</tr>")?;
        }
        write!(out, "</tbody></table>")
    }
}

/// What is measured, and its numbers as they are to be read.
pub struct TableRow {
    pub name: String,
    pub numbers: Vec<String>,
}

/// What a page shows, in the order in which it shows it. All text is plain: it is escaped here.
pub struct Page<'a> {
    pub title: &'a str,
    pub headlines: &'a [Fact],
    pub warnings: &'a [String],
    pub facts: &'a [Fact],
    pub table: Option<Table>,
    pub sections: Vec<Section>,
    /// The axis of the figures against time; without it the page may have none of them.
    pub time: Option<TimeAxis>,
}

/// The axis that all figures against time share.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimeAxis {
    pub label: String,
    /// First and last second.
    pub span: [f64; 2],
    /// First and last second of each stretch to shade.
    pub outages: Vec<[f64; 2]>,
}

/// The data that `figures.js` reads.
#[derive(Serialize)]
struct Data<'a> {
    time: Option<&'a TimeAxis>,
    figures: Vec<NamedFigure<'a>>,
}

#[derive(Serialize)]
struct NamedFigure<'a> {
    anchor: String,
    #[serde(flatten)]
    figure: &'a Figure,
}

impl Page<'_> {
    /// Writes the page to `path`, over what may stand there.
    ///
    /// # Errors
    /// When the file cannot be written; the error names it.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let written = File::create(path).and_then(|file| {
            let mut out = BufWriter::new(file);
            self.write_to(&mut out)?;
            out.flush()
        });
        written.with_context(|| format!("cannot write the report {}", path.display()))
    }

    /// Writes the page as HTML.
    ///
    /// # Errors
    /// Those of `out`; the data can cause none, as unknown numbers are written as `null`.
    fn write_to(&self, out: &mut impl Write) -> io::Result<()> {
        fill(out, TEMPLATE, |out, name| match name {
            "title" => write!(out, "{}", Escaped(self.title)),
            "style" => out.write_all(STYLE.as_bytes()),
            "links" => self.links(out),
            "headlines" => self.headlines(out),
            "warnings" => self.warnings(out),
            "facts" => self.facts(out),
            "table" => self.table.iter().try_for_each(|table| table.write_to(out)),
            "together" if self.time.is_some() => write!(out, "All time axes move together. "),
            "together" => Ok(()),
            "sections" => self.sections(out),
            "data" => self.data(out),
            "plotly" => out.write_all(PLOTLY.as_bytes()),
            "figures" => out.write_all(FIGURES.as_bytes()),
            _ => unreachable!("page.html has no place {name}"),
        })
    }

    fn links(&self, out: &mut impl Write) -> io::Result<()> {
        for Section { anchor, title, .. } in &self.sections {
            writeln!(out, "<a href=\"#{anchor}\">{}</a>", Escaped(title))?;
        }
        Ok(())
    }

    fn headlines(&self, out: &mut impl Write) -> io::Result<()> {
        for Fact { label, value } in self.headlines {
            let (label, value) = (Escaped(label), Escaped(value));
            writeln!(out, "<div><dt>{label}</dt><dd>{value}</dd></div>")?;
        }
        Ok(())
    }

    fn warnings(&self, out: &mut impl Write) -> io::Result<()> {
        let heading = match self.warnings.len() {
            0 => return write!(out, "<p class=\"quiet\">No warnings.</p>"),
            1 => "1 warning".into(),
            count => format!("{count} warnings"),
        };
        writeln!(out, "<div class=\"warnings\"><h2>{heading}</h2><ul>")?;
        for warning in self.warnings {
            writeln!(out, "<li>{}</li>", Escaped(warning))?;
        }
        write!(out, "</ul></div>")
    }

    fn facts(&self, out: &mut impl Write) -> io::Result<()> {
        for Fact { label, value } in self.facts {
            let (label, value) = (Escaped(label), Escaped(value));
            writeln!(out, "<tr><th scope=\"row\">{label}</th><td>{value}</td></tr>")?;
        }
        Ok(())
    }

    fn sections(&self, out: &mut impl Write) -> io::Result<()> {
        for section in &self.sections {
            let (anchor, title) = (&section.anchor, Escaped(&section.title));
            let explanation = Escaped(&section.explanation);
            write!(out, "<section id=\"{anchor}\"><h2>{title}</h2><p>{explanation}</p>")?;
            section.write_parts(out)?;
            writeln!(out, "</section>")?;
        }
        Ok(())
    }

    fn data(&self, out: &mut impl Write) -> io::Result<()> {
        let drawn = self.sections.iter().flat_map(Section::figures);
        let figures = drawn.map(|(anchor, figure)| NamedFigure { anchor, figure }).collect();
        // Escaped so that no name within can close the element that holds it.
        let json = serde_json::to_string(&Data { time: self.time.as_ref(), figures })?;
        out.write_all(json.replace('<', "\\u003c").as_bytes())
    }
}

/// Copies `template`, calling `place` for each `{{name}}` in it. What `place` writes is not looked
/// at again, so no text can pose as a place.
fn fill<W: Write>(
    out: &mut W,
    template: &str,
    mut place: impl FnMut(&mut W, &str) -> io::Result<()>,
) -> io::Result<()> {
    let mut rest = template;
    while let Some((before, (name, after))) =
        rest.split_once("{{").and_then(|(before, after)| Some((before, after.split_once("}}")?)))
    {
        out.write_all(before.as_bytes())?;
        place(out, name)?;
        rest = after;
    }
    out.write_all(rest.as_bytes())
}

/// Plain text, so written that HTML shows it as it stands, in an element or a quoted attribute.
struct Escaped<'a>(&'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for character in self.0.chars() {
            match character {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                '\'' => f.write_str("&#39;")?,
                _ => f.write_char(character)?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_become_markup() {
        assert_eq!(
            Escaped(r#"<b onclick="x('&amp;')">"#).to_string(),
            "&lt;b onclick=&quot;x(&#39;&amp;amp;&#39;)&quot;&gt;"
        );
    }

    #[test]
    fn what_fills_a_place_is_not_filled_again() {
        let mut out = Vec::new();
        fill(&mut out, "a{{x}}b{{x}}c{{", |out, name| write!(out, "{{{{{name}}}}}")).unwrap();
        assert_eq!(out, b"a{{x}}b{{x}}c{{");
    }
}
