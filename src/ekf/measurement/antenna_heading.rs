//! The heading of two GPS antennas.

use super::super::config::AntennaHeadingModel;
use super::super::correction::is_trusted;
use super::super::covariance::Sensitivity;
use super::super::filter::Ekf;
use super::super::gate::{Group, NEVER};
use super::super::innovation::Channel;
use super::super::layout::{ATTITUDE, Layout};
use super::super::scalar::Scalar;
use super::super::square;
use super::super::trace::Trace;
use super::{Report, ScalarMeasurement, Unusable};
use crate::frames::{Body, Vector, wrap_angle};
use crate::gps::AntennaHeading;
use crate::time::Time;

/// What is remembered of the headings before.
#[derive(Clone, Copy, Debug)]
pub struct AntennaHeadingMemory {
    /// When one was last used, if ever.
    pub used: Time,
    /// When one last disagreed with a heading that was turned against it.
    pub distrusted: Option<Time>,
}

impl AntennaHeadingMemory {
    /// There was none.
    pub const NONE: Self = Self { used: NEVER, distrusted: None };
}

/// A heading this far off, rad, points the other way, where the filter's own is surer than that.
const REVERSED_RAD: f64 = 2.6;
const SURE_RAD: f64 = 0.5;
/// A baseline more upright than this share of its length has no heading.
const LEAST_LEVEL: f64 = 0.1;

/// Share by which a turn since the reading may be wrong.
const AGED_SHARE: f64 = 0.1;
/// Readings older than this, s, or further ahead, are not brought to the present.
const OLDEST_S: f64 = 1.0;
const AHEAD_S: f64 = 0.5;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Takes in the heading of two antennas, the second at `baseline` from the first in body axes, m. Its
    /// length is checked against that found only where it is `mounted`, and not just a direction.
    ///
    /// The heading alone moves: what a tilt error makes of it where the baseline is not level counts as noise.
    ///
    /// # Errors
    /// [`Unusable`] when it cannot be compared, or comes too soon after the last one used.
    ///
    /// # Source
    /// Equation (M13) of docs/equations.md.
    // Its frame would stand beneath the other sensors of whoever calls all of them.
    #[inline(never)]
    pub fn update_antenna_heading(
        &mut self,
        reading: &AntennaHeading,
        mounted: Option<Vector<Body>>,
        model: &AntennaHeadingModel,
        trace: &mut impl Trace<T, N>,
    ) -> Result<Report, Unusable> {
        let time = reading.time;
        model.check_baseline(reading, mounted)?;
        let since_s = time - self.antenna_heading.used;
        if since_s < model.interval_s {
            return Err(Unusable::TooSoon);
        }
        let body_to_ned = self.state.body_to_ned.cast();
        let baseline = body_to_ned * mounted.unwrap_or(FORWARD);
        let level = Scalar::hypot(baseline.x(), baseline.y());
        // Written so that a NaN has none.
        let has_heading = level > LEAST_LEVEL * baseline.norm();
        if !has_heading {
            return Err(Unusable::NotFinite);
        }
        let age_s = self.age_s(time)?;
        let turned_rad = (body_to_ned * self.angular_rate_radps.cast()).z() * age_s;
        let off_rad = wrap_angle(reading.heading_rad + turned_rad - baseline.azimuth_rad());
        self.catch_up(trace);
        let own = self.covariance.variance(ATTITUDE + 2);
        if libm::fabs(off_rad) > REVERSED_RAD && own < square(SURE_RAD) {
            return Err(Unusable::Reversed);
        }
        self.relax(trace);
        self.antenna_heading.used = time;
        let tilt = self.covariance.variance(ATTITUDE).max(self.covariance.variance(ATTITUDE + 1));
        let sigma_rad = reading.sigma_rad.unwrap_or(model.sigma_rad).max(model.floor_rad);
        let besides = square(baseline.z() / level) * tilt + square(AGED_SHARE * turned_rad);
        let one = square(sigma_rad) + besides;
        // What readings have in common makes none of them less sure: a jump is one by the error of one.
        let jumps = square(off_rad) > square(self.config.gate.sigmas) * (own + one);
        let noise = if jumps { one } else { model.weight(since_s) * square(sigma_rad) + besides };
        let channel = (Channel::BaselineHeading, Group::BaselineHeading);
        let trusted = is_trusted(&mut self.antenna_heading.distrusted, time, off_rad);
        let mut axes = [None; 6];
        axes[0] = trusted.then(|| ScalarMeasurement {
            sensitivity: Sensitivity::default().with(ATTITUDE + 2, T::ONE),
            ..ScalarMeasurement::new(channel, T::of(off_rad), T::of(noise))
        });
        let mut report = Report::default();
        self.update_sequentially(time, &axes, &mut report, trace);
        Ok(report)
    }

    /// How old a reading is, s, that was true at `time`.
    ///
    /// # Errors
    /// [`Unusable::TooOld`] and [`Unusable::AheadOfImu`] where motion at a constant rate does not reach.
    pub(super) fn age_s(&self, time: Time) -> Result<f64, Unusable> {
        match self.state.time - time {
            age_s if age_s > OLDEST_S => Err(Unusable::TooOld),
            age_s if age_s < -AHEAD_S => Err(Unusable::AheadOfImu),
            age_s => Ok(age_s),
        }
    }
}

/// The direction that a heading is of where nothing else is said.
const FORWARD: Vector<Body> = Vector::new(1.0, 0.0, 0.0);

impl AntennaHeadingModel {
    /// Whether a reading can be one of antennas that are `mounted` so far apart.
    ///
    /// # Errors
    /// [`Unusable::NotFinite`] and [`Unusable::WrongBaseline`].
    pub(in super::super) fn check_baseline(
        &self,
        reading: &AntennaHeading,
        mounted: Option<Vector<Body>>,
    ) -> Result<(), Unusable> {
        if !reading.is_finite() {
            return Err(Unusable::NotFinite);
        }
        let off_m =
            mounted.zip(reading.length_m).map(|(mounted, length_m)| length_m - mounted.norm());
        match off_m {
            Some(off_m) if libm::fabs(off_m) > self.length_tolerance_m => {
                Err(Unusable::WrongBaseline)
            }
            _ => Ok(()),
        }
    }

    /// By how many times a reading's variance counts that comes so long after the one before: the part of its
    /// error that wanders weighs like white noise of as much more as the readings have it in common.
    fn weight(&self, since_s: f64) -> f64 {
        let in_common = (2.0 * self.wander_time_s / since_s).max(1.0);
        1.0 + square(self.wander_share.min(1.0)) * (in_common - 1.0)
    }
}
