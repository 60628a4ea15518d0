//! Sensitivities of the innovations to a record's own unknowns. They are the same for every record, because no sample
//! enters them.

use nalgebra::{DMatrix, DMatrixView};

use super::predictor::Predictor;
use super::products::{BLOCK, observed, propagate, whiten};
use crate::methods::structure::Structure;

/// Whitened sensitivities of the innovations to the own values `columns`, from a record's first sample on.
pub(super) struct OwnRows {
    /// Indices of the record's own values: x0, offsets, biases.
    pub columns: Vec<usize>,
    outputs: usize,
    /// Columns × (samples · outputs), with the outputs of a sample adjacent.
    rows: DMatrix<f64>,
    /// Information matrix of the first samples, with their number.
    information: Vec<(usize, DMatrix<f64>)>,
}

impl OwnRows {
    /// For records of the given `lengths`, samples.
    pub fn new(
        structure: &Structure,
        predictor: &Predictor,
        columns: Vec<usize>,
        lengths: impl Iterator<Item = usize>,
    ) -> Self {
        let (n, outputs, count) = (structure.states.len(), structure.outputs.len(), columns.len());
        let mut lengths: Vec<usize> = lengths.collect();
        lengths.sort_unstable();
        lengths.dedup();
        let longest = lengths.last().copied().unwrap_or(0);
        let mut own = Self {
            outputs,
            rows: DMatrix::zeros(count, longest * outputs),
            information: Vec::with_capacity(lengths.len()),
            columns,
        };
        if count > 0 {
            own.fill(structure, predictor, n);
        }
        let mut squares = DMatrix::zeros(count, count);
        let mut whole = 0;
        for length in lengths {
            while whole + BLOCK <= length {
                own.add(&mut squares, whole, BLOCK);
                whole += BLOCK;
            }
            let mut with_rest = squares.clone();
            own.add(&mut with_rest, whole, length - whole);
            own.information.push((length, with_rest));
        }
        own
    }

    fn fill(&mut self, structure: &Structure, predictor: &Predictor, n: usize) {
        let (count, p) = (self.columns.len(), self.outputs);
        let offsets = structure.offsets.len();
        let first_offset = predictor.gamma.ncols() - offsets;
        // Columns × states, with the sensitivities of a state adjacent; the constant forcing likewise.
        let mut sensitivity = vec![0.0; count * n];
        let mut steady = vec![0.0; count * n];
        let mut biased = vec![0.0; count * p];
        for (index, &own) in self.columns.iter().enumerate() {
            if own < n {
                sensitivity[own * count + index] = 1.0;
            } else if own < n + offsets {
                for row in 0..n {
                    steady[row * count + index] = predictor.gamma[(row, first_offset + own - n)];
                }
            } else {
                let output = structure.bias_rows[own - n - offsets];
                for row in 0..n {
                    steady[row * count + index] = -predictor.gain[(row, output)];
                }
                biased[output * count + index] = 1.0;
            }
        }
        let closed = predictor.closed.transpose();
        let mut next = steady.clone();
        let mut raw = vec![0.0; count * p];
        for rows in self.rows.as_mut_slice().chunks_exact_mut(count * p) {
            observed(predictor, &sensitivity, count, &mut raw);
            raw.iter_mut().zip(&biased).for_each(|(raw, bias)| *raw -= bias);
            whiten(predictor, &raw, count, rows, count);
            next.copy_from_slice(&steady);
            propagate(&closed, &sensitivity, &mut next, count);
            std::mem::swap(&mut sensitivity, &mut next);
        }
    }

    fn add(&self, squares: &mut DMatrix<f64>, first: usize, samples: usize) {
        let rows = self.of(first, samples);
        let (count, long) = rows.shape();
        if count == 0 || long == 0 {
            return;
        }
        let values = &self.rows.as_slice()[first * self.outputs * count..];
        let turned = DMatrixView::from_slice_with_strides(values, long, count, count, 1);
        squares.gemm(1.0, &rows, &turned, 1.0);
    }

    /// Columns × (samples · outputs) of `samples` samples from `first` on.
    pub fn of(&self, first: usize, samples: usize) -> DMatrixView<'_, f64> {
        self.rows.columns(first * self.outputs, samples * self.outputs)
    }

    /// Information matrix of the first `samples`, which must be one of the requested lengths.
    ///
    /// # Panics
    /// For any other number.
    pub fn information(&self, samples: usize) -> &DMatrix<f64> {
        let found = self.information.binary_search_by_key(&samples, |(length, _)| *length);
        &self.information[found.expect("a length that was asked for")].1
    }
}
