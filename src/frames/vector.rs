//! Vectors whose types contain the frame in which they are resolved.

use core::fmt;
use core::marker::PhantomData;
use core::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use super::Ned;
use crate::scalar::Scalar;
use glam::DVec3;

/// Three components resolved in frame `F`; the unit is in the name of the variable or field.
pub struct Vector<F, T = f64> {
    components: [T; 3],
    frame: PhantomData<F>,
}

impl<F> Vector<F> {
    /// A vector from plain components in frame `F`; the compiler cannot check the frame.
    #[must_use]
    pub const fn claim(components: DVec3) -> Self {
        Self { components: components.to_array(), frame: PhantomData }
    }

    /// The plain components, without their frame.
    #[must_use]
    pub const fn components(self) -> DVec3 {
        DVec3::from_array(self.components)
    }
}

impl<F, T: Scalar> Vector<F, T> {
    /// The zero vector.
    pub const ZERO: Self = Self::of_array([T::ZERO; 3]);

    /// A vector from its three components in frame `F`.
    #[must_use]
    pub const fn new(x: T, y: T, z: T) -> Self {
        Self::of_array([x, y, z])
    }

    const fn of_array(components: [T; 3]) -> Self {
        Self { components, frame: PhantomData }
    }

    /// First component: north (NED), forward (body) or Greenwich meridian (ECEF).
    #[must_use]
    pub const fn x(self) -> T {
        self.components[0]
    }

    /// Second component: east (NED), right (body) or 90° east (ECEF).
    #[must_use]
    pub const fn y(self) -> T {
        self.components[1]
    }

    /// Third component: down (NED), down (body) or north pole (ECEF).
    #[must_use]
    pub const fn z(self) -> T {
        self.components[2]
    }

    /// The three components as an array.
    #[must_use]
    pub const fn to_array(self) -> [T; 3] {
        self.components
    }

    /// The same vector in numbers of another type.
    #[must_use]
    #[inline(always)]
    pub fn cast<U: Scalar>(self) -> Vector<F, U> {
        Vector::of_array(self.components.map(|component| U::of(component.wide())))
    }

    /// Inner product.
    #[must_use]
    #[inline]
    pub fn dot(self, other: Self) -> T {
        let ([x, y, z], [a, b, c]) = (self.components, other.components);
        x * a + y * b + z * c
    }

    /// Vector product `self × other`.
    #[must_use]
    #[inline]
    pub fn cross(self, other: Self) -> Self {
        let ([x, y, z], [a, b, c]) = (self.components, other.components);
        Self::new(y * c - b * z, z * a - c * x, x * b - a * y)
    }

    /// Euclidean length.
    #[must_use]
    #[inline]
    pub fn norm(self) -> T {
        self.dot(self).sqrt()
    }

    /// Whether the length is below `limit`, which must be positive; `false` for NaN. It needs no square root.
    #[must_use]
    #[inline]
    pub fn is_shorter_than(self, limit: T) -> bool {
        self.dot(self) < limit * limit
    }

    /// Whether no component is NaN or infinite.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.components.iter().all(|component| component.is_finite())
    }

    #[inline(always)]
    fn zip(self, other: Self, combine: impl Fn(T, T) -> T) -> Self {
        let ([x, y, z], [a, b, c]) = (self.components, other.components);
        Self::new(combine(x, a), combine(y, b), combine(z, c))
    }
}

impl<T: Scalar> Vector<Ned, T> {
    /// Direction of the horizontal part, clockwise from north, rad.
    #[must_use]
    pub fn azimuth_rad(self) -> T {
        self.y().atan2(self.x())
    }
}

impl<F, T: Clone> Clone for Vector<F, T> {
    fn clone(&self) -> Self {
        Self { components: self.components.clone(), frame: PhantomData }
    }
}

impl<F, T: Copy> Copy for Vector<F, T> {}

impl<F, T: PartialEq> PartialEq for Vector<F, T> {
    fn eq(&self, other: &Self) -> bool {
        self.components == other.components
    }
}

impl<F, T: Default> Default for Vector<F, T> {
    fn default() -> Self {
        Self { components: Default::default(), frame: PhantomData }
    }
}

impl<F, T: fmt::Debug> fmt::Debug for Vector<F, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(&self.components).finish()
    }
}

impl<F, T: Scalar> From<[T; 3]> for Vector<F, T> {
    fn from(components: [T; 3]) -> Self {
        Self::of_array(components)
    }
}

impl<F, T: Scalar> Add for Vector<F, T> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<F, T: Scalar> AddAssign for Vector<F, T> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<F, T: Scalar> Sub for Vector<F, T> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<F, T: Scalar> SubAssign for Vector<F, T> {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<F, T: Scalar> Neg for Vector<F, T> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        let [x, y, z] = self.components;
        Self::new(-x, -y, -z)
    }
}

impl<F, T: Scalar> Mul<T> for Vector<F, T> {
    type Output = Self;
    #[inline]
    fn mul(self, factor: T) -> Self {
        let [x, y, z] = self.components;
        Self::new(x * factor, y * factor, z * factor)
    }
}
