//! How much noisier the inertial unit is than assumed, learned from what the fixes say.
//!
//! Innovations of a filter whose noise is right are white. A filter that trusts its inertial unit too much
//! corrects too little, and what is left of one innovation is found again in the next: the innovations of
//! successive fixes become alike. Their product tells by how much the driving noise has to grow, and needs
//! no knowledge of the size of the fixes' own errors, which only ever make successive ones unlike.
//!
//! Where they become very much alike within seconds, something has stepped: a bias, for all the filter knows.

use super::innovation::{Channel, Verdict};
use super::measurement::Report;
use crate::time::Time;

/// By how many times the variance of the inertial unit's driving noise exceeds what is assumed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Excess {
    learned: f64,
    /// Normalised innovations of velocity, north and east, at the last fix.
    last: Option<(Time, [f64; 2])>,
    /// How much alike they have been in the last seconds.
    of_late: f64,
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
/// Fixes further apart than this, s, tell nothing of each other.
const LONGEST_S: f64 = 3.0;
/// An innovation counts no more than so many one-sigmas: outliers are no noise.
const MOST_SIGMAS: f64 = 3.0;

impl Excess {
    /// The noise is what is assumed.
    pub const NONE: Self = Self { learned: 1.0, last: None, of_late: 0.0 };

    /// The factor on variances, from 1 to 10.
    pub fn factor(&self) -> f64 {
        (self.learned / BY_CHANCE).max(1.0)
    }

    /// Takes in what became of a fix; gives whether the fixes of late speak of a step.
    ///
    /// # Source
    /// Equation (K18) of docs/equations.md.
    pub fn learn(&mut self, time: Time, report: &Report) -> bool {
        let mut now = [None; 2];
        for axis in report.innovations() {
            let slot = match axis.channel {
                Channel::VelocityNorth => &mut now[0],
                Channel::VelocityEast => &mut now[1],
                _ => continue,
            };
            if axis.verdict == Verdict::Accepted {
                *slot = Some(axis.normalised().clamp(-MOST_SIGMAS, MOST_SIGMAS));
            }
        }
        let [Some(north), Some(east)] = now else {
            self.last = None;
            return false;
        };
        if let Some((then, last)) = self.last.replace((time, [north, east])) {
            let interval_s = time - then;
            if (0.0..LONGEST_S).contains(&interval_s) {
                let alike = north * last[0] + east * last[1];
                self.of_late += (interval_s / STEP_S).min(1.0) * (alike - self.of_late);
                let share = RATE * interval_s.min(1.0);
                self.learned =
                    (self.learned * (1.0 + share * (alike - USUAL))).clamp(1.0, BY_CHANCE * MOST);
            }
        }
        let stepped = self.of_late > STEP;
        if stepped {
            self.of_late = 0.0;
        }
        stepped
    }
}
