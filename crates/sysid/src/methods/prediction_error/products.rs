//! Products of a predictor's matrices with sensitivities, sample by sample.
//!
//! The sensitivities of a state or an output to all parameters are adjacent: a group. Zeros fill a group up to a
//! multiple of [`LANES`].

use nalgebra::{DMatrix, DMatrixView};
use wide::f64x8;

use super::predictor::Predictor;

/// Number of samples between two updates of the normal equations.
pub(super) const BLOCK: usize = 128;

/// Number of sensitivities that the processor's registers hold during a sum. For matrices this small, a general product
/// would spend most of its time on copying.
pub(super) const LANES: usize = 8;

/// Length of the group of `count` sensitivities.
pub(super) fn group(count: usize) -> usize {
    count.next_multiple_of(LANES)
}

/// The matrices of a predictor, for groups of one length.
pub(super) struct Products {
    group: usize,
    /// Φ, which has fewer entries than F.
    free: Rows,
    /// K.
    gain: Rows,
    /// −C.
    observed: Rows,
    /// L⁻¹.
    whitener: Rows,
    whitened: Vec<f64>,
}

impl Products {
    pub fn new(predictor: &Predictor, group: usize) -> Self {
        Self {
            group,
            free: Rows::of(&predictor.phi),
            gain: Rows::of(&predictor.gain),
            observed: Rows::of(&-&predictor.c),
            whitener: Rows::of(&predictor.whitener),
            whitened: vec![0.0; predictor.c.nrows() * group],
        }
    }

    /// next += Φ s + K dν, with `raw` = dν.
    pub fn propagate(&self, sensitivity: &[f64], raw: &[f64], next: &mut [f64]) {
        self.free.add_product(sensitivity, next, self.group);
        self.gain.add_product(raw, next, self.group);
    }

    /// −C s: effect of the state's sensitivities on the innovations.
    pub fn observe(&self, sensitivity: &[f64], raw: &mut [f64]) {
        raw.fill(0.0);
        self.observed.add_product(sensitivity, raw, self.group);
    }

    /// L⁻¹ times `raw`: the first `count` of each group, written to `rows`, `stride` apart.
    pub fn whiten(&mut self, raw: &[f64], count: usize, rows: &mut [f64], stride: usize) {
        self.whitened.fill(0.0);
        self.whitener.add_product(raw, &mut self.whitened, self.group);
        let groups = self.whitened.chunks_exact(self.group);
        for (into, group) in rows.chunks_mut(stride).zip(groups) {
            into[..count].copy_from_slice(&group[..count]);
        }
    }
}

/// The entries of a matrix that are not zero, row by row, each with its column.
struct Rows(Vec<Vec<(usize, f64)>>);

impl Rows {
    fn of(matrix: &DMatrix<f64>) -> Self {
        let present = |row| {
            let entries = (0..matrix.ncols()).map(move |column| (column, matrix[(row, column)]));
            entries.filter(|(_, value)| *value != 0.0).collect()
        };
        Self((0..matrix.nrows()).map(present).collect())
    }

    /// into += M · from, whose rows are groups.
    fn add_product(&self, from: &[f64], into: &mut [f64], group: usize) {
        let blocks = group / LANES;
        if blocks == 0 {
            return;
        }
        let (from, _) = from.as_chunks::<LANES>();
        let (into, _) = into.as_chunks_mut::<LANES>();
        for (row, into) in self.0.iter().zip(into.chunks_exact_mut(blocks)) {
            for (block, into) in into.iter_mut().enumerate() {
                let mut sum = f64x8::new(*into);
                for &(column, factor) in row {
                    sum += f64x8::new(from[column * blocks + block]) * factor;
                }
                *into = sum.to_array();
            }
        }
    }
}

/// A matrix whose columns are groups.
pub(super) struct Columns {
    group: usize,
    values: Vec<f64>,
}

impl Columns {
    /// The columns of `matrices`, which have equal numbers of rows.
    pub fn of(matrices: &[DMatrixView<'_, f64>]) -> Self {
        let group = matrices.first().map_or(0, |matrix| group(matrix.nrows()));
        let mut values = Vec::new();
        for column in matrices.iter().flat_map(DMatrixView::column_iter) {
            values.extend(column.iter());
            values.resize(values.len().next_multiple_of(LANES), 0.0);
        }
        Self { group, values }
    }

    /// into += M · values, a group.
    pub fn add_product(&self, values: &[f64], into: &mut [f64]) {
        let (columns, _) = self.values.as_chunks::<LANES>();
        let (into, _) = into.as_chunks_mut::<LANES>();
        let blocks = self.group / LANES;
        for (block, into) in into[..blocks].iter_mut().enumerate() {
            let mut sum = f64x8::new(*into);
            for (column, &value) in values.iter().enumerate() {
                sum += f64x8::new(columns[column * blocks + block]) * value;
            }
            *into = sum.to_array();
        }
    }
}
