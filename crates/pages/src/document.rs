//! A page: one HTML file with its text, its data and the drawing script.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use hovernav_toml::WholeFile;
use serde::Serialize;

use crate::fact::Fact;
use crate::figure::Figure;
use crate::html::{Escaped, fill};
use crate::section::Section;
use crate::series::MAX_POINTS;
use crate::table::Table;
use crate::verdict;
use hovernav_score::Verdict;

const TEMPLATE: &str = include_str!("../assets/page.html");
const STYLE: &str = include_str!("../assets/style.css");
const FIGURES: &str = include_str!("../assets/figures.js");
const PLOTLY: &str = include_str!("../assets/plotly-basic.min.js");

/// The contents of a page, in display order. All text is plain and is escaped on output.
#[derive(Default)]
pub struct Page<'a> {
    /// The heading.
    pub title: &'a str,
    /// The headline numbers.
    pub headlines: &'a [Fact],
    /// The verdict, if there is one.
    pub verdict: Option<Verdict>,
    /// Errors and points to check, one sentence each.
    pub warnings: &'a [String],
    /// Further facts, as a table.
    pub facts: &'a [Fact],
    /// The main table of numbers, if there is one.
    pub table: Option<Table>,
    /// The sections, each with a link at the top.
    pub sections: Vec<Section>,
    /// The time axis of the figures. Without it, the page must not contain figures against time.
    pub time: Option<TimeAxis>,
}

/// Clock values, s, from which on the page shows a log relative to its first whole second.
pub(crate) const FAR_S: f64 = 1e6;

/// The zero of a time axis whose first moment is `start_s`, s: that of the log's clock or, if its values are large, the
/// first whole second.
pub(crate) fn first_second(start_s: f64) -> f64 {
    if start_s.abs() >= FAR_S { start_s.floor() } else { 0.0 }
}

/// The label of a time axis with a zero of [`first_second`].
pub(crate) fn time_label(zero_s: f64) -> String {
    if zero_s == 0.0 { "Time, s".into() } else { format!("Time after {zero_s:.0} s, s") }
}

/// The common axis of all figures against time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimeAxis {
    /// The quantity, with its unit.
    pub label: String,
    /// Start and end, s.
    pub span: [f64; 2],
    /// Start and end, s, of each shaded span.
    pub outages: Vec<[f64; 2]>,
    /// Spans with a sentence, in order of time.
    pub marks: Vec<Mark>,
}

/// A span of the time axis with a description.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mark {
    /// Start and end, s.
    pub span: [f64; 2],
    /// The event in one sentence.
    pub words: String,
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

/// Number of warnings outside the folded part.
const WARNINGS_SHOWN: usize = 4;

/// A page that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write the report {}", path.display())]
pub struct PageError {
    /// The file.
    pub path: PathBuf,
    /// The reason.
    pub source: io::Error,
}

impl<'a> Page<'a> {
    /// An empty page.
    #[must_use]
    pub fn titled(title: &'a str) -> Self {
        Self { title, ..Self::default() }
    }

    /// The page as HTML.
    ///
    /// # Errors
    /// Only errors of the JSON writer.
    pub fn html(&self) -> io::Result<String> {
        let mut out = Vec::new();
        self.write_to(&mut out)?;
        String::from_utf8(out).map_err(io::Error::other)
    }

    /// The page inside another document, such as a notebook: a frame of this height, px.
    ///
    /// # Errors
    /// As [`html`](Self::html).
    pub fn framed(&self, height_px: u32) -> io::Result<String> {
        let (html, title) = (self.html()?, Escaped(self.title));
        let page = Escaped(&html);
        Ok(format!(
            "<iframe title=\"{title}\" style=\"width:100%;height:{height_px}px;border:0\" srcdoc=\"{page}\"></iframe>"
        ))
    }

    /// Writes the page to `path` and replaces an existing file.
    ///
    /// # Errors
    /// [`PageError`] if the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), PageError> {
        let written = WholeFile::create(path).and_then(|file| {
            let mut out = BufWriter::new(file);
            self.write_to(&mut out)?;
            out.into_inner()?.finish()
        });
        written.map_err(|source| PageError { path: path.to_path_buf(), source })
    }

    /// Writes the page as HTML.
    ///
    /// # Errors
    /// Errors of writing to `out`. The data cause no error: unknown numbers are written as `null`.
    fn write_to(&self, out: &mut impl Write) -> io::Result<()> {
        fill(out, TEMPLATE, |out, name| match name {
            "title" => write!(out, "{}", Escaped(self.title)),
            "style" => out.write_all(STYLE.as_bytes()),
            "links" => self.links(out),
            "verdict" => self.verdict.iter().try_for_each(|verdict| {
                verdict::write(verdict, out, |reason, out| self.warning(reason, out))
            }),
            "headlines" => self.headlines(out),
            "warnings" => self.warnings(out),
            "facts" => self.facts(out),
            "table" => self.table.iter().try_for_each(|table| table.write_to(out)),
            "together" if self.time.is_some() => write!(
                out,
                "All time axes move together. Keyboard: arrows move, + and − zoom, 0 resets. "
            ),
            "together" => Ok(()),
            "thinned" => self.thinned(out),
            "sections" => self.sections(out),
            "data" => self.data(out),
            "plotly" => out.write_all(PLOTLY.as_bytes()),
            "figures" => out.write_all(FIGURES.as_bytes()),
            _ => unreachable!("page.html has no placeholder {name}"),
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
        if self.warnings.is_empty() {
            return write!(out, "<p class=\"quiet\">No warnings.</p>");
        }
        // Warnings in the verdict are not repeated.
        let said = |warning: &String| {
            self.verdict.as_ref().is_some_and(|verdict| verdict.reasons.contains(warning))
        };
        let warnings: Vec<&String> = self.warnings.iter().filter(|one| !said(one)).collect();
        let heading = match warnings.len() {
            0 => return Ok(()),
            1 => "1 warning".into(),
            count => format!("{count} warnings"),
        };
        writeln!(out, "<div class=\"warnings\"><h2>{heading}</h2><ul>")?;
        // All but the first warnings of a long list are folded, so that the figures stay near the top.
        let (shown, folded) = match warnings.split_at_checked(WARNINGS_SHOWN) {
            Some((shown, folded @ [_, _, ..])) => (shown, folded),
            _ => (&warnings[..], &[][..]),
        };
        shown.iter().try_for_each(|warning| self.warning(warning, out))?;
        write!(out, "</ul>")?;
        if !folded.is_empty() {
            write!(out, "<details><summary>{} more</summary><ul>", folded.len())?;
            folded.iter().try_for_each(|warning| self.warning(warning, out))?;
            write!(out, "</ul></details>")?;
        }
        write!(out, "</div>")
    }

    /// A list item, with a button that shows its span in the figures.
    fn warning(&self, warning: &str, out: &mut impl Write) -> io::Result<()> {
        write!(out, "<li>{}", Escaped(warning))?;
        let marks = self.time.iter().flat_map(|time| &time.marks);
        if let Some(mark) = marks.into_iter().find(|mark| mark.words == *warning) {
            let [from, to] = mark.span;
            // A label for screen readers.
            write!(
                out,
                " <button type=\"button\" class=\"show\" data-from=\"{from}\" data-to=\"{to}\" \
                 aria-label=\"Show {from:.1} to {to:.1} s in the figures\">show</button>"
            )?;
        }
        writeln!(out, "</li>")
    }

    /// A note on thinned lines, for a reader who zooms into a long log.
    fn thinned(&self, out: &mut impl Write) -> io::Result<()> {
        let span_s = self.time.as_ref().map_or(0.0, |time| time.span[1] - time.span[0]);
        // Each pair of points of a line is the minimum and the maximum of its span.
        let stretch_s = 2.0 * span_s / MAX_POINTS as f64;
        if stretch_s < 2.0 {
            return Ok(());
        }
        write!(
            out,
            "Lines are thinned to the minimum and the maximum of about every \
             {stretch_s:.0} s. "
        )
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
            if let Some(what) = section.folded {
                write!(out, "<details><summary>{}</summary>", Escaped(what))?;
            }
            section.write_parts(out)?;
            if section.folded.is_some() {
                write!(out, "</details>")?;
            }
            writeln!(out, "</section>")?;
        }
        Ok(())
    }

    fn data(&self, out: &mut impl Write) -> io::Result<()> {
        let drawn = self.sections.iter().flat_map(Section::figures);
        let figures = drawn.map(|(anchor, figure)| NamedFigure { anchor, figure }).collect();
        // Escaped, so that no text in the data can close the script element.
        let json = serde_json::to_string(&Data { time: self.time.as_ref(), figures })?;
        out.write_all(json.replace('<', "\\u003c").as_bytes())
    }
}
