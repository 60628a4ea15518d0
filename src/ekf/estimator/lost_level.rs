//! Roll and pitch that were lost, and are aligned anew in flight.
//!
//! After a gap, a vehicle that rolls may have any attitude, and a filter that is linearised about a wrong one is soon
//! sure of it. So a second alignment is made beside the filter, from the next samples and fixes: after a gap, and where
//! a velocity is refused soon after samples that hid the motion. It takes as many samples as any alignment. The fixes
//! tell in which direction the force acts that the unit feels, whatever the filter makes of it.

use super::super::heading_search::{HeadingMethod, HeadingSearch};
use super::super::innovation::{Channel, Verdict};
use super::super::layout::{GYRO_BIAS, Layout};
use super::super::measurement::Report;
use super::super::prediction::ResetCause;
use super::super::scalar::Scalar;
use super::super::trace::Trace;
use super::super::wheels::WheelWatch;
use super::{Estimator, FOUND_SIGMA_RAD, Notice, Phase};
use crate::event::Event;
use crate::gps::Fix;
use crate::ins::{Alignment, HeadingSource, Start};

/// What is known of whether the filter is upright.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Level {
    /// Nothing speaks against it.
    Believed,
    /// An alignment beside the filter is under way.
    Doubted,
    /// Roll and pitch were wrong, and are searched together with the heading.
    Lost,
}

/// A filter whose roll and pitch are off by more than this, rad (15°), recovers by itself slowly or not at all.
const LOST_RAD: f64 = 0.26;
/// An alignment whose one-sigma is more than this, rad, tells nothing against a filter.
const SURE_RAD: f64 = 0.2;
/// Nor does one that differs from the filter by less than so many one-sigmas.
const SIGMAS: f64 = 3.0;
/// A fix whose time differs from that of the last sample by more than this, s, tells of another motion.
const FRESH_S: f64 = 0.5;
/// A heading does not tell the rotation about an axis that is further from straight down than this, as a cosine (25°).
const STEEP: f64 = 0.9;

impl<L: Layout<N>, const N: usize, T: Scalar, H: HeadingMethod<T>> Estimator<L, N, T, H> {
    /// Begins to check whether the filter is upright, from the next samples on.
    pub(super) fn doubt_level(&mut self) {
        if H::SEARCHES {
            self.aligner.restart();
            self.level = Level::Doubted;
        }
    }

    /// After a fix: checks whether the filter is upright where that is in doubt. Where it is not, begins a check if a
    /// velocity is refused soon after samples that hid the motion.
    pub(super) fn mind_level(
        &mut self,
        fix: &Fix,
        report: &Report,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        // A fix that waited through a gap does not tell what the samples after it feel.
        let is_fresh = libm::fabs(self.filter.state.time - fix.time) < FRESH_S;
        let moves = self.phase == Phase::Navigating || self.is_searching_again();
        if !(H::SEARCHES && is_fresh && moves) {
            return;
        }
        if self.level == Level::Doubted {
            self.check_level(fix, trace, notify);
        } else if self.filter.gates.doubts_filter(fix.time) && refuses_velocity(report) {
            self.level = Level::Doubted;
            self.aligner.restart_at(fix, self.filter.state.time);
        }
    }

    /// Takes a fix into the alignment beside the filter. Where the alignment shows that the filter is not upright, the
    /// filter goes on from it.
    ///
    /// # Source
    /// Equation (H7) of docs/equations.md.
    #[inline(never)]
    fn check_level(
        &mut self,
        fix: &Fix,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        // A vehicle that moves is not levelled by its force alone.
        if self.aligner.lacks_fix() {
            self.aligner.restart_at(fix, self.filter.state.time);
            return;
        }
        let Some(alignment) = self.aligner.push(&Event::Gps(*fix)) else { return };
        self.aligner.restart_at(fix, self.filter.state.time);
        let [sigma_rad, ..] = alignment.start.attitude_sigma_rad.to_array();
        if alignment.attitude_given || fix.horizontal_velocity_mps.is_none() {
            self.level = Level::Believed;
            return;
        }
        if sigma_rad > SURE_RAD {
            return;
        }
        self.level = Level::Believed;
        let Some(off_rad) = self.off_upright_rad(&alignment) else { return };
        if off_rad > LOST_RAD.max(SIGMAS * sigma_rad) {
            self.align_anew(&alignment, trace);
            let time = self.filter.state.time;
            notify(Notice::CovarianceReset { time, cause: ResetCause::Misaligned { off_rad } });
        }
    }

    /// The angle between the force that the body feels by the solution and by an alignment, rad.
    fn off_upright_rad(&self, alignment: &Alignment) -> Option<f64> {
        let felt = alignment.start.state.body_to_ned.inverse() * alignment.axis;
        let by_solution = self.solution()?.body_to_ned.cast() * felt;
        Some(libm::acos(by_solution.dot(alignment.axis).clamp(-1.0, 1.0)))
    }

    /// Goes on from an alignment and keeps what is known of the gyros; searches the heading where nothing gave it.
    fn align_anew(&mut self, alignment: &Alignment, trace: &mut impl Trace<T, N>) {
        let gyro_bias_radps = self.filter.imu_errors().gyro_bias_radps.cast();
        let variance = (0..3)
            .map(|axis| self.filter.covariance.variance(GYRO_BIAS + axis))
            .fold(0.0, f64::max);
        let sigma_radps = Some(Scalar::sqrt(variance));
        let start =
            Start { gyro_bias_radps, gyro_bias_sigma_radps: sigma_radps, ..alignment.start };
        self.filter.realign(&start, trace);
        self.filter.open_heading(FOUND_SIGMA_RAD);
        self.filter.gates.doubt_heading(self.filter.state.time);
        self.wheels = WheelWatch::UNSEEN;
        self.phase = Phase::Navigating;
        self.search.monitor(self.filter.state.body_to_ned);
        let [.., down] = alignment.axis.to_array();
        if alignment.heading == HeadingSource::Unknown || down < STEEP {
            self.level = Level::Lost;
            let [.., open_rad] = start.attitude_sigma_rad.to_array();
            let open = HeadingSearch::turned_start(start, alignment.axis, 0.0, open_rad);
            self.filter.realign(&open, trace);
            self.filter.attitude_lost = Some(self.filter.state.time);
            let bias_sigma_radps = self.filter.config.imu.gyro_bias_sigma_radps;
            self.search.start(&start, alignment.axis, bias_sigma_radps);
            self.phase = Phase::Searching;
        }
    }
}

/// Whether a velocity of a fix was refused. A place does not count: it may have jumped while the filter is right.
fn refuses_velocity(report: &Report) -> bool {
    report.innovations().any(|axis| {
        let is_velocity = matches!(
            axis.channel,
            Channel::VelocityNorth | Channel::VelocityEast | Channel::VelocityDown
        );
        is_velocity && axis.verdict != Verdict::Accepted
    })
}
