//! Times of the messages, and the innovations between them.

use hovernav::telemetry::Innovations;
use hovernav::time::Time;

/// Time over which the largest innovations are kept, s; fixes come once a second.
const RECENT_S: f64 = 1.0;

/// Schedule of one type of message, on a grid of its period. The mean rate is right even if the loop rate is not a
/// multiple of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Schedule {
    period_s: f64,
    due: Time,
}

impl Schedule {
    pub fn new(rate_hz: f64, start: Time) -> Self {
        Self { period_s: 1.0 / rate_hz, due: start }
    }

    /// The rate, Hz; 0 if the message is off.
    pub fn rate_hz(&self) -> f64 {
        if self.period_s > 0.0 && self.period_s.is_finite() { 1.0 / self.period_s } else { 0.0 }
    }

    /// Changes the rate, from the next message on; 0 turns it off.
    pub fn set_rate(&mut self, rate_hz: f64) {
        self.period_s = 1.0 / rate_hz;
    }

    pub fn is_due(&mut self, now: Time) -> bool {
        // Messages with a rate of 0, a negative rate or NaN are never due.
        let sends = self.period_s > 0.0 && self.period_s.is_finite();
        // Without this, a clock that was set back by more than a period would stop the message.
        let set_back = self.due - now > self.period_s + 1e-3;
        if !sends || (now < self.due && !set_back) {
            return false;
        }
        self.due = self.due + self.period_s;
        if set_back || self.due <= now {
            self.due = now + self.period_s;
        }
        true
    }
}

/// Largest innovations in two consecutive periods of at least [`RECENT_S`]: the current and the previous period.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Recent {
    since: Option<Time>,
    now: Innovations,
    before: Innovations,
}

impl Recent {
    pub fn push(&mut self, innovations: &Innovations, now: Time) {
        let since = *self.since.get_or_insert(now);
        if !(0.0..RECENT_S).contains(&(now - since)) {
            self.since = Some(now);
            self.before = std::mem::take(&mut self.now);
        }
        self.now = largest(&self.now, innovations);
    }

    pub fn largest(&self) -> Innovations {
        largest(&self.now, &self.before)
    }
}

/// The larger innovation of each kind.
fn largest(a: &Innovations, b: &Innovations) -> Innovations {
    let of = |kind: fn(&Innovations) -> Option<f64>| match (kind(a), kind(b)) {
        (Some(a), Some(b)) => Some(a.max(b)),
        (a, b) => a.or(b),
    };
    Innovations {
        position: of(|one| one.position),
        velocity: of(|one| one.velocity),
        attitude: of(|one| one.attitude),
        heading: of(|one| one.heading),
        baro: of(|one| one.baro),
        rejected: a.rejected.max(b.rejected),
    }
}
