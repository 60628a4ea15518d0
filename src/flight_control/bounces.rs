//! Lockout of a switch that bounces.

use crate::time::Time;

/// Number of engagements in quick succession after which the switch is locked out.
pub(super) const MAX_ENGAGEMENTS: u8 = 3;
/// Time, s, without a change of the switch after which the count of engagements is reset. Only an open switch ends a
/// lockout.
pub(super) const STEADY_S: f64 = 3.0;

/// Count of the engagements since the switch was last steady.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bounces {
    is_on: bool,
    /// Time of the last change.
    since: Option<Time>,
    engagements: u8,
}

impl Bounces {
    /// Updates the state from the switch; call it once a cycle. Returns whether closing the switch has no effect.
    pub fn update(&mut self, is_on: bool, now: Time) -> bool {
        let since = *self.since.get_or_insert(now);
        if self.is_on != is_on {
            (self.is_on, self.since) = (is_on, Some(now));
        } else if now - since >= STEADY_S && !(is_on && self.is_locked()) {
            self.engagements = 0;
        }
        self.is_locked()
    }

    /// Counts an engagement.
    pub fn engaged(&mut self) {
        self.engagements = self.engagements.saturating_add(1);
    }

    /// Whether closing the switch has no effect.
    pub const fn is_locked(&self) -> bool {
        self.engagements >= MAX_ENGAGEMENTS
    }
}
