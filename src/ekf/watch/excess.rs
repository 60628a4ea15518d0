//! Ratio of the inertial unit's noise to the assumed noise, learned from the innovations of fixes.
//!
//! Innovations of a filter with correct noise are white. A filter that trusts its inertial unit too much corrects too
//! little. Part of one innovation then remains in the next: successive innovations become correlated. Their product
//! shows by how much the driving noise has to grow. Errors of the fixes themselves only reduce the correlation, so
//! their size need not be known.
//!
//! A strong correlation within seconds indicates a step, most likely of a bias. A large step leads beyond the gate
//! before it shows in the correlation. Rejected innovations then grow from fix to fix, while a receiver fault appears
//! at full size at once.

use super::{BETWEEN_FIXES_S, OUTLIER_SIGMAS};
use crate::ekf::outcome::innovation::{Channel, Innovation, Verdict};
use crate::ekf::outcome::report::Report;
use crate::matrix::square;
use crate::time::Time;

/// Learned factor on the variance of the inertial unit's driving noise, relative to the assumed variance.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct Excess {
    learned: f64,
    /// Time of the last fix, and its normalised innovations of velocity, north and east. `None` if that velocity was
    /// not accepted.
    last: Option<(Time, [f64; 2])>,
    /// Time of the last fix, and its normalised innovation of vertical velocity, if accepted.
    last_down: (Time, Option<f32>),
    /// Mean product of successive innovations over the last seconds, horizontal and vertical.
    mean_product: [f64; 2],
    /// First rejection of horizontal velocity soon after an acceptance: time, and normalised innovations, north and
    /// east. Zeros without a rejection.
    rejected: (Time, [f32; 2]),
    /// First rejection of vertical velocity soon after an acceptance: time, and innovation, m/s. The innovation is zero
    /// after a reset to the measurement.
    rejected_down: (Time, Option<f32>),
    /// Last reset of vertical velocity: time, and growth rate of the velocity error before the reset, m/s².
    reopened_down: (Time, Option<f32>),
}

/// Bias steps that recent innovations indicate, by kind of innovation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::ekf) struct Stepped {
    /// Accepted innovations of horizontal velocity indicate a step of a gyro or an accelerometer.
    pub level: bool,
    /// Accepted innovations of vertical velocity indicate a step of an accelerometer.
    pub down: bool,
    /// Rejected innovations of horizontal velocity indicate a large step.
    pub far: bool,
    /// Growth of rejected innovations of vertical velocity, which indicates a step of an accelerometer.
    pub down_far: Option<Growth>,
}

/// Growth of an error of the vertical velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::ekf) struct Growth {
    /// Growth rate, m/s².
    pub rate_mps2: f64,
    /// Time, s, in which the present velocity error arose at this rate; zero right after a reset to the fix.
    pub left_s: f64,
}

/// Relative change of the learned factor per unit product of two normalised innovations one second apart.
const RATE: f64 = 0.03;
/// Mean product of successive normalised innovations with correct noise. It is not zero because fixes have slow errors
/// and time errors.
const USUAL: f64 = 0.2;
/// Factor that chance alone produces with correct noise.
const CHANCE_FACTOR: f64 = 1.5;
/// Upper limit of the factor on the variance.
const MAX_FACTOR: f64 = 10.0;
/// Mean product of successive normalised innovations above which they indicate a step.
const STEP: f64 = 4.0;
/// Averaging time of the mean product, s.
const STEP_S: f64 = 2.0;
/// Minimum time, s, from a first rejection of horizontal velocity to a larger one that indicates a step.
const GROWING_S: f64 = 0.9;
/// Factor by which rejected innovations must have grown to indicate a step.
const GROWN: f64 = 1.5;
/// Minimum time, s, from a first rejection of vertical velocity to a larger one that indicates a step.
const GROWING_DOWN_S: f64 = 1.9;
/// Longest time, s, between two resets of the vertical velocity to the same side that indicate a step.
const AGAIN_S: f64 = 10.0;

impl Excess {
    /// State before the first fix: the assumed noise.
    pub const NONE: Self = Self {
        learned: 1.0,
        last: None,
        last_down: (Time::ZERO, None),
        mean_product: [0.0; 2],
        rejected: (Time::ZERO, [0.0; 2]),
        rejected_down: (Time::ZERO, None),
        reopened_down: (Time::ZERO, None),
    };

    /// Factor on the variances of the driving noise, from 1 to 10.
    pub fn factor(&self) -> f64 {
        (self.learned / CHANCE_FACTOR).max(1.0)
    }

    /// Resets the factor to one.
    pub fn forget_factor(&mut self) {
        self.learned = 1.0;
    }

    /// Feeds the report of a fix. Returns the step, if any, that recent fixes indicate.
    ///
    /// # Source
    /// Equation (K18) of docs/equations.md.
    pub fn learn(&mut self, time: Time, report: &Report) -> Stepped {
        let find = |channel| report.innovations().find(|axis| axis.channel == channel);
        let normalised = |channel, verdict| {
            find(channel).filter(|axis| axis.verdict == verdict).map(Innovation::normalised)
        };
        let accepted = |channel| {
            normalised(channel, Verdict::Accepted)
                .map(|off| off.clamp(-OUTLIER_SIGMAS, OUTLIER_SIGMAS))
        };
        let rejected = |channel| normalised(channel, Verdict::Rejected);
        let level = accepted(Channel::VelocityNorth).zip(accepted(Channel::VelocityEast));
        let rejected = rejected(Channel::VelocityNorth).zip(rejected(Channel::VelocityEast));
        let was_accepted = self.last.is_some_and(|(then, _)| soon_after(then, time).is_some());
        self.compare_level(time, level);
        let height = find(Channel::PositionDown).map_or(0.0, |height| height.innovation);
        let down_far =
            find(Channel::VelocityDown).and_then(|down| self.grows_down(time, down, height));
        self.compare_down(time, accepted(Channel::VelocityDown), height);
        let [level, down] = self.mean_product.map(|mean_product| mean_product > STEP);
        for (mean_product, stepped) in self.mean_product.iter_mut().zip([level, down]) {
            if stepped {
                *mean_product = 0.0;
            }
        }
        Stepped { level, down, far: self.grows_far(time, rejected, was_accepted), down_far }
    }

    /// Compares the horizontal velocity of a fix with that of the previous fix.
    fn compare_level(&mut self, time: Time, level: Option<(f64, f64)>) {
        let before = core::mem::replace(&mut self.last, level.map(|(n, e)| (time, [n, e])));
        if let (Some((north, east)), Some((then, last))) = (level, before)
            && let Some(interval_s) = soon_after(then, time)
        {
            let alike = north * last[0] + east * last[1];
            self.mean_product[0] += (interval_s / STEP_S).min(1.0) * (alike - self.mean_product[0]);
            let share = RATE * interval_s.min(1.0);
            self.learned = (self.learned * (1.0 + share * (alike - USUAL)))
                .clamp(1.0, CHANCE_FACTOR * MAX_FACTOR);
        }
    }

    /// Compares the vertical velocity of a fix with that of the previous fix. The product counts only if the height
    /// innovation `height` has the same sign: a receiver's vertical velocity has slow errors too.
    fn compare_down(&mut self, time: Time, down: Option<f64>, height: f64) {
        let newest = (time, down.map(|down| down as f32));
        let (then, before) = core::mem::replace(&mut self.last_down, newest);
        if let (Some(down), Some(last)) = (down, before.map(f64::from))
            && let Some(interval_s) = soon_after(then, time)
        {
            let alike = if height * down > 0.0 { down * last } else { 0.0 };
            self.mean_product[1] += (interval_s / STEP_S).min(1.0) * (alike - self.mean_product[1]);
        }
    }

    /// Whether rejected innovations grow to one side, as with a bias step. A receiver fault appears at full size at
    /// once.
    fn grows_far(&mut self, time: Time, rejected: Option<(f64, f64)>, began: bool) -> bool {
        let Some((north, east)) = rejected else {
            self.rejected.1 = [0.0; 2];
            return false;
        };
        let newest = (time, [north as f32, east as f32]);
        let (since, first) = self.rejected;
        if first == [0.0; 2] {
            if began {
                self.rejected = newest;
            }
            return false;
        }
        let [first_north, first_east] = first.map(f64::from);
        let alike = north * first_north + east * first_east;
        let grown = time - since >= GROWING_S
            && alike >= GROWN * (square(first_north) + square(first_east));
        if grown {
            self.rejected = newest;
        }
        grown
    }

    /// Growth of the vertical velocity innovation, if the height innovation `height` has the same sign.
    fn grows_down(&mut self, time: Time, down: &Innovation, height: f64) -> Option<Growth> {
        let off = down.innovation;
        let (then, last) = self.last_down;
        let began = last.is_some() && soon_after(then, time).is_some();
        let ((since, before), (then, reopened)) = (self.rejected_down, self.reopened_down);
        self.rejected_down = match down.verdict {
            Verdict::Accepted => (time, None),
            Verdict::Reset => (time, Some(0.0)),
            Verdict::Rejected if before.is_some() => (since, before),
            Verdict::Rejected => (time, began.then_some(off as f32)),
        };
        let first = f64::from(before.filter(|_| down.verdict != Verdict::Accepted)?);
        let rate = (off - first) / (time - since).max(f64::MIN_POSITIVE);
        let again = down.verdict == Verdict::Reset
            && time - then <= AGAIN_S
            && reopened.is_some_and(|before| rate * f64::from(before) > 0.0);
        if down.verdict == Verdict::Reset {
            self.reopened_down = (time, Some(rate as f32));
        }
        let grows = first * off >= 0.0 && off.abs() >= GROWN * first.abs() && height * off > 0.0;
        let left_s = if down.verdict == Verdict::Reset { 0.0 } else { off / rate };
        (again || (grows && time - since >= GROWING_DOWN_S))
            .then_some(Growth { rate_mps2: rate, left_s })
    }
}

/// Time from one fix to the next, s, if short enough for a comparison.
fn soon_after(then: Time, time: Time) -> Option<f64> {
    Some(time - then).filter(|interval_s| (0.0..BETWEEN_FIXES_S).contains(interval_s))
}
