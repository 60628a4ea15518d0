//! Effect of a fault on the solution: errors against the reference and against the filter's own sigmas.

use std::collections::BTreeSet;

use hovernav::ekf::Solution;
use hovernav::frames::wrap_angle;
use hovernav_dataset::Reference;
use hovernav_score::{Axis, axis_errors, axis_sigmas};
use serde::Serialize;

use super::window::Window;

/// Axes for the comparison of errors with the filter's sigmas, velocity and attitude first.
pub const AXES: [Axis; 9] = [
    Axis::VelocityNorth,
    Axis::VelocityEast,
    Axis::VelocityDown,
    Axis::Roll,
    Axis::Pitch,
    Axis::Yaw,
    Axis::North,
    Axis::East,
    Axis::Down,
];

/// Time for which the velocity has to stay inside its 3 sigma to count as recovered, s.
const BACK_S: f64 = 1.0;
/// Error of velocity, m/s, above which a run has diverged at its end.
const DIVERGED_MPS: f64 = 5.0;
/// Error of horizontal position, m, above which a run has diverged at its end.
const DIVERGED_M: f64 = 50.0;
/// Length of the evaluated end, s.
const END_S: f64 = 10.0;

/// Scores of one run, over all samples from the first solution on for which the reference has a value; NaN without such
/// a sample.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Measures {
    /// Number of samples with a solution; 0 for a log on which the estimator could not start.
    pub samples: usize,
    /// Whether the estimator panicked.
    pub panicked: bool,
    /// Whether a solution contains a number that is not finite.
    pub nan: bool,
    /// Whether the errors of the last ten seconds exceed 5 m/s in velocity or 50 m in horizontal position, or these
    /// seconds have no solution.
    pub diverged: bool,
    /// Fraction of the samples inside 3 sigma on each of [`AXES`].
    pub inside: [f64; 9],
    /// Fraction of the samples inside 3 sigma for velocity and attitude together; each axis and sample counts once.
    pub inside_motion: f64,
    /// Fraction of the samples inside 3 sigma for position.
    pub inside_position: f64,
    /// Fraction of the samples with velocity and attitude inside 3 sigma on all axes simultaneously.
    pub inside_jointly: f64,
    /// Root mean square of error over sigma on each of [`AXES`].
    pub normalised: [f64; 9],
    /// Root mean square of error over sigma for velocity and attitude together.
    pub normalised_motion: f64,
    /// Root mean square error of velocity, m/s, all axes.
    pub velocity_rmse_mps: f64,
    /// Root mean square error of vertical velocity, m/s.
    pub vertical_velocity_rmse_mps: f64,
    /// Root mean square horizontal error, m.
    pub horizontal_rmse_m: f64,
    /// Root mean square error of height, m.
    pub height_rmse_m: f64,
    /// Root mean square error of roll and pitch, °.
    pub tilt_rmse_deg: f64,
    /// Root mean square error of yaw, °.
    pub yaw_rmse_deg: f64,
    /// Largest error of velocity, m/s.
    pub worst_velocity_mps: f64,
    /// Largest horizontal error, m.
    pub worst_horizontal_m: f64,
    /// Largest horizontal difference between the solutions with and without the fault, m.
    pub pulled_m: f64,
    /// Largest difference in velocity between the solutions with and without the fault, m/s.
    pub pulled_mps: f64,
    /// Largest difference in yaw between the solutions with and without the fault, °.
    pub pulled_yaw_deg: f64,
    /// Time, s, from the end of the last fault that ends to the start of the first second with the velocity inside its
    /// 3 sigma. Infinite if there is no such second.
    pub back_after_s: f64,
    /// Errors relative to those of the run without fault: velocity, horizontal position, tilt, yaw.
    pub cost: [f64; 4],
    /// Warnings that the run without fault does not have.
    pub warnings: Vec<String>,
    /// Whether one of these warnings names the fault.
    pub named: bool,
}

/// Errors and sigmas of one sample, in the order of [`AXES`].
struct Compared {
    time_s: f64,
    errors: [f64; 9],
    sigmas: [f64; 9],
}

fn compare(solution: &Solution, reference: &Reference) -> Compared {
    let errors = axis_errors(solution, reference);
    let sigmas = axis_sigmas(solution);
    Compared {
        time_s: solution.time.seconds(),
        errors: AXES.map(|axis| errors[axis as usize]),
        sigmas: AXES
            .map(|axis| sigmas[axis as usize].unwrap_or(f64::NAN).hypot(axis.own_sigma(reference))),
    }
}

/// Root mean square of the finite values; NaN without a finite value.
fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values.filter(|value| value.is_finite()) {
        sum += value * value;
        count += 1.0;
    }
    (sum / count).sqrt()
}

/// Fraction of `true` among the known values; NaN without a known value.
fn share(known: impl Iterator<Item = Option<bool>>) -> f64 {
    let (mut inside, mut count) = (0.0, 0.0);
    for is_inside in known.flatten() {
        inside += f64::from(u8::from(is_inside));
        count += 1.0;
    }
    inside / count
}

impl Compared {
    /// Whether an axis is inside 3 sigma; `None` where the reference has no value.
    fn inside(&self, axis: usize) -> Option<bool> {
        let (error, sigma) = (self.errors[axis], self.sigmas[axis]);
        error.is_finite().then_some(error.abs() <= 3.0 * sigma)
    }

    fn all_inside(&self, axes: std::ops::Range<usize>) -> Option<bool> {
        axes.filter_map(|axis| self.inside(axis)).reduce(|a, b| a && b)
    }

    fn normalised(&self, axis: usize) -> f64 {
        self.errors[axis] / self.sigmas[axis]
    }

    fn norm(&self, axes: std::ops::Range<usize>) -> f64 {
        self.errors[axes].iter().map(|error| error * error).sum::<f64>().sqrt()
    }
}

/// Scores `solutions` of a flight that ends at `end_s` on the log's clock.
pub(super) fn measure(
    solutions: &[Solution],
    reference: Option<&Reference>,
    windows: &[Window],
    end_s: f64,
) -> Measures {
    let mut compared = Vec::new();
    if let Some(reference) = reference {
        compared.extend(solutions.iter().map(|solution| compare(solution, reference)));
    }
    let inside = std::array::from_fn(|axis| share(compared.iter().map(|at| at.inside(axis))));
    let normalised = std::array::from_fn(|axis| rms(compared.iter().map(|at| at.normalised(axis))));
    let pooled = |axes: std::ops::Range<usize>| {
        share(compared.iter().flat_map(|at| axes.clone().map(|axis| at.inside(axis))))
    };
    let most = |axes: std::ops::Range<usize>| {
        let sizes = compared.iter().map(|at| at.norm(axes.clone()));
        sizes.filter(|size| size.is_finite()).fold(f64::NAN, f64::max)
    };
    let of = |axes: std::ops::Range<usize>| rms(compared.iter().map(|at| at.norm(axes.clone())));
    let mut last = compared.iter().filter(|at| at.time_s > end_s - END_S);
    let lost = last.any(|at| at.norm(0..3) > DIVERGED_MPS || at.norm(6..8) > DIVERGED_M);
    let ends = solutions.last().is_none_or(|last| last.time.seconds() > end_s - END_S);
    let end = windows.iter().map(Window::end_s).filter(|end| end.is_finite());
    Measures {
        samples: solutions.len(),
        nan: solutions.iter().any(|solution| !is_finite(solution)),
        diverged: lost || !ends,
        inside,
        inside_motion: pooled(0..6),
        inside_position: pooled(6..9),
        inside_jointly: share(compared.iter().map(|at| at.all_inside(0..6))),
        normalised,
        normalised_motion: rms(compared.iter().flat_map(|at| (0..6).map(|a| at.normalised(a)))),
        velocity_rmse_mps: of(0..3),
        vertical_velocity_rmse_mps: of(2..3),
        horizontal_rmse_m: of(6..8),
        height_rmse_m: of(8..9),
        tilt_rmse_deg: of(3..5),
        yaw_rmse_deg: of(5..6),
        worst_velocity_mps: most(0..3),
        worst_horizontal_m: most(6..8),
        back_after_s: back_after_s(&compared, end.fold(f64::NAN, f64::max)),
        ..Measures::default()
    }
}

impl Measures {
    /// Adds the differences to the run of this flight without fault.
    pub(super) fn against(
        &mut self,
        solutions: &[Solution],
        clean: &Measures,
        clean_solutions: &[Solution],
        named_by: &[&str],
    ) {
        let mut nearest = clean_solutions.iter().peekable();
        for solution in solutions {
            // Time stamps may differ slightly; the next sample of the run without fault is close enough.
            while nearest.peek().is_some_and(|clean| clean.time < solution.time) {
                nearest.next();
            }
            let Some(clean) = nearest.peek() else { break };
            let away = solution.position.displacement_from(&clean.position);
            let turned = solution.body_to_ned.euler().yaw_rad - clean.body_to_ned.euler().yaw_rad;
            self.pulled_m = self.pulled_m.max(away.x().hypot(away.y()));
            let change = solution.velocity_mps - clean.velocity_mps;
            self.pulled_mps = self.pulled_mps.max(change.norm());
            self.pulled_yaw_deg = self.pulled_yaw_deg.max(wrap_angle(turned).to_degrees().abs());
        }
        self.cost = [
            self.velocity_rmse_mps / clean.velocity_rmse_mps,
            self.horizontal_rmse_m / clean.horizontal_rmse_m,
            self.tilt_rmse_deg / clean.tilt_rmse_deg,
            self.yaw_rmse_deg / clean.yaw_rmse_deg,
        ];
        let known: BTreeSet<&String> = clean.warnings.iter().collect();
        self.warnings.retain(|warning| !known.contains(warning));
        self.named = self.warnings.iter().any(|warning| names(warning, named_by));
    }

    /// The largest known [`cost`](Self::cost).
    #[must_use]
    pub fn largest_cost(&self) -> f64 {
        self.cost.iter().copied().filter(|cost| cost.is_finite()).fold(f64::NAN, f64::max)
    }
}

/// Whether a sentence contains one of the words that name a fault, or all of those joined by a +.
pub(super) fn names(sentence: &str, named_by: &[&str]) -> bool {
    let sentence = sentence.to_lowercase();
    named_by.iter().any(|name| name.split('+').all(|part| sentence.contains(part)))
}

/// Time, s, from `end_s` to the start of the first second with the velocity inside 3 sigma.
fn back_after_s(compared: &[Compared], end_s: f64) -> f64 {
    if end_s.is_nan() {
        return f64::NAN;
    }
    let mut since: Option<f64> = None;
    let after = compared.iter().skip_while(|at| at.time_s < end_s);
    for (at, inside) in after.filter_map(|at| Some((at, at.all_inside(0..3)?))) {
        if !inside {
            since = None;
            continue;
        }
        let start_s = *since.get_or_insert(at.time_s);
        if at.time_s - start_s >= BACK_S {
            return (start_s - end_s).max(0.0);
        }
    }
    if compared.iter().any(|at| at.all_inside(0..3).is_some()) { f64::INFINITY } else { f64::NAN }
}

fn is_finite(solution: &Solution) -> bool {
    let angles = solution.body_to_ned.euler();
    let attitude = [angles.roll_rad, angles.pitch_rad, angles.yaw_rad];
    let numbers = attitude
        .into_iter()
        .chain(solution.attitude_sigma_rad)
        .chain(solution.velocity_mps.to_array())
        .chain(solution.velocity_sigma_mps.to_array())
        .chain(solution.position_sigma_m.to_array())
        .chain([solution.position.latitude_rad, solution.position.height_m]);
    numbers.into_iter().all(f64::is_finite)
}
