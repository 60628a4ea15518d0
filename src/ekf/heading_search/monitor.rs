//! Monitor of a known heading against the fixes.

use super::super::scalar::Scalar;
use super::{AGREED_RAD, DOWN, HeadingSearch, turn_between};
use crate::frames::{Body, Ned, Rotation, wrap_angle};
use crate::time::Time;

/// Minimum error of a wrong heading, rad (25°).
const WRONG_RAD: f64 = 0.44;
/// Minimum error of a wrong heading, in one-sigmas of the heading from the fixes.
const WRONG_SIGMAS: f64 = 4.0;
/// Minimum error of a suspect heading, rad (5°).
const SUSPECT_RAD: f64 = 0.09;
/// Minimum error of a suspect heading, in one-sigmas of both headings together.
const SUSPECT_SIGMAS: f64 = 2.5;
/// Minimum duration of a disagreement, s.
const WRONG_S: f64 = 5.0;
/// Minimum number of fixes of a disagreement.
const WRONG_FIXES: u8 = 4;

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

/// Disagreement of the fixes with a heading.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judgement {
    wrong_since: Option<Time>,
    wrong_fixes: u8,
    /// Whether the hypotheses agree with the heading, and recent motion was enough to show it.
    pub is_confirmed: bool,
}

impl Judgement {
    pub const NONE: Self = Self { wrong_since: None, wrong_fixes: 0, is_confirmed: false };

    pub fn forget(&mut self) {
        (self.wrong_fixes, self.is_confirmed) = (0, false);
    }
}

impl<T: Scalar> HeadingSearch<T> {
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
    /// [`WRONG_S`].
    pub(super) fn judge(
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
        let has_evidence = self.has_evidence(1.0);
        let judgement = &mut self.judgement;
        judgement.is_confirmed = off.is_some() && suspect.is_none() && has_evidence;
        let Some(better) = suspect else {
            judgement.wrong_fixes = 0;
            return None;
        };
        if judgement.wrong_fixes == 0 {
            judgement.wrong_since = Some(time);
        }
        judgement.wrong_fixes = judgement.wrong_fixes.saturating_add(1);
        let since = judgement.wrong_since.is_some_and(|since| time - since >= WRONG_S);
        let lasts = since && judgement.wrong_fixes >= WRONG_FIXES;
        if lasts {
            judgement.wrong_fixes = 0;
        }
        lasts.then_some(better)
    }
}
