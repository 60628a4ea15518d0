//! Rotations whose types contain the frames from which and to which they rotate.

use core::fmt;
use core::marker::PhantomData;
use core::ops::Mul;

use glam::{DMat3, DQuat};

use super::Vector;
use crate::scalar::Scalar;

/// A rotation that resolves vectors of frame `From` in frame `To`.
///
/// The rotation is stored as a unit quaternion, Hamilton convention; the scalar is last in [`Rotation::quaternion`].
pub struct Rotation<From, To, T = f64> {
    /// Components x, y, z, w of the unit quaternion.
    quaternion: [T; 4],
    frames: PhantomData<(From, To)>,
}

impl<From, To> Rotation<From, To> {
    /// The rotation with a unit quaternion from `From` to `To`; the compiler cannot check the two frames.
    #[must_use]
    pub const fn claim(quaternion: DQuat) -> Self {
        Self::of_array(quaternion.to_array())
    }

    /// The unit quaternion.
    #[must_use]
    pub const fn quaternion(self) -> DQuat {
        DQuat::from_array(self.quaternion)
    }

    /// The rotation matrix (direction cosines), 3×3.
    #[must_use]
    pub fn matrix(self) -> DMat3 {
        DMat3::from_quat(self.quaternion())
    }
}

impl<From, To, T: Scalar> Rotation<From, To, T> {
    /// The rotation between frames that coincide.
    pub const IDENTITY: Self = Self::of_array([T::ZERO, T::ZERO, T::ZERO, T::ONE]);

    pub(crate) const fn of_array(quaternion: [T; 4]) -> Self {
        Self { quaternion, frames: PhantomData }
    }

    /// The unit quaternion as x, y, z, w.
    #[must_use]
    pub const fn to_array(self) -> [T; 4] {
        self.quaternion
    }

    /// The same rotation in numbers of another type.
    #[must_use]
    #[inline(always)]
    pub fn cast<U: Scalar>(self) -> Rotation<From, To, U> {
        Rotation::of_array(self.quaternion.map(|component| U::of(component.wide())))
    }

    /// The rotation matrix (direction cosines), row by row.
    #[must_use]
    #[inline]
    pub fn rows(self) -> [[T; 3]; 3] {
        let [x, y, z, w] = self.quaternion;
        let (x2, y2, z2) = (x + x, y + y, z + z);
        let (xx, xy, xz) = (x * x2, x * y2, x * z2);
        let (yy, yz, zz) = (y * y2, y * z2, z * z2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        [
            [T::ONE - (yy + zz), xy - wz, xz + wy],
            [xy + wz, T::ONE - (xx + zz), yz - wx],
            [xz - wy, yz + wx, T::ONE - (xx + yy)],
        ]
    }

    /// The inverse rotation, from `To` to `From`.
    #[must_use]
    #[inline]
    pub fn inverse(self) -> Rotation<To, From, T> {
        let [x, y, z, w] = self.quaternion;
        Rotation::of_array([-x, -y, -z, w])
    }

    /// This rotation after a rotation of the frame `From` by `angle_rad`, a rotation vector resolved in `From`. Gyro
    /// increments update a body-to-navigation attitude this way.
    ///
    /// # Source
    /// Equation (F2) of docs/equations.md.
    #[must_use]
    #[inline]
    pub fn turned_in_from(self, angle_rad: Vector<From, T>) -> Self {
        Self::of_array(product(self.quaternion, quaternion_of(angle_rad)))
    }

    /// This rotation followed by a rotation by `angle_rad`, a rotation vector resolved in `To`. Attitude corrections in
    /// the navigation frame are applied this way.
    #[must_use]
    #[inline]
    pub fn turned_in_to(self, angle_rad: Vector<To, T>) -> Self {
        Self::of_array(product(quaternion_of(angle_rad), self.quaternion))
    }

    /// The rotation vector of this rotation, rad, length in [0, π]. A rotation of [`IDENTITY`](Self::IDENTITY) by this
    /// vector gives this rotation.
    ///
    /// # Source
    /// Equation (F3) of docs/equations.md.
    #[must_use]
    pub fn rotation_vector(self) -> Vector<To, T> {
        let [x, y, z, w] = self.quaternion;
        let sign = if w < T::ZERO { -T::ONE } else { T::ONE };
        let sine = Vector::new(x, y, z) * sign;
        let length = sine.norm();
        // Below a length of 1e-8 the ratio is 2, to rounding.
        let ratio = if length < T::of(1e-8) {
            T::of(2.0)
        } else {
            T::of(2.0) * length.atan2(w * sign) / length
        };
        sine * ratio
    }

    /// The same rotation with its quaternion scaled to unit length, to first order. This is sufficient for rounding
    /// errors.
    ///
    /// # Source
    /// Equation (F4) of docs/equations.md.
    #[must_use]
    #[inline]
    pub fn renormalised(self) -> Self {
        let [x, y, z, w] = self.quaternion;
        let length_squared = x * x + y * y + z * z + w * w;
        let factor = T::of(1.5) - T::of(0.5) * length_squared;
        Self::of_array(self.quaternion.map(|component| component * factor))
    }

    /// Whether no component is NaN or infinite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.quaternion.iter().all(|component| component.is_finite())
    }
}

impl<From, To, T: Clone> Clone for Rotation<From, To, T> {
    fn clone(&self) -> Self {
        Self { quaternion: self.quaternion.clone(), frames: PhantomData }
    }
}

impl<From, To, T: Copy> Copy for Rotation<From, To, T> {}

impl<From, To, T: PartialEq> PartialEq for Rotation<From, To, T> {
    fn eq(&self, other: &Self) -> bool {
        self.quaternion == other.quaternion
    }
}

impl<From, To, T: fmt::Debug> fmt::Debug for Rotation<From, To, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(&self.quaternion).finish()
    }
}

impl<From, To, T: Scalar> Mul<Vector<From, T>> for Rotation<From, To, T> {
    type Output = Vector<To, T>;
    #[inline]
    fn mul(self, vector: Vector<From, T>) -> Vector<To, T> {
        let [x, y, z, w] = self.quaternion;
        let (vector, axis) = (Vector::from(vector.to_array()), Vector::new(x, y, z));
        let across = axis.cross(vector) * T::of(2.0);
        vector + across * w + axis.cross(across)
    }
}

impl<From, Through, To, T: Scalar> Mul<Rotation<From, Through, T>> for Rotation<Through, To, T> {
    type Output = Rotation<From, To, T>;
    #[inline]
    fn mul(self, first: Rotation<From, Through, T>) -> Rotation<From, To, T> {
        Rotation::of_array(product(self.quaternion, first.quaternion))
    }
}

/// The product of two quaternions.
#[inline]
fn product<T: Scalar>([x0, y0, z0, w0]: [T; 4], [x1, y1, z1, w1]: [T; 4]) -> [T; 4] {
    [
        w0 * x1 + x0 * w1 + y0 * z1 - z0 * y1,
        w0 * y1 - x0 * z1 + y0 * w1 + z0 * x1,
        w0 * z1 + x0 * y1 - y0 * x1 + z0 * w1,
        w0 * w1 - x0 * x1 - y0 * y1 - z0 * z1,
    ]
}

/// The exact quaternion of a rotation vector. Below 0.1 rad it is a series whose first omitted term is under 1e-17,
/// above it uses sine and cosine.
///
/// # Source
/// Equation (F1) of docs/equations.md.
#[inline]
pub(super) fn quaternion_of<F, T: Scalar>(angle_rad: Vector<F, T>) -> [T; 4] {
    let number = T::of;
    let one = T::ONE;
    let h = number(0.25) * angle_rad.dot(angle_rad);
    // Below 2e-4 rad two terms of the series give all digits; the rotation of the NED axes in one step never exceeds
    // this angle.
    let (cos_half, half_sinc) = if h < number(1e-8) {
        (one - h * number(0.5), number(0.5) * (one - h * number(1.0 / 6.0)))
    } else if h < number(0.0025) {
        let cosine = number(1.0 / 24.0) - h * (number(1.0 / 720.0) - h * number(1.0 / 40_320.0));
        let sine = number(1.0 / 120.0) - h * (number(1.0 / 5040.0) - h * number(1.0 / 362_880.0));
        (
            one - h * (number(0.5) - h * cosine),
            number(0.5) * (one - h * (number(1.0 / 6.0) - h * sine)),
        )
    } else {
        let half = h.sqrt();
        let (sin_half, cos_half) = half.sincos();
        (cos_half, number(0.5) * sin_half / half)
    };
    let [x, y, z] = angle_rad.to_array();
    [x * half_sinc, y * half_sinc, z * half_sinc, cos_half]
}
