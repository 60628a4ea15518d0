//! The covariance over one step: P ← Φ P Φᵀ + Q, by the blocks of Φ that are not zero or one.
#![expect(
    clippy::indexing_slicing,
    reason = "every index is below the number of states, which `Layout` fixes for a whole loop"
)]

use super::super::layout::{ACCEL_BIAS, ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use super::super::scalar::Scalar;
use super::{Covariance, add_scaled};

/// One step of the error dynamics in discrete form: everything the propagation needs.
#[derive(Clone, Copy, Debug)]
pub struct Transition<T, const N: usize> {
    /// Length of the step, s.
    pub interval_s: T,
    /// Body-to-NED direction cosines times the step, rows north, east, down, s.
    pub turn: [[T; 3]; 3],
    /// Velocity change by specific force over the step, NED, m/s.
    pub force: [T; 3],
    /// Direction cosines times the rotation increment of each gyro (scale factor errors), rad.
    pub scaled_rotation: [[T; 3]; 3],
    /// Direction cosines times the velocity increment of each accelerometer, m/s.
    pub scaled_velocity: [[T; 3]; 3],
    /// Factor by which each state decays over the step: one but for Gauss–Markov states.
    pub decay: [T; N],
    /// Variance added to attitude over the step, NED, upper triangle by rows: nn, ne, nd, ee, ed, dd.
    pub attitude_noise: [T; 6],
    /// Variance added to velocity over the step, like `attitude_noise`.
    pub velocity_noise: [T; 6],
    /// Variance added to each other state over the step (the first six are not used).
    pub noise: [T; N],
}

/// The column before the parameters: packed operations come two by two, and start at even columns.
const EVEN: usize = GYRO_BIAS - 1;

impl<T: Scalar, const N: usize> Covariance<T, N> {
    /// P ← Φ P Φᵀ + Q over one step.
    ///
    /// Φ is the identity but for the blocks of [`Transition`]; terms under 2e-4 per second are left
    /// out: the turning of NED (ω_in ψ, ω_in δv), the change of gravity with height (3e-6 s⁻²) and
    /// of Earth and transport rate with position and velocity (2e-7 rad/m). So is the second effect
    /// of an error within one step (a gyro bias on velocity: half a step late).
    ///
    /// # Source
    /// Equations (K2) and (K3) of docs/equations.md.
    pub fn propagate<L: Layout<N>>(&mut self, step: &Transition<T, N>) {
        let moved = self.moved_rows::<L>(step);
        let (rows, parameter_rows) = self.rows.split_at_mut(GYRO_BIAS);
        let (_, decay) = step.decay.split_at(EVEN);
        for (j, row) in parameter_rows.iter_mut().enumerate() {
            let own = step.decay[GYRO_BIAS + j];
            let (_, parameters) = row.split_at_mut(EVEN);
            for (value, &other) in parameters.iter_mut().zip(decay) {
                *value = *value * (own * other);
            }
            for (value, moved) in row.iter_mut().zip(&moved) {
                *value = moved[GYRO_BIAS + j] * own;
            }
        }
        for (row, moved) in rows.iter_mut().zip(&moved) {
            for ((value, &moved), &decay) in row.iter_mut().zip(moved).zip(&step.decay) {
                *value = moved * decay;
            }
        }
        self.close::<L>(step, &moved);
        self.add_noise(step);
    }

    /// The nine rows of Φ P that are not just decayed rows of P.
    #[inline(always)]
    fn moved_rows<L: Layout<N>>(&self, step: &Transition<T, N>) -> [[T; N]; GYRO_BIAS] {
        let p = &self.rows;
        let half = step.interval_s * T::of(0.5);
        let mut moved = [[T::ZERO; N]; GYRO_BIAS];
        for axis in 0..3 {
            let mut attitude = p[ATTITUDE + axis];
            for k in 0..3 {
                add_scaled(&mut attitude, -step.turn[axis][k], &p[GYRO_BIAS + k]);
            }
            let mut velocity = p[VELOCITY + axis];
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            add_scaled(&mut velocity, step.force[last], &p[ATTITUDE + next]);
            add_scaled(&mut velocity, -step.force[next], &p[ATTITUDE + last]);
            for k in 0..3 {
                add_scaled(&mut velocity, -step.turn[axis][k], &p[ACCEL_BIAS + k]);
            }
            if let Some(scale) = L::GYRO_SCALE {
                for k in 0..3 {
                    add_scaled(&mut attitude, -step.scaled_rotation[axis][k], &p[scale + k]);
                }
            }
            if let Some(scale) = L::ACCEL_SCALE {
                for k in 0..3 {
                    add_scaled(&mut velocity, -step.scaled_velocity[axis][k], &p[scale + k]);
                }
            }
            let mut position = p[POSITION + axis];
            add_scaled(&mut position, half, &p[VELOCITY + axis]);
            add_scaled(&mut position, half, &velocity);
            moved[ATTITUDE + axis] = attitude;
            moved[VELOCITY + axis] = velocity;
            moved[POSITION + axis] = position;
        }
        moved
    }

    /// The block of attitude, velocity and position of (Φ P) Φᵀ from the moved rows: its upper
    /// triangle by blocks of three, and their mirror.
    #[inline(always)]
    fn close<L: Layout<N>>(&mut self, step: &Transition<T, N>, moved: &[[T; N]; GYRO_BIAS]) {
        let half = step.interval_s * T::of(0.5);
        let p = &mut self.rows;
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let (attitude, velocity) = (ATTITUDE + axis, VELOCITY + axis);
            let position = POSITION + axis;
            for (i, row) in moved.iter().enumerate().take(VELOCITY) {
                let mut value = row[attitude];
                for k in 0..3 {
                    value -= step.turn[axis][k] * row[GYRO_BIAS + k];
                }
                if let Some(scale) = L::GYRO_SCALE {
                    for k in 0..3 {
                        value -= step.scaled_rotation[axis][k] * row[scale + k];
                    }
                }
                (p[i][attitude], p[attitude][i]) = (value, value);
            }
            for (i, row) in moved.iter().enumerate().take(POSITION) {
                let mut value = row[velocity] + step.force[last] * row[ATTITUDE + next]
                    - step.force[next] * row[ATTITUDE + last];
                for k in 0..3 {
                    value -= step.turn[axis][k] * row[ACCEL_BIAS + k];
                }
                if let Some(scale) = L::ACCEL_SCALE {
                    for k in 0..3 {
                        value -= step.scaled_velocity[axis][k] * row[scale + k];
                    }
                }
                (p[i][velocity], p[velocity][i]) = (value, value);
                let value = row[position] + half * (row[velocity] + value);
                (p[i][position], p[position][i]) = (value, value);
            }
        }
        for axis in 0..3 {
            let (velocity, position) = (VELOCITY + axis, POSITION + axis);
            for (i, row) in moved.iter().enumerate().skip(POSITION) {
                // Velocity's column is done: its mirror stands in this row.
                let value = row[position] + half * (row[velocity] + p[i][velocity]);
                (p[i][position], p[position][i]) = (value, value);
            }
        }
    }

    #[inline(always)]
    fn add_noise(&mut self, step: &Transition<T, N>) {
        for (first, noise) in [(ATTITUDE, &step.attitude_noise), (VELOCITY, &step.velocity_noise)] {
            let [nn, ne, nd, ee, ed, dd] = *noise;
            let block = [[nn, ne, nd], [ne, ee, ed], [nd, ed, dd]];
            for (i, line) in block.iter().enumerate() {
                for (j, &value) in line.iter().enumerate() {
                    self.rows[first + i][first + j] += value;
                }
            }
        }
        for i in POSITION..N {
            self.rows[i][i] += step.noise[i];
        }
    }
}
