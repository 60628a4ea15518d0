//! `hovernav info`: what is in a log.

use std::path::PathBuf;

use hovernav_formats::Log;
use hovernav_log::Info;
use hovernav_log::record::RecordInfo;

use crate::arguments::Sensors;

#[derive(clap::Args)]
pub struct Arguments {
    /// A dataset directory, a flight record or a log of any other format
    log: PathBuf,
    #[command(flatten)]
    sensors: Sensors,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let Log { dataset, record, .. } =
        hovernav_formats::open(&arguments.log, &arguments.sensors.options())?;
    print!("{}", Info(&dataset));
    if let Some(record) = record {
        print!("{}", RecordInfo(&record));
    }
    Ok(())
}
