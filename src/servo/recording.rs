//! An output that keeps what it was told, for simulation and tests.

use core::convert::Infallible;

use super::{Channels, PulseOutput};
use crate::time::Time;

/// Keeps every command with its time, in memory that grows with them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// When, and the widths in ms.
    pub written: Vec<(Time, Channels<f64>)>,
}

impl PulseOutput for Recording {
    type Error = Infallible;

    fn write(&mut self, widths_ms: &Channels<f64>, now: Time) -> Result<(), Infallible> {
        self.written.push((now, *widths_ms));
        Ok(())
    }
}
