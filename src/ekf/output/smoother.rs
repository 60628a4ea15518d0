//! Fixed-interval smoothing: every moment is estimated from the whole log, past and future. Needs `std`.
//!
//! The filter runs forward once, observed by a [`Smoother`]. The smoother stores the transition of every propagation,
//! and sensitivity, gain and innovation of every scalar update. At every inertial sample it stores the estimate and its
//! covariance. Then the modified Bryson–Frazier recursion runs backward over the record. An adjoint λ and its
//! information Λ are zero at the end of the log. The recursion takes them back through every update by
//!
//! λ ← λ − h (kᵀλ + ν/s),  Λ ← (I − k hᵀ)ᵀ Λ (I − k hᵀ) + h hᵀ/s
//!
//! and through every propagation by λ ← Φᵀ λ, Λ ← Φᵀ Λ Φ. At a sample with filtered covariance P the smoothed error
//! state is −P λ, its covariance P − P Λ P. The result equals that of the Rauch–Tung–Striebel form without inverting a
//! covariance: the only divisor is an innovation's variance s. So states that are known exactly, or whose variance is
//! still zero, do no harm.
//!
//! A correction of the state needs no record. It moves the estimate but not the error's statistics: λ gives the error
//! of each estimate *at its own time*. A rejected axis has no effect. A raised variance acts as a propagation with the
//! identity as transition and the added variance as process noise. It changes neither λ nor Λ. A reset of variances,
//! which removes their correlations too, is recorded as a reset. Later data contain no information about the previous
//! values of these states. So their rows of λ and Λ become zero.
//!
//! The smoother is as linear as the filter: it uses the transitions and sensitivities of the forward run.
//!
//! # Memory
//! Per inertial sample: the transition (0.8 kB with 26 states), the estimate (0.4 kB), and the rows of the covariance
//! for the solution (2.3 kB). Those are the fifteen rows of the base states, without symmetric repetitions. Per scalar
//! update: 0.6 kB. An hour at 100 Hz takes 1.3 GB, unless it is smoothed in parts: see [`Smoother::smooth_before`].
//!
//! # Source
//! G. J. Bierman (1973), Fixed interval smoothing with discrete measurements, *International Journal of Control* 18
//! (1), 65–75; A. E. Bryson and M. Frazier (1963), Smoothing for linear and nonlinear dynamic systems, the form
//! modified.
#![expect(
    clippy::indexing_slicing,
    reason = "every index is below the number of states, which `Layout` fixes for a whole loop"
)]

use alloc::vec::Vec;
use core::ops::Range;

use super::solution::Solution;
use crate::ekf::filter::Ekf;
use crate::ekf::kernel::covariance::{Covariance, Gain, Relaxation, Sensitivity, Transition};
use crate::ekf::kernel::layout::{
    ACCEL_BIAS, ATTITUDE, BASE, GYRO_BIAS, Layout, POSITION, VELOCITY,
};
use crate::ekf::kernel::trace::Trace;
use crate::frames::{Body, Vector};
use crate::ins::NavState;
use crate::matrix::add_scaled;

/// Records a filter's forward run, then smooths it backward.
///
/// Give it to the filter as its [`Trace`], and call [`sampled`](Self::sampled) at each moment of a smoothed solution.
///
/// ```
/// use hovernav::ekf::{FullEkf, Smoother};
/// use hovernav::ekf::layout::Full;
/// # use hovernav::imu::ImuSample;
/// # use hovernav::gps::Fix;
///
/// # fn smooth(mut filter: FullEkf, log: &[(ImuSample, Option<Fix>)]) -> Vec<hovernav::ekf::Solution> {
/// let mut smoother = Smoother::<Full, 28>::with_capacity(log.len());
/// for (sample, fix) in log {
///     let _ = filter.predict_traced(sample, &mut smoother);
///     if let Some(fix) = fix {
///         let _ = filter.update_gps_traced(fix, &mut smoother);
///     }
///     smoother.sampled(&filter);
/// }
/// smoother.smooth()
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Smoother<L, const N: usize> {
    order: Vec<Record>,
    propagations: Vec<Transition<f64, N>>,
    updates: Vec<Update<N>>,
    samples: Vec<Sample<N>>,
    /// For each sample, the rows of the base states, each from its diagonal on.
    covariances: Vec<f64>,
    /// The filter at the first sample; the smoothed estimates are written to it one by one.
    filter: Option<Ekf<L, N>>,
}

/// Kind of a recorded action. Its details are at the end of the list of that kind.
#[derive(Clone, Copy, Debug)]
enum Record {
    Propagated,
    Updated,
    Sampled,
    Reset { first: u8, end: u8 },
}

#[derive(Clone, Copy, Debug)]
struct Update<const N: usize> {
    sensitivity: Sensitivity<f64>,
    gain: Gain<f64, N>,
    innovation: f64,
}

/// The filter's estimate at a sample.
#[derive(Clone, Copy, Debug)]
struct Sample<const N: usize> {
    state: NavState,
    parameters: [f64; N],
    angular_rate_radps: Vector<Body>,
    /// Ambiguity of the filter's position, horizontal and vertical, m.
    ambiguity_m: [f32; 2],
}

/// Information from the later part of the log about the error state at a moment. Zero by default, as at the end of the
/// log.
#[derive(Clone, Debug)]
pub struct Adjoint<const N: usize> {
    /// λ, as a matrix of one column.
    vector: [[f64; 1]; N],
    /// Λ, symmetric.
    information: [[f64; N]; N],
}

impl<const N: usize> Default for Adjoint<N> {
    fn default() -> Self {
        Self { vector: [[0.0]; N], information: [[0.0; N]; N] }
    }
}

impl<L: Layout<N>, const N: usize> Trace<f64, N> for Smoother<L, N> {
    fn propagated(&mut self, step: &Transition<f64, N>) {
        self.order.push(Record::Propagated);
        self.propagations.push(*step);
    }

    fn updated(&mut self, sensitivity: &Sensitivity<f64>, gain: &Gain<f64, N>, innovation: f64) {
        self.order.push(Record::Updated);
        self.updates.push(Update { sensitivity: *sensitivity, gain: *gain, innovation });
    }

    fn reset(&mut self, states: Range<usize>) {
        let bounded = |state: usize| u8::try_from(state.min(N)).unwrap_or(u8::MAX);
        self.order.push(Record::Reset { first: bounded(states.start), end: bounded(states.end) });
    }
}

impl<L: Layout<N>, const N: usize> Smoother<L, N> {
    /// Number of covariance entries stored for a sample.
    const KEPT: usize = BASE * N - BASE * (BASE - 1) / 2;

    /// An empty smoother, with memory for `samples` samples.
    #[must_use]
    pub fn with_capacity(samples: usize) -> Self {
        Self {
            order: Vec::with_capacity(2 * samples),
            propagations: Vec::with_capacity(samples),
            updates: Vec::new(),
            samples: Vec::with_capacity(samples),
            covariances: Vec::with_capacity(Self::KEPT * samples),
            filter: None,
        }
    }

    /// Stores the filter's estimate for smoothing.
    pub fn sampled(&mut self, filter: &Ekf<L, N>) {
        self.order.push(Record::Sampled);
        self.samples.push(Sample {
            state: filter.state,
            parameters: filter.parameters,
            angular_rate_radps: filter.memory.angular_rate_radps,
            ambiguity_m: filter.ambiguity_m(),
        });
        for state in 0..BASE {
            self.covariances.extend_from_slice(filter.covariance.upper_row(state));
        }
        self.filter.get_or_insert_with(|| filter.clone());
    }

    /// Runs backward over the record. Returns the smoothed solution at every [`sampled`](Self::sampled) moment, in
    /// order of time.
    ///
    /// The angular rate is the filter's minus the correction of the gyro bias.
    #[must_use]
    pub fn smooth(self) -> Vec<Solution> {
        self.smooth_before(&mut Adjoint::default())
    }

    /// [`smooth`](Self::smooth) for a part of a log. Before the call, `adjoint` holds the information from the log
    /// after the part. On return it also includes the information from the part. So a long log is smoothed part by
    /// part, from the last to the first, with bitwise identical results.
    #[must_use]
    pub fn smooth_before(mut self, adjoint: &mut Adjoint<N>) -> Vec<Solution> {
        let mut solutions = Vec::with_capacity(self.samples.len());
        // Iterations: one a record. The smoother does not run in flight.
        while let Some(record) = self.order.pop() {
            match record {
                Record::Propagated => {
                    if let Some(step) = self.propagations.pop() {
                        adjoint.back_over_propagation(&step);
                    }
                }
                Record::Updated => {
                    if let Some(update) = self.updates.pop() {
                        adjoint.back_over_update(&update);
                    }
                }
                Record::Reset { first, end } => adjoint.forget(first.into()..end.into()),
                Record::Sampled => {
                    if let Some((sample, filter)) = self.samples.pop().zip(self.filter.as_mut()) {
                        let kept = self.covariances.len().saturating_sub(Self::KEPT);
                        let rows = unpacked::<N>(&self.covariances[kept..]);
                        self.covariances.truncate(kept);
                        solutions.push(adjoint.solution(filter, &sample, &rows));
                    }
                }
            }
        }
        solutions.reverse();
        solutions
    }
}

/// The fifteen base rows of a covariance from their stored entries.
fn unpacked<const N: usize>(kept: &[f64]) -> [[f64; N]; BASE] {
    let mut rows = [[0.0; N]; BASE];
    let mut kept = kept.iter();
    for (state, row) in rows.iter_mut().enumerate() {
        for (value, &entry) in row.iter_mut().skip(state).zip(&mut kept) {
            *value = entry;
        }
    }
    mirror(&mut rows);
    rows
}

/// Copies the upper triangle to the lower.
fn mirror<const N: usize, const M: usize>(rows: &mut [[f64; M]; N]) {
    for column in 1..N {
        let (above, below) = rows.split_at_mut(column);
        for (value, row) in below[0].iter_mut().zip(above) {
            *value = row[column];
        }
    }
}

impl<const N: usize> Adjoint<N> {
    /// λ ← Φᵀ λ, Λ ← Φᵀ Λ Φ.
    ///
    /// # Source
    /// Equation (B2) of docs/equations.md.
    fn back_over_propagation(&mut self, step: &Transition<f64, N>) {
        pull_back::<N, 1>(step, &mut self.vector);
        pull_back::<N, N>(step, &mut self.information);
        let half_done = self.information;
        self.information = core::array::from_fn(|i| core::array::from_fn(|j| half_done[j][i]));
        pull_back::<N, N>(step, &mut self.information);
        // Mirroring keeps Λ symmetric: over a long log, rounding would make it asymmetric.
        mirror(&mut self.information);
    }

    /// Removes all later information about `states`.
    ///
    /// # Source
    /// Equation (B2) of docs/equations.md, with zero rows of Φ for these states.
    fn forget(&mut self, states: Range<usize>) {
        for state in states.filter(|&state| state < N) {
            self.vector[state] = [0.0];
            self.information[state] = [0.0; N];
            for row in &mut self.information {
                row[state] = 0.0;
            }
        }
    }

    /// Carries the adjoint back through a scalar update. With a = Λ k the new Λ is Λ − h aᵀ − a hᵀ + (kᵀa + 1/s) h hᵀ,
    /// where h has few terms.
    ///
    /// # Source
    /// Equation (B1) of docs/equations.md.
    fn back_over_update(&mut self, update: &Update<N>) {
        let Gain { gain, innovation_variance } = &update.gain;
        let pulled = self.information.map(|row| dot(&row, gain));
        let innermost = dot(&pulled, gain) + 1.0 / innovation_variance;
        let mut surprise = update.innovation / innovation_variance;
        for ([entry], factor) in self.vector.iter().zip(gain) {
            surprise += entry * factor;
        }
        let mut direction = [0.0; N];
        for (state, derivative) in update.sensitivity.terms() {
            direction[state] += derivative;
        }
        let rows = self.information.iter_mut().zip(&mut self.vector);
        for ((row, [entry]), (seen, own)) in rows.zip(direction.iter().zip(&pulled)) {
            *entry -= seen * surprise;
            add_scaled(row, seen * innermost - own, &direction);
            add_scaled(row, -seen, &pulled);
        }
    }

    /// The smoothed solution at a sample, computed in the borrowed `filter`.
    ///
    /// # Source
    /// Equation (B3) of docs/equations.md.
    fn solution<L: Layout<N>>(
        &self,
        filter: &mut Ekf<L, N>,
        sample: &Sample<N>,
        rows: &[[f64; N]; BASE],
    ) -> Solution {
        let mut correction = [0.0; N];
        let mut covariance = [[0.0; N]; N];
        for (i, row) in rows.iter().enumerate() {
            let mut explained = [0.0; N];
            for ((&entry, line), adjoint) in row.iter().zip(&self.information).zip(&self.vector) {
                correction[i] -= entry * adjoint[0];
                add_scaled(&mut explained, entry, line);
            }
            for (j, other) in rows.iter().enumerate().skip(i) {
                if !is_used_by_solution(i, j) {
                    continue;
                }
                let value = row[j] - dot(&explained, other);
                covariance[i][j] = value;
            }
        }
        mirror(&mut covariance);
        let [x, y, z] = [0, 1, 2].map(|axis| correction[GYRO_BIAS + axis]);
        filter.state = sample.state;
        filter.parameters = sample.parameters;
        filter.memory.angular_rate_radps = sample.angular_rate_radps - Vector::new(x, y, z);
        filter.covariance = Covariance::from_rows(covariance);
        filter.correct(&correction);
        // A smoothed solution is past, so no controller needs its heading revision.
        let mut solution = filter.unambiguous_solution();
        solution.widen(sample.ambiguity_m);
        Solution { heading_revision_rad: 0.0, ..solution }
    }
}

/// Whether a solution uses the covariance of two base states. It needs all variances, and for its lever arm and its
/// angles the covariances among attitude, velocity and position.
const fn is_used_by_solution(row: usize, column: usize) -> bool {
    row == column || (row < VELOCITY && column < GYRO_BIAS)
}

/// Φᵀ times a matrix: the transpose of the factor in
/// [`Covariance::propagate`](crate::ekf::kernel::covariance::Covariance::propagate).
fn pull_back<const N: usize, const M: usize>(step: &Transition<f64, N>, rows: &mut [[f64; M]; N]) {
    let half = 0.5 * step.interval_s;
    if let Some(Relaxation { decay, .. }) = &step.relaxation {
        for (row, decay) in rows.iter_mut().zip(decay).skip(GYRO_BIAS) {
            for value in row {
                *value *= decay;
            }
        }
    }
    let attitude: [[f64; M]; 3] = core::array::from_fn(|axis| rows[ATTITUDE + axis]);
    // The new velocity also moves the position.
    let velocity: [[f64; M]; 3] = core::array::from_fn(|axis| {
        let mut row = rows[VELOCITY + axis];
        add_scaled(&mut row, half, &rows[POSITION + axis]);
        row
    });
    let mut subtract = |first: usize, by: &[[f64; 3]; 3], from: &[[f64; M]; 3]| {
        for (factors, row) in by.iter().zip(from) {
            for (k, factor) in factors.iter().enumerate() {
                add_scaled(&mut rows[first + k], -factor, row);
            }
        }
    };
    subtract(GYRO_BIAS, &step.turn, &attitude);
    subtract(ACCEL_BIAS, &step.turn, &velocity);
    for (axis, row) in velocity.iter().enumerate() {
        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
        add_scaled(&mut rows[ATTITUDE + next], step.force[last], row);
        add_scaled(&mut rows[ATTITUDE + last], -step.force[next], row);
        let position = rows[POSITION + axis];
        rows[VELOCITY + axis] = *row;
        add_scaled(&mut rows[VELOCITY + axis], half, &position);
    }
}

/// Inner product, in two sums that a processor computes in parallel.
fn dot<const M: usize>(a: &[f64; M], b: &[f64; M]) -> f64 {
    let mut sums = [0.0; 2];
    let (a_pairs, a_rest) = a.as_chunks::<2>();
    let (b_pairs, b_rest) = b.as_chunks::<2>();
    for (a, b) in a_pairs.iter().zip(b_pairs) {
        sums[0] += a[0] * b[0];
        sums[1] += a[1] * b[1];
    }
    a_rest.iter().zip(b_rest).fold(sums[0] + sums[1], |sum, (a, b)| sum + a * b)
}
