//! Amplification or reduction of a log's own vibration.

use std::ops::Range;

use crate::noise::Noise;

/// Length of each of two moving means in sequence, s. Motion faster than about the inverse of twice this length counts
/// as vibration.
const SMOOTHED_S: f64 = 0.2;
/// Range of the time by which the source of the added vibration is earlier in the log, s.
const EARLIER_S: (f64, f64) = (2.0, 10.0);

/// Change of the vibration, and the source of the added part.
///
/// Vibration is the signal of an axis minus its moving mean of 0.2 s, with the mean applied twice. The two means are a
/// triangle of 0.4 s, whose response is 0.5 at 2.2 Hz. For a factor below one, a part of the vibration is removed. For
/// a factor k above one, the vibration from 2 to 10 s earlier is added. It is scaled such that the root mean square
/// becomes k times the original. Strength, spectrum and phases between the axes remain those of the log, because all
/// axes use the same time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vibration {
    factor: f64,
    earlier: usize,
    half: usize,
    sign: f64,
}

impl Vibration {
    /// A random change that multiplies the vibration by `factor`, for samples `period_s` apart.
    pub fn drawn(factor: f64, period_s: f64, noise: &mut Noise) -> Self {
        let (min_s, max_s) = EARLIER_S;
        let earlier_s = min_s + (max_s - min_s) * noise.uniform();
        let sign = if noise.uniform() < 0.5 { -1.0 } else { 1.0 };
        let earlier = ((earlier_s / period_s) as usize).max(1);
        let half = ((0.5 * SMOOTHED_S / period_s).round() as usize).max(1);
        Self { factor, earlier, half, sign }
    }

    /// Values to add to `values` of one axis, for the rows `within`.
    pub fn added(&self, values: &[f64], within: Range<usize>) -> Vec<f64> {
        let smooth = moving_mean(&moving_mean(values, self.half), self.half);
        let fast = |place: usize| values[place] - smooth[place];
        if self.factor < 1.0 {
            return within.map(|place| (self.factor - 1.0) * fast(place)).collect();
        }
        let other = |place: usize| {
            // In the first seconds of the log, the source of the added vibration is later instead of earlier.
            let place = place.checked_sub(self.earlier).unwrap_or(place + self.earlier);
            self.sign * fast(place.min(values.len() - 1))
        };
        // |f + s g|² = k² |f|², solved for s.
        let [mut ff, mut fg, mut gg] = [0.0; 3];
        for place in within.clone() {
            let (f, g) = (fast(place), other(place));
            (ff, fg, gg) = (ff + f * f, fg + f * g, gg + g * g);
        }
        let missing = ff * (self.factor * self.factor - 1.0);
        let size = if missing > 0.0 && gg > 0.0 {
            ((fg * fg + gg * missing).sqrt() - fg) / gg
        } else {
            0.0
        };
        within.map(|place| size * other(place)).collect()
    }
}

/// The mean of each value and up to `half` of its neighbours on either side.
fn moving_mean(values: &[f64], half: usize) -> Vec<f64> {
    let mut sums = vec![0.0];
    for value in values {
        sums.push(sums[sums.len() - 1] + value);
    }
    let mean = |place: usize| {
        let reach = half.min(place).min(values.len() - 1 - place);
        (sums[place + reach + 1] - sums[place - reach]) / (2 * reach + 1) as f64
    };
    (0..values.len()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Stream;

    #[test]
    fn the_root_mean_square_becomes_as_many_times_as_large() {
        let values: Vec<f64> = (0..3000)
            .map(|k| (1.9 * f64::from(k)).sin() + 5.0 * (0.002 * f64::from(k)).sin())
            .collect();
        let fast = |values: &[f64]| {
            let smooth = moving_mean(&moving_mean(values, 3), 3);
            let squares = values.iter().zip(smooth).map(|(value, smooth)| (value - smooth).powi(2));
            squares.sum::<f64>().sqrt()
        };
        for factor in [0.0, 0.5, 1.0, 2.0, 8.0] {
            for seed in 0..5 {
                let mut noise = Noise::new(seed, Stream::Fault);
                let vibration = Vibration::drawn(factor, 1.0 / 33.0, &mut noise);
                let added = vibration.added(&values, 0..values.len());
                let shaken: Vec<f64> = values.iter().zip(added).map(|(a, b)| a + b).collect();
                let ratio = fast(&shaken) / fast(&values);
                assert!(
                    (ratio - factor).abs() < 0.1 * (1.0 + 0.3 * factor),
                    "{ratio} for {factor}"
                );
            }
        }
    }
}
