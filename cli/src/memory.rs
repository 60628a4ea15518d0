//! Checks that the free memory is sufficient.

use std::path::Path;

use anyhow::{anyhow, ensure};
use hovernav_dataset::{Dataset, LogError};
use hovernav_formats::{Log, Options};
use hovernav_replay::smoothing_bytes;

/// Memory for a page and files, in addition to the log, bytes.
const RESERVE: u64 = 64 << 20;

/// Opens `log`, unless the estimated memory exceeds the free memory. The estimate is `times` the size of the log in
/// memory.
pub fn open(log: &Path, options: &Options, times: u64) -> anyhow::Result<Log> {
    check(log, options, times)?;
    hovernav_formats::open(log, options).map_err(in_terms_of_features)
}

/// `error` for the user. If this build cannot read the format of the file, the error names the feature that adds the
/// reader.
pub fn in_terms_of_features(error: LogError) -> anyhow::Error {
    match error {
        LogError::MissingFeature { path, format, feature: reader } => {
            let feature = if reader == "record" { reader } else { "formats" };
            anyhow!(
                "{}: found {format}, which this build cannot read: it lacks the feature `{feature}`",
                path.display()
            )
        }
        other => other.into(),
    }
}

/// Rejects `log` if `times` its size in memory exceeds the free memory.
pub fn check(log: &Path, options: &Options, times: u64) -> anyhow::Result<()> {
    let (needed, free) = (times * hovernav_formats::bytes_of(log, options)?, free_bytes());
    ensure!(
        needed <= free,
        "{}: reading takes about {:.2} GB of memory, found {:.2} GB free: expected more memory or a shorter \
         log",
        log.display(),
        needed as f64 / 1e9,
        free as f64 / 1e9
    );
    Ok(())
}

/// Rejects a log that is too long to smooth in the free memory, before smoothing starts.
pub fn check_smoothing(log: &Path, dataset: &Dataset) -> anyhow::Result<()> {
    let needed = smoothing_bytes(dataset) + RESERVE;
    let free = free_bytes();
    ensure!(
        needed <= free,
        "{}: smoothing {} samples takes {:.2} GB of memory in addition to the log, found {:.2} GB free: \
         expected more memory, a shorter log, or no --smooth",
        log.display(),
        dataset.sample_count(),
        needed as f64 / 1e9,
        free as f64 / 1e9
    );
    Ok(())
}

/// Memory, bytes, that this process may still allocate. It is the minimum of three values: the machine's free memory,
/// the memory left in the control group, and the process's own limit. `u64::MAX` where the system reports no value; the
/// allocation is then attempted.
fn free_bytes() -> u64 {
    let machine = kilobytes("/proc/meminfo", "MemAvailable:");
    let known = [machine, left_in_group(), left_below_limit()].into_iter().flatten();
    known.min().unwrap_or(u64::MAX)
}

/// The value of `key`, in bytes, in a file of lines with kB values.
fn kilobytes(path: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(path).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(1024 * line.split_whitespace().next()?.parse::<u64>().ok()?)
}

/// Memory left in the control group (version 2), bytes.
fn left_in_group() -> Option<u64> {
    let group = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let place = group.lines().find_map(|line| line.strip_prefix("0::"))?;
    let number = |name: &str| -> Option<u64> {
        std::fs::read_to_string(format!("/sys/fs/cgroup{place}/{name}")).ok()?.trim().parse().ok()
    };
    Some(number("memory.max")?.saturating_sub(number("memory.current")?))
}

/// Memory left below the limit of `ulimit -v`, bytes.
fn left_below_limit() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(limit.saturating_sub(kilobytes("/proc/self/status", "VmSize:")?))
}
