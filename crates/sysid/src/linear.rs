//! A linear model as a one-step map, and what it predicts.

use nalgebra::{DMatrix, DVector};

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
        spectral_radius(&self.a)
    }

    /// The outputs (samples × outputs) that the inputs (samples × inputs) alone give from the
    /// state `start`: the free run, without any correction from measurements.
    ///
    /// An unstable model may overflow to infinities.
    #[must_use]
    pub fn simulate(&self, inputs: &DMatrix<f64>, start: &DVector<f64>) -> DMatrix<f64> {
        let forcing = &self.b * inputs.transpose();
        let mut states = DMatrix::zeros(self.order(), inputs.nrows());
        let mut state = start.clone();
        for (mut kept, forced) in states.column_iter_mut().zip(forcing.column_iter()) {
            kept.copy_from(&state);
            state.copy_from(&forced);
            state.gemv(1.0, &self.a, &kept, 1.0);
        }
        (&self.c * states + &self.d * inputs.transpose()).transpose()
    }
}

/// A [`LinearModel`] with a model of what it cannot foresee, in innovation form:
/// x(k+1) = A x + B u + K e, y = C x + D u + e, where e is what the past could not tell of y.
#[derive(Debug, Clone, PartialEq)]
pub struct InnovationModel {
    /// The model.
    pub system: LinearModel,
    /// K, states × outputs; zero where all disturbance is measurement noise (output error).
    pub gain: DMatrix<f64>,
}

impl InnovationModel {
    /// The same model with all disturbance taken for measurement noise.
    #[must_use]
    pub fn without_gain(&self) -> Self {
        Self {
            system: self.system.clone(),
            gain: DMatrix::zeros(self.gain.nrows(), self.gain.ncols()),
        }
    }

    /// The largest magnitude among the eigenvalues of A − K C: below 1 the one-step predictor
    /// forgets its start, whether or not the plant itself is stable.
    #[must_use]
    pub fn predictor_spectral_radius(&self) -> f64 {
        spectral_radius(&(&self.system.a - &self.gain * &self.system.c))
    }

    /// One-step predictions (samples × outputs): row k uses the inputs to k and the outputs to k−1,
    /// from the state `start` at the first sample.
    #[must_use]
    pub fn predict(
        &self,
        inputs: &DMatrix<f64>,
        outputs: &DMatrix<f64>,
        start: &DVector<f64>,
    ) -> DMatrix<f64> {
        self.predict_ahead(inputs, outputs, start, 1)
    }

    /// Predictions `steps` ahead (samples × outputs): row k uses the inputs to k and the outputs to
    /// k−`steps`. The first rows, which have no such outputs, run free from `start`.
    ///
    /// # Panics
    /// Where `steps` is zero: the present needs no prediction.
    #[must_use]
    pub fn predict_ahead(
        &self,
        inputs: &DMatrix<f64>,
        outputs: &DMatrix<f64>,
        start: &DVector<f64>,
        steps: usize,
    ) -> DMatrix<f64> {
        assert!(steps > 0, "a prediction looks at least one step ahead");
        let LinearModel { a, b, c, d, .. } = &self.system;
        let samples = inputs.nrows();
        let forcing = b * inputs.transpose();
        let direct = d * inputs.transpose();
        let mut predicted = DMatrix::zeros(c.nrows(), samples);
        let mut state = start.clone();
        // Nothing is measured yet: the first rows run free.
        let mut free = start.clone();
        for sample in 0..steps.min(samples) {
            predicted.set_column(sample, &(c * &free + direct.column(sample)));
            free = a * free + forcing.column(sample);
        }
        for sample in 0..samples {
            let expected = c * &state + direct.column(sample);
            let innovation = outputs.row(sample).transpose() - expected;
            state = a * state + forcing.column(sample) + &self.gain * innovation;
            // `state` is now that of sample + 1 with the output of `sample`.
            let target = sample + steps;
            if target < samples {
                let mut ahead = state.clone();
                for step in sample + 1..target {
                    ahead = a * ahead + forcing.column(step);
                }
                predicted.set_column(target, &(c * ahead + direct.column(target)));
            }
        }
        predicted.transpose()
    }
}

/// The largest magnitude among the eigenvalues; infinite where they are not finite.
pub(crate) fn spectral_radius(a: &DMatrix<f64>) -> f64 {
    if a.iter().any(|value| !value.is_finite()) {
        return f64::INFINITY;
    }
    a.complex_eigenvalues().iter().map(|pole| pole.norm()).fold(0.0, f64::max)
}
