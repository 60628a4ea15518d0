//! Linear least squares that tolerates linearly dependent columns.

use nalgebra::DMatrix;

/// Ratio of diagonal elements of the triangular factor, smallest to largest, below which columns count as dependent.
const DEPENDENT: f64 = 1e-11;

/// The x that minimises ‖a x − b‖. If columns of `a` are dependent, it is the solution of smallest norm with all
/// columns scaled to unit length. `a` is rows × unknowns, `b` rows × right-hand sides.
#[must_use]
pub fn least_squares(mut a: DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let norms: Vec<f64> = a.column_iter().map(|column| column.norm()).collect();
    for (mut column, norm) in a.column_iter_mut().zip(&norms) {
        if *norm > 0.0 {
            column /= *norm;
        }
    }
    let mut solution = solve(a, b);
    for (mut row, norm) in solution.row_iter_mut().zip(&norms) {
        if *norm > 0.0 {
            row /= *norm;
        }
    }
    solution
}

/// A and B of a tall problem, reduced to as many rows as columns. AᵀA, AᵀB and the solution stay the same. The
/// reduction rotates A and B together in blocks that fit in the cache.
fn condensed(a: DMatrix<f64>, b: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    /// Number of rows rotated at a time, per column. Larger blocks are not faster.
    const BLOCK: usize = 16;
    /// Smallest number of rows rotated at a time.
    const MIN: usize = 512;
    let (unknowns, sides) = (a.ncols(), b.ncols());
    let block = MIN.max(BLOCK * (unknowns + sides));
    if a.nrows() <= 2 * block {
        return (a, b.clone());
    }
    let mut rotated = DMatrix::zeros(0, unknowns + sides);
    for first in (0..a.nrows()).step_by(block) {
        let (above, length) = (rotated.nrows(), block.min(a.nrows() - first));
        let mut both = rotated.resize_vertically(above + length, 0.0);
        both.view_mut((above, 0), (length, unknowns)).copy_from(&a.rows(first, length));
        both.view_mut((above, unknowns), (length, sides)).copy_from(&b.rows(first, length));
        rotated = both.qr().unpack_r();
    }
    (rotated.columns(0, unknowns).into_owned(), rotated.columns(unknowns, sides).into_owned())
}

fn solve(a: DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let (a, b) = condensed(a, b);
    let unknowns = a.ncols();
    if a.nrows() >= unknowns {
        let qr = a.clone().qr();
        let r = qr.r();
        let diagonal = r.diagonal().abs();
        if unknowns == 0 || diagonal.min() > DEPENDENT * diagonal.max() {
            let mut rotated = b.clone();
            qr.q_tr_mul(&mut rotated);
            let top = rotated.rows(0, unknowns).into_owned();
            if let Some(solution) = r.solve_upper_triangular(&top) {
                return solution;
            }
        }
    }
    let svd = a.svd(true, true);
    let tolerance = DEPENDENT * svd.singular_values.max();
    svd.solve(&b, tolerance).unwrap_or_else(|_| DMatrix::zeros(unknowns, b.ncols()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use nalgebra::dmatrix;

    #[test]
    fn a_tall_problem_is_solved_as_a_short_one() {
        let rows = 5000;
        let a = DMatrix::from_fn(rows, 3, |row, column| ((row * (column + 2)) as f64).sin());
        let x = dmatrix![1.0, -2.0; 0.5, 3.0; -1.0, 0.1];
        let off = DMatrix::from_fn(rows, 2, |row, side| ((row * row * (side + 1)) as f64).cos());
        let b = &a * &x + off;
        let found = least_squares(a.clone(), &b);
        let normal = (a.tr_mul(&a)).cholesky().unwrap().solve(&a.tr_mul(&b));
        assert_abs_diff_eq!(found, normal, epsilon = 1e-12);
    }

    #[test]
    fn dependent_columns_share_the_work() {
        let a = dmatrix![1.0, 1.0, 0.0; 2.0, 2.0, 1.0; 3.0, 3.0, 0.0; 4.0, 4.0, -1.0];
        let x = least_squares(a.clone(), &dmatrix![2.0; 7.0; 6.0; 5.0]);
        assert!((x - dmatrix![1.0; 1.0; 3.0]).norm() < 1e-12);
        let none = least_squares(a * 0.0, &dmatrix![1.0; 1.0; 1.0; 1.0]);
        assert!(none.norm() == 0.0);
    }
}
