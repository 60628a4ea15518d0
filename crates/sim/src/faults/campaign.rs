//! Campaigns of faults: many faults in many flights.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use hovernav_dataset::{Dataset, LogError};
use rayon::prelude::*;
use serde::Serialize;

use super::catalogue::Kind;
use super::fault::Fault;
use super::flights::{Clean, Flight};
use super::injection::{FaultyLog, InjectError, Made};
use super::measure::{Measures, measure, names};
use super::runner::estimate;
use super::window::Window;

/// Every combination of faults, flights and seeds.
#[derive(Clone, Debug)]
pub struct Campaign {
    /// Flights without faults.
    pub flights: Vec<Flight>,
    /// Cells of the campaign: each contains the faults of one copy.
    pub cells: Vec<Vec<Fault>>,
    /// Number of seeds, from 1, at least one. A flight or fault without random values is run with one seed only.
    pub seeds: u64,
}

/// Result of one run of a campaign.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// The flight's name.
    pub flight: String,
    /// The requested faults; empty for the flight without faults.
    pub faults: String,
    /// Kinds of the faults.
    pub kinds: Vec<Kind>,
    /// Seed of the faults.
    pub seed: u64,
    /// Times of the faults.
    pub made: Vec<Made>,
    /// Effect of the faults.
    #[serde(flatten)]
    pub measures: Measures,
}

/// Faults and severities of `hovernav inject --campaign`.
const STANDARD: [&str; 48] = [
    "vibration=2",
    "vibration=4",
    "clip-accel=2",
    "clip-gyro=60",
    "clip-burst=3",
    "clip-burst=3@:3",
    "stuck=all",
    "stuck=all@:5",
    "stuck=gz@:5",
    "stuck=az@:5",
    "gap=0.5",
    "gap=2",
    "gap=2 gap=3.4 gap=5",
    "gap=10",
    "gap=30",
    "packet-loss=5",
    "packet-loss=25",
    "jitter=3",
    "gyro-bias=0.5",
    "accel-bias=0.3",
    "gps-time=0.15",
    "gps-time=-0.15",
    "outage=10",
    "outage=30",
    "glitch-step=10",
    "glitch-step=60",
    "glitch-ramp=1",
    "glitch-follow=5",
    "frozen-fix",
    "no-velocity",
    "height-held",
    "height-empty",
    "mag-heading=30",
    "mag-heading-only=30",
    "mag-vector=0.2",
    "lever-arm=1",
    "lever-sign",
    "accel-scale=0.5",
    "accel-sign=xyz",
    "gyro-sign=z",
    "swap-axes=xy",
    "unit=g",
    "unit=degps",
    "swap-latlon",
    "radians",
    "mag-vector-only=0.2",
    "attitude-frozen",
    "attitude-late=0.3",
];

/// Cells of the standard campaign.
#[must_use]
pub fn standard_cells() -> Vec<Vec<Fault>> {
    STANDARD.iter().filter_map(|cell| parse(cell).ok()).collect()
}

fn parse(cell: &str) -> Result<Vec<Fault>, String> {
    cell.split_whitespace().map(str::parse).collect()
}

/// Name of a cell in tables.
pub(super) fn name(faults: &[Fault]) -> String {
    faults.iter().map(Fault::to_string).collect::<Vec<_>>().join(" ")
}

impl Campaign {
    /// Largest number of runs, including those without fault.
    #[must_use]
    pub fn runs(&self) -> u64 {
        self.flights.len() as u64 * self.seeds * (1 + self.cells.len() as u64)
    }

    /// Runs the campaign on all processors. Faults of a sensor that a flight does not have are skipped. `progress` is
    /// called for every run.
    ///
    /// # Errors
    /// [`LogError`] for a flight that cannot be read or a copy that cannot be written.
    pub fn run(&self, progress: impl Fn() + Sync) -> Result<Vec<Outcome>, LogError> {
        let seeds = |flight: &Flight| if flight.is_drawn() { self.seeds } else { 1 };
        let pairs: Vec<(&Flight, u64)> = (self.flights.iter())
            .flat_map(|flight| (1..=seeds(flight)).map(move |seed| (flight, seed)))
            .collect();
        let outcomes = pairs.par_iter().map(|&(flight, seed)| {
            let scratch = scratch()?;
            let clean = flight.clean(seed, scratch.path())?;
            progress();
            clean.outcomes(&self.cells, self.seeds, &progress)
        });
        let outcomes = outcomes.collect::<Result<Vec<Vec<Outcome>>, LogError>>()?;
        Ok(outcomes.into_iter().flatten().collect())
    }
}

impl Clean {
    /// The outcome without faults, then those of `cells`. A cell with a random fault is run for seeds 1 to `seeds`, any
    /// other cell once. A simulated flight has one seed, its own. A cell is skipped if one of its faults is in a sensor
    /// that the flight lacks. Each run with faults calls `progress`.
    ///
    /// # Errors
    /// [`LogError`] for a copy that cannot be written.
    pub fn outcomes(
        &self,
        cells: &[Vec<Fault>],
        seeds: u64,
        progress: impl Fn() + Sync,
    ) -> Result<Vec<Outcome>, LogError> {
        let jobs = self.jobs(cells, seeds);
        let runs = jobs.par_iter().map(|&(cell, seed)| {
            let outcome = self.faulty(cell, seed);
            progress();
            outcome
        });
        let runs = runs.collect::<Result<Vec<_>, LogError>>()?;
        let without = Outcome {
            flight: self.name.clone(),
            faults: String::new(),
            kinds: Vec::new(),
            seed: self.seed,
            made: Vec::new(),
            measures: self.measures.clone(),
        };
        Ok(std::iter::once(without).chain(runs.into_iter().flatten()).collect())
    }

    /// The faults and seeds of the copies of this flight: seeds 1 to `seeds` if a fault is random and the flight is a
    /// dataset, otherwise only the flight's own seed.
    pub(super) fn jobs<'a>(
        &self,
        cells: &'a [Vec<Fault>],
        seeds: u64,
    ) -> Vec<(&'a Vec<Fault>, u64)> {
        let of_cell = |cell: &'a Vec<Fault>| {
            let is_drawn = !self.is_drawn && cell.iter().any(Fault::is_drawn);
            let last = if is_drawn { seeds } else { self.seed };
            (self.seed..=last).map(move |seed| (cell, seed))
        };
        cells.iter().flat_map(of_cell).collect()
    }

    /// A copy of the sensors with `faults` in a temporary directory; `None` where the flight lacks the sensor of one of
    /// the faults.
    pub(super) fn copy(
        &self,
        faults: &[Fault],
        seed: u64,
    ) -> Result<Option<(FaultyLog, tempfile::TempDir)>, LogError> {
        let faulty = match self.log.with_faults(faults, seed) {
            Ok(faulty) => faulty,
            Err(InjectError::Log(error)) => return Err(error),
            Err(InjectError::Unfit { .. } | InjectError::Place { .. }) => return Ok(None),
        };
        let scratch = scratch()?;
        faulty.write_sensors(scratch.path())?;
        Ok(Some((faulty, scratch)))
    }

    /// This flight with `faults`; `None` where it lacks the sensor of one of them.
    fn faulty(&self, faults: &[Fault], seed: u64) -> Result<Option<Outcome>, LogError> {
        let Some((faulty, scratch)) = self.copy(faults, seed)? else { return Ok(None) };
        let windows: Vec<Window> = faulty.made.iter().map(|made| made.window).collect();
        let run =
            catch_unwind(AssertUnwindSafe(|| Dataset::open(scratch.path()).and_then(estimate)));
        let named_by: Vec<&str> =
            faults.iter().flat_map(|fault| fault.kind.entry().named_by.iter().copied()).collect();
        let measures = match run {
            Ok(Ok((run, warnings))) => {
                let reference = self.reference.as_ref();
                let mut measures = measure(&run.solutions, reference, &windows, self.end_s);
                measures.warnings = warnings;
                measures.against(&run.solutions, &self.measures, &self.solutions, &named_by);
                measures
            }
            // A log rejected with a reason is not a failure of the filter.
            Ok(Err(error)) => {
                let refusal = error.to_string();
                let named = names(&refusal, &named_by);
                Measures { warnings: vec![refusal], named, ..Measures::default() }
            }
            Err(_) => Measures { panicked: true, ..Measures::default() },
        };
        let kinds = faults.iter().map(|fault| fault.kind).collect();
        let (flight, faults) = (self.name.clone(), name(faults));
        Ok(Some(Outcome { flight, faults, kinds, seed, made: faulty.made, measures }))
    }
}

pub(super) fn scratch() -> Result<tempfile::TempDir, LogError> {
    tempfile::tempdir()
        .map_err(|source| LogError::Io { path: Path::new("temporary directory").into(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_standard_cells_are_faults() {
        for cell in STANDARD {
            assert_eq!(name(&parse(cell).unwrap()), cell);
        }
    }
}
