//! Estimated parameters, always with their bounds.

use std::fmt;

use nalgebra::DMatrix;

/// Status of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Estimated.
    Free,
    /// Estimated, and ended on one of its limits.
    OnBound,
    /// Fixed at its initial value by the structure.
    Held,
    /// Dropped; the log contains the reason.
    Dropped,
}

impl Status {
    /// Status in one or a few words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Free => "estimated",
            Self::OnBound => "on its limit",
            Self::Held => "held",
            Self::Dropped => "dropped",
        }
    }
}

/// One parameter of an identified structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Name in the structure.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Estimated value.
    pub value: f64,
    /// Initial value.
    pub start: f64,
    /// Status.
    pub status: Status,
    /// Cramér–Rao bound, one sigma, in the parameter's unit; 0 where the parameter was not estimated. If the settings
    /// ask for it, the bound accounts for innovations that are correlated and of varying size.
    pub bound: f64,
    /// The bound for white innovations.
    pub white_bound: f64,
    /// Insensitivity: change of the parameter, with all others fixed, that raises the cost by the same amount for each
    /// parameter. It is 1/√ of the parameter's own information and never above the white bound.
    pub insensitivity: f64,
}

impl Estimate {
    /// Whether the parameter was estimated.
    #[must_use]
    pub const fn is_estimated(&self) -> bool {
        matches!(self.status, Status::Free | Status::OnBound)
    }

    /// Cramér–Rao bound in percent of the value.
    #[must_use]
    pub fn bound_percent(&self) -> f64 {
        100.0 * self.bound / self.value.abs()
    }

    /// Insensitivity in percent of the value.
    #[must_use]
    pub fn insensitivity_percent(&self) -> f64 {
        100.0 * self.insensitivity / self.value.abs()
    }
}

/// Parameters of an identified structure with their correlations, noises last.
///
/// Printed like CIFER's identification summary: value, Cramér–Rao bound and insensitivity in percent, then the strongly
/// correlated pairs. CIFER's bound is twice the bound printed here.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimates {
    /// Parameters in the structure's order, then σ of each process noise, then σ of each output's noise. A process
    /// noise is constant within a sample; its σ has the unit of the state's rate.
    pub list: Vec<Estimate>,
    /// Indices in `list` of the estimated parameters.
    pub free: Vec<usize>,
    /// Covariance of the estimated parameters, in the order of `free`; noises as σ.
    pub covariance: DMatrix<f64>,
    /// Covariance for white innovations.
    pub white_covariance: DMatrix<f64>,
}

impl Estimates {
    /// Estimate of the parameter `name`.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Estimate> {
        self.list.iter().find(|estimate| estimate.name == name)
    }

    /// Correlation of two estimates; `None` where one was not estimated.
    #[must_use]
    pub fn correlation(&self, one: &str, other: &str) -> Option<f64> {
        let find = |name: &str| self.free.iter().position(|&index| self.list[index].name == name);
        Some(self.correlation_at(find(one)?, find(other)?))
    }

    /// Factor by which white innovations would understate the variances of the estimates `names` together. It is the
    /// mean of the eigenvalues of W⁻¹V. W is the covariance for white innovations, V that for the actual innovations.
    /// The likelihood is overstated by this factor. `None` where no estimate of `names` exists, or a variance is
    /// unknown.
    ///
    /// # Source
    /// Kent (1982), *Biometrika* 69(1); Rotnitzky and Jewell (1990), *Biometrika* 77(3). Equation (I31) of
    /// docs/equations.md.
    #[must_use]
    pub fn inflation(&self, names: &[&str]) -> Option<f64> {
        let is_one = |&place: &usize| names.contains(&&*self.list[self.free[place]].name);
        let places: Vec<usize> = (0..self.free.len()).filter(is_one).collect();
        let of = |all: &DMatrix<f64>| all.select_rows(&places).select_columns(&places);
        let ratios = of(&self.white_covariance).cholesky()?.solve(&of(&self.covariance));
        Some(ratios.trace() / places.len() as f64).filter(|mean| mean.is_finite())
    }

    /// Pairs whose correlation exceeds `least` in size: names and correlation, strongest first.
    #[must_use]
    pub fn strong_correlations(&self, least: f64) -> Vec<(&str, &str, f64)> {
        let mut pairs = Vec::new();
        for (row, &one) in self.free.iter().enumerate() {
            for (column, &other) in self.free.iter().enumerate().take(row) {
                let value = self.correlation_at(row, column);
                if value.abs() > least {
                    pairs.push((&*self.list[other].name, &*self.list[one].name, value));
                }
            }
        }
        pairs.sort_by(|one, other| other.2.abs().total_cmp(&one.2.abs()));
        pairs
    }

    fn correlation_at(&self, row: usize, column: usize) -> f64 {
        let variance = |index| self.covariance[(index, index)];
        self.covariance[(row, column)] / (variance(row) * variance(column)).sqrt()
    }
}

impl fmt::Display for Estimates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<12} {:>12} {:<10} {:>12} {:>8} {:>8}",
            "parameter", "value", "unit", "bound", "bound %", "insens %"
        )?;
        for estimate in &self.list {
            write!(f, "{:<12} {:>12.5} {:<10} ", estimate.name, estimate.value, estimate.unit)?;
            match estimate.status {
                Status::Held => writeln!(f, "{:>12}", "held")?,
                Status::Dropped => writeln!(f, "{:>12}", "dropped")?,
                Status::Free | Status::OnBound => writeln!(
                    f,
                    "{:>12.5} {:>8.2} {:>8.2}{}",
                    estimate.bound,
                    estimate.bound_percent(),
                    estimate.insensitivity_percent(),
                    if estimate.status == Status::OnBound { "  on its limit" } else { "" }
                )?,
            }
        }
        for (one, other, value) in self.strong_correlations(0.9) {
            writeln!(f, "correlation of {one} and {other}: {value:.3}")?;
        }
        Ok(())
    }
}
