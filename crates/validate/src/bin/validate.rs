//! Every set through the estimator, compared with the committed table.

use std::fs;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context as _, ensure};
use clap::Parser;
use hovernav_validate::{Row, find, markdown, moved, read_csv, run, write_csv};

const CHECKOUT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Flies every set and prints the numbers that moved by more than 2 % against docs/validation/sets.csv
#[derive(Parser)]
struct Arguments {
    /// Fly this set alone; may be repeated
    #[arg(long, value_name = "NAME")]
    set: Vec<String>,
    /// Threads; one for each core unless given
    #[arg(long, value_name = "N", default_value_t = 0)]
    jobs: usize,
    /// Settings that override those of every set, in the form of dataset.toml; may be repeated
    #[arg(long, value_name = "FILE")]
    config: Vec<PathBuf>,
    /// One such setting, such as filter.gps.position_sigma_m=2; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    settings: Vec<String>,
    /// Directory with datasets, cases and logs
    #[arg(long, value_name = "DIR", default_value = hovernav_testing::SHARED)]
    shared: PathBuf,
    /// Exit with status 1 if anything moved
    #[arg(long)]
    check: bool,
    /// Renew the committed table
    #[arg(long, conflicts_with_all = ["set", "config", "settings"])]
    write: bool,
}

fn main() -> anyhow::Result<ExitCode> {
    let arguments = Arguments::parse();
    rayon::ThreadPoolBuilder::new().num_threads(arguments.jobs).build_global()?;
    let mut sets = find(CHECKOUT.as_ref(), &arguments.shared)?;
    for name in &arguments.set {
        ensure!(sets.iter().any(|set| set.name == *name), "found no set {name}");
    }
    let is_asked = |name: &String| arguments.set.is_empty() || arguments.set.contains(name);
    sets.retain(|set| is_asked(&set.name));

    let mut configs = arguments.config.clone();
    let mut given = tempfile::Builder::new().prefix("settings").suffix(".toml").tempfile()?;
    if !arguments.settings.is_empty() {
        writeln!(given, "{}", arguments.settings.join("\n"))?;
        configs.push(given.path().to_path_buf());
    }

    let new = run(&sets, &configs);
    let home = PathBuf::from(CHECKOUT).join("docs/validation");
    let (table, page) = (home.join("sets.csv"), home.join("sets.md"));
    let mut old: Vec<Row> = match fs::read_to_string(&table) {
        Ok(text) => read_csv(&text).with_context(|| table.display().to_string())?,
        Err(_) => Vec::new(),
    };
    old.retain(|row| is_asked(&row.set));
    let moved = moved(&old, &new);
    moved.iter().for_each(|line| println!("{line}"));
    println!("{} sets, {} rows, {} changes", sets.len(), new.len(), moved.len());
    if arguments.write {
        fs::create_dir_all(&home)?;
        let text = write_csv(&new);
        fs::write(&page, markdown(&read_csv(&text)?))?;
        fs::write(&table, text)?;
    }
    let fails = arguments.check && !moved.is_empty();
    Ok(if fails { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}
