//! Bias steps of the gyros relative to the inertial unit's own attitude. Bias steps of the accelerometers relative to
//! that attitude and the fixes' velocity.

use hovernav::ekf::{Notice, Solution, Unusable};
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector};
use hovernav::time::Time;

use super::judged::Judged;
use crate::finding::{Finding, FindingKind, Sensor};
use crate::rates::Rates;
use hovernav_dataset::statistics::quantile;

/// Time over which a bias is averaged, s.
const MEAN_S: f64 = 10.0;
/// Turn rate beyond which the inertial unit's own attitude lags, rad/s.
const TURNING_RADPS: f64 = 0.2;
/// Time after which a filter with enlarged bias uncertainty has estimated its biases again, s.
const ABSORBED_S: f64 = 15.0;
/// Number of means on either side of a step that are compared.
const SIDE: usize = 3;
/// Largest number of means near a step in which the inertial unit's own attitude may disagree with the gyros. A real
/// step causes such a disagreement.
const MAX_REJECTED: usize = 2;
/// Smallest step, in multiples of the usual change between means.
const UNUSUAL: f64 = 6.0;
/// Smallest step of a gyro's bias that is reported, rad/s.
const MIN_GYRO: f64 = 0.002;
/// Smallest step of an accelerometer's bias that is reported, m/s².
const MIN_ACCEL: f64 = 0.12;
/// Smallest lasting step of a gyro's bias that the filter has estimated, rad/s; a smaller one may be an initial bias
/// estimated late.
const MIN_LASTING_GYRO: f64 = 0.0035;
/// Smallest lasting step of an accelerometer's bias that the filter has estimated, m/s²: five one-sigmas of its initial
/// bias.
const MIN_LASTING_ACCEL: f64 = 0.25;
/// Smallest fraction of a step by which the filter's own bias must follow. The inertial unit's own attitude drifts,
/// which looks like a step among few means. Inserted steps have 0.39 and more, simulated flights without a step 0.14
/// and less.
const FOLLOWED: f64 = 0.35;
/// Span before a step over which the filter's bias is averaged, s from the step.
const BEFORE_S: [f64; 2] = [-12.0, -5.0];
/// Span after a step over which the filter's bias is averaged, s from the step.
const AFTER_S: [f64; 2] = [15.0, 30.0];
const GRAVITY_MPS2: f64 = 9.807;

/// Mean difference between a sensor and its references over [`MEAN_S`].
struct Excess {
    start_s: f64,
    values: [f64; 3],
    /// Mean turn rate, rad/s.
    turn_radps: f64,
}

pub(super) fn find(log: &Judged<'_>, witness: Witness, findings: &mut Vec<Finding>) {
    let rejected_s = rejected_s(log);
    let is_witness = &|near: &[Excess]| {
        let is_denied = |part: &&Excess| {
            let first = rejected_s.partition_point(|&time_s| time_s < part.start_s);
            rejected_s.get(first).is_some_and(|&time_s| time_s < part.start_s + MEAN_S)
        };
        near.iter().all(|part| part.turn_radps < TURNING_RADPS)
            && near.iter().filter(is_denied).count() <= MAX_REJECTED
    };
    let [turns, forces] = witness.finish(log);
    let degps = ("°/s", 180.0 / std::f64::consts::PI);
    let of_gyro = |solution: &Solution| solution.gyro_bias_radps;
    let followed = |axis, time_s, change| follows(log, of_gyro, axis, time_s, change);
    step(&turns, is_witness, "gyro", MIN_GYRO, degps, followed, findings);
    let mps2 = ("m/s²", 1.0);
    let of_accel = |solution: &Solution| solution.accel_bias_mps2;
    let followed = |axis, time_s, change| follows(log, of_accel, axis, time_s, change);
    step(&forces, is_witness, "accelerometer", MIN_ACCEL, mps2, followed, findings);
    absorbed(log, findings);
}

/// Times at which the inertial unit's own attitude disagreed with the gyros, s.
fn rejected_s(log: &Judged<'_>) -> Vec<f64> {
    let rejected = log.run.notices.iter().filter_map(|notice| match notice {
        Notice::NotUsed { time, reason: Unusable::InconsistentWithGyros, .. } => {
            Some(time.seconds())
        }
        _ => None,
    });
    rejected.collect()
}

/// Differences of the sensors from the inertial unit's own attitude and from the fixes, averaged over intervals of
/// [`MEAN_S`].
#[derive(Default)]
pub(super) struct Witness {
    part: Vec<Rates>,
    attitude: Vec<Option<Rotation<Body, Ned>>>,
    turns: Vec<Excess>,
    forces: Vec<Excess>,
}

impl Witness {
    pub fn push(&mut self, log: &Judged<'_>, at: &Rates, attitude: Option<EulerAngles>) {
        if self.part.first().is_some_and(|first| at.time - first.time >= MEAN_S) {
            self.close(log);
        }
        self.part.push(*at);
        self.attitude.push(attitude.map(Rotation::from_euler));
    }

    /// Ends the current averaging interval; an incomplete one is dropped.
    fn close(&mut self, log: &Judged<'_>) {
        let Self { part, attitude, .. } = self;
        if let [first, .., last] = &part[..]
            && last.time - first.time > 0.9 * MEAN_S
            && part.windows(2).all(|pair| pair[1].time - pair[0].time < 0.3)
        {
            let turns = part.iter().map(|at| Vector::<Body>::from(at.turn_radps).norm());
            let turn_radps = turns.sum::<f64>() / part.len() as f64;
            let start_s = first.time.seconds();
            let of = |values| Excess { start_s, values, turn_radps };
            self.turns.extend(turn_excess(part, attitude).map(of));
            self.forces.extend(force_excess(log, part, attitude).map(of));
        }
        self.part.clear();
        self.attitude.clear();
    }

    /// Differences of the gyros and of the accelerometers.
    fn finish(mut self, log: &Judged<'_>) -> [Vec<Excess>; 2] {
        self.close(log);
        [self.turns, self.forces]
    }
}

/// Mean difference of the gyro rates from those of the inertial unit's own attitude, rad/s.
fn turn_excess(part: &[Rates], attitude: &[Option<Rotation<Body, Ned>>]) -> Option<[f64; 3]> {
    let mut excess = [0.0; 3];
    let length_s = part.last()?.time - part.first()?.time;
    for (index, pair) in part.windows(2).enumerate() {
        let (from, to) = ((*attitude.get(index)?)?, (*attitude.get(index + 1)?)?);
        let turned = (from.inverse() * to).rotation_vector().to_array();
        let interval_s = pair[1].time - pair[0].time;
        for axis in 0..3 {
            let gyro = 0.5 * (pair[0].turn_radps[axis] + pair[1].turn_radps[axis]) * interval_s;
            excess[axis] += (gyro - turned[axis]) / length_s;
        }
    }
    Some(excess)
}

/// Mean difference of the specific force from that of gravity and the fixes' velocity changes, m/s², body axes. The
/// attitude is applied between successive fixes, because the acceleration of a circling vehicle keeps turning.
fn force_excess(
    log: &Judged<'_>,
    part: &[Rates],
    attitude: &[Option<Rotation<Body, Ned>>],
) -> Option<[f64; 3]> {
    let (start, end) = (part.first()?.time, part.last()?.time);
    let fixes = &log.dataset.fixes;
    let first = fixes.partition_point(|fix| fix.time < start);
    let (mut excess, mut covered_s, mut index) = (Vector::<Body>::ZERO, 0.0, 0);
    for pair in fixes[first..].windows(2).take_while(|pair| pair[1].time <= end) {
        let interval_s = pair[1].time - pair[0].time;
        let change_mps = pair[1].velocity_mps()? - pair[0].velocity_mps()?;
        let (mut force_integral_mps, mut force_integral_s, mut last) =
            (Vector::<Ned>::ZERO, 0.0, None);
        while let Some(at) = part.get(index).filter(|at| at.time <= pair[1].time) {
            if at.time > pair[0].time {
                let body_to_ned = (*attitude.get(index)?)?;
                force_integral_mps += body_to_ned * Vector::from(at.force_mps2) * at.interval_s;
                force_integral_s += at.interval_s;
                last = Some(body_to_ned);
            }
            index += 1;
        }
        let Some(body_to_ned) = last else { continue };
        if !(0.5..2.0).contains(&(force_integral_s / interval_s)) {
            continue;
        }
        let expected_mps = change_mps - Vector::new(0.0, 0.0, GRAVITY_MPS2) * force_integral_s;
        excess += body_to_ned.inverse() * (force_integral_mps - expected_mps);
        covered_s += force_integral_s;
    }
    (covered_s > 0.5 * MEAN_S).then(|| (excess * (1.0 / covered_s)).to_array())
}

/// Adds the steps that the filter has estimated, according to its biases within [`ABSORBED_S`].
fn absorbed(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let at = |time_s: f64| log.solution_at(time_s);
    let mut told_s = f64::NEG_INFINITY;
    for report in log.run.reports().filter(|report| report.bias_variance_was_raised()) {
        let Some(time_s) = report.time().map(Time::seconds) else { continue };
        let (Some(before), Some(after), Some(later)) =
            (at(time_s - 0.5), at(time_s + ABSORBED_S), at(time_s + 2.0 * ABSORBED_S))
        else {
            continue;
        };
        let known = findings.iter().any(|finding| {
            finding.kind == FindingKind::BiasStep
                && (finding.start_s..=finding.end_s).contains(&time_s)
        });
        if known || time_s - told_s < ABSORBED_S {
            continue;
        }
        // A bias change caused by a turn reverses later; a step stays.
        let lasting = |after: [f64; 3], later: [f64; 3], least: f64| {
            std::array::from_fn(|axis| {
                let (change, stays): (f64, f64) = (after[axis], later[axis]);
                let lasts = change.abs() > least && stays.abs() > least && change * stays > 0.0;
                lasts.then_some(stays)
            })
        };
        let gyro: [Option<f64>; 3] = lasting(
            (after.gyro_bias_radps - before.gyro_bias_radps).to_array(),
            (later.gyro_bias_radps - before.gyro_bias_radps).to_array(),
            MIN_LASTING_GYRO,
        );
        let accel: [Option<f64>; 3] = lasting(
            (after.accel_bias_mps2 - before.accel_bias_mps2).to_array(),
            (later.accel_bias_mps2 - before.accel_bias_mps2).to_array(),
            MIN_LASTING_ACCEL,
        );
        let mut named = Vec::new();
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            named.extend(gyro[axis].map(|by| format!("gyro {name} {:+.2} °/s", by.to_degrees())));
            named.extend(accel[axis].map(|by| format!("accelerometer {name} {by:+.2} m/s²")));
        }
        if named.is_empty() {
            continue;
        }
        told_s = time_s;
        let words = format!(
            "inertial unit: bias stepped before {time_s:.0} s according to the fixes ({}): a sensor fault or a \
             temperature change; the filter has estimated the new bias",
            named.join(", ")
        );
        findings.push(Finding::warning(
            Sensor::InertialUnit,
            FindingKind::BiasStep,
            (time_s, time_s + ABSORBED_S),
            words,
        ));
    }
}

/// Whether the filter's own bias, read by `of`, follows a step of `change` at `time_s`.
fn follows(
    log: &Judged<'_>,
    of: fn(&Solution) -> Vector<Body>,
    axis: usize,
    time_s: f64,
    change: f64,
) -> bool {
    let mean = |[from_s, to_s]: [f64; 2]| {
        let span_s = time_s + from_s..time_s + to_s;
        let within =
            log.run.solutions.iter().filter(|solution| span_s.contains(&solution.time.seconds()));
        let (sum, count) = within.fold((0.0, 0.0), |(sum, count), solution| {
            (sum + of(solution).to_array()[axis], count + 1.0)
        });
        sum / count
    };
    // NaN without solutions, which compares as false.
    (mean(AFTER_S) - mean(BEFORE_S)) / change > FOLLOWED
}

fn step(
    means: &[Excess],
    is_witness: impl Fn(&[Excess]) -> bool,
    what: &str,
    least: f64,
    (unit, scale): (&str, f64),
    is_followed: impl Fn(usize, f64, f64) -> bool,
    findings: &mut Vec<Finding>,
) {
    let side = |of: &[Excess], axis: usize| {
        of.iter().map(|mean| mean.values[axis]).sum::<f64>() / of.len() as f64
    };
    for axis in 0..3 {
        let changes: Vec<(f64, f64)> = means
            .windows(2 * SIDE)
            .filter(|near| is_witness(near))
            .map(|near| {
                let (before, after) = near.split_at(SIDE);
                (after[0].start_s, side(after, axis) - side(before, axis))
            })
            .collect();
        let mut sizes: Vec<f64> = changes.iter().map(|(_, change)| change.abs()).collect();
        let usual = quantile(&mut sizes, 0.5).unwrap_or(f64::INFINITY);
        let largest = changes.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        let Some(&(time_s, change)) =
            largest.filter(|(_, change)| change.abs() > least && change.abs() > UNUSUAL * usual)
        else {
            continue;
        };
        if !is_followed(axis, time_s, change) {
            continue;
        }
        let words = format!(
            "{what} bias of axis {} stepped by {:.2} {unit} at about {time_s:.0} s, according to the unit's own \
             attitude and the fixes: a sensor fault or a temperature change",
            ["x", "y", "z"][axis],
            change * scale
        );
        findings.push(Finding::warning(
            Sensor::InertialUnit,
            FindingKind::BiasStep,
            (time_s - MEAN_S, time_s + MEAN_S),
            words,
        ));
    }
}
