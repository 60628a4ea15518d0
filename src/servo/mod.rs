//! Servo pulses: the pilot's commands as inputs, the servos' commands as outputs.
//!
//! A radio-control servo takes its position from the width of a pulse: 1 to 2 ms, about 50 times a second. Each of the
//! five controls has one servo. The input of the pilot and the output of the autopilot are therefore widths about trim.
//!
//! [`Captured`] stores the pulses of one channel, [`ChannelConfig`] converts widths to stick fractions and back,
//! [`Swashplate`] mixes the servos under the swashplate. [`Switch`] evaluates the pilot's aux channel, and [`Limiter`]
//! keeps the outputs within range and rate. [`PulseCapture`] and [`PulseOutput`] are the interfaces to the hardware, so
//! that a board can bring its own:
//!
//! ```
//! use hovernav::controls::Channels;
//! use hovernav::servo::{ChannelConfig, Limiter, PulseOutput};
//! use hovernav::time::Time;
//!
//! /// The compare registers of a timer, in ticks of 0.5 µs.
//! #[derive(Default)]
//! struct Timer([u16; 5]);
//!
//! impl PulseOutput for Timer {
//!     type Error = core::convert::Infallible;
//!
//!     fn write(&mut self, widths_ms: &Channels<f64>, _now: Time) -> Result<(), Self::Error> {
//!         self.0 = widths_ms.map(|width_ms| (2e3 * width_ms).round() as u16).to_array();
//!         Ok(())
//!     }
//! }
//!
//! let config = Channels::<ChannelConfig>::default();
//! let mut limiter = Limiter::new(config, 0.2)?;
//! let mut servos = Timer::default();
//!
//! let sticks = Channels { lateral: 0.1, ..Channels::default() };
//! let mut now = Time::ZERO;
//! for _ in 0..3 {
//!     let command_ms = sticks.zip(config).map(|(stick, config)| config.width_ms(stick));
//!     let limited = limiter.apply(&command_ms, now);
//!     servos.write(&limited.map(|servo| servo.width_ms), now)?;
//!     now = now + 0.03;
//! }
//! assert_eq!(Channels::from(servos.0).lateral, 3_100);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod capture;
mod config;
mod edges;
mod limiter;
pub mod packet;
mod swashplate;
mod switch;
mod width;

pub use capture::{Captured, PilotPulses, Pulse, PulseFault, Signal, SignalConfig};
pub(crate) use config::within;
pub use config::{ChannelConfig, ConfigError, Direction};
pub use edges::{EdgeTimer, Paired};
pub use limiter::{Limit, Limited, Limiter};
pub use swashplate::{Swashplate, SwashplateKind};
pub use switch::{Switch, SwitchConfig};
pub use width::{LONGEST_MS, SHORTEST_MS, is_plausible};

use crate::controls::Channels;
use crate::time::Time;

/// Source of the pilot's pulses.
pub trait PulseCapture {
    /// Error of the source itself; missing pulses are not an error of the source.
    type Error: core::error::Error;

    /// Reads the pulses that arrived by `now`, without waiting for more, and returns their state.
    ///
    /// # Errors
    /// `Self::Error` if the source cannot be read. The previous state stays and becomes older.
    fn poll(&mut self, now: Time) -> Result<&PilotPulses, Self::Error>;
}

/// Output of the servos' pulses.
pub trait PulseOutput {
    /// Error of the outputs.
    type Error: core::error::Error;

    /// Sets the widths, ms, of the pulses from `now` on.
    ///
    /// # Errors
    /// `Self::Error` if a channel cannot be set. Every other channel has been set if possible.
    fn write(&mut self, widths_ms: &Channels<f64>, now: Time) -> Result<(), Self::Error>;
}
