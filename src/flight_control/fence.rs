//! Monitor of the fence: it detects that the vehicle reaches the fence, and gives the set-point to return.

use super::config::Fence;
use crate::autopilot::SetPoint;
use crate::earth::{Geodetic, LocalEarth};
use crate::frames::Vector;
use crate::scalar::Scalar;

/// Fraction of the fence's radius and height within which the vehicle counts as inside again.
const WELL_INSIDE: f64 = 0.8;

/// Change of the fence's state in a cycle.
pub(super) enum FenceChange {
    /// The vehicle reached the fence.
    Reached,
    /// The vehicle is well inside again.
    Left,
}

/// The fence, and whether the vehicle reached it.
#[derive(Clone, Copy, Debug)]
pub(super) struct FenceMonitor<T> {
    fence: Option<Fence>,
    /// Earth model at the centre.
    local: Option<LocalEarth<T>>,
    /// Set-point to return to, from the moment the fence was reached until the vehicle is well inside again.
    home: Option<SetPoint>,
}

impl<T: Scalar> FenceMonitor<T> {
    pub fn new(fence: Option<Fence>) -> Self {
        let local = fence.map(|fence| LocalEarth::about(&fence.centre));
        Self { fence, local, home: None }
    }

    /// Whether the vehicle reached the fence and is not yet well inside again.
    pub const fn is_outside(&self) -> bool {
        self.home.is_some()
    }

    /// Set-point to return to while the vehicle is outside. It is repeated in every cycle and overrides other
    /// requests.
    pub const fn home(&self) -> Option<SetPoint> {
        self.home
    }

    /// Resets the state: the monitor reports again when the vehicle reaches the fence.
    pub const fn engage(&mut self) {
        self.home = None;
    }

    /// Distance from the centre as a fraction of the distance to the fence: the greater of the fractions to the side
    /// and to the top. 1 at the fence; `None` without a fence.
    pub fn share(&self, position: &Geodetic) -> Option<f64> {
        let (fence, local) = (self.fence?, self.local?);
        let [north, east, down] = local.displacement(&fence.centre, position).to_array();
        let (radius_m, height_m) = (T::of(fence.radius_m), T::of(fence.height_m));
        Some((north.hypot(east) / radius_m).max(-down / height_m).wide())
    }

    /// Updates the state with the vehicle's position and its [`share`](Self::share).
    pub fn step(&mut self, position: &Geodetic, share: Option<f64>) -> Option<FenceChange> {
        let (fence, local, share) = (self.fence?, self.local?, share?);
        if self.is_outside() {
            if share >= WELL_INSIDE {
                return None;
            }
            self.home = None;
            return Some(FenceChange::Left);
        }
        if share < 1.0 {
            return None;
        }
        let up_m = -local.displacement(&fence.centre, position).z().wide();
        let height_m = up_m.min(WELL_INSIDE * 0.9 * fence.height_m).max(0.0);
        let position = fence.centre.displaced(Vector::new(0.0, 0.0, -height_m));
        self.home = Some(SetPoint::Position { position, heading_rad: None });
        Some(FenceChange::Reached)
    }
}
