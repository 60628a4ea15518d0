//! The files of a ROS 2 bag.

use std::path::{Path, PathBuf};

use hovernav_dataset::LogError;
use hovernav_toml::read_bytes;

/// The message files of a ROS 2 bag.
pub(crate) struct Bag {
    /// The files in their order.
    pub files: Vec<PathBuf>,
    /// Names of the files that the bag's metadata lists, but that are missing.
    pub missing: Vec<String>,
    /// Names of .mcap files that the bag's metadata does not list. These files are not read.
    pub unlisted: Vec<String>,
}

/// Endings of packed files.
const PACKED: [&str; 2] = [".zstd", ".zst"];

/// The message files of a ROS 2 bag; `None` for other logs. A bag is a directory with a `metadata.yaml`, or with .mcap
/// files but no tables: a killed recorder writes no metadata. Only files that the metadata lists are read, if at least
/// one of them exists.
pub(crate) fn files_of_bag(log: &Path) -> Result<Option<Bag>, LogError> {
    let has = |name: &str| log.join(name).is_file();
    if !log.is_dir() || has("imu.csv") || has("mapping.toml") {
        return Ok(None);
    }
    let entries = std::fs::read_dir(log).map_err(LogError::io(log))?;
    let files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    let with = |endings: &[&str]| {
        let is_such =
            |file: &&PathBuf| endings.iter().any(|ending| plain_name(file).ends_with(ending));
        let mut found: Vec<PathBuf> = files.iter().filter(is_such).cloned().collect();
        // rosbag2 numbers the files of a split bag: `flight_9.mcap`, `flight_10.mcap`.
        let number = |file: &PathBuf| {
            let stem = file.file_name()?.to_str()?.split('.').next()?;
            stem.rsplit('_').next()?.parse::<u32>().ok()
        };
        found.sort_by_key(|file| (number(file), file.clone()));
        found
    };
    let mut messages = with(&[".mcap"]);
    let is_dataset = || has("dataset.toml") || !with(&[".csv"]).is_empty();
    if !has("metadata.yaml") && (messages.is_empty() || is_dataset()) {
        return Ok(None);
    }
    // If a file is next to its packed copy, one of both is read.
    messages.dedup_by_key(|file| plain_name(file));
    let mut missing = listed_in_bag(&log.join("metadata.yaml"));
    let listed = missing.clone();
    let place = |file: &PathBuf| listed.iter().position(|listed| *listed == plain_name(file));
    let mut unlisted = Vec::new();
    if messages.iter().any(|file| place(file).is_some()) {
        unlisted = messages.iter().filter(|file| place(file).is_none()).map(plain_name).collect();
        messages.retain(|file| place(file).is_some());
        messages.sort_by_key(place);
        missing.retain(|listed| messages.iter().all(|file| plain_name(file) != *listed));
    } else {
        missing.clear();
    }
    // A SQLite file is rejected later, with advice in the error.
    let found = if messages.is_empty() { with(&[".db3"]) } else { messages };
    if found.is_empty() {
        let reason = "found a ROS 2 bag without an .mcap file".to_owned();
        return Err(LogError::Unusable { path: log.to_path_buf(), reason });
    }
    Ok(Some(Bag { files: found, missing, unlisted }))
}

/// Name of a file without the ending of a packed one.
fn plain_name(file: impl AsRef<Path>) -> String {
    let name = file.as_ref().file_name().unwrap_or_default().to_string_lossy().into_owned();
    let plain = PACKED.iter().find_map(|ending| name.strip_suffix(ending));
    plain.map_or_else(|| name.clone(), str::to_owned)
}

/// Names of the files that the `metadata.yaml` of a bag lists, in their order. The ending of a packed copy is removed.
fn listed_in_bag(metadata: &Path) -> Vec<String> {
    /// Largest metadata that is read, bytes.
    const LARGEST: u64 = 1 << 24;
    let bytes = read_bytes(metadata, LARGEST).unwrap_or_default();
    let text = String::from_utf8_lossy(&bytes);
    let mut lines = text.lines().map(str::trim);
    lines.by_ref().find(|line| *line == "relative_file_paths:");
    let items = lines.map_while(|line| line.strip_prefix("- "));
    items.map(|item| plain_name(item.trim().trim_matches(['"', '\'']))).collect()
}
