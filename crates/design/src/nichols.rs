//! A loop on a Nichols chart: gain over phase, and its distance from the critical point.

use nalgebra::Complex;

use super::curve::Peak;
use super::error::DesignError;
use super::response::bode;
use hovernav_model::StateSpace;

/// Gain margin, dB, and phase margin, °, that a loop must keep in combination.
pub const ZONE: (f64, f64) = (6.0, 45.0);

/// A loop on a Nichols chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Nichols {
    /// Phase, °, within half a turn of −180°, and gain, dB, at each frequency.
    pub curve: Vec<(f64, f64)>,
    /// The smallest disk margin of this loop alone, with its frequency: twice the least |1 + L|/|1 − L|.
    pub disk: Peak,
}

impl Nichols {
    /// The chart of the loop `open` from its one input to its one output, both named `channel`, at `frequencies_radps`.
    ///
    /// # Errors
    /// [`DesignError`] where the loop has no such input.
    ///
    /// # Source
    /// Seiler, Packard and Gahinet (2020), "An introduction to disk margins", *IEEE Control Systems* 40(5), the
    /// disk of skew 0.
    pub fn of(
        open: &StateSpace,
        channel: &str,
        frequencies_radps: &[f64],
    ) -> Result<Self, DesignError> {
        let response = bode(open, channel, 0, frequencies_radps)?;
        let mut disk = Peak { frequency_radps: f64::NAN, value: f64::INFINITY };
        let mut curve = Vec::with_capacity(response.len());
        for (&frequency_radps, (gain_db, phase_deg)) in frequencies_radps.iter().zip(response) {
            curve.push((phase_deg.rem_euclid(360.0) - 360.0, gain_db));
            let loop_gain = Complex::from_polar(10f64.powf(gain_db / 20.0), phase_deg.to_radians());
            let value = 2.0 * (loop_gain + 1.0).norm() / (-loop_gain + 1.0).norm();
            if value < disk.value {
                disk = Peak { frequency_radps, value };
            }
        }
        Ok(Self { curve, disk })
    }

    /// Factors between which the loop's gain may vary according to its disk margin, for any phase within
    /// [`disk_phase_deg`](Self::disk_phase_deg).
    #[must_use]
    pub fn disk_gain(&self) -> [f64; 2] {
        let half = 0.5 * self.disk.value.min(2.0);
        [(1.0 - half) / (1.0 + half), (1.0 + half) / (1.0 - half)]
    }

    /// Phase, °, by which the loop may vary according to its disk margin, for any gain within
    /// [`disk_gain`](Self::disk_gain).
    #[must_use]
    pub fn disk_phase_deg(&self) -> f64 {
        2.0 * (0.5 * self.disk.value).atan().to_degrees()
    }

    /// Whether the loop passes through the zone: an ellipse about −180° and 0 dB with the margins of [`ZONE`] as
    /// semi-axes.
    #[must_use]
    pub fn enters_zone(&self) -> bool {
        let inside = |&(phase_deg, gain_db): &(f64, f64)| {
            ((phase_deg + 180.0) / ZONE.1).hypot(gain_db / ZONE.0) < 1.0
        };
        self.curve.iter().any(inside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::response::logarithmic_frequencies;
    use approx::assert_abs_diff_eq;
    use hovernav_model::{Signal, TimeDomain};
    use nalgebra::{DMatrix, dmatrix};

    /// Chart of the loop gain/(s (s + 1)).
    fn loop_of(gain: f64) -> Nichols {
        let signals = |names: &[&str]| names.iter().map(|name| Signal::new(name, "1")).collect();
        let open = StateSpace::new(
            "loop",
            TimeDomain::Continuous,
            signals(&["x", "v"]),
            signals(&["x"]),
            dmatrix![0.0, 1.0; 0.0, -1.0],
            dmatrix![0.0; gain],
        )
        .unwrap()
        .with_outputs(signals(&["x"]), dmatrix![1.0, 0.0], DMatrix::zeros(1, 1))
        .unwrap();
        Nichols::of(&open, "x", &logarithmic_frequencies(0.01, 100.0, 4000)).unwrap()
    }

    #[test]
    fn the_disk_margin_is_that_of_its_closed_form() {
        // |1 + L|²/|1 − L|² of 1/(s² + s) is ((1 − ω²)² + ω²)/((1 + ω²)² + ω²), least at ω = 1: 1/5.
        let found = loop_of(1.0);
        assert!((found.disk.value - 2.0 / 5f64.sqrt()).abs() < 1e-5, "{:?}", found.disk);
        assert_abs_diff_eq!(found.disk.frequency_radps, 1.0, epsilon = 1e-2);
        let [least, most] = found.disk_gain();
        assert_abs_diff_eq!(least * most, 1.0, epsilon = 1e-12);
        assert!(most > 2.0);
    }

    #[test]
    fn a_loop_enters_the_zone_where_its_phase_margin_is_small() {
        // Phase margins of 52° and 18°, with unlimited gain margin.
        assert!(!loop_of(1.0).enters_zone() && loop_of(10.0).enters_zone());
        assert!(
            loop_of(1.0).curve.iter().all(|(phase_deg, _)| (-180.0..-89.0).contains(phase_deg))
        );
    }
}
