//! Choice of the mode: the best mode that the pilot and the estimate allow.

use super::mode::{Mode, Reason, Transition};
use super::transfer::TransferConfig;
use crate::controls::Sticks;
use crate::health::Health;
use crate::scalar::Scalar;
use crate::time::Time;

/// Inputs for the choice of the mode in one step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Request<T> {
    pub now: Time,
    /// The pilot's switch.
    pub engage: bool,
    /// The pilot's sticks, if there is a signal.
    pub pilot: Option<Sticks<T>>,
    pub health: Health,
}

/// The mode and the state of its choice: the pilot's override, the time without velocity, and the time for which a
/// better mode has been possible. Times are summed in `f64` for every number type.
#[derive(Clone, Copy, Debug)]
pub(super) struct Supervisor<T> {
    period_s: f64,
    override_travel: T,
    patience_s: f64,
    recovery_s: f64,
    mode: Mode,
    last_transition: Option<Transition>,
    /// Positions of the sticks at engagement; `None` after an override.
    pilot_at_engagement: Option<Sticks<T>>,
    overridden: bool,
    without_velocity_s: f64,
    improving_s: f64,
}

impl<T: Scalar> Supervisor<T> {
    pub fn new(period_s: f64, transfer: &TransferConfig<T>, recovery_s: T) -> Self {
        Self {
            period_s,
            override_travel: transfer.override_travel,
            patience_s: transfer.patience_s.wide(),
            recovery_s: recovery_s.wide(),
            mode: Mode::Manual,
            last_transition: None,
            pilot_at_engagement: None,
            overridden: false,
            without_velocity_s: 0.0,
            improving_s: 0.0,
        }
    }

    pub const fn mode(&self) -> Mode {
        self.mode
    }

    pub const fn last_transition(&self) -> Option<Transition> {
        self.last_transition
    }

    /// Changes to the best mode that pilot and estimate allow. A worse mode is entered at once. A better mode is
    /// entered after the estimate has been good enough for the recovery time.
    pub fn choose(&mut self, request: &Request<T>) -> Option<Transition> {
        if !request.engage {
            self.overridden = false;
        } else if let (Some(now), Some(then)) = (request.pilot, self.pilot_at_engagement) {
            self.overridden |= now.farthest_from(then) > self.override_travel;
        }
        let (from, (to, why)) = (self.mode, self.best(request));
        self.without_velocity_s = if request.health.velocity.is_ok() || to == Mode::Manual {
            0.0
        } else {
            self.without_velocity_s + self.period_s
        };
        let hands_over = from == Mode::Manual || to == Mode::Manual;
        let improves = !hands_over && to < from;
        self.improving_s = if improves { self.improving_s + self.period_s } else { 0.0 };
        if to == from || (improves && self.improving_s < self.recovery_s) {
            return None;
        }
        let reason = match from {
            Mode::Manual => Reason::Switch,
            _ if improves => Reason::Recovered,
            _ => why,
        };
        if hands_over {
            self.pilot_at_engagement = request.pilot.filter(|_| from == Mode::Manual);
        }
        self.improving_s = 0.0;
        self.mode = to;
        self.last_transition = Some(Transition { time: request.now, from, to, reason });
        self.last_transition
    }

    /// The best mode that pilot and estimate allow, and the reason that prevents a better mode.
    fn best(&self, request: &Request<T>) -> (Mode, Reason) {
        let impatient = self.without_velocity_s >= self.patience_s;
        let health = &request.health;
        match (health.tilt, health.velocity, health.position) {
            _ if self.overridden => (Mode::Manual, Reason::Override),
            _ if !request.engage => (Mode::Manual, Reason::Switch),
            // Without attitude, the pilot keeps the sticks.
            (Err(_), ..) if self.mode == Mode::Manual => (Mode::Manual, Reason::Switch),
            (Err(why), ..) => (Mode::Neutral, Reason::Distrust(why)),
            (_, Err(_), _) if impatient => (Mode::Descent, Reason::VelocityNotRecovered),
            (_, Err(why), _) => (Mode::Attitude, Reason::Distrust(why)),
            (.., Err(why)) => (Mode::Velocity, Reason::Distrust(why)),
            _ => (Mode::Position, Reason::Recovered),
        }
    }
}
