//! An output that keeps what it was sent, for simulation and tests.

use core::convert::Infallible;

use hovernav::controls::Channels;
use hovernav::servo::PulseOutput;
use hovernav::time::Time;

/// Keeps every command with its time, in memory that grows with them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordingOutput {
    /// When, and the widths in ms.
    pub written: Vec<(Time, Channels<f64>)>,
}

impl PulseOutput for RecordingOutput {
    type Error = Infallible;

    fn write(&mut self, widths_ms: &Channels<f64>, now: Time) -> Result<(), Infallible> {
        self.written.push((now, *widths_ms));
        Ok(())
    }
}
