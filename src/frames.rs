//! Frames as types: a vector knows what it is resolved in, a rotation what it leads from and to.
//!
//! Adding a body vector to a navigation vector, or rotating the wrong way, does not compile. The
//! types hold nothing but the numbers, so they cost nothing at run time.
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

use core::fmt;
use core::marker::PhantomData;
use core::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use glam::{DMat3, DQuat, DVec3};

/// North, east, down at the vehicle: the navigation frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ned;

/// Forward, right, down in the vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Body;

/// Earth-centred, Earth-fixed: x through the Greenwich meridian, z through the north pole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ecef;

/// Three components resolved in frame `F`; the unit is in the name of whatever holds it.
pub struct Vector<F> {
    components: DVec3,
    frame: PhantomData<F>,
}

impl<F> Vector<F> {
    /// The zero vector.
    pub const ZERO: Self = Self::claim(DVec3::ZERO);

    /// A vector from its three components in frame `F`.
    #[must_use]
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self::claim(DVec3::new(x, y, z))
    }

    /// Claims that plain components are resolved in frame `F`: the named door into the frame.
    #[must_use]
    pub const fn claim(components: DVec3) -> Self {
        Self { components, frame: PhantomData }
    }

    /// The plain components: the named door out of the frame.
    #[must_use]
    pub const fn components(self) -> DVec3 {
        self.components
    }

    /// First component: north, forward or Greenwich.
    #[must_use]
    pub const fn x(self) -> f64 {
        self.components.x
    }

    /// Second component: east, right or 90° east.
    #[must_use]
    pub const fn y(self) -> f64 {
        self.components.y
    }

    /// Third component: down, down or north pole.
    #[must_use]
    pub const fn z(self) -> f64 {
        self.components.z
    }

    /// The three components as an array.
    #[must_use]
    pub const fn to_array(self) -> [f64; 3] {
        self.components.to_array()
    }

    /// Inner product.
    #[must_use]
    pub fn dot(self, other: Self) -> f64 {
        self.components.dot(other.components)
    }

    /// Vector product `self × other`.
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        Self::claim(self.components.cross(other.components))
    }

    /// Euclidean length.
    #[must_use]
    pub fn norm(self) -> f64 {
        self.components.length()
    }

    /// Whether no component is NaN or infinite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.components.is_finite()
    }
}

impl<F> Clone for Vector<F> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<F> Copy for Vector<F> {}

impl<F> PartialEq for Vector<F> {
    fn eq(&self, other: &Self) -> bool {
        self.components == other.components
    }
}

impl<F> Default for Vector<F> {
    fn default() -> Self {
        Self::ZERO
    }
}

impl<F> fmt::Debug for Vector<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.to_array()).finish()
    }
}

impl<F> From<[f64; 3]> for Vector<F> {
    fn from(components: [f64; 3]) -> Self {
        Self::claim(DVec3::from_array(components))
    }
}

impl<F> Add for Vector<F> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::claim(self.components + other.components)
    }
}

impl<F> AddAssign for Vector<F> {
    fn add_assign(&mut self, other: Self) {
        self.components += other.components;
    }
}

impl<F> Sub for Vector<F> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::claim(self.components - other.components)
    }
}

impl<F> SubAssign for Vector<F> {
    fn sub_assign(&mut self, other: Self) {
        self.components -= other.components;
    }
}

impl<F> Neg for Vector<F> {
    type Output = Self;
    fn neg(self) -> Self {
        Self::claim(-self.components)
    }
}

impl<F> Mul<f64> for Vector<F> {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self::claim(self.components * factor)
    }
}

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

/// A rotation that re-resolves vectors of frame `From` in frame `To`.
///
/// Held as a unit quaternion, Hamilton convention, scalar last in [`Rotation::quaternion`].
pub struct Rotation<From, To> {
    quaternion: DQuat,
    frames: PhantomData<(From, To)>,
}

impl<From, To> Rotation<From, To> {
    /// The frames coincide.
    pub const IDENTITY: Self = Self::claim(DQuat::IDENTITY);

    /// Claims that a unit quaternion leads from `From` to `To`: the named door into the frames.
    #[must_use]
    pub const fn claim(quaternion: DQuat) -> Self {
        Self { quaternion, frames: PhantomData }
    }

    /// The unit quaternion.
    #[must_use]
    pub const fn quaternion(self) -> DQuat {
        self.quaternion
    }

    /// The rotation matrix (direction cosines), 3×3.
    #[must_use]
    pub fn matrix(self) -> DMat3 {
        DMat3::from_quat(self.quaternion)
    }

    /// The rotation that leads back.
    #[must_use]
    pub fn inverse(self) -> Rotation<To, From> {
        Rotation::claim(self.quaternion.conjugate())
    }

    /// This rotation preceded by a rotation of `From` about itself by `angle_rad` (a rotation
    /// vector resolved in `From`): how gyro increments move a body-to-navigation attitude.
    #[must_use]
    pub fn turned_in_from(self, angle_rad: Vector<From>) -> Self {
        Self::claim(self.quaternion * quaternion_of(angle_rad.components()))
    }

    /// This rotation followed by a rotation of `To` about itself by `angle_rad` (a rotation vector
    /// resolved in `To`): how a navigation-frame attitude correction is applied.
    #[must_use]
    pub fn turned_in_to(self, angle_rad: Vector<To>) -> Self {
        Self::claim(quaternion_of(angle_rad.components()) * self.quaternion)
    }

    /// The rotation vector of this rotation, rad, length in [0, π]: the inverse of turning
    /// [`IDENTITY`](Self::IDENTITY) by it.
    #[must_use]
    pub fn rotation_vector(self) -> Vector<To> {
        let shortest = if self.quaternion.w < 0.0 { -self.quaternion } else { self.quaternion };
        let sine = shortest.xyz();
        let length = sine.length();
        // Below 1e-8 the ratio is 2 to rounding.
        let ratio =
            if length < 1e-8 { 2.0 } else { 2.0 * libm::atan2(length, shortest.w) / length };
        Vector::claim(sine * ratio)
    }

    /// Rescaled to unit length to first order, which is all that rounding ever asks for.
    #[must_use]
    pub fn renormalised(self) -> Self {
        Self::claim(self.quaternion * (1.5 - 0.5 * self.quaternion.length_squared()))
    }
}

impl<From, To> Clone for Rotation<From, To> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<From, To> Copy for Rotation<From, To> {}

impl<From, To> PartialEq for Rotation<From, To> {
    fn eq(&self, other: &Self) -> bool {
        self.quaternion == other.quaternion
    }
}

impl<From, To> fmt::Debug for Rotation<From, To> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.quaternion, f)
    }
}

impl<From, To> Mul<Vector<From>> for Rotation<From, To> {
    type Output = Vector<To>;
    fn mul(self, vector: Vector<From>) -> Vector<To> {
        Vector::claim(self.quaternion * vector.components())
    }
}

impl<From, Through, To> Mul<Rotation<From, Through>> for Rotation<Through, To> {
    type Output = Rotation<From, To>;
    fn mul(self, first: Rotation<From, Through>) -> Rotation<From, To> {
        Rotation::claim(self.quaternion * first.quaternion)
    }
}

impl Rotation<Body, Ned> {
    /// Body-to-NED attitude from roll, pitch and yaw.
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
    #[must_use]
    pub fn euler(self) -> EulerAngles {
        let DQuat { x, y, z, w } = self.quaternion;
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

/// The quaternion of a rotation vector: exact, by a series below 0.1 rad whose first omitted term is
/// under 1e-17, by sine and cosine above.
fn quaternion_of(angle_rad: DVec3) -> DQuat {
    let h = 0.25 * angle_rad.length_squared();
    let (cos_half, half_sinc) = if h < 0.0025 {
        (
            1.0 - h * (1.0 / 2.0 - h * (1.0 / 24.0 - h * (1.0 / 720.0 - h / 40320.0))),
            0.5 * (1.0 - h * (1.0 / 6.0 - h * (1.0 / 120.0 - h * (1.0 / 5040.0 - h / 362_880.0)))),
        )
    } else {
        let half = libm::sqrt(h);
        let (sin_half, cos_half) = libm::sincos(half);
        (cos_half, 0.5 * sin_half / half)
    };
    DQuat::from_xyzw(
        angle_rad.x * half_sinc,
        angle_rad.y * half_sinc,
        angle_rad.z * half_sinc,
        cos_half,
    )
}

/// An angle brought into (−π, π]. NaN and infinities give NaN.
#[must_use]
pub fn wrap_angle(angle_rad: f64) -> f64 {
    use core::f64::consts::{PI, TAU};
    let wrapped = libm::remainder(angle_rad, TAU);
    if wrapped <= -PI { wrapped + TAU } else { wrapped }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{FRAC_PI_2, PI};
    use proptest::prelude::*;

    fn angle_between<A, B>(a: Rotation<A, B>, b: Rotation<A, B>) -> f64 {
        let difference = a.quaternion.conjugate() * b.quaternion;
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
            prop_assert!((attitude.quaternion.length() - 1.0).abs() < 1e-15);
        }

        #[test]
        fn a_rotation_vector_and_its_negative_cancel(
            x in -3.0..3.0, y in -3.0..3.0, z in -3.0..3.0, scale in prop::sample::select(
                vec![1.0, 0.1, 1e-3, 1e-9]),
        ) {
            let turn = Vector::<Body>::new(x, y, z) * scale;
            let there: Rotation<Body, Ned> = Rotation::IDENTITY.turned_in_from(turn);
            prop_assert!(angle_between(there.turned_in_from(-turn), Rotation::IDENTITY) < 1e-15);
            prop_assert!((there.quaternion.length() - 1.0).abs() < 1e-15);
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
            let q = quaternion_of(DVec3::new(angle, 0.0, 0.0));
            assert!((q.x - libm::sin(0.5 * angle)).abs() < 1e-16);
            assert!((q.w - libm::cos(0.5 * angle)).abs() < 1.2e-16);
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
    fn half_a_turn_wraps_to_plus_pi() {
        assert_eq!(wrap_angle(-PI), PI);
        assert_eq!(wrap_angle(PI), PI);
        assert!(wrap_angle(f64::NAN).is_nan());
    }
}
