//! A flight and its estimate as one uniformly sampled record.

use nalgebra::DMatrix;

use super::error::IdentifyError;
use super::flight_condition::FlightCondition;
use super::gaps::{Gap, gaps};
use crate::record::preprocess::{LowPass, PreprocessError, filtered};
use crate::record::{Experiment, STICKS, TestPoint, Tone, notch_delay_s, stepped, without_tones};
use hovernav::ekf::Solution;
use hovernav::gps::Fix;
use hovernav::time::Time;
use hovernav_dataset::Dataset;

/// Signals of the estimated motion of a flight, in order.
pub const MOTION: [&str; 8] = ["u", "v", "w", "p", "q", "r", "phi", "theta"];

/// Terms that rigid-body kinematics add to the linear equations of u, v, w (m/s²), φ and θ (rad/s).
pub(super) const KINEMATIC: [&str; 5] = ["ku", "kv", "kw", "kphi", "ktheta"];

/// Movement that an autopilot injected on each stick, in the order of [`STICKS`].
pub(super) const INJECTED: [&str; 4] =
    ["injected_lateral", "injected_longitudinal", "injected_collective", "injected_pedal"];

/// Steps of the test points on each stick, used where a record does not contain the injected movement.
pub(super) const STEPPED: [&str; 4] =
    ["stepped_lateral", "stepped_longitudinal", "stepped_collective", "stepped_pedal"];

/// Order of the anti-alias filter before decimation.
const ALIAS_ORDER: usize = 8;
/// Corner frequency of the anti-alias filter, as a fraction of half the new sample rate.
const ALIAS_PART: f64 = 0.8;

/// Gravity of the equations, m/s².
pub(super) const GRAVITY_MPS2: f64 = 9.81;

/// Source of the velocity used for identification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Velocity {
    /// The estimator's velocity.
    Estimated,
    /// The receiver's own velocity, each fix held until the next and rotated into body axes, as in the thesis.
    HeldGps,
}

/// A flight as one uniformly sampled record.
#[derive(Debug, Clone)]
pub struct FlightRecord {
    /// Time of the first sample.
    pub start: Time,
    /// The inputs are [`STICKS`] and their injected movement, or else their steps. The outputs are [`MOTION`], then the
    /// kinematic terms of the linear equations: ku, kv, kw, m/s², kphi and ktheta, rad/s.
    pub experiment: Experiment,
    /// Heading at each sample, rad.
    pub heading_rad: Vec<f64>,
    /// Range of flight in which the model is identified.
    pub condition: FlightCondition,
    /// Parts of the flight without sticks or motion. There the sticks hold their last value, and the motion is
    /// interpolated.
    pub gaps: Vec<Gap>,
}

impl FlightRecord {
    /// Samples `solutions` of `dataset`, in time order, on a uniform grid at their usual interval. Motion is
    /// interpolated, and sticks are relative to their median. Each stick is the mean of its held values over the
    /// interval to the next sample: a step between two samples keeps its time.
    ///
    /// # Errors
    /// [`IdentifyError`] where there are no controls or no solutions.
    pub fn new(
        dataset: &Dataset,
        solutions: &[Solution],
        velocity: Velocity,
    ) -> Result<Self, IdentifyError> {
        let short = IdentifyError::NoSolution { found: solutions.len() };
        let (Some(first), Some(last)) = (solutions.first(), solutions.last()) else {
            return Err(short);
        };
        let mut intervals: Vec<f64> =
            solutions.windows(2).map(|pair| pair[1].time - pair[0].time).collect();
        intervals.sort_by(f64::total_cmp);
        if solutions.len() < 100 {
            return Err(short);
        }
        let usual = intervals[intervals.len() / 2];
        // The interval is the mean of all intervals within 10 % of the median. The median alone contains the rounding
        // of the clock.
        let usual: Vec<f64> = intervals
            .into_iter()
            .filter(|interval| (0.9..1.1).contains(&(interval / usual)))
            .collect();
        let period_s = usual.iter().sum::<f64>() / usual.len() as f64;
        let span = last.time - first.time;
        let samples = (span / period_s + 1e-6) as usize + 1;
        if dataset.controls.is_empty() {
            return Err(IdentifyError::NoControls);
        }
        let rows: Vec<Time> = dataset.controls.iter().map(|row| row.0).collect();
        if let [one, .., other] = rows[..]
            && (other < first.time || one > last.time)
        {
            return Err(IdentifyError::Apart {
                sticks_s: [one, other].map(Time::seconds),
                motion_s: [first.time, last.time].map(Time::seconds),
            });
        }
        let (deliberate, own_names) = if dataset.injected.iter().flatten().all(|own| *own == 0.0) {
            (stepped(&dataset.controls), STEPPED)
        } else {
            (dataset.injected.clone(), INJECTED)
        };
        let of_motion: Vec<Time> = solutions.iter().map(|solution| solution.time).collect();
        let ends = [first.time, last.time];
        let gaps = [gaps("sticks", &rows, ends), gaps("motion", &of_motion, ends)].concat();
        let deliberate: Vec<_> = rows.into_iter().zip(deliberate).collect();
        let moved = [&dataset.controls, &deliberate];
        let trims = moved.map(|controls| medians(controls)).concat();
        let mut inputs = DMatrix::zeros(samples, STICKS.len() * moved.len());
        let mut outputs = DMatrix::zeros(samples, MOTION.len() + KINEMATIC.len());
        let mut heading_rad = Vec::with_capacity(samples);
        for sample in 0..samples {
            let time = first.time.offset_by(sample as f64 * period_s);
            let held = moved.iter().flat_map(|controls| held_mean(controls, time, period_s));
            for (input, value) in held.enumerate() {
                inputs[(sample, input)] = value - trims[input];
            }
            let next = solutions
                .partition_point(|solution| solution.time < time)
                .clamp(1, solutions.len() - 1);
            let (before, after) = (&solutions[next - 1], &solutions[next]);
            let part = ((time - before.time) / (after.time - before.time)).clamp(0.0, 1.0);
            let (one, other) =
                (motion(before, &dataset.fixes, velocity), motion(after, &dataset.fixes, velocity));
            let motion: [f64; 8] = std::array::from_fn(|channel| {
                one[channel] + part * (other[channel] - one[channel])
            });
            for (channel, value) in motion.into_iter().chain(kinematic(motion)).enumerate() {
                outputs[(sample, channel)] = value;
            }
            heading_rad.push(before.body_to_ned.euler().yaw_rad);
        }
        let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        let name = dataset.manifest.name.clone();
        let measured = [&MOTION[..], &KINEMATIC].concat();
        let moved = names(&[STICKS, own_names].concat());
        let experiment = Experiment::new(name, period_s, moved, names(&measured), inputs, outputs)?;
        let condition = FlightCondition::HOVER;
        Ok(Self { start: first.time, experiment, heading_rad, condition, gaps })
    }

    /// The record for a model valid in `condition`.
    #[must_use]
    pub fn within(self, condition: FlightCondition) -> Self {
        Self { condition, ..self }
    }

    /// Whether the motion at `sample` is in the condition.
    pub(super) fn holds(&self, sample: usize) -> bool {
        let value = |channel: usize| self.experiment.outputs[(sample, channel)];
        sample < self.experiment.samples()
            && self.condition.holds([0, 1, 2].map(value), [6, 7].map(value))
    }

    /// The record without `tones`; see [`without_tones`].
    pub(super) fn without_tones(&self, tones: &[Tone], filled: &[&str]) -> Self {
        let later_s = notch_delay_s(tones, self.experiment.period_s);
        Self {
            start: self.start.offset_by(-later_s),
            experiment: without_tones(&self.experiment, tones, filled),
            heading_rad: self.heading_rad.clone(),
            condition: self.condition,
            gaps: self.gaps.clone(),
        }
    }

    /// Whether sticks and motion were recorded from `from` to `to`, and long enough before `from` for the filters to
    /// settle after a gap.
    pub(super) fn is_whole(&self, from: Time, to: Time) -> bool {
        /// Settling time, s: three time constants of the narrowest notch.
        const FORGOTTEN_S: f64 = 2.0;
        !self.gaps.iter().any(|gap| gap.from < to && from < gap.to.offset_by(FORGOTTEN_S))
    }

    /// The record low-pass filtered and decimated to the longest whole multiple of its period up to `longest_s`.
    ///
    /// Each stick is then the mean over each new interval, with the attenuation of a held mean compensated.
    ///
    /// # Errors
    /// [`PreprocessError::TooShort`].
    pub(super) fn thinned(&self, longest_s: f64) -> Result<Self, PreprocessError> {
        let every = (longest_s / self.experiment.period_s) as usize;
        if every < 2 {
            return Ok(self.clone());
        }
        let period_s = every as f64 * self.experiment.period_s;
        let low_pass = LowPass::butterworth(
            ALIAS_ORDER,
            ALIAS_PART * 0.5 / period_s,
            self.experiment.period_s,
        )?;
        let smooth = filtered(&self.experiment, &low_pass)?;
        let samples = smooth.samples() / every;
        let means = DMatrix::from_fn(samples, smooth.inputs.ncols(), |sample, input| {
            smooth.inputs.view((sample * every, input), (every, 1)).mean()
        });
        let inputs = unattenuated(&means);
        let outputs = DMatrix::from_fn(samples, smooth.outputs.ncols(), |sample, output| {
            smooth.outputs[(sample * every, output)]
        });
        let heading_rad = (0..samples).map(|sample| self.heading_rad[sample * every]).collect();
        let experiment = Experiment { period_s, inputs, outputs, is_smooth: true, ..smooth };
        let (condition, gaps) = (self.condition, self.gaps.clone());
        Ok(Self { start: self.start, experiment, heading_rad, condition, gaps })
    }

    /// The samples of a test point, named after its stick and time.
    ///
    /// # Errors
    /// [`IdentifyError::Experiment`] where it lies outside the record.
    pub fn cut(&self, point: &TestPoint) -> Result<Experiment, IdentifyError> {
        let mut piece = self.experiment.slice(self.sample(point.start)..self.sample(point.end))?;
        let stick = point.stick.map_or("manoeuvre", |stick| STICKS[stick]);
        piece.name = format!("{stick} at {:.1} s", point.first_step.seconds());
        Ok(piece)
    }

    /// Index of the sample at `time`, at most one past the last sample.
    pub(super) fn sample(&self, time: Time) -> usize {
        let samples = (time - self.start) / self.experiment.period_s;
        (samples.round().max(0.0) as usize).min(self.experiment.samples())
    }
}

/// Compensates `means` over intervals of length T, one column per signal, for attenuation by averaging and holding.
/// This attenuation is (sin x / x)², x = ω T/2. Accurate to 2 % up to 0.8 of half the sample rate.
///
/// # Source
/// Equation (I34) of docs/equations.md.
fn unattenuated(means: &DMatrix<f64>) -> DMatrix<f64> {
    const ORDER: u32 = 12;
    let (mut held, mut bent, mut factor) = (means.clone(), means.clone(), 1.0);
    for power in (1..=ORDER).map(f64::from) {
        let next = power + 1.0;
        factor *= power * power / (2.0 * next * (2.0 * next - 1.0));
        let last = bent.nrows().saturating_sub(1);
        bent = DMatrix::from_fn(bent.nrows(), bent.ncols(), |sample, input| {
            if sample == 0 || sample == last {
                return 0.0;
            }
            2.0 * bent[(sample, input)] - bent[(sample - 1, input)] - bent[(sample + 1, input)]
        });
        held += &bent * factor;
    }
    held
}

/// Median of each stick: pulses in microseconds are far from zero, and deliberate movements start at the median.
fn medians(controls: &[(Time, [f64; 4])]) -> [f64; 4] {
    std::array::from_fn(|stick| {
        let mut values: Vec<f64> = controls.iter().map(|row| row.1[stick]).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    })
}

/// Mean of each stick over `period_s` from `from` on, with each value held until the next.
fn held_mean(controls: &[(Time, [f64; 4])], from: Time, period_s: f64) -> [f64; 4] {
    let until = from.offset_by(period_s);
    let mut at = controls.partition_point(|control| control.0 <= from).max(1) - 1;
    let (mut begin, mut sums) = (from, [0.0; 4]);
    loop {
        let end = controls.get(at + 1).map_or(until, |next| next.0.min(until)).max(begin);
        for (sum, value) in sums.iter_mut().zip(controls[at].1) {
            *sum += value * (end - begin) / period_s;
        }
        if end >= until || at + 1 >= controls.len() {
            return sums;
        }
        (begin, at) = (end, at + 1);
    }
}

/// u, v, w, p, q, r, φ, θ of a solution.
fn motion(solution: &Solution, fixes: &[Fix], velocity: Velocity) -> [f64; 8] {
    let held = fixes.partition_point(|fix| fix.time <= solution.time).max(1) - 1;
    let measured = match velocity {
        Velocity::Estimated => None,
        Velocity::HeldGps => fixes.get(held).and_then(Fix::velocity_mps),
    };
    let [u, v, w] = measured
        .map_or_else(
            || solution.velocity_body_mps(),
            |velocity| solution.body_to_ned.inverse() * velocity,
        )
        .to_array();
    let [p, q, r] = solution.angular_rate_radps.to_array();
    let angles = solution.body_to_ned.euler();
    [u, v, w, p, q, r, angles.roll_rad, angles.pitch_rad]
}

/// Terms of the rigid-body equations in addition to u̇ = −gθ, v̇ = gφ, ẇ = 0, φ̇ = p, θ̇ = q, without forces.
///
/// # Source
/// Equation (I25) of docs/equations.md.
fn kinematic([u, v, w, p, q, r, phi, theta]: [f64; 8]) -> [f64; 5] {
    let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = (phi.sin_cos(), theta.sin_cos());
    [
        r * v - q * w - GRAVITY_MPS2 * (sin_theta - theta),
        p * w - r * u + GRAVITY_MPS2 * (cos_theta * sin_phi - phi),
        q * u - p * v + GRAVITY_MPS2 * (cos_theta * cos_phi - 1.0),
        (q * sin_phi + r * cos_phi) * sin_theta / cos_theta,
        q * (cos_phi - 1.0) - r * sin_phi,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_held_mean_is_as_large_as_the_movement_near_half_the_sample_rate() {
        for (part, accuracy) in [(0.1, 1e-9), (0.5, 1e-4), (0.8, 0.02)] {
            let half_angle = part * std::f64::consts::FRAC_PI_2;
            let mean = |sample: usize, _| {
                let attenuated = (half_angle.sin() / half_angle).powi(2);
                attenuated * (2.0 * half_angle * sample as f64).sin()
            };
            let held = unattenuated(&DMatrix::from_fn(200, 1, mean));
            for sample in 20..180 {
                let expected = (2.0 * half_angle * sample as f64).sin();
                assert_abs_diff_eq!(held[(sample, 0)], expected, epsilon = accuracy);
            }
        }
        assert_eq!(
            unattenuated(&DMatrix::from_element(5, 2, 0.3)),
            DMatrix::from_element(5, 2, 0.3)
        );
        assert!(unattenuated(&DMatrix::zeros(0, 4)).is_empty());
    }

    #[test]
    fn a_step_between_two_samples_keeps_its_time() {
        let at = |time_s: f64| Time::from_seconds(time_s);
        let controls = [(at(0.0), [0.0; 4]), (at(1.01), [0.1, 0.2, 0.0, -0.1])];
        let held = |from_s: f64| held_mean(&controls, at(from_s), 0.03);
        assert_eq!(held(0.5), [0.0; 4]);
        assert_abs_diff_eq!(held(1.0)[1], 0.2 * 2.0 / 3.0, epsilon = 1e-9);
        assert_abs_diff_eq!(held(1.02)[3], -0.1, epsilon = 1e-12);
        assert_abs_diff_eq!(held(7.0)[0], 0.1, epsilon = 1e-12);
        // Before the first record the sticks are at its values.
        assert_eq!(held(-1.0), [0.0; 4]);
    }
}
