//! Sensitivities of a fix's six axes. Terms that several axes have in common are stored once.
#![expect(
    clippy::indexing_slicing,
    reason = "axes count from 0 to 2, in arrays of three; measurements from 0 to 5, in arrays of six"
)]

use super::sensitivity::MAX_AXES;
use super::{Covariance, Sensitivity};
use crate::ekf::kernel::layout::{ACCEL_BIAS, ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use crate::scalar::Scalar;

/// Sensitivity of three axes of a fix, north, east and down, to states other than their own error.
#[derive(Clone, Copy, Debug)]
pub struct AxesSensitivity<T> {
    /// Vector w: the axes observe w × ψ, with the attitude error ψ.
    pub turning: [T; 3],
    /// Sensitivity to the gyro biases, one row per axis.
    pub gyro_bias: [[T; 3]; 3],
    /// Sensitivity to the accelerometer biases.
    pub accel_bias: [[T; 3]; 3],
    /// Sensitivity to the delay of the fix; of a position also to its latency.
    pub delay: [T; 3],
}

/// The sensitivities of velocity and position of a fix.
///
/// # Source
/// Equations (M3) and (M4) of docs/equations.md.
#[derive(Clone, Copy, Debug)]
pub struct FixSensitivity<T> {
    /// Sensitivity of the velocity.
    pub velocity: AxesSensitivity<T>,
    /// Sensitivity of the position.
    pub position: AxesSensitivity<T>,
    /// Age of the position, s.
    pub age_s: T,
}

// Written out: as a fold over any number of elements it takes 0.7 kB more of program.
#[inline(always)]
fn dot<T: Scalar>([a, b, c]: [T; 3], [x, y, z]: [T; 3]) -> T {
    a * x + b * y + c * z
}

impl<T: Scalar> AxesSensitivity<T> {
    /// Part of H x from attitude and biases; `at` gives a state's error.
    #[inline(always)]
    fn of_motion(&self, at: &impl Fn(usize) -> T) -> [T; 3] {
        let three = |first: usize| [at(first), at(first + 1), at(first + 2)];
        let (turned, gyro, accel) = (three(ATTITUDE), three(GYRO_BIAS), three(ACCEL_BIAS));
        let ([u, v, w], [p, q, r]) = (self.turning, turned);
        let [x, y, z] = [v * r - w * q, w * p - u * r, u * q - v * p];
        let [a, b, c] = self.gyro_bias.map(|row| dot(row, gyro));
        let [d, e, f] = self.accel_bias.map(|row| dot(row, accel));
        [x + a + d, y + b + e, z + c + f]
    }
}

impl<T: Scalar> FixSensitivity<T> {
    /// H x for the axes of velocity; `at` gives a state of x.
    #[inline(always)]
    fn velocity<L: Layout<N>, const N: usize>(&self, at: &impl Fn(usize) -> T) -> [T; 3] {
        let seen = self.velocity.of_motion(at);
        core::array::from_fn(|axis| {
            let mut seen = seen[axis] + at(VELOCITY + axis);
            if let Some(first) = L::GPS_VELOCITY {
                seen += at(first + axis);
            }
            if let Some(state) = L::GPS_DELAY {
                seen += self.velocity.delay[axis] * at(state);
            }
            seen
        })
    }

    /// H x for the axes of position.
    #[inline(always)]
    fn position<L: Layout<N>, const N: usize>(&self, at: &impl Fn(usize) -> T) -> [T; 3] {
        let seen = self.position.of_motion(at);
        core::array::from_fn(|axis| {
            let mut seen = seen[axis] + at(POSITION + axis) - self.age_s * at(VELOCITY + axis);
            if let Some(first) = L::GPS_POSITION {
                seen += at(first + axis);
            }
            for state in [L::LATENCY, L::GPS_DELAY].into_iter().flatten() {
                seen += self.position.delay[axis] * at(state);
            }
            seen
        })
    }

    /// P Hᵀ of each axis, and H P Hᵀ of each axis with itself and all later axes. The covariance must be mirrored.
    #[inline(never)]
    pub(super) fn project<L: Layout<N>, const N: usize>(
        &self,
        covariance: &Covariance<T, N>,
        projected: &mut [[T; N]; MAX_AXES],
        seen: &mut [[T; MAX_AXES]; MAX_AXES],
    ) {
        // Velocity first, then position: both together need more values than there are registers.
        let [a, b, c, d, e, f] = projected;
        for state in 0..N {
            let at = |of: usize| covariance.mirrored_value(of, state);
            [a[state], b[state], c[state]] = self.velocity::<L, N>(&at);
        }
        for state in 0..N {
            let at = |of: usize| covariance.mirrored_value(of, state);
            [d[state], e[state], f[state]] = self.position::<L, N>(&at);
        }
        for (behind, projected) in projected.iter().enumerate() {
            let at = |of: usize| projected.get(of).copied().unwrap_or(T::ZERO);
            let velocity = self.velocity::<L, N>(&at);
            for (row, value) in seen.iter_mut().zip(velocity) {
                row[behind] = value;
            }
            if behind >= velocity.len() {
                let position = self.position::<L, N>(&at);
                for (row, value) in seen.iter_mut().skip(velocity.len()).zip(position) {
                    row[behind] = value;
                }
            }
        }
    }

    /// The row of H of one axis, in the order velocity north, east, down, position north, east, down.
    #[inline(always)]
    pub(super) fn row<L: Layout<N>, const N: usize>(&self, index: usize) -> Sensitivity<T> {
        let mut row = Sensitivity::default();
        for state in 0..N {
            let at = |of: usize| if of == state { T::ONE } else { T::ZERO };
            let [a, b, c] = self.velocity::<L, N>(&at);
            let [d, e, f] = self.position::<L, N>(&at);
            row.add(state, [a, b, c, d, e, f][index.min(MAX_AXES - 1)]);
        }
        row
    }
}
