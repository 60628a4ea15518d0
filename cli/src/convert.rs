//! `hovernav convert`: any log to a dataset directory, or a damaged record to a whole one.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, ensure};
use hovernav_log::copy_whole;

use crate::arguments::Sensors;
use crate::memory;
use crate::output::{self, Working};

/// The reference, which is copied unread: only a scorer may look into it.
const REFERENCE: &str = "reference.csv";

#[derive(clap::Args)]
pub struct Arguments {
    /// A dataset directory, a flight record or a log of any other format
    log: PathBuf,
    #[command(flatten)]
    sensors: Sensors,
    /// Write what is whole of a flight record that was cut off or damaged as a new record, which other
    /// programs open
    #[arg(long, conflicts_with_all = ["imu", "gps", "mag", "baro"])]
    repair: bool,
    /// The directory to write, or with --repair the record, a new file
    #[arg(long, value_name = "PATH")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let Arguments { log, sensors, repair, out } = arguments;
    if *repair {
        return write_repaired(log, out);
    }
    let converting = Working::on("converting");
    let dataset = memory::open(log, &sensors.options(), 1)?.dataset;
    output::create(out)?;
    let same = matches!((log.canonicalize(), out.canonicalize()), (Ok(a), Ok(b)) if a == b);
    ensure!(!same, "{}: the log itself, expected another directory", out.display());
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
        output::say(format_args!("warning: {warning}"));
    }
    Ok(())
}

fn write_repaired(log: &Path, out: &Path) -> anyhow::Result<()> {
    let repaired = hovernav_log::record::repair(log, out)?;
    output::say(format_args!(
        "{}: {} messages, repaired {}",
        out.display(),
        repaired.messages,
        repaired.repair
    ));
    for warning in &repaired.warnings {
        output::say(format_args!("warning: {warning}"));
    }
    Ok(())
}
