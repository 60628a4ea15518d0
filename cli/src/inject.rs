//! `hovernav inject`: copies of a dataset with faults, and the estimator's errors under many such faults.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Instant;

use anyhow::Context as _;
use clap::error::ErrorKind;
use hovernav_formats::Options;
use hovernav_sim::faults::{
    self, Campaign, Fault, Flight, Log, Outcome, csv, goals_markdown, markdown, standard_cells,
    svg, verdicts,
};

use crate::memory;

#[derive(clap::Args)]
#[command(after_help = "`--fault list` prints every fault with its range, default and duration.")]
pub struct Arguments {
    /// A dataset directory or a flight record; with --campaign, any number of dataset directories
    log: Vec<PathBuf>,
    /// A fault, NAME[=VALUE][@[START][:DURATION]], with times in seconds of the log's clock; omitted times are drawn
    /// from the seed; may be repeated; `list` prints all faults
    #[arg(long, value_name = "FAULT", required_unless_present = "campaign")]
    fault: Vec<Asked>,
    /// Seed of the random times, directions and noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The directory to write
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Run the estimator on many faulty copies, one fault at a time: all faults, or those of --fault; writes table.md,
    /// runs.svg, results.csv and summary.json to out/injection or --out
    #[arg(long)]
    campaign: bool,
    /// With --campaign: number of seeds for faults with random parts
    #[arg(long, value_name = "N", default_value_t = 5, requires = "campaign",
          value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// With --campaign: include simulated flights, one per seed; without a LOG, only simulated flights run
    #[arg(long, requires = "campaign")]
    simulated: bool,
}

/// A fault, or the request to list all faults.
#[derive(Clone, Copy)]
enum Asked {
    Fault(Fault),
    List,
}

impl FromStr for Asked {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "list" { Ok(Self::List) } else { text.parse().map(Self::Fault) }
    }
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let mut asked = Vec::new();
    for fault in &arguments.fault {
        match fault {
            Asked::Fault(fault) => asked.push(*fault),
            Asked::List => {
                crate::output::print(faults::list());
                return Ok(());
            }
        }
    }
    if arguments.campaign {
        return campaign(arguments, &asked);
    }
    match (&arguments.log[..], &arguments.out) {
        ([log], Some(out)) => copy(log, &asked, arguments.seed, out),
        ([_], None) => usage("expected --out DIR"),
        ([], _) => usage("expected a LOG"),
        _ => usage("found several LOGs, expected one"),
    }
}

fn usage(message: &str) -> ! {
    let message = format!("{message}; see `hovernav inject --help`\n");
    clap::Error::raw(ErrorKind::MissingRequiredArgument, message).exit()
}

fn copy(log: &Path, asked: &[Fault], seed: u64, out: &Path) -> anyhow::Result<()> {
    // A flight record is first converted to a dataset; the faults then change that dataset.
    let scratch =
        tempfile::tempdir().context("cannot create a temporary directory for the conversion")?;
    let dir = if log.is_dir() { log } else { scratch.path() };
    if !log.is_dir() {
        memory::open(log, &Options::default(), 1)?.dataset.write(dir, &[])?;
    }
    let faulty = Log::open(dir)?.with_faults(asked, seed)?;
    faulty.write(out)?;
    for made in &faulty.made {
        crate::output::say(format_args!("{made}"));
    }
    crate::output::say(format_args!("{}: written", out.display()));
    Ok(())
}

fn campaign(arguments: &Arguments, asked: &[Fault]) -> anyhow::Result<()> {
    let started = Instant::now();
    let out = arguments.out.clone().unwrap_or_else(|| "out/injection".into());
    crate::output::create(&out)?;
    let mut flights: Vec<Flight> = arguments.log.iter().cloned().map(Flight::Dataset).collect();
    if arguments.simulated || flights.is_empty() {
        flights.push(Flight::Simulated);
    }
    let cells = match asked {
        [] => standard_cells(),
        asked => asked.iter().map(|fault| vec![*fault]).collect(),
    };
    let campaign = Campaign { flights, cells, seeds: arguments.seeds };
    let bar = crate::output::bar(campaign.runs() as usize);
    let outcomes = campaign.run(|| bar.inc(1))?;
    bar.finish_and_clear();

    let goals = goals_markdown(&outcomes);
    let write = |file: &str, text: String| crate::output::write(&out.join(file), text);
    write("table.md", format!("{goals}{}", markdown(&outcomes)))?;
    write("results.csv", csv(&outcomes))?;
    write("runs.svg", svg(&outcomes))?;
    let wall_s = started.elapsed().as_secs_f64();
    let summary = summary(arguments, &outcomes, wall_s);
    crate::output::write_json(&summary, &out.join("summary.json"))?;
    crate::output::say_text(&goals);
    crate::output::say(format_args!("{}: {} runs in {wall_s:.1} s", out.display(), outcomes.len()));
    Ok(())
}

fn summary(arguments: &Arguments, outcomes: &[Outcome], wall_s: f64) -> serde_json::Value {
    let input: Vec<String> = arguments.log.iter().map(|log| log.display().to_string()).collect();
    serde_json::json!({
        "tool": "hovernav",
        "version": env!("CARGO_PKG_VERSION"),
        "input": input.join(" "),
        "duration_s": 0.0,
        "wall_s": wall_s,
        "imu_samples": outcomes.iter().map(|outcome| outcome.measures.samples).sum::<usize>(),
        "gps_fixes_used": 0,
        "gps_fixes_rejected": 0,
        "goals": verdicts(outcomes),
        "runs": outcomes,
    })
}
