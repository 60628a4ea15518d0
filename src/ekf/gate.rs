//! Gates, and the way back for a filter that has locked itself out.
//!
//! A gate keeps a bad fix out. A filter that has gone wrong keeps *every* fix out, and drifts for
//! ever. Time tells the two apart: once everything of one kind has been refused for longer than
//! [`lockout_s`](super::GateConfig::lockout_s), the fault is taken to be the filter's own. Its covariance is opened by
//! the size of the innovation, correlations kept, and the fix is taken. That is reported as
//! [`Verdict::Reopened`](super::Verdict::Reopened), never silent.

use crate::time::Time;

/// Kinds of measurement that are refused, and reopened, together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    HorizontalPosition,
    VerticalPosition,
    HorizontalVelocity,
    VerticalVelocity,
    Attitude,
    Baro,
}

/// Since when each group has been refused without a break.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lockouts {
    groups: [Option<Lockout>; 6],
}

#[derive(Clone, Copy, Debug)]
struct Lockout {
    since: Time,
    refusals: u32,
}

/// Fewer refusals than this never reopen, however far apart they are.
const LEAST_REFUSALS: u32 = 3;

impl Lockouts {
    pub fn accepted(&mut self, group: Group) {
        if let Some(lockout) = self.groups.get_mut(group as usize) {
            *lockout = None;
        }
    }

    /// Notes a refusal; true when the filter is locked out and has to be reopened.
    pub fn refused(&mut self, group: Group, time: Time, lockout_s: f64) -> bool {
        let Some(slot) = self.groups.get_mut(group as usize) else { return false };
        let lockout = slot.get_or_insert(Lockout { since: time, refusals: 0 });
        lockout.refusals = lockout.refusals.saturating_add(1);
        let locked_out = lockout.refusals >= LEAST_REFUSALS && time - lockout.since >= lockout_s;
        if locked_out {
            *slot = None;
        }
        locked_out
    }
}
