//! The products of a predictor's small matrices with sensitivities, sample by sample.

use nalgebra::DMatrix;

use super::predictor::Predictor;

/// Samples between two updates of the normal equations.
pub(super) const BLOCK: usize = 128;

/// −C s: effect of the state's sensitivities on the innovations, with those of an output adjacent.
pub(super) fn observed(
    predictor: &Predictor,
    sensitivity: &[f64],
    columns: usize,
    raw: &mut [f64],
) {
    let (p, n) = predictor.c.shape();
    raw.fill(0.0);
    for row in 0..p {
        let into = &mut raw[row * columns..(row + 1) * columns];
        for state in 0..n {
            let factor = predictor.c[(row, state)];
            if factor != 0.0 {
                add(into, -factor, &sensitivity[state * columns..(state + 1) * columns]);
            }
        }
    }
}

/// L⁻¹ times `raw`, in which the `columns` of an output are adjacent, written to `rows`, in which outputs are `stride`
/// apart.
pub(super) fn whiten(
    predictor: &Predictor,
    raw: &[f64],
    columns: usize,
    rows: &mut [f64],
    stride: usize,
) {
    for row in 0..predictor.c.nrows() {
        let into = &mut rows[row * stride..row * stride + columns];
        into.fill(0.0);
        for column in 0..=row {
            let factor = predictor.whitener[(row, column)];
            if factor != 0.0 {
                add(into, factor, &raw[column * columns..(column + 1) * columns]);
            }
        }
    }
}

/// next += F s, with `closed` = Fᵀ. The sensitivities of a state, `columns` of them, are adjacent. Four states are
/// processed at a time, because a general product would spend its time packing matrices this small.
pub(super) fn propagate(
    closed: &DMatrix<f64>,
    sensitivity: &[f64],
    next: &mut [f64],
    columns: usize,
) {
    if columns == 0 {
        return;
    }
    let states = closed.nrows();
    for (row, into) in next.chunks_exact_mut(columns).enumerate() {
        let factors = closed.column(row);
        let factors = factors.as_slice();
        let whole = states - states % 4;
        for first in (0..whole).step_by(4) {
            let [f0, f1, f2, f3] = [0, 1, 2, 3].map(|offset| factors[first + offset]);
            let (s0, rest) = sensitivity[first * columns..].split_at(columns);
            let (s1, rest) = rest.split_at(columns);
            let (s2, rest) = rest.split_at(columns);
            let s3 = &rest[..columns];
            for ((((into, a), b), c), d) in into.iter_mut().zip(s0).zip(s1).zip(s2).zip(s3) {
                *into += (f0 * a + f1 * b) + (f2 * c + f3 * d);
            }
        }
        for state in whole..states {
            add(into, factors[state], &sensitivity[state * columns..(state + 1) * columns]);
        }
    }
}

/// into += factor · from.
pub(super) fn add(into: &mut [f64], factor: f64, from: &[f64]) {
    for (into, from) in into.iter_mut().zip(from) {
        *into += factor * from;
    }
}
