//! The attitude of a reference system: the inertial unit's own.

use super::update::ScalarMeasurement;
use crate::ekf::filter::Ekf;
use crate::ekf::kernel::covariance::Sensitivity;
use crate::ekf::kernel::layout::{ATTITUDE, Layout};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::innovation::Channel;
use crate::ekf::outcome::report::{Report, Unusable};
use crate::ekf::watch::READING_S;
use crate::frames::{Body, Ned, Rotation, Vector, wrap_angle};
use crate::matrix::square;
use crate::scalar::Scalar;
use crate::time::Time;

/// Largest heading difference, rad, at which the reference's tilt is used together with its heading.
const FAR_RAD: f64 = 0.35;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Fuses an attitude from another source, such as the inertial unit's own: roll, pitch and heading from true north.
    ///
    /// # Errors
    /// [`Unusable`] if the attitude cannot be compared, or comes too soon after the last used one.
    ///
    /// # Source
    /// Equation (M8) of docs/equations.md.
    pub fn update_attitude(
        &mut self,
        time: Time,
        reference: Rotation<Body, Ned, T>,
        trace: &mut impl Trace<T, N>,
    ) -> Result<Report, Unusable> {
        let mut report = Report::default();
        self.fuse_attitude(time, reference, &mut report, trace).map(|()| report)
    }

    /// Whether an attitude at `time` is late enough after the last used one.
    pub(in crate::ekf) fn is_attitude_due(&self, time: Time) -> bool {
        self.memory.heading.since_used_s(time) >= self.config.attitude.interval_s
    }

    /// [`update_attitude`](Self::update_attitude), reported in the empty `report`.
    pub(in crate::ekf) fn fuse_attitude(
        &mut self,
        time: Time,
        reference: Rotation<Body, Ned, T>,
        report: &mut Report,
        trace: &mut impl Trace<T, N>,
    ) -> Result<(), Unusable> {
        let first = L::ATTITUDE_REFERENCE.ok_or(Unusable::NoState)?;
        if !reference.is_finite() {
            return Err(Unusable::NotFinite);
        }
        let model = self.config.attitude;
        let elapsed_s = self.memory.heading.since_used_s(time);
        if elapsed_s < model.interval_s {
            return Err(Unusable::TooSoon);
        }
        self.relax(trace);
        self.memory.heading.used = Some(time);
        let wander_rad = self.heading_wander_rad(model.heading_wander_rad, elapsed_s);
        self.memory.heading_wander = [wander_rad, model.wander_time_s];
        self.memory.heading_revision.is_magnetic = false;
        let wander: Vector<Ned, T> = self.block(first).into();
        let off =
            |filter: &Self| (reference * filter.state.body_to_ned.inverse()).rotation_vector();
        let lost = self.shall_reset_attitude(time).then(|| off(self));
        if let Some(off) = lost {
            self.reset_attitude(off - wander, ATTITUDE, trace);
        }
        let own = self.state.body_to_ned;
        let mut left = off(self) - wander;
        let is_far = left.z().abs() > T::of(FAR_RAD);
        let accepts_heading = self.memory.heading.accepts(time, left.z().wide());
        if is_far || !accepts_heading {
            let heading_off = wrap_angle(reference.heading_rad() - own.heading_rad());
            let turned = reference.turned_in_to(Vector::new(T::ZERO, T::ZERO, -heading_off));
            let tilt = (turned * own.inverse()).rotation_vector() - wander;
            left = Vector::new(tilt.x(), tilt.y(), heading_off - wander.z());
        }
        let [tilt_excess, heading_excess] = self.watch_attitude(time, left, elapsed_s)?;
        let (sin, cos) = own.heading_sincos();
        let axes = [
            (Channel::Roll, [cos, sin, T::ZERO]),
            (Channel::Pitch, [-sin, cos, T::ZERO]),
            (Channel::Yaw, [T::ZERO, T::ZERO, T::ONE]),
        ];
        let noise = square(T::of(model.noise_rad));
        let mut scalars = [None; 6];
        let used = axes.iter().filter(|axis| axis.0 != Channel::Yaw || accepts_heading);
        for (slot, &(channel, axis)) in scalars.iter_mut().zip(used) {
            let excess = if channel == Channel::Yaw { heading_excess } else { tilt_excess };
            let (off, noise) = (left.dot(axis.into()), noise + excess);
            let measurement = ScalarMeasurement::new(channel, off, noise, Sensitivity::default());
            // In place: copies of the sensitivities would cost a thousand instructions.
            let sensitivity = &mut slot.insert(measurement).sensitivity;
            sensitivity.add_block(ATTITUDE, axis);
            sensitivity.add_block(first, axis);
        }
        self.update_sequentially(time, &scalars, report, trace);
        if let Some(off) = lost {
            report.was_fused(axes.iter().map(|axis| off.dot(axis.1.into()).wide()));
        }
        Ok(())
    }

    /// Checks whether a reference turns as the gyros do, given its difference `off_rad`, `elapsed_s` after the previous
    /// one. Returns its variances in tilt and heading in addition to its noise, rad².
    ///
    /// # Errors
    /// [`Unusable::InconsistentWithGyros`] if it does not.
    fn watch_attitude(
        &mut self,
        time: Time,
        off_rad: Vector<Ned, T>,
        elapsed_s: f64,
    ) -> Result<[T; 2], Unusable> {
        if !self.config.mechanisms.attitude_monitor {
            return Ok([T::ZERO; 2]);
        }
        let off_rad = off_rad.cast().to_array();
        let watch = &mut self.memory.attitude_watch;
        // After faulty inertial samples the gyros are no reference. In a disturbed field, the reference's heading
        // follows the field.
        let field = &self.memory.field_watch;
        if elapsed_s > READING_S
            || self.memory.gates.is_filter_suspect(time)
            || field.heading_sigma_rad > 0.0
        {
            watch.forget();
        }
        let elapsed_s = elapsed_s.min(READING_S) as f32;
        if !field.is_suspect() {
            watch.push(off_rad, elapsed_s);
        }
        if watch.is_inconsistent() {
            return Err(Unusable::InconsistentWithGyros);
        }
        Ok(watch.excess(self.config.attitude.noise_rad, elapsed_s))
    }
}
