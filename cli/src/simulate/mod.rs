//! `hovernav simulate`: a flight whose truth is known, recorded as a dataset.

mod arguments;
mod closed_loop;
mod excitation;
mod failure;
#[cfg(feature = "lines")]
mod lines;
mod page;
mod path;
mod summary;

pub use arguments::Arguments;

use anyhow::ensure;

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    ensure!(
        arguments.heading.is_finite(),
        "heading: found {}, expected degrees",
        arguments.heading
    );
    match arguments.flight {
        Some(flight) => path::run(arguments, flight),
        None => closed_loop::run(arguments),
    }
}
