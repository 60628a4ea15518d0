//! `hovernav ablate`: the effect of each mechanism of the estimator, switched off alone.

use std::collections::BTreeSet;
use std::fs;
use std::io::{ErrorKind, Write as _};
use std::path::PathBuf;
use std::sync::Mutex;

use anyhow::{Context as _, bail};
use hovernav_sim::faults::{
    Ablation, Cut, Fault, Flight, ablation_csv, ablation_markdown, read_ablation, standard_cells,
};
use hovernav_toml::read_bytes;

/// Name of the results in the output directory.
const RESULTS: &str = "results.csv";
/// Largest file of results that is read, bytes.
const LARGEST: u64 = 1 << 28;

#[derive(clap::Args)]
#[command(
    after_help = "An interrupted ablation continues where it ended, in the same directory. `--cut list` prints \
                        the cuts."
)]
pub struct Arguments {
    /// Dataset directories
    log: Vec<PathBuf>,
    /// Include simulated flights, one per seed; without a LOG, only simulated flights run
    #[arg(long)]
    simulated: bool,
    /// A fault, as in `hovernav inject`; may be repeated. Without any, the faults of its campaign; `none` for no fault
    #[arg(long, value_name = "FAULT")]
    fault: Vec<String>,
    /// Number of seeds for faults with random parts, and for simulated flights
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// A mechanism or setting to switch off; may be repeated; all without any
    #[arg(long, value_name = "NAME")]
    cut: Vec<String>,
    /// Directory of results.csv and table.md
    #[arg(long, value_name = "DIR", default_value = "out/ablation")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let mut cuts = Cut::all();
    if arguments.cut.iter().any(|name| name == "list") {
        for cut in cuts {
            crate::output::print(format_args!("{}\n", cut.name));
        }
        return Ok(());
    }
    for name in &arguments.cut {
        if !cuts.iter().any(|cut| cut.name == *name) {
            bail!("found no mechanism `{name}`; `--cut list` prints all");
        }
    }
    cuts.retain(|cut| arguments.cut.is_empty() || arguments.cut.iter().any(|it| it == cut.name));
    let mut cells = Vec::new();
    for fault in arguments.fault.iter().filter(|fault| *fault != "none") {
        let cell: Result<Vec<Fault>, String> = fault.split_whitespace().map(str::parse).collect();
        cells.push(cell.map_err(anyhow::Error::msg)?);
    }
    if arguments.fault.is_empty() {
        cells = standard_cells();
    }
    let mut flights: Vec<Flight> = arguments.log.iter().cloned().map(Flight::Dataset).collect();
    if arguments.simulated || flights.is_empty() {
        flights.push(Flight::Simulated);
    }

    crate::output::create(&arguments.out)?;
    let path = arguments.out.join(RESULTS);
    let shown = path.display().to_string();
    let mut rows = match read_bytes(&path, LARGEST) {
        Ok(bytes) => read_ablation(&String::from_utf8_lossy(&bytes)),
        Err(error) if error.kind() == ErrorKind::NotFound => Vec::new(),
        Err(error) => return Err(error).with_context(|| shown),
    };
    // The last run of an interrupted ablation may be incomplete, or lack cuts that are requested now.
    let is_complete = |run: &str| {
        let known: BTreeSet<&str> =
            rows.iter().filter(|row| row.run == run).map(|row| &*row.cut).collect();
        cuts.iter().chain(&[Cut::NONE]).all(|cut| known.contains(cut.name))
    };
    let runs: BTreeSet<String> = rows.iter().map(|row| row.run.clone()).collect();
    let complete: BTreeSet<String> = runs.into_iter().filter(|run| is_complete(run)).collect();
    rows.retain(|row| complete.contains(&row.run));
    crate::output::write(&path, ablation_csv(&rows))?;
    let file = fs::OpenOptions::new().append(true).open(&path).with_context(|| shown.clone())?;
    let results = Mutex::new((file, rows, Ok(())));
    let ablation = Ablation { flights, cells, seeds: arguments.seeds, cuts };
    ablation.run(&|run| complete.contains(run), &|new| {
        let Ok(mut results) = results.lock() else { return };
        let (file, rows, outcome) = &mut *results;
        let written = file.write_all(ablation_csv(&new).as_bytes());
        rows.extend(new);
        if outcome.is_ok() {
            *outcome = written;
        }
    })?;
    let (_, mut rows, outcome) =
        results.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    outcome.with_context(|| shown.clone())?;
    rows.sort_by(|a, b| (&a.run, &a.cut).cmp(&(&b.run, &b.cut)));
    let results = ablation_csv(&rows);
    // From the digits in the file, so that an ablation in parts gives the same table.
    let table = ablation_markdown(&read_ablation(&results));
    crate::output::write(&path, results)?;
    crate::output::write(&arguments.out.join("table.md"), table.clone())?;
    crate::output::say_text(&table);
    Ok(())
}
