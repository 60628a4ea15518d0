//! A linear model as a one-step map, and what it predicts.

use nalgebra::{DMatrix, DVector, DVectorView};

/// A linear time-invariant state-space model in discrete time:
/// x(k+1) = A x(k) + B u(k), y(k) = C x(k) + D u(k).
///
/// The matrices are a one-step map at `period_s`, never continuous-time derivatives: a stable
/// model has the eigenvalues of `a` inside the unit circle.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearModel {
    /// State transition over one period, states × states.
    pub a: DMatrix<f64>,
    /// Input matrix for an input held over one period, states × inputs.
    pub b: DMatrix<f64>,
    /// Output matrix, outputs × states.
    pub c: DMatrix<f64>,
    /// Direct feedthrough, outputs × inputs.
    pub d: DMatrix<f64>,
    /// The sample period, s.
    pub period_s: f64,
}

impl LinearModel {
    /// Number of states.
    #[must_use]
    pub fn order(&self) -> usize {
        self.a.nrows()
    }

    /// Number of inputs.
    #[must_use]
    pub fn input_count(&self) -> usize {
        self.b.ncols()
    }

    /// Number of outputs.
    #[must_use]
    pub fn output_count(&self) -> usize {
        self.c.nrows()
    }

    /// The largest magnitude among the eigenvalues of `a`: below 1 the model is stable.
    #[must_use]
    pub fn spectral_radius(&self) -> f64 {
        self.a.complex_eigenvalues().iter().map(|pole| pole.norm()).fold(0.0, f64::max)
    }

    /// The outputs (samples × outputs) that the inputs (samples × inputs) alone give from the
    /// state `start`: the free run, without any correction from measurements.
    ///
    /// An unstable model may overflow to infinities.
    #[must_use]
    pub fn simulate(&self, inputs: &DMatrix<f64>, start: &DVector<f64>) -> DMatrix<f64> {
        let samples = inputs.nrows();
        let columns = inputs.transpose();
        let mut outputs = DMatrix::zeros(self.output_count(), samples);
        let mut state = start.clone();
        let mut next = state.clone();
        for sample in 0..samples {
            let input: DVectorView<'_, f64> = columns.column(sample);
            let mut output = outputs.column_mut(sample);
            output.gemv(1.0, &self.c, &state, 0.0);
            output.gemv(1.0, &self.d, &input, 1.0);
            next.gemv(1.0, &self.a, &state, 0.0);
            next.gemv(1.0, &self.b, &input, 1.0);
            std::mem::swap(&mut state, &mut next);
        }
        outputs.transpose()
    }
}
