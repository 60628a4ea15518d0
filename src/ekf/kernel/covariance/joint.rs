//! Several scalar measurements of one moment, fused one after another on their projections. The covariance is changed
//! once for all of them.
#![expect(
    clippy::indexing_slicing,
    reason = "every index is below the number of states or of measurements, which bound the loops"
)]

use core::marker::PhantomData;

use super::fix_sensitivity::FixSensitivity;
use super::sensitivity::MAX_AXES;
use super::{Covariance, Gain, Sensitivity};
use crate::ekf::kernel::layout::Layout;
use crate::matrix::add_scaled;
use crate::scalar::Scalar;

/// Sensitivities of the measurements of one moment.
#[derive(Clone, Copy, Debug)]
pub enum Sensitivities<'a, T> {
    /// One sensitivity each, for the measurements that exist.
    Each([Option<&'a Sensitivity<T>>; MAX_AXES]),
    /// Velocity and position of a fix.
    Fix(&'a FixSensitivity<T>),
}

impl<T: Scalar> Sensitivities<'_, T> {
    /// Number of slots up to the last measurement that exists.
    #[inline(always)]
    fn end(&self) -> usize {
        match self {
            Self::Each(each) => each.iter().rposition(Option::is_some).map_or(0, |last| last + 1),
            Self::Fix(_) => MAX_AXES,
        }
    }

    /// Sensitivity of one measurement, if it exists.
    #[must_use]
    #[inline(never)]
    pub fn of<L: Layout<N>, const N: usize>(&self, index: usize) -> Option<Sensitivity<T>> {
        match self {
            Self::Each(each) => each.get(index).copied().flatten().copied(),
            Self::Fix(fix) => Some(fix.row::<L, N>(index)),
        }
    }
}

/// Scalar measurements of one moment, being fused into a covariance.
///
/// Each fused measurement changes the projections P Hᵀ and H P Hᵀ of the later ones. To judge each after all earlier
/// ones, the few numbers of H P Hᵀ are enough. [`settle`](Self::settle) then changes P Hᵀ, the covariance and the state
/// once.
#[derive(Clone, Debug)]
pub struct Joint<'a, L, T, const N: usize> {
    sensitivities: Sensitivities<'a, T>,
    /// Number of slots up to the last measurement that exists.
    end: usize,
    /// P Hᵀ of each measurement, before the first is fused.
    projected: [[T; N]; MAX_AXES],
    /// H P Hᵀ of each measurement with itself and the later ones.
    seen: [[T; MAX_AXES]; MAX_AXES],
    /// Remaining innovation of each measurement after the earlier ones.
    innovations: [T; MAX_AXES],
    /// One-sigma of the innovation of each measurement fused but not yet settled; zero for all others.
    pending: [T; MAX_AXES],
    /// Correction of the state by the settled measurements.
    correction: [T; N],
    layout: PhantomData<L>,
}

impl<'a, L: Layout<N>, T: Scalar, const N: usize> Joint<'a, L, T, N> {
    /// Measurements with given `innovations`. Call [`project`](Self::project) from index 0 before the first use.
    #[must_use]
    #[inline(always)]
    pub fn new(sensitivities: Sensitivities<'a, T>, innovations: [T; MAX_AXES]) -> Self {
        Self {
            end: sensitivities.end(),
            sensitivities,
            projected: [[T::ZERO; N]; MAX_AXES],
            seen: [[T::ZERO; MAX_AXES]; MAX_AXES],
            innovations,
            pending: [T::ZERO; MAX_AXES],
            correction: [T::ZERO; N],
            layout: PhantomData,
        }
    }

    /// Projects the measurements from `first` on: at the beginning, and after any change of the covariance outside
    /// [`settle`](Self::settle).
    #[inline(never)]
    pub fn project(&mut self, covariance: &mut Covariance<T, N>, first: usize) {
        covariance.renew_mirror();
        let each = match self.sensitivities {
            Sensitivities::Each(each) => each,
            Sensitivities::Fix(fix) => {
                fix.project::<L, N>(covariance, &mut self.projected, &mut self.seen);
                return;
            }
        };
        for b in first..MAX_AXES {
            let Some(sensitivity) = each[b] else { continue };
            covariance.project_on(sensitivity, &mut self.projected[b]);
            #[expect(
                clippy::needless_range_loop,
                reason = "by iterators it takes 80 instructions more"
            )]
            // Iterations: at most MAX_AXES.
            for before in first..=b {
                if let Some(other) = each[before] {
                    self.seen[before][b] = other.dot(&self.projected[b]);
                }
            }
        }
    }

    /// H P Hᵀ of a measurement, after the update with the already fused measurements. Rounding can make it negative if
    /// gaps have raised the covariance beyond all bounds. The result is then zero, and the measurement has no effect.
    #[must_use]
    pub fn variance(&self, index: usize) -> T {
        let variance = self.seen.get(index).map_or(T::ZERO, |row| row[index.min(MAX_AXES - 1)]);
        if variance >= T::ZERO { variance } else { T::ZERO }
    }

    /// One-sigma of the innovation of a measurement with variance `noise`, after the update with the already fused
    /// measurements.
    #[must_use]
    pub fn sigma(&self, index: usize, noise: T) -> T {
        (self.variance(index) + noise).sqrt()
    }

    /// Remaining innovation of a measurement, after the update with the already fused measurements.
    #[must_use]
    pub fn innovation(&self, index: usize) -> T {
        self.innovations.get(index).copied().unwrap_or(T::ZERO)
    }

    /// Largest squared normalised innovation of the measurements `members`, each computed after the update with the
    /// earlier ones. Measurements that contradict each other then exceed a gate that each of them passes alone.
    #[must_use]
    #[inline(never)]
    pub fn largest_in_turn(&self, members: core::ops::Range<usize>, noise: &[T; MAX_AXES]) -> T {
        let (mut seen, mut innovations) = (self.seen, self.innovations);
        let mut largest = T::ZERO;
        // Iterations: at most MAX_AXES.
        for index in members.start..members.end.min(MAX_AXES) {
            let variance = seen[index][index].max(T::ZERO) + noise[index];
            largest = largest.max(innovations[index] * innovations[index] / variance);
            let own = seen[index];
            // Iterations: at most MAX_AXES.
            for later in index + 1..members.end.min(MAX_AXES) {
                let share = own[later] / variance;
                innovations[later] -= share * innovations[index];
                for (seen, &own) in seen[later].iter_mut().zip(&own) {
                    *seen -= share * own;
                }
            }
        }
        largest
    }

    /// Correction of the state by the fused measurements, complete after [`settle`](Self::settle).
    #[must_use]
    pub const fn correction(&self) -> &[T; N] {
        &self.correction
    }

    /// Fuses a measurement with variance `noise` and innovation one-sigma `sigma`, as returned by
    /// [`sigma`](Self::sigma): this saves a second root.
    ///
    /// With v = P Hᵀ and the innovation variance S, the settled covariance is P − v vᵀ / S: one symmetric term. Its
    /// rounding error grows with S over the noise. If H P Hᵀ exceeds `MAX_INFORMATION` times the noise, the
    /// measurement is fused at once in Bierman's stabilised form. The earlier ones are then settled first, and reported
    /// as [`settle`](Self::settle) does.
    ///
    /// # Source
    /// Equations (K6) and (K16) of docs/equations.md.
    pub fn fuse(
        &mut self,
        covariance: &mut Covariance<T, N>,
        index: usize,
        noise: T,
        sigma: T,
        on_fused: &mut impl FnMut(usize, &Gain<T, N>, T),
    ) {
        let variance = self.variance(index);
        if variance <= T::ZERO {
            let nothing = Gain { gain: [T::ZERO; N], innovation_variance: noise };
            on_fused(index, &nothing, self.innovation(index));
            return;
        }
        if variance > noise * T::MAX_INFORMATION {
            self.fuse_stabilised(covariance, index, noise, on_fused);
            return;
        }
        let index = index.min(MAX_AXES - 1);
        let inverse = T::ONE / (sigma * sigma);
        let own = self.seen[index];
        let innovation = self.innovations[index];
        // The explicit bound shows the compiler that the index stays in range.
        for b in index + 1..self.end.min(MAX_AXES) {
            let share = own[b] * inverse;
            self.innovations[b] -= share * innovation;
            // Whole rows: entries before the diagonal are never read, and a loop of constant length takes half the
            // time.
            for (seen, &own) in self.seen[b].iter_mut().zip(&own) {
                *seen -= share * own;
            }
        }
        self.pending[index] = sigma;
    }

    // Rare, and not inlined: it needs a stack frame of its own.
    #[inline(never)]
    fn fuse_stabilised(
        &mut self,
        covariance: &mut Covariance<T, N>,
        index: usize,
        noise: T,
        on_fused: &mut impl FnMut(usize, &Gain<T, N>, T),
    ) {
        let Some(sensitivity) = self.sensitivities.of::<L, N>(index) else { return };
        self.settle(covariance, on_fused);
        self.project(covariance, index);
        let variance = self.variance(index);
        let projected = &self.projected[index.min(MAX_AXES - 1)];
        let gain = covariance.update(&sensitivity, projected, variance, noise);
        let innovation = self.innovation(index);
        add_scaled(&mut self.correction, innovation, &gain.gain);
        for b in index + 1..MAX_AXES {
            if let Some(other) = self.sensitivities.of::<L, N>(b) {
                self.innovations[b] -= other.dot(&gain.gain) * innovation;
            }
        }
        self.project(covariance, index + 1);
        on_fused(index, &gain, innovation);
    }

    /// Applies the measurements fused since the last call to covariance and correction. Calls `on_fused` with the
    /// index, gain and innovation of each, in their order. Later measurements must be [`project`](Self::project)ed
    /// again.
    // Not inlined, so that the stack frames of this function and of the others do not add up.
    #[inline(never)]
    pub fn settle(
        &mut self,
        covariance: &mut Covariance<T, N>,
        on_fused: &mut impl FnMut(usize, &Gain<T, N>, T),
    ) {
        match self.pending.iter().rposition(|&sigma| sigma > T::ZERO) {
            None => return,
            Some(0) => self.settle_first::<1>(covariance, on_fused),
            Some(1 | 2) => self.settle_first::<3>(covariance, on_fused),
            Some(_) => self.settle_first::<MAX_AXES>(covariance, on_fused),
        }
        self.pending = [T::ZERO; MAX_AXES];
    }

    /// [`settle`](Self::settle)s the first `K` slots; slots without a pending measurement contribute nothing.
    #[inline(always)]
    fn settle_first<const K: usize>(
        &mut self,
        covariance: &mut Covariance<T, N>,
        on_fused: &mut impl FnMut(usize, &Gain<T, N>, T),
    ) {
        // These values are divided by the innovations' one-sigmas, so that the loop over the states needs no division.
        let mut shares = [[T::ZERO; K]; K];
        let (mut inverses, mut moves) = ([T::ZERO; K], [T::ZERO; K]);
        let Some(projected) = self.projected.first_chunk_mut::<K>() else { return };
        for index in 0..K.min(MAX_AXES) {
            if self.pending[index] > T::ZERO {
                let inverse = T::ONE / self.pending[index];
                (inverses[index], moves[index]) = (inverse, inverse * self.innovations[index]);
                for (behind, share) in shares[index].iter_mut().enumerate().skip(index + 1) {
                    if self.pending[behind.min(MAX_AXES - 1)] > T::ZERO {
                        *share = self.seen[index][behind.min(MAX_AXES - 1)] * inverse;
                    }
                }
            } else {
                projected[index] = [T::ZERO; N];
            }
        }
        // Subtracts from each P Hᵀ the part that the earlier measurements explain.
        #[expect(
            clippy::needless_range_loop,
            reason = "by iterators nothing shows that it ends at N"
        )]
        for state in 0..N {
            let mut left: [T; K] = core::array::from_fn(|slot| projected[slot][state]);
            let mut correction = self.correction[state];
            for behind in 0..K {
                // Iterations: at most K.
                for before in 0..behind {
                    let known = shares[before][behind] * left[before];
                    left[behind] -= known;
                }
                left[behind] = left[behind] * inverses[behind];
                correction += left[behind] * moves[behind];
                projected[behind][state] = left[behind];
            }
            self.correction[state] = correction;
        }
        for (index, (projected, &inverse)) in projected.iter().zip(&inverses).enumerate() {
            let sigma = self.pending[index.min(MAX_AXES - 1)];
            if sigma > T::ZERO {
                let gain = projected.map(|value| value * inverse);
                let gain = Gain { gain, innovation_variance: sigma * sigma };
                on_fused(index, &gain, self.innovations[index.min(MAX_AXES - 1)]);
            }
        }
        covariance.subtract_squares(projected);
    }
}

impl<T: Scalar, const N: usize> Covariance<T, N> {
    /// P ← P − Σ v vᵀ over vectors v: upper triangle and its mirror, in 2 × 2 blocks that vector instructions can
    /// transpose.
    #[inline(always)]
    fn subtract_squares<const K: usize>(&mut self, vectors: &[[T; N]; K]) {
        let p = &mut self.rows;
        for above in 0..N / 2 {
            let i = 2 * above;
            let own: [[T; 2]; K] =
                core::array::from_fn(|term| [vectors[term][i], vectors[term][i + 1]]);
            for left in above..N / 2 {
                let j = 2 * left;
                // Always false for an even `N`: the check removes bounds checks when optimising for size.
                if i + 1 >= N || j + 1 >= N {
                    break;
                }
                let mut square = [[p[i][j], p[i][j + 1]], [p[i + 1][j], p[i + 1][j + 1]]];
                for (v, own) in vectors.iter().zip(&own) {
                    for (line, &own) in square.iter_mut().zip(own) {
                        line[0] -= own * v[j];
                        line[1] -= own * v[j + 1];
                    }
                }
                let [[a, b], [c, d]] = square;
                (p[j][i], p[j][i + 1]) = (a, c);
                (p[j + 1][i], p[j + 1][i + 1]) = (b, d);
                (p[i][j], p[i][j + 1]) = (a, b);
                (p[i + 1][j], p[i + 1][j + 1]) = (c, d);
            }
        }
    }
}
