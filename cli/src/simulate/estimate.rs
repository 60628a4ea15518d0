//! Runs the filter over a simulated flight after its dataset is written.

use std::path::Path;

use hovernav::ekf::Innovation;
use hovernav::time::Time;
use hovernav_dataset::{Dataset, Reference};
use hovernav_findings::findings;
use hovernav_formats::RunSummary;
use hovernav_pages::flight::{self, FlightData};
use hovernav_replay::{Run, estimate};
use hovernav_score::{Apart, Score, innovations, score};

use crate::output;

/// The estimate of a simulated flight, scored against the truth.
pub struct Estimate {
    pub run: Run,
    /// The result of each scalar update of the run.
    pub innovations: Vec<Innovation>,
    pub reference: Option<Reference>,
    pub score: Option<Score>,
    pub summary: RunSummary,
}

impl Estimate {
    /// Runs the filter over `dataset`, whose files and truth are in `out`. `progress` receives the number of processed
    /// samples.
    pub fn of(dataset: &mut Dataset, out: &Path, progress: impl Fn(usize)) -> anyhow::Result<Self> {
        let settings = dataset.settings()?;
        let run = estimate(dataset, &settings, progress);
        let mut summary =
            RunSummary::new(Path::new(&dataset.manifest.vehicle), dataset, &run, false);
        let reference = Reference::open(out, &dataset.manifest)?;
        let score =
            reference.as_ref().map(|reference| score(&run.solutions, reference, Time::ZERO));
        let apart = reference
            .as_ref()
            .map(|reference| Apart::of_reference(&run.solutions, reference, Time::ZERO));
        summary.set_findings(findings(dataset, &run), &run.solutions, apart.as_ref());
        summary.set_scores(score.as_ref(), Vec::new());
        let innovations = innovations(&run);
        summary.conclude(&innovations);
        Ok(Self { run, innovations, reference, score, summary })
    }

    /// Writes `report.html` to `out`. Without a solution it writes no page and prints the reason.
    pub fn write_page(&self, title: &str, dataset: &Dataset, out: &Path) -> anyhow::Result<()> {
        let Self { run, innovations, reference, score, summary } = self;
        if run.solutions.is_empty() {
            output::say(
                "no report.html: the filter did not align, so there is no solution to show",
            );
            output::remove_stale(out, [output::REPORT]);
            return Ok(());
        }
        let page = FlightData {
            title,
            verdict: summary.verdict.as_ref(),
            headlines: &flight::headlines(summary),
            facts: &flight::facts(summary),
            warnings: &summary.warnings,
            solutions: &run.solutions,
            fixes: &dataset.fixes,
            innovations,
            reference: &flight::reference_moments(&run.solutions, reference.as_ref()),
            score: score.as_ref(),
            log: Some(dataset),
            baro: &dataset.baro,
            sticks: &flight::sticks(dataset)?,
            notices: &run.notices,
            findings: &summary.findings,
            ..FlightData::default()
        };
        Ok(flight::page(&page).write(&out.join(output::REPORT))?)
    }
}
