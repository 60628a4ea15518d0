//! The steady-state Kalman predictor of a structure at one set of parameters, and its derivatives.

use nalgebra::{Cholesky, DMatrix};

use crate::methods::kalman::predicted_covariance;
use crate::methods::structure::Structure;
use hovernav_model::linalg::{HoldDerivatives, Stein, ZeroOrderHold};

/// The predictor x⁺ = Φ x + Γ [u n o] + K ν. The innovation ν = y − C x − D u − b has the covariance S = L Lᵀ. The
/// inputs are u, the process noises n, the offsets o, the biases b. The last entries of u are excursions of late inputs:
/// their columns of B are A times those of the inputs.
///
/// Process noise is an unmeasured input, white from sample to sample and held between. Its covariance per step is Γₙ
/// diag(σ²) Γₙᵀ, and its derivatives are those of Γ.
pub(super) struct Predictor {
    hold: ZeroOrderHold,
    pub phi: DMatrix<f64>,
    pub gamma: DMatrix<f64>,
    pub c: DMatrix<f64>,
    pub d: DMatrix<f64>,
    /// Number of derivatives of the late inputs with respect to delays and lags.
    pub slopes: usize,
    pub gain: DMatrix<f64>,
    /// F = Φ − K C.
    closed: DMatrix<f64>,
    /// Covariance of the predicted state.
    pub covariance: DMatrix<f64>,
    /// L⁻¹, lower triangular.
    pub whitener: DMatrix<f64>,
    /// ln det S.
    pub log_determinant: f64,
    process_sigma: Vec<f64>,
    measurement_sigma: Vec<f64>,
}

/// Kind of an entry of the whole parameter vector: a parameter of the structure, then ln σ of each process noise, then
/// ln σ of each measurement noise.
#[derive(Clone, Copy)]
enum Entry {
    Structure(usize),
    Process(usize),
    Measurement(usize),
}

/// Derivative of the predictor with respect to one parameter.
pub(super) struct Derivative {
    pub phi: DMatrix<f64>,
    pub gamma: DMatrix<f64>,
    pub c: DMatrix<f64>,
    pub d: DMatrix<f64>,
    pub gain: DMatrix<f64>,
    /// L⁻¹ dS L⁻ᵀ.
    pub whitened_innovations: DMatrix<f64>,
    /// Inputs that this parameter delays or lags, each with the index of its derivative among the derivatives of the
    /// inputs.
    pub shifts: Vec<(usize, usize)>,
}

impl Predictor {
    /// The predictor at `theta`, the whole parameter vector. With `innovations` false the gain is 0: output error.
    /// `None` where no stabilising gain exists or values overflow.
    pub fn new(
        structure: &Structure,
        theta: &[f64],
        period_s: f64,
        innovations: bool,
    ) -> Option<Self> {
        let (own, sigmas) = theta.split_at(structure.parameters.len());
        let sigmas: Vec<f64> = sigmas.iter().map(|log| log.exp()).collect();
        let (process_sigma, measurement_sigma) = sigmas.split_at(structure.noises.len());
        let (n, m, q) = (structure.states.len(), structure.inputs.len(), structure.noises.len());
        let (dynamics, measurement) = structure.combined(own);
        let a = dynamics.columns(0, n).into_owned();
        let late = structure.late_inputs();
        let mut b = dynamics.columns(n, dynamics.ncols() - n).into_owned();
        b = b.insert_columns(m, late.len(), 0.0);
        for (place, &input) in late.iter().enumerate() {
            let excursion = &a * b.column(input);
            b.set_column(m + place, &excursion);
        }
        let hold = ZeroOrderHold::new(a, b, period_s)?;
        let (phi, gamma) = hold.map().clone();
        let c = measurement.columns(0, n).into_owned();
        let d = measurement.columns(n, m).insert_columns(m, late.len(), 0.0);
        let m = d.ncols();

        let p = structure.outputs.len();
        let r = DMatrix::from_fn(p, p, |row, column| {
            if row == column { measurement_sigma[row].powi(2) } else { 0.0 }
        });
        let (gain, covariance, s) = if innovations {
            let mut driven = gamma.columns(m, q).into_owned();
            for (index, sigma) in process_sigma.iter().enumerate() {
                driven.column_mut(index).scale_mut(*sigma);
            }
            let covariance = predicted_covariance(&phi, &c, &(&driven * driven.transpose()), &r)?;
            let across = &covariance * c.transpose();
            let s = &c * &across + &r;
            let gain = (&phi * across) * Cholesky::new(s.clone())?.inverse();
            (gain, covariance, s)
        } else {
            (DMatrix::zeros(n, p), DMatrix::zeros(n, n), r)
        };
        let lower = Cholesky::new(s)?.unpack();
        let log_determinant = 2.0 * lower.diagonal().iter().map(|value| value.ln()).sum::<f64>();
        let whitener = lower.solve_lower_triangular(&DMatrix::identity(p, p))?;
        Some(Self {
            closed: &phi - &gain * &c,
            hold,
            phi,
            gamma,
            c,
            d,
            slopes: 4 * late.len(),
            gain,
            covariance,
            whitener,
            log_determinant,
            process_sigma: process_sigma.to_vec(),
            measurement_sigma: measurement_sigma.to_vec(),
        })
    }

    /// The derivatives with respect to the entries `free` of the whole parameter vector `theta`.
    ///
    /// K changes with P. dP solves Stein's equation dP = F dP Fᵀ + dF P Fᵀ + F P dFᵀ + K dR Kᵀ + dQ with dF = dΦ − K
    /// dC. The change of the gain cancels because the gain is optimal.
    ///
    /// # Source
    /// Equation (I11) of docs/equations.md.
    pub fn derivatives(
        &self,
        structure: &Structure,
        theta: &[f64],
        free: &[usize],
        innovations: bool,
    ) -> Option<Vec<Derivative>> {
        let stein = if innovations { Some(Stein::new(&self.closed)?) } else { None };
        let hold = self.hold.derivatives();
        let inverse = self.whitener.transpose() * &self.whitener;
        let from_covariance = &self.covariance * self.closed.transpose();
        Some(
            free.iter()
                .map(|&index| {
                    let kind = kind(structure, index);
                    let mut change = self.direct(&hold, structure, theta, kind);
                    let d_r = self.measurement_change(kind);
                    let d_s = if let Some(stein) = &stein {
                        let d_p = self.covariance_change(&change, kind, stein, &from_covariance);
                        let moved = &change.c * &self.covariance * self.c.transpose();
                        let d_s =
                            &self.c * &d_p * self.c.transpose() + &moved + moved.transpose() + &d_r;
                        change.gain = ((&change.phi * &self.covariance + &self.phi * &d_p)
                            * self.c.transpose()
                            + &self.phi * &self.covariance * change.c.transpose()
                            - &self.gain * &d_s)
                            * &inverse;
                        d_s
                    } else {
                        d_r
                    };
                    change.whitened_innovations = &self.whitener * d_s * self.whitener.transpose();
                    change
                })
                .collect(),
        )
    }

    fn covariance_change(
        &self,
        change: &Derivative,
        kind: Entry,
        stein: &Stein,
        from_covariance: &DMatrix<f64>,
    ) -> DMatrix<f64> {
        let m = self.d.ncols();
        let d_closed = &change.phi - &self.gain * &change.c;
        let half = d_closed * from_covariance;
        let mut forcing = &half + half.transpose();
        for (index, sigma) in self.process_sigma.iter().enumerate() {
            let column = self.gamma.column(m + index);
            let moved = change.gamma.column(m + index);
            forcing.ger(sigma * sigma, &column, &moved, 1.0);
            forcing.ger(sigma * sigma, &moved, &column, 1.0);
        }
        match kind {
            Entry::Process(index) => {
                let column = self.gamma.column(m + index);
                forcing.ger(2.0 * self.process_sigma[index].powi(2), &column, &column, 1.0);
            }
            Entry::Measurement(index) => {
                let column = self.gain.column(index);
                forcing.ger(2.0 * self.measurement_sigma[index].powi(2), &column, &column, 1.0);
            }
            Entry::Structure(_) => {}
        }
        stein.solve(forcing)
    }

    fn measurement_change(&self, kind: Entry) -> DMatrix<f64> {
        let p = self.c.nrows();
        let mut d_r = DMatrix::zeros(p, p);
        if let Entry::Measurement(index) = kind {
            d_r[(index, index)] = 2.0 * self.measurement_sigma[index].powi(2);
        }
        d_r
    }

    /// Derivative with respect to a parameter at constant gain.
    fn direct(
        &self,
        hold: &HoldDerivatives<'_>,
        structure: &Structure,
        theta: &[f64],
        kind: Entry,
    ) -> Derivative {
        let (n, m, p) = (self.phi.nrows(), self.d.ncols(), self.c.nrows());
        let mut measurement = DMatrix::zeros(p, n + m);
        let mut change = Vec::new();
        let mut shifts = Vec::new();
        if let Entry::Structure(index) = kind {
            let (inputs, late) = (structure.inputs.len(), structure.late_inputs());
            for term in &structure.dynamics {
                let rate = term.derivative(theta, index);
                if rate != 0.0 {
                    let later = if term.column < n + inputs { 0 } else { late.len() };
                    change.push((term.row, term.column + later, rate));
                }
            }
            for term in &structure.measurement {
                measurement[(term.row, term.column)] += term.derivative(theta, index);
            }
            let (a, b) = self.hold.rates();
            let own = change.clone();
            for (place, &input) in late.iter().enumerate() {
                let excursion = n + inputs + place;
                for &(row, column, rate) in &own {
                    if column < n {
                        change.push((row, excursion, rate * b[(column, input)]));
                    } else if column == n + input {
                        change.extend((0..n).map(|to| (to, excursion, a[(to, row)] * rate)));
                    }
                }
                for (which, of) in [&structure.delays, &structure.lags].into_iter().enumerate() {
                    if of[input] == Some(index) {
                        let first = 4 * place + 2 * which;
                        shifts.extend([(input, first), (inputs + place, first + 1)]);
                    }
                }
            }
        }
        let (phi, gamma) = hold.along(&change);
        Derivative {
            phi,
            gamma,
            c: measurement.columns(0, n).into_owned(),
            d: measurement.columns(n, m).into_owned(),
            gain: DMatrix::zeros(n, p),
            whitened_innovations: DMatrix::zeros(p, p),
            shifts,
        }
    }
}

fn kind(structure: &Structure, index: usize) -> Entry {
    let (own, process) = (structure.parameters.len(), structure.noises.len());
    match index.checked_sub(own) {
        None => Entry::Structure(index),
        Some(index) if index < process => Entry::Process(index),
        Some(index) => Entry::Measurement(index - process),
    }
}
