//! Likely mistakes in the set-up of the sensors.

use core::ffi::{CStr, c_char};

use hovernav::setup::{ForceScale, SetupFault as CoreSetupFault};

/// Likely mistakes in the set-up of the sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum SetupFault {
    /// A mistake unknown to this header.
    Other = 0,
    /// Accelerations in g instead of m/s^2.
    ForceInG = 1,
    /// Accelerations in thousandths of g.
    ForceInThousandthsOfG = 2,
    /// Accelerations multiplied by g once too often.
    ForceTimesG = 3,
    /// Accelerometers with another range than assumed.
    ForceOtherRange = 4,
    /// Accelerations without gravity.
    ForceWithoutGravity = 5,
    /// Accelerations whose size differs from gravity, in an unknown unit or range.
    ForceSize = 6,
    /// A specific force that does not point along -z: axes other than forward, right, down.
    ForceDirection = 7,
    /// Angular rates in deg/s instead of rad/s.
    RatesInDegrees = 8,
    /// A vertical velocity positive up instead of down.
    VelocityUp = 9,
    /// North and east velocity swapped.
    VelocitySwapped = 10,
    /// A north velocity of the wrong sign.
    VelocityNorthReversed = 11,
    /// An east velocity of the wrong sign.
    VelocityEastReversed = 12,
    /// A velocity in another unit than m/s.
    VelocityScale = 13,
    /// A roll or pitch rate of the wrong sign, or both swapped.
    GyroTilts = 14,
    /// A yaw rate of the wrong sign.
    GyroYaw = 15,
    /// Angular rates in other axes than the accelerations.
    GyroAxes = 16,
    /// Velocities of zero while the positions move.
    VelocityZero = 17,
    /// Latitude and longitude in radians instead of degrees.
    PositionInRadians = 18,
    /// A gyro axis that is always zero.
    GyroDead = 19,
    /// An accelerometer axis that is always zero.
    AccelerometerDead = 20,
    /// Heights in another unit than m.
    HeightScale = 21,
}

impl SetupFault {
    const ALL: [(Self, &CStr); 22] = [
        (Self::Other, c"a mistake unknown to this version"),
        (Self::ForceInG, c"accelerations in g, expected m/s^2"),
        (Self::ForceInThousandthsOfG, c"accelerations in thousandths of g, expected m/s^2"),
        (Self::ForceTimesG, c"accelerations multiplied by g once too often"),
        (Self::ForceOtherRange, c"accelerometers with another range than assumed"),
        (Self::ForceWithoutGravity, c"accelerations without gravity, expected specific force"),
        (Self::ForceSize, c"accelerations in another unit or range, expected m/s^2"),
        (Self::ForceDirection, c"axes other than forward, right, down"),
        (Self::RatesInDegrees, c"angular rates in deg/s, expected rad/s"),
        (Self::VelocityUp, c"vertical velocity positive up, expected positive down"),
        (Self::VelocitySwapped, c"north and east velocity swapped"),
        (Self::VelocityNorthReversed, c"north velocity of the wrong sign"),
        (Self::VelocityEastReversed, c"east velocity of the wrong sign"),
        (Self::VelocityScale, c"velocity in another unit, expected m/s"),
        (Self::GyroTilts, c"roll or pitch rate of the wrong sign, or both swapped"),
        (Self::GyroYaw, c"yaw rate of the wrong sign"),
        (Self::GyroAxes, c"angular rates in other axes than the accelerations"),
        (Self::VelocityZero, c"velocity not measured: zero while positions move"),
        (Self::PositionInRadians, c"latitude and longitude in rad, expected deg"),
        (Self::GyroDead, c"a gyro axis is always zero"),
        (Self::AccelerometerDead, c"an accelerometer axis is always zero"),
        (Self::HeightScale, c"heights in another unit, expected m"),
    ];

    /// The code of the fault, and the number in its notice.
    pub(crate) fn of(fault: &CoreSetupFault) -> (Self, f64) {
        match *fault {
            CoreSetupFault::ForceSize { mean_mps2, scale } => {
                let kind = match scale {
                    ForceScale::InG => Self::ForceInG,
                    ForceScale::InThousandthsOfG => Self::ForceInThousandthsOfG,
                    ForceScale::TimesG => Self::ForceTimesG,
                    ForceScale::OtherRange { .. } => Self::ForceOtherRange,
                    ForceScale::WithoutGravity => Self::ForceWithoutGravity,
                    _ => Self::ForceSize,
                };
                (kind, f64::from(mean_mps2))
            }
            CoreSetupFault::ForceDirection { .. } => (Self::ForceDirection, 0.0),
            CoreSetupFault::RatesInDegrees { reported_rad, .. } => {
                (Self::RatesInDegrees, f64::from(reported_rad))
            }
            CoreSetupFault::VelocityUp => (Self::VelocityUp, 0.0),
            CoreSetupFault::VelocitySwapped => (Self::VelocitySwapped, 0.0),
            CoreSetupFault::VelocityReversed { north: true } => (Self::VelocityNorthReversed, 0.0),
            CoreSetupFault::VelocityReversed { north: false } => (Self::VelocityEastReversed, 0.0),
            CoreSetupFault::VelocityScale { unit_mps } => {
                (Self::VelocityScale, f64::from(unit_mps))
            }
            CoreSetupFault::GyroSigns { tilts: true, yaw: false } => (Self::GyroTilts, 0.0),
            CoreSetupFault::GyroSigns { tilts: false, .. } => (Self::GyroYaw, 0.0),
            CoreSetupFault::GyroSigns { tilts: true, yaw: true } => (Self::GyroAxes, 0.0),
            CoreSetupFault::VelocityZero { speed_mps } => {
                (Self::VelocityZero, f64::from(speed_mps))
            }
            CoreSetupFault::DeadAxis { is_gyro: true, axis } => (Self::GyroDead, f64::from(axis)),
            CoreSetupFault::DeadAxis { is_gyro: false, axis } => {
                (Self::AccelerometerDead, f64::from(axis))
            }
            CoreSetupFault::HeightScale { factor } => (Self::HeightScale, f64::from(factor)),
            CoreSetupFault::PositionInRadians => (Self::PositionInRadians, 0.0),
            _ => (Self::Other, 0.0),
        }
    }
}

/// The text of a HovernavSetupFault: static, ends with a zero byte, never null.
#[unsafe(no_mangle)]
pub extern "C" fn hovernav_setup_fault_text(fault: u32) -> *const c_char {
    let [(_, other), ..] = SetupFault::ALL;
    SetupFault::ALL
        .into_iter()
        .find(|(known, _)| *known as u32 == fault)
        .map_or(other, |(_, text)| text)
        .as_ptr()
}
