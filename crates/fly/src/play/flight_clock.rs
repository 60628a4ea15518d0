//! The clock of a played flight.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::serial::Clock;
use hovernav::time::Time;

/// Time, s, by which the devices' clock starts before the flight: no measurement is due until the flight begins.
const BEFORE_S: f64 = 1e8;

/// Time from the last byte to the end of the flight, s: the host needs it to read that byte.
const LINGER_S: f64 = 0.5;

/// The time of the devices. It starts long before the flight and jumps to the beginning of the flight.
#[derive(Debug)]
pub(super) struct FlightClock {
    clock: Clock,
    first: Time,
    last: Time,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    /// This clock minus the host's clock, ns.
    ahead_ns: i64,
    /// Number of devices that must still start before the flight begins.
    not_started: usize,
    has_begun: bool,
}

impl FlightClock {
    /// A flight from `first` to `last` that begins when `not_started` devices have started.
    pub fn new(clock: Clock, first: Time, last: Time, not_started: usize) -> Self {
        let ahead_ns = ahead_ns(&clock, first + -BEFORE_S);
        let state = Mutex::new(State { ahead_ns, not_started, has_begun: false });
        Self { clock, first, last, state }
    }

    /// The host's clock.
    pub fn host(&self) -> &Clock {
        &self.clock
    }

    /// Starts the flight after `wait`.
    pub fn begin_after(&self, wait: Duration) {
        let mut state = self.state();
        let shown = self.first + -wait.as_secs_f64() * self.clock.speed();
        state.ahead_ns = ahead_ns(&self.clock, shown);
        state.has_begun = true;
    }

    /// Counts a started device; the last one starts the flight.
    pub fn device_started(&self) {
        let mut state = self.state();
        state.not_started = state.not_started.saturating_sub(1);
        if state.not_started == 0 && !state.has_begun {
            state.has_begun = true;
            state.ahead_ns = ahead_ns(&self.clock, self.first);
        }
    }

    pub fn now(&self) -> Time {
        self.shown(&self.state())
    }

    /// Time since the start of the flight, s; `None` before.
    pub fn elapsed_s(&self) -> Option<f64> {
        let state = self.state();
        Some(self.shown(&state) - self.first).filter(|flown| state.has_begun && *flown >= 0.0)
    }

    /// Whether the last byte was due at least [`LINGER_S`] ago.
    pub fn is_over(&self) -> bool {
        let state = self.state();
        state.has_begun && self.shown(&state) - self.last > LINGER_S * self.clock.speed()
    }

    /// The host's clock at `time`, if the offset does not change.
    pub fn on_host(&self, time: Time) -> Time {
        Time::from_nanoseconds(time.nanoseconds().saturating_sub(self.state().ahead_ns))
    }

    fn shown(&self, state: &State) -> Time {
        Time::from_nanoseconds(self.clock.now().nanoseconds().saturating_add(state.ahead_ns))
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Offset from `clock` to a clock that now shows `shown`, ns.
fn ahead_ns(clock: &Clock, shown: Time) -> i64 {
    shown.nanoseconds().saturating_sub(clock.now().nanoseconds())
}
