//! Settings for programs that read no files: as Rust, as a C header, and as postcard bytes. All three work without the
//! standard library.

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

/// The form of emitted settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Form {
    /// Rust source: functions, and the numbers of an autopilot as constants
    Rust,
    /// A C header for hovernav.h
    C,
    /// The postcard encoding, in binary
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

/// Writes `name` in each of `forms` into `directory`; `text` returns the bytes of a form.
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
