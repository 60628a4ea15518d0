//! How much noisier the inertial unit is than assumed, learned from what the fixes say.
//!
//! Innovations of a filter whose noise is right are white. A filter that trusts its inertial unit too much
//! corrects too little, and what is left of one innovation is found again in the next: the innovations of
//! successive fixes become alike. Their product tells by how much the driving noise has to grow, and needs
//! no knowledge of the size of the fixes' own errors, which only ever make successive ones unlike.
//!
//! Where they become very much alike within seconds, something has stepped: a bias, for all the filter knows.
//! A large step leads beyond the gate before that shows; what is refused then grows from fix to fix, while what a
//! receiver gets wrong is there at a stroke.

use super::innovation::{Channel, Innovation, Verdict};
use super::measurement::Report;
use crate::scalar::Scalar;
use crate::time::Time;

/// By how many times the variance of the inertial unit's driving noise exceeds what is assumed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Excess {
    learned: f64,
    /// Normalised innovations of velocity, north and east, at the last fix, where they were accepted.
    last: Option<(Time, [f64; 2])>,
    /// The same of vertical velocity.
    last_down: Option<(Time, f64)>,
    /// How much alike they have been in the last seconds, level and vertical.
    of_late: [f64; 2],
    /// When level velocity was first refused, soon after it had been accepted, and how far off it was.
    refused: Option<(Time, f64)>,
    /// The same of vertical velocity, m/s; none off where it was reopened.
    refused_down: (Time, Option<f32>),
    /// When vertical velocity was reopened last, and by how much its error had grown each second, m/s².
    reopened_down: (Time, Option<f32>),
}

/// Which innovations speak of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Stepped {
    /// Those of level velocity: of a gyro, or of an accelerometer.
    pub level: bool,
    /// Those of vertical velocity: of an accelerometer.
    pub down: bool,
    /// Those of level velocity that are refused: of a large step.
    pub far: bool,
    /// Those of vertical velocity that are refused: of an accelerometer.
    pub down_far: Option<Growth>,
}

/// How an error of the vertical velocity has grown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Growth {
    /// By so much a second, m/s².
    pub rate_mps2: f64,
    /// For what is left of it, for so long, s: for none where a fix has just been taken in.
    pub left_s: f64,
}

/// Share by which the likeness of two fixes a second apart moves the factor.
const RATE: f64 = 0.03;
/// Likeness that a filter with right noise shows too: slow errors of the fixes, timing.
const USUAL: f64 = 0.2;
/// Chance alone makes the innovations of a filter with right noise so much alike.
const BY_CHANCE: f64 = 1.5;
/// No unit is noisier than assumed by more than so many times, in variance.
const MOST: f64 = 10.0;
/// Innovations that are so much alike for so long, s, are those of a step.
const STEP: f64 = 4.0;
const STEP_S: f64 = 2.0;
/// Refused innovations speak of a step when, after so long, s, they are so many times what they were.
const GROWING_S: f64 = 0.9;
const GROWN: f64 = 1.5;
/// Vertical ones after so long, s.
const GROWING_DOWN_S: f64 = 1.9;
/// So does a vertical velocity that is reopened again, to the same side, within so long, s.
const AGAIN_S: f64 = 10.0;
/// Fixes further apart than this, s, tell nothing of each other.
const LONGEST_S: f64 = 3.0;
/// An innovation counts no more than so many one-sigmas: outliers are no noise.
const MOST_SIGMAS: f64 = 3.0;

impl Excess {
    /// The noise is what is assumed.
    pub const NONE: Self = Self {
        learned: 1.0,
        last: None,
        last_down: None,
        of_late: [0.0; 2],
        refused: None,
        refused_down: (Time::ZERO, None),
        reopened_down: (Time::ZERO, None),
    };

    /// The factor on variances, from 1 to 10.
    pub fn factor(&self) -> f64 {
        (self.learned / BY_CHANCE).max(1.0)
    }

    /// Takes in what became of a fix; gives whether the fixes of late speak of a step.
    ///
    /// # Source
    /// Equation (K18) of docs/equations.md.
    pub fn learn(&mut self, time: Time, report: &Report) -> Stepped {
        let find = |channel| report.innovations().find(|axis| axis.channel == channel);
        let normalised = |channel, verdict| {
            find(channel).filter(|axis| axis.verdict == verdict).map(Innovation::normalised)
        };
        let accepted = |channel| {
            normalised(channel, Verdict::Accepted).map(|off| off.clamp(-MOST_SIGMAS, MOST_SIGMAS))
        };
        let refused = |channel| normalised(channel, Verdict::Rejected);
        let level = accepted(Channel::VelocityNorth).zip(accepted(Channel::VelocityEast));
        let refused = refused(Channel::VelocityNorth).zip(refused(Channel::VelocityEast));
        let was_accepted = self.last.is_some_and(|(then, _)| soon_after(then, time).is_some());
        self.compare_level(time, level);
        let height = find(Channel::PositionDown).map_or(0.0, |height| height.innovation);
        let down_far =
            find(Channel::VelocityDown).and_then(|down| self.grows_down(time, down, height));
        self.compare_down(time, accepted(Channel::VelocityDown), height);
        let [level, down] = self.of_late.map(|of_late| of_late > STEP);
        for (of_late, stepped) in self.of_late.iter_mut().zip([level, down]) {
            if stepped {
                *of_late = 0.0;
            }
        }
        Stepped { level, down, far: self.grows_far(time, refused, was_accepted), down_far }
    }

    /// Compares the level velocity of a fix with that of the fix before.
    fn compare_level(&mut self, time: Time, level: Option<(f64, f64)>) {
        let before = core::mem::replace(&mut self.last, level.map(|(n, e)| (time, [n, e])));
        if let (Some((north, east)), Some((then, last))) = (level, before)
            && let Some(interval_s) = soon_after(then, time)
        {
            let alike = north * last[0] + east * last[1];
            self.of_late[0] += (interval_s / STEP_S).min(1.0) * (alike - self.of_late[0]);
            let share = RATE * interval_s.min(1.0);
            self.learned =
                (self.learned * (1.0 + share * (alike - USUAL))).clamp(1.0, BY_CHANCE * MOST);
        }
    }

    /// The same of the vertical velocity, where the innovation of `height` bears it out: a receiver's vertical
    /// velocity errs slowly too.
    fn compare_down(&mut self, time: Time, down: Option<f64>, height: f64) {
        let before = core::mem::replace(&mut self.last_down, down.map(|down| (time, down)));
        if let (Some(down), Some((then, last))) = (down, before)
            && let Some(interval_s) = soon_after(then, time)
        {
            let alike = if height * down > 0.0 { down * last } else { 0.0 };
            self.of_late[1] += (interval_s / STEP_S).min(1.0) * (alike - self.of_late[1]);
        }
    }

    /// Whether innovations that are refused grow, as a bias makes them: what a receiver does is there at a
    /// stroke.
    fn grows_far(&mut self, time: Time, refused: Option<(f64, f64)>, began: bool) -> bool {
        let Some((north, east)) = refused else {
            self.refused = None;
            return false;
        };
        let size = Scalar::hypot(north, east);
        let Some((since, first)) = self.refused else {
            self.refused = began.then_some((time, size));
            return false;
        };
        let grown = time - since >= GROWING_S && size >= GROWN * first;
        if grown {
            self.refused = Some((time, size));
        }
        grown
    }

    /// The same of the vertical velocity, where the innovation of `height` bears it out; gives by how much it grows.
    fn grows_down(&mut self, time: Time, down: &Innovation, height: f64) -> Option<Growth> {
        let off = down.innovation;
        let began = self.last_down.is_some_and(|(then, _)| soon_after(then, time).is_some());
        let ((since, before), (then, reopened)) = (self.refused_down, self.reopened_down);
        self.refused_down = match down.verdict {
            Verdict::Accepted => (time, None),
            Verdict::Reopened => (time, Some(0.0)),
            Verdict::Rejected if before.is_some() => (since, before),
            Verdict::Rejected => (time, began.then_some(off as f32)),
        };
        let first = f64::from(before.filter(|_| down.verdict != Verdict::Accepted)?);
        let rate = (off - first) / (time - since).max(f64::MIN_POSITIVE);
        let again = down.verdict == Verdict::Reopened
            && time - then <= AGAIN_S
            && reopened.is_some_and(|before| rate * f64::from(before) > 0.0);
        if down.verdict == Verdict::Reopened {
            self.reopened_down = (time, Some(rate as f32));
        }
        let grows = first * off >= 0.0 && off.abs() >= GROWN * first.abs() && height * off > 0.0;
        let left_s = if down.verdict == Verdict::Reopened { 0.0 } else { off / rate };
        (again || (grows && time - since >= GROWING_DOWN_S))
            .then_some(Growth { rate_mps2: rate, left_s })
    }
}

/// Time from one fix to another, s, where they tell of each other.
fn soon_after(then: Time, time: Time) -> Option<f64> {
    Some(time - then).filter(|interval_s| (0.0..LONGEST_S).contains(interval_s))
}
