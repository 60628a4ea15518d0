//! Magnetic heading.

use super::update::ScalarMeasurement;
use crate::ekf::filter::Ekf;
use crate::ekf::kernel::covariance::Sensitivity;
use crate::ekf::kernel::layout::{ATTITUDE, Layout};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::innovation::Channel;
use crate::ekf::outcome::report::{Report, Unusable};
use crate::ekf::watch::field_watch::{AttitudeUncertainty, FieldChange, Parts, Turn};
use crate::frames::{Body, Vector, wrap_angle};
use crate::matrix::square;
use crate::scalar::Scalar;
use crate::time::Time;

/// Minimum strength of a plausible field, gauss: the Earth's is 0.22 gauss or more. A weaker field means that the
/// magnetometer does not work yet.
const MIN_GAUSS: f32 = 0.05;

/// Minimum horizontal part of a field, as a fraction of its strength, that determines a heading.
const MIN_LEVEL_SHARE: f64 = 0.02;

/// Largest one-sigma, rad, of a magnetic heading that replaces a heading hidden by a gap.
const MAX_UNLEVELLED_RAD: f64 = 0.1;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Checks a magnetic field, gauss, before it gives a heading or the inertial unit's own heading follows it.
    /// Strength and dip do not depend on the heading. If they change, the slow error of the heading's sensor is widened
    /// accordingly. If the change lasts, the one-sigma of the heading is widened too. Returns the change. The field is
    /// not checked while a gap has left the attitude unknown.
    ///
    /// # Source
    /// Equation (M15) of docs/equations.md.
    #[inline(never)]
    pub(in crate::ekf) fn watch_field(
        &mut self,
        time: Time,
        field_gauss: Vector<Body>,
        trace: &mut impl Trace<T, N>,
    ) -> Option<FieldChange> {
        let error = L::ATTITUDE_REFERENCE? + 2;
        let is_due = self.memory.field_watch.is_due(time, self.config.magnetometer.interval_s);
        if !self.config.mechanisms.field_monitor || self.memory.attitude_lost.is_some() || !is_due {
            return None;
        }
        let field = self.state.body_to_ned * field_gauss.cast();
        let [level, down] = [field.x().hypot(field.y()), field.z()].map(|part| part.wide() as f32);
        // The condition is written so that a NaN is skipped.
        if !(level.abs() + down.abs() >= MIN_GAUSS && field.is_finite()) {
            return None;
        }
        let uncertainty = AttitudeUncertainty {
            tilt_variance: self.tilt_variance() as f32,
            heading_variance: self.covariance.variance(ATTITUDE + 2) as f32,
            turned: self.memory.gates.is_filter_suspect(time),
        };
        let parts = Parts { level, down, azimuth_rad: field.azimuth_rad().wide() as f32 };
        let change = self.memory.field_watch.push(time, parts, &uncertainty)?;
        if change.turn == Some(Turn::Suspect) {
            // Restarts the interval between used headings, so that the next checked field is also used.
            self.memory.heading.used = self.memory.heading.used.map(|_| time);
            return Some(change);
        }
        // The inertial unit's own heading follows the field.
        self.memory.attitude_watch.forget();
        self.relax(trace);
        if change.turn == Some(Turn::Lasting) {
            self.suspect_heading(self.estimate(error).wide(), trace);
        } else {
            self.add_parameter_variance(error, f64::from(square(change.sigma_rad)), trace);
        }
        if change.turn == Some(Turn::Settled) && self.memory.heading_revision.is_magnetic {
            // The field at the start was disturbed, and so the heading was wrong: it is measured again.
            self.memory.attitude_lost = Some(time);
            self.memory.heading_revision.replaced(0.0);
            self.forget_heading_error(self.config.magnetometer.heading_wander_rad);
            trace.reset(error..error + 1);
        }
        Some(change)
    }

    /// The larger of the two variances of the tilt, rad².
    pub(super) fn tilt_variance(&self) -> f64 {
        self.covariance.variance(ATTITUDE).max(self.covariance.variance(ATTITUDE + 1))
    }

    /// Fuses a magnetic field, gauss: heading from magnetic north, `declination_rad` east of true north, levelled by
    /// the filter's own roll and pitch.
    ///
    /// # Errors
    /// [`Unusable`] if the field cannot be compared, or comes too soon after the last used one.
    ///
    /// # Source
    /// Equation (M9) of docs/equations.md.
    pub fn update_magnetic_heading(
        &mut self,
        time: Time,
        field_gauss: Vector<Body>,
        declination_rad: f64,
        trace: &mut impl Trace<T, N>,
    ) -> Result<Report, Unusable> {
        let field = self.state.body_to_ned * field_gauss.cast();
        let horizontal = field.x().hypot(field.y());
        let strength = field.norm();
        // The strength of a field with huge components is infinite.
        if !(field.is_finite() && strength.is_finite()) {
            return Err(Unusable::NotFinite);
        }
        if horizontal <= T::of(MIN_LEVEL_SHARE) * strength {
            return Err(Unusable::HorizontalFieldTooWeak);
        }
        self.samples.rest.field(field_gauss);
        let first = L::ATTITUDE_REFERENCE.ok_or(Unusable::NoState)? + 2;
        let model = self.config.magnetometer;
        let elapsed_s = self.memory.heading.used.map_or(model.interval_s, |used| time - used);
        // If the levelling attitude is off by ψ, the field's dip turns its horizontal part. This is an error of the
        // reference, as slow as that of the tilt; it does not move the tilt.
        let dip = (field.z() / horizontal).wide();
        let usual_rad =
            Scalar::sqrt(square(model.heading_wander_rad) + square(dip) * self.tilt_variance());
        // After a gap the fixes have to correct roll and pitch first.
        let had_gap = self.memory.gates.is_filter_suspect(time);
        let may_lean = had_gap || self.memory.attitude_lost.is_some();
        if may_lean && usual_rad > MAX_UNLEVELLED_RAD {
            return Err(Unusable::NotLevelled);
        }
        if elapsed_s < model.interval_s {
            return Err(Unusable::TooSoon);
        }
        self.relax(trace);
        let before = self.memory.heading.used.replace(time);
        let is_first = before.is_none_or(|before| had_gap && self.memory.gates.suspected > before);
        let wander_rad = self.heading_wander_rad(usual_rad, elapsed_s);
        self.memory.heading_wander = [wander_rad, model.wander_time_s];
        self.memory.heading_revision.is_magnetic = true;
        let lost = self.shall_reset_attitude(time);
        if is_first || lost {
            // Until now the state was the slow error of an attitude reference.
            let missing = square(wander_rad) - self.covariance.variance(first);
            self.add_parameter_variance(first, missing.max(0.0), trace);
        }
        let error = wrap_angle(T::of(declination_rad) - field.azimuth_rad());
        let off = wrap_angle(error - self.estimate(first));
        if lost {
            self.reset_attitude(Vector::new(T::ZERO, T::ZERO, off), ATTITUDE + 2, trace);
        }
        let innovation = if lost { T::ZERO } else { off };
        let heading = self.memory.heading.accepts(time, innovation.wide()).then(|| {
            let sensitivity = Sensitivity::default().with(ATTITUDE + 2, T::ONE).with(first, T::ONE);
            let noise = square(T::of(model.noise_rad));
            ScalarMeasurement::new(Channel::Yaw, innovation, noise, sensitivity)
        });
        let mut report = self.update_one(time, heading, trace);
        if lost {
            report.was_fused([off.wide()]);
        }
        Ok(report)
    }
}
