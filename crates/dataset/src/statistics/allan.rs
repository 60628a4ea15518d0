//! Allan deviation of an inertial sensor at rest.

/// Number of averaging times per decade.
const PER_DECADE: f64 = 10.0;

/// Allan deviation at one averaging time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AllanPoint {
    /// Averaging time τ, s.
    pub tau_s: f64,
    /// Allan deviation σ(τ), in the unit of the readings.
    pub deviation: f64,
}

/// Overlapping Allan deviation of evenly sampled `readings`, `interval_s` apart, at about ten averaging times a decade,
/// up to half the recording. Empty with fewer than two readings, or an interval that is not above zero.
///
/// White noise of density N (an angle random walk) is N/√τ, a random walk of density K is K·√(τ/3), and a drift of
/// slope R is R·τ/√2.
///
/// ```
/// use hovernav_dataset::allan_deviation;
/// // A drift of 0.01 a second.
/// let drift: Vec<f64> = (0..1000).map(|k| 0.01 * 0.1 * f64::from(k)).collect();
/// let points = allan_deviation(&drift, 0.1);
/// assert!((points[0].deviation - 0.01 * 0.1 / 2f64.sqrt()).abs() < 1e-12);
/// ```
///
/// # Source
/// IEEE Std 952-1997, annex C; the overlapping form by W. J. Riley, *Handbook of Frequency Stability Analysis*, NIST
/// SP 1065 (2008), equation 11.
#[must_use]
pub fn allan_deviation(readings: &[f64], interval_s: f64) -> Vec<AllanPoint> {
    // Written so that a NaN is rejected.
    let has_interval = interval_s > 0.0;
    if !has_interval || readings.is_empty() {
        return Vec::new();
    }
    // Sums of deviations from the mean, which cancels in the differences, lose no digits in a long recording.
    let mean = readings.iter().sum::<f64>() / readings.len() as f64;
    let mut sums = vec![0.0; readings.len() + 1];
    for (index, reading) in readings.iter().enumerate() {
        sums[index + 1] = sums[index] + (reading - mean);
    }
    let mut points = Vec::new();
    let mut wanted = 1.0_f64;
    loop {
        let count = wanted.round() as usize;
        if 2 * count > readings.len() {
            return points;
        }
        let terms = readings.len() + 1 - 2 * count;
        let squares: f64 = (0..terms)
            .map(|k| sums[k + 2 * count] - 2.0 * sums[k + count] + sums[k])
            .map(|difference| difference * difference)
            .sum();
        let variance = squares / (2.0 * (count * count) as f64 * terms as f64);
        points.push(AllanPoint { tau_s: count as f64 * interval_s, deviation: variance.sqrt() });
        while wanted.round() as usize == count {
            wanted *= 10f64.powf(1.0 / PER_DECADE);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng as _;
    use rand_distr::{Distribution as _, StandardNormal};

    const INTERVAL_S: f64 = 0.01;
    const COUNT: usize = 200_000;

    fn white() -> impl Iterator<Item = f64> {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        std::iter::repeat_with(move || StandardNormal.sample(&mut random)).take(COUNT)
    }

    /// Asserts that the deviation is as `expected` at averaging times up to a hundredth of the recording. There the
    /// one-sigma of the Allan deviation itself is below 7 % (about √(τ/T)/√2).
    fn assert_near(readings: &[f64], expected: impl Fn(f64) -> f64, min_s: f64) {
        let points = allan_deviation(readings, INTERVAL_S);
        assert!(points.len() > 40);
        let max_s = 0.01 * INTERVAL_S * COUNT as f64;
        for point in points.iter().filter(|point| (min_s..max_s).contains(&point.tau_s)) {
            let ratio = point.deviation / expected(point.tau_s);
            assert!((ratio - 1.0).abs() < 0.2, "{point:?}: {ratio}");
        }
    }

    #[test]
    fn white_noise_falls_with_the_root_of_the_averaging_time() {
        let density = 0.02;
        let readings: Vec<f64> = white().map(|noise| density / INTERVAL_S.sqrt() * noise).collect();
        assert_near(&readings, |tau_s| density / tau_s.sqrt(), INTERVAL_S);
    }

    #[test]
    fn a_random_walk_rises_with_the_root_of_the_averaging_time() {
        let density = 0.003;
        let mut walked = 0.0;
        let steps = white().map(|noise| {
            walked += density * INTERVAL_S.sqrt() * noise;
            walked
        });
        // Readings are a sum of discrete steps: at an averaging time of one sample K·√(τ/3) does not hold yet.
        assert_near(
            &steps.collect::<Vec<_>>(),
            |tau_s| density * (tau_s / 3.0).sqrt(),
            10.0 * INTERVAL_S,
        );
    }

    #[test]
    fn a_drift_is_exact_and_a_bias_has_no_effect() {
        let drift: Vec<f64> = (0..5000).map(|k| 3.0 + 0.02 * INTERVAL_S * f64::from(k)).collect();
        for AllanPoint { tau_s, deviation } in allan_deviation(&drift, INTERVAL_S) {
            assert!((deviation / (0.02 * tau_s / 2f64.sqrt()) - 1.0).abs() < 1e-6);
        }
        assert!(allan_deviation(&[1.5; 100], 0.1).iter().all(|point| point.deviation == 0.0));
    }

    #[test]
    fn too_little_to_compare_gives_nothing() {
        assert!(allan_deviation(&[], 0.1).is_empty());
        assert!(allan_deviation(&[1.0], 0.1).is_empty());
        assert!(allan_deviation(&[1.0, 2.0], 0.0).is_empty());
        assert_eq!(allan_deviation(&[1.0, 2.0], 0.1).len(), 1);
        let last = allan_deviation(&[0.5; 1000], 0.1).last().copied();
        assert!(last.is_some_and(|point| point.tau_s <= 50.0));
    }
}
