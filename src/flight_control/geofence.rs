//! Monitor of the geofence: it detects that the vehicle reaches the geofence, and gives the set-point to return.

use super::config::Geofence;
use crate::autopilot::SetPoint;
use crate::earth::{Geodetic, LocalEarth};
use crate::frames::Vector;
use crate::scalar::Scalar;

/// Fraction of the geofence's radius and height within which the vehicle counts as inside again.
const WELL_INSIDE: f64 = 0.8;

/// Change of the geofence's state in a cycle.
pub(super) enum GeofenceChange {
    /// The vehicle reached the geofence.
    Reached,
    /// The vehicle is well inside again.
    Left,
}

/// The geofence, and whether the vehicle reached it.
#[derive(Clone, Copy, Debug)]
pub(super) struct GeofenceMonitor<T> {
    geofence: Option<Geofence>,
    /// Earth model at the centre.
    local: Option<LocalEarth<T>>,
    /// Set-point to return to, from the moment the geofence was reached until the vehicle is well inside again.
    home: Option<SetPoint>,
}

impl<T: Scalar> GeofenceMonitor<T> {
    pub fn new(geofence: Option<Geofence>) -> Self {
        let local = geofence.map(|geofence| LocalEarth::about(&geofence.centre));
        Self { geofence, local, home: None }
    }

    /// Whether the vehicle reached the geofence and is not yet well inside again.
    pub const fn is_outside(&self) -> bool {
        self.home.is_some()
    }

    /// Set-point to return to while the vehicle is outside. It is repeated in every cycle and overrides other
    /// requests.
    pub const fn home(&self) -> Option<SetPoint> {
        self.home
    }

    /// Resets the state: the monitor reports again when the vehicle reaches the geofence.
    pub const fn engage(&mut self) {
        self.home = None;
    }

    /// Distance from the centre as a fraction of the distance to the geofence: the greater of the fractions to the side
    /// and to the top. 1 at the geofence; `None` without a geofence.
    pub fn share(&self, position: &Geodetic) -> Option<f64> {
        let (geofence, local) = (self.geofence?, self.local?);
        let [north, east, down] = local.displacement(&geofence.centre, position).to_array();
        let (radius_m, height_m) = (T::of(geofence.radius_m), T::of(geofence.height_m));
        Some((north.hypot(east) / radius_m).max(-down / height_m).wide())
    }

    /// Updates the state with the vehicle's position and its [`share`](Self::share).
    pub fn step(&mut self, position: &Geodetic, share: Option<f64>) -> Option<GeofenceChange> {
        let (geofence, local, share) = (self.geofence?, self.local?, share?);
        if self.is_outside() {
            if share >= WELL_INSIDE {
                return None;
            }
            self.home = None;
            return Some(GeofenceChange::Left);
        }
        if share < 1.0 {
            return None;
        }
        let up_m = -local.displacement(&geofence.centre, position).z().wide();
        let height_m = up_m.min(WELL_INSIDE * 0.9 * geofence.height_m).max(0.0);
        let position = geofence.centre.displaced(Vector::new(0.0, 0.0, -height_m));
        self.home = Some(SetPoint::Position { position, heading_rad: None });
        Some(GeofenceChange::Reached)
    }
}
