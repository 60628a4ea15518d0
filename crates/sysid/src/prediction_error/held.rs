//! The exact one-step map of ẋ = A x + B w under held w, and its derivatives.

use nalgebra::DMatrix;

/// Abscissae and weights of Gauss's rule of 8 points on −1…1 (Abramowitz and Stegun, table 25.4).
const GAUSS: [(f64, f64); 8] = [
    (-0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
    (-0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (-0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (-0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
];

/// e^{At} and ∫₀ᵗ e^{As} ds at one time, and the second times B.
struct Moment {
    phi: DMatrix<f64>,
    integral: DMatrix<f64>,
    gamma: DMatrix<f64>,
}

/// The map x⁺ = Φ x + Γ w over one period, with what its derivatives need.
///
/// An entry of A at (i, j) moves Φ by ∫ e^{A(h−s)} eᵢ eⱼᵀ e^{As} ds: a sum of outer products at the
/// nodes of a Gauss rule, exact to rounding over a step h with ‖A‖h ≤ 1. Longer periods double up
/// from there.
pub(super) struct Held {
    nodes: Vec<Moment>,
    step: f64,
    /// Φ and Γ at step, 2·step, 4·step … up to the period.
    levels: Vec<(DMatrix<f64>, DMatrix<f64>)>,
    /// ∫₀ʰ e^{As} ds over one step.
    integral: DMatrix<f64>,
}

impl Held {
    /// Of `dynamics`, [A B], over `period_s`. `None` where it is not finite.
    pub fn new(dynamics: &DMatrix<f64>, period_s: f64) -> Option<Self> {
        let n = dynamics.nrows();
        let a = dynamics.columns(0, n).into_owned();
        let b = dynamics.columns(n, dynamics.ncols() - n).into_owned();
        let norm = a.column_iter().map(|column| column.lp_norm(1)).fold(0.0, f64::max) * period_s;
        if !norm.is_finite() {
            return None;
        }
        let doublings = if norm > 1.0 { norm.log2().ceil() as i32 } else { 0 };
        let step = period_s / 2_f64.powi(doublings);
        let nodes = GAUSS.iter().map(|(x, _)| moment(&a, &b, 0.5 * step * (1.0 + x))).collect();
        let end = moment(&a, &b, step);
        let mut levels = vec![(end.phi, end.gamma)];
        for level in 0..doublings as usize {
            let (phi, gamma) = &levels[level];
            levels.push((phi * phi, phi * gamma + gamma));
        }
        Some(Self { nodes, step, levels, integral: end.integral })
    }

    /// Φ and Γ over the whole period.
    pub fn map(&self) -> &(DMatrix<f64>, DMatrix<f64>) {
        &self.levels[self.levels.len() - 1]
    }

    /// The derivatives of Φ and Γ along a change of [A B] given as (row, column, rate).
    pub fn derivative(&self, change: &[(usize, usize, f64)]) -> (DMatrix<f64>, DMatrix<f64>) {
        let (phi, gamma) = &self.levels[0];
        let n = phi.nrows();
        let mut d_phi = DMatrix::zeros(n, n);
        let mut d_gamma = DMatrix::zeros(n, gamma.ncols());
        for &(row, column, rate) in change {
            if column >= n {
                d_gamma.column_mut(column - n).axpy(rate, &self.integral.column(row), 1.0);
                continue;
            }
            for (index, (_, weight)) in GAUSS.iter().enumerate() {
                // The rule is symmetric: node 7 − i lies as far from the end as node i from the start.
                let late = &self.nodes[GAUSS.len() - 1 - index];
                let early = &self.nodes[index];
                let scale = 0.5 * self.step * weight * rate;
                let left = late.phi.column(row);
                d_phi.ger(scale, &left, &early.phi.row(column).transpose(), 1.0);
                d_gamma.ger(scale, &left, &early.gamma.row(column).transpose(), 1.0);
            }
        }
        for (phi, gamma) in &self.levels[..self.levels.len() - 1] {
            d_gamma = &d_phi * gamma + phi * &d_gamma + &d_gamma;
            d_phi = &d_phi * phi + phi * &d_phi;
        }
        (d_phi, d_gamma)
    }
}

/// Taylor's series, for ‖A‖t ≤ 1.
fn moment(a: &DMatrix<f64>, b: &DMatrix<f64>, t: f64) -> Moment {
    const TERMS: u32 = 17;
    let n = a.nrows();
    let identity = DMatrix::identity(n, n);
    let scaled = a * t;
    let mut series = identity.clone();
    for term in (2..=TERMS).rev() {
        series = &identity + (&scaled * series) / f64::from(term);
    }
    let integral = series * t;
    Moment { phi: identity + a * &integral, gamma: &integral * b, integral }
}
