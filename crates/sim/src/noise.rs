//! Random numbers from a seed, and random processes.

use hovernav::glam::DVec3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardNormal};

/// Random stream of each error. No two errors share a stream, so a change of one leaves the others unchanged.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stream {
    Gyro = 1,
    Accelerometer,
    Vibration,
    Attitude,
    Magnetometer,
    GpsPosition,
    GpsVelocity,
    Gust,
    Baro,
    Campaign,
    Fault,
    Range,
    Antennas,
}

/// Independent standard normal deviates.
#[derive(Clone, Debug)]
pub(super) struct Noise(ChaCha8Rng);

impl Noise {
    pub(super) fn new(seed: u64, stream: Stream) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream as u64);
        Self(generator)
    }

    pub(super) fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// Uniform from 0 to below 1.
    pub(super) fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(super) fn normal3(&mut self) -> DVec3 {
        DVec3::new(self.normal(), self.normal(), self.normal())
    }

    /// A direction with uniform distribution on the sphere.
    pub fn direction(&mut self) -> [f64; 3] {
        loop {
            if let Some(unit) = self.normal3().try_normalize() {
                return unit.to_array();
            }
        }
    }
}

/// Three independent first-order Gauss-Markov processes, stationary from the first sample on: x ← exp(−T/τ) x + σ √(1 −
/// exp(−2T/τ)) w, with w standard normal.
#[derive(Clone, Debug)]
pub(super) struct GaussMarkov {
    value: DVec3,
    decay: f64,
    drive: DVec3,
}

impl GaussMarkov {
    /// Equation (W1) of docs/equations.md.
    pub(super) fn new(sigma: DVec3, time_s: f64, period_s: f64, noise: &mut Noise) -> Self {
        let decay = (-period_s / time_s).exp();
        let drive = sigma * (1.0 - decay * decay).sqrt();
        Self { value: sigma * noise.normal3(), decay, drive }
    }

    pub(super) fn next(&mut self, noise: &mut Noise) -> DVec3 {
        let value = self.value;
        self.value = value * self.decay + self.drive * noise.normal3();
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_seed_gives_the_same_numbers_and_another_stream_gives_others() {
        let draw = |seed, stream| Noise::new(seed, stream).normal3();
        assert_eq!(draw(7, Stream::Gyro), draw(7, Stream::Gyro));
        assert_ne!(draw(7, Stream::Gyro), draw(8, Stream::Gyro));
        assert_ne!(draw(7, Stream::Gyro), draw(7, Stream::Accelerometer));
    }

    #[test]
    fn gauss_markov_has_its_variance_and_correlation_time() {
        let mut noise = Noise::new(1, Stream::Gyro);
        let (sigma, time_s, period_s) = (DVec3::new(1.0, 2.0, 0.5), 0.2, 0.01);
        let mut process = GaussMarkov::new(sigma, time_s, period_s, &mut noise);
        let values: Vec<DVec3> = (0..200_000).map(|_| process.next(&mut noise) / sigma).collect();
        // 200 000 samples are 5 000 correlation times: 2 % in variance, one sigma.
        let correlation = |lag: usize| {
            let products = values.iter().zip(&values[lag..]).map(|(a, b)| *a * *b);
            products.sum::<DVec3>() / (values.len() - lag) as f64
        };
        assert!((correlation(0) - 1.0).abs().max_element() < 0.06);
        assert!((correlation(20) - (-1f64).exp()).abs().max_element() < 0.06);
        assert!((correlation(40) - (-2f64).exp()).abs().max_element() < 0.06);
    }

    #[test]
    fn gauss_markov_starts_in_its_stationary_state() {
        let squares = (0..4000).map(|seed| {
            let mut noise = Noise::new(seed, Stream::Gyro);
            let first = GaussMarkov::new(DVec3::ONE, 1e3, 0.01, &mut noise).next(&mut noise);
            first * first
        });
        let variance = squares.sum::<DVec3>() / 4000.0;
        assert!((variance - 1.0).abs().max_element() < 0.1);
    }
}
