//! Directories of text files and captures, as a logger or a data set makes them.

use std::path::{Path, PathBuf};

use crate::format::Format;
use crate::recognise::{format_of, head_of, recognise};
use hovernav_dataset::LogError;

const ENDINGS: [&str; 5] = ["csv", "txt", "tsv", "dat", "pos"];
/// Largest number of text files in a directory of one log.
const MAX_FILES: usize = 100;
/// Depth of the subdirectories that are searched: a drive of KITTI has `oxts/data`.
const DEPTH: usize = 3;
/// Parts of the names of directories with one sensor each, as EuRoC has them.
const SENSORS: [&str; 8] = ["imu", "acc", "gyr", "gps", "gnss", "mag", "baro", "pressure"];
/// Parts of the names of directories without inertial samples and fixes, as KITTI and EuRoC have them.
const OTHERS: [&str; 6] = ["cam", "image_", "velodyne", "groundtruth", "leica", "vicon"];
/// Name of the times next to a directory with a file for each row.
const TIMES: &str = "timestamps.txt";

/// The format of `log`. A directory is a dataset. It is text with a mapping if it has a `mapping.toml` and no `imu.csv`
/// in hovernav's own columns. A file is recognised from its first bytes.
///
/// # Errors
/// [`LogError`] with the next step for a directory of another kind, and for an unknown file.
pub(crate) fn format_of_log(log: &Path) -> Result<Format, LogError> {
    if !log.is_dir() {
        return recognise(log);
    }
    let has = |name: &str| log.join(name).exists();
    let is_mapped = has("mapping.toml") && !has_own_times(&log.join("imu.csv"));
    if is_mapped || has("imu.csv") || has("dataset.toml") || has("gps.csv") {
        return Ok(if is_mapped { Format::Text } else { Format::Dataset });
    }
    let found = files(log);
    // Text files of other endings may be remarks next to a log.
    let is_table = |file: &PathBuf| {
        file.extension().is_some_and(|last| last == "csv") || file.parent() != Some(log)
    };
    let shown = log.display();
    let tables = found.as_ref().map(|found| found.iter().find(|file| is_table(file)));
    let reason = match (tables, lone_log(log)) {
        (Ok(Some(table)), _) => match table.parent() {
            Some(parent) if has_own_times(&parent.join("imu.csv")) => {
                format!("found a directory, expected its log {}", parent.display())
            }
            _ => format!(
                "found a directory of text files with unknown columns. Run `hovernav init {shown}` to map them"
            ),
        },
        (_, Some(file)) => format!("found a directory, expected its log {}", file.display()),
        (Ok(None), None) => return Ok(Format::Dataset),
        (Err(_), None) => return found.map(|_| Format::Dataset),
    };
    Err(LogError::Unusable { path: log.to_path_buf(), reason })
}

/// The first file of a directory, by name, that is a log in a format of its own.
fn lone_log(directory: &Path) -> Option<PathBuf> {
    let entries = std::fs::read_dir(directory).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> =
        entries.map(|entry| entry.path()).filter(|path| path.is_file()).collect();
    files.sort();
    let is_log = |path: &PathBuf| {
        let format = head_of(path).ok().and_then(|head| format_of(&head));
        format.is_some_and(|format| format != Format::Text)
    };
    files.into_iter().find(is_log)
}

/// Whether a file's first line has hovernav's own time column. A foreign `imu.csv` may be in the same directory as
/// its mapping.
fn has_own_times(file: &Path) -> bool {
    let head = if file.is_file() { head_of(file).unwrap_or_default() } else { Vec::new() };
    let line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
    line.split(|byte| *byte == b',').any(|name| name.trim_ascii().ends_with(b"t_s"))
}

/// Text files and captures of one log in `directory`, otherwise in its subdirectories: those with one sensor each, or
/// the only one with files. Empty without such files.
///
/// # Errors
/// [`LogError::Unusable`], with the next step, for files of several logs and for a file for each row.
pub(crate) fn files(directory: &Path) -> Result<Vec<PathBuf>, LogError> {
    let mut found = directories(directory, DEPTH)?;
    let sensors =
        |(path, files): &(PathBuf, Vec<PathBuf>)| files.len() == 1 && is_called(path, &SENSORS);
    let reason = match &found[..] {
        [(rows, files)] if files.len() > MAX_FILES => of_rows(rows, files.len()),
        [_, _, ..] if !found.iter().all(sensors) => {
            let names: Vec<String> =
                found.iter().take(5).map(|(path, _)| path.display().to_string()).collect();
            format!(
                "found text files in {} subdirectories, expected those of one log: name one of {}",
                found.len(),
                names.join(", ")
            )
        }
        _ => return Ok(found.drain(..).flat_map(|(_, files)| files).collect()),
    };
    Err(LogError::Unusable { path: directory.to_path_buf(), reason })
}

/// Directories with text files, each with the files: `directory`, otherwise those of the next level that has any. A
/// directory with a file for each row replaces the one with their times.
fn directories(directory: &Path, depth: usize) -> Result<Vec<(PathBuf, Vec<PathBuf>)>, LogError> {
    let entries = std::fs::read_dir(directory).map_err(LogError::io(directory))?;
    let mut entries: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    entries.sort();
    let (below, files): (Vec<_>, Vec<_>) = entries.into_iter().partition(|path| path.is_dir());
    let found: Vec<PathBuf> = files.into_iter().filter(|file| is_part(file)).collect();
    let mut deeper = Vec::new();
    if depth > 0 && (found.is_empty() || found.contains(&directory.join(TIMES))) {
        for path in below.iter().filter(|path| !is_called(path, &OTHERS)) {
            // A directory that may not be read is no reason to refuse the others.
            deeper.extend(directories(path, depth - 1).unwrap_or_default());
        }
    }
    let is_here = deeper.is_empty() && !found.is_empty();
    Ok(if is_here { vec![(directory.to_path_buf(), found)] } else { deeper })
}

fn is_part(file: &Path) -> bool {
    let ending = file.extension().unwrap_or_default().to_ascii_lowercase();
    let is_capture = || head_of(file).is_ok_and(|head| format_of(&head) == Some(Format::Raw));
    file.is_file() && (ENDINGS.iter().any(|known| ending == *known) || is_capture())
}

fn is_called(directory: &Path, parts: &[&str]) -> bool {
    let name = directory.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    parts.iter().any(|part| name.contains(part))
}

/// Reason against a directory with `count` files of one row each, with the command that joins them.
fn of_rows(directory: &Path, count: usize) -> String {
    let shown = directory.display();
    let found = format!("found {count} text files, expected at most {MAX_FILES}, one a sensor");
    let times = directory.parent().map(|parent| parent.join(TIMES)).filter(|times| times.is_file());
    match times {
        Some(times) => format!(
            "{found}: join the rows with `paste -d ' ' {} <(cat {shown}/*.txt) > oxts.txt`, and run `hovernav init \
             oxts.txt`",
            times.display()
        ),
        None => format!("{found}: name the files of one log; join files of one row each"),
    }
}
