//! The vehicle's clocks, which give the age of time stamps.
//!
//! Source: MAVLink, *common message set*: a field `time_usec` counts from the start of 1970 or from boot, depending on
//! its magnitude.

/// Smallest time stamp that counts from the start of 1970, µs. As a time since boot it would mean thirty years of
/// operation.
const SINCE_BOOT_US: u64 = 1_000_000_000_000_000;
/// Largest lead of a time stamp over the newest clock reading, s: the interval between two readings.
const AHEAD_S: f64 = 1.0;

/// The newest clock readings, µs.
#[derive(Default)]
pub struct Clocks {
    boot: Option<u64>,
    unix: Option<u64>,
}

impl Clocks {
    /// Stores a clock reading, µs; zero means no clock.
    pub const fn observe(&mut self, now_us: u64) {
        match now_us {
            0 => {}
            1..SINCE_BOOT_US => self.boot = Some(now_us),
            SINCE_BOOT_US.. => self.unix = Some(now_us),
        }
    }

    /// The age of `then_us`, s; `None` if the clock of this time stamp is unknown.
    pub fn since_s(&self, then_us: u64) -> Option<f64> {
        let now_us = if then_us < SINCE_BOOT_US { self.boot } else { self.unix }?;
        let since_s = 1e-6 * (now_us as f64 - then_us as f64);
        (then_us > 0 && since_s >= -AHEAD_S).then_some(since_s.max(0.0))
    }
}
