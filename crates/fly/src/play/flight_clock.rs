//! The clock of a flight that is played.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::serial::Clock;
use hovernav::time::Time;

/// How long before the flight the clock stands when the devices are switched on, s: whatever time
/// goes by until it begins, nothing has been measured yet.
const BEFORE_S: f64 = 1e8;

/// After the last byte is due the flight is not yet over for this long, s: the host has to read it.
const LINGER_S: f64 = 0.5;

/// The time of the devices, on the host's clock: it runs from long before the flight, and skips to its
/// beginning.
#[derive(Debug)]
pub(super) struct FlightClock {
    clock: Clock,
    first: Time,
    last: Time,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    /// What this clock shows more than the host's, ns.
    ahead_ns: i64,
    /// Devices that have yet to start before the flight begins.
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

    /// Lets the flight begin after `wait`.
    pub fn begin_after(&self, wait: Duration) {
        let mut state = self.state();
        let shown = self.first + -wait.as_secs_f64() * self.clock.speed();
        state.ahead_ns = ahead_ns(&self.clock, shown);
        state.has_begun = true;
    }

    /// One more device has started.
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

    /// Seconds since the flight began; `None` before it begins.
    pub fn elapsed_s(&self) -> Option<f64> {
        let state = self.state();
        Some(self.shown(&state) - self.first).filter(|flown| state.has_begun && *flown >= 0.0)
    }

    /// Whether everything was sent half a second ago or earlier.
    pub fn is_over(&self) -> bool {
        let state = self.state();
        state.has_begun && self.shown(&state) - self.last > LINGER_S * self.clock.speed()
    }

    /// What the host's clock shows at `time`, if nothing changes.
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

/// By how much a clock that shows `shown` now is ahead of `clock`, ns.
fn ahead_ns(clock: &Clock, shown: Time) -> i64 {
    shown.nanoseconds().saturating_sub(clock.now().nanoseconds())
}
