//! A page: one HTML file that holds its text, its data and the script that draws them.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use anyhow::Context as _;
use hovernav_log::WholeFile;
use serde::Serialize;

use super::fact::Fact;
use super::figure::Figure;
use super::html::{Escaped, fill};
use super::section::Section;
use super::series::MOST_POINTS;
use super::table::Table;
use super::verdict::Verdict;

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("style.css");
const FIGURES: &str = include_str!("figures.js");
const PLOTLY: &str = include_str!("../../assets/plotly-basic.min.js");

/// What a page shows, in the order in which it shows it. All text is plain: it is escaped here.
pub struct Page<'a> {
    pub title: &'a str,
    pub headlines: &'a [Fact],
    /// What it all comes to, where somebody judged it.
    pub verdict: Option<Verdict>,
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
    /// Spans with a sentence each, in order of time.
    pub marks: Vec<Mark>,
}

/// A span of the time axis that something is said of.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mark {
    /// First and last second.
    pub span: [f64; 2],
    /// What happened, in one plain sentence.
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

/// Warnings that stand unfolded.
const WARNINGS_SHOWN: usize = 4;

impl Page<'_> {
    /// Writes the page to `path`, over what may stand there.
    ///
    /// # Errors
    /// When the file cannot be written; the error names it.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let written = WholeFile::create(path).and_then(|file| {
            let mut out = BufWriter::new(file);
            self.write_to(&mut out)?;
            out.into_inner()?.finish()
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
            "verdict" => self.verdict.iter().try_for_each(|verdict| verdict.write_to(out)),
            "headlines" => self.headlines(out),
            "warnings" => self.warnings(out),
            "facts" => self.facts(out),
            "table" => self.table.iter().try_for_each(|table| table.write_to(out)),
            "together" if self.time.is_some() => write!(
                out,
                "All time axes move together; with the keyboard, arrows move them, + and − zoom, 0 returns. "
            ),
            "together" => Ok(()),
            "thinned" => self.thinned(out),
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
        if self.warnings.is_empty() {
            return write!(out, "<p class=\"quiet\">No warnings.</p>");
        }
        // What the verdict says already is not said again.
        let said = |warning: &String| {
            self.verdict.as_ref().is_some_and(|verdict| verdict.points.contains(warning))
        };
        let warnings: Vec<&String> = self.warnings.iter().filter(|one| !said(one)).collect();
        let heading = match warnings.len() {
            0 => return Ok(()),
            1 => "1 warning".into(),
            count => format!("{count} warnings"),
        };
        writeln!(out, "<div class=\"warnings\"><h2>{heading}</h2><ul>")?;
        // So many that the figures would be far down are folded, but for the first.
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

    fn warning(&self, warning: &str, out: &mut impl Write) -> io::Result<()> {
        write!(out, "<li>{}", Escaped(warning))?;
        let marks = self.time.iter().flat_map(|time| &time.marks);
        if let Some(mark) = marks.into_iter().find(|mark| mark.words == *warning) {
            let [from, to] = mark.span;
            // Plain words for who hears the page instead of seeing it.
            write!(
                out,
                " <button type=\"button\" class=\"show\" data-from=\"{from}\" data-to=\"{to}\" \
                 aria-label=\"Show {from:.1} to {to:.1} s in the figures\">show</button>"
            )?;
        }
        writeln!(out, "</li>")
    }

    /// What a reader who zooms into a long log should know.
    fn thinned(&self, out: &mut impl Write) -> io::Result<()> {
        let span_s = self.time.as_ref().map_or(0.0, |time| time.span[1] - time.span[0]);
        // Of every two points of a line, one is the lowest and one the highest of its stretch.
        let stretch_s = 2.0 * span_s / MOST_POINTS as f64;
        if stretch_s < 2.0 {
            return Ok(());
        }
        write!(
            out,
            "Over so long a time a line has the highest and the lowest value of about every \
             {stretch_s:.0} s, and nothing between. "
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
        // Escaped so that no name within can close the element that holds it.
        let json = serde_json::to_string(&Data { time: self.time.as_ref(), figures })?;
        out.write_all(json.replace('<', "\\u003c").as_bytes())
    }
}
