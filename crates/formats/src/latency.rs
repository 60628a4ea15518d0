//! Latency of fixes in logs that do not state it.

/// Time that a receiver needs to compute and send a fix, s. ArduPilot uses this value for u-blox receivers since the
/// seventh generation, PX4 for all receivers.
pub(crate) const USUAL_LATENCY_S: f64 = 0.11;
