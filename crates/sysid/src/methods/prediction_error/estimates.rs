//! Parameters as they are printed: never without their bounds.

use std::fmt;

use nalgebra::DMatrix;

/// What became of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Estimated.
    Free,
    /// Estimated, and ended on one of its bounds.
    OnBound,
    /// Held at its start by the structure.
    Held,
    /// Dropped; the log says why.
    Dropped,
}

impl Status {
    /// What became of it, in a word or two.
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

/// One parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Name in the structure.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value found.
    pub value: f64,
    /// Value at the start.
    pub start: f64,
    /// What became of it.
    pub status: Status,
    /// Cramér–Rao bound, one sigma, in the parameter's unit; 0 where it was not estimated. Where
    /// the settings ask for it, it is that of innovations as they are: correlated, and larger at some
    /// times than at others.
    pub bound: f64,
    /// The bound if innovations were white.
    pub white_bound: f64,
    /// How far the parameter alone can move at that cost: 1/√ of its own information. Never above the
    /// white bound.
    pub insensitivity: f64,
}

impl Estimate {
    /// Whether the search was free to move it.
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

/// The parameters of an identified structure, its noises last, and their correlations.
///
/// Printed as CIFER prints its identification summary: value, Cramér–Rao bound and insensitivity in
/// percent, then the pairs that are strongly correlated. CIFER's bound is this one doubled.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimates {
    /// Parameters in the structure's order, then σ of each process noise (of a state's rate, per
    /// sample), then σ of each output's noise.
    pub list: Vec<Estimate>,
    /// Indices in `list` of what was estimated.
    pub free: Vec<usize>,
    /// Covariance of what was estimated, in the order of `free`; noises as σ.
    pub covariance: DMatrix<f64>,
    /// The covariance if innovations were white.
    pub white_covariance: DMatrix<f64>,
}

impl Estimates {
    /// The estimate named `name`.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Estimate> {
        self.list.iter().find(|estimate| estimate.name == name)
    }

    /// The correlation of two estimates; `None` where one was not estimated.
    #[must_use]
    pub fn correlation(&self, one: &str, other: &str) -> Option<f64> {
        let find = |name: &str| self.free.iter().position(|&index| self.list[index].name == name);
        Some(self.correlation_at(find(one)?, find(other)?))
    }

    /// How many times larger the variances of the estimates `names` together are than those of white
    /// innovations: the mean of the eigenvalues of W⁻¹V, of their two covariances. By so much their likelihood
    /// is overstated. `None` where none of them was estimated, or no variance can be told.
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
