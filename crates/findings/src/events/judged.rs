//! A run over a log, to be judged.

use hovernav::ekf::Solution;

use hovernav_dataset::Dataset;
use hovernav_replay::Run;

/// A log, and a run over it.
#[derive(Clone, Copy)]
pub(super) struct Judged<'a> {
    pub dataset: &'a Dataset,
    pub run: &'a Run,
}

impl Judged<'_> {
    /// The solution at `time_s`, or the first one after it.
    pub fn solution_at(&self, time_s: f64) -> Option<&Solution> {
        let solutions = &self.run.solutions;
        let index = solutions.partition_point(|solution| solution.time.seconds() < time_s);
        solutions.get(index)
    }

    /// One-sigma of horizontal position, m, and horizontal velocity, m/s, at a time.
    pub fn sigmas_at(&self, time_s: f64) -> Option<(f64, f64)> {
        let solution = self.solution_at(time_s).or(self.run.solutions.last())?;
        let horizontal = |[north, east, _]: [f64; 3]| north.hypot(east);
        Some((
            horizontal(solution.position_sigma_m.to_array()),
            horizontal(solution.velocity_sigma_mps.to_array()),
        ))
    }

    /// Change of the one-sigmas over a span, as the end of a sentence; empty without solutions.
    pub fn cost(&self, start_s: f64, end_s: f64) -> String {
        let Some((before, after)) = self.sigmas_at(start_s).zip(self.sigmas_at(end_s)) else {
            return String::new();
        };
        format!(
            "; position one-sigma went from {:.1} to {:.1} m, velocity one-sigma from {:.2} to {:.2} m/s",
            before.0, after.0, before.1, after.1
        )
    }

    /// First and last time of the solution, s.
    pub fn span_s(&self) -> Option<(f64, f64)> {
        let solutions = &self.run.solutions;
        Some((solutions.first()?.time.seconds(), solutions.last()?.time.seconds()))
    }
}
