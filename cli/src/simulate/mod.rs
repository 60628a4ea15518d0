//! `hovernav simulate`: a simulated flight with known truth, recorded as a dataset.

mod arguments;
mod closed_loop;
mod estimate;
mod excitation;
mod failure;
#[cfg(feature = "lines")]
mod lines;
mod page;
mod path;
mod summary;
mod velocity;

pub use arguments::Arguments;
pub use closed_loop::record;

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    match arguments.flight {
        Some(flight) => path::run(arguments, flight),
        None => closed_loop::run(arguments),
    }
}
