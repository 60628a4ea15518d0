//! The exact one-step map of ẋ = A x + B u with held u, and its derivatives.

use nalgebra::DMatrix;

/// Abscissae and weights of the 8-point Gauss rule on −1…1 (Abramowitz and Stegun, table 25.4).
const GAUSS_LEGENDRE: [(f64, f64); 8] = [
    (-0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
    (-0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (-0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (-0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
];

/// The map x⁺ = Φ x + Γ u of ẋ = A x + B u over one period with held u. It uses a Taylor series over a step with
/// ‖A‖·step ≤ 1, then doubling: exact to rounding.
///
/// # Source
/// Franklin, Powell and Workman, *Digital Control of Dynamic Systems*, section 4.3; scaling and
/// squaring: Moler and Van Loan (2003), *SIAM Review* 45(1), method 3.
#[derive(Clone, Debug)]
pub struct ZeroOrderHold {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    step: f64,
    /// Φ and Γ at step, 2·step, 4·step … up to the period.
    levels: Vec<(DMatrix<f64>, DMatrix<f64>)>,
    /// ∫₀ʰ e^{As} ds over one step h.
    integral: DMatrix<f64>,
}

impl ZeroOrderHold {
    /// The map of `a`, n×n, and `b`, n×m, over `period_s`. `None` where a number is not finite.
    ///
    /// # Source
    /// Equation (L5) of docs/equations.md.
    #[must_use]
    pub fn new(a: DMatrix<f64>, b: DMatrix<f64>, period_s: f64) -> Option<Self> {
        let norm = a.column_iter().map(|column| column.lp_norm(1)).fold(0.0, f64::max) * period_s;
        if !norm.is_finite() {
            return None;
        }
        let doublings = if norm > 1.0 { norm.log2().ceil() as i32 } else { 0 };
        let step = period_s / 2_f64.powi(doublings);
        let end = Propagator::new(&a, &b, step);
        let mut levels = vec![(end.phi, end.gamma)];
        for level in 0..doublings as usize {
            let (phi, gamma) = &levels[level];
            levels.push((phi * phi, phi * gamma + gamma));
        }
        Some(Self { a, b, step, levels, integral: end.integral })
    }

    /// A, n×n, and B, n×m.
    #[must_use]
    pub const fn rates(&self) -> (&DMatrix<f64>, &DMatrix<f64>) {
        (&self.a, &self.b)
    }

    /// Φ, n×n, and Γ, n×m, over the whole period.
    #[must_use]
    pub fn map(&self) -> &(DMatrix<f64>, DMatrix<f64>) {
        &self.levels[self.levels.len() - 1]
    }

    /// Intermediate results for the derivatives of the map.
    #[must_use]
    pub fn derivatives(&self) -> HoldDerivatives<'_> {
        let at = |x: f64| Propagator::new(&self.a, &self.b, 0.5 * self.step * (1.0 + x));
        HoldDerivatives { hold: self, nodes: GAUSS_LEGENDRE.iter().map(|(x, _)| at(*x)).collect() }
    }
}

/// The derivatives of a [`ZeroOrderHold`] with respect to the entries of A and B.
///
/// An entry of A at (i, j) changes Φ by ∫ e^{A(h−s)} eᵢ eⱼᵀ e^{As} ds. A Gauss rule evaluates it as a sum of outer
/// products, exact to rounding over one step. Longer periods follow by doubling.
#[derive(Clone, Debug)]
pub struct HoldDerivatives<'a> {
    hold: &'a ZeroOrderHold,
    nodes: Vec<Propagator>,
}

impl HoldDerivatives<'_> {
    /// The derivatives of Φ and Γ along a change of [A B] given as (row, column, rate).
    ///
    /// # Source
    /// Equation (I12) of docs/equations.md.
    #[must_use]
    pub fn along(&self, change: &[(usize, usize, f64)]) -> (DMatrix<f64>, DMatrix<f64>) {
        let levels = &self.hold.levels;
        let (phi, gamma) = &levels[0];
        let n = phi.nrows();
        let mut d_phi = DMatrix::zeros(n, n);
        let mut d_gamma = DMatrix::zeros(n, gamma.ncols());
        for &(row, column, rate) in change {
            if column >= n {
                let integral = self.hold.integral.column(row);
                d_gamma.column_mut(column - n).axpy(rate, &integral, 1.0);
                continue;
            }
            for (index, (_, weight)) in GAUSS_LEGENDRE.iter().enumerate() {
                // The rule is symmetric: node 7 − i is as far from the end as node i from the start.
                let late = &self.nodes[GAUSS_LEGENDRE.len() - 1 - index];
                let early = &self.nodes[index];
                let scale = 0.5 * self.hold.step * weight * rate;
                let left = late.phi.column(row);
                d_phi.ger(scale, &left, &early.phi.row(column).transpose(), 1.0);
                d_gamma.ger(scale, &left, &early.gamma.row(column).transpose(), 1.0);
            }
        }
        for (phi, gamma) in &levels[..levels.len() - 1] {
            d_gamma = &d_phi * gamma + phi * &d_gamma + &d_gamma;
            d_phi = &d_phi * phi + phi * &d_phi;
        }
        (d_phi, d_gamma)
    }
}

/// e^{At}, the integral ∫₀ᵗ e^{As} ds, and this integral times B, for one time t.
#[derive(Clone, Debug)]
struct Propagator {
    phi: DMatrix<f64>,
    integral: DMatrix<f64>,
    gamma: DMatrix<f64>,
}

impl Propagator {
    /// e^{At} and its integral by Taylor's series, for ‖A‖t ≤ 1.
    fn new(a: &DMatrix<f64>, b: &DMatrix<f64>, t: f64) -> Self {
        const TERMS: u32 = 17;
        let n = a.nrows();
        let identity = DMatrix::identity(n, n);
        let scaled = a * t;
        let mut series = identity.clone();
        for term in (2..=TERMS).rev() {
            series = &identity + (&scaled * series) / f64::from(term);
        }
        let integral = series * t;
        Self { phi: identity + a * &integral, gamma: &integral * b, integral }
    }
}

/// e^{At} of a square `a`; NaN throughout where a number is not finite.
#[must_use]
pub fn exponential(a: &DMatrix<f64>, t: f64) -> DMatrix<f64> {
    let n = a.nrows();
    match ZeroOrderHold::new(a.clone(), DMatrix::zeros(n, 0), t) {
        Some(hold) => hold.map().0.clone(),
        None => DMatrix::from_element(n, n, f64::NAN),
    }
}
