//! The measurement update in its textbook form: scalar rows in sequence, Joseph's covariance, error injection.

use hovernav::ekf::Channel;
use nalgebra::{SVector, UnitQuaternion};

use crate::filter::Filter;
use crate::mechanization::{Earth, Vector};
use crate::transition::Matrix;
use hovernav::ekf::layout::{ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};

/// One axis of a measurement: measured minus predicted, its row of H, its variance R.
#[derive(Clone, Copy, Debug)]
pub struct Row<const N: usize> {
    pub channel: Channel,
    pub innovation: f64,
    pub h: SVector<f64, N>,
    pub noise: f64,
}

/// An innovation after fusing the axes before it, and its one-sigma.
#[derive(Clone, Copy, Debug)]
pub struct Compared {
    pub channel: Channel,
    pub innovation: f64,
    pub sigma: f64,
    /// One-sigma of the innovation before any axis of the same time is fused, as if the states were uncorrelated.
    pub sigma_before: f64,
}

impl<const N: usize> Row<N> {
    /// An axis without derivatives yet.
    pub fn new(channel: Channel, innovation: f64, noise: f64) -> Self {
        Self { channel, innovation, h: SVector::zeros(), noise }
    }

    /// Adds the derivative ∂z/∂x by one state.
    #[must_use]
    pub fn sees(mut self, state: usize, derivative: f64) -> Self {
        self.h[state] += derivative;
        self
    }

    /// Adds the derivatives of three consecutive states.
    #[must_use]
    pub fn sees_block(mut self, first: usize, derivatives: [f64; 3]) -> Self {
        for (axis, derivative) in derivatives.into_iter().enumerate() {
            self.h[first + axis] += derivative;
        }
        self
    }
}

/// One scalar row (K6), with Joseph's form of the covariance: P⁺ = (I − K H) P (I − K H)ᵀ + K R Kᵀ. Returns the gain.
pub fn joseph<const N: usize>(p: &mut Matrix<N>, row: &Row<N>) -> SVector<f64, N> {
    let seen = *p * row.h;
    let gain = seen / (row.h.dot(&seen) + row.noise);
    let left = Matrix::identity() - gain * row.h.transpose();
    *p = left * *p * left.transpose() + gain * gain.transpose() * row.noise;
    gain
}

impl<L: Layout<N>, const N: usize> Filter<L, N> {
    /// Fuses the `accepted` rows one after another, and corrects the state by all of them together.
    pub fn fuse(&mut self, rows: &[Row<N>], accepted: &[bool]) -> Vec<Compared> {
        let mut correction = SVector::<f64, N>::zeros();
        let mut compared = Vec::new();
        let before = self.covariance.diagonal();
        for (row, &accepted) in rows.iter().zip(accepted) {
            let innovation = row.innovation - row.h.dot(&correction);
            let variance = row.h.dot(&(self.covariance * row.h)) + row.noise;
            compared.push(Compared {
                channel: row.channel,
                innovation,
                sigma: variance.sqrt(),
                sigma_before: (row.h.component_mul(&row.h).dot(&before) + row.noise).sqrt(),
            });
            if accepted {
                correction += joseph(&mut self.covariance, row) * innovation;
            }
        }
        self.inject(&correction);
        compared
    }

    /// Adds an error state to the estimates (K1). The attitude error is then zero again. Its covariance is not turned
    /// by half of the correction, as in Solà (section 7.2.2: zero to first order).
    fn inject(&mut self, error: &SVector<f64, N>) {
        let block = |first: usize| Vector::new(error[first], error[first + 1], error[first + 2]);
        let nominal = &mut self.nominal;
        let turned = UnitQuaternion::from_scaled_axis(block(ATTITUDE));
        nominal.attitude = turned * nominal.attitude;
        nominal.attitude.renormalize();
        nominal.velocity_mps += block(VELOCITY);
        nominal.place = Earth::at(&nominal.place).displaced(&nominal.place, &block(POSITION));
        for state in GYRO_BIAS..N {
            self.parameters[state] += error[state];
        }
    }
}

mod tests {
    use nalgebra::{SMatrix, SVector};

    use super::*;

    /// Uncorrelated axes may be fused one after another or all at once: K = P Hᵀ (H P Hᵀ + R)⁻¹.
    #[test]
    fn rows_in_sequence_are_the_update_by_all_of_them() {
        let root = Matrix::<4>::from_fn(|i, j| {
            ((i * 7 + j * 3) % 5) as f64 - 1.5 + f64::from(u8::from(i == j))
        });
        let before = root * root.transpose();
        let h = SMatrix::<f64, 2, 4>::from_fn(|i, j| ((i * 5 + j * 2) % 3) as f64 - 0.7);
        let r = SVector::<f64, 2>::new(0.3, 0.8);
        let s = h * before * h.transpose() + SMatrix::from_diagonal(&r);
        let gain = before * h.transpose() * s.try_inverse().unwrap();
        let at_once = before - gain * h * before;
        let mut in_sequence = before;
        for axis in 0..2 {
            let mut row = Row::new(Channel::Yaw, 0.0, r[axis]);
            row.h = h.row(axis).transpose();
            joseph(&mut in_sequence, &row);
        }
        assert!((at_once - in_sequence).norm() < 1e-12 * before.norm());
    }
}
