//! The estimator's use of a user's own sensors.

use super::Estimator;
use super::phase::Phase;
use crate::ekf::heading_search::HeadingMethod;
use crate::ekf::kernel::layout::Layout;
use crate::ekf::kernel::trace::Trace;
use crate::ekf::measurement::Measurement;
use crate::ekf::outcome::report::{Report, Unusable};
use crate::scalar::Scalar;
use crate::time::Time;

impl<L: Layout<N>, const N: usize, T: Scalar, H: HeadingMethod<T>> Estimator<L, N, T, H> {
    /// Fuses a reading of a user's own sensor, valid at `time`, at once: see [`Ekf::update`](super::Ekf::update). Call
    /// it when the reading arrives, between the events; nothing is stored for later samples.
    ///
    /// # Errors
    /// [`Unusable::NotAligned`] before the first solution, [`Unusable::HeadingUnknown`] during a heading search, and
    /// those of [`Ekf::update`](super::Ekf::update). A reading that is compared and rejected is no error: the
    /// [`Report`] contains its verdict.
    pub fn update(
        &mut self,
        measurement: &(impl Measurement + ?Sized),
        time: Time,
    ) -> Result<Report, Unusable> {
        self.update_traced(measurement, time, &mut ())
    }

    /// [`update`](Self::update), with the filter observed by `trace`.
    ///
    /// # Errors
    /// As [`update`](Self::update).
    pub fn update_traced(
        &mut self,
        measurement: &(impl Measurement + ?Sized),
        time: Time,
        trace: &mut impl Trace<T, N>,
    ) -> Result<Report, Unusable> {
        match self.phase {
            Phase::Aligning => Err(Unusable::NotAligned),
            Phase::Searching => Err(Unusable::HeadingUnknown),
            Phase::Navigating => self.filter.update(measurement, time, trace),
        }
    }
}
