//! One sample of the predictor: its state, the innovation and the whitened innovation.

use super::predictor::Predictor;
use super::products::{Columns, group};

/// The state of a predictor, and its matrices.
pub(super) struct Step {
    /// x, filled with zeros to a group.
    state: Vec<f64>,
    /// ν, filled with zeros to a group.
    innovation: Vec<f64>,
    /// Number of states, of inputs and of outputs.
    sizes: [usize; 3],
    /// Number of derivatives of the inputs.
    slopes: usize,
    /// −[C D].
    expected: Columns,
    /// [Φ Γᵤ].
    driven: Columns,
    /// [Γₒ K].
    corrected: Columns,
    /// L⁻¹.
    whitener: Columns,
}

impl Step {
    /// A predictor in the state `start`. The last `offsets` columns of its Γ belong to constant offsets.
    pub fn new(predictor: &Predictor, start: &[f64], offsets: usize) -> Self {
        let Predictor { phi, gamma, c, d, gain, whitener, .. } = predictor;
        let (inputs, first_offset) = (d.ncols(), gamma.ncols() - offsets);
        let mut state = start.to_vec();
        state.resize(group(state.len()), 0.0);
        let [minus_c, minus_d] = [-c, -d];
        Self {
            state,
            innovation: vec![0.0; group(c.nrows())],
            sizes: [start.len(), inputs, c.nrows()],
            slopes: predictor.slopes,
            expected: Columns::of(&[minus_c.as_view(), minus_d.as_view()]),
            driven: Columns::of(&[phi.as_view(), gamma.columns(0, inputs).as_view()]),
            corrected: Columns::of(&[
                gamma.columns(first_offset, offsets).as_view(),
                gain.as_view(),
            ]),
            whitener: Columns::of(&[whitener.as_view()]),
        }
    }

    /// Writes x to z = [x u du/dτ o ν] and replaces the measured outputs in z by their innovation ν. Then it advances
    /// to the next sample.
    pub fn advance(&mut self, z: &mut [f64]) {
        let [states, inputs, outputs] = self.sizes;
        z[..states].copy_from_slice(&self.state[..states]);
        let measured = z.len() - outputs;
        self.innovation[..outputs].copy_from_slice(&z[measured..]);
        self.expected.add_product(&z[..states + inputs], &mut self.innovation);
        z[measured..].copy_from_slice(&self.innovation[..outputs]);
        self.state.fill(0.0);
        self.driven.add_product(&z[..states + inputs], &mut self.state);
        self.corrected.add_product(&z[states + inputs + self.slopes..], &mut self.state);
    }

    /// L⁻¹ ν.
    pub fn whiten(&mut self, innovation: &[f64], whitened: &mut [f64]) {
        self.innovation.fill(0.0);
        self.whitener.add_product(innovation, &mut self.innovation);
        whitened.copy_from_slice(&self.innovation[..whitened.len()]);
    }
}
