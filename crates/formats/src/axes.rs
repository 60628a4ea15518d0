//! Conversions from the axes of other programs to hovernav's.

use glam::DQuat;
#[cfg(feature = "ros2")]
use hovernav::frames::Vector;
use hovernav::frames::{Body, Ned, Rotation};

/// Attitude from a quaternion that rotates forward-right-down to north-east-down, scalar first. `None` if the
/// quaternion's length differs from 1 by 0.1 or more.
pub(crate) fn attitude_frd_ned([w, x, y, z]: [f64; 4]) -> Option<Rotation<Body, Ned>> {
    unit(DQuat::from_xyzw(x, y, z, w)).map(Rotation::claim)
}

/// Attitude from a quaternion that rotates forward-left-up to east-north-up, scalar first. `None` if the quaternion's
/// length differs from 1 by 0.1 or more.
///
/// # Source
/// REP 103, *Standard Units of Measure and Coordinate Conventions*, section Coordinate Frame Conventions. The two
/// rotations are by 180° each, about x and about the bisector of x and y.
pub(crate) fn attitude_flu_enu([w, x, y, z]: [f64; 4]) -> Option<Rotation<Body, Ned>> {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let enu_to_ned = DQuat::from_xyzw(half, half, 0.0, 0.0);
    let frd_to_flu = DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0);
    let flu_to_enu = unit(DQuat::from_xyzw(x, y, z, w))?;
    Some(Rotation::claim(enu_to_ned * flu_to_enu * frd_to_flu))
}

/// Converts a vector from forward-left-up axes to body axes.
#[cfg(feature = "ros2")]
pub(crate) fn body_from_flu([forward, left, up]: [f64; 3]) -> Vector<Body> {
    Vector::new(forward, -left, -up)
}

fn unit(quaternion: DQuat) -> Option<DQuat> {
    let length = quaternion.length();
    (length.is_finite() && (length - 1.0).abs() < 0.1).then(|| quaternion.normalize())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn level_and_facing_east_is_identity_in_enu_and_yaw_90_in_ned() {
        let attitude = attitude_flu_enu([1.0, 0.0, 0.0, 0.0]).unwrap().euler();
        let [roll, pitch, yaw] = attitude.to_degrees();
        assert_abs_diff_eq!(roll, 0.0, epsilon = 1e-9);
        assert_abs_diff_eq!(pitch, 0.0, epsilon = 1e-9);
        assert_abs_diff_eq!(yaw, 90.0, epsilon = 1e-9);
    }

    #[test]
    fn nose_up_is_positive_pitch_in_all_axes() {
        // A rotation by −10° about left, in forward-left-up axes, is nose up by 10°.
        let half = 5.0f64.to_radians();
        let attitude = attitude_flu_enu([half.cos(), 0.0, -half.sin(), 0.0]).unwrap().euler();
        assert_abs_diff_eq!(attitude.pitch_rad.to_degrees(), 10.0, epsilon = 1e-9);
        assert_eq!(attitude_frd_ned([0.0; 4]), None);
        assert_eq!(attitude_frd_ned([f64::NAN; 4]), None);
    }
}
