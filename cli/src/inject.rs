//! `hovernav inject`: faulty copies of a dataset.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::Context as _;
use clap::error::ErrorKind;
use hovernav_sim::faults::{self, Fault, Log};

#[derive(clap::Args)]
#[command(after_help = "`--fault list` prints every fault with its range, default and duration.")]
pub struct Arguments {
    /// A dataset directory or a flight record
    log: Option<PathBuf>,
    /// A fault, NAME[=VALUE][@START[:DURATION]]: times in seconds of the log's clock, drawn by the
    /// seed where not given; may be repeated; `list` prints them all
    #[arg(long, value_name = "FAULT", required = true)]
    fault: Vec<Asked>,
    /// What draws times, directions and noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The directory to write
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// A fault, or the list of them all.
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
                print!("{}", faults::list());
                return Ok(());
            }
        }
    }
    let (Some(log), Some(out)) = (&arguments.log, &arguments.out) else {
        let missing = if arguments.log.is_none() { "a LOG" } else { "--out DIR" };
        let message = format!("expected {missing}; see `hovernav inject --help`\n");
        clap::Error::raw(ErrorKind::MissingRequiredArgument, message).exit()
    };
    copy(log, &asked, arguments.seed, out)
}

fn copy(log: &Path, asked: &[Fault], seed: u64, out: &Path) -> anyhow::Result<()> {
    // A flight record is written as a dataset first, which the faults then change.
    let scratch = tempfile::tempdir().context("cannot make a directory to convert in")?;
    let dir = if log.is_dir() { log } else { scratch.path() };
    if !log.is_dir() {
        hovernav_log::open(log)?.0.write(dir, &[])?;
    }
    let faulty = Log::open(dir)?.with_faults(asked, seed)?;
    faulty.write(out)?;
    for made in &faulty.made {
        println!("{made}");
    }
    println!("{}: written", out.display());
    Ok(())
}
