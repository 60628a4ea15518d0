//! The sequential update: axis after axis, gated by groups.

use super::super::covariance::{Joint, Sensitivity};
use super::super::filter::Ekf;
use super::super::gate::Group;
use super::super::innovation::{Channel, Innovation, Verdict};
use super::super::layout::{ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use super::super::scalar::Scalar;
use super::super::square;
use super::super::trace::Trace;
use super::Report;
use crate::time::Time;

/// A scalar measurement ready to be compared: innovation, sensitivity, variance.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScalarMeasurement<T> {
    pub channel: Channel,
    pub group: Group,
    pub innovation: T,
    pub noise: T,
    pub sensitivity: Sensitivity<T>,
}

impl<T: Scalar> ScalarMeasurement<T> {
    /// A measurement that sees no state yet.
    pub fn new((channel, group): (Channel, Group), innovation: T, noise: T) -> Self {
        Self { channel, group, innovation, noise, sensitivity: Sensitivity::default() }
    }
}

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Compares, gates, corrects: axis after axis, each group refused or taken as a whole.
    ///
    /// # Source
    /// Equation (K8) of docs/equations.md.
    // Its frame is large; inlined, it would stand beneath whatever else its caller calls.
    #[inline(never)]
    pub(super) fn update_sequentially(
        &mut self,
        time: Time,
        axes: &[Option<ScalarMeasurement<T>>; 6],
        trace: &mut impl Trace<T, N>,
    ) -> Report {
        let mut report = Report::default();
        let mut correction = [T::ZERO; N];
        let sensitivities = axes.each_ref().map(|axis| axis.as_ref().map(|axis| &axis.sensitivity));
        let innovations =
            axes.each_ref().map(|axis| axis.as_ref().map_or(T::ZERO, |axis| axis.innovation));
        let mut joint = Joint::new(sensitivities, innovations);
        joint.project(&self.covariance, 0);
        let mut done: Option<Group> = None;
        for (first, axis) in axes.iter().enumerate() {
            let Some(axis) = axis.as_ref().filter(|axis| done != Some(axis.group)) else {
                continue;
            };
            done = Some(axis.group);
            let group = || {
                let present =
                    axes.iter().enumerate().filter_map(|(n, other)| Some((n, other.as_ref()?)));
                present.filter(|(_, other)| other.group == axis.group)
            };
            let (mut largest, mut sum, mut count, mut one) = (T::ZERO, T::ZERO, T::ZERO, T::ZERO);
            for (index, axis) in group() {
                let variance = joint.variance(index) + axis.noise;
                let normalised = square(joint.innovation(index)) / variance;
                largest = largest.max(normalised);
                one = joint.innovation(index) / variance.sqrt();
                sum += normalised;
                count += T::ONE;
            }
            // Written so that a NaN is refused.
            let leans = self.gates.leans(axis.group, time, one.wide());
            let fits = largest <= square(T::of(self.config.gate.sigmas)) && !leans;
            let verdict = if fits {
                self.gates.accepted(axis.group, time, (sum / count).wide());
                Verdict::Accepted
            } else if self.gates.refused(axis.group, time, &self.config.gate) {
                joint.settle(&mut self.covariance);
                for (_, axis) in group() {
                    self.reopen(axis);
                }
                joint.project(&self.covariance, first);
                Verdict::Reopened
            } else {
                Verdict::Rejected
            };
            for (index, axis) in group() {
                let innovation = joint.innovation(index);
                let sigma = (joint.variance(index) + axis.noise).sqrt();
                if verdict != Verdict::Rejected {
                    let gain = joint.take_in(&mut self.covariance, index, axis.noise);
                    for (value, &factor) in correction.iter_mut().zip(&gain.gain) {
                        *value += factor * innovation;
                    }
                    trace.updated(&axis.sensitivity, &gain, innovation.wide());
                }
                let channel = axis.channel;
                let (innovation, sigma) = (innovation.wide(), sigma.wide());
                report.push(Innovation { time, channel, innovation, sigma, verdict });
            }
        }
        joint.settle(&mut self.covariance);
        report.covariance_reset = self.correct(&correction);
        if report.covariance_reset {
            trace.reset(0..N);
        }
        report
    }

    /// Opens the states an axis speaks of by the size of its innovation.
    ///
    /// # Source
    /// Equation (K9) of docs/equations.md.
    #[inline(never)]
    fn reopen(&mut self, axis: &ScalarMeasurement<T>) {
        let opened = square(axis.innovation).wide();
        match axis.channel {
            Channel::PositionNorth => self.covariance.add_variance(POSITION, opened),
            Channel::PositionEast => self.covariance.add_variance(POSITION + 1, opened),
            Channel::PositionDown => self.covariance.add_variance(POSITION + 2, opened),
            // What tilt does to the vertical velocity is of the second order.
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
                self.covariance.add_variance(state, opened);
                // A velocity this far off came through the attitude.
                self.covariance.add_variance(ATTITUDE, square(REOPENED_TILT_RAD));
                self.covariance.add_variance(ATTITUDE + 1, square(REOPENED_TILT_RAD));
                self.covariance.add_variance(ATTITUDE + 2, square(REOPENED_HEADING_RAD));
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
            Channel::Range => {
                if let Some(state) = L::GROUND {
                    self.covariance.add_variance(state, opened);
                }
            }
        }
    }
}

const REOPENED_TILT_RAD: f64 = 0.05;
const REOPENED_HEADING_RAD: f64 = 0.3;
