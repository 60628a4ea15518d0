//! The heading of two GPS antennas.

use super::update::ScalarMeasurement;
use crate::ekf::filter::Ekf;
use crate::ekf::kernel::covariance::Sensitivity;
use crate::ekf::kernel::layout::{ATTITUDE, Layout};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::innovation::Channel;
use crate::ekf::outcome::report::{Report, Unusable};
use crate::ekf::settings::config::AntennaHeadingModel;
use crate::ekf::watch::READING_S;
use crate::frames::{Body, Vector, wrap_angle};
use crate::gps::AntennaHeading;
use crate::matrix::square;
use crate::scalar::Scalar;
use crate::time::Time;

/// Difference from the filter's heading, rad, beyond which a measured heading counts as reversed.
const REVERSED_RAD: f64 = 2.6;
/// Largest one-sigma of the filter's heading, rad, at which a measured heading can count as reversed.
const SURE_RAD: f64 = 0.5;
/// Minimum horizontal part of a baseline, as a fraction of its length, that determines a heading.
const MIN_LEVEL: f64 = 0.1;

/// One-sigma of the turn since the reading, as a fraction of the turn.
const AGED_SHARE: f64 = 0.1;
/// Largest time, s, by which a reading may be newer than the last inertial sample.
const AHEAD_S: f64 = 0.5;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Fuses the heading of two antennas. `mounted` is the vector from the first to the second antenna in body axes, m.
    /// Without `mounted` the second is ahead of the first, and the measured length is not checked.
    ///
    /// Only the heading is corrected. If the baseline is not horizontal, the effect of a tilt error counts as noise.
    ///
    /// # Errors
    /// [`Unusable`] if the heading cannot be compared, or comes too soon after the last used one.
    ///
    /// # Source
    /// Equation (M13) of docs/equations.md.
    // Not inlined, so that its stack frame is not part of a caller's that updates several sensors.
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
        let since_s = self.memory.antenna_heading.since_used_s(time);
        if since_s < model.interval_s {
            return Err(Unusable::TooSoon);
        }
        let body_to_ned = self.state.body_to_ned.cast();
        let baseline = body_to_ned * mounted.unwrap_or(FORWARD);
        let level = Scalar::hypot(baseline.x(), baseline.y());
        // The condition is written so that a NaN has no heading.
        let has_heading = level > MIN_LEVEL * baseline.norm();
        if !has_heading {
            return Err(Unusable::NotFinite);
        }
        let age_s = self.age_s(time)?;
        let turned_rad = (body_to_ned * self.memory.angular_rate_radps.cast()).z() * age_s;
        let off_rad = wrap_angle(reading.heading_rad + turned_rad - baseline.azimuth_rad());
        self.catch_up(trace);
        let own = self.covariance.variance(ATTITUDE + 2);
        if libm::fabs(off_rad) > REVERSED_RAD && own < square(SURE_RAD) {
            return Err(Unusable::BaselineReversed);
        }
        self.relax(trace);
        self.memory.antenna_heading.used = Some(time);
        let tilt = self.tilt_variance();
        let sigma_rad = reading.sigma_rad.unwrap_or(model.sigma_rad).max(model.floor_rad);
        let besides = square(baseline.z() / level) * tilt + square(AGED_SHARE * turned_rad);
        let one = square(sigma_rad) + besides;
        // Only the error of one reading decides whether it is a jump. The enlarged variance, for slow errors of
        // successive readings, would hide a jump.
        let jumps = square(off_rad) > square(self.config.gate.sigmas) * (own + one);
        let noise = if jumps { one } else { model.weight(since_s) * square(sigma_rad) + besides };
        let trusted = self.memory.antenna_heading.accepts(time, off_rad);
        let heading = trusted.then(|| {
            let sensitivity = Sensitivity::default().with(ATTITUDE + 2, T::ONE);
            let (off, noise) = (T::of(off_rad), T::of(noise));
            ScalarMeasurement::new(Channel::BaselineHeading, off, noise, sensitivity)
        });
        Ok(self.update_one(time, heading, trace))
    }

    /// Age, s, of a reading that was valid at `time`.
    ///
    /// # Errors
    /// [`Unusable::TooOld`] and [`Unusable::AheadOfImu`] if the age is too large to assume a constant rate.
    pub(super) fn age_s(&self, time: Time) -> Result<f64, Unusable> {
        match self.state.time - time {
            age_s if age_s > READING_S => Err(Unusable::TooOld),
            age_s if age_s < -AHEAD_S => Err(Unusable::AheadOfImu),
            age_s => Ok(age_s),
        }
    }
}

/// Direction of the baseline by default.
const FORWARD: Vector<Body> = Vector::new(1.0, 0.0, 0.0);

impl AntennaHeadingModel {
    /// Whether a reading is consistent with the distance between the `mounted` antennas.
    ///
    /// # Errors
    /// [`Unusable::NotFinite`] and [`Unusable::WrongBaseline`].
    pub(in crate::ekf) fn check_baseline(
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

    /// Factor on the variance of a reading that comes `since_s` after the previous one. The slow part of its error
    /// counts as white noise. Its variance is multiplied by the number of readings within two correlation times.
    fn weight(&self, since_s: f64) -> f64 {
        let in_common = (2.0 * self.wander_time_s / since_s).max(1.0);
        1.0 + square(self.wander_share.min(1.0)) * (in_common - 1.0)
    }
}
