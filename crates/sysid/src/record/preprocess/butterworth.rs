//! Butterworth low-pass filters in sections of second order.

use std::f64::consts::PI;

use super::PreprocessError;

/// One section, (b₀ + b₁ z⁻¹ + b₂ z⁻²) / (1 + a₁ z⁻¹ + a₂ z⁻²).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Numerator, b₀ to b₂.
    pub b: [f64; 3],
    /// Denominator after the leading 1, a₁ and a₂.
    pub a: [f64; 2],
}

/// A low-pass filter of unit gain at zero frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct LowPass {
    /// Sections of the filter, applied one after the other. An odd order has one section of first order.
    pub sections: Vec<Section>,
    order: usize,
}

/// Largest useful order: above it rounding errors of the sections dominate.
const LARGEST_ORDER: usize = 16;

impl LowPass {
    /// A Butterworth filter, half power at `cutoff_hz`, by the bilinear transform with the cut-off
    /// mapped exactly.
    ///
    /// # Errors
    /// [`PreprocessError::FilterOrder`] outside 1 to 16; [`PreprocessError::Cutoff`] where the
    /// cut-off is not between zero and half the sample rate.
    ///
    /// # Source
    /// A. Oppenheim & R. Schafer, *Discrete-Time Signal Processing*, 3rd ed., section 7.2 and
    /// appendix B.1.
    /// Equation (I1) of docs/equations.md.
    pub fn butterworth(
        order: usize,
        cutoff_hz: f64,
        period_s: f64,
    ) -> Result<Self, PreprocessError> {
        if !(1..=LARGEST_ORDER).contains(&order) {
            return Err(PreprocessError::FilterOrder { order, largest: LARGEST_ORDER });
        }
        let part = cutoff_hz * period_s;
        if !(part > 0.0 && part < 0.5) {
            return Err(PreprocessError::Cutoff { cutoff_hz, rate_hz: period_s.recip() });
        }
        let warped = (PI * part).tan();
        let mut sections = Vec::with_capacity(order.div_ceil(2));
        if order % 2 == 1 {
            let norm = 1.0 / (1.0 + warped);
            sections.push(Section {
                b: [warped * norm, warped * norm, 0.0],
                a: [(warped - 1.0) * norm, 0.0],
            });
        }
        for pair in 0..order / 2 {
            let angle = PI * (2 * pair + 1) as f64 / (2 * order) as f64;
            // Poles at −sin(angle) ± j cos(angle) on the unit circle of the analogue filter.
            let damping = 2.0 * angle.sin() * warped;
            let norm = 1.0 / (1.0 + damping + warped * warped);
            let b = warped * warped * norm;
            sections.push(Section {
                b: [b, 2.0 * b, b],
                a: [2.0 * (warped * warped - 1.0) * norm, (1.0 - damping + warped * warped) * norm],
            });
        }
        Ok(Self { sections, order })
    }

    /// The filter's order.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }
}
