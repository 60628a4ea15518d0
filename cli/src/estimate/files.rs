//! The solution's files, written while the filter runs.

use std::path::Path;

use hovernav::ekf::Solution;
use hovernav::time::Time;
use hovernav_dataset::{Manifest, SolutionWriter};

use super::arguments::Arguments;
use super::columns;
use super::export::Exports;
use crate::output;

/// `solution.csv` and the requested exports. The first solution creates the files; without a solution nothing is
/// written.
pub struct Files<'a> {
    arguments: &'a Arguments,
    manifest: &'a Manifest,
    out: &'a Path,
    rate: Option<Rate>,
    open: Option<(SolutionWriter, Exports)>,
}

impl<'a> Files<'a> {
    pub fn new(arguments: &'a Arguments, manifest: &'a Manifest, out: &'a Path) -> Self {
        let rate = arguments.rate.map(Rate::of);
        Self { arguments, manifest, out, rate, open: None }
    }

    /// Writes `solution`, unless the requested output rate skips it.
    pub fn push(&mut self, solution: &Solution) -> anyhow::Result<()> {
        if self.rate.as_mut().is_some_and(|rate| !rate.takes(solution.time)) {
            return Ok(());
        }
        if self.open.is_none() {
            output::create(self.out)?;
            let extra = columns::of(&self.arguments.columns);
            let csv = SolutionWriter::new(&self.out.join("solution.csv"), &extra);
            let exports = Exports::begin(&self.arguments.export, self.manifest, self.out)?;
            self.open = Some((csv, exports));
        }
        if let Some((csv, exports)) = &mut self.open {
            csv.push(solution)?;
            exports.push(solution)?;
        }
        Ok(())
    }

    /// Completes the files.
    pub fn finish(self) -> anyhow::Result<()> {
        let Some((csv, exports)) = self.open else { return Ok(()) };
        csv.finish()?;
        exports.finish()
    }
}

/// Selects the first solution, and then the first solution of every period of the output rate.
struct Rate {
    hz: f64,
    first: Option<Time>,
    period: f64,
}

impl Rate {
    fn of(hz: f64) -> Self {
        Self { hz, first: None, period: f64::NEG_INFINITY }
    }

    fn takes(&mut self, time: Time) -> bool {
        // A time that rounding puts just before a period belongs to that period.
        const ROUNDING: f64 = 1e-6;
        let period = ((time - *self.first.get_or_insert(time)) * self.hz + ROUNDING).floor();
        let is_new = period > self.period;
        self.period = self.period.max(period);
        is_new
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(hz: f64, interval_ns: i64, count: i64) -> Vec<i64> {
        let mut rate = Rate::of(hz);
        (0..count)
            .filter(|index| rate.takes(Time::from_nanoseconds(7_000 + index * interval_ns)))
            .collect()
    }

    #[test]
    fn a_rate_is_kept_on_average_and_never_exceeded() {
        assert_eq!(taken(10.0, 10_000_000, 51), [0, 10, 20, 30, 40, 50]);
        assert_eq!(taken(10.0, 30_303_030, 3301).len(), 1000);
        // A log with a lower sample rate than the requested output rate is written completely.
        assert_eq!(taken(10.0, 200_000_000, 5), [0, 1, 2, 3, 4]);
    }
}
