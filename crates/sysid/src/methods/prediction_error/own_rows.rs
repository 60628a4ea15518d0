//! Sensitivities of the innovations to a record's own unknowns. They are the same for every record, because no sample
//! enters them.

use nalgebra::{DMatrix, DMatrixView};

use super::predictor::Predictor;
use super::products::{BLOCK, Products, group};
use crate::methods::structure::Structure;

/// Whitened sensitivities of the innovations to the own values `columns`, from a record's first sample on.
pub(super) struct OwnRows {
    /// Indices of the record's own values: x0, offsets, biases.
    pub columns: Vec<usize>,
    outputs: usize,
    /// Columns × (samples · outputs), with the outputs of a sample adjacent.
    rows: Vec<f64>,
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
            rows: vec![0.0; count * longest * outputs],
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
        let group = group(count);
        let mut sensitivity = vec![0.0; group * n];
        let mut steady = vec![0.0; group * n];
        let mut biased = vec![0.0; group * p];
        for (index, &own) in self.columns.iter().enumerate() {
            if own < n {
                sensitivity[own * group + index] = 1.0;
            } else if own < n + offsets {
                for row in 0..n {
                    steady[row * group + index] = predictor.gamma[(row, first_offset + own - n)];
                }
            } else {
                let output = structure.bias_rows[own - n - offsets];
                biased[output * group + index] = 1.0;
            }
        }
        let mut products = Products::new(predictor, group);
        let mut next = steady.clone();
        let mut raw = vec![0.0; group * p];
        for rows in self.rows.chunks_exact_mut(count * p) {
            products.observe(&sensitivity, &mut raw);
            raw.iter_mut().zip(&biased).for_each(|(raw, bias)| *raw -= bias);
            products.whiten(&raw, count, rows, count);
            next.copy_from_slice(&steady);
            products.propagate(&sensitivity, &raw, &mut next);
            std::mem::swap(&mut sensitivity, &mut next);
        }
    }

    fn add(&self, squares: &mut DMatrix<f64>, first: usize, samples: usize) {
        let (count, long) = (self.columns.len(), samples * self.outputs);
        if count == 0 || long == 0 {
            return;
        }
        let values = self.of(first, samples);
        let rows = DMatrixView::from_slice(values, count, long);
        let turned = DMatrixView::from_slice_with_strides(values, long, count, count, 1);
        squares.gemm(1.0, &rows, &turned, 1.0);
    }

    /// Columns × (samples · outputs), column by column, of `samples` samples from `first` on.
    pub fn of(&self, first: usize, samples: usize) -> &[f64] {
        let each = self.outputs * self.columns.len();
        &self.rows[first * each..(first + samples) * each]
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
