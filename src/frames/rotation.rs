//! Rotations that know the frames they lead from and to.

use core::fmt;
use core::marker::PhantomData;
use core::ops::Mul;

use glam::{DMat3, DQuat, DVec3};

use super::Vector;

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
    ///
    /// # Source
    /// Equation (F2) of docs/equations.md.
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
    ///
    /// # Source
    /// Equation (F3) of docs/equations.md.
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
    ///
    /// # Source
    /// Equation (F4) of docs/equations.md.
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
/// The quaternion of a rotation vector: exact, by a series below 0.1 rad whose first omitted term is
/// under 1e-17, by sine and cosine above.
///
/// # Source
/// Equation (F1) of docs/equations.md.
pub(super) fn quaternion_of(angle_rad: DVec3) -> DQuat {
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
