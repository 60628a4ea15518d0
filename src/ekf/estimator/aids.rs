//! What the estimator makes of a rangefinder and of a second antenna.

use super::super::heading_search::{FoundHeading, HeadingMethod};
use super::super::layout::Layout;
use super::super::measurement::Aid;
use super::super::scalar::Scalar;
use super::super::trace::Trace;
use super::{Estimator, Notice, Phase};
use crate::event::RangeReading;
use crate::frames::Vector;
use crate::gps::AntennaHeading;

impl<L: Layout<N>, const N: usize, T: Scalar, H: HeadingMethod<T>> Estimator<L, N, T, H> {
    #[inline(never)]
    pub(super) fn range(
        &mut self,
        reading: &RangeReading,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        if !self.aiding.rangefinder {
            return;
        }
        let rangefinder = self.rangefinder;
        let result =
            self.navigating().and_then(|filter| filter.update_range(reading, &rangefinder, trace));
        notify(Notice::of_update(reading.time, Aid::Rangefinder, result));
    }

    /// A heading of two antennas also ends the search for one.
    #[inline(never)]
    pub(super) fn antenna_heading(
        &mut self,
        reading: &AntennaHeading,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        if !self.aiding.second_antenna {
            return;
        }
        let (baseline_m, model) = (self.aligner.config().baseline_m, self.antenna_heading);
        if self.phase == Phase::Searching && model.check_baseline(reading, baseline_m).is_ok() {
            let baseline = baseline_m.unwrap_or(Vector::new(1.0, 0.0, 0.0));
            if let Some(FoundHeading { filter, sector, sigma_rad }) =
                self.search.found_at(baseline, reading.heading_rad)
            {
                self.filter.continue_from(filter);
                self.filter.open_heading(sigma_rad);
                self.phase = Phase::Navigating;
                self.search.watch(self.filter.state.body_to_ned);
                notify(Notice::HeadingFound { time: reading.time, sector, sigma_rad });
            }
        }
        let result = self
            .navigating()
            .and_then(|filter| filter.update_antenna_heading(reading, baseline_m, &model, trace));
        notify(Notice::of_update(reading.time, Aid::SecondAntenna, result));
    }
}
