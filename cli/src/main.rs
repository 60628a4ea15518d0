//! The command `hovernav`, with one subcommand per task. This crate reads arguments, shows progress and writes files.
//! The library does the computation.
//!
//! A subcommand ("verb" in the code) is a module with `Arguments` and `run`, and a line in [`Verb`] and [`Verb::run`].
//! A verb that needs a cargo feature also has a line in [`MISSING_FEATURES`]. Verbs do not use other verbs. Shared code
//! is in [`arguments`], [`emit`], [`memory`], [`output`] and [`summary`]; the crate `hovernav-pages` draws the pages.

mod arguments;
mod emit;
mod help;
mod memory;
mod output;
#[cfg(any(feature = "fly", feature = "ground"))]
mod stop;
mod summary;

#[cfg(feature = "bench")]
mod bench;
mod compare;
mod config;
mod convert;
mod estimate;
mod info;
#[cfg(feature = "formats")]
mod init;
#[cfg(feature = "manual")]
mod manual;
#[cfg(feature = "record")]
mod report;
mod score;

#[cfg(feature = "lab")]
mod ablate;
#[cfg(feature = "lab")]
mod campaign;
#[cfg(feature = "lab")]
mod design;
#[cfg(feature = "lab")]
mod identify;
#[cfg(feature = "lab")]
mod inject;
#[cfg(feature = "lab")]
mod simulate;

#[cfg(all(feature = "fly", target_os = "linux"))]
mod fly;
#[cfg(feature = "ground")]
mod ground;
#[cfg(feature = "fly")]
mod play;

use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue};
use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

/// Navigation for small helicopters and drones: computes position, velocity and attitude, with their uncertainties,
/// from a recorded log
#[derive(Parser)]
#[command(version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
    /// Print only the requested output and errors
    #[arg(long, short, global = true)]
    quiet: bool,
}

#[derive(Subcommand)]
enum Verb {
    /// Run the filter over a log; writes solution.csv, summary.json and report.html
    Estimate(estimate::Arguments),
    /// Identify a model of the helicopter from a flight and validate it; writes model.toml, summary.json and
    /// report.html
    #[cfg(feature = "lab")]
    Identify(Box<identify::Arguments>),
    /// Show the contents of a log: sensors, sample rates, time spans, gaps
    Info(info::Arguments),
    /// Show a recorded flight on a page: modes, set-points, sticks, health, timing; writes report.html and summary.json
    #[cfg(feature = "record")]
    Report(report::Arguments),
    /// Run the real-time flight loop on the flight computer and record the flight
    #[cfg(all(feature = "fly", target_os = "linux"))]
    Fly(fly::Arguments),
    /// Replay a log over pseudo-terminals, as the sensors sent it, as input for `hovernav fly`
    #[cfg(feature = "fly")]
    Play(play::Arguments),
    /// Run the ground station: a page with live plots, records and flight control of a vehicle connected by serial port
    /// or UDP
    #[cfg(feature = "ground")]
    Ground(ground::Arguments),
    /// Convert any log to a dataset directory
    Convert(convert::Arguments),
    /// List every file, column and key of the settings, with defaults and units; `help config` prints the same
    Config(config::Arguments),
    /// Map the columns of foreign text files to quantities, units and axes; writes a mapping and a commented
    /// dataset.toml that estimate, info and convert read
    #[cfg(feature = "formats")]
    Init(init::Arguments),
    /// Switch off each mechanism of the estimator alone, on many flights and faults; writes results.csv and table.md
    #[cfg(feature = "lab")]
    Ablate(ablate::Arguments),
    /// Copy a log and add faults to it: vibration, gaps, GPS glitches and many more
    #[cfg(feature = "lab")]
    Inject(inject::Arguments),
    /// Design the hover autopilot for a model and check it at the sample rate of the flight loop; writes
    /// autopilot.toml, summary.json and report.html
    #[cfg(feature = "lab")]
    Design(design::Arguments),
    /// Simulate a flight and record it as a dataset: the closed loop with sensors, estimator and servos, or a
    /// prescribed path with --flight
    #[cfg(feature = "lab")]
    Simulate(simulate::Arguments),
    /// Simulate many closed-loop flights, each with random airframe, wind, sensors and GPS; writes results.csv,
    /// percentiles.csv, summary.json and report.html
    #[cfg(feature = "lab")]
    Campaign(campaign::Arguments),
    /// Compare solutions (solution.csv, TUM or EuRoC) with each other; writes summary.json and report.html
    Compare(compare::Arguments),
    /// Time the filter and the flight loop on this machine and compare with the period of the loop
    #[cfg(feature = "bench")]
    Bench(bench::Arguments),
    /// Score a trajectory of any program (solution.csv, TUM or EuRoC) against a reference
    Score(score::Arguments),
    /// Print a shell script that completes the arguments of this command
    #[cfg(feature = "manual")]
    Completions(manual::Completions),
    /// Write a manual page for each subcommand
    #[cfg(feature = "manual")]
    Man(manual::Man),
}

impl Verb {
    fn run(&self) -> anyhow::Result<()> {
        match self {
            Self::Estimate(arguments) => estimate::run(arguments),
            #[cfg(feature = "lab")]
            Self::Identify(arguments) => identify::run(arguments),
            Self::Info(arguments) => info::run(arguments),
            #[cfg(feature = "record")]
            Self::Report(arguments) => report::run(arguments),
            #[cfg(all(feature = "fly", target_os = "linux"))]
            Self::Fly(arguments) => fly::run(arguments),
            #[cfg(feature = "fly")]
            Self::Play(arguments) => play::run(arguments),
            #[cfg(feature = "ground")]
            Self::Ground(arguments) => ground::run(arguments),
            Self::Convert(arguments) => convert::run(arguments),
            Self::Config(arguments) => config::run(arguments),
            #[cfg(feature = "formats")]
            Self::Init(arguments) => init::run(arguments),
            #[cfg(feature = "lab")]
            Self::Ablate(arguments) => ablate::run(arguments),
            #[cfg(feature = "lab")]
            Self::Inject(arguments) => inject::run(arguments),
            #[cfg(feature = "lab")]
            Self::Design(arguments) => design::run(arguments),
            #[cfg(feature = "lab")]
            Self::Simulate(arguments) => simulate::run(arguments),
            #[cfg(feature = "lab")]
            Self::Campaign(arguments) => campaign::run(arguments),
            Self::Compare(arguments) => compare::run(arguments),
            #[cfg(feature = "bench")]
            Self::Bench(arguments) => bench::run(arguments),
            Self::Score(arguments) => score::run(arguments),
            #[cfg(feature = "manual")]
            Self::Completions(arguments) => {
                manual::completions(arguments, <Arguments as clap::CommandFactory>::command())
            }
            #[cfg(feature = "manual")]
            Self::Man(arguments) => manual::man(arguments, Arguments::command()),
        }
    }
}

/// The subcommands that this build lacks, and the feature that adds each.
const MISSING_FEATURES: &[(&str, &str)] = &[
    #[cfg(not(all(feature = "fly", target_os = "linux")))]
    ("fly", "feature `fly` on Linux"),
    #[cfg(not(feature = "fly"))]
    ("play", "feature `fly`"),
    #[cfg(not(feature = "bench"))]
    ("bench", "feature `bench`"),
    #[cfg(not(feature = "formats"))]
    ("init", "feature `formats`"),
    #[cfg(not(feature = "ground"))]
    ("ground", "feature `ground`"),
    #[cfg(not(feature = "manual"))]
    ("completions", "feature `manual`"),
    #[cfg(not(feature = "manual"))]
    ("man", "feature `manual`"),
    #[cfg(not(feature = "record"))]
    ("report", "feature `record`"),
    #[cfg(not(feature = "lab"))]
    ("ablate", "feature `lab`"),
    #[cfg(not(feature = "lab"))]
    ("campaign", "feature `lab`"),
    #[cfg(not(feature = "lab"))]
    ("design", "feature `lab`"),
    #[cfg(not(feature = "lab"))]
    ("identify", "feature `lab`"),
    #[cfg(not(feature = "lab"))]
    ("inject", "feature `lab`"),
    #[cfg(not(feature = "lab"))]
    ("simulate", "feature `lab`"),
];

fn main() -> ExitCode {
    let arguments = match parsed() {
        Ok(arguments) => arguments,
        Err(error) => {
            let Some((verb, feature)) = missing_feature(&error) else { error.exit() };
            output::complain(format_args!(
                "hovernav: `{verb}` is not in this build, which lacks the {feature}"
            ));
            return ExitCode::FAILURE;
        }
    };
    if arguments.quiet {
        output::be_quiet();
    }
    let failure = match arguments.verb.run() {
        Ok(()) => {
            output::unwritten().map(|error| format!("cannot write to standard output: {error}"))
        }
        Err(error) => Some(in_one_line(&error)),
    };
    if let Some(failure) = failure {
        output::complain(format_args!("hovernav: {failure}"));
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// Parses the arguments. A negative number is accepted as a value; the range of the argument then checks it.
fn parsed() -> Result<Arguments, clap::Error> {
    let command = help::explained(Arguments::command()).mut_subcommands(|verb| {
        verb.mut_args(|argument| {
            let is_value = argument.get_action().takes_values() && !argument.is_positional();
            if is_value && !argument.is_allow_hyphen_values_set() {
                argument.allow_negative_numbers(true)
            } else {
                argument
            }
        })
    });
    Arguments::from_arg_matches(&command.try_get_matches()?)
}

/// The entry of [`MISSING_FEATURES`] that the user requested, if that is the cause of the error.
fn missing_feature(error: &clap::Error) -> Option<&'static (&'static str, &'static str)> {
    match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(asked)) => {
            MISSING_FEATURES.iter().find(|(verb, _)| verb == asked)
        }
        _ => None,
    }
}

/// The error and its causes on one line; a cause that repeats the end of the preceding message is omitted.
fn in_one_line(error: &anyhow::Error) -> String {
    error.chain().skip(1).fold(error.to_string(), |message, cause| {
        let cause = cause.to_string();
        if message.ends_with(&cause) { message } else { format!("{message}: {cause}") }
    })
}
