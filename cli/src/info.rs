//! `hovernav info`: what is in a log.

use std::path::PathBuf;

use hovernav_log::Info;
use hovernav_log::record::RecordInfo;

#[derive(clap::Args)]
pub struct Arguments {
    /// A dataset directory or a flight record
    log: PathBuf,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let (dataset, record) = hovernav_log::open(&arguments.log)?;
    print!("{}", Info(&dataset));
    if let Some(record) = record {
        print!("{}", RecordInfo(&record));
    }
    Ok(())
}
