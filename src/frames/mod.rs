//! Frames as types. The type of a vector contains the frame in which it is resolved. The type of a rotation contains
//! the frames from which and to which it rotates.
//!
//! Adding a body vector to a navigation vector, or applying a rotation to a vector of another frame, does not compile.
//! The types hold only the numbers, so they cost nothing at run time.
//!
//! ```
//! use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector};
//!
//! let heading_east = EulerAngles { roll_rad: 0.0, pitch_rad: 0.0, yaw_rad: 90f64.to_radians() };
//! let body_to_ned = Rotation::from_euler(heading_east);
//! let forward: Vector<Body> = Vector::new(1.0, 0.0, 0.0);
//! let east: Vector<Ned> = body_to_ned * forward;
//! assert!((east.y() - 1.0).abs() < 1e-15);
//! ```
mod euler;
mod rotation;
mod vector;

pub use euler::{EulerAngles, wrap_angle};
pub use rotation::Rotation;
pub use vector::Vector;

/// Frame north, east, down at the vehicle: the navigation frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ned;

/// Frame forward, right, down of the vehicle: the body frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Body;

/// Frame Earth-centred, Earth-fixed (ECEF): x through the Greenwich meridian, z through the north pole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ecef;
#[cfg(test)]
mod tests {
    use super::rotation::quaternion_of;
    use super::*;
    use approx::assert_abs_diff_eq;
    use core::f64::consts::{FRAC_PI_2, PI};
    use proptest::prelude::*;

    fn angle_between<A, B>(a: Rotation<A, B>, b: Rotation<A, B>) -> f64 {
        let difference = a.quaternion().conjugate() * b.quaternion();
        2.0 * libm::atan2(difference.xyz().length(), libm::fabs(difference.w))
    }

    proptest! {
        #[test]
        fn euler_angles_reproduce_the_attitude(
            roll in -PI..PI, pitch in -FRAC_PI_2..FRAC_PI_2, yaw in -PI..PI,
        ) {
            let attitude = Rotation::from_euler(
                EulerAngles { roll_rad: roll, pitch_rad: pitch, yaw_rad: yaw });
            prop_assert!(angle_between(attitude, Rotation::from_euler(attitude.euler())) < 3e-6);
            prop_assert!((attitude.quaternion().length() - 1.0).abs() < 1e-15);
        }

        #[test]
        fn a_rotation_vector_and_its_negative_cancel(
            x in -3.0..3.0, y in -3.0..3.0, z in -3.0..3.0, scale in prop::sample::select(
                vec![1.0, 0.1, 1e-3, 1e-9]),
        ) {
            let turn = Vector::<Body>::new(x, y, z) * scale;
            let there: Rotation<Body, Ned> = Rotation::IDENTITY.turned_in_from(turn);
            prop_assert!(angle_between(there.turned_in_from(-turn), Rotation::IDENTITY) < 1e-15);
            prop_assert!((there.quaternion().length() - 1.0).abs() < 1e-15);
        }

        #[test]
        fn the_rotation_vector_comes_back(
            x in -1.8..1.8, y in -1.8..1.8, z in -1.8..1.8, scale in prop::sample::select(
                vec![1.0, 1e-3, 1e-9]),
        ) {
            let turn = Vector::<Ned>::new(x, y, z) * scale;
            let rotation: Rotation<Ned, Ned> = Rotation::IDENTITY.turned_in_to(turn);
            prop_assert!((rotation.rotation_vector() - turn).norm() < 1e-14 * scale.max(1e-2));
        }

        #[test]
        fn wrapped_angles_lie_in_the_half_open_circle(angle in -1e4..1e4) {
            let wrapped = wrap_angle(angle);
            prop_assert!(wrapped > -PI && wrapped <= PI);
            prop_assert!((libm::sin(wrapped) - libm::sin(angle)).abs() < 1e-11);
        }
    }

    #[test]
    fn the_series_meets_sine_and_cosine_where_they_change_over() {
        for angle in [0.0999, 0.1001] {
            let [x, _, _, w] = quaternion_of(Vector::<Ned>::new(angle, 0.0, 0.0));
            assert_abs_diff_eq!(x, libm::sin(0.5 * angle), epsilon = 1e-16);
            assert_abs_diff_eq!(w, libm::cos(0.5 * angle), epsilon = 1.2e-16);
        }
    }

    #[test]
    fn vertical_attitudes_have_finite_angles_that_reproduce_them() {
        for pitch in [FRAC_PI_2, -FRAC_PI_2] {
            for yaw in [-3.0, 0.4, 2.9] {
                let attitude = Rotation::from_euler(EulerAngles {
                    roll_rad: 0.3,
                    pitch_rad: pitch,
                    yaw_rad: yaw,
                });
                let angles = attitude.euler();
                assert!(angles.is_finite());
                assert!(angle_between(attitude, Rotation::from_euler(angles)) < 1e-6);
            }
        }
    }

    #[test]
    fn sine_and_cosine_of_the_heading_are_those_of_its_angle() {
        for pitch in [-FRAC_PI_2, -1.5, 0.0, 0.3, FRAC_PI_2] {
            for yaw in [-3.0, -0.1, 0.0, 1.6, 2.9] {
                let angles = EulerAngles { roll_rad: 0.3, pitch_rad: pitch, yaw_rad: yaw };
                let attitude = Rotation::<Body, Ned>::from_euler(angles);
                let (sine, cosine) = attitude.heading_sincos();
                let heading = attitude.heading_rad();
                assert!((sine - libm::sin(heading)).abs() < 1e-12, "{pitch} {yaw}");
                assert!((cosine - libm::cos(heading)).abs() < 1e-12, "{pitch} {yaw}");
            }
        }
    }

    #[test]
    fn half_a_turn_wraps_to_plus_pi() {
        assert_eq!(wrap_angle(-PI), PI);
        assert_eq!(wrap_angle(PI), PI);
        assert!(wrap_angle(f64::NAN).is_nan());
    }
}
