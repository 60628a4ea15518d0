//! The one clock of a flight.

use std::thread;
use std::time::{Duration, Instant};

use hovernav::time::Time;

/// Monotonic time since the flight's start, the same for all that hold a copy.
///
/// ```
/// use hovernav_fly::serial::Clock;
/// let clock = Clock::start();
/// let before = clock.now();
/// clock.sleep_until(before + 0.002);
/// assert!(clock.now() - before >= 0.002);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    start: Instant,
    speed: f64,
}

impl Clock {
    /// A clock that shows [`Time::ZERO`] now.
    #[must_use]
    pub fn start() -> Self {
        Self { start: Instant::now(), speed: 1.0 }
    }

    /// A clock that shows [`Time::ZERO`] now and runs `speed` times as fast as time does: for flights
    /// that are played. `None` unless `speed` is between 0.001 and 1000.
    #[must_use]
    pub fn at_speed(speed: f64) -> Option<Self> {
        (0.001..=1e3).contains(&speed).then(|| Self { start: Instant::now(), speed })
    }

    /// The time.
    #[must_use]
    pub fn now(&self) -> Time {
        let elapsed = self.start.elapsed();
        if self.speed == 1.0 {
            // Integer nanoseconds, however long the flight.
            return Time::from_nanoseconds(i64::try_from(elapsed.as_nanos()).unwrap_or(i64::MAX));
        }
        Time::ZERO + elapsed.as_secs_f64() * self.speed
    }

    /// How long to wait for `time`; nothing if it is past.
    #[must_use]
    pub fn until(&self, time: Time) -> Duration {
        let wait_s = (time - self.now()) / self.speed;
        Duration::try_from_secs_f64(wait_s).unwrap_or(Duration::ZERO)
    }

    /// Waits for `time`.
    pub fn sleep_until(&self, time: Time) {
        thread::sleep(self.until(time));
    }
}
