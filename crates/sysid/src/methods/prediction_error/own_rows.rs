//! Sensitivities of the innovations to a record's own unknowns. They are the same for every record, because no sample
//! enters them.

use nalgebra::{DMatrix, DMatrixView};
use rayon::prelude::*;

use super::predictor::Predictor;
use super::products::{BLOCK, LANES, Products};
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
    /// The sensitivities for records of the given `lengths`, samples.
    pub fn new(
        structure: &Structure,
        predictor: &Predictor,
        columns: Vec<usize>,
        lengths: impl Iterator<Item = usize>,
    ) -> Self {
        let (outputs, count) = (structure.outputs.len(), columns.len());
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
            own.fill(structure, predictor);
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

    fn fill(&mut self, structure: &Structure, predictor: &Predictor) {
        let (count, p) = (self.columns.len(), self.outputs);
        let samples = self.rows.len() / (count * p);
        let parts: Vec<Vec<f64>> = self
            .columns
            .par_chunks(LANES)
            .map(|columns| rows_of(columns, structure, predictor, samples))
            .collect();
        let mut parts: Vec<_> = parts
            .iter()
            .zip(self.columns.chunks(LANES))
            .map(|(rows, own)| rows.chunks_exact(own.len()))
            .collect();
        for row in self.rows.chunks_exact_mut(count) {
            for (into, part) in row.chunks_mut(LANES).zip(&mut parts) {
                into.copy_from_slice(part.next().unwrap_or_default());
            }
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

/// Whitened sensitivities of `samples` samples to at most [`LANES`] own values: `columns` × (samples · outputs), column
/// by column.
fn rows_of(
    columns: &[usize],
    structure: &Structure,
    predictor: &Predictor,
    samples: usize,
) -> Vec<f64> {
    let (n, p) = (structure.states.len(), structure.outputs.len());
    let offsets = structure.offsets.len();
    let first_offset = predictor.gamma.ncols() - offsets;
    let mut sensitivity = vec![0.0; LANES * n];
    let mut steady = vec![0.0; LANES * n];
    let mut biased = vec![0.0; LANES * p];
    for (index, &own) in columns.iter().enumerate() {
        if own < n {
            sensitivity[own * LANES + index] = 1.0;
        } else if own < n + offsets {
            for row in 0..n {
                steady[row * LANES + index] = predictor.gamma[(row, first_offset + own - n)];
            }
        } else {
            let output = structure.bias_rows[own - n - offsets];
            biased[output * LANES + index] = 1.0;
        }
    }
    let count = columns.len();
    let mut products = Products::new(predictor, LANES);
    let mut next = steady.clone();
    let mut raw = vec![0.0; LANES * p];
    let mut all = vec![0.0; count * samples * p];
    for rows in all.chunks_exact_mut(count * p) {
        products.observe(&sensitivity, &mut raw);
        raw.iter_mut().zip(&biased).for_each(|(raw, bias)| *raw -= bias);
        products.whiten(&raw, count, rows, count);
        next.copy_from_slice(&steady);
        products.propagate(&sensitivity, &raw, &mut next);
        std::mem::swap(&mut sensitivity, &mut next);
    }
    all
}
