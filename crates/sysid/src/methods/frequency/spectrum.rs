//! Auto- and cross-spectra from overlapping windows.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix};

use super::{ChirpZ, FrequencyError};

/// Shape of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Window {
    /// Raised cosine: little leakage; needs an overlap of at least one half.
    Hann,
    /// Rectangle: for records that are zero at both ends.
    Rectangle,
}

/// Evenly spaced frequencies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// First frequency, Hz, above zero.
    pub first_hz: f64,
    /// Last frequency, Hz, at most half the sample rate.
    pub last_hz: f64,
    /// Number of frequencies, at least 2.
    pub points: usize,
}

impl Band {
    /// The frequencies, Hz.
    #[must_use]
    pub fn frequencies_hz(&self) -> Vec<f64> {
        (0..self.points).map(|point| self.first_hz + point as f64 * self.step_hz()).collect()
    }

    fn step_hz(&self) -> f64 {
        (self.last_hz - self.first_hz) / (self.points.max(2) - 1) as f64
    }

    pub(super) fn check(&self, period_s: f64) -> Result<(), FrequencyError> {
        let Self { first_hz, last_hz, points } = *self;
        let rate_hz = period_s.recip();
        let inside =
            first_hz > 0.0 && last_hz > first_hz && last_hz <= 0.5 * rate_hz * (1.0 + 1e-9);
        if inside && points >= 2 {
            Ok(())
        } else {
            Err(FrequencyError::Band { first_hz, last_hz, points, rate_hz })
        }
    }
}

/// Settings of the spectral estimation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectrumSettings {
    /// Length of a window, s.
    pub window_s: f64,
    /// Fraction of a window that the next window shares, 0 to 0.95.
    pub overlap: f64,
    /// Window shape.
    pub window: Window,
    /// Frequencies of the result.
    pub band: Band,
}

/// One-sided spectral densities of several signals.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectra {
    /// The frequencies, Hz.
    pub frequencies_hz: Vec<f64>,
    /// At each frequency the Hermitian matrix of E[Xᵢ* Xⱼ], signals × signals, in units squared per
    /// Hz.
    pub densities: Vec<DMatrix<Complex<f64>>>,
    /// Number of independent averages: length of the records over that of a window.
    pub averages: f64,
    /// The constant of the random error: √0.55 with windows that overlap by half or more, else 1
    /// (Tischler & Remple, section 7.3).
    pub error_constant: f64,
}

impl Spectra {
    /// The normalised random error of a response of coherence γ² (Tischler & Remple eq. 7.8; Bendat & Piersol eq.
    /// 9.90): its standard deviation as a fraction of the response's magnitude.
    #[must_use]
    pub fn random_error(&self, coherence: f64) -> f64 {
        random_error(coherence, self.averages, self.error_constant)
    }
}

/// Normalised random error of a response from its coherence and the number of averages.
///
/// # Source
/// Equation (I20) of docs/equations.md.
pub(super) fn random_error(coherence: f64, averages: f64, constant: f64) -> f64 {
    let coherence = coherence.clamp(1e-12, 1.0);
    constant * ((1.0 - coherence) / (2.0 * coherence * averages)).sqrt()
}

/// Spectra of all signals together, averaged over the windows of all `records` (each samples × signals, the same
/// signals in each). The mean of every window is removed first.
///
/// # Errors
/// [`FrequencyError::Band`] or [`FrequencyError::Window`] for an invalid band or window.
///
/// # Source
/// Equation (I18) of docs/equations.md.
pub fn spectra(
    records: &[&DMatrix<f64>],
    period_s: f64,
    settings: &SpectrumSettings,
) -> Result<Spectra, FrequencyError> {
    settings.band.check(period_s)?;
    let longest = records.iter().map(|record| record.nrows()).max().unwrap_or(0);
    let window = (settings.window_s / period_s).round().max(0.0) as usize;
    if window < 8 || window > longest {
        return Err(FrequencyError::Window { window, longest });
    }
    let weights: Vec<f64> = (0..window)
        .map(|sample| match settings.window {
            Window::Hann => 0.5 - 0.5 * (TAU * sample as f64 / window as f64).cos(),
            Window::Rectangle => 1.0,
        })
        .collect();
    let power: f64 = weights.iter().map(|weight| weight * weight).sum();
    let hop = ((1.0 - settings.overlap.clamp(0.0, 0.95)) * window as f64).round().max(1.0) as usize;
    let (first, step) = (settings.band.first_hz * period_s, settings.band.step_hz() * period_s);
    let transform = ChirpZ::new(window, first, step, settings.band.points);

    let signals = records.first().map_or(0, |record| record.ncols());
    let mut densities = vec![DMatrix::zeros(signals, signals); settings.band.points];
    let (mut windows, mut averages) = (0, 0.0);
    let mut tapered = vec![0.0; window];
    for record in records.iter().filter(|record| record.nrows() >= window) {
        averages += record.nrows() as f64 / window as f64;
        for start in (0..=record.nrows() - window).step_by(hop) {
            windows += 1;
            let transformed: Vec<_> = record
                .column_iter()
                .map(|signal| {
                    let part = signal.rows(start, window);
                    let mean = part.mean();
                    for ((slot, value), weight) in tapered.iter_mut().zip(part.iter()).zip(&weights)
                    {
                        *slot = weight * (value - mean);
                    }
                    transform.transform(&tapered)
                })
                .collect();
            for (point, density) in densities.iter_mut().enumerate() {
                for row in 0..signals {
                    for column in 0..signals {
                        density[(row, column)] +=
                            transformed[row][point].conj() * transformed[column][point];
                    }
                }
            }
        }
    }
    let scale = Complex::from(2.0 * period_s / (power * f64::from(windows)));
    for density in &mut densities {
        *density *= scale;
    }
    Ok(Spectra {
        frequencies_hz: settings.band.frequencies_hz(),
        densities,
        averages,
        error_constant: if settings.overlap >= 0.5 { 0.55_f64.sqrt() } else { 1.0 },
    })
}
