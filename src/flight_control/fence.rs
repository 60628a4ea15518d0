//! The watch on the fence: when it is reached, and where to go then.

use super::config::Fence;
use crate::autopilot::SetPoint;
use crate::earth::{Geodetic, Local};
use crate::frames::Vector;
use crate::scalar::Scalar;

/// Share of the fence's radius and height inside of which it is forgotten again.
const WELL_INSIDE: f64 = 0.8;

/// What became of the fence in a cycle.
pub(super) enum FenceChange {
    /// It is reached.
    Reached,
    /// The vehicle is well inside again.
    Left,
}

/// The fence, and whether it was reached.
#[derive(Clone, Copy, Debug)]
pub(super) struct FenceWatch<T> {
    fence: Option<Fence>,
    /// The Earth at its middle.
    local: Option<Local<T>>,
    /// Where to go, from when it was reached until the vehicle is well inside again.
    home: Option<SetPoint>,
}

impl<T: Scalar> FenceWatch<T> {
    pub fn new(fence: Option<Fence>) -> Self {
        let local = fence.map(|fence| Local::about(&fence.centre));
        Self { fence, local, home: None }
    }

    /// Whether it was reached and the vehicle is not yet well inside again.
    pub const fn is_outside(&self) -> bool {
        self.home.is_some()
    }

    /// Where to go while it is outside: asked for again and again, whatever else is asked for meanwhile.
    pub const fn home(&self) -> Option<SetPoint> {
        self.home
    }

    /// Begins anew: the next time that it is found reached is told.
    pub const fn engage(&mut self) {
        self.home = None;
    }

    /// Share of the way from the middle to the side or the top, the greater, 1 at the fence; `None` without
    /// a fence.
    pub fn share(&self, position: &Geodetic) -> Option<f64> {
        let (fence, local) = (self.fence?, self.local?);
        let [north, east, down] = local.displacement(&fence.centre, position).to_array();
        let (radius_m, height_m) = (T::of(fence.radius_m), T::of(fence.height_m));
        Some((north.hypot(east) / radius_m).max(-down / height_m).wide())
    }

    /// Takes in where the vehicle is, by its [`share`](Self::share) there.
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
        self.home = Some(SetPoint::Place { position, heading_rad: None });
        Some(FenceChange::Reached)
    }
}
