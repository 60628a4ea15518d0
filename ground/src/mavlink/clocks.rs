//! What the vehicle's clocks read, by which what it dates has an age.
//!
//! Source: MAVLink, *common message set*: a field `time_usec` counts from the start of 1970 or from boot,
//! which its size tells.

/// What is greater counts from the start of 1970, µs: no vehicle has been switched on for thirty years.
const SINCE_BOOT_US: u64 = 1_000_000_000_000_000;
/// A date may be ahead of the newest reading by the time between two, s.
const AHEAD_S: f64 = 1.0;

/// The newest readings, µs.
#[derive(Default)]
pub struct Clocks {
    boot: Option<u64>,
    unix: Option<u64>,
}

impl Clocks {
    /// Hears what a clock reads now, µs; zero is what none reads.
    pub const fn hear(&mut self, now_us: u64) {
        match now_us {
            0 => {}
            1..SINCE_BOOT_US => self.boot = Some(now_us),
            SINCE_BOOT_US.. => self.unix = Some(now_us),
        }
    }

    /// How long ago `then_us` was, s; `None` where no clock that was heard tells.
    pub fn since_s(&self, then_us: u64) -> Option<f64> {
        let now_us = if then_us < SINCE_BOOT_US { self.boot } else { self.unix }?;
        let since_s = 1e-6 * (now_us as f64 - then_us as f64);
        (then_us > 0 && since_s >= -AHEAD_S).then_some(since_s.max(0.0))
    }
}
