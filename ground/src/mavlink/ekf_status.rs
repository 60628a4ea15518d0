//! EKF_STATUS_REPORT, ArduPilot's word on its estimator, which the common set lacks.
//!
//! Source: MAVLink, *ardupilotmega message set*, message 193.

/// Its number.
pub const ID: u32 = 193;
/// The byte that stands for its layout in the checksum.
pub const LAYOUT: u8 = 71;

/// What it says.
pub struct EkfStatus {
    /// One bit each, as ESTIMATOR_STATUS has them.
    pub flags: u16,
    /// Innovations of velocity over their gate.
    pub velocity: f32,
    /// Of horizontal position.
    pub position: f32,
    /// Of the compass.
    pub compass: f32,
}

impl EkfStatus {
    /// Of a payload, whose zeros at the end may have been left out.
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
