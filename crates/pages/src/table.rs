//! A table of numbers, or of words in columns without numbers.

use std::io::{self, Write};

use crate::html::Escaped;
use crate::verdict::sign;
use hovernav_score::Level;

/// A table of numbers with a row of heads. The first head is above the names.
pub struct Table {
    /// Contents and units of the table.
    pub caption: String,
    /// The head of each column.
    pub heads: Vec<String>,
    /// The rows, in order.
    pub rows: Vec<TableRow>,
}

impl Table {
    pub(crate) fn write_to(&self, out: &mut impl Write) -> io::Result<()> {
        let Self { caption, heads, rows } = self;
        let caption = Escaped(caption);
        // A table wider than a phone screen scrolls sideways by itself.
        write!(out, "<div class=\"wide\"><table class=\"numbers\"><caption>{caption}</caption>")?;
        write!(out, "<thead><tr>")?;
        let columns = heads.len().saturating_sub(1);
        let of_words: Vec<bool> = (0..columns).map(|column| self.is_of_words(column)).collect();
        let class = |column: usize| match of_words.get(column) {
            Some(true) => " class=\"words\"",
            _ => "",
        };
        for (index, head) in heads.iter().enumerate() {
            let class = index.checked_sub(1).map_or("", class);
            write!(out, "<th scope=\"col\"{class}>{}</th>", Escaped(head))?;
        }
        writeln!(out, "</tr></thead><tbody>")?;
        for TableRow { name, numbers, judged } in rows {
            match judged {
                Some(level) => {
                    let (class, sign) = (level.name(), sign(*level));
                    write!(out, "<tr class=\"{class}\"><th scope=\"row\">{sign} ")?;
                }
                None => write!(out, "<tr><th scope=\"row\">")?,
            }
            write!(out, "{}</th>", Escaped(name))?;
            for (column, number) in numbers.iter().enumerate() {
                write!(out, "<td{}>{}</td>", class(column), Escaped(number))?;
            }
            writeln!(out, "</tr>")?;
        }
        write!(out, "</tbody></table></div>")
    }

    /// Whether a column consists of words: no cell starts like a number.
    fn is_of_words(&self, column: usize) -> bool {
        let cells = || self.rows.iter().filter_map(|row| row.numbers.get(column)?.chars().next());
        cells().next().is_some()
            && !cells().any(|first| first.is_ascii_digit() || "+-−±–.<>".contains(first))
    }
}

/// A measured quantity and its formatted numbers.
pub struct TableRow {
    /// The head of the row.
    pub name: String,
    /// The cells, as text.
    pub numbers: Vec<String>,
    /// The reliability of the row, if it is evaluated.
    pub judged: Option<Level>,
}

impl TableRow {
    /// A row without evaluation.
    #[must_use]
    pub fn new(name: impl Into<String>, numbers: Vec<String>) -> Self {
        Self { name: name.into(), numbers, judged: None }
    }
}
