//! Roll, pitch and yaw.

use super::{Body, Ned, Rotation};
use crate::scalar::Scalar;

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
        Self::of_angles(angles)
    }

    /// Roll, pitch and yaw of this attitude. At ±90° of pitch only the sum or difference of roll and yaw is defined;
    /// the two angles are still finite and reproduce the attitude.
    ///
    /// # Source
    /// Equation (F6) of docs/equations.md.
    #[must_use]
    pub fn euler(self) -> EulerAngles {
        let [roll_rad, pitch_rad, yaw_rad] = self.angles();
        EulerAngles { roll_rad, pitch_rad, yaw_rad }
    }
}

impl<T: Scalar> Rotation<Body, Ned, T> {
    /// Body-to-NED attitude from roll, pitch and yaw, as [`from_euler`](Rotation::from_euler), in numbers of any type.
    #[must_use]
    pub fn of_angles(angles: EulerAngles) -> Self {
        let half = |angle_rad: f64| T::of(0.5 * angle_rad).sincos();
        let (sin_r, cos_r) = half(angles.roll_rad);
        let (sin_p, cos_p) = half(angles.pitch_rad);
        let (sin_y, cos_y) = half(angles.yaw_rad);
        Self::of_array([
            sin_r * cos_p * cos_y - cos_r * sin_p * sin_y,
            cos_r * sin_p * cos_y + sin_r * cos_p * sin_y,
            cos_r * cos_p * sin_y - sin_r * sin_p * cos_y,
            cos_r * cos_p * cos_y + sin_r * sin_p * sin_y,
        ])
    }

    /// Roll, pitch and yaw of [`euler`](Rotation::euler), rad, in numbers of any type.
    #[must_use]
    pub fn angles(self) -> [T; 3] {
        let [x, y, z, w] = self.to_array();
        let two = T::of(2.0);
        let sin_pitch = self.sin_pitch();
        let (yaw_rad, pitch_rad) = (self.heading_rad(), sin_pitch.asin());
        if is_vertical(sin_pitch) {
            return [T::ZERO, pitch_rad, yaw_rad];
        }
        let roll_rad = (two * (w * x + y * z)).atan2(T::ONE - two * (x * x + y * y));
        [roll_rad, pitch_rad, yaw_rad]
    }

    /// Yaw of [`euler`](Rotation::euler), rad, computed without roll and pitch.
    #[must_use]
    pub fn heading_rad(self) -> T {
        let [x, y, z, w] = self.to_array();
        let two = T::of(2.0);
        let sin_pitch = self.sin_pitch();
        if is_vertical(sin_pitch) {
            let twice = if sin_pitch < T::ZERO { two } else { -two };
            return wrap_angle(twice * x.atan2(w));
        }
        (two * (w * z + x * y)).atan2(T::ONE - two * (y * y + z * z))
    }

    /// Sine and cosine of [`heading_rad`](Self::heading_rad), computed without the angle.
    #[must_use]
    pub fn heading_sincos(self) -> (T, T) {
        if is_vertical(self.sin_pitch()) {
            return self.heading_rad().sincos();
        }
        let [x, y, z, w] = self.to_array();
        let two = T::of(2.0);
        let (east, north) = (two * (w * z + x * y), T::ONE - two * (y * y + z * z));
        let level = (east * east + north * north).sqrt();
        if level == T::ZERO {
            return self.heading_rad().sincos();
        }
        (east / level, north / level)
    }

    fn sin_pitch(self) -> T {
        let [x, y, z, w] = self.to_array();
        let sine = T::of(2.0) * (w * y - x * z);
        // Written so that a NaN stays a NaN.
        let within = if sine > T::ONE { T::ONE } else { sine };
        if within < -T::ONE { -T::ONE } else { within }
    }
}

/// Whether pitch is ±90°, where only the sum or difference of roll and yaw is defined.
fn is_vertical<T: Scalar>(sin_pitch: T) -> bool {
    sin_pitch.abs() >= T::of(1.0 - 1e-12)
}

/// An angle wrapped into (−π, π]. NaN and infinities give NaN.
#[must_use]
pub fn wrap_angle<T: Scalar>(angle_rad: T) -> T {
    use core::f64::consts::{PI, TAU};
    if angle_rad.abs() < T::of(PI) {
        return angle_rad;
    }
    let wrapped = libm::remainder(angle_rad.wide(), TAU);
    T::of(if wrapped <= -PI { wrapped + TAU } else { wrapped })
}
