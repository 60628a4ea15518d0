//! Steps of a bias that the unit's own attitude witnesses, with the fixes' velocity for the
//! accelerometers.

use hovernav::ekf::{Notice, Solution, Unusable};
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector};

use super::Judged;
use crate::finding::{Finding, FindingKind, Sensor, Severity};
use crate::rates::Rates;
use crate::statistics::quantile;

/// Over how long a bias is averaged, s.
const MEAN_S: f64 = 10.0;
/// A unit's own attitude lags in faster turns, rad/s.
const TURNING_RADPS: f64 = 0.2;
/// A filter that has opened its biases knows them after so long, s.
const ABSORBED_S: f64 = 15.0;
/// Means on either side of a step.
const SIDE: usize = 3;
/// Parts near a step in which the attitude may turn otherwise than the gyros: with them, as a step itself makes it.
const MOST_DENIED: usize = 2;
/// A step is so many times what the means usually change by.
const UNUSUAL: f64 = 6.0;
/// Smaller steps cost little: rad/s and m/s².
const LEAST_GYRO: f64 = 0.002;
const LEAST_ACCEL: f64 = 0.12;
/// Of a step that the filter took in; less may be how the bias was from the start, of which the filter has
/// learned late: five one-sigmas of the accelerometers' bias.
const LEAST_LASTING_GYRO: f64 = 0.0035;
const LEAST_LASTING_ACCEL: f64 = 0.25;
/// The unit's own attitude wanders, which looks like a step where there are few means: the filter's own bias has to follow
/// by this share (0.39 and more of steps that were put in, 0.14 and less of simulated flights without any).
const FOLLOWED: f64 = 0.35;
/// From when to when, s after a step, the filter's bias is averaged before it and after it.
const BEFORE_S: [f64; 2] = [-12.0, -5.0];
const AFTER_S: [f64; 2] = [15.0, 30.0];
const GRAVITY_MPS2: f64 = 9.807;

/// What the sensors read beyond what their witnesses say, averaged.
struct Excess {
    start_s: f64,
    values: [f64; 3],
    /// Mean rate of turn, rad/s.
    turn_radps: f64,
}

pub(super) fn find(log: &Judged<'_>, witness: Witness, findings: &mut Vec<Finding>) {
    let denied_s = denied_s(log);
    let is_witness = &|near: &[Excess]| {
        let is_denied = |part: &&Excess| {
            let first = denied_s.partition_point(|&time_s| time_s < part.start_s);
            denied_s.get(first).is_some_and(|&time_s| time_s < part.start_s + MEAN_S)
        };
        near.iter().all(|part| part.turn_radps < TURNING_RADPS)
            && near.iter().filter(is_denied).count() <= MOST_DENIED
    };
    let [turns, forces] = witness.finish(log);
    let degps = ("°/s", 180.0 / std::f64::consts::PI);
    let of_gyro = |solution: &Solution| solution.gyro_bias_radps;
    let followed = |axis, time_s, change| follows(log, of_gyro, axis, time_s, change);
    step(&turns, is_witness, "gyro", LEAST_GYRO, degps, followed, findings);
    let mps2 = ("m/s²", 1.0);
    let of_accel = |solution: &Solution| solution.accel_bias_mps2;
    let followed = |axis, time_s, change| follows(log, of_accel, axis, time_s, change);
    step(&forces, is_witness, "accelerometer", LEAST_ACCEL, mps2, followed, findings);
    absorbed(log, findings);
}

/// When the unit's own attitude turned otherwise than the gyros, s.
fn denied_s(log: &Judged<'_>) -> Vec<f64> {
    let denied = log.run.notices.iter().filter_map(|notice| match notice {
        Notice::NotUsed { time, reason: Unusable::TurnsOtherwise, .. } => Some(time.seconds()),
        _ => None,
    });
    denied.collect()
}

/// What the unit's own attitude and the fixes bear witness to, part by part of [`MEAN_S`].
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

    /// Ends a part, which counts if it is whole.
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

    /// Of turns and of forces.
    fn finish(mut self, log: &Judged<'_>) -> [Vec<Excess>; 2] {
        self.close(log);
        [self.turns, self.forces]
    }
}

/// Mean of gyro rates less those of the unit's own attitude.
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

/// Mean of specific force, less what gravity and the fixes' velocity say from fix to fix, turned by the
/// unit's own attitude: a vehicle that circles accelerates to another side every second.
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
        let (mut felt_mps, mut felt_s, mut last) = (Vector::<Ned>::ZERO, 0.0, None);
        while let Some(at) = part.get(index).filter(|at| at.time <= pair[1].time) {
            if at.time > pair[0].time {
                let body_to_ned = (*attitude.get(index)?)?;
                felt_mps += body_to_ned * Vector::from(at.force_mps2) * at.interval_s;
                felt_s += at.interval_s;
                last = Some(body_to_ned);
            }
            index += 1;
        }
        let Some(body_to_ned) = last else { continue };
        if !(0.5..2.0).contains(&(felt_s / interval_s)) {
            continue;
        }
        let expected_mps = change_mps - Vector::new(0.0, 0.0, GRAVITY_MPS2) * felt_s;
        excess += body_to_ned.inverse() * (felt_mps - expected_mps);
        covered_s += felt_s;
    }
    (covered_s > 0.5 * MEAN_S).then(|| (excess * (1.0 / covered_s)).to_array())
}

/// Steps that the filter took in, by what its biases became within [`ABSORBED_S`].
fn absorbed(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let solutions = &log.run.solutions;
    let at = |time_s: f64| {
        let index = solutions.partition_point(|solution| solution.time.seconds() < time_s);
        solutions.get(index)
    };
    let mut told_s = f64::NEG_INFINITY;
    for notice in &log.run.notices {
        let Notice::Updated(report) = notice else { continue };
        let Some(axis) = report.innovations().next().filter(|_| report.biases_were_doubted())
        else {
            continue;
        };
        let time_s = axis.time.seconds();
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
        // What a turn brings about goes again; a step stays.
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
            LEAST_LASTING_GYRO,
        );
        let accel: [Option<f64>; 3] = lasting(
            (after.accel_bias_mps2 - before.accel_bias_mps2).to_array(),
            (later.accel_bias_mps2 - before.accel_bias_mps2).to_array(),
            LEAST_LASTING_ACCEL,
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
        findings.push(Finding {
            start_s: time_s,
            end_s: time_s + ABSORBED_S,
            sensor: Sensor::InertialUnit,
            kind: FindingKind::BiasStep,
            severity: Severity::Warning,
            count: 1,
            words: format!(
                "inertial unit: bias stepped before {time_s:.0} s, as the fixes witness ({}): a fault of the \
                 sensor, or a change of its temperature; the filter took it in",
                named.join(", ")
            ),
        });
    }
}

/// Whether the filter's own bias, which `of` gives, follows a step by `change` at `time_s`.
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
    // Not a number where there are no solutions.
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
        findings.push(Finding {
            start_s: time_s - MEAN_S,
            end_s: time_s + MEAN_S,
            sensor: Sensor::InertialUnit,
            kind: FindingKind::BiasStep,
            severity: Severity::Warning,
            count: 1,
            words: format!(
                "{what} bias of axis {} stepped by {:.2} {unit} at about {time_s:.0} s, as the unit's own \
                 attitude and the fixes witness: a fault of the sensor, or a change of its temperature",
                ["x", "y", "z"][axis],
                change * scale
            ),
        });
    }
}
