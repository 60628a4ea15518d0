//! Zero-phase filtering, forwards and backwards.

use super::{LowPass, PreprocessError, Section};

impl LowPass {
    /// The signal filtered forwards, then backwards: no phase shift, the gain squared.
    ///
    /// Each end is extended by its own mirror image about the end point, 3·(order + 1) samples long. The filter starts
    /// in the steady state of the first value: a constant passes unchanged, and a ramp nearly so at its ends.
    ///
    /// # Errors
    /// [`PreprocessError::TooShort`] where the signal is not longer than its extension.
    ///
    /// # Source
    /// F. Gustafsson (1996), "Determining the initial states in forward-backward filtering", *IEEE Trans. Signal
    /// Processing* 44(4), for the problem. The ends are those of SciPy's `filtfilt`, which this function equals to
    /// rounding. Equation (I2) of docs/equations.md.
    pub fn zero_phase(&self, signal: &[f64]) -> Result<Vec<f64>, PreprocessError> {
        let margin = 3 * (self.order() + 1);
        let samples = signal.len();
        if samples <= margin {
            return Err(PreprocessError::TooShort {
                what: "a zero-phase filter",
                samples,
                needed: margin,
            });
        }
        let (first, last) = (signal[0], signal[samples - 1]);
        let mut prolonged = Vec::with_capacity(samples + 2 * margin);
        prolonged.extend(signal[1..=margin].iter().rev().map(|value| 2.0 * first - value));
        prolonged.extend_from_slice(signal);
        let tail = &signal[samples - margin - 1..samples - 1];
        prolonged.extend(tail.iter().rev().map(|value| 2.0 * last - value));
        for _ in 0..2 {
            for section in &self.sections {
                section.run(&mut prolonged);
            }
            prolonged.reverse();
        }
        Ok(prolonged[margin..margin + samples].to_vec())
    }
}

impl Section {
    /// Filters in place, in the transposed direct form, from the steady state of the first value.
    fn run(&self, signal: &mut [f64]) {
        let ([b0, b1, b2], [a1, a2]) = (self.b, self.a);
        let gain = (b0 + b1 + b2) / (1.0 + a1 + a2);
        let first = signal[0];
        let mut second = (b2 - a2 * gain) * first;
        let mut newer = (b1 - a1 * gain) * first + second;
        for value in signal {
            let input = *value;
            let output = b0 * input + newer;
            newer = b1 * input - a1 * output + second;
            second = b2 * input - a2 * output;
            *value = output;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_passes_unchanged_and_a_ramp_all_but_its_ends() {
        let filter = LowPass::butterworth(4, 3.0, 0.03).unwrap();
        let ramp: Vec<f64> = (0..100).map(|k| 5.0 - 0.1 * f64::from(k)).collect();
        let passed = filter.zero_phase(&ramp).unwrap();
        for (k, (before, after)) in ramp.iter().zip(&passed).enumerate() {
            let most = if (40..60).contains(&k) { 1e-5 } else { 1e-2 };
            assert!((before - after).abs() < most, "{before} {after}");
        }
        let constant = filter.zero_phase(&[2.5; 40]).unwrap();
        assert!(constant.iter().all(|value| (value - 2.5).abs() < 1e-12));
    }

    #[test]
    fn a_signal_shorter_than_its_mirror_is_refused() {
        let filter = LowPass::butterworth(4, 3.0, 0.03).unwrap();
        assert!(filter.zero_phase(&[0.0; 15]).is_err() && filter.zero_phase(&[0.0; 16]).is_ok());
    }

    #[test]
    fn impossible_filters_are_refused() {
        assert!(LowPass::butterworth(0, 3.0, 0.03).is_err());
        assert!(LowPass::butterworth(17, 3.0, 0.03).is_err());
        for cutoff_hz in [0.0, -1.0, 16.7, f64::NAN, f64::INFINITY] {
            assert!(LowPass::butterworth(2, cutoff_hz, 0.03).is_err(), "{cutoff_hz}");
        }
    }
}
