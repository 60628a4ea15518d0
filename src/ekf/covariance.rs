//! The covariance of the error state and the two kernels that move it.
//!
//! Stored whole and symmetric, row-major: rows are contiguous, so both kernels are sums of scaled
//! rows that the compiler turns into vector instructions. Propagation uses the blocks of the
//! transition that are not zero or one; a scalar update is Bierman's stabilised form, which keeps
//! the matrix positive where the short form P − k vᵀ loses that to rounding.
//!
//! # Source
//! Groves, second edition, equations 14.63 to 14.73 (error dynamics in NED); G. J. Bierman (1977),
//! *Factorization Methods for Discrete Sequential Estimation*, section V.3 (stabilised update).

use super::layout::{ACCEL_BIAS, ATTITUDE, BASE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use super::scalar::Scalar;

/// Covariance of the error state, units those of the states; always exactly symmetric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covariance<T, const N: usize> {
    rows: [[T; N]; N],
}

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

/// The row of H of a scalar measurement: the few states it sees.
#[derive(Clone, Copy, Debug)]
pub struct Sensitivity<T> {
    terms: [(usize, T); 20],
    count: usize,
}

impl<T: Scalar> Default for Sensitivity<T> {
    fn default() -> Self {
        Self { terms: [(0, T::ZERO); 20], count: 0 }
    }
}

impl<T: Scalar> Sensitivity<T> {
    /// Adds ∂z/∂x of one state. A state may be named more than once: the terms add up. At most 20;
    /// zeros do not count, and cost nothing later.
    #[must_use]
    pub fn with(mut self, state: usize, derivative: f64) -> Self {
        if derivative == 0.0 {
            return self;
        }
        if let Some(term) = self.terms.get_mut(self.count) {
            *term = (state, T::of(derivative));
            self.count += 1;
        }
        self
    }

    /// Adds the derivatives of three consecutive states.
    #[must_use]
    pub fn with_block(self, first: usize, derivatives: [f64; 3]) -> Self {
        let [x, y, z] = derivatives;
        self.with(first, x).with(first + 1, y).with(first + 2, z)
    }

    /// The states and their derivatives.
    pub fn terms(&self) -> impl Iterator<Item = (usize, T)> + '_ {
        self.terms.iter().take(self.count).copied()
    }

    /// H x.
    #[must_use]
    pub fn dot<const N: usize>(&self, state: &[T; N]) -> T {
        let mut sum = T::ZERO;
        for (index, derivative) in self.terms() {
            if let Some(&value) = state.get(index) {
                sum += derivative * value;
            }
        }
        sum
    }
}

/// What a scalar update did, for the log and the smoother.
#[derive(Clone, Copy, Debug)]
pub struct Gain<T, const N: usize> {
    /// Kalman gain, state units per measurement unit.
    pub gain: [T; N],
    /// Innovation variance H P Hᵀ + R.
    pub innovation_variance: T,
}

/// The column before the parameters: packed operations come two by two, and start at even columns.
const EVEN: usize = GYRO_BIAS - 1;

#[inline(always)]
fn add_scaled<T: Scalar, const N: usize>(row: &mut [T; N], factor: T, other: &[T; N]) {
    for (value, &term) in row.iter_mut().zip(other) {
        *value += factor * term;
    }
}

impl<T: Scalar, const N: usize> Covariance<T, N> {
    /// All zero.
    #[must_use]
    pub const fn zero() -> Self {
        Self { rows: [[T::ZERO; N]; N] }
    }

    /// A covariance of given rows, which must be symmetric.
    #[cfg(feature = "alloc")]
    pub(super) const fn from_rows(rows: [[T; N]; N]) -> Self {
        Self { rows }
    }

    /// The rows; symmetric.
    #[must_use]
    pub const fn rows(&self) -> &[[T; N]; N] {
        &self.rows
    }

    /// Variance of one state; zero for a state that is not there.
    #[must_use]
    pub fn variance(&self, state: usize) -> f64 {
        self.entry(state, state)
    }

    /// Covariance of two states; zero for a state that is not there.
    #[must_use]
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        self.rows.get(row).and_then(|row| row.get(column)).map_or(0.0, |value| value.wide())
    }

    /// Sets a variance and forgets the state's correlations.
    pub fn set_variance(&mut self, state: usize, variance: f64) {
        for row in &mut self.rows {
            if let Some(value) = row.get_mut(state) {
                *value = T::ZERO;
            }
        }
        if let Some(row) = self.rows.get_mut(state) {
            *row = [T::ZERO; N];
            if let Some(value) = row.get_mut(state) {
                *value = T::of(variance);
            }
        }
    }

    /// Adds to a variance, keeping the correlations: reopens a state without forgetting how it
    /// hangs together with the others.
    pub fn add_variance(&mut self, state: usize, variance: f64) {
        if let Some(value) = self.rows.get_mut(state).and_then(|row| row.get_mut(state)) {
            *value += T::of(variance);
        }
    }

    /// Copies the first `count` states' covariance from a filter of another layout.
    pub fn take_over<U: Scalar, const K: usize>(&mut self, other: &Covariance<U, K>, count: usize) {
        for (row, from) in self.rows.iter_mut().zip(&other.rows).take(count) {
            for (value, &entry) in row.iter_mut().zip(from).take(count) {
                *value = T::of(entry.wide());
            }
        }
    }

    /// The 3×3 block at two states' starts, row by row.
    #[must_use]
    pub fn block(&self, row: usize, column: usize) -> [[f64; 3]; 3] {
        let mut block = [[0.0; 3]; 3];
        for (i, line) in block.iter_mut().enumerate() {
            for (j, value) in line.iter_mut().enumerate() {
                *value = self.entry(row + i, column + j);
            }
        }
        block
    }

    /// Whether every entry is finite and no variance negative.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        self.rows.iter().enumerate().all(|(index, row)| {
            row.iter().all(|value| value.wide().is_finite()) && self.variance(index) >= 0.0
        })
    }

    /// P ← Φ P Φᵀ + Q over one step.
    ///
    /// Φ is the identity but for the blocks of [`Transition`]; terms under 2e-4 per second are left
    /// out: the turning of NED (ω_in ψ, ω_in δv), the change of gravity with height (3e-6 s⁻²) and
    /// of Earth and transport rate with position and velocity (2e-7 rad/m). So is the second effect
    /// of an error within one step (a gyro bias on velocity: half a step late).
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

    /// P Hᵀ and H P Hᵀ of a scalar measurement.
    #[must_use]
    pub fn project(&self, sensitivity: &Sensitivity<T>) -> ([T; N], T) {
        let mut projected = [T::ZERO; N];
        for (state, derivative) in sensitivity.terms() {
            if let Some(row) = self.rows.get(state) {
                add_scaled(&mut projected, derivative, row);
            }
        }
        let variance = sensitivity.dot(&projected);
        (projected, variance)
    }

    /// H P Hᵀ of a scalar measurement alone.
    #[must_use]
    pub fn projected_variance(&self, sensitivity: &Sensitivity<T>) -> T {
        let mut variance = T::ZERO;
        for (n, (state, derivative)) in sensitivity.terms().enumerate() {
            let Some(row) = self.rows.get(state) else { continue };
            let mut sum = T::ZERO;
            for (other, factor) in sensitivity.terms().skip(n + 1) {
                if let Some(&value) = row.get(other) {
                    sum += factor * value;
                }
            }
            if let Some(&own) = row.get(state) {
                variance += derivative * (derivative * own + sum + sum);
            }
        }
        variance
    }

    /// Takes in one scalar measurement of variance `noise`, whose [`project`](Self::project)ion is
    /// given; the gain is returned for the state's correction.
    ///
    /// With v = P Hᵀ, gain k and P̄ = P − k vᵀ, Bierman's form is P = P̄ − (P̄ Hᵀ − R k) kᵀ: the second
    /// term takes back what rounding did in the first. Both are applied in one pass, as the
    /// symmetric P − (k mᵀ + m kᵀ) with m = ½ (v + P̄ Hᵀ − R k).
    pub fn update(
        &mut self,
        sensitivity: &Sensitivity<T>,
        projected: &[T; N],
        variance: T,
        noise: T,
    ) -> Gain<T, N> {
        let innovation_variance = variance + noise;
        let inverse = T::ONE / innovation_variance;
        let gain = projected.map(|value| value * inverse);
        let mut excess = [T::ZERO; N];
        for (state, derivative) in sensitivity.terms() {
            if let (Some(row), Some(&seen)) = (self.rows.get(state), projected.get(state)) {
                for ((value, &p), &k) in excess.iter_mut().zip(row).zip(&gain) {
                    *value += derivative * (p - k * seen);
                }
            }
        }
        for (value, &k) in excess.iter_mut().zip(&gain) {
            *value -= noise * k;
        }
        self.take_off(&gain, projected, &excess);
        Gain { gain, innovation_variance }
    }

    /// P ← P − k vᵀ − e kᵀ, in this order of rounding: upper triangle, and its mirror.
    fn take_off(&mut self, gain: &[T; N], projected: &[T; N], excess: &[T; N]) {
        let p = &mut self.rows;
        for above in 0..N / 2 {
            let i = 2 * above;
            for left in above..N / 2 {
                let j = 2 * left;
                let mut block = [[T::ZERO; 2]; 2];
                for r in 0..2 {
                    for c in 0..2 {
                        block[r][c] = p[i + r][j + c]
                            - gain[i + r] * projected[j + c]
                            - excess[i + r] * gain[j + c];
                    }
                }
                for c in 0..2 {
                    for r in 0..2 {
                        p[j + c][i + r] = block[r][c];
                    }
                }
                for r in 0..2 {
                    for c in 0..2 {
                        p[i + r][j + c] = block[r][c];
                    }
                }
            }
            p[i + 1][i] = p[i][i + 1];
        }
    }
}

const _: () = assert!(BASE == ACCEL_BIAS + 3);

#[cfg(test)]
mod tests;
