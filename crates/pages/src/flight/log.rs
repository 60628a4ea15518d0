//! The page of an estimated log.

use hovernav::ekf::Innovation;
use hovernav::time::Time;
use hovernav_dataset::{LogError, Outage, ReferenceMoment};
use hovernav_formats::{Estimated, Judged, Log};
use hovernav_score::innovations;

use super::data::{FlightData, reference_moments, sticks};
use super::facts::{facts, headlines};
use super::sections::page;
use crate::{Fact, Page};

/// The page of an estimated log: what [`Log::estimate`] and [`Log::judge`] found, with its raw samples.
pub struct LogPage<'a> {
    log: &'a Log,
    estimated: &'a Estimated,
    judged: &'a Judged,
    outages: &'a [Outage],
    headlines: Vec<Fact>,
    facts: Vec<Fact>,
    innovations: Vec<Innovation>,
    reference: Vec<(Time, ReferenceMoment)>,
    sticks: Vec<Vec<(Time, f64)>>,
}

impl<'a> LogPage<'a> {
    /// The page of `log`, estimated without GPS in `outages`.
    ///
    /// # Errors
    /// [`LogError`] if the file of the sticks changed since the log was opened.
    pub fn new(
        log: &'a Log,
        estimated: &'a Estimated,
        judged: &'a Judged,
        outages: &'a [Outage],
    ) -> Result<Self, LogError> {
        let run = &estimated.pass.run;
        Ok(Self {
            log,
            estimated,
            judged,
            outages,
            headlines: headlines(&judged.summary),
            facts: facts(&judged.summary),
            innovations: innovations(run),
            reference: reference_moments(&run.solutions, judged.reference.as_ref()),
            sticks: sticks(&log.dataset)?,
        })
    }

    /// The page itself.
    #[must_use]
    pub fn page(&self) -> Page<'_> {
        let (dataset, pass) = (&self.log.dataset, &self.estimated.pass);
        let summary = &self.judged.summary;
        page(&FlightData {
            title: &dataset.manifest.name,
            verdict: summary.verdict.as_ref(),
            headlines: &self.headlines,
            facts: &self.facts,
            warnings: &summary.warnings,
            outages: self.outages,
            solutions: &pass.run.solutions,
            smoothed: &pass.smoothed,
            fixes: &dataset.fixes,
            innovations: &self.innovations,
            reference: &self.reference,
            score: self.judged.score.as_ref(),
            onboard: self.log.onboard.as_ref(),
            log: Some(dataset),
            baro: &dataset.baro,
            sticks: &self.sticks,
            notices: &pass.run.notices,
            findings: &summary.findings,
        })
    }
}
