//! Several scalar measurements of one moment, taken in one after the other on their projections; the
//! covariance is touched once for all of them.
#![expect(
    clippy::indexing_slicing,
    reason = "every index is below the number of states or of measurements, which bound the loops"
)]

use core::marker::PhantomData;

use super::super::layout::Layout;
use super::super::scalar::Scalar;
use super::fix_sensitivity::FixSensitivity;
use super::sensitivity::MOST;
use super::{Covariance, Gain, Sensitivity, add_scaled};

/// How the measurements of one moment see the state.
#[derive(Clone, Copy, Debug)]
pub enum Sensitivities<'a, T> {
    /// Each by itself, those that there are.
    Each([Option<&'a Sensitivity<T>>; MOST]),
    /// As velocity and position of a fix.
    Fix(&'a FixSensitivity<T>),
}

impl<T: Scalar> Sensitivities<'_, T> {
    /// The place behind the last that there is.
    #[inline(always)]
    fn end(&self) -> usize {
        match self {
            Self::Each(each) => each.iter().rposition(Option::is_some).map_or(0, |last| last + 1),
            Self::Fix(_) => MOST,
        }
    }

    /// That of one measurement, if there is that one.
    #[must_use]
    #[inline(never)]
    pub fn of<L: Layout<N>, const N: usize>(&self, index: usize) -> Option<Sensitivity<T>> {
        match self {
            Self::Each(each) => each.get(index).copied().flatten().copied(),
            Self::Fix(fix) => Some(fix.row::<L, N>(index)),
        }
    }
}

/// Scalar measurements of one moment on their way into a covariance.
///
/// What one of them teaches changes the projections P Hᵀ and H P Hᵀ of those behind it. To judge each by
/// all before it, H P Hᵀ is enough, a few numbers; P Hᵀ, the covariance and the state are changed once, by
/// [`settle`](Self::settle).
#[derive(Clone, Debug)]
pub struct Joint<'a, L, T, const N: usize> {
    sensitivities: Sensitivities<'a, T>,
    /// Behind the last that there is.
    end: usize,
    /// P Hᵀ of each, before any of them.
    projected: [[T; N]; MOST],
    /// H P Hᵀ: of each with itself and with those behind it.
    seen: [[T; MOST]; MOST],
    /// What is left of each innovation after those before it.
    innovations: [T; MOST],
    /// The one-sigma of the innovations of those taken in that the covariance does not know of yet, zero of
    /// all others.
    pending: [T; MOST],
    /// What those taken in make of the state, as far as they are settled.
    correction: [T; N],
    layout: PhantomData<L>,
}

impl<'a, L: Layout<N>, T: Scalar, const N: usize> Joint<'a, L, T, N> {
    /// The measurements that there are, of given `innovations`; to be [`project`](Self::project)ed from
    /// the first on.
    #[must_use]
    #[inline(always)]
    pub fn new(sensitivities: Sensitivities<'a, T>, innovations: [T; MOST]) -> Self {
        Self {
            end: sensitivities.end(),
            sensitivities,
            projected: [[T::ZERO; N]; MOST],
            seen: [[T::ZERO; MOST]; MOST],
            innovations,
            pending: [T::ZERO; MOST],
            correction: [T::ZERO; N],
            layout: PhantomData,
        }
    }

    /// Projects those from `first` on: at the beginning, and after the covariance was changed otherwise
    /// than by [`settle`](Self::settle).
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
        for b in first..MOST {
            let Some(sensitivity) = each[b] else { continue };
            covariance.project_on(sensitivity, &mut self.projected[b]);
            #[expect(
                clippy::needless_range_loop,
                reason = "by iterators it takes 80 instructions more"
            )]
            // Turns: at most MOST.
            for before in first..=b {
                if let Some(other) = each[before] {
                    self.seen[before][b] = other.dot(&self.projected[b]);
                }
            }
        }
    }

    /// H P Hᵀ of a measurement after those taken in. Rounding can make it negative where gaps have opened
    /// the covariance beyond all bounds; the measurement then sees nothing, and this is zero.
    #[must_use]
    pub fn variance(&self, index: usize) -> T {
        let variance = self.seen.get(index).map_or(T::ZERO, |row| row[index.min(MOST - 1)]);
        if variance >= T::ZERO { variance } else { T::ZERO }
    }

    /// One-sigma of the innovation of a measurement of variance `noise` after those taken in.
    #[must_use]
    pub fn sigma(&self, index: usize, noise: T) -> T {
        (self.variance(index) + noise).sqrt()
    }

    /// What is left of a measurement's innovation after those taken in.
    #[must_use]
    pub fn innovation(&self, index: usize) -> T {
        self.innovations.get(index).copied().unwrap_or(T::ZERO)
    }

    /// What those taken in make of the state, once they are [`settle`](Self::settle)d.
    #[must_use]
    pub const fn correction(&self) -> &[T; N] {
        &self.correction
    }

    /// Takes in a measurement of variance `noise`, whose innovation is of one-sigma `sigma`, that of
    /// [`sigma`](Self::sigma): a root is not drawn twice.
    ///
    /// With v = P Hᵀ and the innovation variance S, the covariance becomes P − v vᵀ / S once it is
    /// settled: one symmetric term. In it rounding grows by S over the noise, so a measurement that
    /// brings more than that bears is taken in by Bierman's stabilised form, at once; those before it are
    /// then settled, and told as [`settle`](Self::settle) does.
    ///
    /// # Source
    /// Equations (K6) and (K16) of docs/equations.md.
    pub fn take_in(
        &mut self,
        covariance: &mut Covariance<T, N>,
        index: usize,
        noise: T,
        sigma: T,
        told: &mut impl FnMut(usize, &Gain<T, N>, T),
    ) {
        let variance = self.variance(index);
        if variance <= T::ZERO {
            let nothing = Gain { gain: [T::ZERO; N], innovation_variance: noise };
            told(index, &nothing, self.innovation(index));
            return;
        }
        if variance > noise * T::MOST_INFORMATION {
            self.take_in_stabilised(covariance, index, noise, told);
            return;
        }
        let index = index.min(MOST - 1);
        let inverse = T::ONE / (sigma * sigma);
        let own = self.seen[index];
        let innovation = self.innovations[index];
        // No more than there are: said where nothing else shows it.
        for b in index + 1..self.end.min(MOST) {
            let share = own[b] * inverse;
            self.innovations[b] -= share * innovation;
            // Whole rows: what stands before the diagonal is never read, and a loop of one length takes half.
            for (seen, &own) in self.seen[b].iter_mut().zip(&own) {
                *seen -= share * own;
            }
        }
        self.pending[index] = sigma;
    }

    // Rare, and with a frame of its own.
    #[inline(never)]
    fn take_in_stabilised(
        &mut self,
        covariance: &mut Covariance<T, N>,
        index: usize,
        noise: T,
        told: &mut impl FnMut(usize, &Gain<T, N>, T),
    ) {
        let Some(sensitivity) = self.sensitivities.of::<L, N>(index) else { return };
        self.settle(covariance, told);
        self.project(covariance, index);
        let variance = self.variance(index);
        let projected = &self.projected[index.min(MOST - 1)];
        let gain = covariance.update(&sensitivity, projected, variance, noise);
        let innovation = self.innovation(index);
        add_scaled(&mut self.correction, innovation, &gain.gain);
        for b in index + 1..MOST {
            if let Some(other) = self.sensitivities.of::<L, N>(b) {
                self.innovations[b] -= other.dot(&gain.gain) * innovation;
            }
        }
        self.project(covariance, index + 1);
        told(index, &gain, innovation);
    }

    /// Changes covariance and correction by what was taken in since the last time; `told` hears each's
    /// place, gain and innovation, in their order. Those behind must be
    /// [`project`](Self::project)ed again.
    // The frames of this and of the rest need not stand on each other.
    #[inline(never)]
    pub fn settle(
        &mut self,
        covariance: &mut Covariance<T, N>,
        told: &mut impl FnMut(usize, &Gain<T, N>, T),
    ) {
        match self.pending.iter().rposition(|&sigma| sigma > T::ZERO) {
            None => return,
            Some(0) => self.settle_first::<1>(covariance, told),
            Some(1 | 2) => self.settle_first::<3>(covariance, told),
            Some(_) => self.settle_first::<MOST>(covariance, told),
        }
        self.pending = [T::ZERO; MOST];
    }

    /// [`settle`](Self::settle)s the first `K`; what waits for nothing among them has no share in it.
    #[inline(always)]
    fn settle_first<const K: usize>(
        &mut self,
        covariance: &mut Covariance<T, N>,
        told: &mut impl FnMut(usize, &Gain<T, N>, T),
    ) {
        // In units of the innovations' one-sigmas, in which nothing is left to be divided by.
        let mut shares = [[T::ZERO; K]; K];
        let (mut inverses, mut moves) = ([T::ZERO; K], [T::ZERO; K]);
        let Some(projected) = self.projected.first_chunk_mut::<K>() else { return };
        for index in 0..K.min(MOST) {
            if self.pending[index] > T::ZERO {
                let inverse = T::ONE / self.pending[index];
                (inverses[index], moves[index]) = (inverse, inverse * self.innovations[index]);
                for (behind, share) in shares[index].iter_mut().enumerate().skip(index + 1) {
                    if self.pending[behind.min(MOST - 1)] > T::ZERO {
                        *share = self.seen[index][behind.min(MOST - 1)] * inverse;
                    }
                }
            } else {
                projected[index] = [T::ZERO; N];
            }
        }
        // Each less what those before it know.
        #[expect(
            clippy::needless_range_loop,
            reason = "by iterators nothing shows that it ends at N"
        )]
        for state in 0..N {
            let mut left: [T; K] = core::array::from_fn(|slot| projected[slot][state]);
            let mut correction = self.correction[state];
            for behind in 0..K {
                // Turns: at most K.
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
            let sigma = self.pending[index.min(MOST - 1)];
            if sigma > T::ZERO {
                let gain = projected.map(|value| value * inverse);
                let gain = Gain { gain, innovation_variance: sigma * sigma };
                told(index, &gain, self.innovations[index.min(MOST - 1)]);
            }
        }
        covariance.subtract_squares(projected);
    }
}

impl<T: Scalar, const N: usize> Covariance<T, N> {
    /// P ← P − Σ v vᵀ over vectors v: upper triangle, and its mirror, in squares of two, which are what
    /// vector instructions turn.
    #[inline(always)]
    fn subtract_squares<const K: usize>(&mut self, vectors: &[[T; N]; K]) {
        let p = &mut self.rows;
        for above in 0..N / 2 {
            let i = 2 * above;
            let own: [[T; 2]; K] =
                core::array::from_fn(|term| [vectors[term][i], vectors[term][i + 1]]);
            for left in above..N / 2 {
                let j = 2 * left;
                // True of every pair: said where optimising for size would not find out.
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
