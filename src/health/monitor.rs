//! Monitors sensor events and estimator notices for the health of the estimate.

use super::{DegradedQuantities, Distrust, Health, HealthLimits};
use crate::earth::Geodetic;
use crate::ekf::{Channel, Notice, Solution, Verdict};
use crate::event::Event;
use crate::gps::Fix;
use crate::imu::Motion;
use crate::scalar::Scalar;
use crate::time::Time;

/// Number of repetitions after which a receiver's fix counts as frozen.
const FIX_REPEATS: u8 = 2;
/// Shortest duration, s, of the repetitions of a frozen fix.
const FIX_FROZEN_S: f64 = 1.5;
/// Number of repetitions after which an inertial sample counts as frozen.
const SAMPLE_REPEATS: u8 = 4;
/// Shortest duration, s, of the repetitions of a frozen inertial sample.
const SAMPLE_FROZEN_S: f64 = 0.12;
/// Number of rejected fixes after which fixes and estimate disagree.
const REJECTIONS: u8 = 3;
/// Number of consecutive accepted fixes after which the disagreement ends.
const ACCEPTANCES: u8 = 3;
/// Time, s, for which attitude counts as degraded after a suspect sample.
const SUSPECT_S: f64 = 1.0;

/// The value that a sensor repeats, and the times of its first and latest occurrence.
#[derive(Clone, Copy, Debug)]
struct Repeated<R> {
    last: Option<R>,
    since: Time,
    latest: Time,
    times: u8,
}

impl<R: PartialEq> Repeated<R> {
    const NONE: Self = Self { last: None, since: Time::ZERO, latest: Time::ZERO, times: 0 };

    fn observe(&mut self, value: R, time: Time) {
        self.latest = time;
        if self.last.as_ref() == Some(&value) {
            self.times = self.times.saturating_add(1);
        } else {
            (self.last, self.since, self.times) = (Some(value), time, 0);
        }
    }

    fn is_frozen(&self, times: u8, for_s: f64) -> bool {
        self.times >= times && self.latest - self.since >= for_s
    }
}

/// Agreement of fixes and estimate in one quantity.
#[derive(Clone, Copy, Debug)]
struct Agreement {
    accepted: Option<Time>,
    rejected_since: Option<Time>,
    rejections: u8,
    acceptances: u8,
}

impl Agreement {
    const NONE: Self = Self { accepted: None, rejected_since: None, rejections: 0, acceptances: 0 };

    fn observe(&mut self, time: Time, verdict: Verdict) {
        if verdict == Verdict::Accepted {
            self.accepted = Some(time);
            self.acceptances = self.acceptances.saturating_add(1);
            if self.acceptances >= ACCEPTANCES {
                (self.rejected_since, self.rejections) = (None, 0);
            }
        } else {
            self.acceptances = 0;
            self.rejections = self.rejections.saturating_add(1);
            self.rejected_since = self.rejected_since.or(Some(time));
        }
    }

    fn is_lost<T: Scalar>(&self, now: Time, after_s: T) -> bool {
        self.rejections >= REJECTIONS
            && self.rejected_since.is_some_and(|since| now.seconds_since::<T>(since) > after_s)
    }
}

/// Health of an estimate over time: not only its one-sigmas, but also whether the sensors work and agree with it.
///
/// Pass to it every event for the estimator and every notice of the estimator; both take little time. Without events
/// and notices it uses one-sigma and age alone, as [`Health::assess`] does.
///
/// * Frozen receiver: three fixes equal to the last bit, for 1.5 s. Position and velocity are not good:
///   [`Distrust::Frozen`].
/// * Frozen inertial unit: five samples equal to the last bit, for 0.12 s. No quantity is good: [`Distrust::Frozen`].
/// * Rejected fixes: three rejections, the first of them longer than [`HealthLimits::disagreement_s`] ago. The rejected
///   quantity is not good, [`Distrust::Disagreement`], until three fixes in a row are accepted.
/// * No accepted fix for [`HealthLimits::dead_reckoning_s`]: [`Health::dead_reckoning_since`] is set. The one-sigmas
///   limit the time for which position and velocity are good enough.
///
/// A one-sigma that exceeded its limit is good again only below 0.8 of the limit.
#[derive(Clone, Copy, Debug)]
pub struct HealthMonitor<T = f64> {
    limits: HealthLimits<T>,
    sample: Repeated<Motion>,
    fix: Repeated<(Geodetic, Option<[f64; 2]>, Option<f64>)>,
    position: Agreement,
    velocity: Agreement,
    suspect: Option<Time>,
    was_good: [bool; 5],
}

impl<T: Scalar> HealthMonitor<T> {
    /// A monitor without any observations.
    #[must_use]
    pub const fn new(limits: HealthLimits<T>) -> Self {
        Self {
            limits,
            sample: Repeated::NONE,
            fix: Repeated::NONE,
            position: Agreement::NONE,
            velocity: Agreement::NONE,
            suspect: None,
            was_good: [true; 5],
        }
    }

    /// Observes a sensor event, before or after the estimator.
    pub fn observe(&mut self, event: &Event) {
        match event {
            Event::Imu(sample) => self.sample.observe(sample.motion, sample.time),
            Event::Gps(Fix {
                time, position, horizontal_velocity_mps, down_velocity_mps, ..
            }) => {
                self.fix.observe((*position, *horizontal_velocity_mps, *down_velocity_mps), *time);
            }
            _ => {}
        }
    }

    /// Observes a notice of the estimator.
    pub fn observe_notice(&mut self, notice: &Notice) {
        match notice {
            Notice::Aligned(alignment) => {
                let start = Some(alignment.start.state.time);
                (self.position, self.velocity) = (Agreement::NONE, Agreement::NONE);
                (self.position.accepted, self.velocity.accepted) = (start, start);
            }
            Notice::Updated(report) => {
                // North and east are accepted or rejected together: one axis represents both.
                for axis in report.innovations() {
                    match axis.channel {
                        Channel::PositionNorth => self.position.observe(axis.time, axis.verdict),
                        Channel::VelocityNorth => self.velocity.observe(axis.time, axis.verdict),
                        _ => {}
                    }
                }
            }
            Notice::SampleSuspect { time, .. } | Notice::SampleRejected { time, .. } => {
                self.suspect = Some(*time);
            }
            _ => {}
        }
    }

    /// Health of `solution` at `now`, on the solution's clock.
    #[must_use]
    pub fn assess(&mut self, solution: Option<&Solution<T>>, now: Time) -> Health {
        let limits = &self.limits;
        let mut health = Health::within(solution, now, limits, &self.was_good);
        if self.sample.is_frozen(SAMPLE_REPEATS, SAMPLE_FROZEN_S) {
            health = Health::none(Distrust::Frozen);
        }
        let disagreement_s = limits.disagreement_s;
        if self.fix.is_frozen(FIX_REPEATS, FIX_FROZEN_S) {
            health = health.without_velocity(Distrust::Frozen);
        } else if self.velocity.is_lost(now, disagreement_s) {
            health = health.without_velocity(Distrust::Disagreement);
        } else if self.position.is_lost(now, disagreement_s) {
            health.position = health.position.and(Err(Distrust::Disagreement));
        }
        self.was_good = health.are_good();

        let latest = match (self.position.accepted, self.velocity.accepted) {
            (Some(position), Some(velocity)) => Some(position.max(velocity)),
            (position, velocity) => position.or(velocity),
        };
        let age_s = |of: Time| now.seconds_since::<T>(of);
        let dead_reckoning = latest.filter(|latest| age_s(*latest) > limits.dead_reckoning_s);
        let rejected = |of: &Agreement| of.rejections > 0;
        let near = DegradedQuantities::near(solution, limits);
        health.dead_reckoning_since = dead_reckoning;
        health.degraded = DegradedQuantities {
            attitude: near.attitude || self.suspect.is_some_and(|at| age_s(at) < T::of(SUSPECT_S)),
            velocity: near.velocity || dead_reckoning.is_some() || rejected(&self.velocity),
            position: near.position || dead_reckoning.is_some() || rejected(&self.position),
        };
        health
    }
}
