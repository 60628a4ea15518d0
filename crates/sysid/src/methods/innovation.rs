//! A linear model with its disturbances, and its predictions.

use nalgebra::{DMatrix, DVector};

use hovernav_model::LinearModel;
use hovernav_model::linalg::spectral_radius;

/// A discrete [`LinearModel`] with a disturbance model in innovation form: x(k+1) = A x + B u + K e, y = C x + D u + e.
/// The innovation e is the part of y that the past does not predict.
#[derive(Debug, Clone, PartialEq)]
pub struct InnovationModel {
    /// The model, discrete in time.
    pub system: LinearModel,
    /// K, states × outputs; zero where all disturbance is measurement noise (output error).
    pub gain: DMatrix<f64>,
}

impl InnovationModel {
    /// The same model with all disturbance as measurement noise.
    #[must_use]
    pub fn without_gain(&self) -> Self {
        Self {
            system: self.system.clone(),
            gain: DMatrix::zeros(self.gain.nrows(), self.gain.ncols()),
        }
    }

    /// Largest magnitude of the eigenvalues of A − K C. Below 1 the one-step predictor forgets its initial state, even
    /// if the vehicle is unstable.
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

    /// Predictions `steps` ahead (samples × outputs): row k uses the inputs to k and the outputs to k−`steps`. The
    /// first rows have no such outputs and are simulated from `start`.
    ///
    /// # Panics
    /// Where `steps` is zero.
    #[must_use]
    pub fn predict_ahead(
        &self,
        inputs: &DMatrix<f64>,
        outputs: &DMatrix<f64>,
        start: &DVector<f64>,
        steps: usize,
    ) -> DMatrix<f64> {
        assert!(steps > 0, "a prediction is at least one step ahead");
        let LinearModel { a, b, c, d, .. } = &self.system;
        let samples = inputs.nrows();
        let forcing = b * inputs.transpose();
        let direct = d * inputs.transpose();
        let mut predicted = DMatrix::zeros(c.nrows(), samples);
        let mut state = start.clone();
        // The first rows are simulated, because they have no earlier measurements.
        let mut free = start.clone();
        for sample in 0..steps.min(samples) {
            predicted.set_column(sample, &(c * &free + direct.column(sample)));
            free = a * free + forcing.column(sample);
        }
        for sample in 0..samples {
            let expected = c * &state + direct.column(sample);
            let innovation = outputs.row(sample).transpose() - expected;
            state = a * state + forcing.column(sample) + &self.gain * innovation;
            // `state` is that of sample + 1 with the output of `sample`.
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
