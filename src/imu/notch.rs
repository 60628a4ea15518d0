//! Notch filter at the speed of a rotor: removes its vibration from the samples, and reports the resulting delay.
//!
//! Each harmonic has a second-order section with gain 0 at the harmonic's frequency and gain 1 at zero frequency:
//!
//! ```text
//! H(z) = (1 − 2 c z⁻¹ + z⁻²) / ((1 + α) − 2 c z⁻¹ + (1 − α) z⁻²),   c = cos(2π f T), α = tan(π w T)
//! ```
//!
//! with the frequency f, the half-power width w, and the sampling interval T. Motion that is slow against f leaves the
//! section α / (1 − c) samples later, about w / (2π f²) seconds: 1.3 ms for 5 Hz at 25 Hz. The output samples are dated
//! back by this delay, so that the filter compares fixes with the motion at the right time. Below f/10, the time of a
//! sample is accurate to a hundredth of the delay.
//!
//! A frequency above half the sample rate appears below it as an alias; the section is set to the alias. An alias below
//! [`NotchConfig::least_hz`] cannot be separated from motion and is left in.

use super::{ImuSample, Motion};
use crate::frames::{Body, Vector};
use crate::time::Time;

/// Largest number of harmonics that a notch removes.
pub const MAX_HARMONICS: usize = 4;

/// Settings of a notch.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct NotchConfig {
    /// Frequency of the rotor, Hz; with 0, the measured one, by [`Notch::set_frequency_hz`].
    pub frequency_hz: f64,
    /// Width of the notch at half power, Hz, the same at each harmonic.
    pub width_hz: f64,
    /// Number of multiples of the frequency to remove, 1 to 4.
    pub harmonics: u32,
    /// Lowest apparent frequency to remove, Hz: lower frequencies belong to the vehicle's own motion.
    pub least_hz: f64,
}

impl Default for NotchConfig {
    fn default() -> Self {
        Self { frequency_hz: 0.0, width_hz: 4.0, harmonics: 1, least_hz: 6.0 }
    }
}

impl NotchConfig {
    /// A notch at `frequency_hz`, 4 Hz wide.
    #[must_use]
    pub fn at_hz(frequency_hz: f64) -> Self {
        Self { frequency_hz, ..Self::default() }
    }

    /// Sets the width at half power, Hz.
    #[must_use]
    pub const fn with_width_hz(mut self, width_hz: f64) -> Self {
        self.width_hz = width_hz;
        self
    }

    /// Sets the number of multiples of the frequency to remove, 1 to 4.
    #[must_use]
    pub const fn with_harmonics(mut self, harmonics: u32) -> Self {
        self.harmonics = harmonics;
        self
    }

    /// The first setting out of range: its name, its value and the expected range. Frequencies must be from 0 to less
    /// than 10 000 Hz. The width must be more than 0 and less than 10 000 Hz. The number of harmonics must be 1 to
    /// [`MAX_HARMONICS`].
    #[must_use]
    pub fn out_of_range(&self) -> Option<(&'static str, f64, &'static str)> {
        const FREQUENCY: &str = "0 to less than 10000 Hz";
        const WIDTH: &str = "more than 0, less than 10000 Hz";
        let frequency = |value: f64| (0.0..1e4).contains(&value);
        let harmonics = f64::from(self.harmonics);
        let checks = [
            ("frequency_hz", self.frequency_hz, FREQUENCY, frequency(self.frequency_hz)),
            ("width_hz", self.width_hz, WIDTH, frequency(self.width_hz) && self.width_hz > 0.0),
            ("harmonics", harmonics, "1 to 4", (1.0..=MAX_HARMONICS as f64).contains(&harmonics)),
            ("least_hz", self.least_hz, FREQUENCY, frequency(self.least_hz)),
        ];
        checks
            .into_iter()
            .find(|check| !check.3)
            .map(|(key, value, expected, _)| (key, value, expected))
    }
}

/// Apparent frequency of a tone of `frequency_hz` in samples taken at `rate_hz`: 0 to half the sample rate.
///
/// ```
/// use hovernav::imu::apparent_hz;
/// assert_eq!(apparent_hz(120.0, 100.0), 20.0);
/// assert_eq!(apparent_hz(80.0, 100.0), 20.0);
/// assert_eq!(apparent_hz(20.0, 100.0), 20.0);
/// ```
#[must_use]
pub fn apparent_hz(frequency_hz: f64, rate_hz: f64) -> f64 {
    libm::fabs(frequency_hz - rate_hz * libm::round(frequency_hz / rate_hz))
}

/// Number of axes: three rates and three forces, or their increments.
const AXES: usize = 6;
/// Longest gap, s, that does not reset the sections.
const GAP_S: f64 = 0.25;
/// Weight of a new interval in the mean interval.
const NEWEST: f64 = 0.01;
/// Relative change of rate or frequency after which the coefficients are recomputed.
const CHANGED: f64 = 0.002;

#[derive(Clone, Copy, Debug, Default)]
struct Section {
    cos: f64,
    alpha: f64,
    inputs: [[f64; AXES]; 2],
    outputs: [[f64; AXES]; 2],
}

impl Section {
    /// Direct form I: a constant signal stays constant while the coefficients change.
    fn filter(&mut self, input: [f64; AXES]) -> [f64; AXES] {
        let (twice, scale) = (2.0 * self.cos, 1.0 / (1.0 + self.alpha));
        let mut output = input;
        let [inputs, outputs] = [&self.inputs, &self.outputs];
        let before = inputs[0].iter().zip(&inputs[1]).zip(outputs[0].iter().zip(&outputs[1]));
        for (value, ((x1, x2), (y1, y2))) in output.iter_mut().zip(before) {
            *value = (*value - twice * x1 + x2 + twice * y1 - (1.0 - self.alpha) * y2) * scale;
        }
        self.inputs = [input, self.inputs[0]];
        self.outputs = [output, self.outputs[0]];
        output
    }
}

/// Removes the vibration of a rotor from inertial samples.
///
/// Used before the [`Estimator`](crate::ekf::Estimator), which does not depend on it; without a notch there is no cost.
///
/// ```
/// use hovernav::frames::Vector;
/// use hovernav::imu::{ImuSample, Motion, Notch, NotchConfig};
/// use hovernav::time::Time;
///
/// let mut notch = Notch::new(NotchConfig::at_hz(25.0));
/// let mut left_mps2: f64 = 0.0;
/// for k in 0..400 {
///     let seconds = f64::from(k) * 0.01;
///     let shaken_mps2 = 3.0 * (std::f64::consts::TAU * 25.0 * seconds).sin();
///     let motion = Motion::Rates {
///         angular_rate_radps: Vector::ZERO,
///         specific_force_mps2: Vector::new(0.0, 0.0, -9.8 + shaken_mps2),
///     };
///     let sample = notch.filter(&ImuSample::new(Time::ZERO + seconds, motion));
///     let force = sample.motion.mean_rates(0.01).specific_force_mps2;
///     if k > 100 {
///         left_mps2 = left_mps2.max((force.z() + 9.8).abs());
///     }
/// }
/// assert!(left_mps2 < 0.01);
/// assert!((notch.delay_s() - 1.26e-3).abs() < 1e-5);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Notch {
    config: NotchConfig,
    sections: [Section; MAX_HARMONICS],
    /// Number of sections in use.
    used: usize,
    frequency_hz: f64,
    interval_s: f64,
    /// Rate and frequency of the present coefficients.
    set_for: [f64; 2],
    delay_s: f64,
    /// Time and motion of the last sample, and its output.
    last: Option<(Time, Motion, ImuSample)>,
}

impl Notch {
    /// A notch without samples yet.
    #[must_use]
    pub fn new(config: NotchConfig) -> Self {
        Self {
            config,
            sections: [Section::default(); MAX_HARMONICS],
            used: 0,
            frequency_hz: config.frequency_hz,
            interval_s: 0.0,
            set_for: [0.0; 2],
            delay_s: 0.0,
            last: None,
        }
    }

    /// Sets the frequency of the rotor, Hz; a value that is not positive and finite is ignored.
    pub fn set_frequency_hz(&mut self, frequency_hz: f64) {
        if frequency_hz > 0.0 && frequency_hz.is_finite() {
            self.frequency_hz = frequency_hz;
        }
    }

    /// Delay of the output after the input at low frequency, s. The output samples are already dated back by it.
    #[must_use]
    pub const fn delay_s(&self) -> f64 {
        self.delay_s
    }

    /// The sample without the rotor's vibration, dated back by the [`delay`](Self::delay_s). A sample that is not
    /// finite or not later than the previous one is returned unfiltered, so that the filter can reject it.
    ///
    /// # Source
    /// Equation (S15) of docs/equations.md.
    #[must_use]
    pub fn filter(&mut self, sample: &ImuSample) -> ImuSample {
        let elapsed_s = self.last.map(|(time, ..)| sample.time - time);
        if elapsed_s.is_some_and(|elapsed_s| elapsed_s <= 0.0) || !sample.motion.is_finite() {
            return ImuSample { time: sample.time.offset_by(-self.delay_s), ..*sample };
        }
        let values = components(&sample.motion);
        let same_form = self.last.is_some_and(|(_, motion, _)| {
            core::mem::discriminant(&motion) == core::mem::discriminant(&sample.motion)
        });
        match elapsed_s.filter(|&elapsed_s| elapsed_s <= GAP_S && same_form) {
            Some(elapsed_s) => {
                if self.interval_s == 0.0 {
                    self.interval_s = elapsed_s;
                }
                self.interval_s += NEWEST * (elapsed_s - self.interval_s);
                self.set();
            }
            None => self.settle(values),
        }
        let mut filtered = values;
        for section in self.sections.iter_mut().take(self.used) {
            filtered = section.filter(filtered);
        }
        // A stuck IMU is detected by its repetitions, so they must stay identical.
        let repeated = self.last.filter(|(_, motion, _)| *motion == sample.motion);
        let motion = match repeated {
            Some((.., out)) => out.motion,
            None => of_components(&sample.motion, filtered),
        };
        let mut time = sample.time.offset_by(-self.delay_s);
        if let (Some((.., out)), Some(elapsed_s)) = (self.last, elapsed_s) {
            // Time must increase also while the delay grows.
            time = time.max(out.time.offset_by(0.5 * elapsed_s));
        }
        let out = ImuSample { time, motion, ..*sample };
        self.last = Some((sample.time, sample.motion, out));
        out
    }

    /// Initialises the sections as if the motion had always been constant at `values`.
    fn settle(&mut self, values: [f64; AXES]) {
        for section in &mut self.sections {
            section.inputs = [values; 2];
            section.outputs = [values; 2];
        }
    }

    /// Recomputes the coefficients if rate or frequency has changed.
    fn set(&mut self) {
        let now = [1.0 / self.interval_s, self.frequency_hz];
        let same = now
            .iter()
            .zip(&self.set_for)
            .all(|(now, before)| libm::fabs(now - before) <= CHANGED * before);
        if same {
            return;
        }
        self.set_for = now;
        let [rate_hz, frequency_hz] = now;
        let width = (core::f64::consts::PI * self.config.width_hz / rate_hz).min(MAX_WIDTH);
        let alpha = libm::tan(width);
        let (mut used, mut delay_samples) = (0, 0.0);
        let last = self.sections.iter().take(self.used).next_back().map(|last| last.outputs);
        for harmonic in 1..=self.config.harmonics.min(MAX_HARMONICS as u32) {
            let apparent_hz = apparent_hz(f64::from(harmonic) * frequency_hz, rate_hz);
            if apparent_hz < self.config.least_hz || frequency_hz == 0.0 {
                continue;
            }
            let cos = libm::cos(core::f64::consts::TAU * apparent_hz / rate_hz);
            if let Some(section) = self.sections.get_mut(used) {
                (section.cos, section.alpha) = (cos, alpha);
                if used >= self.used
                    && let Some(outputs) = last
                {
                    // A newly used section has no history: it starts from the outputs of the last section in use.
                    (section.inputs, section.outputs) = (outputs, outputs);
                }
                used += 1;
                delay_samples += alpha / (1.0 - cos);
            }
        }
        self.used = used;
        self.delay_s = delay_samples * self.interval_s;
    }
}

/// Upper limit of half the width of a notch, rad per sample.
const MAX_WIDTH: f64 = 0.75;

fn components(motion: &Motion) -> [f64; AXES] {
    let (Motion::Rates { angular_rate_radps: a, specific_force_mps2: b }
    | Motion::Increments { angle_rad: a, velocity_mps: b }) = motion;
    let ([x, y, z], [u, v, w]) = (a.to_array(), b.to_array());
    [x, y, z, u, v, w]
}

/// A motion in the same form as `form`.
fn of_components(form: &Motion, [x, y, z, u, v, w]: [f64; AXES]) -> Motion {
    let (a, b) = (Vector::<Body>::new(x, y, z), Vector::<Body>::new(u, v, w));
    match form {
        Motion::Rates { .. } => Motion::Rates { angular_rate_radps: a, specific_force_mps2: b },
        Motion::Increments { .. } => Motion::Increments { angle_rad: a, velocity_mps: b },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    fn sample(seconds: f64, force_z: f64) -> ImuSample {
        let motion = Motion::Rates {
            angular_rate_radps: Vector::ZERO,
            specific_force_mps2: Vector::new(0.0, 0.0, force_z),
        };
        ImuSample::new(Time::ZERO + seconds, motion)
    }

    fn force_z(sample: &ImuSample) -> f64 {
        sample.motion.mean_rates(0.01).specific_force_mps2.z()
    }

    /// Largest difference, after a second, between the output and `clean` at the output's time.
    fn error(
        config: NotchConfig,
        rate_hz: f64,
        raw: impl Fn(f64) -> f64,
        clean: impl Fn(f64) -> f64,
    ) -> f64 {
        let mut notch = Notch::new(config);
        let mut worst: f64 = 0.0;
        for k in 0..(5.0 * rate_hz) as u32 {
            let seconds = f64::from(k) / rate_hz;
            let out = notch.filter(&sample(seconds, raw(seconds)));
            if seconds > 1.0 {
                worst = worst.max((force_z(&out) - clean(out.time.seconds())).abs());
            }
        }
        worst
    }

    #[test]
    fn a_tone_and_its_harmonics_go_and_what_is_slow_comes_at_the_time_it_is_dated() {
        let slow = |t: f64| -9.8 + (TAU * t).sin();
        let raw = |t: f64| slow(t) + 4.0 * (TAU * 23.0 * t).sin() + 2.0 * (TAU * 46.0 * t).cos();
        let config = NotchConfig { harmonics: 2, ..NotchConfig::at_hz(23.0) };
        assert!(error(config, 200.0, raw, slow) < 2e-3);
        // If the output were not dated back by the delay, the error would be 2π · 1.4 ms.
        assert!(error(config, 200.0, raw, |t| slow(t - 1.4e-3)) > 5e-3);
    }

    #[test]
    fn a_tone_beyond_half_the_rate_is_taken_out_where_it_appears() {
        let raw = |t: f64| 3.0 * (TAU * 120.0 * t).sin();
        assert!(error(NotchConfig::at_hz(120.0), 100.0, raw, |_| 0.0) < 1e-3);
    }

    #[test]
    fn what_appears_among_the_motion_is_left_in_and_costs_no_delay() {
        let raw = |t: f64| 3.0 * (TAU * 98.0 * t).sin();
        assert!(error(NotchConfig::at_hz(98.0), 100.0, raw, raw) < 1e-9);
    }

    #[test]
    fn a_followed_rotor_is_taken_out_while_it_runs_up() {
        let mut notch = Notch::new(NotchConfig { width_hz: 6.0, ..NotchConfig::default() });
        let (mut phase, mut worst): (f64, f64) = (0.0, 0.0);
        let mut before = Time::ZERO;
        for k in 0..4000 {
            let seconds = f64::from(k) * 0.005;
            let frequency_hz = 20.0 + 0.5 * seconds;
            phase += TAU * frequency_hz * 0.005;
            notch.set_frequency_hz(frequency_hz);
            let out = notch.filter(&sample(seconds, 5.0 * phase.sin() - 9.8));
            assert!(k == 0 || out.time > before);
            before = out.time;
            if seconds > 1.0 {
                worst = worst.max((force_z(&out) + 9.8).abs());
            }
        }
        assert!(worst < 0.15, "{worst}");
    }

    #[test]
    fn a_unit_that_repeats_itself_is_not_smoothed_out_of_sight() {
        let mut notch = Notch::new(NotchConfig::at_hz(20.0));
        for k in 0..100 {
            let _ = notch.filter(&sample(f64::from(k) * 0.01, f64::from(k % 7)));
        }
        let stuck = notch.filter(&sample(1.0, 3.5)).motion;
        assert!(
            (101..120).all(|k| notch.filter(&sample(f64::from(k) * 0.01, 3.5)).motion == stuck)
        );
        // Nor are NaN and late samples changed.
        assert!(force_z(&notch.filter(&sample(1.3, f64::NAN))).is_nan());
        assert_eq!(force_z(&notch.filter(&sample(0.5, 42.0))), 42.0);
    }

    #[test]
    fn a_gap_leaves_no_transient() {
        let mut notch = Notch::new(NotchConfig::at_hz(20.0));
        for k in 0..100 {
            let _ = notch.filter(&sample(f64::from(k) * 0.01, -9.8));
        }
        assert_eq!(force_z(&notch.filter(&sample(3.0, 2.0))), 2.0);
    }

    #[test]
    fn settings_out_of_range_are_named() {
        let config = NotchConfig::at_hz(20.0);
        assert_eq!(config.out_of_range(), None);
        let wrong = NotchConfig { harmonics: 9, ..config };
        assert_eq!(wrong.out_of_range(), Some(("harmonics", 9.0, "1 to 4")));
        let wrong = NotchConfig { width_hz: 0.0, ..config };
        assert_eq!(
            wrong.out_of_range(),
            Some(("width_hz", 0.0, "more than 0, less than 10000 Hz"))
        );
    }
}
