//! Vectors that know the frame they are resolved in.

use core::fmt;
use core::marker::PhantomData;
use core::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use super::Ned;
use glam::DVec3;

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

impl Vector<Ned> {
    /// Direction of the horizontal part, clockwise from north, rad.
    #[must_use]
    pub fn azimuth_rad(self) -> f64 {
        libm::atan2(self.y(), self.x())
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
