//! `--export`: the solution in the formats of other programs.

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;
use std::str::FromStr;

use anyhow::Context as _;
use clap::error::ErrorKind;
use hovernav::ekf::Solution;
use hovernav_export::{Export, ExportError, ExportFormat, LAYOUT};

/// A format by its name, or `-`: standard output.
#[derive(Clone, Copy, PartialEq)]
pub enum ExportArgument {
    Format(ExportFormat),
    StandardOutput,
}

impl FromStr for ExportArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "-" => Ok(Self::StandardOutput),
            _ => text.parse().map(Self::Format).map_err(|error| format!("{error} or -")),
        }
    }
}

/// Whether the solution goes to standard output.
pub fn is_piped(asked: &[ExportArgument]) -> bool {
    asked.contains(&ExportArgument::StandardOutput)
}

fn formats(asked: &[ExportArgument]) -> Vec<ExportFormat> {
    let formats = asked.iter().filter_map(|argument| match argument {
        ExportArgument::Format(format) => Some(*format),
        ExportArgument::StandardOutput => None,
    });
    let mut formats: Vec<ExportFormat> = formats.collect();
    formats.sort_unstable();
    formats.dedup();
    formats
}

/// Refuses what cannot be, before anything is estimated.
pub fn check(asked: &[ExportArgument], logs: usize) -> anyhow::Result<()> {
    let formats = formats(asked);
    if is_piped(asked) && (formats.len() != 1 || logs != 1) {
        let message = format!(
            "--export -: found {} formats and {logs} logs, expected one of each for standard output\n",
            formats.len()
        );
        clap::Error::raw(ErrorKind::ArgumentConflict, message).exit();
    }
    if formats.contains(&ExportFormat::Parquet) && !cfg!(feature = "parquet") {
        return Err(ExportError::LeftOut(ExportFormat::Parquet).into());
    }
    Ok(())
}

/// Writes what was asked for beside `solution.csv` in `out`, or to standard output.
pub fn write(
    asked: &[ExportArgument],
    name: &str,
    solutions: &[Solution],
    out: &Path,
) -> anyhow::Result<()> {
    let export = Export { name, solutions };
    for format in formats(asked) {
        if is_piped(asked) {
            let written = export.write(format, &mut BufWriter::new(io::stdout()));
            // A reader that has gone has what it wanted.
            return match written {
                Err(ExportError::Io(error)) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
                other => Ok(other?),
            };
        }
        let path = out.join(format.file_name());
        let failed = || format!("cannot write {}", path.display());
        let file = File::create(&path).with_context(failed)?;
        export.write(format, &mut BufWriter::new(file)).with_context(failed)?;
        if format == ExportFormat::Mcap {
            let layout = out.join("solution.foxglove-layout.json");
            std::fs::write(&layout, LAYOUT)
                .with_context(|| format!("cannot write {}", layout.display()))?;
        }
    }
    Ok(())
}
