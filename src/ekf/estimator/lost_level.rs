//! Roll and pitch that are wrong after a gap, and their alignment in flight.
//!
//! A vehicle that rolls may have any attitude after a gap. A filter linearised about a wrong attitude soon becomes
//! certain of it. So a second alignment runs in parallel with the filter, on the next samples and fixes. It starts
//! after a gap, and when a velocity is rejected soon after samples that hid the motion. It needs as many samples as the
//! first alignment. The fixes determine the direction of the specific force independently of the filter.

use super::lost_heading::open_about;
use super::phase::{Phase, TiltCheck};
use super::{Estimator, FOUND_SIGMA_RAD, Notice};
use crate::ekf::heading_search::HeadingMethod;
use crate::ekf::kernel::layout::{ACCEL_BIAS, GYRO_BIAS, Layout};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::group::Group;
use crate::ekf::outcome::innovation::Verdict;
use crate::ekf::outcome::prediction::ResetCause;
use crate::ekf::outcome::report::Report;
use crate::ekf::watch::OUTLIER_SIGMAS;
use crate::event::Event;
use crate::gps::Fix;
use crate::ins::{Alignment, HeadingSource, Start};
use crate::scalar::Scalar;

/// Error of roll and pitch, rad (15°), beyond which the filter recovers slowly or not at all.
const LOST_RAD: f64 = 0.26;
/// Largest one-sigma, rad, of an alignment that counts as evidence against the filter.
const SURE_RAD: f64 = 0.2;
/// Largest time difference, s, between a fix and the last sample for the two to describe the same motion.
const FRESH_S: f64 = 0.5;
/// Minimum cosine of the angle (25°) between an axis and straight down. Only about such a steep axis does a heading
/// determine the rotation.
const STEEP: f64 = 0.9;

impl<L: Layout<N>, const N: usize, T: Scalar, H: HeadingMethod<T>> Estimator<L, N, T, H> {
    /// Starts a check of roll and pitch with the next samples.
    pub(super) fn start_tilt_check(&mut self) {
        if H::SEARCHES && self.filter.config.mechanisms.lost_level {
            self.aligner.restart();
            self.tilt_check = TiltCheck::Running;
        }
    }

    /// Continues a check of roll and pitch after a fix, if one is running. Otherwise starts one if a velocity is
    /// rejected soon after samples that hid the motion.
    pub(super) fn monitor_tilt(
        &mut self,
        fix: &Fix,
        report: &Report,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        // A fix that waited through a gap does not match the samples after it.
        let is_fresh = libm::fabs(self.filter.state.time - fix.time) < FRESH_S;
        let moves = self.phase == Phase::Navigating || self.is_searching_again();
        if !(H::SEARCHES && self.filter.config.mechanisms.lost_level && is_fresh && moves) {
            return;
        }
        if self.tilt_check == TiltCheck::Running {
            self.continue_tilt_check(fix, trace, notify);
        } else if self.filter.memory.gates.is_filter_suspect(fix.time) && rejects_velocity(report) {
            self.tilt_check = TiltCheck::Running;
            self.aligner.restart_at(fix, self.filter.state.time);
        }
    }

    /// Adds a fix to the second alignment. If the alignment shows that roll and pitch are wrong, the filter restarts
    /// from it.
    ///
    /// # Source
    /// Equation (H7) of docs/equations.md.
    #[inline(never)]
    fn continue_tilt_check(
        &mut self,
        fix: &Fix,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        // In motion, the specific force alone does not determine roll and pitch.
        if self.aligner.lacks_fix() {
            self.aligner.restart_at(fix, self.filter.state.time);
            return;
        }
        let Some(alignment) = self.aligner.push(&Event::Gps(*fix)) else { return };
        self.aligner.restart_at(fix, self.filter.state.time);
        let [sigma_rad, ..] = alignment.start.attitude_sigma_rad.to_array();
        if alignment.attitude_given || fix.horizontal_velocity_mps.is_none() {
            self.tilt_check = TiltCheck::Idle;
            return;
        }
        if sigma_rad > SURE_RAD {
            return;
        }
        self.tilt_check = TiltCheck::Idle;
        let Some(off_rad) = self.force_direction_error_rad(&alignment) else { return };
        if off_rad > LOST_RAD.max(OUTLIER_SIGMAS * sigma_rad) {
            self.restart_from(&alignment, trace);
            let time = self.filter.state.time;
            notify(Notice::CovarianceReset { time, cause: ResetCause::Misaligned { off_rad } });
        }
    }

    /// Angle between the directions of the specific force according to the solution and to an alignment, rad.
    fn force_direction_error_rad(&self, alignment: &Alignment) -> Option<f64> {
        let felt = alignment.start.state.body_to_ned.inverse() * alignment.axis;
        let by_solution = self.solution()?.body_to_ned.cast() * felt;
        Some(libm::acos(by_solution.dot(alignment.axis).clamp(-1.0, 1.0)))
    }

    /// Restarts from an alignment and keeps the gyro biases; searches the heading if it is unknown.
    fn restart_from(&mut self, alignment: &Alignment, trace: &mut impl Trace<T, N>) {
        let gyro_bias_radps = self.filter.imu_errors().gyro_bias_radps.cast();
        let sigma_radps = self.filter.covariance.largest_sigma(GYRO_BIAS..ACCEL_BIAS);
        let start =
            Start { gyro_bias_radps, gyro_bias_sigma_radps: Some(sigma_radps), ..alignment.start };
        let [.., down] = alignment.axis.to_array();
        let is_open = alignment.heading == HeadingSource::Unknown || down < STEEP;
        let aligned = if is_open { open_about(start, alignment.axis) } else { start };
        self.filter.realign(&aligned, trace);
        self.filter.memory.gates.heading_replaced = self.filter.state.time;
        self.wheels.forget();
        if is_open {
            self.tilt_check = TiltCheck::Failed;
            self.filter.memory.attitude_lost = Some(self.filter.state.time);
            self.search_all(&start, alignment.axis);
        } else {
            self.filter.raise_heading_sigma(FOUND_SIGMA_RAD);
            self.phase = Phase::Navigating;
            self.monitor_heading();
        }
    }
}

/// Whether a velocity of a fix was rejected. A position does not count: it may have jumped while the filter is right.
fn rejects_velocity(report: &Report) -> bool {
    report.innovations().any(|axis| {
        let group = axis.channel.group();
        let is_velocity = matches!(group, Group::HorizontalVelocity | Group::VerticalVelocity);
        is_velocity && axis.verdict != Verdict::Accepted
    })
}
