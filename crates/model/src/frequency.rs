//! Frequency responses of a linear model at many frequencies.

use nalgebra::{Complex, DMatrix};

use super::linear::{LinearModel, TimeDomain};

/// A linear model with its A in Hessenberg form, prepared for many frequencies. One response takes about n² operations;
/// [`LinearModel::frequency_response`] takes about n³.
///
/// ```
/// use hovernav_model::shipped;
///
/// let model = shipped::raptor60();
/// let sweep = model.linear().sweep();
/// let [one, other] = [sweep.at(3.0).unwrap(), model.linear().frequency_response(3.0).unwrap()];
/// assert!((&one - &other).norm() < 1e-12 * other.norm());
/// ```
#[derive(Clone, Debug)]
pub struct FrequencySweep {
    time: TimeDomain,
    /// The matrix [−QᵀAQ, QᵀB], transposed so that each row of the equations is contiguous in memory. In each row the
    /// elements before the left neighbour of the diagonal are zero.
    equations: DMatrix<Complex<f64>>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
}

impl LinearModel {
    /// Prepares the model for many frequencies.
    #[must_use]
    pub fn sweep(&self) -> FrequencySweep {
        let Self { time, mut a, mut b, mut c, d } = self.clone();
        if a.nrows() > 1 {
            let (q, hessenberg) = a.hessenberg().unpack();
            (a, b, c) = (hessenberg, q.tr_mul(&b), c * q);
        }
        let (n, m) = b.shape();
        let equations = DMatrix::from_fn(n + m, n, |column, row| {
            Complex::from(if column < n { -a[(row, column)] } else { b[(row, column - n)] })
        });
        FrequencySweep { time, equations, c, d }
    }
}

impl FrequencySweep {
    /// C(zI − A)⁻¹B + D at `frequency_radps`, equal to [`LinearModel::frequency_response`].
    ///
    /// # Source
    /// Laub (1981), *Efficient multivariable frequency response computations*, IEEE Transactions on Automatic
    /// Control 26(2); equation (L12) of docs/equations.md.
    #[must_use]
    pub fn at(&self, frequency_radps: f64) -> Option<DMatrix<Complex<f64>>> {
        let z = self.time.variable(frequency_radps);
        let n = self.equations.ncols();
        let m = self.equations.nrows() - n;
        let mut rows = self.equations.clone();
        for k in 0..n {
            rows[(k, k)] += z;
        }
        // In column k only the rows k and k + 1 can contain the pivot.
        for k in 0..n.saturating_sub(1) {
            if rows[(k, k + 1)].norm_sqr() > rows[(k, k)].norm_sqr() {
                rows.swap_columns(k, k + 1);
            }
            let factor = rows[(k, k + 1)] / rows[(k, k)];
            if factor == Complex::ZERO {
                continue;
            }
            let (pivot, mut next) = rows.columns_range_pair_mut(k, k + 1);
            let next = next.as_mut_slice()[k..].iter_mut();
            for (value, above) in next.zip(&pivot.as_slice()[k..]) {
                *value -= factor * above;
            }
        }
        let mut states = DMatrix::<Complex<f64>>::zeros(n, m);
        for k in (0..n).rev() {
            let row = rows.column(k);
            let (left, right) = row.as_slice().split_at(n);
            for (mut column, value) in states.column_iter_mut().zip(right) {
                let column = column.as_mut_slice();
                let known: Complex<f64> = left[k + 1..]
                    .iter()
                    .zip(&column[k + 1..])
                    .map(|(own, state)| own * state)
                    .sum();
                column[k] = (value - known) / left[k];
            }
        }
        let mut response = DMatrix::zeros(self.d.nrows(), m);
        for ((output, input), value) in (0..m)
            .flat_map(|input| (0..self.d.nrows()).map(move |output| (output, input)))
            .zip(response.iter_mut())
        {
            let of_states: Complex<f64> =
                (0..n).map(|state| states[(state, input)] * self.c[(output, state)]).sum();
            *value = of_states + self.d[(output, input)];
        }
        response.iter().all(|value: &Complex<f64>| value.is_finite()).then_some(response)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shipped;
    use nalgebra::dmatrix;

    #[test]
    fn the_sweep_answers_as_one_frequency_by_itself_does() {
        for model in [shipped::raptor60(), shipped::mettler_r50(), shipped::thesis()] {
            let held = model.linear().held(0.03).unwrap();
            for linear in [model.linear(), &held] {
                let sweep = linear.sweep();
                for radps in [0.0, 0.01, 0.3, 2.0, 11.0, 60.0] {
                    let expected = linear.frequency_response(radps);
                    let found = sweep.at(radps);
                    if let (Some(found), Some(expected)) = (found, expected) {
                        assert!((found - &expected).norm() < 1e-9 * expected.norm(), "{radps}");
                    }
                }
            }
        }
    }

    #[test]
    fn models_of_no_state_one_and_two_and_poles_on_the_border_are_answered_too() {
        let one = |a, b, c, d| LinearModel { time: TimeDomain::Continuous, a, b, c, d };
        let lag = one(dmatrix![-2.0], dmatrix![2.0], dmatrix![1.0], dmatrix![0.5]);
        let at = lag.sweep().at(2.0).unwrap()[(0, 0)];
        assert!((at - Complex::new(1.0, -0.5)).norm() < 1e-15);
        let none =
            one(DMatrix::zeros(0, 0), DMatrix::zeros(0, 1), DMatrix::zeros(1, 0), dmatrix![3.0]);
        assert_eq!(none.sweep().at(1.0).unwrap()[(0, 0)], Complex::from(3.0));
        let swing = dmatrix![0.0, 1.0; -4.0, 0.0];
        let border = one(swing, dmatrix![0.0; 1.0], dmatrix![1.0, 0.0], dmatrix![0.0]).sweep();
        assert!(border.at(2.0).is_none());
        assert!((border.at(1.0).unwrap()[(0, 0)] - Complex::from(1.0 / 3.0)).norm() < 1e-15);
    }
}
