//! Whether there is memory for what is asked.

use std::path::Path;

use anyhow::{anyhow, ensure};
use hovernav_formats::{Log, Options};
use hovernav_log::{Dataset, LogError};

/// What a page and files take beside the log.
const BESIDE: u64 = 64 << 20;

/// Opens `log`, unless that and what is made of it take more memory than is free: so many times the log's own.
pub fn open(log: &Path, options: &Options, times: u64) -> anyhow::Result<Log> {
    check(log, options, times)?;
    hovernav_formats::open(log, options).map_err(|error| match error {
        LogError::LeftOut { path, format, .. } => left_out(&path, &format),
        other => other.into(),
    })
}

/// Why the file at `path` cannot be read, which is of a `format` of another program.
pub fn left_out(path: &Path, format: &str) -> anyhow::Error {
    anyhow!(
        "{}: found {format}, which this build cannot read: it lacks the feature `formats`",
        path.display()
    )
}

/// Refuses `log` where to read it and what is made of it take more memory than is free.
pub fn check(log: &Path, options: &Options, times: u64) -> anyhow::Result<()> {
    let (needed, free) = (times * hovernav_formats::bytes_of(log, options)?, free_bytes());
    ensure!(
        needed <= free,
        "{}: to read it takes about {:.2} GB of memory, found {:.2} GB free: expected more memory or a shorter \
         log",
        log.display(),
        needed as f64 / 1e9,
        free as f64 / 1e9
    );
    Ok(())
}

/// Refuses to smooth what the memory that is free will not hold, before it is begun.
pub fn check_smoothing(log: &Path, dataset: &Dataset) -> anyhow::Result<()> {
    let needed = dataset.smoothing_bytes() + BESIDE;
    let free = free_bytes();
    ensure!(
        needed <= free,
        "{}: smoothing {} samples takes {:.2} GB of memory beside the log, found {:.2} GB free: \
         expected more memory, a shorter log, or no --smooth",
        log.display(),
        dataset.sample_count(),
        needed as f64 / 1e9,
        free as f64 / 1e9
    );
    Ok(())
}

/// Memory that this process may still take: the least of what the machine has, what its control group
/// has left and what its own limit leaves. Where the system does not say, it is tried.
fn free_bytes() -> u64 {
    let machine = kilobytes("/proc/meminfo", "MemAvailable:");
    let known = [machine, left_in_group(), left_below_limit()].into_iter().flatten();
    known.min().unwrap_or(u64::MAX)
}

/// The number of kB behind `key` in a file of such lines.
fn kilobytes(path: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(path).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(1024 * line.split_whitespace().next()?.parse::<u64>().ok()?)
}

/// What version 2 of control groups leaves.
fn left_in_group() -> Option<u64> {
    let group = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let place = group.lines().find_map(|line| line.strip_prefix("0::"))?;
    let number = |name: &str| -> Option<u64> {
        std::fs::read_to_string(format!("/sys/fs/cgroup{place}/{name}")).ok()?.trim().parse().ok()
    };
    Some(number("memory.max")?.saturating_sub(number("memory.current")?))
}

/// What `ulimit -v` leaves.
fn left_below_limit() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(limit.saturating_sub(kilobytes("/proc/self/status", "VmSize:")?))
}
