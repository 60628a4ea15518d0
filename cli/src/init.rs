//! `hovernav init`: a mapping for foreign text files.

use std::path::{Path, PathBuf};

use anyhow::ensure;
use hovernav_formats::Proposal;

use crate::output;

#[derive(clap::Args)]
pub struct Arguments {
    /// Text files in columns, of one flight: one file with all sensors, or one per sensor
    #[arg(required = true)]
    file: Vec<PathBuf>,
    /// The directory for mapping.toml and dataset.toml [default: named after the first file]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace an existing mapping.toml
    #[arg(long)]
    force: bool,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let Arguments { file, out, force } = arguments;
    let looking = output::Working::on("looking at the columns");
    let proposal = Proposal::of(file)?;
    drop(looking);
    let out = out.clone().unwrap_or_else(|| default_directory(&file[0]));
    ensure!(!out.is_file(), "{}: found a file, expected a directory for --out", out.display());
    output::say_text(&proposal);
    proposal.write(&out, *force)?;
    let shown = out.display();
    output::say(format_args!("\nwrote {shown}/mapping.toml and {shown}/dataset.toml"));
    match proposal.has_motion() {
        true if proposal.has_fixes() => {
            output::say(format_args!("next: hovernav estimate {shown}"));
        }
        true => output::say(format_args!("next: hovernav init with a file of positions")),
        false => output::say(format_args!("next: hovernav score {shown} REFERENCE")),
    }
    Ok(())
}

/// The default directory, relative to the working directory: `flight` for `logs/flight.csv`. A file without an
/// extension gives its name with `-mapped`.
fn default_directory(file: &Path) -> PathBuf {
    let stem = file.file_stem().unwrap_or_default();
    let is_bare = file.extension().is_none();
    let mut name = stem.to_os_string();
    if is_bare {
        name.push("-mapped");
    }
    PathBuf::from(name)
}
