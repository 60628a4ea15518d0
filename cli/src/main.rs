//! The command `hovernav`: one verb a job. It reads arguments, shows progress and writes files; what
//! is computed, the library computes.

mod campaign;
mod convert;
mod design;
mod estimate;
#[cfg(all(feature = "fly", target_os = "linux"))]
mod fly;
mod identify;
mod inject;
mod log;
mod model;
#[cfg(feature = "fly")]
mod play;
mod report;
mod simulate;
mod summary;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use hovernav_log::Info;
use hovernav_log::record::RecordInfo;

/// Navigation for small helicopters and drones: from a recorded log to position, velocity and
/// attitude with honest uncertainties.
#[derive(Parser)]
#[command(version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Run the filter over a log; writes solution.csv, summary.json and report.html
    Estimate(estimate::Arguments),
    /// Identify a model of the helicopter from a flight, and validate it; writes model.toml,
    /// summary.json and report.html
    Identify(identify::Arguments),
    /// Say what is in a log: sensors, rates, spans, gaps
    Info {
        /// A dataset directory or a flight record
        log: PathBuf,
    },
    /// Fly: the real-time loop on the flight computer, recorded
    #[cfg(all(feature = "fly", target_os = "linux"))]
    Fly(fly::Arguments),
    /// Play a log as the sensors sent it, over pseudo-terminals, for `hovernav fly` to fly on
    #[cfg(feature = "fly")]
    Play(play::Arguments),
    /// Write any log as a dataset directory
    Convert(convert::Arguments),
    /// Make a copy of a log with faults in it: vibration, gaps, GPS glitches and many more
    Inject(inject::Arguments),
    /// Design the hover autopilot for a model and check it at the loop's own rate; writes
    /// autopilot.toml, summary.json and report.html
    Design(design::Arguments),
    /// Fly in simulation, the closed loop with sensors, estimator and servos inside, or with --flight
    /// along a path, and record it as a dataset
    Simulate(simulate::Arguments),
    /// Fly the closed loop many times over, airframe, wind, sensors and GPS drawn anew for each; writes
    /// results.csv, percentiles.csv, summary.json and report.html
    Campaign(campaign::Arguments),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().verb {
        Verb::Estimate(arguments) => estimate::run(&arguments),
        #[cfg(all(feature = "fly", target_os = "linux"))]
        Verb::Fly(arguments) => fly::run(&arguments),
        #[cfg(feature = "fly")]
        Verb::Play(arguments) => play::run(&arguments),
        Verb::Identify(arguments) => identify::run(&arguments),
        Verb::Info { log } => info(&log),
        Verb::Convert(arguments) => convert::run(&arguments),
        Verb::Inject(arguments) => inject::run(&arguments),
        Verb::Design(arguments) => design::run(&arguments),
        Verb::Simulate(arguments) => simulate::run(&arguments),
        Verb::Campaign(arguments) => campaign::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("hovernav: {}", in_one_line(&error));
            ExitCode::FAILURE
        }
    }
}

fn info(log: &Path) -> anyhow::Result<()> {
    let (dataset, record) = log::open(log)?;
    print!("{}", Info(&dataset));
    if let Some(record) = record {
        print!("{}", RecordInfo(&record));
    }
    Ok(())
}

/// The error and its causes, less those that the message before already ends with.
fn in_one_line(error: &anyhow::Error) -> String {
    error.chain().skip(1).fold(error.to_string(), |told, cause| {
        let cause = cause.to_string();
        if told.ends_with(&cause) { told } else { format!("{told}: {cause}") }
    })
}
