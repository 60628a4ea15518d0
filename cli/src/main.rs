//! The command `hovernav`: one verb a job. It reads arguments, shows progress and writes files; what
//! is computed, the library computes.

mod estimate;
#[cfg(target_os = "linux")]
mod fly;
mod play;
mod report;
mod simulate;
mod summary;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use hovernav::log::{Dataset, Info};

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
    /// Say what is in a log: sensors, rates, spans, gaps
    Info {
        /// A dataset directory
        log: PathBuf,
    },
    /// Fly: the real-time loop on the flight computer, recorded
    #[cfg(target_os = "linux")]
    Fly(fly::Arguments),
    /// Play a log as the sensors sent it, over pseudo-terminals, for `hovernav fly` to fly on
    Play(play::Arguments),
    /// Fly a path in simulation and record its sensors as a dataset
    Simulate(simulate::Arguments),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().verb {
        Verb::Estimate(arguments) => estimate::run(&arguments),
        Verb::Info { log } => Dataset::open(&log)
            .map(|dataset| print!("{}", Info(&dataset)))
            .map_err(anyhow::Error::from),
        #[cfg(target_os = "linux")]
        Verb::Fly(arguments) => fly::run(&arguments),
        Verb::Play(arguments) => play::run(&arguments),
        Verb::Simulate(arguments) => simulate::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("hovernav: {}", in_one_line(&error));
            ExitCode::FAILURE
        }
    }
}

/// The error and its causes, less those that the message before already ends with.
fn in_one_line(error: &anyhow::Error) -> String {
    error.chain().skip(1).fold(error.to_string(), |told, cause| {
        let cause = cause.to_string();
        if told.ends_with(&cause) { told } else { format!("{told}: {cause}") }
    })
}
