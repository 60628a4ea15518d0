//! One epoch as the receiver reports it, on the receiver's clock.

use core::f64::consts::{FRAC_PI_2, TAU};

use super::{Fix, ReceiverTime};
use crate::earth::Geodetic;
use crate::frames::{Ned, Vector, wrap_angle};
use crate::scalar::Scalar;
use crate::time::Time;

/// Whether the receiver solved for height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Latitude and longitude only: the height is held or assumed.
    TwoD,
    /// Latitude, longitude and height.
    ThreeD,
}

/// Source of corrections in addition to the satellites' own messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Correction {
    /// No correction: a plain fix.
    None,
    /// Corrections of code ranges, from the ground or from satellites.
    Differential,
    /// Carrier phase with unresolved (float) ambiguities.
    RtkFloat,
    /// Carrier phase with resolved (integer) ambiguities.
    RtkFixed,
}

/// Dilutions of precision: factors from the error of one measured range to the error of the solution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DilutionOfPrecision {
    /// Dilution of position.
    pub position: Option<f64>,
    /// Dilution of horizontal position.
    pub horizontal: Option<f64>,
    /// Dilution of height.
    pub vertical: Option<f64>,
}

/// One epoch of a receiver, with every value checked to be finite and possible. Values that the receiver did not send
/// are `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverFix {
    /// Arrival of the first byte of the epoch's first message, on the host's clock. Its delay after the time of
    /// validity is steady: it consists of the computation in the receiver and the queue of the serial line. The arrival
    /// of later bytes depends on the number of messages.
    pub arrival: Time,
    /// Time of validity on the receiver's clock; `None` if the receiver did not send it.
    pub time: Option<ReceiverTime>,
    /// Geodetic latitude, WGS-84, in [−π/2, π/2].
    pub latitude_rad: f64,
    /// Longitude, WGS-84, in (−π, π].
    pub longitude_rad: f64,
    /// Height above the WGS-84 ellipsoid, m.
    pub height_m: Option<f64>,
    /// Height above mean sea level by the receiver's geoid, m.
    pub altitude_msl_m: Option<f64>,
    /// Velocity north and east, m/s.
    pub horizontal_velocity_mps: Option<[f64; 2]>,
    /// Velocity downwards, m/s.
    pub down_velocity_mps: Option<f64>,
    /// Speed over ground, m/s. It may be known without the direction, because many receivers leave the course empty
    /// when nearly at rest.
    pub ground_speed_mps: Option<f64>,
    /// One-sigma of position, m; the decoder's documentation states its derivation from the receiver's values.
    pub position_sigma_m: Option<Vector<Ned>>,
    /// One-sigma of velocity, m/s.
    pub velocity_sigma_mps: Option<Vector<Ned>>,
    /// Number of satellites used.
    pub satellites: Option<u8>,
    /// Dilutions of precision.
    pub dilution: DilutionOfPrecision,
    /// Whether height was solved for.
    pub dimension: Option<Dimension>,
    /// Source of corrections of the fix.
    pub correction: Option<Correction>,
}

impl ReceiverFix {
    /// A fix with only a position.
    pub(super) const fn new(arrival: Time, place: Horizontal) -> Self {
        Self {
            arrival,
            time: None,
            latitude_rad: place.latitude_rad,
            longitude_rad: place.longitude_rad,
            height_m: None,
            altitude_msl_m: None,
            horizontal_velocity_mps: None,
            down_velocity_mps: None,
            ground_speed_mps: None,
            position_sigma_m: None,
            velocity_sigma_mps: None,
            satellites: None,
            dilution: DilutionOfPrecision { position: None, horizontal: None, vertical: None },
            dimension: None,
            correction: None,
        }
    }

    /// The fix as an input of the filter, valid at `time` on the inertial unit's clock.
    ///
    /// `None` while the height above the ellipsoid is unknown. A receiver that only reports height above mean sea
    /// level needs [`with_geoid_separation`](Self::with_geoid_separation).
    #[must_use]
    pub fn at(&self, time: Time) -> Option<Fix> {
        Some(Fix {
            two_dimensional: self.dimension == Some(Dimension::TwoD),
            position_sigma_m: self.position_sigma_m,
            horizontal_velocity_mps: self.horizontal_velocity_mps,
            down_velocity_mps: self.down_velocity_mps,
            velocity_sigma_mps: self.velocity_sigma_mps,
            satellites: self.satellites,
            ..Fix::at(
                time,
                Geodetic {
                    latitude_rad: self.latitude_rad,
                    longitude_rad: self.longitude_rad,
                    height_m: self.height_m?,
                },
            )
        })
    }

    /// Computes a missing height, above the ellipsoid or above mean sea level, from the other height. `separation_m` is
    /// the geoid's height above the ellipsoid at the flying site (−107 to 86 m over the Earth).
    #[must_use]
    pub fn with_geoid_separation(mut self, separation_m: f64) -> Self {
        self.height_m =
            self.height_m.or_else(|| self.altitude_msl_m.map(|above_sea| above_sea + separation_m));
        self.altitude_msl_m =
            self.altitude_msl_m.or_else(|| self.height_m.map(|height| height - separation_m));
        self
    }

    /// Sets the horizontal velocity and with it the ground speed.
    pub(super) fn set_horizontal_velocity(&mut self, north_mps: f64, east_mps: f64) {
        self.horizontal_velocity_mps = Some([north_mps, east_mps]);
        self.ground_speed_mps = Some(Scalar::hypot(north_mps, east_mps));
    }
}

/// A latitude and a longitude that have passed the range check.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Horizontal {
    pub latitude_rad: f64,
    pub longitude_rad: f64,
}

impl Horizontal {
    /// Latitude and longitude, rad; `None` when one is not finite or out of range.
    pub fn new(latitude_rad: f64, longitude_rad: f64) -> Option<Self> {
        let on_earth = libm::fabs(latitude_rad) <= FRAC_PI_2 && libm::fabs(longitude_rad) <= TAU;
        on_earth.then(|| Self { latitude_rad, longitude_rad: wrap_angle(longitude_rad) })
    }
}

/// The height, if it is finite and within 100 km of the ellipsoid, the limit of receivers.
pub(super) fn plausible_height(height_m: f64) -> Option<f64> {
    (libm::fabs(height_m) <= 1e5).then_some(height_m)
}

/// The velocity, if it is finite and at most 600 m/s: commercial receivers stop at 515 m/s.
pub(super) fn plausible_velocity<const N: usize>(velocity_mps: [f64; N]) -> Option<[f64; N]> {
    velocity_mps.iter().all(|component| libm::fabs(*component) <= 600.0).then_some(velocity_mps)
}

/// The one-sigmas, if all are finite and above zero: receivers send zeros for unknown ones.
pub(super) fn known_sigma(sigma: Vector<Ned>) -> Option<Vector<Ned>> {
    sigma.to_array().iter().all(|sigma| *sigma > 0.0 && sigma.is_finite()).then_some(sigma)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn fix() -> ReceiverFix {
        ReceiverFix::new(Time::ZERO, Horizontal { latitude_rad: 0.1, longitude_rad: 0.2 })
    }

    #[test]
    fn a_fix_without_height_above_the_ellipsoid_is_not_for_the_filter() {
        assert_eq!(fix().at(Time::ZERO), None);
        let above_sea = ReceiverFix { altitude_msl_m: Some(31.0), ..fix() };
        assert_eq!(above_sea.at(Time::ZERO), None);
        let fix = above_sea.with_geoid_separation(7.0).at(Time::ZERO).unwrap();
        assert_eq!(fix.position.height_m, 38.0);
    }

    #[test]
    fn the_receivers_own_heights_are_not_overwritten() {
        let both = ReceiverFix { height_m: Some(40.0), altitude_msl_m: Some(31.0), ..fix() };
        assert_eq!(both.with_geoid_separation(7.0), both);
    }

    #[test]
    fn no_place_height_or_velocity_is_taken_that_cannot_be() {
        for (latitude, longitude) in [(1.6, 0.0), (f64::NAN, 0.0), (0.0, 7.0), (0.0, f64::INFINITY)]
        {
            assert_eq!(Horizontal::new(latitude, longitude), None);
        }
        assert_eq!(plausible_height(f64::NAN), None);
        assert_eq!(plausible_height(-1.1e5), None);
        assert_eq!(plausible_velocity([0.0, f64::NEG_INFINITY]), None);
        assert_eq!(plausible_velocity([0.0, 601.0]), None);
        assert_eq!(plausible_velocity([0.0, -599.0, 1.0]), Some([0.0, -599.0, 1.0]));
    }

    #[test]
    fn longitude_east_of_the_date_line_comes_back_negative() {
        let place = Horizontal::new(0.0, 246.0f64.to_radians()).unwrap();
        assert_abs_diff_eq!(place.longitude_rad.to_degrees(), -114.0, epsilon = 1e-12);
    }
}
