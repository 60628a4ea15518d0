//! `hovernav convert`: converts any log to a dataset directory, or repairs a damaged flight record.

use std::path::PathBuf;

use anyhow::{Context as _, ensure};
use hovernav_toml::copy_whole;

use crate::arguments::Sensors;
use crate::memory;
use crate::output::{self, Working};

/// The reference file is copied unread: only a scorer may read its contents.
const REFERENCE: &str = "reference.csv";

#[derive(clap::Args)]
pub struct Arguments {
    /// A dataset directory, a flight record or a log of any other format
    log: PathBuf,
    #[command(flatten)]
    sensors: Sensors,
    /// Repair a truncated or damaged flight record: write its intact part as a new record that other programs can open
    #[cfg(feature = "record")]
    #[arg(long, conflicts_with_all = ["imu", "gps", "mag", "baro"])]
    repair: bool,
    /// The directory to write, or with --repair the new record file
    #[arg(long, value_name = "PATH")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let Arguments {
        log,
        sensors,
        #[cfg(feature = "record")]
        repair,
        out,
    } = arguments;
    #[cfg(feature = "record")]
    if *repair {
        return write_repaired(log, out);
    }
    let converting = Working::on("converting");
    let dataset = memory::open(log, &sensors.options(), 1)?.dataset;
    output::create(out)?;
    let same = matches!((log.canonicalize(), out.canonicalize()), (Ok(a), Ok(b)) if a == b);
    ensure!(!same, "{}: found the log itself, expected another directory for --out", out.display());
    dataset.write(out, &[])?;
    let reference = log.join(REFERENCE);
    if reference.exists() {
        let copy = out.join(REFERENCE);
        copy_whole(&reference, &copy).with_context(|| {
            format!("cannot copy {} to {}", reference.display(), copy.display())
        })?;
    }
    drop(converting);
    output::say(format_args!(
        "{}: {} inertial samples, {} fixes, {} stick positions",
        out.display(),
        dataset.imu.len(),
        dataset.fixes.len(),
        dataset.controls.len()
    ));
    for warning in &dataset.warnings {
        output::warn(warning);
    }
    Ok(())
}

#[cfg(feature = "record")]
fn write_repaired(log: &std::path::Path, out: &std::path::Path) -> anyhow::Result<()> {
    let repaired = hovernav_record::repair(log, out)?;
    output::say(format_args!(
        "{}: {} messages, repaired {}",
        out.display(),
        repaired.messages,
        repaired.repair
    ));
    for warning in &repaired.warnings {
        output::warn(warning);
    }
    Ok(())
}
