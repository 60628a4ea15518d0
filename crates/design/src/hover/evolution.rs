//! Minimisation of a function from its values alone.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

/// Random numbers from a seed; `uniform` is the same on every machine.
///
/// # Source
/// Steele, Lea and Flood (2014), *Fast splittable pseudorandom number generators*: SplitMix64. Normal
/// numbers after Box and Muller (1958).
pub(super) struct Random(pub u64);

impl Random {
    /// Uniform from 0 (included) to 1 (excluded).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Normal, of mean 0 and variance 1.
    pub fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}

/// Result of a search.
pub(super) struct Minimum {
    pub at: Vec<f64>,
    pub cost: f64,
    /// Number of points evaluated.
    pub trials: usize,
}

/// Smallest `cost` found around `start` with about `most` evaluations. The first step is `step` in each coordinate; a
/// cost of 0 ends the search. The costs of a generation are computed in parallel.
///
/// The distribution of the points adapts to the shape of the valley. Weights that compensate each other form a narrow
/// valley, in which steps of one weight at a time make no progress.
///
/// # Source
/// Hansen (2016), *The CMA Evolution Strategy: A Tutorial*, arXiv:1604.00772, with its default numbers.
/// Equation (L20) of docs/equations.md.
pub(super) fn minimise(
    start: &[f64],
    step: f64,
    most: usize,
    seed: u64,
    cost: impl Fn(&[f64]) -> f64 + Sync,
) -> Minimum {
    let n = start.len();
    let size = n as f64;
    let drawn = 4 + (3.0 * size.ln()) as usize;
    let parents = drawn / 2;
    let share = |rank: usize| (0.5 * (drawn as f64 + 1.0)).ln() - ((rank + 1) as f64).ln();
    let sum: f64 = (0..parents).map(share).sum();
    let shares: Vec<f64> = (0..parents).map(|rank| share(rank) / sum).collect();
    let effective = 1.0 / shares.iter().map(|share| share * share).sum::<f64>();
    // Forgetting rates of each path and of the covariance.
    let of_path = (4.0 + effective / size) / (size + 4.0 + 2.0 * effective / size);
    let of_step = (effective + 2.0) / (size + effective + 5.0);
    let rank_one = 2.0 / ((size + 1.3).powi(2) + effective);
    let rank_many = f64::min(
        1.0 - rank_one,
        2.0 * (effective - 2.0 + 1.0 / effective) / ((size + 2.0).powi(2) + effective),
    );
    let damping = 1.0 + of_step + 2.0 * (((effective - 1.0) / (size + 1.0)).sqrt() - 1.0).max(0.0);
    let expected = size.sqrt() * (1.0 - 1.0 / (4.0 * size) + 1.0 / (21.0 * size * size));

    let mut random = Random(seed);
    let mut mean = DVector::from_row_slice(start);
    let mut covariance = DMatrix::<f64>::identity(n, n);
    let (mut path, mut step_path) = (DVector::<f64>::zeros(n), DVector::<f64>::zeros(n));
    let mut step = step;
    let mut best = Minimum { at: start.to_vec(), cost: cost(start), trials: 1 };
    let mut kept = 1.0;
    while best.trials < most && best.cost > 0.0 && step > 1e-4 {
        let axes = covariance.clone().symmetric_eigen();
        let lengths = axes.eigenvalues.map(|value| value.max(1e-16).sqrt());
        let shaped = &axes.eigenvectors * DMatrix::from_diagonal(&lengths);
        let steps: Vec<DVector<f64>> =
            (0..drawn).map(|_| &shaped * DVector::from_fn(n, |_, _| random.normal())).collect();
        let points: Vec<DVector<f64>> = steps.iter().map(|own| &mean + own * step).collect();
        let costs = side_by_side(&points, |point| cost(point.as_slice()));
        best.trials += drawn;
        let mut order: Vec<usize> = (0..drawn).collect();
        order.sort_by(|&one, &other| costs[one].total_cmp(&costs[other]));
        if costs[order[0]] < best.cost {
            best.cost = costs[order[0]];
            best.at = points[order[0]].as_slice().to_vec();
        }
        let taken = || order.iter().map(|&at| &steps[at]).zip(&shares);
        let moved = taken().fold(DVector::zeros(n), |sum, (own, &share)| sum + own * share);
        mean += &moved * step;
        let unshaped = axes.eigenvectors.tr_mul(&moved).component_div(&lengths);
        step_path = step_path * (1.0 - of_step)
            + &axes.eigenvectors * unshaped * (of_step * (2.0 - of_step) * effective).sqrt();
        kept *= (1.0 - of_step).powi(2);
        let length = step_path.norm() / f64::sqrt(1.0 - kept) / expected;
        let follows = if length < 1.4 + 2.0 / (size + 1.0) { 1.0 } else { 0.0 };
        path = path * (1.0 - of_path)
            + &moved * (follows * (of_path * (2.0 - of_path) * effective).sqrt());
        let lost = (1.0 - follows) * of_path * (2.0 - of_path);
        covariance *= 1.0 - rank_one * (1.0 - lost) - rank_many;
        covariance.ger(rank_one, &path, &path, 1.0);
        for (own, &share) in taken() {
            covariance.ger(rank_many * share, own, own, 1.0);
        }
        step *= (of_step / damping * (step_path.norm() / expected - 1.0)).exp();
    }
    best
}

/// Results of `work` for all points, in their order, on as many threads as the machine has processors.
pub(super) fn side_by_side<P: Sync, R: Send>(
    points: &[P],
    work: impl Fn(&P) -> R + Sync,
) -> Vec<R> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let each = points.len().div_ceil(threads).max(1);
    let work = &work;
    std::thread::scope(|scope| {
        let parts = points.chunks(each);
        let parts: Vec<_> = parts
            .map(|part| scope.spawn(move || part.iter().map(work).collect::<Vec<R>>()))
            .collect();
        let done = parts.into_iter().map(|part| match part.join() {
            Ok(done) => done,
            Err(panic) => std::panic::resume_unwind(panic),
        });
        done.flatten().collect()
    })
}
