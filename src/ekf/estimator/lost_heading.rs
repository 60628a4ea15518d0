//! The heading search. It finds a heading that is unknown at the start, or was lost in a gap of the samples, if only
//! motion can show it.
//!
//! A vehicle may turn far within a few seconds. A filter linearised about the heading before such a gap becomes certain
//! of a wrong heading. After the gap a search about the last known heading starts.

use super::phase::Phase;
use super::{Estimator, FOUND_SIGMA_RAD, Notice};
use crate::ekf::heading_search::{HeadingMethod, HeadingSearch, HypothesisMotion};
use crate::ekf::kernel::layout::{ACCEL_BIAS, ATTITUDE, GYRO_BIAS, Layout};
use crate::ekf::kernel::trace::Trace;
use crate::frames::{Ned, Vector};
use crate::ins::Start;
use crate::scalar::Scalar;
use crate::time::Time;

/// One-sigma of a vehicle's turn rate during a gap, rad/s: after nine seconds its heading is unknown.
const HIDDEN_RADPS: f64 = 0.35;

impl<L: Layout<N>, const N: usize, T: Scalar, H: HeadingMethod<T>> Estimator<L, N, T, H> {
    /// Whether a previously known heading is searched again.
    pub(super) fn is_searching_again(&self) -> bool {
        self.phase == Phase::Searching && self.filter.memory.attitude_lost.is_some()
    }

    /// Handles a reset, or a gap of `length_s` that ended at `time`. Searches the heading again if the gap hid it, and
    /// checks roll and pitch.
    #[inline(never)]
    pub(super) fn search_again(&mut self, time: Time, length_s: f64) {
        self.interrupt_search();
        if self.phase != Phase::Navigating || self.filter.memory.attitude_lost.is_none() {
            return;
        }
        self.start_tilt_check();
        if H::SEARCHES && !self.filter.had_heading(time.offset_by(-length_s)) {
            let variance = self.filter.covariance.variance(ATTITUDE + 2);
            self.search_about(Scalar::sqrt(variance).max(HIDDEN_RADPS * length_s));
        }
    }

    /// Searches all headings from a start whose attitude about `axis` is unknown.
    pub(super) fn search_all(&mut self, start: &Start, axis: Vector<Ned>) {
        if let Some(search) = self.search.bank() {
            search.start(start, axis, self.filter.config.imu.gyro_bias_sigma_radps);
        }
        self.phase = Phase::Searching;
    }

    /// Searches about the present heading, of one-sigma `sigma_rad`.
    fn search_about(&mut self, sigma_rad: f64) {
        let filter = &self.filter;
        let others = [ATTITUDE..ATTITUDE + 2, GYRO_BIAS..ACCEL_BIAS]
            .map(|states| filter.covariance.largest_sigma(states));
        if let Some(search) = self.search.bank() {
            search.start_about(filter.state.body_to_ned, sigma_rad, others);
        }
        self.phase = Phase::Searching;
    }

    /// Lets the filter follow the search after a fix. Once the heading is found, the filter navigates.
    #[inline(never)]
    pub(super) fn follow_search(
        &mut self,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        let Some(motion) = self.search.bank().and_then(HeadingSearch::motion) else { return };
        if motion.is_found {
            let time = self.filter.state.time;
            // The heading comes from motion alone, so it counts as unconfirmed. A heading found with two antennas does
            // not: their next readings correct it.
            self.filter.memory.gates.heading_replaced = time;
            self.accept_heading(&motion, (time, FOUND_SIGMA_RAD), trace, notify);
        } else {
            self.filter.follow(&motion, trace);
        }
    }

    /// Continues with a heading found at `time`, with a one-sigma of at least `min_rad`, rad.
    pub(super) fn accept_heading(
        &mut self,
        motion: &HypothesisMotion<T>,
        (time, min_rad): (Time, f64),
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        if !self.filter.accept_heading(motion, min_rad, trace) {
            return;
        }
        self.phase = Phase::Navigating;
        self.wheels.forget();
        self.monitor_heading();
        let HypothesisMotion { turn_rad, heading_sigma_rad: sigma_rad, .. } = *motion;
        notify(Notice::HeadingFound { time, turn_rad, sigma_rad });
    }
}

/// Returns `start` with the one-sigma of its heading about `axis` instead of about down. The attitude about `axis` is
/// unknown.
pub(super) fn open_about(start: Start, axis: Vector<Ned>) -> Start {
    let [.., open_rad] = start.attitude_sigma_rad.to_array();
    HeadingSearch::turned_start(start, axis, 0.0, open_rad)
}
