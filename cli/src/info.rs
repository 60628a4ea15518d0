//! `hovernav info`: what is in a log.

use std::path::PathBuf;

use hovernav_formats::{Log, Options};
use hovernav_log::Info;
use hovernav_log::record::RecordInfo;

#[derive(clap::Args)]
pub struct Arguments {
    /// A dataset directory or a flight record
    log: PathBuf,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let Log { dataset, record, .. } = hovernav_formats::open(&arguments.log, &Options::default())?;
    print!("{}", Info(&dataset));
    if let Some(record) = record {
        print!("{}", RecordInfo(&record));
    }
    Ok(())
}
