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

/// Kinds there are.
const GROUPS: usize = 6;

/// Since when, and how often, each group has been refused without a break.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lockouts {
    since: [Time; GROUPS],
    refusals: [u8; GROUPS],
}

/// Fewer refusals than this never reopen, however far apart they are.
const LEAST_REFUSALS: u8 = 3;

impl Lockouts {
    /// No group has been refused.
    pub const NONE: Self = Self { since: [Time::ZERO; GROUPS], refusals: [0; GROUPS] };

    pub fn accepted(&mut self, group: Group) {
        if let Some(refusals) = self.refusals.get_mut(group as usize) {
            *refusals = 0;
        }
    }

    /// Notes a refusal; true when the filter is locked out and has to be reopened.
    pub fn refused(&mut self, group: Group, time: Time, lockout_s: f64) -> bool {
        let group = group as usize;
        let (Some(since), Some(refusals)) =
            (self.since.get_mut(group), self.refusals.get_mut(group))
        else {
            return false;
        };
        if *refusals == 0 {
            *since = time;
        }
        *refusals = refusals.saturating_add(1);
        let locked_out = *refusals >= LEAST_REFUSALS && time - *since >= lockout_s;
        if locked_out {
            *refusals = 0;
        }
        locked_out
    }
}
