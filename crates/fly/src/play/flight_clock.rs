//! The clock of a flight that is played.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use hovernav::time::Time;

/// How long before the flight the clock stands when the devices are switched on, s: whatever time
/// goes by until it begins, nothing has been measured yet.
const BEFORE_S: f64 = 1e8;

/// After the last byte is due the flight is not yet over for this long, s: the host has to read it.
const LINGER_S: f64 = 0.5;

/// The time of the devices: it runs from long before the flight, and skips to its beginning.
#[derive(Debug)]
pub(super) struct FlightClock {
    first: Time,
    last: Time,
    speed: f64,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    /// A moment, and what the clock shows then.
    anchor: (Instant, Time),
    /// Devices that have yet to start before the flight begins.
    not_started: usize,
    has_begun: bool,
}

impl FlightClock {
    /// A flight from `first` to `last` that begins when `not_started` devices have started.
    pub fn new(first: Time, last: Time, speed: f64, not_started: usize) -> Self {
        let anchor = (Instant::now(), first + -BEFORE_S);
        Self {
            first,
            last,
            speed,
            state: Mutex::new(State { anchor, not_started, has_begun: false }),
        }
    }

    /// Lets the flight begin after `wait`.
    pub fn begin_after(&self, wait: Duration) {
        let mut state = self.state();
        state.anchor = (Instant::now(), self.first + -wait.as_secs_f64() * self.speed);
        state.has_begun = true;
    }

    /// One more device has started.
    pub fn device_started(&self) {
        let mut state = self.state();
        state.not_started = state.not_started.saturating_sub(1);
        if state.not_started == 0 && !state.has_begun {
            state.has_begun = true;
            state.anchor = (Instant::now(), self.first);
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
        state.has_begun && self.shown(&state) - self.last > LINGER_S * self.speed
    }

    /// How long to wait for `time` if nothing changes.
    pub fn until(&self, time: Time) -> Duration {
        let wait_s = (time - self.now()) / self.speed;
        if wait_s > 0.0 {
            Duration::try_from_secs_f64(wait_s).unwrap_or(Duration::MAX)
        } else {
            Duration::ZERO
        }
    }

    fn shown(&self, state: &State) -> Time {
        let (moment, time) = state.anchor;
        time + moment.elapsed().as_secs_f64() * self.speed
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
