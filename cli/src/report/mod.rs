//! `hovernav report`: a recorded flight on a page.

mod page;
mod summary;
mod verdict;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::ensure;
use hovernav_dataset::LogError;
use hovernav_formats::Options;
use hovernav_record::Record;
use hovernav_replay::estimate;

use self::page::RecordPage;
use self::summary::RecordSummary;
use crate::{memory, output};

#[derive(clap::Args)]
pub struct Arguments {
    /// A flight record
    record: PathBuf,
    /// Directory to write [default: out/NAME-report]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    let path = &arguments.record;
    if path.is_dir() {
        let reason = "found a directory, expected a flight record of hovernav fly";
        let reason = reason.to_owned();
        return Err(LogError::Unusable { path: path.clone(), reason }.into());
    }
    // A file that is not a record is rejected by [`Record::open`] below, whose error expects a record and not any log.
    if Record::is_mcap(path) {
        memory::check(path, &Options::default(), 1)?;
    }
    let working = output::Working::on("replaying");
    let record = Record::open(path)?;
    let dataset = record.dataset()?;
    let replayed = estimate(&dataset, &record.header.settings()?, |_| {});
    let reproduction = record.reproduced_by(&replayed.solutions);
    let sticks = record.sticks_reproduced()?;
    let out = arguments
        .out
        .clone()
        .unwrap_or_else(|| Path::new("out").join(format!("{}-report", output::name_of(path))));
    output::create(&out)?;
    let fixes = replayed.fixes_compared;
    let mut summary = RecordSummary::new(path, &record, &dataset, reproduction, sticks, fixes);
    RecordPage { record: &record, summary: &summary }.write(&out.join(output::REPORT))?;
    summary.wall_s = started.elapsed().as_secs_f64();
    output::write_json(&summary, &out.join("summary.json"))?;
    drop(working);
    summary.say(&out);
    ensure!(
        reproduction.first_difference.is_none()
            && sticks.is_none_or(|sticks| sticks.first_difference.is_none()),
        "{}: the replay differs from the flight: {}",
        path.display(),
        summary.replay
    );
    Ok(())
}
