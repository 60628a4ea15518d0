//! Lockout of a switch that bounces.

use crate::time::Time;

/// Engagements, each soon after the one before, after which the switch is locked out.
pub(super) const MOST_ENGAGEMENTS: u8 = 3;
/// Time, s, of an unchanged switch after which engagements are counted from zero, and of an open one that ends a
/// lockout.
pub(super) const STEADY_S: f64 = 3.0;

/// Engagements of a switch that has not been steady since.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bounces {
    is_on: bool,
    /// Time of the last change.
    since: Option<Time>,
    engagements: u8,
}

impl Bounces {
    /// Updates the state by the switch, once a cycle. Returns whether closing it has no effect.
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
        self.engagements >= MOST_ENGAGEMENTS
    }
}
