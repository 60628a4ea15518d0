//! Several scalar measurements of one moment, taken in one after the other on their projections; the
//! covariance is touched once for all of them.
#![expect(
    clippy::indexing_slicing,
    reason = "every index is below the number of states or of measurements, which bound the loops"
)]

use super::super::scalar::Scalar;
use super::{Covariance, Gain, Sensitivity, add_scaled};

/// Most measurements of one moment: position and velocity.
pub const MOST: usize = 6;

/// Scalar measurements of one moment on their way into a covariance.
///
/// What one of them teaches changes the projections P Hᵀ and H P Hᵀ of those behind it, which are far
/// fewer numbers than the covariance: so each can be judged by all before it, and the covariance is
/// changed once, by [`settle`](Self::settle).
#[derive(Clone, Debug)]
pub struct Joint<'a, T, const N: usize> {
    sensitivities: [Option<&'a Sensitivity<T>>; MOST],
    /// P Hᵀ of each.
    projected: [[T; N]; MOST],
    /// H P Hᵀ: of each with itself and with those behind it.
    seen: [[T; MOST]; MOST],
    /// What is left of each innovation after those before it.
    innovations: [T; MOST],
    /// The inverse innovation variance of those taken in that the covariance does not know of yet, zero
    /// of all others.
    pending: [T; MOST],
}

impl<'a, T: Scalar, const N: usize> Joint<'a, T, N> {
    /// The measurements that there are, of given `innovations`; to be [`project`](Self::project)ed from
    /// the first on.
    #[must_use]
    #[inline(always)]
    pub const fn new(
        sensitivities: [Option<&'a Sensitivity<T>>; MOST],
        innovations: [T; MOST],
    ) -> Self {
        Self {
            sensitivities,
            projected: [[T::ZERO; N]; MOST],
            seen: [[T::ZERO; MOST]; MOST],
            innovations,
            pending: [T::ZERO; MOST],
        }
    }

    /// Projects those from `first` on: at the beginning, and after the covariance was changed otherwise
    /// than by [`settle`](Self::settle).
    #[inline(never)]
    pub fn project(&mut self, covariance: &Covariance<T, N>, first: usize) {
        for b in first..MOST {
            let Some(sensitivity) = self.sensitivities[b] else { continue };
            self.projected[b] = covariance.project_on(sensitivity);
            for a in first..=b {
                if let Some(other) = self.sensitivities[a] {
                    self.seen[a][b] = other.dot(&self.projected[b]);
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

    /// What is left of a measurement's innovation after those taken in.
    #[must_use]
    pub fn innovation(&self, index: usize) -> T {
        self.innovations.get(index).copied().unwrap_or(T::ZERO)
    }

    /// Takes in a measurement of variance `noise`; the gain is returned for the state's correction.
    ///
    /// With v = P Hᵀ and the innovation variance S, the covariance becomes P − v vᵀ / S once it is
    /// settled: one symmetric term. In it rounding grows by S over the noise, so a measurement that
    /// brings more than that bears is taken in by Bierman's stabilised form, at once.
    ///
    /// # Source
    /// Equations (K6) and (K16) of docs/equations.md.
    pub fn take_in(
        &mut self,
        covariance: &mut Covariance<T, N>,
        index: usize,
        noise: T,
    ) -> Gain<T, N> {
        let nothing = Gain { gain: [T::ZERO; N], innovation_variance: noise };
        let Some(sensitivity) = self.sensitivities.get(index).copied().flatten() else {
            return nothing;
        };
        let variance = self.variance(index);
        if variance <= T::ZERO {
            return nothing;
        }
        if variance > noise * T::MOST_INFORMATION {
            return self.take_in_stabilised(covariance, index, sensitivity, noise);
        }
        let innovation_variance = variance + noise;
        let inverse = T::ONE / innovation_variance;
        let (before, behind) = self.projected.split_at_mut((index + 1).min(MOST));
        let Some(projected) = before.last() else { return nothing };
        let innovation = self.innovations[index.min(MOST - 1)];
        let shares = self.seen[index.min(MOST - 1)].map(|seen| seen * inverse);
        #[expect(clippy::needless_range_loop, reason = "by iterators it takes a sixth longer")]
        for b in index + 1..MOST {
            let measured = self.sensitivities[b].is_some();
            let Some(other) = behind.get_mut(b - index - 1).filter(|_| measured) else {
                continue;
            };
            add_scaled(other, -shares[b], projected);
            self.innovations[b] -= shares[b] * innovation;
            let own = self.seen[index.min(MOST - 1)];
            for c in b..MOST {
                self.seen[b][c] -= shares[b] * own[c];
            }
        }
        self.pending[index.min(MOST - 1)] = inverse;
        Gain { gain: projected.map(|value| value * inverse), innovation_variance }
    }

    // Rare, and with a frame of its own.
    #[inline(never)]
    fn take_in_stabilised(
        &mut self,
        covariance: &mut Covariance<T, N>,
        index: usize,
        sensitivity: &Sensitivity<T>,
        noise: T,
    ) -> Gain<T, N> {
        self.settle(covariance);
        self.project(covariance, index);
        let variance = self.variance(index);
        let projected = &self.projected[index.min(MOST - 1)];
        let gain = covariance.update(sensitivity, projected, variance, noise);
        let innovation = self.innovation(index);
        for b in index + 1..MOST {
            if let Some(other) = self.sensitivities[b] {
                self.innovations[b] -= other.dot(&gain.gain) * innovation;
            }
        }
        self.project(covariance, index + 1);
        gain
    }

    /// Changes the covariance by what was taken in since the last time.
    // The frames of this and of the rest need not stand on each other.
    #[inline(never)]
    pub fn settle(&mut self, covariance: &mut Covariance<T, N>) {
        let [first, ..] = &self.projected;
        let mut waiting = [(first, T::ZERO); MOST];
        let mut count = 0;
        for (projected, inverse) in self.projected.iter().zip(&mut self.pending) {
            if *inverse > T::ZERO
                && let Some(slot) = waiting.get_mut(count)
            {
                *slot = (projected, *inverse);
                count += 1;
                *inverse = T::ZERO;
            }
        }
        let [a, b, c, ..] = waiting;
        match count {
            0 => {}
            1 => covariance.subtract_squares([a]),
            2 | 3 => covariance.subtract_squares([a, b, c]),
            _ => covariance.subtract_squares(waiting),
        }
    }
}

impl<T: Scalar, const N: usize> Covariance<T, N> {
    /// P ← P − Σ v vᵀ f over `terms` of v and f: upper triangle, and its mirror, in squares of two, which
    /// are what vector instructions turn.
    fn subtract_squares<const K: usize>(&mut self, terms: [(&[T; N], T); K]) {
        let p = &mut self.rows;
        for above in 0..N / 2 {
            let i = 2 * above;
            let scaled = terms.map(|(v, factor)| [v[i] * factor, v[i + 1] * factor]);
            for left in above..N / 2 {
                let j = 2 * left;
                // True of every pair: said where optimising for size would not find out.
                if i + 1 >= N || j + 1 >= N {
                    break;
                }
                let mut square = [[p[i][j], p[i][j + 1]], [p[i + 1][j], p[i + 1][j + 1]]];
                for ((v, _), scaled) in terms.iter().zip(&scaled) {
                    for (line, &scaled) in square.iter_mut().zip(scaled) {
                        line[0] -= scaled * v[j];
                        line[1] -= scaled * v[j + 1];
                    }
                }
                let [[a, b], [c, d]] = square;
                (p[j][i], p[j][i + 1]) = (a, c);
                (p[j + 1][i], p[j + 1][i + 1]) = (b, d);
                (p[i][j], p[i][j + 1]) = (a, b);
                (p[i + 1][j], p[i + 1][j + 1]) = (c, d);
            }
            p[i + 1][i] = p[i][i + 1];
        }
    }
}
