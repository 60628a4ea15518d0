//! An output that records its commands, for simulation and tests.

use core::convert::Infallible;

use hovernav::controls::Channels;
use hovernav::servo::PulseOutput;
use hovernav::time::Time;

/// Records every command with its time; the memory grows with the number of commands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordingOutput {
    /// Time and widths, ms.
    pub written: Vec<(Time, Channels<f64>)>,
}

impl PulseOutput for RecordingOutput {
    type Error = Infallible;

    fn write(&mut self, widths_ms: &Channels<f64>, now: Time) -> Result<(), Infallible> {
        self.written.push((now, *widths_ms));
        Ok(())
    }
}
