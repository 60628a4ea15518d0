//! The sequential update: axis after axis, gated by groups.
#![expect(clippy::indexing_slicing, reason = "axes count from 0 to 5, in arrays of six")]

use crate::ekf::filter::Ekf;
use crate::ekf::gate::{Off, Reopening};
use crate::ekf::kernel::covariance::{Gain, Joint, Sensitivities, Sensitivity};
use crate::ekf::kernel::layout::{ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::group::Group;
use crate::ekf::outcome::innovation::{Channel, Innovation, Verdict};
use crate::ekf::outcome::report::Report;
use crate::matrix::square;
use crate::scalar::{Scalar, single};
use crate::time::Time;

/// A scalar measurement without its sensitivity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Compared<T> {
    pub channel: Channel,
    pub innovation: T,
    pub noise: T,
}

/// A scalar measurement ready to be compared: innovation, noise variance, sensitivity.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScalarMeasurement<T> {
    axis: Compared<T>,
    pub sensitivity: Sensitivity<T>,
}

impl<T: Scalar> ScalarMeasurement<T> {
    pub fn new(channel: Channel, innovation: T, noise: T, sensitivity: Sensitivity<T>) -> Self {
        Self { axis: Compared { channel, innovation, noise }, sensitivity }
    }
}

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Fuses one measurement, if there is one: see [`compare`](Self::compare).
    pub(super) fn update_one(
        &mut self,
        time: Time,
        measurement: Option<ScalarMeasurement<T>>,
        trace: &mut impl Trace<T, N>,
    ) -> Report {
        self.update_axes(time, &[measurement, None, None, None, None, None], trace)
    }

    /// Fuses measurements that each have a sensitivity: see [`compare`](Self::compare).
    pub(super) fn update_axes(
        &mut self,
        time: Time,
        axes: &[Option<ScalarMeasurement<T>>; 6],
        trace: &mut impl Trace<T, N>,
    ) -> Report {
        let mut report = Report::default();
        self.update_sequentially(time, axes, &mut report, trace);
        report
    }

    /// [`update_axes`](Self::update_axes), reported in the empty `report`.
    pub(super) fn update_sequentially(
        &mut self,
        time: Time,
        axes: &[Option<ScalarMeasurement<T>>; 6],
        report: &mut Report,
        trace: &mut impl Trace<T, N>,
    ) {
        let sensitivities = axes.each_ref().map(|axis| axis.as_ref().map(|axis| &axis.sensitivity));
        let compared = axes.each_ref().map(|axis| axis.as_ref().map(|axis| axis.axis));
        self.compare(time, &compared, Sensitivities::Each(sensitivities), report, trace);
    }

    /// Compares one axis after the other, gates it and corrects the state. Each group is rejected or accepted as a
    /// whole. The outcome is written to `report`, which is empty before: it is large, and returning it would copy it.
    ///
    /// Returns the shift, m, north, east and down, of the expected position of the next fix. It is the shift of the
    /// position plus that of its slow error.
    ///
    /// # Source
    /// Equation (K8) of docs/equations.md.
    // Not inlined, because its large stack frame would otherwise be part of the caller's.
    #[inline(never)]
    pub(super) fn compare(
        &mut self,
        time: Time,
        axes: &[Option<Compared<T>>; 6],
        sensitivities: Sensitivities<'_, T>,
        report: &mut Report,
        trace: &mut impl Trace<T, N>,
    ) -> [f32; 3] {
        let innovations =
            axes.each_ref().map(|axis| axis.as_ref().map_or(T::ZERO, |axis| axis.innovation));
        let groups = axes.each_ref().map(|axis| axis.as_ref().map(|axis| axis.channel.group()));
        let noise = axes.each_ref().map(|axis| axis.as_ref().map_or(T::ZERO, |axis| axis.noise));
        let mut joint = Joint::<L, T, N>::new(sensitivities, innovations);
        joint.project(&mut self.covariance, 0);
        let mut on_fused = |index: usize, gain: &Gain<T, N>, innovation: T| {
            if trace.wants_updates()
                && let Some(sensitivity) = sensitivities.of::<L, N>(index)
            {
                trace.updated(&sensitivity, gain, innovation.wide());
            }
        };
        // Exception for the fixes of a receiver with a proven contradiction. A fix is accepted if all its axes agree
        // with the filter within the noise of the fix. Its heights may belong to two different levels, so agreement of
        // the horizontal axes is enough for these.
        let near = T::of(square(self.config.gate.sigmas));
        let are_near = |with_vertical: bool| {
            let mut axes = innovations.iter().zip(&noise).enumerate();
            axes.all(|(index, (&off, &noise))| {
                is_vertical(index) && !with_vertical || square(off) <= near * noise
            })
        };
        let mut first = 0;
        // Iterations: at most one an axis: `first` moves on by one or more.
        while first < axes.len() {
            // The axes of a group are adjacent.
            let mut end = first + 1;
            // Iterations: at most one an axis.
            while end < axes.len() && groups[end] == groups[first] {
                end += 1;
            }
            // `end` never exceeds the length: the minimum helps an optimiser for size, which cannot derive this.
            let members = first..end.min(axes.len());
            first = end;
            let Some(group) = groups[members.start] else { continue };
            let (mut largest, mut sum) = (T::ZERO, T::ZERO);
            for index in members.clone() {
                let variance = joint.variance(index) + noise[index];
                let normalised = square(joint.innovation(index)) / variance;
                largest = largest.max(normalised);
                sum += normalised;
            }
            if group == Group::Own {
                largest = joint.largest_in_turn(members.clone(), &noise);
            }
            let at = members.start;
            let second = if members.len() > 1 { joint.innovation(at + 1) } else { T::ZERO };
            let off = Off {
                axes: [joint.innovation(at), second].map(Scalar::wide),
                variance: (joint.variance(at) + noise[at]).wide(),
            };
            let is_biased = self.config.mechanisms.biased_heights
                && group.is_height()
                && self.memory.gates.is_biased(group, time, &off);
            let fits = largest <= square(T::of(self.config.gate.sigmas))
                && !is_biased
                && (!(self.memory.gates.contradiction.proven && group.is_of_fix())
                    || are_near(is_vertical(at)));
            let verdict = if fits {
                if group == Group::HorizontalPosition {
                    self.judge_position(joint.variance(at).wide(), noise[at].wide());
                }
                let count = members.len() as f64;
                self.memory.gates.accepted(group, time, &off, sum.wide() / count);
                Verdict::Accepted
            } else if let Some(reopening) =
                self.memory.gates.note_rejection(group, time, &off, &self.config.gate)
            {
                if !self.config.mechanisms.previous_position {
                    self.memory.gates.forget_previous(group);
                }
                joint.settle(&mut self.covariance, &mut on_fused);
                for axis in axes.iter().take(end).skip(members.start).flatten() {
                    let Some(state) = measured_state::<L, N>(axis.channel) else { continue };
                    self.reopen(state, square(axis.innovation).wide(), time);
                    if let Reopening::Motion { lost_s } = reopening {
                        let opened = square(axis.innovation.wide() / lost_s.max(MIN_LOST_S));
                        self.reopen(state.saturating_sub(POSITION - VELOCITY), opened, time);
                    }
                }
                joint.project(&mut self.covariance, members.start);
                Verdict::Reset
            } else {
                if self.config.mechanisms.previous_position {
                    self.memory.gates.note_rejected_position(group, &off);
                }
                Verdict::Rejected
            };
            for index in members {
                let Some(channel) = axes[index].as_ref().map(|axis| axis.channel) else { continue };
                let innovation = joint.innovation(index).wide();
                let sigma = joint.sigma(index, noise[index]);
                if verdict != Verdict::Rejected {
                    joint.fuse(&mut self.covariance, index, noise[index], sigma, &mut on_fused);
                }
                let sigma = sigma.wide();
                report.push(Innovation { time, channel, innovation, sigma, verdict });
            }
        }
        joint.settle(&mut self.covariance, &mut on_fused);
        report.covariance_reset = self.correct(joint.correction());
        if report.covariance_reset {
            trace.reset(0..N);
            return [0.0; 3];
        }
        trace.corrected(joint.correction());
        let at = |state: usize| joint.correction().get(state).map_or(0.0, |&moved| single(moved));
        [0, 1, 2]
            .map(|axis| at(POSITION + axis) + L::GPS_POSITION.map_or(0.0, |first| at(first + axis)))
    }

    /// Notifies the gates of a position that was unknown before this fix: the `variance` of the position is large
    /// compared to the `noise` of the fix, both in m². Called before the position is fused.
    fn judge_position(&mut self, variance: f64, noise: f64) {
        let wander_m = self.memory.gps_wander.map_or(0.0, |[level, ..]| level.into());
        if variance > square(UNKNOWN) * square(wander_m).max(noise) {
            self.memory.gates.forget_position();
        }
    }

    /// Raises the variances of roll and pitch, whose error is the likely cause of a velocity error.
    pub(super) fn reopen_tilt(&mut self) {
        self.covariance.add_variance(ATTITUDE, square(REOPENED_TILT_RAD));
        self.covariance.add_variance(ATTITUDE + 1, square(REOPENED_TILT_RAD));
    }

    /// Raises the variance of a measured state by `opened`, and those of states that probably share its error.
    ///
    /// # Source
    /// Equation (K9) of docs/equations.md.
    #[inline(never)]
    fn reopen(&mut self, state: usize, opened: f64, time: Time) {
        self.covariance.add_variance(state, opened);
        match state {
            // The axes of a measured attitude are not those of the states.
            ATTITUDE => {
                self.covariance.add_variance(ATTITUDE + 1, opened);
                self.covariance.add_variance(ATTITUDE + 2, opened);
            }
            // An attitude error is the likely cause of an error of the horizontal velocity. The effect of tilt on the
            // vertical velocity is of second order.
            NORTH_VELOCITY | EAST_VELOCITY => {
                self.reopen_tilt();
                self.covariance.add_variance(ATTITUDE + 2, square(REOPENED_HEADING_RAD));
            }
            // If a barometer agrees with the filter, its level has the same error as the height. The variance of the
            // level is then raised together with that of the height.
            HEIGHT => {
                if let Some(level) = L::BARO.filter(|_| self.memory.gates.agrees(Group::Baro, time))
                {
                    self.covariance.add_variance(level, opened);
                    let cross = self.covariance.value(HEIGHT, level).wide();
                    self.covariance.set_cross(HEIGHT, level, cross + opened);
                }
            }
            _ => {}
        }
    }
}

/// The state that a channel measures, the first one of the attitude. `None` for channels to which the filter is never
/// reset.
const fn measured_state<L: Layout<N>, const N: usize>(channel: Channel) -> Option<usize> {
    Some(match channel {
        Channel::PositionNorth => POSITION,
        Channel::PositionEast => POSITION + 1,
        Channel::PositionDown => HEIGHT,
        Channel::VelocityNorth | Channel::RestVelocityNorth => NORTH_VELOCITY,
        Channel::VelocityEast | Channel::RestVelocityEast => EAST_VELOCITY,
        Channel::VelocityDown | Channel::RestVelocityDown => VELOCITY + 2,
        Channel::Roll | Channel::Pitch | Channel::Yaw | Channel::BaselineHeading => ATTITUDE,
        Channel::RestRateX => GYRO_BIAS,
        Channel::RestRateY => GYRO_BIAS + 1,
        Channel::RestRateZ => GYRO_BIAS + 2,
        Channel::BaroHeight => return L::BARO,
        Channel::Range => return L::GROUND,
        // The check for wheels comes before the comparison; the group of own sensors has no gate.
        Channel::WheelsRight | Channel::WheelsDown | Channel::Own(_) => return None,
    })
}

/// Whether an axis of a fix is vertical, by its index: north, east and down of the velocity, then of the position.
const fn is_vertical(index: usize) -> bool {
    index % 3 == 2
}

const NORTH_VELOCITY: usize = VELOCITY;
const EAST_VELOCITY: usize = VELOCITY + 1;
const HEIGHT: usize = POSITION + 2;
/// Ratio of the position's one-sigma to that of the fix above which the position was unknown before the fix.
const UNKNOWN: f64 = 2.0;
/// Lower limit, s, of the time in which an innovation of the position arose. The variance of the velocity is raised by
/// the square of the innovation divided by this time.
const MIN_LOST_S: f64 = 1.0;
/// One-sigma added to roll and pitch (3°) together with a horizontal velocity, rad: tilt is the likely cause of a large
/// velocity error.
const REOPENED_TILT_RAD: f64 = 0.05;
/// One-sigma added to the heading (17°) together with a horizontal velocity, rad.
const REOPENED_HEADING_RAD: f64 = 0.3;
