//! The transition of the error state: F as continuous error dynamics, and Φ over a step (K2).

use hovernav::ekf::layout::{ACCEL_BIAS, ATTITUDE, GYRO_BIAS, POSITION, VELOCITY};
use nalgebra::{Matrix3, SMatrix};

use crate::mechanization::{Vector, skew};

pub type Matrix<const N: usize> = SMatrix<f64, N, N>;

/// Motion over one step, or summed over several.
#[derive(Clone, Copy, Debug)]
pub struct Sums {
    pub seconds: f64,
    /// C at the start of the last step.
    pub cosines: Matrix3<f64>,
    /// Δv_f; its horizontal part counts by the fraction that is motion (K23).
    pub force_mps: Vector,
    /// Σ σ² of gyros, rad², and accelerometers, (m/s)², for each axis of the body (K4).
    pub angle_variance: Vector,
    pub velocity_variance: Vector,
}

impl Sums {
    /// The sum of the steps in `before` and this step.
    pub fn after(self, before: &Self) -> Self {
        Self {
            seconds: before.seconds + self.seconds,
            cosines: self.cosines,
            force_mps: before.force_mps + self.force_mps,
            angle_variance: before.angle_variance + self.angle_variance,
            velocity_variance: before.velocity_variance + self.velocity_variance,
        }
    }

    /// G, the effect of the integrals of all errors except position on attitude and velocity over the step: δψ⁺ = δψ +
    /// (G x)_ψ and δv⁺ = δv + (G x)_v. These are the error dynamics F of Groves (14.63 to 14.73) times Δt, without the
    /// terms below 2e-4 per second.
    fn driven<const N: usize>(&self) -> Matrix<N> {
        let mut g = Matrix::zeros();
        let turn = self.cosines * self.seconds;
        set(&mut g, ATTITUDE, GYRO_BIAS, &-turn);
        set(&mut g, VELOCITY, ATTITUDE, &-skew(&self.force_mps));
        set(&mut g, VELOCITY, ACCEL_BIAS, &-turn);
        g
    }

    /// Φ over the step (K2), before the parameters relax.
    pub fn transition<const N: usize>(&self) -> Matrix<N> {
        with_position(Matrix::identity() + self.driven(), self.seconds)
    }
}

/// Φ with its rows of position: δp⁺ = δp + ½ Δt (δv + δv⁺).
pub fn with_position<const N: usize>(mut phi: Matrix<N>, seconds: f64) -> Matrix<N> {
    for axis in 0..3 {
        let mut velocities = phi.row(VELOCITY + axis).into_owned();
        velocities[VELOCITY + axis] += 1.0;
        let mut position = velocities * (seconds / 2.0);
        position[POSITION + axis] += 1.0;
        phi.set_row(POSITION + axis, &position);
    }
    phi
}

/// Writes a block of three by three into a matrix.
pub fn set<const N: usize>(of: &mut Matrix<N>, row: usize, column: usize, block: &Matrix3<f64>) {
    of.fixed_view_mut::<3, 3>(row, column).copy_from(block);
}
