//! The directory of the records, and safe record names.

use std::io;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use serde::Serialize;

/// Longest name, bytes.
const LONGEST: usize = 64;
/// Largest number of listed records, newest first.
const LISTED: usize = 500;
/// Reserved device names of Windows.
const DEVICES: [&str; 6] = ["con", "prn", "aux", "nul", "com", "lpt"];

/// An invalid name for a record.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "found the name \"{found}\", expected 1 to {LONGEST} letters, digits, `-`, `_`, `.` or spaces, starting with a letter or digit"
)]
pub struct NameError {
    found: String,
}

/// A record in the directory.
#[derive(Clone, Debug, Serialize)]
pub struct Listed {
    /// Name.
    pub name: String,
    /// Size, bytes.
    pub bytes: u64,
    /// Time of the last change, seconds since the start of 1970.
    pub modified_s: f64,
}

/// The directory.
#[derive(Clone, Debug)]
pub struct Folder {
    root: PathBuf,
}

impl Folder {
    /// Opens the directory at `root`, and creates it if it is missing.
    ///
    /// # Errors
    /// If the directory cannot be created.
    pub fn open(root: &Path) -> io::Result<Self> {
        std::fs::create_dir_all(root)?;
        Ok(Self { root: root.to_path_buf() })
    }

    /// Path of the directory.
    #[must_use]
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The file of a record with this name.
    ///
    /// # Errors
    /// [`NameError`] for a name that could point outside the directory or have a special meaning.
    pub fn record(&self, name: &str) -> Result<PathBuf, NameError> {
        Ok(self.root.join(format!("{}.mcap", checked(name)?)))
    }

    /// The directory for the results of a record.
    ///
    /// # Errors
    /// As [`Folder::record`].
    pub fn results(&self, name: &str) -> Result<PathBuf, NameError> {
        Ok(self.root.join(format!("{}.results", checked(name)?)))
    }

    /// Whether the results of a record with this name would be written through a link, to a directory outside.
    ///
    /// # Errors
    /// As [`Folder::record`].
    pub fn results_are_elsewhere(&self, name: &str) -> Result<bool, NameError> {
        let results = self.results(name)?;
        let inside = [
            results.clone(),
            results.join("estimate"),
            results.join("identify"),
            results.join("dataset"),
        ];
        Ok(inside.iter().any(|path| path.is_symlink()))
    }

    /// The records, newest first.
    ///
    /// # Errors
    /// If the directory cannot be read.
    pub fn list(&self) -> io::Result<Vec<Listed>> {
        let mut listed = Vec::new();
        for entry in std::fs::read_dir(&self.root)? {
            let entry = entry?;
            let path = entry.path();
            let is_record = path.extension().is_some_and(|extension| extension == "mcap");
            let name = path.file_stem().and_then(|stem| stem.to_str());
            let Some(name) = name.filter(|name| is_record && checked(name).is_ok()) else {
                continue;
            };
            // A link counts as its target. A pipe or a device is never opened, so it is not offered.
            let Ok(metadata) = std::fs::metadata(&path) else { continue };
            if !metadata.is_file() {
                continue;
            }
            let since = metadata.modified().ok().and_then(|at| at.duration_since(UNIX_EPOCH).ok());
            listed.push(Listed {
                name: name.to_owned(),
                bytes: metadata.len(),
                modified_s: since.unwrap_or_default().as_secs_f64(),
            });
        }
        listed.sort_by(|a, b| b.modified_s.total_cmp(&a.modified_s));
        listed.truncate(LISTED);
        Ok(listed)
    }
}

fn checked(name: &str) -> Result<&str, NameError> {
    let error =
        || NameError { found: name.chars().take(LONGEST).filter(|c| !c.is_control()).collect() };
    let good = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ');
    let begins = name.starts_with(|c: char| c.is_ascii_alphanumeric());
    let ends = name.ends_with(|c: char| c != '.' && c != ' ');
    let stem = name.split('.').next().unwrap_or_default().to_ascii_lowercase();
    let stem = stem.trim_end_matches(|c: char| c.is_ascii_digit());
    if name.len() > LONGEST
        || !begins
        || !ends
        || !name.chars().all(good)
        || DEVICES.contains(&stem)
    {
        return Err(error());
    }
    Ok(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_leads_out_of_the_folder() {
        let folder = Folder { root: "/records".into() };
        assert_eq!(folder.record("hover 3.b_2-x"), Ok("/records/hover 3.b_2-x.mcap".into()));
        let long = "x".repeat(65);
        for bad in [
            "",
            ".",
            "..",
            "../x",
            "a/b",
            "a\\b",
            "/etc/passwd",
            "a\0b",
            ".hidden",
            "x.",
            "x ",
            " x",
            "C:",
            "C:x",
            "con",
            "NUL.txt",
            "com1",
            "ä",
            "a\nb",
            "-rf",
            "%2e%2e",
            &long,
        ] {
            assert!(folder.record(bad).is_err(), "{bad}");
            assert!(folder.results(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn what_is_no_record_is_not_listed() {
        let place = tempfile::tempdir().unwrap();
        let folder = Folder::open(place.path()).unwrap();
        for file in ["a.mcap", "b.txt", ".c.mcap", "con.mcap"] {
            std::fs::write(place.path().join(file), b"x").unwrap();
        }
        std::fs::create_dir(place.path().join("d.mcap")).unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink("/dev/zero", place.path().join("e.mcap")).unwrap();
        let names: Vec<_> = folder.list().unwrap().into_iter().map(|one| one.name).collect();
        assert_eq!(names, ["a"]);
    }
}
