//! Where results go, and how they are written.

use std::path::Path;

use anyhow::Context as _;
use serde::Serialize;

/// What a log's results are called after.
pub fn name_of(log: &Path) -> String {
    let full = log.canonicalize().unwrap_or_else(|_| log.to_path_buf());
    full.file_stem().map_or_else(|| "log".into(), |name| name.to_string_lossy().into_owned())
}

/// Makes the directory that results go to.
pub fn create(directory: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(directory)
        .with_context(|| format!("cannot create {}", directory.display()))
}

/// Writes a summary as JSON that people can read, too.
pub fn write_json(summary: &impl Serialize, path: &Path) -> anyhow::Result<()> {
    let text = serde_json::to_string_pretty(summary)? + "\n";
    std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}
