//! The fix of any receiver, as an input of the filter.

use crate::earth::Geodetic;
use crate::frames::{Ned, Vector};
use crate::time::Time;

/// One position fix, with the accuracy that the receiver reports; unreported values are `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Time of validity on the inertial unit's clock: arrival minus latency.
    pub time: Time,
    /// The antenna's position.
    pub position: Geodetic,
    /// Whether the receiver held or assumed the height, or reported none; then neither height nor down velocity is
    /// measured.
    pub two_dimensional: bool,
    /// One-sigma of the position, north, east and down, m, if the receiver reports it.
    pub position_sigma_m: Option<Vector<Ned>>,
    /// The antenna's horizontal velocity, m/s, north and east.
    pub horizontal_velocity_mps: Option<[f64; 2]>,
    /// The antenna's down velocity, m/s; receivers that send only NMEA do not report it.
    pub down_velocity_mps: Option<f64>,
    /// One-sigma of the velocity, m/s.
    pub velocity_sigma_mps: Option<Vector<Ned>>,
    /// Number of satellites used.
    pub satellites: Option<u8>,
}

/// Upper limit of the speed, above any orbital speed, m/s.
const FASTEST_MPS: f64 = 1e4;
/// Ratio of the one-sigma of the down velocity to that of the horizontal velocity, for receivers that report one figure
/// for both.
const DOWN_TO_LEVEL: f64 = 1.5;
/// Largest valid one-sigma, m or m/s; a larger one contains no information.
const WIDEST_SIGMA: f64 = 1e6;

impl Fix {
    /// A fix with only a position.
    #[must_use]
    pub const fn at(time: Time, position: Geodetic) -> Self {
        Self {
            time,
            position,
            two_dimensional: false,
            position_sigma_m: None,
            horizontal_velocity_mps: None,
            down_velocity_mps: None,
            velocity_sigma_mps: None,
            satellites: None,
        }
    }

    /// Velocity down, m/s, if the fix measures the vertical.
    pub(crate) fn measured_down_mps(&self) -> Option<f64> {
        self.down_velocity_mps.filter(|_| !self.two_dimensional)
    }

    /// This fix with a velocity, m/s.
    ///
    /// ```
    /// use hovernav::prelude::*;
    ///
    /// let home = Geodetic::from_degrees(48.1, 11.6, 520.0).ok_or("invalid position")?;
    /// let fix = Fix::at(Time::from_seconds(1.0), home)
    ///     .with_velocity_mps(Vector::new(3.0, -1.0, 0.2))
    ///     .with_position_sigma_m(Vector::new(1.5, 1.5, 3.0));
    /// assert!(fix.is_finite());
    /// # Ok::<(), &str>(())
    /// ```
    #[must_use]
    pub const fn with_velocity_mps(mut self, velocity_mps: Vector<Ned>) -> Self {
        let [north, east, down] = velocity_mps.to_array();
        self.horizontal_velocity_mps = Some([north, east]);
        self.down_velocity_mps = Some(down);
        self
    }

    /// This fix with the one-sigma of position that the receiver reports, m.
    #[must_use]
    pub const fn with_position_sigma_m(mut self, sigma_m: Vector<Ned>) -> Self {
        self.position_sigma_m = Some(sigma_m);
        self
    }

    /// This fix with the one-sigma of velocity that the receiver reports, m/s.
    #[must_use]
    pub const fn with_velocity_sigma_mps(mut self, sigma_mps: Vector<Ned>) -> Self {
        self.velocity_sigma_mps = Some(sigma_mps);
        self
    }

    /// Whether every value is finite and possible for a receiver near the ground. The position must be navigable and
    /// speeds within ±10 km/s. One-sigmas must be above zero, and at most 1 000 km or 1 000 km/s.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let speed_is_good = |speed: f64| libm::fabs(speed) <= FASTEST_MPS;
        let sigma_is_good = |sigma: Option<Vector<Ned>>| {
            sigma.is_none_or(|sigma| {
                sigma.to_array().iter().all(|&sigma| sigma > 0.0 && sigma <= WIDEST_SIGMA)
            })
        };
        self.position.is_navigable()
            && self
                .horizontal_velocity_mps
                .is_none_or(|velocity| velocity.into_iter().all(speed_is_good))
            && self.down_velocity_mps.is_none_or(speed_is_good)
            && sigma_is_good(self.position_sigma_m)
            && sigma_is_good(self.velocity_sigma_mps)
    }

    /// One-sigma of the velocity on each axis, m/s, if the receiver reports any. If the receiver reports one figure for
    /// all three axes, it is the one-sigma of the horizontal axes. On the down axis it is multiplied by 1.5, because no
    /// satellites are below the antenna.
    ///
    /// # Source
    /// The ratio: `gps_control.cpp` of the estimator EKF2 of PX4.
    #[must_use]
    pub fn axes_velocity_sigma_mps(&self) -> Option<Vector<Ned>> {
        self.velocity_sigma_mps.map(|sigma| {
            let [north, east, down] = sigma.to_array();
            let is_one_figure = north == east && east == down;
            Vector::new(north, east, if is_one_figure { DOWN_TO_LEVEL * down } else { down })
        })
    }

    /// The complete velocity, m/s, if all three components are known.
    #[must_use]
    pub fn velocity_mps(&self) -> Option<Vector<Ned>> {
        if self.two_dimensional {
            return None;
        }
        let [north, east] = self.horizontal_velocity_mps?;
        Some(Vector::new(north, east, self.down_velocity_mps?))
    }
}
