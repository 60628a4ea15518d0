//! The page itself: one HTML file that holds its text, its data and the script that draws them.

use std::fmt::Write as _;

use serde::Serialize;

use super::Fact;
use super::series::Figure;

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("style.css");
const FIGURES: &str = include_str!("figures.js");
const PLOTLY: &str = include_str!(concat!(env!("OUT_DIR"), "/plotly.min.js"));

/// One figure with its heading.
pub struct Section {
    /// Short, unique on the page and free of spaces: the target of a link.
    pub anchor: &'static str,
    pub title: &'static str,
    /// One line for a reader who has never seen such a plot.
    pub explanation: String,
    pub figure: Figure,
}

/// A table with a line of heads; the first column is text, the others numbers.
pub struct Table {
    pub caption: String,
    pub heads: Vec<&'static str>,
    pub rows: Vec<Vec<String>>,
}

/// What a page shows, in the order in which it shows it. All text is plain: it is escaped here.
pub struct Page<'a> {
    pub title: &'a str,
    pub headlines: &'a [Fact],
    pub warnings: &'a [String],
    pub facts: &'a [Fact],
    pub table: Option<Table>,
    pub sections: Vec<Section>,
    pub time: TimeAxis,
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
    time: &'a TimeAxis,
    figures: Vec<NamedFigure<'a>>,
}

#[derive(Serialize)]
struct NamedFigure<'a> {
    anchor: &'a str,
    #[serde(flatten)]
    figure: &'a Figure,
}

impl Page<'_> {
    /// The page as HTML.
    ///
    /// # Errors
    /// None that the data can cause: unknown numbers are written as `null`.
    pub fn render(&self) -> serde_json::Result<String> {
        let figures = self.sections.iter().filter(|section| !section.figure.rows.is_empty());
        let figures = figures
            .map(|section| NamedFigure { anchor: section.anchor, figure: &section.figure })
            .collect();
        // Escaped so that no name within can close the element that holds it.
        let data = serde_json::to_string(&Data { time: &self.time, figures })?;
        let data = data.replace('<', "\\u003c");
        let mut html = String::with_capacity(PLOTLY.len() + data.len() + (64 << 10));
        fill(&mut html, TEMPLATE, |html, name| match name {
            "title" => escape(html, self.title),
            "style" => html.push_str(STYLE),
            "links" => self.links(html),
            "headlines" => self.headlines(html),
            "warnings" => self.warnings(html),
            "facts" => self.facts(html),
            "table" => self.table(html),
            "sections" => self.sections(html),
            "data" => html.push_str(&data),
            "plotly" => html.push_str(PLOTLY),
            "figures" => html.push_str(FIGURES),
            _ => debug_assert!(false, "no such place: {name}"),
        });
        Ok(html)
    }

    fn links(&self, html: &mut String) {
        for section in &self.sections {
            let _ = write!(html, "<a href=\"#{}\">{}</a>\n", section.anchor, section.title);
        }
    }

    fn headlines(&self, html: &mut String) {
        for Fact { label, value } in self.headlines {
            html.push_str("<div><dt>");
            escape(html, label);
            html.push_str("</dt><dd>");
            escape(html, value);
            html.push_str("</dd></div>\n");
        }
    }

    fn warnings(&self, html: &mut String) {
        if self.warnings.is_empty() {
            html.push_str("<p class=\"quiet\">No warnings.</p>");
            return;
        }
        let plural = if self.warnings.len() == 1 { "" } else { "s" };
        let _ = write!(
            html,
            "<div class=\"warnings\"><h2>{} warning{plural}</h2><ul>",
            self.warnings.len()
        );
        for warning in self.warnings {
            html.push_str("<li>");
            escape(html, warning);
            html.push_str("</li>\n");
        }
        html.push_str("</ul></div>");
    }

    fn facts(&self, html: &mut String) {
        for Fact { label, value } in self.facts {
            html.push_str("<tr><th scope=\"row\">");
            escape(html, label);
            html.push_str("</th><td>");
            escape(html, value);
            html.push_str("</td></tr>\n");
        }
    }

    fn table(&self, html: &mut String) {
        let Some(table) = &self.table else { return };
        html.push_str("<table class=\"numbers\"><caption>");
        escape(html, &table.caption);
        html.push_str("</caption><thead><tr>");
        for head in &table.heads {
            let _ = write!(html, "<th scope=\"col\">{head}</th>");
        }
        html.push_str("</tr></thead><tbody>\n");
        for row in &table.rows {
            html.push_str("<tr>");
            for (column, cell) in row.iter().enumerate() {
                html.push_str(if column == 0 { "<th scope=\"row\">" } else { "<td>" });
                escape(html, cell);
                html.push_str(if column == 0 { "</th>" } else { "</td>" });
            }
            html.push_str("</tr>\n");
        }
        html.push_str("</tbody></table>");
    }

    fn sections(&self, html: &mut String) {
        for Section { anchor, title, explanation, figure } in &self.sections {
            let _ = write!(html, "<section id=\"{anchor}\"><h2>{title}</h2><p>");
            escape(html, explanation);
            html.push_str("</p>");
            if figure.rows.is_empty() {
                html.push_str("<p class=\"quiet\">Nothing to draw: the log has none.</p>");
            } else {
                let _ = write!(
                    html,
                    "<div class=\"figure\" data-figure=\"{anchor}\" style=\"height:{}px\"></div>",
                    figure.height_px()
                );
            }
            html.push_str("</section>\n");
        }
    }
}

/// Copies `template`, calling `place` for each `{{name}}` in it. What `place` writes is not looked
/// at again, so no text can pose as a place.
fn fill(html: &mut String, template: &str, mut place: impl FnMut(&mut String, &str)) {
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        let Some((name, after)) = after.split_once("}}") else { break };
        html.push_str(before);
        place(html, name);
        rest = after;
    }
    html.push_str(rest);
}

/// Appends plain text so that HTML shows it as it stands, in an element or a quoted attribute.
fn escape(html: &mut String, text: &str) {
    for character in text.chars() {
        match character {
            '&' => html.push_str("&amp;"),
            '<' => html.push_str("&lt;"),
            '>' => html.push_str("&gt;"),
            '"' => html.push_str("&quot;"),
            '\'' => html.push_str("&#39;"),
            _ => html.push(character),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_cannot_become_markup() {
        let mut html = String::new();
        escape(&mut html, r#"<b onclick="x('&amp;')">"#);
        assert_eq!(html, "&lt;b onclick=&quot;x(&#39;&amp;amp;&#39;)&quot;&gt;");
    }

    #[test]
    fn what_fills_a_place_is_not_filled_again() {
        let mut html = String::new();
        fill(&mut html, "a{{x}}b{{x}}c{{", |html, name| html.push_str(&format!("{{{{{name}}}}}")));
        assert_eq!(html, "a{{x}}b{{x}}c{{");
    }
}
