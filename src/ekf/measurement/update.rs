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
                && (!self.memory.gates.is_contradicted(group) || are_near(is_vertical(at)));
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
                    self.reopen(axis, time);
                    if let Reopening::Motion { lost_s } = reopening {
                        self.reopen_motion(axis, lost_s);
                    }
                }
                joint.project(&mut self.covariance, members.start);
                Verdict::Reset
            } else {
                if self.config.mechanisms.previous_position {
                    self.memory.gates.doubt_start(group, &off);
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

    /// Before a position is fused: notifies the gates if this fix first makes the position known. This is the case if
    /// the `variance` of the position is large compared to the `noise` of the fix, both in m².
    fn judge_position(&mut self, variance: f64, noise: f64) {
        let wander_m = self.memory.gps_wander.map_or(0.0, |[level, ..]| level.into());
        if variance > square(UNKNOWN) * square(wander_m).max(noise) {
            self.memory.gates.reset_position_time();
        }
    }

    /// Raises the variance of the velocity along the axis of a position whose receiver reports no velocity. The
    /// innovation of the position arose within `lost_s`, s.
    #[inline(never)]
    fn reopen_motion(&mut self, axis: &Compared<T>, lost_s: f64) {
        let opened = square(axis.innovation.wide() / lost_s.max(MIN_LOST_S));
        match axis.channel {
            Channel::PositionNorth => self.reopen_level_velocity(VELOCITY, opened),
            Channel::PositionEast => self.reopen_level_velocity(VELOCITY + 1, opened),
            _ => self.covariance.add_variance(VELOCITY + 2, opened),
        }
    }

    /// Raises the variance of a component of the horizontal velocity by `opened`, (m/s)², and the variances of the
    /// attitude.
    fn reopen_level_velocity(&mut self, state: usize, opened: f64) {
        self.covariance.add_variance(state, opened);
        // An attitude error is the likely cause of a velocity error of this size.
        self.reopen_tilt();
        self.covariance.add_variance(ATTITUDE + 2, square(REOPENED_HEADING_RAD));
    }

    /// Raises the variances of roll and pitch, whose error is the likely cause of a velocity error.
    pub(super) fn reopen_tilt(&mut self) {
        self.covariance.add_variance(ATTITUDE, square(REOPENED_TILT_RAD));
        self.covariance.add_variance(ATTITUDE + 1, square(REOPENED_TILT_RAD));
    }

    /// Raises the variances of the states that an axis measures by the square of its innovation.
    ///
    /// # Source
    /// Equation (K9) of docs/equations.md.
    #[inline(never)]
    fn reopen(&mut self, axis: &Compared<T>, time: Time) {
        let opened = square(axis.innovation).wide();
        match axis.channel {
            Channel::PositionNorth => self.covariance.add_variance(POSITION, opened),
            Channel::PositionEast => self.covariance.add_variance(POSITION + 1, opened),
            Channel::PositionDown => {
                self.covariance.add_variance(POSITION + 2, opened);
                // If a barometer agrees with the filter, its level has the same error as the height. The variance of
                // the level is then raised together with that of the height.
                if let Some(level) = L::BARO.filter(|_| self.memory.gates.agrees(Group::Baro, time))
                {
                    self.covariance.add_variance(level, opened);
                    let cross = self.covariance.value(POSITION + 2, level).wide();
                    self.covariance.set_cross(POSITION + 2, level, cross + opened);
                }
            }
            // The effect of tilt on the vertical velocity is of second order.
            Channel::VelocityDown | Channel::RestVelocityDown => {
                self.covariance.add_variance(VELOCITY + 2, opened);
            }
            Channel::VelocityNorth
            | Channel::VelocityEast
            | Channel::RestVelocityNorth
            | Channel::RestVelocityEast => {
                let state = match axis.channel {
                    Channel::VelocityNorth | Channel::RestVelocityNorth => VELOCITY,
                    _ => VELOCITY + 1,
                };
                self.reopen_level_velocity(state, opened);
            }
            Channel::Roll | Channel::Pitch | Channel::Yaw | Channel::BaselineHeading => {
                for state in 0..3 {
                    self.covariance.add_variance(ATTITUDE + state, opened);
                }
            }
            Channel::RestRateX => self.covariance.add_variance(GYRO_BIAS, opened),
            Channel::RestRateY => self.covariance.add_variance(GYRO_BIAS + 1, opened),
            Channel::RestRateZ => self.covariance.add_variance(GYRO_BIAS + 2, opened),
            Channel::BaroHeight => {
                if let Some(state) = L::BARO {
                    self.covariance.add_variance(state, opened);
                }
            }
            // The check for wheels comes before the comparison, so these axes are never rejected.
            Channel::WheelsRight | Channel::WheelsDown => {}
            // Its group has no gate, so the filter is never reset to it.
            Channel::Own(_) => {}
            Channel::Range => {
                if let Some(state) = L::GROUND {
                    self.covariance.add_variance(state, opened);
                }
            }
        }
    }
}

/// Whether an axis of a fix is vertical, by its index: north, east and down of the velocity, then of the position.
const fn is_vertical(index: usize) -> bool {
    index % 3 == 2
}

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
