//! `--export`: the solution in the formats of other programs.

use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::Context as _;
use clap::error::ErrorKind;
use hovernav::ekf::Solution;
use hovernav_dataset::Manifest;
use hovernav_export::{Export, ExportError, ExportFormat, LAYOUT};
use hovernav_toml::WholeFile;

use crate::output::EXPORTED;
use crate::output::{self, cannot_write};

/// A format by name, or `-` for standard output.
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

/// The Foxglove layout that accompanies [`ExportFormat::Mcap`].
const LAYOUT_FILE: &str = "solution.foxglove-layout.json";

/// The files of [`EXPORTED`] that are not requested.
pub fn not_asked(asked: &[ExportArgument]) -> Vec<&'static str> {
    // Formats on standard output have no file.
    let in_files = if is_piped(asked) { Vec::new() } else { formats(asked) };
    let layout = in_files.contains(&ExportFormat::Mcap).then(|| LAYOUT_FILE.to_owned());
    let files: Vec<String> =
        in_files.into_iter().map(ExportFormat::file_name).chain(layout).collect();
    EXPORTED.into_iter().filter(|name| files.iter().all(|file| file != name)).collect()
}

/// Rejects impossible requests before the estimation starts.
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
        return Err(ExportError::MissingFeature(ExportFormat::Parquet).into());
    }
    Ok(())
}

struct InTheMaking {
    path: PathBuf,
    export: Export<'static>,
    /// The unfinished file; `None` for standard output.
    file: Option<WholeFile>,
}

/// The requested files while they are being written.
#[derive(Default)]
pub struct Exports {
    files: Vec<InTheMaking>,
    /// Whether the reader of standard output has closed the pipe. Further output is then discarded, without an error.
    is_unread: bool,
}

impl Exports {
    /// Creates the requested files next to `solution.csv` in `out`, or starts writing to standard output.
    pub fn begin(
        asked: &[ExportArgument],
        manifest: &Manifest,
        out: &Path,
    ) -> anyhow::Result<Self> {
        let name = &manifest.name;
        let utc_at_zero_ns = manifest.utc_at_zero_ns().unwrap_or_default();
        let mut exports = Self::default();
        for format in formats(asked) {
            if is_piped(asked) {
                let path = PathBuf::from("standard output");
                let export =
                    Export::new(format, name, utc_at_zero_ns, BufWriter::new(io::stdout()));
                exports.is_unread = is_unread(export.as_ref().err());
                if !exports.is_unread {
                    exports.files.push(InTheMaking { path, export: export?, file: None });
                }
                continue;
            }
            let path = out.join(format.file_name());
            let begun = WholeFile::create(&path).and_then(|file| Ok((file.handle()?, file)));
            let (handle, file) = begun.with_context(|| cannot_write(&path))?;
            let export = Export::new(format, name, utc_at_zero_ns, BufWriter::new(handle))
                .with_context(|| cannot_write(&path))?;
            if format == ExportFormat::Mcap {
                output::write(&out.join(LAYOUT_FILE), LAYOUT)?;
            }
            exports.files.push(InTheMaking { path, export, file: Some(file) });
        }
        Ok(exports)
    }

    /// Adds a solution to each export.
    pub fn push(&mut self, solution: &Solution) -> anyhow::Result<()> {
        for InTheMaking { path, export, .. } in &mut self.files {
            let written = if self.is_unread { Ok(()) } else { export.push(solution) };
            self.is_unread |= is_unread(written.as_ref().err());
            if !self.is_unread {
                written.with_context(|| cannot_write(path))?;
            }
        }
        Ok(())
    }

    /// Completes each export.
    pub fn finish(self) -> anyhow::Result<()> {
        for InTheMaking { path, export, file } in self.files {
            let written = if self.is_unread { Ok(()) } else { export.finish() };
            if !is_unread(written.as_ref().err()) {
                written.with_context(|| cannot_write(&path))?;
            }
            if let Some(file) = file {
                file.finish().with_context(|| cannot_write(&path))?;
            }
        }
        Ok(())
    }
}

/// Whether the error is a closed pipe.
fn is_unread(error: Option<&ExportError>) -> bool {
    matches!(error, Some(ExportError::Io(error)) if error.kind() == io::ErrorKind::BrokenPipe)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_an_export_is_known_to_those_who_clear_away_earlier_ones() {
        let all = ExportFormat::ALL.map(ExportArgument::Format);
        assert_eq!(not_asked(&[]), EXPORTED);
        assert_eq!(not_asked(&all), [""; 0]);
        assert_eq!(
            EXPORTED.len(),
            all.len() + 1,
            "the layout is the only file that is not a format"
        );
    }
}
