//! Fixes that wait for the inertial samples about when they hold.

use super::super::heading_search::HeadingMethod;
use super::super::layout::Layout;
use super::super::measurement::{Aid, Unusable};
use super::super::scalar::Scalar;
use super::super::trace::Trace;
use super::{Estimator, HELD, Notice, OF_ONE_CLOCK_S, Phase};
use crate::gps::Fix;
use crate::time::Time;

impl<L: Layout<N>, const N: usize, T: Scalar, H: HeadingMethod<T>> Estimator<L, N, T, H> {
    /// Whether a fix of `time` need not wait for later samples.
    pub(super) fn is_due(&self, time: Time) -> bool {
        match self.phase {
            Phase::Navigating => self.filter.is_due(time),
            Phase::Aligning | Phase::Searching => time <= self.time(),
        }
    }

    /// Lets a fix wait, in the place of the oldest that does where there is none left.
    #[inline(never)]
    pub(super) fn hold(
        &mut self,
        fix: &Fix,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        let time = self.time();
        if fix.time - time > OF_ONE_CLOCK_S {
            notify(Notice::NotUsed { time: fix.time, aid: Aid::Gps, reason: Unusable::AheadOfImu });
            return;
        }
        // The newest tell most of where a gap in the samples has led.
        let full = self.held.iter().all(Option::is_some);
        if let Some(oldest) = self.held.first_mut().filter(|_| full).and_then(Option::take) {
            self.held.rotate_left(1);
            if oldest.time <= time {
                self.gps(&oldest, trace, notify);
            } else {
                let reason = Unusable::AheadOfImu;
                notify(Notice::NotUsed { time: oldest.time, aid: Aid::Gps, reason });
            }
        }
        if let Some(slot) = self.held.iter_mut().find(|slot| slot.is_none()) {
            *slot = Some(*fix);
        }
    }

    /// Takes in the fixes that waited, those that need not any more, or before a gap all that are not from within it.
    #[inline(never)]
    pub(super) fn take_held(
        &mut self,
        before_gap: bool,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        for slot in 0..HELD {
            let is_due = |fix: &Fix| match before_gap {
                true => fix.time <= self.time(),
                false => self.is_due(fix.time),
            };
            let held = self.held.get(slot).and_then(Option::as_ref);
            // By reference until it is taken: each copy would be one on the stack.
            if held.is_some_and(is_due)
                && let Some(fix) = self.held.get_mut(slot).and_then(Option::take)
            {
                self.gps(&fix, trace, notify);
            }
        }
    }
}
