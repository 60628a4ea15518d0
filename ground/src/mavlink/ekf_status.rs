//! EKF_STATUS_REPORT, the estimator status of ArduPilot, which is not in the common set.
//!
//! Source: MAVLink, *ardupilotmega message set*, message 193.

/// Message number.
pub const ID: u32 = 193;
/// The CRC_EXTRA byte of the message.
pub const LAYOUT: u8 = 71;

/// The contents of the message.
pub struct EkfStatus {
    /// Flags, as in ESTIMATOR_STATUS.
    pub flags: u16,
    /// Velocity innovation divided by its gate.
    pub velocity: f32,
    /// Horizontal position innovation divided by its gate.
    pub position: f32,
    /// Compass innovation divided by its gate.
    pub compass: f32,
}

impl EkfStatus {
    /// Decodes a payload. Trailing zeros may be missing.
    pub fn of(payload: &[u8]) -> Self {
        let byte = |place: usize| payload.get(place).copied().unwrap_or(0);
        let number = |place: usize| f32::from_le_bytes(std::array::from_fn(|k| byte(place + k)));
        Self {
            velocity: number(0),
            position: number(4),
            compass: number(12),
            flags: u16::from_le_bytes([byte(20), byte(21)]),
        }
    }
}
