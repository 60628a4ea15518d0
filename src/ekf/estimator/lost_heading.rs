//! A heading that a gap in the samples has hidden, where nothing but motion gives one.
//!
//! Linearised about a heading that is off by as much as a vehicle turns in seconds, a filter ends up sure of a
//! wrong one. So its headings are searched anew, about what was known, beside the filter that flies on; that goes over
//! to the one that is found.

use super::super::heading_search::{FoundHeading, HeadingMethod};
use super::super::layout::{ATTITUDE, Layout};
use super::super::scalar::Scalar;
use super::super::square;
use super::super::trace::Trace;
use super::super::wheels::WheelWatch;
use super::{Estimator, FOUND_SIGMA_RAD, Notice, Phase};
use crate::frames::{Vector, wrap_angle};
use crate::imu::ImuSample;
use crate::time::Time;

/// A vehicle turns by so much, one-sigma, in each second that is hidden, rad: after nine it may point anywhere.
const HIDDEN_RADPS: f64 = 0.35;
/// A heading less sure than this, rad, is searched after trouble.
const UNSURE_RAD: f64 = 0.35;

impl<L: Layout<N>, const N: usize, T: Scalar, H: HeadingMethod<T>> Estimator<L, N, T, H> {
    /// Whether headings are searched beside the filter.
    pub(super) fn is_searching_anew(&self) -> bool {
        H::SEARCHES
            && self.phase == Phase::Navigating
            && self.filter.attitude_lost.is_some()
            && self.search.is_open()
    }

    /// After samples that were missing until `time` for `length_s`, or a reset: searches anew if they hid the heading, and
    /// looks whether the filter is upright.
    #[inline(never)]
    pub(super) fn search_anew(&mut self, time: Time, length_s: f64) {
        self.search.stop_and_monitor(self.filter.state.body_to_ned);
        let is_lost = self.filter.attitude_lost.is_some();
        if is_lost {
            self.doubt_level();
        }
        if !(H::SEARCHES && is_lost) || self.filter.had_heading(time.offset_by(-length_s)) {
            return;
        }
        let variance = self.filter.covariance.variance(ATTITUDE + 2);
        let sigma_rad = Scalar::sqrt(variance).max(HIDDEN_RADPS * length_s);
        self.search.reopen(&self.filter, sigma_rad);
    }

    /// After a sample: searches anew if readings that hid the motion have left the heading so unsure that it cannot be
    /// linearised about.
    #[inline(never)]
    pub(super) fn search_if_lost(&mut self, time: Time) {
        let filter = &mut self.filter;
        if !(H::SEARCHES && filter.gates.doubts_filter(time)) {
            return;
        }
        let unsure = filter.covariance.variance(ATTITUDE + 2) > square(UNSURE_RAD);
        if unsure && !filter.had_heading(time) {
            filter.attitude_lost = Some(time);
            filter.catch_up(&mut ());
            let sigma_rad = Scalar::sqrt(filter.covariance.variance(ATTITUDE + 2));
            self.search.reopen(&self.filter, sigma_rad);
        }
    }

    /// Lets the search take a sample, and ends it when the heading is found.
    #[inline(never)]
    pub(super) fn go_on_searching(
        &mut self,
        sample: &ImuSample,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        if self.search.predict(sample).is_ok()
            && self.search.found().is_some()
            && let Some((sector, sigma_rad)) = self.settle(trace)
        {
            let time = self.filter.state.time;
            notify(Notice::HeadingFound { time, sector, sigma_rad });
        }
    }

    /// Goes on with the heading that leads; gives its sector and one-sigma, rad.
    pub(super) fn settle(&mut self, trace: &mut impl Trace<T, N>) -> Option<(usize, f64)> {
        let before_rad = self.filter.state.body_to_ned.heading_rad();
        let FoundHeading { filter, sector, sigma_rad, wander } = self.search.leading()?;
        let turned_rad = wrap_angle(filter.state.body_to_ned.heading_rad() - before_rad);
        self.filter.rejoin(filter);
        self.filter.open_unknown_wander(wander);
        let sigma_rad = sigma_rad.max(FOUND_SIGMA_RAD);
        self.filter.open_heading(sigma_rad);
        self.filter.gates.doubt_heading(self.filter.state.time);
        trace.reset(0..N);
        trace.turned(Vector::new(0.0, 0.0, turned_rad.wide()));
        self.wheels = WheelWatch::UNSEEN;
        self.search.stop_and_monitor(self.filter.state.body_to_ned);
        Some((sector, sigma_rad))
    }
}
