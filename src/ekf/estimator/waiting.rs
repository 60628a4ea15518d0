//! Fixes that wait for the inertial samples around their time.

use super::{Estimator, MAX_WAITING, Notice, OF_ONE_CLOCK_S};
use crate::ekf::heading_search::HeadingMethod;
use crate::ekf::kernel::layout::Layout;
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::report::{Aid, Unusable};
use crate::gps::Fix;
use crate::scalar::Scalar;
use crate::time::Time;

impl<L: Layout<N>, const N: usize, T: Scalar, H: HeadingMethod<T>> Estimator<L, N, T, H> {
    /// The slot of the earliest waiting fix.
    fn earliest_held(&mut self) -> Option<&mut Option<Fix>> {
        let held = self.waiting_fixes.iter_mut().filter(|held| held.is_some());
        held.min_by_key(|held| held.as_ref().map(|fix| fix.time))
    }

    /// Stores a fix until its samples arrive. Without a free slot, the oldest waiting fix is fused at once. It is
    /// reported as unused if it is ahead of the samples.
    #[inline(never)]
    pub(super) fn store_fix(
        &mut self,
        fix: &Fix,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        let time = self.filter.state.time;
        if fix.time - time > OF_ONE_CLOCK_S {
            notify(Notice::NotUsed { time: fix.time, aid: Aid::Gps, reason: Unusable::AheadOfImu });
            return;
        }
        // The oldest fix makes room: after a gap in the samples the newest fixes show the motion best.
        let full = self.waiting_fixes.iter().all(Option::is_some);
        if let Some(oldest) = self.earliest_held().filter(|_| full).and_then(Option::take) {
            if oldest.time <= time {
                self.gps(&oldest, trace, notify);
            } else {
                let reason = Unusable::AheadOfImu;
                notify(Notice::NotUsed { time: oldest.time, aid: Aid::Gps, reason });
            }
        }
        if let Some(slot) = self.waiting_fixes.iter_mut().find(|slot| slot.is_none()) {
            *slot = Some(*fix);
        }
    }

    /// Fuses the waiting fixes up to the time `until`, in order of time.
    #[inline(never)]
    pub(super) fn fuse_waiting(
        &mut self,
        until: Time,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        for _ in 0..MAX_WAITING {
            let due = |held: &mut Option<Fix>| held.take_if(|fix| fix.time <= until);
            let Some(fix) = self.earliest_held().and_then(due) else { return };
            self.gps(&fix, trace, notify);
        }
    }
}
