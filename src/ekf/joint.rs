//! Joint covariance of position, velocity and attitude.
#![expect(clippy::indexing_slicing, reason = "indices below the constant length of the arrays")]

use super::filter::Ekf;
use super::layout::{ATTITUDE, Layout, POSITION, VELOCITY};
use super::scalar::Scalar;
use crate::frames::Vector;

/// Number of errors: position, velocity and attitude, each north, east and down.
const ERRORS: usize = 9;

/// Covariance of the errors of a [`Solution`](super::Solution), true minus estimated. Position, m, and velocity, m/s,
/// are those of the solution's point. Attitude, rad, is the small rotation in NED from the estimated to the true body
/// axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointCovariance(pub [[f64; ERRORS]; ERRORS]);

impl JointCovariance {
    /// Squared error normalised by its covariance, eᵀ P⁻¹ e: 9 on average if the covariance is right. `None` if the
    /// covariance is singular or not positive definite.
    ///
    /// # Source
    /// Equation (K17) of docs/equations.md.
    #[must_use]
    pub fn normalised_squared(&self, error: &[f64; ERRORS]) -> Option<f64> {
        // Decomposition P = L D Lᵀ, column by column; then the sum of (L⁻¹ e)²/D.
        let mut factor = self.0;
        let mut left = *error;
        let mut sum = 0.0;
        for column in 0..ERRORS {
            let pivot = factor[column][column];
            // The comparison also rejects NaN. Rounding leaves at most this fraction of a variance.
            let is_positive = pivot > 1e-12 * self.0[column][column];
            if !is_positive {
                return None;
            }
            sum += left[column] * left[column] / pivot;
            let below: [f64; ERRORS] = core::array::from_fn(|row| factor[row][column]);
            for row in column + 1..ERRORS {
                let share = below[row] / pivot;
                left[row] -= share * left[column];
                for (value, other) in factor[row].iter_mut().zip(below).skip(column + 1) {
                    *value -= share * other;
                }
            }
        }
        sum.is_finite().then_some(sum)
    }
}

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Joint covariance of position, velocity and attitude at the point of the [`solution`](Self::solution). Consistent
    /// with the solution's one-sigmas of position and velocity.
    ///
    /// # Source
    /// Equations (K9) and (K11) of docs/equations.md.
    #[must_use]
    pub fn joint_covariance(&self) -> JointCovariance {
        let lever_arm = self.mounting.solution_from_imu();
        let body_to_ned = self.state.body_to_ned.cast();
        let arms = [
            body_to_ned * lever_arm.0,
            body_to_ned * lever_arm.relative_velocity(self.angular_rate_radps.cast()),
            Vector::ZERO,
        ];
        // δ(point) = δ(IMU) − [arm ×] ψ: the IMU's error, and two attitude errors with their factors.
        let mut terms = [[(0, 0.0); 3]; ERRORS];
        for (block, (first, arm)) in
            [POSITION, VELOCITY, ATTITUDE].into_iter().zip(arms).enumerate()
        {
            let arm = arm.to_array();
            for axis in 0..3 {
                let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
                terms[3 * block + axis] = [
                    (first + axis, 1.0),
                    (ATTITUDE + next, arm[last]),
                    (ATTITUDE + last, -arm[next]),
                ];
            }
        }
        let mut joint = [[0.0; ERRORS]; ERRORS];
        for (row, row_terms) in terms.iter().enumerate() {
            for (column, column_terms) in terms.iter().enumerate() {
                for &(i, a) in row_terms {
                    for &(j, b) in column_terms {
                        joint[row][column] += a * b * self.covariance.entry(i, j);
                    }
                }
            }
        }
        let [level_m, vertical_m] = self.ambiguity_m().map(f64::from);
        for (axis, ambiguity_m) in [level_m, level_m, vertical_m].into_iter().enumerate() {
            joint[axis][axis] += ambiguity_m * ambiguity_m;
        }
        JointCovariance(joint)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_joint_error_counts_by_its_own_covariance() {
        // P = A Aᵀ with a lower triangular A; for e = A u the normalised square is uᵀ u.
        let entry = |i: usize, j: usize| match i.cmp(&j) {
            core::cmp::Ordering::Less => 0.0,
            core::cmp::Ordering::Equal => 0.5 + 0.1 * i as f64,
            core::cmp::Ordering::Greater => 0.3 * ((i * 7 + j * 3) % 5) as f64 - 0.5,
        };
        let mut joint = JointCovariance([[0.0; ERRORS]; ERRORS]);
        let mut error = [0.0; ERRORS];
        let unit: [f64; ERRORS] = core::array::from_fn(|k| 1.0 - 0.3 * k as f64);
        for (i, (row, error)) in joint.0.iter_mut().zip(&mut error).enumerate() {
            for (j, value) in row.iter_mut().enumerate() {
                *value = (0..ERRORS).map(|k| entry(i, k) * entry(j, k)).sum();
            }
            *error = (0..ERRORS).map(|k| entry(i, k) * unit[k]).sum();
        }
        let expected: f64 = unit.iter().map(|value| value * value).sum();
        let found = joint.normalised_squared(&error).unwrap();
        assert!((found - expected).abs() < 1e-9 * expected, "{found} {expected}");
        assert_eq!(JointCovariance([[0.0; ERRORS]; ERRORS]).normalised_squared(&error), None);
        assert_eq!(JointCovariance([[f64::NAN; ERRORS]; ERRORS]).normalised_squared(&error), None);
        joint.0[4] = joint.0[3];
        joint.0.iter_mut().for_each(|row| row[4] = row[3]);
        assert_eq!(joint.normalised_squared(&error), None);
    }
}
