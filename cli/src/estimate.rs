//! `hovernav estimate`: the filter over a log, scored and drawn.

use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Instant;

use anyhow::{Context as _, ensure};
use hovernav::ekf::{Innovation, Notice, Solution};
use hovernav::time::Time;
use hovernav_log::{
    Dataset, Outage, Reference, Run, Score, SmoothedRun, outage_drift, score, write_solution,
};
use indicatif::{ProgressBar, ProgressStyle};

use crate::report::{self, Report};
use crate::summary::{OutageDrift, Summary};

#[derive(clap::Args)]
pub struct Arguments {
    /// A dataset directory or a flight record
    log: PathBuf,
    /// Where to write; out/NAME unless given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Settings that override those of the log's dataset.toml, in the same form
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Go back over the whole log as well: each moment then knows what came after it
    #[arg(long)]
    smooth: bool,
    /// Leave out the GPS from START for DURATION seconds of the log's clock; may be repeated
    #[arg(long, value_name = "START:DURATION")]
    outage: Vec<Window>,
    /// Thin the GPS to at most this rate
    #[arg(long, value_name = "HZ", value_parser = positive)]
    gps_rate: Option<f64>,
    /// Write no report.html
    #[arg(long)]
    no_report: bool,
}

impl Arguments {
    /// Whether anything asks for another solution than the one that flew.
    fn changes_the_filter(&self) -> bool {
        self.config.is_some() || !self.outage.is_empty() || self.gps_rate.is_some()
    }
}

/// `START:DURATION`, both in seconds.
#[derive(Clone, Copy)]
pub struct Window(Outage);

impl Window {
    /// The same as an outage.
    pub fn outage(self) -> Outage {
        self.0
    }
}

impl FromStr for Window {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("found \"{text}\", expected START:DURATION in seconds");
        let (start, duration) = text.split_once(':').ok_or_else(expected)?;
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
        let start = number(start).and_then(Time::from_seconds).ok_or_else(expected)?;
        let duration_s =
            number(duration).filter(|&duration| duration > 0.0).ok_or_else(expected)?;
        Ok(Self(Outage { start, duration_s }))
    }
}

fn positive(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|&value: &f64| value.is_finite() && value > 0.0)
        .ok_or_else(|| format!("found \"{text}\", expected a number of hertz above 0"))
}

/// Logs shorter than this are done before a bar could be read.
const SAMPLES_WORTH_A_BAR: usize = 500_000;

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    let (mut dataset, record) = crate::log::open(&arguments.log)?;
    if let Some(config) = &arguments.config {
        dataset.configure(config)?;
    }
    ensure!(
        !dataset.fixes.is_empty(),
        "{}: found no usable fix, expected at least one to start from",
        if record.is_some() { arguments.log.clone() } else { arguments.log.join("gps.csv") }
            .display()
    );
    let config = dataset.settings()?;
    let outages: Vec<Outage> = arguments.outage.iter().map(|window| window.0).collect();
    dataset.withhold(&outages, arguments.gps_rate);

    let bar = progress_bar(dataset.imu.len());
    let progress = |done: usize| {
        if done.is_multiple_of(4096) {
            bar.set_position(done as u64);
        }
    };
    let (run, smoothed) = if arguments.smooth {
        let SmoothedRun { forward, solutions } = dataset.smooth(&config, progress);
        (forward, solutions)
    } else {
        (dataset.estimate(&config, progress), Vec::new())
    };
    bar.finish_and_clear();
    ensure!(
        !run.solutions.is_empty(),
        "{}: no solution: alignment found no fix with {} s of inertial samples before it",
        arguments.log.display(),
        config.alignment.duration_s
    );

    let reference = match &record {
        Some(_) => None,
        None => Reference::open(&arguments.log, &dataset.manifest)?,
    };
    let first_imu = dataset.imu.first().map_or(Time::ZERO, |sample| sample.time);
    let solutions = if smoothed.is_empty() { &run.solutions } else { &smoothed };
    let scored = reference.as_ref().map(|reference| score(solutions, reference, first_imu));
    let drifts = drifts(solutions, &outages, reference.as_ref());

    let out =
        arguments.out.clone().unwrap_or_else(|| Path::new("out").join(name_of(&arguments.log)));
    std::fs::create_dir_all(&out).with_context(|| format!("cannot create {}", out.display()))?;
    write_solution(&out.join("solution.csv"), solutions)?;
    let mut summary = Summary::new(&arguments.log, &dataset, &run, !smoothed.is_empty());
    if arguments.smooth && smoothed.is_empty() {
        let warning = "nothing was smoothed, as the heading was not found: the solution is causal";
        summary.warnings.push(warning.into());
    }
    summary.warnings.extend(reference.iter().flat_map(|reference| reference.warnings.clone()));
    summary.flown = record
        .filter(|record| !record.solutions.is_empty() && !arguments.changes_the_filter())
        .map(|record| record.reproduced_by(&run.solutions).into());
    summary.set_scores(scored.as_ref(), drifts);
    if !arguments.no_report {
        write_report(
            &out.join("report.html"),
            (&dataset, &run, &smoothed),
            &outages,
            reference.as_ref(),
            scored.as_ref(),
            &summary,
        )?;
    }
    summary.wall_s = started.elapsed().as_secs_f64();
    summary.write(&out.join("summary.json"))?;
    print!("{}", summary.in_words(&out));
    Ok(())
}

/// What a log's results are called after.
pub fn name_of(log: &Path) -> String {
    let full = log.canonicalize().unwrap_or_else(|_| log.to_path_buf());
    full.file_stem().map_or_else(|| "log".into(), |name| name.to_string_lossy().into_owned())
}

fn progress_bar(samples: usize) -> ProgressBar {
    if samples < SAMPLES_WORTH_A_BAR || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{wide_bar} {percent}% {eta} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(samples as u64).with_style(style)
}

fn drifts(
    solutions: &[Solution],
    outages: &[Outage],
    reference: Option<&Reference>,
) -> Vec<OutageDrift> {
    outages
        .iter()
        .map(|outage| OutageDrift {
            start_s: outage.start.seconds(),
            duration_s: outage.duration_s,
            max_horizontal_m: reference.and_then(|reference| {
                outage_drift(solutions, reference, outage.start, outage.duration_s)
            }),
        })
        .collect()
}

fn write_report(
    path: &Path,
    (dataset, run, smoothed): (&Dataset, &Run, &[Solution]),
    outages: &[Outage],
    reference: Option<&Reference>,
    score: Option<&Score>,
    summary: &Summary,
) -> anyhow::Result<()> {
    let innovations: Vec<Innovation> = run
        .notices
        .iter()
        .filter_map(|notice| match notice {
            Notice::Updated(report) => Some(report),
            _ => None,
        })
        .flat_map(|report| report.innovations().copied())
        .collect();
    let reference: Vec<_> = reference.map_or_else(Vec::new, |reference| {
        run.solutions.iter().map(|solution| (solution.time, reference.at(solution.time))).collect()
    });
    report::write(
        path,
        &Report {
            title: &dataset.manifest.name,
            headlines: &summary.headlines(),
            facts: &summary.facts(),
            warnings: &summary.warnings,
            outages,
            solutions: &run.solutions,
            smoothed,
            fixes: &dataset.fixes,
            innovations: &innovations,
            reference: &reference,
            score,
        },
    )
}
