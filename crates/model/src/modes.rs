//! Eigenvalues with their frequency, damping and time constants.

use std::fmt;

use nalgebra::Complex;

use super::error::ModelError;
use super::linalg::eigenvalues;
use super::linear::TimeDomain;
use super::state_space::StateSpace;

/// One eigenvalue of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Eigenvalue of A, 1/s for a continuous model, dimensionless for a discrete one.
    pub eigenvalue: Complex<f64>,
    /// Eigenvalue in continuous time, 1/s: ln(λ)/T for a discrete model, infinite for a λ of zero.
    pub continuous: Complex<f64>,
}

impl Mode {
    /// Natural frequency, rad/s.
    #[must_use]
    pub fn frequency_radps(&self) -> f64 {
        self.continuous.norm()
    }

    /// Damping ratio in −1…1, above zero for a mode that decays; `None` for an integrator.
    #[must_use]
    pub fn damping_ratio(&self) -> Option<f64> {
        let frequency = self.frequency_radps();
        if frequency.is_infinite() {
            return Some(1.0);
        }
        (frequency > 1e-12).then(|| -self.continuous.re / frequency)
    }

    /// Time in which the mode decays to 1/e, s. Negative for a mode that grows e-fold in that time, `None` for constant
    /// amplitude.
    #[must_use]
    pub fn time_constant_s(&self) -> Option<f64> {
        (self.continuous.re.abs() > 1e-12).then(|| -1.0 / self.continuous.re)
    }
}

/// Modes of a model, slowest first. Displayed as a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    /// Time domain of the eigenvalues.
    pub time: TimeDomain,
    /// The modes in order of rising natural frequency. In a pair the mode with positive imaginary part comes first.
    pub modes: Vec<Mode>,
}

impl StateSpace {
    /// The modes of the model.
    ///
    /// # Errors
    /// [`ModelError::Eigenvalues`] where the computation does not converge.
    ///
    /// # Source
    /// Equation (L16) of docs/equations.md.
    pub fn modes(&self) -> Result<Modes, ModelError> {
        let time = self.time();
        let mut modes: Vec<Mode> = eigenvalues(self.a())?
            .into_iter()
            .map(|eigenvalue| {
                let continuous = match time {
                    TimeDomain::Continuous => eigenvalue,
                    TimeDomain::Discrete { .. } if eigenvalue == Complex::ZERO => {
                        Complex::new(f64::NEG_INFINITY, 0.0)
                    }
                    TimeDomain::Discrete { period_s } => eigenvalue.ln() / period_s,
                };
                Mode { eigenvalue, continuous }
            })
            .collect();
        modes.sort_by(|one, other| {
            let (one, other) = (one, other);
            one.frequency_radps()
                .total_cmp(&other.frequency_radps())
                .then(other.eigenvalue.im.total_cmp(&one.eigenvalue.im))
        });
        Ok(Modes { time, modes })
    }
}

impl fmt::Display for Modes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:>24}  {:>10}  {:>8}  {:>10}", "eigenvalue", "rad/s", "damping", "1/e in s")?;
        for mode in &self.modes {
            let Complex { re, im } = mode.eigenvalue;
            let eigenvalue =
                if im == 0.0 { format!("{re:.4}") } else { format!("{re:.4} {im:+.4}i") };
            let or_dash =
                |value: Option<f64>| value.map_or_else(|| "-".into(), |v| format!("{v:.3}"));
            writeln!(
                f,
                "{eigenvalue:>24}  {:>10.4}  {:>8}  {:>10}",
                mode.frequency_radps(),
                or_dash(mode.damping_ratio()),
                or_dash(mode.time_constant_s()),
            )?;
        }
        Ok(())
    }
}
