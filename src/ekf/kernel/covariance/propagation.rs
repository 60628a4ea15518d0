//! Propagation of the covariance over one step: P ← Φ P Φᵀ + Q, by the blocks of Φ that are neither zero nor one.
#![expect(
    clippy::indexing_slicing,
    clippy::needless_range_loop,
    reason = "every index is below the number of states, which `Layout` fixes for a whole loop, and stands \
              for a row as well as for a column"
)]

use super::Covariance;
use crate::ekf::kernel::layout::{ACCEL_BIAS, ATTITUDE, BASE, GYRO_BIAS, POSITION, VELOCITY};
use crate::scalar::Scalar;

/// One step of the error dynamics in discrete form: everything the propagation needs.
#[derive(Clone, Copy, Debug)]
pub struct Transition<T, const N: usize> {
    /// Length of the step, s.
    pub interval_s: T,
    /// Body-to-NED direction cosines times the step, rows north, east, down, s.
    pub turn: [[T; 3]; 3],
    /// Velocity change by specific force over the step, NED, m/s.
    pub force: [T; 3],
    /// Variance added to attitude over the step, NED, upper triangle by rows: nn, ne, nd, ee, ed, dd.
    pub attitude_noise: [T; 6],
    /// Variance added to velocity over the step, NED, upper triangle by rows, as in `attitude_noise`.
    pub velocity_noise: [T; 6],
    /// Variance added to position over the step, north, east, down.
    pub position_noise: [T; 3],
    /// Relaxation of the parameters since the previous one; `None` while the elapsed time is too short to matter.
    pub relaxation: Option<Relaxation<T, N>>,
}

/// Decay and noise of the parameters over time; they are Gauss–Markov processes or constants.
#[derive(Clone, Copy, Debug)]
pub struct Relaxation<T, const N: usize> {
    /// Factor by which each state decays. It is one for attitude, velocity and position, and for constants.
    pub decay: [T; N],
    /// Variance added to each state; unused for attitude, velocity and position.
    pub noise: [T; N],
}

impl<T: Scalar, const N: usize> Default for Relaxation<T, N> {
    /// No decay and no noise.
    fn default() -> Self {
        Self { decay: [T::ONE; N], noise: [T::ZERO; N] }
    }
}

impl<T: Scalar, const N: usize> Relaxation<T, N> {
    /// Adds to the variances of the parameters from `first` on; nothing decays.
    #[must_use]
    pub fn opening<const K: usize>(first: usize, variances: [f64; K]) -> Self {
        let mut relaxation = Self::default();
        for (noise, variance) in relaxation.noise.iter_mut().skip(first).zip(variances) {
            *noise = T::of(variance);
        }
        relaxation
    }
}

impl<T: Scalar, const N: usize> Transition<T, N> {
    /// Transition of zero duration that changes nothing.
    pub const NONE: Self = Self {
        interval_s: T::ZERO,
        turn: [[T::ZERO; 3]; 3],
        force: [T::ZERO; 3],
        attitude_noise: [T::ZERO; 6],
        velocity_noise: [T::ZERO; 6],
        position_noise: [T::ZERO; 3],
        relaxation: None,
    };

    /// Transition of zero duration that changes the parameters only.
    #[must_use]
    pub const fn of_relaxation(relaxation: Relaxation<T, N>) -> Self {
        Self { relaxation: Some(relaxation), ..Self::NONE }
    }

    /// Attitude part of Φ x; `at` gives a state of x.
    #[inline(always)]
    fn attitude(&self, at: &impl Fn(usize) -> T, axis: usize) -> T {
        let mut value = at(ATTITUDE + axis);
        for k in 0..3 {
            value -= self.turn[axis][k] * at(GYRO_BIAS + k);
        }
        value
    }

    /// Velocity part of Φ x.
    #[inline(always)]
    fn velocity(&self, at: &impl Fn(usize) -> T, axis: usize) -> T {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut value = at(VELOCITY + axis) + self.force[last] * at(ATTITUDE + next)
            - self.force[next] * at(ATTITUDE + last);
        for k in 0..3 {
            value -= self.turn[axis][k] * at(ACCEL_BIAS + k);
        }
        value
    }
}

/// Even column before the first parameter: vector operations handle pairs that start at even columns.
const EVEN: usize = GYRO_BIAS - 1;

impl<T: Scalar, const N: usize> Covariance<T, N> {
    /// P ← Φ P Φᵀ + Q over one step.
    ///
    /// Φ is the identity except for the blocks of [`Transition`]. Terms below 2e-4 per second are neglected: the
    /// rotation of NED (ω_in ψ, ω_in δv), and the change of gravity with height (3e-6 s⁻²). The change of Earth and
    /// transport rate with position and velocity (2e-7 rad/m) is neglected too. So is the second-order effect of an
    /// error within one step: a gyro bias reaches velocity half a step late.
    ///
    /// # Source
    /// Equations (K2) and (K3) of docs/equations.md.
    #[inline(never)]
    pub fn propagate(&mut self, step: &Transition<T, N>) {
        // Only biases drive the motion, and they come first among the parameters.
        self.mirror_up_to(BASE);
        self.mirrored = false;
        self.move_rows(step);
        self.close(step);
        self.add_noise(step);
        self.mirror_motion();
        if let Some(relaxation) = &step.relaxation {
            self.relax(relaxation);
        }
    }

    /// Applies decay and noise to the parameters.
    #[inline(never)]
    pub fn relax(&mut self, Relaxation { decay, noise }: &Relaxation<T, N>) {
        self.mirrored = false;
        let (_, parameters) = decay.split_at(EVEN);
        let (rows, parameter_rows) = self.rows.split_at_mut(GYRO_BIAS);
        for row in rows {
            let (_, row) = row.split_at_mut(EVEN);
            for (value, &other) in row.iter_mut().zip(parameters) {
                *value = *value * other;
            }
        }
        let own = decay.iter().zip(noise).enumerate().skip(GYRO_BIAS);
        for (row, (state, (&own, &noise))) in parameter_rows.iter_mut().zip(own) {
            let variance = row[state] * (own * own) + noise;
            let (_, right) = row.split_at_mut(EVEN);
            for (value, &other) in right.iter_mut().zip(parameters) {
                *value = *value * (own * other);
            }
            // The variance is stored in this loop, not in a separate one, so that wide vectors run along the rows
            // without gathers.
            row[state] = variance;
        }
    }

    /// P ← Φ P, column by column. Only the rows of attitude, velocity and position change.
    #[inline(always)]
    fn move_rows(&mut self, step: &Transition<T, N>) {
        let half = step.interval_s * T::of(0.5);
        let p = &mut self.rows;
        for column in 0..N {
            let at = |state: usize| p[state][column];
            let attitude: [T; 3] = core::array::from_fn(|axis| step.attitude(&at, axis));
            let velocity: [T; 3] = core::array::from_fn(|axis| step.velocity(&at, axis));
            let position: [T; 3] = core::array::from_fn(|axis| {
                at(POSITION + axis) + half * (at(VELOCITY + axis) + velocity[axis])
            });
            for axis in 0..3 {
                p[ATTITUDE + axis][column] = attitude[axis];
                p[VELOCITY + axis][column] = velocity[axis];
                p[POSITION + axis][column] = position[axis];
            }
        }
    }

    /// Computes the block of attitude, velocity and position of (Φ P) Φᵀ in place, upper triangle only. The input is
    /// the rows of Φ P. Each entry of Φ P is read before its result overwrites it.
    ///
    /// The result is symmetric. Velocity results below the diagonal are therefore read from above the diagonal. The
    /// results in the rows of position and columns of velocity are read from the rows of velocity.
    #[inline(always)]
    fn close(&mut self, step: &Transition<T, N>) {
        let half = step.interval_s * T::of(0.5);
        let p = &mut self.rows;
        for axis in 0..3 {
            let i = VELOCITY + axis;
            for other in 0..3 {
                let before = p[i][VELOCITY + other];
                let after = if other < axis {
                    p[VELOCITY + other][i]
                } else {
                    step.velocity(&|state| p[i][state], other)
                };
                p[i][POSITION + other] += half * (before + after);
                if other >= axis {
                    p[i][VELOCITY + other] = after;
                }
            }
        }
        for axis in 0..3 {
            let i = POSITION + axis;
            for other in 0..3 {
                if other >= axis {
                    let velocity = p[i][VELOCITY + other] + p[VELOCITY + other][i];
                    p[i][POSITION + other] += half * velocity;
                }
            }
        }
        for i in ATTITUDE..VELOCITY {
            let velocity: [T; 3] =
                core::array::from_fn(|axis| step.velocity(&|state| p[i][state], axis));
            for (axis, velocity) in velocity.into_iter().enumerate() {
                p[i][POSITION + axis] += half * (p[i][VELOCITY + axis] + velocity);
                p[i][VELOCITY + axis] = velocity;
            }
            for axis in 0..3 {
                if ATTITUDE + axis >= i {
                    p[i][ATTITUDE + axis] = step.attitude(&|state| p[i][state], axis);
                }
            }
        }
    }

    /// Mirrors the upper triangle of attitude, velocity and position.
    #[inline(always)]
    fn mirror_motion(&mut self) {
        let p = &mut self.rows;
        for i in 1..GYRO_BIAS {
            // Iterations: at most GYRO_BIAS.
            for j in 0..i {
                p[i][j] = p[j][i];
            }
        }
    }

    #[inline(always)]
    fn add_noise(&mut self, step: &Transition<T, N>) {
        self.add_upper::<ATTITUDE>(&step.attitude_noise);
        self.add_upper::<VELOCITY>(&step.velocity_noise);
        for (axis, &noise) in step.position_noise.iter().enumerate() {
            self.rows[POSITION + axis][POSITION + axis] += noise;
        }
    }

    /// Adds to the block of three states, upper triangle by rows.
    #[inline(always)]
    fn add_upper<const FIRST: usize>(&mut self, [nn, ne, nd, ee, ed, dd]: &[T; 6]) {
        let p = &mut self.rows;
        p[FIRST][FIRST] += *nn;
        p[FIRST][FIRST + 1] += *ne;
        p[FIRST][FIRST + 2] += *nd;
        p[FIRST + 1][FIRST + 1] += *ee;
        p[FIRST + 1][FIRST + 2] += *ed;
        p[FIRST + 2][FIRST + 2] += *dd;
    }
}
