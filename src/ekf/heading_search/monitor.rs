//! Monitor of a known heading against the fixes.

use super::{AGREED_RAD, DOWN, HeadingSearch, turn_between};
use crate::frames::{Body, Ned, Rotation, wrap_angle};
use crate::scalar::Scalar;
use crate::time::Time;

/// Minimum error of a wrong heading, rad (25°).
const WRONG_RAD: f64 = 0.44;
/// Minimum error of a wrong heading, in one-sigmas of the heading from the fixes.
const WRONG_SIGMAS: f64 = 4.0;
/// Minimum error of a suspect heading, rad (5°).
const SUSPECT_RAD: f64 = 0.09;
/// Minimum error of a suspect heading, in one-sigmas of both headings together.
const SUSPECT_SIGMAS: f64 = 2.5;

/// Heading confirmed by the fixes while the heading of the filter is wrong or suspect.
#[derive(Clone, Copy, Debug)]
pub struct BetterHeading {
    /// Turn from the filter's heading to the better one, clockwise, rad.
    pub turn_rad: f64,
    /// One-sigma of the better heading, rad.
    pub sigma_rad: f64,
    /// Whether the filter's heading is wrong and must be replaced; otherwise it is suspect and its one-sigma grows.
    pub replaces: bool,
}

impl<T: Scalar> HeadingSearch<T> {
    /// Whether recent motion confirmed the last judged heading.
    pub(in crate::ekf) fn is_confirmed(&self) -> bool {
        self.judgement.is_confirmed
    }

    /// Turn from an attitude's heading to that of the hypotheses; `None` while the hypotheses disagree.
    fn off(&self, body_to_ned: Rotation<Body, Ned, T>) -> Option<BetterHeading> {
        let best = self.best().filter(|_| self.has_begun())?;
        let (off_rad, sigma_rad) = self.heading_spread();
        let start_to_ned = (body_to_ned * self.body_to_start.inverse()).cast();
        let turn_rad = wrap_angle(turn_between(start_to_ned, best.start_to_ned, DOWN) + off_rad);
        let replaces = libm::fabs(turn_rad) > WRONG_RAD.max(WRONG_SIGMAS * sigma_rad);
        (sigma_rad < AGREED_RAD).then_some(BetterHeading { turn_rad, sigma_rad, replaces })
    }

    /// The better heading, once the heading of an attitude with one-sigma `own_sigma_rad` has been wrong or suspect for
    /// some seconds.
    pub(in crate::ekf) fn judge(
        &mut self,
        time: Time,
        body_to_ned: Rotation<Body, Ned, T>,
        own_sigma_rad: T,
    ) -> Option<BetterHeading> {
        let is_suspect = |off: &BetterHeading| {
            let sigma_rad = Scalar::hypot(off.sigma_rad, own_sigma_rad.wide());
            off.replaces || libm::fabs(off.turn_rad) > SUSPECT_RAD.max(SUSPECT_SIGMAS * sigma_rad)
        };
        let off = self.off(body_to_ned);
        let suspect = off.filter(is_suspect);
        let is_confirmed = off.is_some() && suspect.is_none() && self.has_evidence(1.0);
        self.judgement.is_confirmed = is_confirmed;
        let lasts = self.judgement.lasts(time, suspect.is_some());
        suspect.filter(|_| lasts)
    }
}
