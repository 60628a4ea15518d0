//! The attitude of a reference system: the inertial unit's own.

use super::super::filter::Ekf;
use super::super::gate::Group;
use super::super::innovation::Channel;
use super::super::layout::{ATTITUDE, Layout};
use super::super::scalar::Scalar;
use super::super::square;
use super::super::trace::Trace;
use super::{Report, ScalarMeasurement, Unusable};
use crate::frames::{Body, Ned, Rotation, Vector, wrap_angle};
use crate::time::Time;

/// A heading further off than this, rad, would turn what a reference says of the tilt.
const FAR_RAD: f64 = 0.35;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Takes in an attitude from elsewhere, the unit's own: roll, pitch and heading from true north.
    ///
    /// # Errors
    /// [`Unusable`] when it cannot be compared, or comes too soon after the last one used.
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
        self.take_in_attitude(time, reference, &mut report, trace).map(|()| report)
    }

    /// Whether an attitude at `time` comes long enough after the last one used.
    pub(in super::super) fn is_attitude_due(&self, time: Time) -> bool {
        self.attitude_used.is_none_or(|used| time - used >= self.config.attitude.interval_s)
    }

    /// [`update_attitude`](Self::update_attitude), told in the empty `report`.
    pub(in super::super) fn take_in_attitude(
        &mut self,
        time: Time,
        reference: Rotation<Body, Ned, T>,
        report: &mut Report,
        trace: &mut impl Trace<T, N>,
    ) -> Result<(), Unusable> {
        let (sin, cos) = self.state.body_to_ned.heading_sincos();
        let down = [T::ZERO, T::ZERO, T::ONE];
        let axes = [
            (Channel::Roll, [cos, sin, T::ZERO], [cos, sin, T::ZERO]),
            (Channel::Pitch, [-sin, cos, T::ZERO], [-sin, cos, T::ZERO]),
            (Channel::Yaw, down, down),
        ];
        self.update_reference(time, reference, &axes, report, trace)
    }

    /// Compares a reference about some axes: each with its channel, its sensitivity to the attitude
    /// error, and the direction of the innovation, which is also its sensitivity to the slow error.
    pub(super) fn update_reference(
        &mut self,
        time: Time,
        reference: Rotation<Body, Ned, T>,
        axes: &[(Channel, [T; 3], [T; 3])],
        report: &mut Report,
        trace: &mut impl Trace<T, N>,
    ) -> Result<(), Unusable> {
        let first = L::ATTITUDE_REFERENCE.ok_or(Unusable::NoState)?;
        if !reference.is_finite() {
            return Err(Unusable::NotFinite);
        }
        let model = self.config.attitude;
        let elapsed_s = self.attitude_used.map_or(model.interval_s, |used| time - used);
        if elapsed_s < model.interval_s {
            return Err(Unusable::TooSoon);
        }
        self.relax(trace);
        self.attitude_used = Some(time);
        let wander_rad = self.heading_wander_rad(model.heading_wander_rad, elapsed_s);
        self.heading_wander = (wander_rad, self.wander_time_s(model.wander_time_s));
        self.heading_revision.is_magnetic = false;
        let wander: Vector<Ned, T> = self.block(first).into();
        let off =
            |filter: &Self| (reference * filter.state.body_to_ned.inverse()).rotation_vector();
        let lost = self.takes_attitude(time).then(|| off(self));
        if let Some(off) = lost {
            self.take_attitude(off - wander, ATTITUDE, trace);
        }
        let (mut reference, mut trusts_heading) = (reference, true);
        if self.heading_distrusted.is_some() {
            let heading_off = reference.heading_rad() - self.state.body_to_ned.heading_rad();
            let heading_off = wrap_angle(heading_off - wander.z());
            trusts_heading = self.trusts_heading(time, heading_off.wide());
            // A heading that is far off would turn what the reference says of the tilt.
            if !trusts_heading {
                reference = reference.turned_in_to(Vector::new(T::ZERO, T::ZERO, -heading_off));
            }
        }
        let own = self.state.body_to_ned;
        let left_of = |reference: Rotation<Body, Ned, T>| {
            (reference * own.inverse()).rotation_vector() - wander
        };
        let mut left = left_of(reference);
        if left.z().abs() > T::of(FAR_RAD) {
            let heading_off = wrap_angle(reference.heading_rad() - own.heading_rad());
            let turned = reference.turned_in_to(Vector::new(T::ZERO, T::ZERO, -heading_off));
            left = left_of(turned) + Vector::new(T::ZERO, T::ZERO, heading_off);
        }
        let noise = square(T::of(model.noise_rad));
        let mut scalars = core::array::from_fn(|_| None);
        let used = axes.iter().filter(|axis| axis.0 != Channel::Yaw || trusts_heading);
        for (slot, &(channel, seen, direction)) in scalars.iter_mut().zip(used) {
            let group = if channel == Channel::Yaw { Group::Heading } else { Group::Tilt };
            let innovation = left.dot(direction.into());
            let measurement = ScalarMeasurement::new((channel, group), innovation, noise);
            let sensitivity = &mut slot.insert(measurement).sensitivity;
            sensitivity.add_block(ATTITUDE, seen);
            sensitivity.add_block(first, direction);
        }
        self.update_sequentially(time, &scalars, report, trace);
        if let Some(off) = lost {
            report.was_taken(axes.iter().map(|axis| off.dot(axis.2.into()).wide()));
        }
        Ok(())
    }
}
