//! Time offset between inertial samples and fixes: comparison of their horizontal accelerations.
//!
//! The attitude is that of gyros and accelerometers alone, so that a clock error which makes a filter diverge does not
//! disturb the search. Its heading is arbitrary and drifts: every [`WINDOW`] changes have their own rotation.

use hovernav::earth::STANDARD_GRAVITY_MPS2;
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector};
use hovernav::gps::Fix;
use hovernav_dataset::LONGEST_LATENCY_S;

use crate::limits::DRIFTED_S;
use crate::plausibility::Scale;
use crate::rates::Rates;

/// Coarse step of the search, s.
const COARSE_S: f64 = 0.1;
/// Fine step of the search, s.
const FINE_S: f64 = 0.01;
/// Distance from the best delay, s, beyond which a delay is a separate candidate.
const NEAR_S: f64 = 2.0;
/// Interval between stored velocities, s.
const STEP_S: f64 = 0.04;
/// Interval between the compared velocities, s. Second differences cancel the effect of an attitude error that lasts
/// longer.
const OVER_S: f64 = 1.0;
/// Longest interval between fixes that are compared, s.
const LONGEST_S: f64 = 2.5;
/// Number of velocity changes with one rotation.
const WINDOW: usize = 60;
/// Number of velocity changes in a part of the flight. The delays of the parts are compared.
const PART: usize = 40;
/// Smallest number of parts that can show a growing delay.
const MIN_PARTS: usize = 3;
/// Smallest growth of the delay over the flight, in multiples of the delays' rms distance from the fitted line.
const OFF_LINE: f64 = 5.0;
/// Smallest additional fraction of the velocity changes that a growing delay must explain, compared with a constant
/// delay.
const DRIFT_EXPLAINS: f64 = 0.05;
/// Longest interval between samples, s, over which the velocity change is known.
const GAP_S: f64 = 0.3;
/// Longest section of a flight that is used, s.
const LOOKED_S: f64 = 3600.0;
/// Smallest number of velocity changes to be compared.
const MIN_CHANGES: usize = 30;
/// Smallest rms of the velocity changes, m/s, from which a delay is estimated.
const MIN_MPS: f64 = 0.25;
/// Smallest fraction of the velocity changes that the best delay must explain.
const MIN_EXPLAINED: f64 = 0.1;
/// Fraction of the velocity changes that is sufficient for any number of them.
const WELL_EXPLAINED: f64 = 0.5;
/// Number of explained velocity changes that is sufficient for a smaller fraction. Of 120 random changes, the best
/// delay explains up to 25.
const MANY_EXPLAINED: f64 = 40.0;
/// Largest fraction explained by a distant delay, relative to the best one.
const DISTANT: f64 = 0.5;
/// Largest fraction explained without delay, relative to the best one.
const UNDELAYED: f64 = 0.8;
/// Time in which the accelerometers correct the attitude of the gyros, s.
const SETTLING_S: f64 = 20.0;

/// Horizontal velocity, up to a constant: integral of the measured specific force, levelled by gyros and gravity.
#[derive(Default)]
pub(super) struct MeasuredVelocity {
    moments: Vec<Moment>,
    /// For each interval of [`STEP_S`], number of moments before it, from the first moment's interval to the last
    /// one's.
    earlier: Vec<usize>,
    sum_mps: [f64; 2],
    gaps: u32,
    attitude: Option<Levelled>,
}

/// Velocity from the specific force at one time.
#[derive(Clone, Copy)]
struct Moment {
    time_s: f64,
    horizontal_mps: [f64; 2],
    /// Number of gaps before this time.
    gaps: u32,
}

impl MeasuredVelocity {
    pub fn push(&mut self, rates: &Rates) {
        let (time_s, interval_s) = (rates.time.seconds(), rates.interval_s);
        if self.moments.first().is_some_and(|first| time_s - first.time_s >= LOOKED_S) {
            return;
        }
        let force_mps2 = Vector::from(rates.force_mps2);
        if interval_s > GAP_S {
            self.gaps += 1;
            self.attitude = None;
        }
        let attitude = self.attitude.get_or_insert_with(|| Levelled::of(force_mps2));
        let levelled_mps2 = attitude.push(rates.turn_radps.into(), force_mps2, interval_s);
        let [x, y, _] = (levelled_mps2 * interval_s).to_array();
        self.sum_mps = [self.sum_mps[0] + x, self.sum_mps[1] + y];
        let is_due = self.moments.last().is_none_or(|last| time_s - last.time_s >= STEP_S);
        if is_due {
            let Self { sum_mps: horizontal_mps, gaps, .. } = *self;
            let first_s = self.moments.first().map_or(time_s, |first| first.time_s);
            let count = self.moments.len();
            self.earlier.resize(interval(time_s - first_s) + 1, count);
            self.moments.push(Moment { time_s, horizontal_mps, gaps });
        }
    }

    /// Growth of the fixes' delay, s per s; `None` if successive parts of the flight do not show it clearly. A growing
    /// delay shows that the clocks of samples and fixes run at different rates.
    pub fn drift(&self, reported: &[Change]) -> Option<f64> {
        let parts: Vec<[f64; 2]> = reported
            .chunks(PART)
            .filter_map(|part| Some([centre_s(part), self.plain_delay_s(part)?.0]))
            .collect();
        if parts.len() < MIN_PARTS {
            return None;
        }
        let count = parts.len() as f64;
        let [time_s, delay_s] =
            [0, 1].map(|which| parts.iter().map(|at| at[which]).sum::<f64>() / count);
        let about: Vec<(f64, f64)> =
            parts.iter().map(|[at_s, at_delay_s]| (at_s - time_s, at_delay_s - delay_s)).collect();
        let drift = Scale::of(&about)?.scale;
        // The fitted line has two parameters.
        let off_s = (about.iter().map(|(t, d)| (d - drift * t).powi(2)).sum::<f64>()
            / (count - 2.0))
            .sqrt();
        let grown_s = drift.abs() * (parts.last()?[0] - parts.first()?[0]);
        let along = |at_s: f64| delay_s + drift * (at_s - time_s);
        let [growing, steady] =
            [self.explained(reported, along), self.explained(reported, |_| delay_s)]
                .map(|found| found.map_or(0.0, |found| found.fraction));
        let is_plain =
            growing > steady + DRIFT_EXPLAINS && grown_s > DRIFTED_S.max(OFF_LINE * off_s);
        is_plain.then_some(drift)
    }

    /// Time by which the fixes are valid earlier than the declared latency states, s; `None` if it is not significant.
    pub fn delay_s(&self, reported: &[Change]) -> Option<f64> {
        let (delay_s, fraction) = self.plain_delay_s(reported)?;
        let undelayed = self.explained(reported, |_| 0.0).map_or(0.0, |found| found.fraction);
        (undelayed <= UNDELAYED * fraction).then_some(delay_s)
    }

    /// Delay that explains the largest fraction of the changes `reported` by the fixes, s, and that fraction. `None` if
    /// a distant delay explains about as much.
    fn plain_delay_s(&self, reported: &[Change]) -> Option<(f64, f64)> {
        let fraction = |delay_s: f64| {
            self.explained(reported, |_| delay_s).map_or(0.0, |found| found.fraction)
        };
        let steps = (LONGEST_LATENCY_S / COARSE_S) as i32;
        let tried: Vec<(f64, f64)> = (-steps..=steps)
            .map(|step| COARSE_S * f64::from(step))
            .map(|delay_s| (delay_s, fraction(delay_s)))
            .collect();
        let (coarse_s, most) = tried.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let distant = tried.iter().filter(|(delay_s, _)| (delay_s - coarse_s).abs() > NEAR_S);
        let distant = distant.map(|(_, fraction)| *fraction).fold(0.0, f64::max);
        let Explained { count, .. } = self.explained(reported, |_| coarse_s)?;
        let is_enough = most > WELL_EXPLAINED || most * count > MANY_EXPLAINED;
        if most < MIN_EXPLAINED || !is_enough || distant > DISTANT * most {
            return None;
        }
        let steps = (COARSE_S / FINE_S) as i32;
        let fine_s = (-steps..=steps)
            .map(|step| coarse_s + FINE_S * f64::from(step))
            .max_by(|a, b| fraction(*a).total_cmp(&fraction(*b)))?;
        Some((fine_s, most))
    }

    /// Part of the changes `reported` by the fixes that the measured changes `delay_s` earlier explain. The measured
    /// changes of a window are rotated by one angle, the one that fits best.
    pub fn explained(
        &self,
        reported: &[Change],
        delay_s: impl Fn(f64) -> f64,
    ) -> Option<Explained> {
        // Successive changes share two of their three times.
        let mut last = [(f64::NAN, None); 3];
        let (mut common, mut squares, mut count) = (0.0, [0.0; 2], 0);
        for window in reported.chunks(WINDOW) {
            let (mut along, mut across) = (0.0, 0.0);
            for change in window {
                last = change.times_s.map(|time_s| {
                    let known = last.iter().find(|(last_s, _)| *last_s == time_s);
                    known.copied().unwrap_or_else(|| (time_s, self.at(time_s - delay_s(time_s))))
                });
                let [Some(start), Some(middle), Some(end)] = last.map(|(_, moment)| moment) else {
                    continue;
                };
                let Some(a) = Self::change([start, middle, end]) else { continue };
                let b = change.horizontal_mps;
                along += a[0] * b[0] + a[1] * b[1];
                across += a[0] * b[1] - a[1] * b[0];
                let added = [a, b].map(|[x, y]| x * x + y * y);
                squares = [squares[0] + added[0], squares[1] + added[1]];
                count += 1;
            }
            common += f64::hypot(along, across);
        }
        let moves = squares.iter().all(|sum| sum / f64::from(count) > MIN_MPS.powi(2));
        let is_known = count as usize >= MIN_CHANGES && moves;
        is_known.then(|| Explained {
            fraction: common.powi(2) / (squares[0] * squares[1]),
            count: f64::from(count),
        })
    }

    fn change(moments: [Moment; 3]) -> Option<[f64; 2]> {
        let [start, _, end] = moments;
        let velocities = moments.map(|moment| moment.horizontal_mps);
        (start.gaps == end.gaps).then(|| second_difference(velocities))
    }

    fn at(&self, time_s: f64) -> Option<Moment> {
        let earlier = *self.earlier.get(interval(time_s - self.moments.first()?.time_s))?;
        let within = self.moments[earlier..].iter().take_while(|moment| moment.time_s < time_s);
        let after = earlier + within.count();
        let (from, to) = (self.moments.get(after.checked_sub(1)?)?, self.moments.get(after)?);
        let share = (time_s - from.time_s) / (to.time_s - from.time_s);
        let between = |axis: usize| {
            let [from, to] = [from, to].map(|moment| moment.horizontal_mps[axis]);
            from + share * (to - from)
        };
        Some(Moment { time_s, horizontal_mps: [between(0), between(1)], gaps: to.gaps })
    }
}

/// Changes reported by the fixes that the inertial unit measured too.
pub(super) struct Explained {
    /// Explained fraction of the changes, 0 to 1.
    pub fraction: f64,
    /// Number of changes compared.
    count: f64,
}

/// Roll and pitch from gyros and gravity, with an arbitrary heading.
struct Levelled {
    body_to_level: Rotation<Body, Ned>,
    gyro_bias_radps: Vector<Body>,
    /// Time since the start, s.
    age_s: f64,
}

impl Levelled {
    /// Attitude in which `force_mps2` is vertical.
    fn of(force_mps2: Vector<Body>) -> Self {
        let [x, y, z] = force_mps2.to_array();
        let (roll_rad, pitch_rad) = (f64::atan2(-y, -z), f64::atan2(x, y.hypot(z)));
        let angles = EulerAngles { roll_rad, pitch_rad, yaw_rad: 0.0 };
        Self {
            body_to_level: Rotation::from_euler(angles),
            gyro_bias_radps: Vector::ZERO,
            age_s: 0.0,
        }
    }

    /// Adds a sample; the result is its specific force in level axes, m/s².
    fn push(
        &mut self,
        turn_radps: Vector<Body>,
        force_mps2: Vector<Body>,
        interval_s: f64,
    ) -> Vector<Ned> {
        self.age_s += interval_s;
        let turn_rad = (turn_radps - self.gyro_bias_radps) * interval_s;
        self.body_to_level = self.body_to_level.turned_in_from(turn_rad);
        let levelled_mps2 = self.body_to_level * force_mps2;
        let [x, y, _] = levelled_mps2.to_array();
        // Shocks correct no more than gravity does. At first the mean of few samples is the best estimate.
        let size_mps2 = levelled_mps2.norm().max(STANDARD_GRAVITY_MPS2);
        let off_rad = Vector::new(-y, x, 0.0) * (1.0 / size_mps2);
        let gain = 1.0 / (1.0 + self.age_s).min(SETTLING_S);
        self.body_to_level =
            self.body_to_level.turned_in_to(off_rad * (gain * interval_s)).renormalised();
        // Critical damping.
        let off_rad = self.body_to_level.inverse() * off_rad;
        let slow = (0.5 / SETTLING_S).powi(2);
        self.gyro_bias_radps -= off_rad * (slow * interval_s);
        levelled_mps2
    }
}

/// Index of the interval of [`STEP_S`] that contains the time `since_s` after the first moment; 0 before it.
fn interval(since_s: f64) -> usize {
    (since_s / STEP_S) as usize
}

/// Second difference of the horizontal velocity over three times.
pub(super) struct Change {
    times_s: [f64; 3],
    horizontal_mps: [f64; 2],
}

/// Mean time of the changes, weighted by their squares, s.
fn centre_s(changes: &[Change]) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for Change { times_s: [_, time_s, _], horizontal_mps: [x, y] } in changes {
        let weight = x * x + y * y;
        sum += weight * time_s;
        weights += weight;
    }
    sum / weights
}

fn second_difference([start, middle, end]: [[f64; 2]; 3]) -> [f64; 2] {
    [0, 1].map(|axis| end[axis] - 2.0 * middle[axis] + start[axis])
}

/// Changes of the velocity that the `fixes` report, otherwise that of their positions.
pub(super) fn reported_changes(fixes: &[Fix]) -> Vec<Change> {
    let mut due: Vec<&Fix> = Vec::new();
    let has_velocity = fixes.iter().any(|fix| fix.horizontal_velocity_mps.is_some());
    for fix in fixes {
        let is_due = due.last().is_none_or(|last| fix.time - last.time >= OVER_S - STEP_S);
        if is_due && (!has_velocity || fix.horizontal_velocity_mps.is_some()) {
            due.push(fix);
        }
    }
    let reported: Vec<(f64, [f64; 2])> = if has_velocity {
        due.iter()
            .filter_map(|fix| Some((fix.time.seconds(), fix.horizontal_velocity_mps?)))
            .collect()
    } else {
        due.windows(2).map(|pair| mean_velocity(pair[0], pair[1])).collect()
    };
    let changes = reported.windows(3).filter_map(|reported| {
        let &[start, middle, end] = reported else { return None };
        let is_near = (middle.0 - start.0).max(end.0 - middle.0) < LONGEST_S;
        is_near.then(|| Change {
            times_s: [start.0, middle.0, end.0],
            horizontal_mps: second_difference([start.1, middle.1, end.1]),
        })
    });
    changes.collect()
}

/// Mean horizontal velocity between two positions, at the time in the middle.
fn mean_velocity(from: &Fix, to: &Fix) -> (f64, [f64; 2]) {
    let over_s = to.time - from.time;
    let [north_m, east_m, _] = to.position.displacement_from(&from.position).to_array();
    (from.time.seconds() + 0.5 * over_s, [north_m / over_s, east_m / over_s])
}
