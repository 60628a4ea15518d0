//! Roll, pitch and yaw.

use glam::DQuat;

use super::{Body, Ned, Rotation};

/// Roll, pitch and yaw of the 3-2-1 sequence: yaw about down, then pitch, then roll.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EulerAngles {
    /// Rotation about the forward axis, right side down positive, in (−π, π].
    pub roll_rad: f64,
    /// Nose-up angle, in [−π/2, π/2].
    pub pitch_rad: f64,
    /// Heading from true north, clockwise, in (−π, π].
    pub yaw_rad: f64,
}

impl EulerAngles {
    /// The three angles from degrees.
    #[must_use]
    pub fn from_degrees(roll_deg: f64, pitch_deg: f64, yaw_deg: f64) -> Self {
        Self {
            roll_rad: roll_deg.to_radians(),
            pitch_rad: pitch_deg.to_radians(),
            yaw_rad: yaw_deg.to_radians(),
        }
    }

    /// Roll, pitch and yaw in degrees.
    #[must_use]
    pub fn to_degrees(self) -> [f64; 3] {
        [self.roll_rad.to_degrees(), self.pitch_rad.to_degrees(), self.yaw_rad.to_degrees()]
    }

    /// Whether no angle is NaN or infinite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.roll_rad.is_finite() && self.pitch_rad.is_finite() && self.yaw_rad.is_finite()
    }
}
impl Rotation<Body, Ned> {
    /// Body-to-NED attitude from roll, pitch and yaw.
    ///
    /// # Source
    /// Equation (F5) of docs/equations.md.
    #[must_use]
    pub fn from_euler(angles: EulerAngles) -> Self {
        let (sin_r, cos_r) = libm::sincos(0.5 * angles.roll_rad);
        let (sin_p, cos_p) = libm::sincos(0.5 * angles.pitch_rad);
        let (sin_y, cos_y) = libm::sincos(0.5 * angles.yaw_rad);
        Self::claim(DQuat::from_xyzw(
            sin_r * cos_p * cos_y - cos_r * sin_p * sin_y,
            cos_r * sin_p * cos_y + sin_r * cos_p * sin_y,
            cos_r * cos_p * sin_y - sin_r * sin_p * cos_y,
            cos_r * cos_p * cos_y + sin_r * sin_p * sin_y,
        ))
    }

    /// Roll, pitch and yaw of this attitude. At ±90° of pitch, where only the sum or difference of
    /// roll and yaw exists, both are still finite and reproduce the attitude.
    ///
    /// # Source
    /// Equation (F6) of docs/equations.md.
    #[must_use]
    pub fn euler(self) -> EulerAngles {
        let DQuat { x, y, z, w } = self.quaternion();
        let sin_pitch = (2.0 * (w * y - x * z)).clamp(-1.0, 1.0);
        if libm::fabs(sin_pitch) > 1.0 - 1e-12 {
            let yaw_rad = wrap_angle(-2.0 * libm::copysign(1.0, sin_pitch) * libm::atan2(x, w));
            return EulerAngles { roll_rad: 0.0, pitch_rad: libm::asin(sin_pitch), yaw_rad };
        }
        EulerAngles {
            roll_rad: libm::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
            pitch_rad: libm::asin(sin_pitch),
            yaw_rad: libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
        }
    }
}
/// An angle brought into (−π, π]. NaN and infinities give NaN.
#[must_use]
pub fn wrap_angle(angle_rad: f64) -> f64 {
    use core::f64::consts::{PI, TAU};
    let wrapped = libm::remainder(angle_rad, TAU);
    if wrapped <= -PI { wrapped + TAU } else { wrapped }
}
