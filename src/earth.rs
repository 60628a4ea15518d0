//! Earth model of the filter: the WGS-84 ellipsoid, its normal gravity and its rotation.
//!
//! Sources: NIMA TR8350.2, *Department of Defense World Geodetic System 1984*, third edition,
//! amendment 1 (constants: tables 3.1 to 3.4; gravity: equations 4-1 and 4-3); Groves, *Principles
//! of GNSS, Inertial, and Multisensor Integrated Navigation Systems*, second edition, chapter 2.
//!
//! Conversions are valid over the whole globe, poles and date line included, from 5 000 km below to 10 000 000 km
//! above the ellipsoid. Gravity is accurate to 1e-6 m/s² up to 15 km. North is undefined at the poles:
//! [`transport_rate`](LocalEarth::transport_rate) grows without bound there. Navigation in NED therefore requires
//! [`Geodetic::is_navigable`].

use core::f64::consts::FRAC_PI_2;

use glam::{DMat3, DQuat, DVec3};

use crate::frames::{Ecef, Ned, Rotation, Vector, wrap_angle};
use crate::scalar::Scalar;

/// Equatorial radius, m (TR8350.2 table 3.1: defining).
pub const SEMI_MAJOR_AXIS_M: f64 = 6_378_137.0;
/// Flattening (TR8350.2 table 3.1: 1/f = 298.257223563, defining).
pub const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// Square of the first eccentricity, f (2 − f).
pub const ECCENTRICITY_SQUARED: f64 = FLATTENING * (2.0 - FLATTENING);
/// Polar radius, m, a (1 − f).
pub const SEMI_MINOR_AXIS_M: f64 = SEMI_MAJOR_AXIS_M * (1.0 - FLATTENING);
/// Rotation rate of the Earth, rad/s (TR8350.2 table 3.1: defining).
pub const EARTH_RATE_RADPS: f64 = 7.292_115e-5;
/// Standard gravity, m/s²: the unit "g" of an inertial unit, and the factor from acceleration to tilt. Source: 3rd
/// CGPM (1901).
pub const STANDARD_GRAVITY_MPS2: f64 = 9.806_65;
/// Normal gravity at the equator, m/s² (TR8350.2 table 3.4).
pub const EQUATORIAL_GRAVITY_MPS2: f64 = 9.780_325_335_9;
/// Somigliana's constant k (TR8350.2 table 3.4).
pub const SOMIGLIANA_K: f64 = 0.001_931_852_652_41;
/// Ratio m = ω² a² b / GM of the gravity formula (TR8350.2 table 3.4).
pub const GRAVITY_RATIO_M: f64 = 0.003_449_786_506_84;

/// Largest height above the ellipsoid, or depth below it, at which vehicles navigate, m.
const HIGHEST_M: f64 = 1e5;

/// A position as geodetic latitude, longitude and height above the WGS-84 ellipsoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geodetic {
    /// Geodetic latitude, north positive, in [−π/2, π/2].
    pub latitude_rad: f64,
    /// Longitude, east positive, in (−π, π].
    pub longitude_rad: f64,
    /// Height above the ellipsoid (not above mean sea level), m.
    pub height_m: f64,
}

impl Geodetic {
    /// Creates a position from degrees and metres.
    ///
    /// `None` when a value is not finite, the latitude is beyond ±90°, the longitude beyond ±360°, or the height
    /// beyond ±100 km.
    #[must_use]
    pub fn from_degrees(latitude_deg: f64, longitude_deg: f64, height_m: f64) -> Option<Self> {
        let on_earth = libm::fabs(latitude_deg) <= 90.0
            && libm::fabs(longitude_deg) <= 360.0
            && libm::fabs(height_m) <= HIGHEST_M;
        on_earth.then(|| Self {
            latitude_rad: latitude_deg.to_radians(),
            longitude_rad: wrap_angle(longitude_deg.to_radians()),
            height_m,
        })
    }

    /// Latitude in degrees.
    #[must_use]
    pub fn latitude_deg(&self) -> f64 {
        self.latitude_rad.to_degrees()
    }

    /// Longitude in degrees, in (−180, 180].
    #[must_use]
    pub fn longitude_deg(&self) -> f64 {
        self.longitude_rad.to_degrees()
    }

    /// Whether north is defined well enough at this position to navigate in NED. Requires a latitude within ±89.9°, a
    /// height within ±100 km of the ellipsoid, and finite values. At 89.9°, 11 km from a pole, 10 m/s eastwards turns
    /// the frame at 0.05°/s.
    #[must_use]
    pub fn is_navigable(&self) -> bool {
        libm::fabs(self.latitude_rad) <= 89.9f64.to_radians()
            && self.longitude_rad.is_finite()
            && libm::fabs(self.height_m) <= HIGHEST_M
    }

    /// Earth-centred, Earth-fixed coordinates of this position, m (Groves 2.112).
    ///
    /// # Source
    /// Equation (E2) of docs/equations.md.
    #[must_use]
    pub fn to_ecef(&self) -> Vector<Ecef> {
        let (sin_lat, cos_lat) = self.latitude_rad.sincos();
        let (sin_lon, cos_lon) = self.longitude_rad.sincos();
        let prime_vertical_m = prime_vertical_radius_m(sin_lat);
        let across = (prime_vertical_m + self.height_m) * cos_lat;
        let along = (prime_vertical_m * (1.0 - ECCENTRICITY_SQUARED) + self.height_m) * sin_lat;
        Vector::new(across * cos_lon, across * sin_lon, along)
    }

    /// The position with the Earth-centred, Earth-fixed coordinates `position_m`.
    ///
    /// Bowring's iteration on the parametric latitude converges to rounding in at most four iterations over the
    /// heights of this module. `None` for NaN or infinities, and within 1 000 km of the Earth's centre, where
    /// latitude is not defined.
    ///
    /// # Source
    /// B. R. Bowring (1976), Transformation from spatial to geographical coordinates, *Survey
    /// Review* 23 (181), 323–327.
    /// Equation (E3) of docs/equations.md.
    #[must_use]
    pub fn from_ecef(position_m: Vector<Ecef>) -> Option<Self> {
        if !(position_m.norm() > 1e6 && position_m.is_finite()) {
            return None;
        }
        let [x, y, z] = position_m.to_array();
        let across = Scalar::hypot(x, y);
        let second_eccentricity_squared = ECCENTRICITY_SQUARED / (1.0 - ECCENTRICITY_SQUARED);
        let mut parametric = libm::atan2(z, across * (1.0 - FLATTENING));
        let mut latitude_rad = parametric;
        for _ in 0..4 {
            let (sin_b, cos_b) = parametric.sincos();
            latitude_rad = libm::atan2(
                z + second_eccentricity_squared * SEMI_MINOR_AXIS_M * sin_b * sin_b * sin_b,
                across - ECCENTRICITY_SQUARED * SEMI_MAJOR_AXIS_M * cos_b * cos_b * cos_b,
            );
            let (sin_lat, cos_lat) = latitude_rad.sincos();
            parametric = libm::atan2((1.0 - FLATTENING) * sin_lat, cos_lat);
        }
        let (sin_lat, cos_lat) = latitude_rad.sincos();
        let height_m = across * cos_lat + z * sin_lat
            - SEMI_MAJOR_AXIS_M * SEMI_MAJOR_AXIS_M / prime_vertical_radius_m(sin_lat);
        Some(Self { latitude_rad, longitude_rad: wrap_angle(libm::atan2(y, x)), height_m })
    }

    /// Rotation from Earth-fixed axes to north, east, down at this position (Groves 2.150).
    ///
    /// # Source
    /// Equation (E4) of docs/equations.md.
    #[must_use]
    pub fn ecef_to_ned(&self) -> Rotation<Ecef, Ned> {
        let (sin_lat, cos_lat) = self.latitude_rad.sincos();
        let (sin_lon, cos_lon) = self.longitude_rad.sincos();
        Rotation::claim(DQuat::from_mat3(&DMat3::from_cols(
            DVec3::new(-sin_lat * cos_lon, -sin_lon, -cos_lat * cos_lon),
            DVec3::new(-sin_lat * sin_lon, cos_lon, -cos_lat * sin_lon),
            DVec3::new(cos_lat, 0.0, -sin_lat),
        )))
    }

    /// Straight-line vector from `origin` to this position, m, resolved in the north, east and down of `origin`. It is
    /// exact at any distance.
    ///
    /// # Source
    /// Equation (E5) of docs/equations.md.
    #[must_use]
    pub fn local_ned_m(&self, origin: &Self) -> Vector<Ned> {
        origin.ecef_to_ned() * (self.to_ecef() - origin.to_ecef())
    }

    /// The position at `offset_m` from `origin`, resolved in the north, east and down of `origin`: the inverse of
    /// [`local_ned_m`](Self::local_ned_m). `None` near the Earth's centre and for NaN.
    #[must_use]
    pub fn from_local_ned(origin: &Self, offset_m: Vector<Ned>) -> Option<Self> {
        Self::from_ecef(origin.to_ecef() + origin.ecef_to_ned().inverse() * offset_m)
    }

    /// This position moved by a small NED displacement along the curved surface, computed with the radii of curvature;
    /// for filter corrections and lever arms. The error grows with the square of the distance. Below 80° of latitude it
    /// is under 1 µm within 1 m and under 6 mm within 100 m.
    #[must_use]
    pub fn displaced<T: Scalar>(&self, displacement_m: Vector<Ned, T>) -> Self {
        LocalEarth::about(self).displaced(self, displacement_m)
    }

    /// Small NED displacement from `from` to this position, m, computed with the radii of curvature at `from`: the
    /// inverse of [`displaced`](Self::displaced).
    #[must_use]
    pub fn displacement_from(&self, from: &Self) -> Vector<Ned> {
        LocalEarth::at(from).displacement(from, self)
    }
}

/// Quantities of the Earth model that navigation needs at one position, computed from one sine and one cosine.
#[derive(Clone, Copy, Debug)]
pub struct LocalEarth<T = f64> {
    /// Meridian radius of curvature plus height, m: metres of northing per radian of latitude.
    pub north_radius_m: T,
    /// Prime-vertical radius of curvature plus height, m.
    pub east_radius_m: T,
    /// Normal gravity at this height, m/s², straight down.
    pub gravity_mps2: T,
    /// Rotation of the Earth relative to inertial space, rad/s.
    pub earth_rate_radps: Vector<Ned, T>,
    sin_latitude: T,
    cos_latitude: T,
}

impl LocalEarth {
    /// The Earth model at the position `place`.
    ///
    /// Gravity is Somigliana's formula on the ellipsoid, extended to height by the second-order series (TR8350.2
    /// equations 4-1 and 4-3). Its northward component above the ellipsoid (8e-9 h sin 2φ, Groves 2.140: 1 µm/s² at 120
    /// m) is neglected.
    ///
    /// # Source
    /// Equations (E1), (E6) and (E7) of docs/equations.md.
    #[must_use]
    pub fn at(place: &Geodetic) -> Self {
        Self::about(place)
    }
}

impl<T: Scalar> LocalEarth<T> {
    /// The Earth model at the position `place`, as [`at`](LocalEarth::at), in any number type.
    #[must_use]
    pub fn about(place: &Geodetic) -> Self {
        let number = T::of;
        let (one, three, two) = (T::ONE, number(3.0), number(2.0));
        let (sin_latitude, cos_latitude) = number(place.latitude_rad).sincos();
        let height_m = number(place.height_m);
        let sin_squared = sin_latitude * sin_latitude;
        let flat = one - number(ECCENTRICITY_SQUARED) * sin_squared;
        let root = flat.sqrt();
        let prime_vertical_m = number(SEMI_MAJOR_AXIS_M) / root;
        let meridian_m = prime_vertical_m * number(1.0 - ECCENTRICITY_SQUARED) / flat;
        let surface_gravity =
            number(EQUATORIAL_GRAVITY_MPS2) * (one + number(SOMIGLIANA_K) * sin_squared) / root;
        let h = height_m * number(1.0 / SEMI_MAJOR_AXIS_M);
        let slope =
            number(1.0 + FLATTENING + GRAVITY_RATIO_M) - number(2.0 * FLATTENING) * sin_squared;
        let earth_rate = number(EARTH_RATE_RADPS);
        Self {
            north_radius_m: meridian_m + height_m,
            east_radius_m: prime_vertical_m + height_m,
            gravity_mps2: surface_gravity * (one - two * slope * h + three * h * h),
            earth_rate_radps: Vector::new(
                earth_rate * cos_latitude,
                T::ZERO,
                -earth_rate * sin_latitude,
            ),
            sin_latitude,
            cos_latitude,
        }
    }

    /// Rotation rate of the NED axes relative to the Earth, caused by motion over the Earth, rad/s (Groves 5.44).
    ///
    /// # Source
    /// Equation (E8) of docs/equations.md.
    #[must_use]
    pub fn transport_rate(&self, velocity_mps: Vector<Ned, T>) -> Vector<Ned, T> {
        let about_north = velocity_mps.y() / self.east_radius_m;
        Vector::new(
            about_north,
            -velocity_mps.x() / self.north_radius_m,
            -about_north * self.sin_latitude / self.cos_latitude,
        )
    }

    /// The position `from` moved by a small displacement; `self` must be the Earth model at or near `from`.
    ///
    /// # Source
    /// Equation (E9) of docs/equations.md.
    #[must_use]
    pub fn displaced(&self, from: &Geodetic, displacement_m: Vector<Ned, T>) -> Geodetic {
        let across_m = self.east_radius_m * self.cos_latitude;
        // Single precision is sufficient for the angles of a small displacement; the sums are computed in double
        // precision.
        let latitude_rad = from.latitude_rad + (displacement_m.x() / self.north_radius_m).wide();
        let longitude_rad = from.longitude_rad + (displacement_m.y() / across_m).wide();
        Geodetic {
            latitude_rad: latitude_rad.clamp(-FRAC_PI_2, FRAC_PI_2),
            longitude_rad: if libm::fabs(longitude_rad) >= core::f64::consts::PI {
                wrap_angle(longitude_rad)
            } else {
                longitude_rad
            },
            height_m: from.height_m - displacement_m.z().wide(),
        }
    }

    /// The position `from` moved by the displacement of one integration step. The radii are those at the middle of the
    /// step, so the result is accurate to second order in the step's length. `self` must be the Earth model at `from`.
    ///
    /// # Source
    /// Equation (E10) of docs/equations.md.
    #[must_use]
    pub fn carried(&self, from: &Geodetic, travel_m: Vector<Ned, T>) -> Geodetic {
        let half = T::of(0.5);
        let half_climb_m = -half * travel_m.z();
        let half_north_rad = half * travel_m.x() / (self.north_radius_m + half_climb_m);
        let middle = Self {
            north_radius_m: self.north_radius_m + half_climb_m,
            east_radius_m: self.east_radius_m + half_climb_m,
            cos_latitude: self.cos_latitude - self.sin_latitude * half_north_rad,
            ..*self
        };
        middle.displaced(from, travel_m)
    }

    /// Small displacement between two positions, m; `self` must be the Earth model at or near them.
    #[must_use]
    pub fn displacement(&self, from: &Geodetic, to: &Geodetic) -> Vector<Ned, T> {
        Vector::new(
            T::of(to.latitude_rad - from.latitude_rad) * self.north_radius_m,
            T::of(wrap_angle(to.longitude_rad - from.longitude_rad))
                * self.east_radius_m
                * self.cos_latitude,
            T::of(from.height_m - to.height_m),
        )
    }
}

fn prime_vertical_radius_m(sin_latitude: f64) -> f64 {
    SEMI_MAJOR_AXIS_M / Scalar::sqrt(1.0 - ECCENTRICITY_SQUARED * sin_latitude * sin_latitude)
}
