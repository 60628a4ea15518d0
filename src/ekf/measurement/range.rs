//! Distance to the ground, along the beam of a rangefinder.

use super::update::ScalarMeasurement;
use crate::ekf::filter::Ekf;
use crate::ekf::kernel::covariance::Sensitivity;
use crate::ekf::kernel::layout::{ATTITUDE, Layout, POSITION};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::innovation::Channel;
use crate::ekf::outcome::report::{Report, Unusable};
use crate::ekf::settings::estimator_config::Rangefinder;
use crate::event::RangeReading;
use crate::matrix::square;
use crate::scalar::Scalar;

/// Minimum downward component of the beam's direction: the cosine of 60°.
const MIN_DOWN: f64 = 0.5;
/// Ratio of the initial one-sigma of the ground's height to the one-sigma of height and first reading together. The
/// first reading then changes the variance of the height by at most a hundredth.
const OPENED: f64 = 10.0;
/// Smallest innovation, in one-sigmas, of a reading within the gate that counts as a step of the ground.
const STEP_SIGMAS: f64 = 4.0;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Fuses a distance to the ground. A distance that jumps is rejected at first, then attributed to other ground.
    ///
    /// # Errors
    /// [`Unusable`] if the distance cannot be compared.
    ///
    /// # Source
    /// Equation (M12) of docs/equations.md.
    // Not inlined, so that its stack frame is not part of a caller's that updates several sensors.
    #[inline(never)]
    pub fn update_range(
        &mut self,
        reading: &RangeReading,
        rangefinder: &Rangefinder,
        trace: &mut impl Trace<T, N>,
    ) -> Result<Report, Unusable> {
        let state = L::GROUND.ok_or(Unusable::NoState)?;
        let model = &rangefinder.model;
        let RangeReading { time, range_m, .. } = *reading;
        if !reading.is_possible() {
            return Err(Unusable::NotFinite);
        }
        let body_to_ned = self.state.body_to_ned.cast();
        let velocity_mps = self.state.velocity_mps.cast();
        let from_imu = rangefinder.lever_arm_m - self.mounting.imu_lever_arm_m;
        let beam = body_to_ned * rangefinder.beam;
        let hit = body_to_ned * from_imu + beam * range_m;
        let wandered_m = self.memory.ground.see(reading, beam, hit, velocity_mps);
        if self.memory.ground.is_stuck(beam) {
            return Err(Unusable::Stuck);
        }
        let vouched = reading.quality.is_none_or(|quality| quality >= model.least_quality);
        if !(model.least_m..=model.most_m).contains(&range_m) || !vouched {
            return Err(Unusable::OutOfRange);
        }
        if beam.z() < MIN_DOWN {
            return Err(Unusable::TooTilted);
        }
        let age_s = self.age_s(time)?;
        self.relax(trace);
        // The height at the time of the reading.
        let own_m = self.state.position.height_m + velocity_mps.z() * age_s;
        let white_m = reading.sigma_m.unwrap_or(model.noise_m).max(MIN_NOISE_M);
        let noise = square(white_m) + square(model.noise_share * range_m);
        let height_m = if let Some(height_m) = self.memory.ground.height_m {
            self.add_parameter_variance(state, square(model.ground_walk_m) * wandered_m, trace);
            height_m
        } else {
            let variance = self.covariance.variance(POSITION + 2) + noise;
            self.reset_parameter(state, 0.0);
            self.add_parameter_variance(state, square(OPENED) * variance, trace);
            *self.memory.ground.height_m.insert(own_m - hit.z())
        };
        let per_metre = 1.0 / beam.z();
        // The innovation is positive if the reading is longer than the estimated distance to the ground.
        let innovation = (hit.z() - (own_m - height_m - self.parameter(state))) * per_metre;
        let sensitivity = Sensitivity::default()
            .with_block(ATTITUDE, [-hit.y() * per_metre, hit.x() * per_metre, 0.0].map(T::of))
            .with(POSITION + 2, T::of(-per_metre))
            .with(state, T::of(-per_metre));
        let variance = self.covariance.project(&sensitivity).1.wide() + noise;
        let steps = square(STEP_SIGMAS)..=square(self.config.gate.sigmas);
        if steps.contains(&(square(innovation) / variance)) {
            self.add_parameter_variance(state, square(innovation), trace);
        }
        let (innovation, noise) = (T::of(innovation), T::of(noise));
        let range = ScalarMeasurement::new(Channel::Range, innovation, noise, sensitivity);
        Ok(self.update_one(time, Some(range), trace))
    }
}

/// Minimum one-sigma of a reading, m.
const MIN_NOISE_M: f64 = 0.005;
