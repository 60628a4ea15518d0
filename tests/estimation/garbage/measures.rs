//! Errors of a flight with garbage, compared with its twin.

use std::path::Path;

use hovernav::earth::STANDARD_GRAVITY_MPS2;
use hovernav::ekf::Solution;
use hovernav_dataset::{Dataset, Reference};
use hovernav_findings::{check_fitness, ignore, ignore_inconsistent};
use hovernav_replay::estimate;
use hovernav_score::{Axis, axis_errors, axis_sigmas};

use super::flights::Case;

/// Largest bias, as a fraction of full scale.
const BIAS_SHARE: f64 = 0.1;
/// Errors beyond those of the twin within which a flight is normal again: velocity, m/s, and position, horizontal and
/// vertical, m.
const MARGIN: [f64; 3] = [0.5, 5.0, 5.0];
/// Time, s, for which errors must stay within the margin to count as normal.
const STAYS_S: f64 = 5.0;
/// Time at the end of a flight, s, in which errors beyond `LOST` count as divergence.
const END_S: f64 = 10.0;
/// Errors beyond which a flight counts as diverged, in the order of `MARGIN`.
const LOST: [f64; 3] = [5.0, 50.0, 50.0];

/// Errors, biases and outcome of one flight.
#[derive(Clone, Debug)]
pub struct Measures {
    /// Largest errors from the garbage's start to the end of the flight: height, m, velocity down and velocity
    /// horizontal, m/s.
    pub height_m: f64,
    pub vertical_mps: f64,
    pub horizontal_mps: f64,
    /// Largest error of velocity north or east over its one-sigma in that time.
    pub horizontal_sigmas: f64,
    /// Fraction of the samples and axes of velocity within 3 sigma, from the garbage's start to 30 s after its end.
    pub inside: f64,
    /// Fraction of the twin's samples and axes of velocity within 3 sigma, in the same time.
    pub twin_inside: f64,
    /// Largest error of the twin's height, m.
    pub twin_height_m: f64,
    /// Largest error of the twin's velocity down, m/s.
    pub twin_vertical_mps: f64,
    /// Time from the receiver's recovery until the errors equal those of the twin within a margin, s; infinite if they
    /// never do.
    pub normal_after_s: f64,
    /// Largest ratio of a gyro or accelerometer bias to its limit, which is [`BIAS_SHARE`] of full scale, over all
    /// solutions.
    pub bias: f64,
    /// Whether an accepted log ends with errors that are not finite or far too large.
    pub diverged: bool,
    /// Reason for rejecting the log, which then has no solution.
    pub refused: Option<String>,
    /// Sensors excluded in the flight, but not in the twin.
    pub ignored: usize,
}

/// Solutions of a dataset, computed as by `hovernav estimate`.
pub struct Twin {
    /// Empty if the log is rejected.
    solutions: Vec<Solution>,
    refused: Option<String>,
    ignored: usize,
    /// Full scale of gyros, rad/s, and accelerometers, m/s².
    full_scale: [f64; 2],
}

impl Twin {
    pub fn of(mut dataset: Dataset) -> Self {
        let imu = &dataset.manifest.imu;
        let full_scale = [
            imu.gyro_range_degps.expect("both state it").to_radians(),
            imu.accel_range_g.expect("both state it") * STANDARD_GRAVITY_MPS2,
        ];
        let denied = match check_fitness(&dataset, Path::new("garbage")) {
            Ok(denied) => denied,
            Err(error) => {
                let refused = Some(error.to_string());
                return Self { solutions: Vec::new(), refused, ignored: 0, full_scale };
            }
        };
        let mut ignored = ignore(&mut dataset, denied).len();
        let config = dataset.settings().unwrap();
        let mut run = estimate(&dataset, &config, |_| {});
        let without = ignore_inconsistent(&mut dataset, &config, &run).len();
        if without > 0 {
            run = estimate(&dataset, &config, |_| {});
            ignored += without;
        }
        Self { solutions: run.solutions, refused: None, ignored, full_scale }
    }

    /// Largest bias over `BIAS_SHARE` of its full scale.
    fn bias(&self) -> f64 {
        let [gyro_radps, accel_mps2] = self.full_scale.map(|full_scale| BIAS_SHARE * full_scale);
        let most = |biases: [f64; 3]| biases.into_iter().map(f64::abs).fold(0.0, f64::max);
        let of = |solution: &Solution| {
            let gyro = most(solution.gyro_bias_radps.to_array()) / gyro_radps;
            gyro.max(most(solution.accel_bias_mps2.to_array()) / accel_mps2)
        };
        self.solutions.iter().map(of).fold(0.0, f64::max)
    }

    fn errors(&self, reference: &Reference) -> Vec<Errors> {
        self.solutions.iter().map(|solution| Errors::of(solution, reference)).collect()
    }
}

/// Errors of one solution.
#[derive(Clone, Copy)]
struct Errors {
    time_s: f64,
    velocity_mps: [f64; 3],
    sigma_mps: [f64; 3],
    horizontal_m: f64,
    height_m: f64,
}

impl Errors {
    fn of(solution: &Solution, reference: &Reference) -> Self {
        let velocity = [Axis::VelocityNorth, Axis::VelocityEast, Axis::VelocityDown];
        let (errors, sigmas) = (axis_errors(solution, reference), axis_sigmas(solution));
        Self {
            time_s: solution.time.seconds(),
            velocity_mps: velocity.map(|axis| errors[axis as usize].abs()),
            sigma_mps: velocity.map(|axis| sigmas[axis as usize].unwrap_or(f64::NAN)),
            horizontal_m: errors[Axis::Horizontal as usize],
            height_m: errors[Axis::Down as usize].abs(),
        }
    }

    /// Magnitudes of the errors: velocity, m/s, horizontal position, m, and height, m.
    fn sizes(&self) -> [f64; 3] {
        let [north, east, down] = self.velocity_mps;
        [north.hypot(east).hypot(down), self.horizontal_m, self.height_m]
    }

    /// Whether the velocities north, east and down are within 3 sigma.
    fn within_3_sigma(&self) -> [bool; 3] {
        [0, 1, 2].map(|axis| self.velocity_mps[axis] <= 3.0 * self.sigma_mps[axis])
    }
}

/// Whether every error is below its limit; a non-finite one is not.
fn all_below(sizes: [f64; 3], limits: [f64; 3]) -> bool {
    sizes.iter().zip(limits).all(|(size, limit)| *size <= limit)
}

fn share_inside(errors: &[Errors], case: &Case) -> f64 {
    let span_s = case.start_s..case.end_s() + 30.0;
    let during: Vec<bool> = (errors.iter().filter(|at| span_s.contains(&at.time_s)))
        .flat_map(Errors::within_3_sigma)
        .collect();
    during.iter().filter(|inside| **inside).count() as f64 / during.len() as f64
}

/// Measures of `flown`, the flight of `case`; its `twin` has no garbage.
pub fn measure(case: &Case, reference: &Reference, flown: &Twin, twin: &Twin) -> Measures {
    // Outside its time span the reference has no values.
    let known = |twin: &Twin| -> Vec<Errors> {
        let moments = twin.errors(reference).into_iter();
        moments.filter(|at| reference_is_known(reference, at.time_s)).collect()
    };
    let (errors, normal) = (known(flown), known(twin));
    let most_of = |errors: &[Errors], pick: &dyn Fn(&Errors) -> f64| {
        let number = |size: f64| if size.is_nan() { f64::INFINITY } else { size };
        let after = errors.iter().filter(|at| at.time_s >= case.start_s);
        after.map(|at| number(pick(at))).fold(0.0, f64::max)
    };
    let most = |pick: &dyn Fn(&Errors) -> f64| most_of(&errors, pick);
    let last_s = errors.last().map_or(f64::NEG_INFINITY, |at| at.time_s);
    let ends_early = normal.last().is_none_or(|at| at.time_s > last_s + 1.0);
    let is_lost = |at: &Errors| !all_below(at.sizes(), LOST);
    Measures {
        height_m: most(&|at| at.height_m),
        vertical_mps: most(&|at| at.velocity_mps[2]),
        horizontal_mps: most(&|at| at.velocity_mps[0].hypot(at.velocity_mps[1])),
        horizontal_sigmas: most(&|at| {
            let [north, east] = [0, 1].map(|axis| at.velocity_mps[axis] / at.sigma_mps[axis]);
            north.max(east)
        }),
        inside: share_inside(&errors, case),
        twin_inside: share_inside(&normal, case),
        twin_height_m: most_of(&normal, &|at| at.height_m),
        twin_vertical_mps: most_of(&normal, &|at| at.velocity_mps[2]),
        normal_after_s: normal_after_s(&errors, &normal, case.end_s()),
        bias: flown.bias(),
        diverged: flown.refused.is_none()
            && (ends_early || errors.iter().filter(|at| at.time_s >= last_s - END_S).any(is_lost)),
        refused: flown.refused.clone(),
        ignored: flown.ignored.saturating_sub(twin.ignored),
    }
}

fn reference_is_known(reference: &Reference, time_s: f64) -> bool {
    let moment = reference.at(hovernav::time::Time::ZERO + time_s);
    moment.velocity_mps.iter().chain(&moment.position).all(|number| number.is_finite())
}

/// Time from `end_s` until errors stay within `MARGIN` of the twin's, s.
fn normal_after_s(errors: &[Errors], normal: &[Errors], end_s: f64) -> f64 {
    let mut since_s: Option<f64> = None;
    let mut twins = normal.iter().peekable();
    for at in errors.iter().filter(|at| at.time_s >= end_s) {
        while twins.next_if(|twin| twin.time_s < at.time_s - 1e-6).is_some() {}
        let Some(twin) = twins.peek() else { break };
        let mut limits = twin.sizes();
        limits.iter_mut().zip(MARGIN).for_each(|(limit, margin)| *limit += margin);
        if !all_below(at.sizes(), limits) {
            since_s = None;
            continue;
        }
        let since_s = *since_s.get_or_insert(at.time_s);
        if at.time_s - since_s >= STAYS_S {
            return since_s - end_s;
        }
    }
    f64::INFINITY
}
