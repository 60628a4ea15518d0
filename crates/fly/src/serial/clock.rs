//! The clock of a flight.

use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use super::emulation::Emulation;
use super::signal::{Signal, lock};
use hovernav::time::Time;

/// A time later than any flight.
const NEVER: Time = Time::from_nanoseconds(i64::MAX);
/// UTC at the start of an emulation: 20 March 2026, 04:09:30, as in the emulated receiver.
const EMULATED_UNIX_NS: i64 = 1_773_979_770_000_000_000;

/// Time since the start of the flight, the same for all copies of the clock.
///
/// A real flight uses the machine's monotonic clock. In an [emulation](Self::emulated), time passes only while all
/// threads wait: a flight takes only its computing time and is reproducible.
///
/// ```
/// use hovernav_fly::serial::Clock;
/// let clock = Clock::start();
/// let before = clock.now();
/// clock.sleep_until(before + 0.002);
/// assert!(clock.now() - before >= 0.002);
///
/// let clock = Clock::emulated();
/// let task = clock.spawn("waits", { let clock = clock.clone(); move || clock.sleep_until(clock.now() + 3600.0) });
/// task.unwrap().join().unwrap();
/// assert_eq!(clock.now().seconds(), 3600.0);
/// ```
#[derive(Clone, Debug)]
pub struct Clock(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Machine { start: Instant, speed: f64 },
    Emulated { emulation: Arc<Emulation>, processor: usize },
}

impl Clock {
    /// A clock that shows [`Time::ZERO`] now.
    #[must_use]
    pub fn start() -> Self {
        Self(Kind::Machine { start: Instant::now(), speed: 1.0 })
    }

    /// A clock that shows [`Time::ZERO`] now and runs at `speed` times real time, for played flights. `None` unless
    /// `speed` is between 0.001 and 1000.
    #[must_use]
    pub fn at_speed(speed: f64) -> Option<Self> {
        let is_possible = (0.001..=1e3).contains(&speed);
        is_possible.then(|| Self(Kind::Machine { start: Instant::now(), speed }))
    }

    /// The clock of a new emulation, at [`Time::ZERO`]. Its threads are the calling one and those that
    /// [`spawn`](Self::spawn) starts; its serial lines are in memory.
    ///
    /// One thread runs at a time, and computation takes no time. A thread of the emulation that waits for another
    /// must wait with this clock.
    #[must_use]
    pub fn emulated() -> Self {
        Self(Kind::Emulated { emulation: Arc::new(Emulation::begin()), processor: 0 })
    }

    /// The same clock for the threads of another processor, which can be [held](Self::hold_until) separately.
    #[must_use]
    pub fn on_another_processor(&self) -> Self {
        match &self.0 {
            Kind::Machine { .. } => self.clone(),
            Kind::Emulated { emulation, .. } => Self(Kind::Emulated {
                emulation: Arc::clone(emulation),
                processor: emulation.add_processor(),
            }),
        }
    }

    /// Holds the threads of this emulated processor until `time`, like a processor that is busy with other work. No
    /// effect on the machine's clock.
    pub fn hold_until(&self, time: Time) {
        if let Kind::Emulated { emulation, processor } = &self.0 {
            emulation.hold_until(*processor, time);
        }
    }

    /// The time.
    #[must_use]
    pub fn now(&self) -> Time {
        match &self.0 {
            Kind::Machine { start, speed } => {
                let elapsed = start.elapsed();
                if *speed == 1.0 {
                    // Integer nanoseconds keep their resolution in long flights.
                    return Time::from_nanoseconds(
                        i64::try_from(elapsed.as_nanos()).unwrap_or(i64::MAX),
                    );
                }
                Time::ZERO + elapsed.as_secs_f64() * speed
            }
            Kind::Emulated { emulation, .. } => emulation.now(),
        }
    }

    /// UTC since the start of 1970, ns.
    #[must_use]
    pub fn unix_ns(&self) -> i64 {
        match &self.0 {
            Kind::Machine { .. } => {
                let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
                i64::try_from(unix.as_nanos()).unwrap_or(i64::MAX)
            }
            Kind::Emulated { emulation, .. } => {
                EMULATED_UNIX_NS.saturating_add(emulation.now().nanoseconds())
            }
        }
    }

    /// Real duration until `time`, for waits without this clock. Zero if it is past, and for an emulated clock,
    /// which does not advance during such a wait.
    #[must_use]
    pub fn until(&self, time: Time) -> Duration {
        match &self.0 {
            Kind::Machine { speed, .. } => {
                let wait_s = (time - self.now()) / speed;
                Duration::try_from_secs_f64(wait_s).unwrap_or(Duration::ZERO)
            }
            Kind::Emulated { .. } => Duration::ZERO,
        }
    }

    /// Waits for `time`.
    pub fn sleep_until(&self, time: Time) {
        match &self.0 {
            Kind::Machine { .. } => thread::sleep(self.until(time)),
            Kind::Emulated { emulation, processor } => emulation.wait(*processor, time, None),
        }
    }

    /// Runs `work` in a new thread of this clock.
    ///
    /// # Errors
    /// A thread cannot be started.
    pub fn spawn<T: Send + 'static>(
        &self,
        name: impl Into<String>,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> io::Result<Task<T>> {
        let ended: Arc<End> = Arc::default();
        let ending = Ending { clock: self.clone(), ended: Arc::clone(&ended) };
        let builder = thread::Builder::new().name(name.into());
        let thread = match &self.0 {
            Kind::Machine { .. } => builder.spawn(move || {
                let _ending = ending;
                work()
            })?,
            Kind::Emulated { emulation, processor } => {
                let ticket = emulation.reserve();
                let theirs = Arc::clone(emulation);
                let thread = builder.spawn(move || {
                    theirs.wait_for_turn(ticket);
                    let _ending = ending;
                    work()
                })?;
                emulation.admit(ticket, *processor, thread.thread().clone());
                thread
            }
        };
        Ok(Task { thread, clock: self.clone(), ended })
    }

    /// Whether this is the clock of an emulation, in which time also waits for the disk.
    pub(crate) fn is_emulated(&self) -> bool {
        matches!(self.0, Kind::Emulated { .. })
    }

    /// The emulation of this clock, if any.
    pub(super) fn emulation(&self) -> Option<&Arc<Emulation>> {
        match &self.0 {
            Kind::Machine { .. } => None,
            Kind::Emulated { emulation, .. } => Some(emulation),
        }
    }

    /// Speed relative to real time.
    #[cfg(unix)]
    pub(crate) fn speed(&self) -> f64 {
        match &self.0 {
            Kind::Machine { speed, .. } => *speed,
            Kind::Emulated { .. } => 1.0,
        }
    }

    /// Releases `guard` of `mutex` until `signal` is raised or `deadline` has passed; may also return earlier.
    pub(super) fn wait<'a, T>(
        &self,
        signal: &Signal,
        mutex: &'a Mutex<T>,
        guard: MutexGuard<'a, T>,
        deadline: Time,
    ) -> MutexGuard<'a, T> {
        match &self.0 {
            Kind::Machine { .. } => {
                let wait = self.until(deadline);
                let waited = signal.condvar.wait_timeout(guard, wait);
                waited.unwrap_or_else(PoisonError::into_inner).0
            }
            Kind::Emulated { emulation, processor } => {
                drop(guard);
                emulation.wait(*processor, deadline, Some(signal.number));
                lock(mutex)
            }
        }
    }

    /// Wakes the threads that wait for `signal`.
    pub(super) fn raise(&self, signal: &Signal) {
        match &self.0 {
            Kind::Machine { .. } => signal.condvar.notify_all(),
            Kind::Emulated { emulation, .. } => emulation.raise(signal.number),
        }
    }
}

/// A thread of a [`Clock`].
#[derive(Debug)]
pub struct Task<T> {
    thread: JoinHandle<T>,
    clock: Clock,
    ended: Arc<End>,
}

/// Whether a thread has ended.
#[derive(Debug, Default)]
struct End {
    is_over: Mutex<bool>,
    signal: Signal,
}

/// Signals the end of a thread, also after a panic, when it is dropped.
struct Ending {
    clock: Clock,
    ended: Arc<End>,
}

impl<T> Task<T> {
    /// Whether the thread has ended.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        *lock(&self.ended.is_over)
    }

    /// Waits for the end of the thread and returns its result.
    ///
    /// # Errors
    /// The payload of its panic.
    pub fn join(self) -> thread::Result<T> {
        let End { is_over, signal } = &*self.ended;
        let mut over = lock(is_over);
        while !*over {
            over = self.clock.wait(signal, is_over, over, NEVER);
        }
        drop(over);
        self.thread.join()
    }
}

impl Drop for Ending {
    fn drop(&mut self) {
        *lock(&self.ended.is_over) = true;
        self.clock.raise(&self.ended.signal);
        if let Some(emulation) = self.clock.emulation() {
            emulation.leave();
        }
    }
}
