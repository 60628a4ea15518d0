//! Runs of the estimator on every set, as by `hovernav estimate`: causal, smoothed, and without GPS in windows.

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::path::PathBuf;

use hovernav::ekf::{EstimatorConfig, Solution};
use hovernav_dataset::statistics::quantile;
use hovernav_dataset::{Dataset, LogError, Outage, Reference};
use hovernav_findings::{Finding, SetupFinding};
use hovernav_findings::{check_fitness, findings, ignore, ignore_inconsistent};
use hovernav_formats::{Log, Onboard, Options};
use hovernav_replay::{Keep, Run, thin};
use hovernav_replay::{estimate_each, smooth_keeping};
use hovernav_score::{Statistics, score};
use rayon::prelude::*;

use crate::outages::{Drift, drifts};
use crate::row::Row;
use crate::sets::{Set, Windows};

/// Runs the estimator on `sets`, on the threads of the current pool. The keys of the files `settings` override those of
/// each set's `dataset.toml`. The rows have the order of the sets for any number of threads.
#[must_use]
pub fn run(sets: &[Set], settings: &[PathBuf]) -> Vec<Row> {
    let rows = |set: &Set| {
        fly(set, settings).unwrap_or_else(|error| {
            let why = error.to_string().replace(&*set.path.to_string_lossy(), &set.name);
            let why = why.trim_start_matches(&format!("{}: ", set.name)).to_owned();
            vec![Row { refused: why, ..Row::new(&set.name, "estimate") }]
        })
    };
    sets.par_iter().flat_map_iter(rows).collect()
}

/// A log on which the estimator can run, and the data for its evaluation.
struct Flight<'a> {
    set: &'a Set,
    dataset: Dataset,
    config: EstimatorConfig,
    ignored: Vec<SetupFinding>,
    reference: Option<Reference>,
    onboard: Option<Onboard>,
}

fn fly(set: &Set, settings: &[PathBuf]) -> Result<Vec<Row>, LogError> {
    let Log { mut dataset, onboard, .. } = hovernav_formats::open(&set.path, &Options::default())?;
    for file in settings {
        dataset.configure(file)?;
    }
    let denied = check_fitness(&dataset, &set.path)?;
    let mut ignored = ignore(&mut dataset, denied);
    let config = dataset.settings()?;
    let mut causal = estimate(&dataset, &config);
    let without = ignore_inconsistent(&mut dataset, &config, &causal);
    if !without.is_empty() {
        causal = estimate(&dataset, &config);
        ignored.extend(without);
    }
    if causal.solutions.is_empty() {
        let reason = "no solution: the alignment did not end".to_owned();
        return Err(LogError::Unusable { path: set.path.clone(), reason });
    }
    let reference = match set.path.is_dir() {
        true => Reference::open(&set.path, &dataset.manifest)?,
        false => None,
    };
    let flight = Flight { set, dataset, config, ignored, reference, onboard };
    let (causal, (smoothed, outages)) = rayon::join(
        || flight.row("causal", &causal, &causal.solutions, Vec::new()),
        || rayon::join(|| flight.smoothed(), || flight.outages()),
    );
    Ok([causal, smoothed].into_iter().chain(outages).collect())
}

fn estimate(dataset: &Dataset, config: &EstimatorConfig) -> Run {
    let run = estimate_each(dataset, config, Keep::Thinned, |_| {}, |_| Ok::<(), Infallible>(()));
    run.unwrap_or_else(|never| match never {})
}

impl Flight<'_> {
    /// The row of `solutions` from the filter's `run`.
    fn row(&self, name: &str, run: &Run, solutions: &[Solution], more: Vec<Finding>) -> Row {
        let mut row = Row::new(&self.set.name, name);
        if let (Some(reference), Some((first, _))) = (&self.reference, self.dataset.sample_span()) {
            row.reference = self.kind_of_reference();
            row.set_score(&score(solutions, reference, first));
        } else if let Some(onboard) = &self.onboard {
            let difference = onboard.difference(solutions);
            row.reference = format!("{} onboard, not independent", onboard.name);
            row.set_errors(
                difference
                    .iter()
                    .flat_map(|onboard| &onboard.difference)
                    .map(|(name, statistics)| (*name, *statistics)),
            );
        }
        let mut findings = findings(&self.dataset, run);
        findings.extend(more);
        let span = self.dataset.sample_span();
        let span_s = span.map_or((0.0, 0.0), |(first, last)| (first.seconds(), last.seconds()));
        findings.extend(self.ignored.iter().map(|found| found.finding(span_s.0, span_s.1)));
        row.set_findings(&findings);
        row.set("fixes_used", Some(run.fixes_compared.used as f64));
        row.set("fixes_rejected", Some(run.fixes_compared.rejected as f64));
        row
    }

    fn smoothed(&self) -> Row {
        let endless = |_| ControlFlow::Continue(());
        let smoothed = smooth_keeping(&self.dataset, &self.config, Keep::Thinned, endless);
        let smoothed = smoothed.unwrap_or_default();
        if smoothed.solutions.is_empty() {
            let refused = "nothing smoothed: the heading was not found".to_owned();
            return Row { refused, ..Row::new(&self.set.name, "smoothed") };
        }
        let solutions = thin(smoothed.solutions);
        let denied = smoothed.inconsistent.iter().map(Finding::from).collect();
        self.row("smoothed", &smoothed.forward, &solutions, denied)
    }

    /// A row for each length of window; no rows where no reference has positions.
    fn outages(&self) -> Vec<Row> {
        let Some(reference) = &self.reference else { return Vec::new() };
        let rows = self.set.windows.iter().map(|windows| self.outage_row(windows, reference));
        rows.filter(|row| !row.numbers.is_empty()).collect()
    }

    fn outage_row(&self, windows: &Windows, reference: &Reference) -> Row {
        let name = format!("outages {} s", windows.duration_s);
        let mut row = Row::new(&self.set.name, &name);
        row.reference = self.kind_of_reference();
        let spaced = self
            .dataset
            .sample_span()
            .map(|(first, last)| windows.spaced(first.offset_by(reference.skip_s), last));
        let flown = |outages: &[Outage]| -> Vec<Drift> {
            let drifts = drifts(&self.dataset, &self.config, reference, outages);
            drifts.into_iter().flatten().collect()
        };
        set_drifts(&mut row, "documented", &flown(&windows.documented()));
        set_drifts(&mut row, "spaced", &flown(&spaced.unwrap_or_default()));
        row
    }

    /// Description of the reference in the set's manifest, up to the first parenthesis or semicolon.
    fn kind_of_reference(&self) -> String {
        let manifest = &self.dataset.manifest;
        let quality = manifest.reference.quality.split(['(', ';']).next().unwrap_or_default();
        match (quality.trim(), &*manifest.kind) {
            ("", "simulated") => "simulated truth".to_owned(),
            ("", _) => "not stated".to_owned(),
            (quality, _) => quality.to_owned(),
        }
    }
}

/// Writes the statistics of windows without GPS to the columns that begin with `list`.
fn set_drifts(row: &mut Row, list: &str, drifts: &[Drift]) {
    let mut sizes: Vec<f64> = drifts.iter().map(|drift| drift.horizontal_m).collect();
    let Some(Statistics { median, max, .. }) = Statistics::of(&sizes) else { return };
    row.set(&format!("{list}_windows"), Some(sizes.len() as f64));
    row.set(&format!("{list}_median_m"), Some(median));
    row.set(&format!("{list}_p90_m"), quantile(&mut sizes, 0.9));
    row.set(&format!("{list}_worst_m"), Some(max));
    let over_sigma: Vec<f64> = drifts.iter().filter_map(|drift| drift.over_sigma).collect();
    let rms = Statistics::of(&over_sigma).map(|statistics| statistics.rmse);
    row.set(&format!("{list}_over_sigma"), rms);
}
