//! Solutions relative to the first solution in east, north and up, with body axes forward, left and up.

use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav::frames::{Body, Ned, Rotation, Vector};
use hovernav::glam::DQuat;

/// Rotation from NED to ENU: half a turn about the line between north and east.
const ENU_FROM_NED: DQuat =
    DQuat::from_xyzw(std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0);
/// Rotation from forward, left, up to forward, right, down: half a turn about the nose.
const FRD_FROM_FLU: DQuat = DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0);

/// NED components as east, north, up.
pub fn enu(ned: Vector<Ned>) -> [f64; 3] {
    [ned.y(), ned.x(), -ned.z()]
}

/// Body components as forward, left, up.
pub fn flu(body: Vector<Body>) -> [f64; 3] {
    [body.x(), -body.y(), -body.z()]
}

/// The attitude from forward, left, up to east, north, up as a quaternion x, y, z, w with w ≥ 0.
pub fn flu_to_enu(body_to_ned: Rotation<Body, Ned>) -> [f64; 4] {
    let quaternion = ENU_FROM_NED * body_to_ned.quaternion() * FRD_FROM_FLU;
    (if quaternion.w < 0.0 { -quaternion } else { quaternion }).to_array()
}

/// Position relative to `origin`, m, east, north and up.
pub fn position_m(solution: &Solution, origin: &Geodetic) -> [f64; 3] {
    enu(solution.position.local_ned_m(origin))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use hovernav::frames::EulerAngles;

    #[test]
    fn level_and_eastwards_is_no_rotation_at_all() {
        let east = Rotation::from_euler(EulerAngles::from_degrees(0.0, 0.0, 90.0));
        let [x, y, z, w] = flu_to_enu(east);
        assert!(x.hypot(y).hypot(z) < 1e-12 && (w - 1.0).abs() < 1e-12, "{x} {y} {z} {w}");
        let north = Rotation::from_euler(EulerAngles::from_degrees(0.0, 0.0, 0.0));
        let [x, y, z, w] = flu_to_enu(north);
        let half = std::f64::consts::FRAC_1_SQRT_2;
        assert_abs_diff_eq!(z, half, epsilon = 1e-12);
        assert_abs_diff_eq!(w, half, epsilon = 1e-12);
        assert!(x.hypot(y) < 1e-12);
    }
}
