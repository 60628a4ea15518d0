//! `hovernav identify`: identifies a model of the helicopter from a recorded flight.

mod export;
mod page;
mod summary;
mod words;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context as _, ensure};
use hovernav_findings::{Finding, sentences};
use hovernav_formats::{Log, Options};
use hovernav_model::Grade;
use hovernav_replay::{SmoothedRun, smooth};
use hovernav_sysid::helicopter::{
    FlightRecord, FrequencyDomain, ModelStructure, ModelStructureError, Request, Velocity,
    flight_warnings, identify, solutions_for,
};

use self::export::ExportFormat;
use self::page::IdentificationPage;
use self::summary::Summary;
use crate::arguments::finite;
use crate::memory;
use crate::output;

#[derive(clap::Args)]
pub struct Arguments {
    /// A dataset directory with controls.csv, or a flight record
    #[arg(required_unless_present = "list")]
    log: Option<PathBuf>,
    /// Structure of the model: a name from --list, or a file [default: hybrid, multirotor for a flight without flapping,
    /// rates without GPS]
    #[arg(long, visible_alias = "structure", value_name = "NAME|FILE", value_parser = name_or_file)]
    model: Option<String>,
    /// Identify from flight near this forward speed over the ground instead of hover, m/s, for a model of forward flight
    #[arg(long, value_name = "MPS", value_parser = speed, allow_hyphen_values = true)]
    speed: Option<f64>,
    /// List the built-in structures, or print the file of one, as a start for your own
    #[arg(long, value_name = "NAME", num_args = 0..=1)]
    list: Option<Option<String>>,
    /// Signal to read as the vehicle's input, as in RATE, RCIN or vehicle_torque_setpoint [default: the nearest to the
    /// actuators that moves]
    #[arg(long, value_name = "NAME")]
    input: Option<String>,
    /// Identify a second model, from GPS velocity held between fixes, and compare both. Takes about as long again
    #[arg(long)]
    held_gps: bool,
    /// Directory to write [default: out/NAME-identify]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Settings file that overrides the log's dataset.toml, in the same format
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Also write a file for other programs; may be repeated
    #[arg(long, value_name = "FORMAT", value_delimiter = ',')]
    export: Vec<ExportFormat>,
    /// Do not write report.html
    #[arg(long)]
    no_report: bool,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if let Some(name) = &arguments.list {
        return list(name.as_deref());
    }
    let started = Instant::now();
    let log = arguments.log.as_deref().context("expected a log")?;
    let mut options = Options::default();
    options.input.clone_from(&arguments.input);
    let structure = arguments.model.as_deref().map(str::parse::<ModelStructure>).transpose()?;
    let Log { mut dataset, .. } = memory::open(log, &options, 2)?;
    let part = |name| if log.is_dir() { log.join(name) } else { log.to_path_buf() };
    if let Some(config) = &arguments.config {
        dataset.configure(config)?;
    }
    ensure!(
        !dataset.controls.is_empty(),
        "{}: found no sticks, expected one row of stick positions per sample. Identification \
         needs the pilot's inputs",
        part("controls.csv").display()
    );
    ensure!(dataset.sample_count() > 0, "{}: found no inertial samples", log.display());
    let config = dataset.settings()?;
    let working = output::Working::on("estimating");
    let SmoothedRun { forward, solutions, inconsistent } = smooth(&dataset, &config, |_| ());
    drop(working);
    ensure!(
        !arguments.held_gps || !solutions.is_empty(),
        "{}: --held-gps needs GPS and a solution",
        log.display()
    );
    let solutions = solutions_for(&dataset, structure.as_ref(), solutions);
    ensure!(
        !solutions.is_empty(),
        "{}: no solution to identify from: alignment found no fix after {} s of inertial samples, \
         or found no heading. --model rates needs no solution",
        log.display(),
        config.alignment.duration_s
    );

    // The failure of the comparison is a result, too.
    let wanted = Request { structure, speed_mps: arguments.speed };
    let with = |velocity| identify(&dataset, &solutions, wanted.clone(), velocity);
    let held = || arguments.held_gps.then(|| with(Velocity::HeldGps));
    let working = output::Working::on("identifying");
    let (found, held) = rayon::join(|| with(Velocity::Estimated), held);
    let held = held.as_ref().map(Result::as_ref);
    let found = found.with_context(|| log.display().to_string())?;
    let flight = FlightRecord::new(&dataset, &solutions, Velocity::Estimated)?;
    let frequency = FrequencyDomain::of(&found, &flight);
    drop(working);
    let vehicle = found.vehicle()?;
    let verdict = found.verdict(frequency.as_ref().ok());
    let vehicle =
        vehicle.with_source(&found.source(&dataset.manifest.name)).with_verdict(verdict.clone());

    let mut summary = Summary::new(log, &dataset, &forward, &found, held, verdict.clone());
    let inconsistent: Vec<Finding> = inconsistent.iter().map(Finding::from).collect();
    summary.warn(sentences(&inconsistent));
    summary.ask_frequency(frequency.as_ref());
    summary.warn(flight_warnings(&flight, &found.identified.structure));
    let pattern = vehicle.step_taken_for_rate(found.identified.period_s);
    summary.warn(pattern.iter().map(ToString::to_string));

    let out = arguments.out.clone().unwrap_or_else(|| default_out(log));
    output::create(&out)?;
    vehicle.write(&out.join("model.toml"))?;
    export::write(&arguments.export, &vehicle, frequency.as_ref().ok(), &out)?;
    if !arguments.no_report {
        let (facts, headlines) = (summary.facts(), words::headlines(&found));
        let page = IdentificationPage {
            title: &format!("{}: {} model", dataset.manifest.name, found.identified.structure.name),
            facts: &facts,
            headlines: &headlines,
            warnings: summary.warnings(),
            verdict: words::verdict(&summary),
            dataset: &dataset,
            found: &found,
            held,
            frequency: frequency.as_ref(),
        };
        page.build()?.write(&out.join(output::REPORT))?;
    } else {
        output::remove_stale(&out, [output::REPORT]);
    }
    summary.set_wall(started.elapsed().as_secs_f64());
    output::write_json(&summary, &out.join("summary.json"))?;
    let (held, frequency) = (held.and_then(Result::ok), frequency.as_ref());
    output::say_text(words::in_words(&summary, &found, held, frequency, &out));
    let others = match verdict.reasons.len().saturating_sub(1) {
        0 => String::new(),
        count => format!(" ({count} more in {})", out.join("summary.json").display()),
    };
    ensure!(
        verdict.grade != Grade::DoNotFly,
        "{}: do not fly an autopilot based on this model: {}{others}",
        out.join("model.toml").display(),
        verdict.reasons.first().map_or("", String::as_str)
    );
    Ok(())
}

/// A name or an existing file. Errors in the file are not errors of usage.
fn name_or_file(text: &str) -> Result<String, String> {
    match text.parse::<ModelStructure>() {
        Err(error @ ModelStructureError::Unknown { .. }) => Err(error.to_string()),
        _ => Ok(text.to_owned()),
    }
}

fn speed(text: &str) -> Result<f64, String> {
    let speed = finite(text).filter(|mps| (-20.0..=100.0).contains(mps));
    speed.ok_or_else(|| format!("found \"{text}\", expected a speed of -20 to 100 m/s"))
}

/// Prints the built-in structures, or the file of the structure `name`.
fn list(name: Option<&str>) -> anyhow::Result<()> {
    let text = match name {
        Some(name) => ModelStructure::text(name)
            .with_context(|| {
                format!("found `{name}`, expected a name from `hovernav identify --list`")
            })?
            .to_owned(),
        None => ModelStructure::all()
            .map(|structure| format!("{:<12} {}\n", structure.name(), structure.summary))
            .collect(),
    };
    output::say_text(text);
    Ok(())
}

/// The default directory. It differs from the directory of `hovernav estimate` for the same log, because the names of
/// the files are the same.
fn default_out(log: &Path) -> PathBuf {
    Path::new("out").join(output::name_of(log) + "-identify")
}
