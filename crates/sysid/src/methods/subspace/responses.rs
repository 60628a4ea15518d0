//! Recursions for regressors and derivatives.

use nalgebra::DMatrix;

/// Responses of the outputs to each of the `signals` (samples × signals) acting on each of the states. Rows are
/// outputs, sample by sample; columns are signal·order + state.
pub(super) fn forced_responses(
    a: &DMatrix<f64>,
    c: &DMatrix<f64>,
    signals: &DMatrix<f64>,
) -> DMatrix<f64> {
    let rows = signals.nrows() * c.nrows();
    let mut responses = DMatrix::zeros(rows, signals.ncols() * a.nrows());
    let mut recursion = Recursion::new(a, c);
    for (index, mut response) in responses.column_iter_mut().enumerate() {
        let signal = signals.column(index / a.nrows());
        recursion.run(index % a.nrows(), 0.0, signal.as_slice(), response.as_mut_slice());
    }
    responses
}

/// Responses of the outputs to a unit initial value of each state: rows as in [`forced_responses`].
pub(super) fn free_responses(a: &DMatrix<f64>, c: &DMatrix<f64>, samples: usize) -> DMatrix<f64> {
    let silence = vec![0.0; samples];
    let mut responses = DMatrix::zeros(samples * c.nrows(), a.nrows());
    let mut recursion = Recursion::new(a, c);
    for (state, mut response) in responses.column_iter_mut().enumerate() {
        recursion.run(state, 1.0, &silence, response.as_mut_slice());
    }
    responses
}

/// The recursion x(k+1) = A x(k) + e z(k), y(k) = C x(k), the inner loop of this module. z is the signal, e the unit
/// vector of the state that it drives.
struct Recursion {
    order: usize,
    outputs: usize,
    /// Matrix with A above C, stored column by column. One pass over it gives the next state and the output.
    columns: Vec<f64>,
    state: Vec<f64>,
    swept: Vec<f64>,
}

impl Recursion {
    fn new(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Self {
        let (order, outputs) = (a.nrows(), c.nrows());
        let columns = a
            .column_iter()
            .zip(c.column_iter())
            .flat_map(|(a, c)| a.iter().chain(c.iter()).copied().collect::<Vec<_>>())
            .collect();
        Self { order, outputs, columns, state: vec![0.0; order], swept: vec![0.0; order + outputs] }
    }

    /// Drives `state` with `signal`, starting it at `start` and all others at zero.
    fn run(&mut self, state: usize, start: f64, signal: &[f64], response: &mut [f64]) {
        self.state.fill(0.0);
        self.state[state] = start;
        for (push, output) in signal.iter().zip(response.chunks_exact_mut(self.outputs)) {
            self.swept.fill(0.0);
            let columns = self.columns.chunks_exact(self.order + self.outputs);
            for (value, column) in self.state.iter().zip(columns) {
                for (sum, entry) in self.swept.iter_mut().zip(column) {
                    *sum += value * entry;
                }
            }
            self.swept[state] += push;
            let (next, seen) = self.swept.split_at(self.order);
            self.state.copy_from_slice(next);
            output.copy_from_slice(seen);
        }
    }
}
