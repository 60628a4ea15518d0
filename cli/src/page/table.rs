//! A table of numbers.

use std::io::{self, Write};

use super::html::Escaped;

/// A table of numbers with a line of heads, the first head above the names.
pub struct Table {
    pub caption: String,
    pub heads: Vec<String>,
    pub rows: Vec<TableRow>,
}

impl Table {
    pub(super) fn write_to(&self, out: &mut impl Write) -> io::Result<()> {
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
