//! Sums of products in twice the working precision, for residuals far below the rounding of their terms.

use nalgebra::DMatrix;

/// A sum stored as a high and a low number, whose digits do not overlap.
///
/// # Source
/// Ogita, Rump and Oishi, *Accurate sum and dot product*, 2005.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    high: f64,
    low: f64,
}

impl Sum {
    fn add(&mut self, value: f64) {
        let sum = self.high + value;
        let back = sum - self.high;
        self.low += (self.high - (sum - back)) + (value - back);
        self.high = sum;
    }

    fn add_product(&mut self, one: f64, other: f64) {
        let product = one * other;
        self.low += one.mul_add(other, -product);
        self.add(product);
    }
}

/// A matrix whose elements are stored as a high and a low number each.
pub(super) struct DoubleDouble {
    pub high: DMatrix<f64>,
    low: DMatrix<f64>,
}

impl DoubleDouble {
    /// A matrix in working precision, with low numbers of zero.
    pub fn of(high: DMatrix<f64>) -> Self {
        let low = DMatrix::zeros(high.nrows(), high.ncols());
        Self { high, low }
    }

    /// A matrix of zeros.
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self::of(DMatrix::zeros(rows, columns))
    }

    fn from_sums(rows: usize, columns: usize, sum: impl Fn(usize, usize) -> Sum) -> Self {
        let (mut high, mut low) = (DMatrix::zeros(rows, columns), DMatrix::zeros(rows, columns));
        for column in 0..columns {
            for row in 0..rows {
                let sum = sum(row, column);
                high[(row, column)] = sum.high + sum.low;
                low[(row, column)] = (sum.high - high[(row, column)]) + sum.low;
            }
        }
        Self { high, low }
    }

    /// This matrix plus `sign` · `left`ᵀ · `right`, with `left` in working precision.
    pub fn plus_product(&self, sign: f64, left: &DMatrix<f64>, right: &Self) -> Self {
        Self::from_sums(self.high.nrows(), self.high.ncols(), |row, column| {
            let mut sum = Sum { high: self.high[(row, column)], low: self.low[(row, column)] };
            let terms = left.column(row);
            let high = right.high.column(column);
            let low = right.low.column(column);
            for ((&one, &high), &low) in terms.iter().zip(high.iter()).zip(low.iter()) {
                let one = sign * one;
                sum.add_product(one, high);
                sum.low += one * low;
            }
            sum
        })
    }

    /// This matrix plus `sign` · `other`.
    pub fn plus(&self, sign: f64, other: &Self) -> Self {
        Self::from_sums(self.high.nrows(), self.high.ncols(), |row, column| {
            let mut sum = Sum { high: self.high[(row, column)], low: self.low[(row, column)] };
            sum.add(sign * other.high[(row, column)]);
            sum.low += sign * other.low[(row, column)];
            sum
        })
    }

    /// The transpose.
    pub fn transpose(&self) -> Self {
        Self { high: self.high.transpose(), low: self.low.transpose() }
    }
}
