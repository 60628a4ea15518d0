//! The files of a ROS 2 bag.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use hovernav_log::LogError;

/// The message files of a ROS 2 bag.
pub(crate) struct Bag {
    /// The files in their order.
    pub files: Vec<PathBuf>,
    /// Names of the files that its metadata lists, but that are missing.
    pub missing: Vec<String>,
}

/// The message files of a ROS 2 bag, which is a directory with a `metadata.yaml`; `None` for other logs. Only files
/// that the metadata lists are read, if any of these is there.
pub(crate) fn files_of_bag(log: &Path) -> Result<Option<Bag>, LogError> {
    let has = |name: &str| log.join(name).is_file();
    if !has("metadata.yaml") || has("imu.csv") || has("mapping.toml") {
        return Ok(None);
    }
    let entries = std::fs::read_dir(log).map_err(LogError::io(log))?;
    let files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    let with = |endings: &[&str]| {
        let name = |file: &PathBuf| file.to_string_lossy().into_owned();
        let is_such = |file: &&PathBuf| endings.iter().any(|ending| name(file).ends_with(ending));
        let mut found: Vec<PathBuf> = files.iter().filter(is_such).cloned().collect();
        // rosbag2 numbers the files of a split bag: `flight_9.mcap`, `flight_10.mcap`.
        let number = |file: &PathBuf| {
            let stem = file.file_name()?.to_str()?.split('.').next()?;
            stem.rsplit('_').next()?.parse::<u32>().ok()
        };
        found.sort_by_key(|file| (number(file), file.clone()));
        found
    };
    let mut messages = with(&[".mcap", ".mcap.zstd"]);
    // A file next to its packed copy.
    let all = messages.clone();
    messages.retain(|file| {
        file.extension().is_none_or(|last| last != "zstd")
            || !all.contains(&file.with_extension(""))
    });
    let mut missing = listed_in_bag(&log.join("metadata.yaml"));
    let listed = missing.clone();
    let name = |file: &PathBuf| {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        name.trim_end_matches(".zstd").to_owned()
    };
    let place = |file: &PathBuf| listed.iter().position(|listed| *listed == name(file));
    if messages.iter().any(|file| place(file).is_some()) {
        messages.retain(|file| place(file).is_some());
        messages.sort_by_key(place);
        missing.retain(|listed| messages.iter().all(|file| name(file) != *listed));
    } else {
        missing.clear();
    }
    // A SQLite file is rejected later, with advice in the error.
    let found = if messages.is_empty() { with(&[".db3"]) } else { messages };
    if found.is_empty() {
        let reason = "found a ROS 2 bag without an .mcap file".to_owned();
        return Err(LogError::Unusable { path: log.to_path_buf(), reason });
    }
    Ok(Some(Bag { files: found, missing }))
}

/// Names of the files that the `metadata.yaml` of a bag lists, in their order, without the ending of a packed copy.
fn listed_in_bag(metadata: &Path) -> Vec<String> {
    /// Largest metadata that is read, bytes.
    const LARGEST: u64 = 1 << 24;
    let mut text = String::new();
    let read =
        std::fs::File::open(metadata).and_then(|file| file.take(LARGEST).read_to_string(&mut text));
    if read.is_err() {
        return Vec::new();
    }
    let mut lines = text.lines().map(str::trim);
    lines.by_ref().find(|line| *line == "relative_file_paths:");
    let items = lines.map_while(|line| line.strip_prefix("- "));
    let name = |item: &str| {
        let path = Path::new(item.trim().trim_matches(['"', '\'']));
        let name = path.file_name()?.to_string_lossy().into_owned();
        Some(name.trim_end_matches(".zstd").to_owned())
    };
    items.filter_map(name).collect()
}
