//! Magnetic heading.

use super::super::filter::Ekf;
use super::super::innovation::Channel;
use super::super::layout::Layout;
use super::super::scalar::Scalar;
use super::super::trace::Trace;
use super::attitude::DOWN;
use super::{Report, Unusable};
use crate::frames::{Body, Vector};
use crate::time::Time;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Takes in a magnetic field, gauss: heading from magnetic north, `declination_rad` east of true
    /// north, levelled by the filter's own roll and pitch.
    ///
    /// # Errors
    /// [`Unusable`] when it cannot be compared, or comes too soon after the last one used.
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
        let field = self.state.body_to_ned * field_gauss;
        let horizontal = libm::hypot(field.x(), field.y());
        if !(field.is_finite() && horizontal > 0.02 * field.norm()) {
            return Err(Unusable::NotFinite);
        }
        let error = libm::atan2(field.y(), field.x()) - declination_rad;
        let turn = Vector::new(0.0, 0.0, -error);
        let reference = self.state.body_to_ned.turned_in_to(turn);
        // Levelled by an attitude that is off by ψ, the field's dip turns its horizontal part.
        let dip = field.z() / horizontal;
        let seen = [-dip * field.x() / horizontal, -dip * field.y() / horizontal, 1.0];
        self.update_reference(time, reference, &[(Channel::Yaw, seen, DOWN)], trace)
    }
}
