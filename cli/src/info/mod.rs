//! `hovernav info`: the contents of a log.

#[cfg(feature = "lab")]
mod sticks;

use std::path::PathBuf;

use hovernav_findings::Survey;
use hovernav_formats::Log;
#[cfg(feature = "record")]
use hovernav_record::RecordInfo;

use crate::arguments::Sensors;
use crate::memory;
use crate::output;

#[derive(clap::Args)]
pub struct Arguments {
    /// A dataset directory, a flight record or a log of any other format
    log: PathBuf,
    #[command(flatten)]
    sensors: Sensors,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let reading = output::Working::on("reading");
    let Log {
        format,
        dataset,
        #[cfg(feature = "record")]
        record,
        ..
    } = memory::open(&arguments.log, &arguments.sensors.options(), 2)?;
    let survey = Survey::of(&dataset);
    #[cfg(feature = "lab")]
    let activity = sticks::activity(&dataset)?;
    drop(reading);
    if arguments.json {
        let mut info = serde_json::to_value(&survey)?;
        info["format"] = format.to_string().into();
        info["input"] = arguments.log.display().to_string().into();
        #[cfg(feature = "lab")]
        if let Some(activity) = activity {
            info["excitation"] = serde_json::to_value(activity)?;
        }
        return output::print_json(&info);
    }
    output::print(&survey);
    #[cfg(feature = "lab")]
    if let Some(activity) = activity {
        output::print(sticks::in_words(&activity));
    }
    #[cfg(feature = "record")]
    if let Some(record) = record {
        output::print(RecordInfo(&record));
    }
    Ok(())
}
