//! The building blocks of pages. Each page is one self-contained file.
//!
//! A [`Page`] consists of sections, a [`Section`] of figures, tables and notes, a [`Figure`] of rows of [`Series`]. A
//! series has a [`Role`]. `figures.js` defines colour, line and symbol of each role and draws with the script in
//! `assets/`.

mod document;
mod fact;
mod figure;
mod html;
mod numbers;
mod section;
mod series;
mod table;
#[cfg(test)]
mod tests;
mod verdict;

pub use document::{Mark, Page, TimeAxis};
pub use fact::{Fact, digits};
pub use figure::{Abscissa, Axis, Figure, Row};
pub use section::Section;
pub use series::{Role, Series};
pub use table::{Table, TableRow};
pub use verdict::{Level, Verdict};
