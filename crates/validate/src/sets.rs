//! The sets, and their windows without GPS.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use hovernav::time::Time;
use hovernav_dataset::Outage;

/// A log for the evaluation.
#[derive(Clone, Debug)]
pub struct Set {
    /// Name of the set in the table.
    pub name: String,
    /// Directory or file of the log.
    pub path: PathBuf,
    /// Windows without GPS, one entry for each length.
    pub windows: Vec<Windows>,
}

/// Windows without GPS of one length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Windows {
    /// Length of each window, s.
    pub duration_s: f64,
    /// The windows that `docs/validation.md` names: the time of the first start (s, clock of the set), the interval
    /// between starts (s), and the number of windows.
    pub documented: Option<(f64, f64, u32)>,
}

/// Interval between the starts of windows over the whole log, s.
const SPACING_S: f64 = 12.0;

impl Windows {
    /// The documented windows.
    #[must_use]
    pub fn documented(&self) -> Vec<Outage> {
        let (first_s, every_s, count) = self.documented.unwrap_or_default();
        let starts = (0..count).map(|index| first_s + every_s * f64::from(index));
        starts
            .filter_map(Time::try_from_seconds)
            .map(|start| Outage { start, duration_s: self.duration_s })
            .collect()
    }

    /// Windows 12 s apart that fit between `first` and `last`.
    #[must_use]
    pub fn spaced(&self, first: Time, last: Time) -> Vec<Outage> {
        (0_u32..)
            .map(|index| first.offset_by(SPACING_S * f64::from(index)))
            .take_while(|start| start.offset_by(self.duration_s) <= last)
            .map(|start| Outage { start, duration_s: self.duration_s })
            .collect()
    }
}

/// The windows of the set `name`, as `docs/validation.md` lists them; 10 s long if the set is not listed.
fn windows(name: &str) -> Vec<Windows> {
    let of = |duration_s, first_s, every_s, count| Windows {
        duration_s,
        documented: Some((first_s, every_s, count)),
    };
    match name {
        "car-rtk" => vec![of(15.0, 100.0, 43.0, 10), of(30.0, 113.0, 75.0, 6)],
        "uav-thor75-1hz" => vec![of(10.0, 240.0, 38.0, 12)],
        "quad-p4rtk-vibration" => vec![of(10.0, 200.0, 20.0, 8)],
        _ => vec![Windows { duration_s: 10.0, documented: None }],
    }
}

/// The sets of `checkout` and of the `shared` data: datasets, then cases, then logs, each in order of name. A set in
/// both comes from the checkout.
///
/// # Errors
/// A directory that cannot be read. A missing directory counts as empty.
pub fn find(checkout: &Path, shared: &Path) -> io::Result<Vec<Set>> {
    let mut sets = Vec::new();
    let own = entries(&checkout.join("datasets"))?;
    let known: Vec<_> = own.iter().map(|path| path.file_name().map(ToOwned::to_owned)).collect();
    let mut datasets = entries(&shared.join("datasets"))?;
    datasets.retain(|path| !known.contains(&path.file_name().map(ToOwned::to_owned)));
    let is_flight = |path: &PathBuf| path.join("imu.csv").exists();
    sets.extend(own.into_iter().chain(datasets).filter(is_flight).map(|path| set("", path)));
    for group in ["cases", "logs"] {
        sets.extend(entries(&shared.join(group))?.into_iter().map(|path| set(group, path)));
    }
    Ok(sets)
}

fn set(group: &str, path: PathBuf) -> Set {
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let name = if group.is_empty() { file.into_owned() } else { format!("{group}/{file}") };
    Set { windows: windows(&name), name, path }
}

/// Files and directories in order of name, without READMEs and compressed references.
fn entries(directory: &Path) -> io::Result<Vec<PathBuf>> {
    if !directory.exists() {
        return Ok(Vec::new());
    }
    let paths: io::Result<Vec<PathBuf>> =
        fs::read_dir(directory)?.map(|entry| Ok(entry?.path())).collect();
    let is_other =
        |path: &PathBuf| path.extension().is_some_and(|kind| kind == "md" || kind == "gz");
    let mut paths = paths?;
    paths.retain(|path| !is_other(path));
    paths.sort();
    Ok(paths)
}
