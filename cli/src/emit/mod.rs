//! Settings for programs that read no files: as Rust, as a C header, and in postcard's bytes, all
//! readable without the standard library.

mod autopilot;
mod estimator;
mod language;
#[cfg(test)]
mod tests;

use std::path::Path;

use crate::output;

#[cfg(feature = "lab")]
pub use autopilot::autopilot;
pub use estimator::estimator;

/// A form in which settings are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Form {
    /// Rust source: functions, and the numbers of an autopilot as constants
    Rust,
    /// A C header for hovernav.h
    C,
    /// The bytes of postcard
    Postcard,
}

impl Form {
    const fn ending(self) -> &'static str {
        match self {
            Self::Rust => "rs",
            Self::C => "h",
            Self::Postcard => "postcard",
        }
    }
}

/// Writes `name` in each of `forms` into `directory`; `text` gives the bytes of a form.
fn write(
    forms: &[Form],
    directory: &Path,
    name: &str,
    text: impl Fn(Form) -> anyhow::Result<Vec<u8>>,
) -> anyhow::Result<()> {
    for &form in forms {
        let path = directory.join(format!("{name}.{}", form.ending()));
        output::write(&path, text(form)?)?;
    }
    Ok(())
}
