#![doc = include_str!("../README.md")]
//!
//! A [`Page`] consists of sections, a [`Section`] of figures, tables and notes, a [`Figure`] of rows of [`Series`]. A
//! series has a [`Role`]. `assets/figures.js` defines colour, line and symbol of each role.
//!
//! ```
//! use hovernav_pages::{Axis, Figure, Page, Role, Row, Section, Series};
//!
//! let gain = Row::new("Gain", "dB").with(Series::curve(Role::Model, [(1.0, 0.0), (10.0, -20.0)]));
//! let figure = Figure::against(Axis::logarithmic("Frequency", "rad/s"), [gain]);
//! let section = Section::new("response", "Response", "Response of a first-order lag.").with(figure);
//! let page = Page { sections: vec![section], ..Page::titled("A model") };
//! assert!(page.html()?.contains("Response of a first-order lag."));
//! # Ok::<(), std::io::Error>(())
//! ```

#[cfg(feature = "campaign")]
pub mod campaign;
pub mod compare;
mod document;
mod fact;
mod figure;
pub mod fleet;
pub mod flight;
mod html;
mod numbers;
mod section;
mod series;
mod table;
#[cfg(test)]
mod tests;
mod verdict;

pub use hovernav_score::{Level, Verdict};

pub use document::{Mark, Page, PageError, TimeAxis};
pub use fact::{Fact, digits};
pub use figure::{Abscissa, Axis, Figure, Row};
pub use section::Section;
pub use series::{Role, Series};
pub use table::{Table, TableRow};
