//! How late fixes are where a log does not say.

/// What a receiver takes to work out a fix and send it, s: the value that ArduPilot has for u-blox
/// receivers since the seventh generation, and PX4 for any.
pub(crate) const USUAL_LATENCY_S: f64 = 0.11;
