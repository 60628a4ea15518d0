//! Time offset of the fixes: comparison of their accelerations with those of the accelerometers.
//!
//! The filter estimates a time offset within its history, a few tenths of a second. This search reaches [`MAX_S`] and
//! uses only the attitude of the filter, whose heading may have any constant error.

use hovernav::frames::Vector;

use super::judged::Judged;
use crate::finding::{Finding, FindingKind, Sensor, Severity};
use crate::limits::DRIFTED_S;
use crate::plausibility::Scale;
use crate::rates::Rates;
use hovernav_dataset::LONGEST_LATENCY_S;
use hovernav_replay::FixTally;

/// Largest time offset of the fixes, s, that needs no declaration; a larger one is a warning.
const OFFSET_S: f64 = 0.1;
/// Range of the time offsets that the filter can estimate, s.
const FOLLOWED_S: std::ops::RangeInclusive<f64> = -0.28..=0.45;
/// Fraction of rejected fixes from which on the filter's estimate of the offset is not used.
const MANY_REJECTED: f64 = 0.1;
/// Smallest offset that is used if it comes from the accelerations, s.
const FAR_S: f64 = 0.25;
/// Difference from the filter's estimate, s, beyond which the offset according to the accelerations replaces it.
const AGREES_S: f64 = 0.1;
/// Largest delay of the search to either side, s: clocks may differ by the leap seconds.
const MAX_S: f64 = 25.0;
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
const MIN_MPS: f64 = 0.5;
/// Smallest fraction of the velocity changes that the best delay must explain.
const EXPLAINED: f64 = 0.5;
/// Smallest lead of the best delay over zero and over distant delays, in explained fraction.
const CLEARLY: f64 = 0.1;
/// Fraction of the velocity changes that the filter's offset must explain to be used.
const UNEXPLAINED: f64 = 0.1;
/// Lead of GPS time over UTC, s.
const LEAP_SECONDS: f64 = 18.0;

pub(super) fn find(log: &Judged<'_>, measured: &MeasuredVelocity, findings: &mut Vec<Finding>) {
    let Some((start_s, end_s)) = log.span_s() else { return };
    let declared_s = log.dataset.manifest.gps.latency_s;
    let FixTally { used, rejected } = log.run.fixes_compared;
    let reported = reported_changes(log);
    if let Some(drift) = measured.drift(&reported) {
        let percent = 100.0 * drift.abs();
        let fast = if drift < 0.0 { "fast" } else { "slow" };
        let words = format!(
            "inertial unit: its clock runs {percent:.2} % {fast} against the clock of the fixes, by their \
             accelerations: rates, forces and the times of all fixes are off; stamp samples with a correct clock, \
             not by counting them"
        );
        findings.push(Finding::warning(
            Sensor::InertialUnit,
            FindingKind::ClockRate,
            (start_s, end_s),
            words,
        ));
        // A growing delay cannot be declared.
        return;
    }
    // Without significant accelerations no offset is rejected.
    let is_unexplained = |offset_s: f64| {
        measured.explained(&reported, |_| offset_s).is_some_and(|share| share < UNEXPLAINED)
    };
    let is_trusted = |offset_s: f64| {
        FOLLOWED_S.contains(&offset_s)
            && (rejected as f64) < MANY_REJECTED * (used + rejected) as f64
            && !is_unexplained(offset_s)
    };
    let own_s = log.run.gps_offset.map(|(offset_s, _)| offset_s).filter(|&own_s| is_trusted(own_s));
    let far_s = measured.delay_s(&reported).filter(|far_s| {
        far_s.abs() > FAR_S && own_s.is_none_or(|own_s| (far_s - own_s).abs() > AGREES_S)
    });
    let side = |offset_s: f64| {
        let found_s = declared_s + offset_s;
        let side = if found_s >= 0.0 { "earlier" } else { "later" };
        format!("{:.3} s {side} than their time stamps", found_s.abs())
    };
    let declared = format!("declared latency {declared_s:.3} s");
    let mend = |offset_s: f64| {
        let latency_s = declared_s + offset_s;
        if latency_s.abs() < LONGEST_LATENCY_S {
            return format!("; set [gps] latency_s = {latency_s:.2}");
        }
        let is_utc = (latency_s.abs() - LEAP_SECONDS).abs() < 1.0;
        let cause = if is_utc { ": GPS time is 18 s ahead of UTC" } else { "" };
        format!("; stamp fixes and samples by one clock{cause}")
    };
    let (is_off, what) = if let Some(far_s) = far_s {
        let how = "by the vehicle's accelerations";
        (true, format!("fixes are valid {} ({how}), {declared}{}", side(far_s), mend(far_s)))
    } else if let Some((offset_s, sigma_s)) = log.run.gps_offset {
        let is_off = offset_s.abs() > OFFSET_S && offset_s.abs() > 4.0 * sigma_s;
        let side = side(offset_s);
        let what = if is_off && !is_trusted(offset_s) {
            format!(
                "fixes may be valid at other times than their time stamps: the filter found {side}, {declared}, which \
                 is beyond its range, or from fixes of which it rejected many; check the clocks"
            )
        } else {
            let mend = if is_off { mend(offset_s) } else { String::new() };
            format!("fixes are valid {side} (one-sigma {sigma_s:.3} s), {declared}{mend}")
        };
        (is_off, what)
    } else {
        return;
    };
    findings.push(
        Finding::warning(
            Sensor::Gps,
            FindingKind::TimeOffset,
            (start_s, end_s),
            format!("gps time offset: {what}"),
        )
        .severity(if is_off { Severity::Warning } else { Severity::Info }),
    );
}

/// Horizontal velocity, up to a constant: integral of the measured specific force in the attitude of a run.
#[derive(Default)]
pub(super) struct MeasuredVelocity {
    moments: Vec<Moment>,
    /// For each interval of [`STEP_S`], number of moments before it, from the first moment's interval to the last
    /// one's.
    earlier: Vec<usize>,
    sum_mps: [f64; 2],
    gaps: u32,
    /// Index of the latest solution used.
    index: usize,
}

/// Velocity from the specific force at one time.
#[derive(Clone, Copy)]
struct Moment {
    time_s: f64,
    north_east_mps: [f64; 2],
    /// Number of gaps before this time.
    gaps: u32,
}

impl MeasuredVelocity {
    pub fn push(&mut self, log: &Judged<'_>, rates: &Rates) {
        let time_s = rates.time.seconds();
        if self.moments.first().is_some_and(|first| time_s - first.time_s >= LOOKED_S) {
            return;
        }
        let (time, solutions) = (rates.time, &log.run.solutions);
        while solutions.get(self.index + 1).is_some_and(|next| next.time <= time) {
            self.index += 1;
        }
        let Some(solution) = solutions.get(self.index).filter(|solution| solution.time <= time)
        else {
            return;
        };
        let force = solution.body_to_ned * Vector::from(rates.force_mps2);
        let [north, east, _] = (force * rates.interval_s).to_array();
        self.sum_mps = [self.sum_mps[0] + north, self.sum_mps[1] + east];
        self.gaps += u32::from(rates.interval_s > GAP_S || time - solution.time > GAP_S);
        let is_due = self.moments.last().is_none_or(|last| time_s - last.time_s >= STEP_S);
        if is_due {
            let Self { sum_mps: north_east_mps, gaps, .. } = *self;
            let first_s = self.moments.first().map_or(time_s, |first| first.time_s);
            let count = self.moments.len();
            self.earlier.resize(interval(time_s - first_s) + 1, count);
            self.moments.push(Moment { time_s, north_east_mps, gaps });
        }
    }

    /// Growth of the fixes' delay, s per s; `None` if successive parts of the flight do not show it clearly. A growing
    /// delay shows that the clocks of samples and fixes run at different rates.
    fn drift(&self, reported: &[Change]) -> Option<f64> {
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
                .map(Option::unwrap_or_default);
        let is_plain = growing > EXPLAINED.max(steady + DRIFT_EXPLAINS)
            && grown_s > DRIFTED_S.max(OFF_LINE * off_s);
        is_plain.then_some(drift)
    }

    /// Time by which the fixes are valid earlier than the declared latency states, s; `None` if it is not significant.
    fn delay_s(&self, reported: &[Change]) -> Option<f64> {
        let (delay_s, explained) = self.plain_delay_s(reported)?;
        let now = self.explained(reported, |_| 0.0).unwrap_or(0.0);
        (now <= explained - CLEARLY).then_some(delay_s)
    }

    /// Delay that explains the largest fraction of the changes `reported` by the fixes, s, and that fraction. `None` if
    /// a distant delay explains about as much.
    fn plain_delay_s(&self, reported: &[Change]) -> Option<(f64, f64)> {
        let explained = |delay_s: f64| self.explained(reported, |_| delay_s).unwrap_or(0.0);
        let steps = (MAX_S / COARSE_S) as i32;
        let tried: Vec<(f64, f64)> = (-steps..=steps)
            .map(|step| COARSE_S * f64::from(step))
            .map(|delay_s| (delay_s, explained(delay_s)))
            .collect();
        let (coarse_s, most) = tried.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let other = tried.iter().filter(|(delay_s, _)| (delay_s - coarse_s).abs() > NEAR_S);
        let other = other.map(|(_, explained)| *explained).fold(0.0, f64::max);
        if most < EXPLAINED || other > most - CLEARLY {
            return None;
        }
        let steps = (COARSE_S / FINE_S) as i32;
        let fine_s = (-steps..=steps)
            .map(|step| coarse_s + FINE_S * f64::from(step))
            .max_by(|a, b| explained(*a).total_cmp(&explained(*b)))?;
        Some((fine_s, most))
    }

    /// Fraction, 0 to 1, of the changes `reported` by the fixes that the measured changes `delay_s` earlier explain.
    /// All measured changes are turned by one angle, the one that fits best.
    fn explained(&self, reported: &[Change], delay_s: impl Fn(f64) -> f64) -> Option<f64> {
        // Successive changes share two of their three times.
        let mut last = [(f64::NAN, None); 3];
        let pairs: Vec<_> = reported
            .iter()
            .filter_map(|change| {
                last = change.times_s.map(|time_s| {
                    let known = last.iter().find(|(last_s, _)| *last_s == time_s);
                    known.copied().unwrap_or_else(|| (time_s, self.at(time_s - delay_s(time_s))))
                });
                let [start, middle, end] = last.map(|(_, moment)| moment);
                Some((Self::change([start?, middle?, end?])?, change.north_east_mps))
            })
            .collect();
        if pairs.len() < MIN_CHANGES {
            return None;
        }
        let count = pairs.len() as f64;
        let (mut measured, mut reported) = ([0.0; 2], [0.0; 2]);
        for (a, b) in &pairs {
            measured = [measured[0] + a[0] / count, measured[1] + a[1] / count];
            reported = [reported[0] + b[0] / count, reported[1] + b[1] / count];
        }
        let (mut along, mut across, mut squares) = (0.0, 0.0, [0.0; 2]);
        for (a, b) in pairs {
            let a = [a[0] - measured[0], a[1] - measured[1]];
            let b = [b[0] - reported[0], b[1] - reported[1]];
            along += a[0] * b[0] + a[1] * b[1];
            across += a[0] * b[1] - a[1] * b[0];
            squares =
                [squares[0] + a[0] * a[0] + a[1] * a[1], squares[1] + b[0] * b[0] + b[1] * b[1]];
        }
        let moves = squares.iter().all(|squares| (squares / count).sqrt() > MIN_MPS);
        moves.then(|| (along.powi(2) + across.powi(2)) / (squares[0] * squares[1]))
    }

    fn change(moments: [Moment; 3]) -> Option<[f64; 2]> {
        let [start, _, end] = moments;
        let velocities = moments.map(|moment| moment.north_east_mps);
        (start.gaps == end.gaps).then(|| second_difference(velocities))
    }

    fn at(&self, time_s: f64) -> Option<Moment> {
        let earlier = *self.earlier.get(interval(time_s - self.moments.first()?.time_s))?;
        let within = self.moments[earlier..].iter().take_while(|moment| moment.time_s < time_s);
        let after = earlier + within.count();
        let (from, to) = (self.moments.get(after.checked_sub(1)?)?, self.moments.get(after)?);
        let share = (time_s - from.time_s) / (to.time_s - from.time_s);
        let between = |axis: usize| {
            let [from, to] = [from, to].map(|moment| moment.north_east_mps[axis]);
            from + share * (to - from)
        };
        Some(Moment { time_s, north_east_mps: [between(0), between(1)], gaps: to.gaps })
    }
}

/// Index of the interval of [`STEP_S`] that contains the time `since_s` after the first moment; 0 before it.
fn interval(since_s: f64) -> usize {
    (since_s / STEP_S) as usize
}

/// Second difference of the horizontal velocity over three times.
struct Change {
    times_s: [f64; 3],
    north_east_mps: [f64; 2],
}

/// Mean time of the changes, weighted by their squares, s.
fn centre_s(changes: &[Change]) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for Change { times_s: [_, time_s, _], north_east_mps: [north, east] } in changes {
        let weight = north * north + east * east;
        sum += weight * time_s;
        weights += weight;
    }
    sum / weights
}

fn second_difference([start, middle, end]: [[f64; 2]; 3]) -> [f64; 2] {
    [0, 1].map(|axis| end[axis] - 2.0 * middle[axis] + start[axis])
}

fn reported_changes(log: &Judged<'_>) -> Vec<Change> {
    let mut reported: Vec<(f64, [f64; 2])> = Vec::new();
    for fix in &log.dataset.fixes {
        let (time_s, velocity) = (fix.time.seconds(), fix.horizontal_velocity_mps);
        let is_due = reported.last().is_none_or(|last| time_s - last.0 >= OVER_S - STEP_S);
        reported.extend(velocity.filter(|_| is_due).map(|velocity| (time_s, velocity)));
    }
    let changes = reported.windows(3).filter_map(|reported| {
        let &[start, middle, end] = reported else { return None };
        let is_near = (middle.0 - start.0).max(end.0 - middle.0) < LONGEST_S;
        is_near.then(|| Change {
            times_s: [start.0, middle.0, end.0],
            north_east_mps: second_difference([start.1, middle.1, end.1]),
        })
    });
    changes.collect()
}
