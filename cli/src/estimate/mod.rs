//! `hovernav estimate`: runs the filter over a log, scores the solution and draws the page.

mod columns;
#[cfg_attr(not(feature = "export"), path = "no_export.rs")]
mod export;
mod files;
mod table;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::ensure;
use hovernav::ekf::{EstimatorConfig, Solution};
use hovernav::ins::HeadingSource;
use hovernav::time::Time;
use hovernav_formats::{Format, Log};
use hovernav_log::{
    Dataset, Finding, Keep, Outage, Reference, Run, SetupFinding, outage_drift, score, thin,
};

use self::columns::ColumnsArgument;
use self::export::ExportArgument;
use self::files::Files;
use crate::arguments::{OutageWindow, Sensors};
use crate::emit::{self, Form};
use crate::flight_page::{self, FlightData};
use crate::memory;
use crate::output::{self, Working};
use crate::summary::{OutageDrift, RunSummary};

#[derive(clap::Args)]
pub struct Arguments {
    /// Dataset directories, flight records or logs of any other format; with several logs, a table lists all of them
    #[arg(required = true)]
    log: Vec<PathBuf>,
    #[command(flatten)]
    sensors: Sensors,
    /// Directory to write [default: out/NAME]; with several logs, the parent of their directories
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Settings file that overrides the log's dataset.toml, in the same format
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Smooth the solution: run backwards over the whole log too, so that each solution also uses later measurements
    #[arg(long)]
    smooth: bool,
    /// Ignore the GPS from START on for DURATION, in seconds of the log's clock; may be repeated
    #[arg(long, value_name = "START:DURATION", allow_hyphen_values = true)]
    outage: Vec<OutageWindow>,
    /// Reduce the GPS to at most this rate
    #[arg(long, value_name = "HZ", value_parser = positive)]
    gps_rate: Option<f64>,
    /// Also write the solution in this format: parquet, kml, gpx, pos, tum, euroc, mcap; may be repeated. With `-` in
    /// addition, the one FORMAT goes to standard output
    #[arg(long, value_name = "FORMAT", value_delimiter = ',')]
    export: Vec<ExportArgument>,
    /// Add columns at the end of solution.csv: quaternion, local, covariance
    #[arg(long, value_name = "COLUMNS", value_delimiter = ',')]
    columns: Vec<ColumnsArgument>,
    /// Largest output rate of solution.csv and the exports [default: every inertial sample; KML and GPX at most 5 Hz]
    #[arg(long, value_name = "HZ", value_parser = positive)]
    rate: Option<f64>,
    /// Also write the estimator's configuration in this form, for programs that read no files; may be repeated
    #[arg(long, value_name = "FORM", value_delimiter = ',')]
    emit: Vec<Form>,
    /// Do not write report.html
    #[arg(long)]
    no_report: bool,
}

impl Arguments {
    /// Whether an argument makes the solution differ from the one computed in flight.
    #[cfg(feature = "record")]
    fn changes_the_filter(&self) -> bool {
        self.config.is_some() || !self.outage.is_empty() || self.gps_rate.is_some()
    }
}

fn positive(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|&value: &f64| value.is_finite() && value > 0.0)
        .ok_or_else(|| format!("found \"{text}\", expected a number of hertz above 0"))
}

/// The files that `--export` writes next to `solution.csv`.
const EXPORTED: [&str; 8] = [
    "solution.parquet",
    "solution.kml",
    "solution.gpx",
    "solution.pos",
    "solution.tum",
    "solution.euroc.csv",
    "solution.mcap",
    "solution.foxglove-layout.json",
];

/// Largest number of inertial samples in memory: 36 MB, two hours at 33 Hz. In a longer log, samples and sticks stay in
/// their file and are read again for each pass.
const SAMPLES_IN_MEMORY: usize = 1 << 18;

/// Samples between two updates of the progress bar.
const SAMPLES_A_STEP: usize = 4096;

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    export::check(&arguments.export, arguments.log.len())?;
    if let [log] = &arguments.log[..] {
        let out = arguments.out.clone();
        let out = out.unwrap_or_else(|| Path::new("out").join(output::name_of(log)));
        let summary = estimate(arguments, log, &out)?;
        // With `--export -`, standard output contains only the solution.
        if !export::is_piped(&arguments.export) {
            output::say_text(summary.in_words(&out));
        }
        return Ok(());
    }
    table::run(arguments)
}

/// Runs the filter over `log` and writes the results to `out`.
fn estimate(arguments: &Arguments, log: &Path, out: &Path) -> anyhow::Result<RunSummary> {
    let started = Instant::now();
    let mut options = arguments.sensors.options();
    options.samples_in_memory = Some(SAMPLES_IN_MEMORY);
    let reading = Working::on("reading");
    let Log {
        format,
        mut dataset,
        #[cfg(feature = "record")]
        record,
        onboard,
        ..
    } = memory::open(log, &options, 1)?;
    drop(reading);
    if let Some(config) = &arguments.config {
        dataset.configure(config)?;
    }
    // A dataset directory without fixes lacks gps.csv; an error then names that file.
    let source = match format {
        Format::Dataset if dataset.fixes.is_empty() => log.join("gps.csv"),
        _ => log.to_path_buf(),
    };
    let denied_aids = dataset.check_fitness(&source)?;
    // A record is replayed with the sensors of the flight, so none of them is left out.
    let leaves_out = format != Format::Record;
    let mut left_out = if leaves_out { dataset.leave_out(denied_aids) } else { Vec::new() };
    let config = dataset.settings()?;
    let outages: Vec<Outage> = arguments.outage.iter().map(|window| window.outage()).collect();
    dataset.withhold(&outages, arguments.gps_rate);

    // The solutions of a record are in memory, and each of them is compared.
    let keep = if format == Format::Record { Keep::All } else { Keep::Thinned };
    let mut flown = fly(arguments, log, out, &dataset, &config, keep)?;
    // Output that went to a pipe cannot be replaced, so the filter runs only once then.
    if leaves_out && !export::is_piped(&arguments.export) {
        let without = dataset.leave_out_denied(&config, &flown.run);
        if !without.is_empty() {
            flown = fly(arguments, log, out, &dataset, &config, keep)?;
            left_out.extend(without);
        }
    }
    let Flown { run, smoothed, denied } = flown;
    ensure!(
        !run.solutions.is_empty(),
        "{}: no solution: alignment found no fix with {} s of inertial samples before it{}",
        log.display(),
        config.alignment.duration_s,
        match config.alignment.heading {
            Some(HeadingSource::Course) => {
                format!(", at {} m/s or faster for its course", config.alignment.course_speed_mps)
            }
            _ => String::new(),
        }
    );

    let judging = Working::on("scoring");
    let mut moments: Vec<Time> =
        run.solutions.iter().chain(&smoothed).map(|solution| solution.time).collect();
    moments.sort_unstable();
    let reference = match format {
        // A directory with a mapping may contain a reference, too.
        Format::Dataset | Format::Text if log.is_dir() => {
            Reference::open_at(log, &dataset.manifest, &moments)?
        }
        _ => None,
    };
    let first_imu = dataset.sample_span().map_or(Time::ZERO, |(first, _)| first);
    let solutions = if smoothed.is_empty() { &run.solutions } else { &smoothed };
    let scored = reference.as_ref().map(|reference| score(solutions, reference, first_imu));
    let drifts = drifts(solutions, &outages, dataset.sample_span(), reference.as_ref());

    let remark = format!("From {} by hovernav {}.", log.display(), env!("CARGO_PKG_VERSION"));
    emit::estimator(&config, dataset.manifest.imu.notch, &remark, &arguments.emit, out)?;
    let mut summary = RunSummary::new(log, &dataset, &run, !smoothed.is_empty());
    dataset.ensure_read()?;
    if arguments.smooth && smoothed.is_empty() {
        let warning = "not smoothed, because the heading was not found: the solution uses past measurements only";
        summary.warnings.push(warning.into());
    }
    summary.add_findings(denied);
    if let Some((first, last)) = dataset.sample_span() {
        let of_log = |left_out: &SetupFinding| left_out.finding(first.seconds(), last.seconds());
        summary.add_findings(left_out.iter().map(of_log).collect());
    }
    summary.warnings.extend(reference.iter().flat_map(|reference| reference.warnings.clone()));
    #[cfg(feature = "record")]
    {
        summary.reproduction = record
            .filter(|record| !record.solutions.is_empty() && !arguments.changes_the_filter())
            .map(|record| record.reproduced_by(&run.solutions).into());
    }
    summary.set_scores(scored.as_ref(), drifts);
    summary.onboard = onboard.as_ref().and_then(|onboard| onboard.difference(solutions));
    let innovations = flight_page::innovations(&run);
    if let Some(onboard) = &onboard {
        summary.onboard_innovations = onboard.innovation_sizes(&innovations);
    }
    if !arguments.no_report {
        let page = FlightData {
            title: &dataset.manifest.name,
            headlines: &summary.headlines(),
            facts: &summary.facts(),
            warnings: &summary.warnings,
            outages: &outages,
            solutions: &run.solutions,
            smoothed: &smoothed,
            fixes: &dataset.fixes,
            innovations: &innovations,
            reference: &flight_page::reference_moments(&run.solutions, reference.as_ref()),
            score: scored.as_ref(),
            onboard: onboard.as_ref(),
            log: Some(&dataset),
            baro: &dataset.baro,
            sticks: &flight_page::sticks(&dataset)?,
            notices: &run.notices,
            findings: &summary.findings,
        };
        flight_page::page(&page).write(&out.join(output::REPORT))?;
    }
    let page = arguments.no_report.then_some(output::REPORT);
    output::remove_stale(out, export::not_asked(&arguments.export).into_iter().chain(page));
    drop(judging);
    summary.wall_s = started.elapsed().as_secs_f64();
    output::write_json(&summary, &out.join("summary.json"))?;
    Ok(summary)
}

/// The result of running the filter over a log.
struct Flown {
    run: Run,
    /// The smoothed solutions; empty if nothing was smoothed.
    smoothed: Vec<Solution>,
    /// Findings where the GPS fixes contradict the smoothed solution.
    denied: Vec<Finding>,
}

/// Runs the filter over `dataset`, read from `log`, and writes the solution to `out`.
fn fly(
    arguments: &Arguments,
    log: &Path,
    out: &Path,
    dataset: &Dataset,
    config: &EstimatorConfig,
    keep: Keep,
) -> anyhow::Result<Flown> {
    let bar = output::bar(dataset.sample_count());
    let progress = |done: usize| {
        if done.is_multiple_of(SAMPLES_A_STEP) {
            bar.set_position(done as u64);
        }
    };
    let mut files = Files::new(arguments, &dataset.manifest, out);
    let (mut smoothed, mut denied) = (Vec::new(), Vec::new());
    let mut forward = None;
    if arguments.smooth {
        memory::check_smoothing(log, dataset)?;
        let run = dataset.smooth_keeping(config, keep, &progress);
        denied = run.denied;
        // If nothing was smoothed, the causal solution is written, as without `--smooth`.
        forward = Some(run.forward).filter(|_| !run.solutions.is_empty());
        run.solutions.iter().try_for_each(|solution| files.push(solution))?;
        smoothed = thin(run.solutions);
    }
    let run = match forward {
        Some(run) => run,
        None => dataset.estimate_each(config, keep, &progress, |solution| files.push(solution))?,
    };
    files.finish()?;
    bar.finish_and_clear();
    Ok(Flown { run, smoothed, denied })
}

fn drifts(
    solutions: &[Solution],
    outages: &[Outage],
    span: Option<(Time, Time)>,
    reference: Option<&Reference>,
) -> Vec<OutageDrift> {
    outages
        .iter()
        .map(|outage| OutageDrift {
            start_s: outage.start.seconds(),
            duration_s: outage.duration_s,
            is_outside: span.is_some_and(|(first, last)| {
                outage.start > last || outage.start.offset_by(outage.duration_s) < first
            }),
            max_horizontal_m: reference.and_then(|reference| {
                outage_drift(solutions, reference, outage.start, outage.duration_s)
            }),
        })
        .collect()
}
