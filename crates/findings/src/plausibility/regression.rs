//! Linear regressions from measured to expected values.

use hovernav_dataset::statistics::quantile;

/// Least squares of `M x + b = y`, gathered pair by pair.
#[derive(Clone, Debug)]
pub(super) struct Regression<const D: usize> {
    count: f64,
    mean_x: [f64; D],
    mean_y: [f64; D],
    xx: [[f64; D]; D],
    xy: [[f64; D]; D],
    yy: [f64; D],
}

/// Result of a regression.
#[derive(Clone, Debug)]
pub(super) struct Fit<const D: usize> {
    /// Matrix from measured to expected values, row by row.
    pub matrix: [[f64; D]; D],
    /// Fraction of each expected component that the fit explains, 0 to 1.
    pub explained: [f64; D],
}

impl<const D: usize> Regression<D> {
    pub const NONE: Self = Self {
        count: 0.0,
        mean_x: [0.0; D],
        mean_y: [0.0; D],
        xx: [[0.0; D]; D],
        xy: [[0.0; D]; D],
        yy: [0.0; D],
    };

    /// Adds a pair; keeps running means and the products about them (Welford).
    pub fn push(&mut self, x: [f64; D], y: [f64; D]) {
        self.count += 1.0;
        let old_x: [f64; D] = std::array::from_fn(|i| x[i] - self.mean_x[i]);
        let old_y: [f64; D] = std::array::from_fn(|i| y[i] - self.mean_y[i]);
        for i in 0..D {
            self.mean_x[i] += old_x[i] / self.count;
            self.mean_y[i] += old_y[i] / self.count;
        }
        for i in 0..D {
            for j in 0..D {
                self.xx[i][j] += old_x[i] * (x[j] - self.mean_x[j]);
                self.xy[i][j] += old_x[i] * (y[j] - self.mean_y[j]);
            }
            self.yy[i] += old_y[i] * (y[i] - self.mean_y[i]);
        }
    }

    /// Root mean square of all measured components together, about their means.
    fn spread(&self) -> f64 {
        ((0..D).map(|i| self.xx[i][i]).sum::<f64>() / self.count).sqrt()
    }

    /// The fit. `None` with too few pairs, or if the independent motion of a measured component is below `least`, rms:
    /// then the components cannot be separated.
    pub fn fit(&self, least: f64) -> Option<Fit<D>> {
        let few = MIN + MIN_EACH * D as f64;
        if self.count < few { None } else { self.fit_of_any(least) }
    }

    /// [`fit`](Self::fit) with any number of pairs.
    fn fit_of_any(&self, least: f64) -> Option<Fit<D>> {
        // Solves xx Mᵀ = xy for the matrix M of the fit, by elimination. The matrix xx is positive definite except for
        // rounding.
        let (mut a, mut b) = (self.xx, self.xy);
        for i in 0..D {
            let pivot = a[i][i];
            if pivot <= least * least * self.count {
                return None;
            }
            for row in i + 1..D {
                let factor = a[row][i] / pivot;
                for column in 0..D {
                    a[row][column] -= factor * a[i][column];
                    b[row][column] -= factor * b[i][column];
                }
            }
        }
        let mut solution = [[0.0; D]; D];
        for i in (0..D).rev() {
            for column in 0..D {
                let known: f64 = (i + 1..D).map(|j| a[i][j] * solution[j][column]).sum();
                solution[i][column] = (b[i][column] - known) / a[i][i];
            }
        }
        let matrix = std::array::from_fn(|row| std::array::from_fn(|column| solution[column][row]));
        let explained = std::array::from_fn(|row| {
            let model: f64 = (0..D).map(|i| solution[i][row] * self.xy[i][row]).sum();
            (model / self.yy[row].max(1e-300)).clamp(0.0, 1.0)
        });
        Some(Fit { matrix, explained })
    }
}

/// Ratio of two quantities, by regression through the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// `y / x`, and its one-sigma.
    pub scale: f64,
    pub sigma: f64,
    /// Fraction of y that the scale explains, 0 to 1.
    pub explained: f64,
}

impl Scale {
    /// Least squares of `scale x = y`; `None` with fewer than two `pairs`, or if x or y is zero throughout.
    pub fn of(pairs: &[(f64, f64)]) -> Option<Self> {
        let sum = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>();
        let (xx, xy, yy) = (sum(|p| p.0 * p.0), sum(|p| p.0 * p.1), sum(|p| p.1 * p.1));
        if pairs.len() < 2 || xx == 0.0 || yy == 0.0 {
            return None;
        }
        let scale = xy / xx;
        let left = (yy - scale * xy).max(0.0);
        let sigma = (left / (pairs.len() - 1) as f64 / xx).sqrt();
        Some(Self { scale, sigma, explained: 1.0 - left / yy })
    }
}

/// Smallest number of pairs for a fit.
const MIN: f64 = 12.0;
/// Smallest number of additional pairs for each entry of a row.
const MIN_EACH: f64 = 4.0;
/// Fraction of the pairs that [`fit`] ignores.
const TRIMMED: f64 = 0.2;
/// Smallest independent spread of a component, as a fraction of the spread of all components. An error in one of two
/// components shows in the other.
const ALONE: f64 = 0.15;
/// Rounds in which the pairs that follow the fit are chosen.
const ROUNDS: usize = 6;
/// Largest residual of a pair that follows the fit, in median residuals.
const NEAR: f64 = 4.0;
/// Largest residual of a pair that follows the fit, as a fraction of the pair's size; the larger of the two limits
/// applies.
const SHARE: f64 = 0.3;
/// Size of a pair, in median residuals, above which the pair counts as moving.
const MOVES: f64 = 3.0;
/// Smallest fraction of the moving pairs that follow the fit.
const FOLLOWED: f64 = 0.5;
/// Smallest number of moving pairs.
const MIN_MOVING: usize = 3;

/// Fit that most of the moving pairs `(x, y)` follow, each with one vote. The fifth of the pairs with the largest
/// residuals is ignored. So a receiver that jumps or freezes for a minute does not look like a wrong unit. `explained`
/// is zero if too few of the moving pairs follow. `None` as in [`Regression::fit`].
pub(super) fn fit<const D: usize>(pairs: &[([f64; D], [f64; D])], least: f64) -> Option<Fit<D>> {
    let whole = Regression::of(pairs);
    whole.fit(least.max(ALONE * whole.spread()))?;
    let (mut chosen, mut judged) = (whole, Vec::new());
    for _ in 0..ROUNDS {
        judged = chosen.judge(pairs)?;
        let following = pairs.iter().zip(&judged).filter(|(_, judged)| judged.follows);
        chosen = Regression::of(following.map(|(pair, _)| pair));
    }
    let mut kept: Vec<_> = pairs.iter().zip(&judged).collect();
    kept.sort_by(|a, b| a.1.residual.total_cmp(&b.1.residual));
    kept.truncate(kept.len() - (TRIMMED * kept.len() as f64) as usize);
    let following = kept.iter().filter(|(_, judged)| judged.follows);
    let kept = Regression::of(following.map(|(pair, _)| *pair));
    let mut fit = kept.fit_of_any(least.max(ALONE * kept.spread()))?;
    let moving = judged.iter().filter(|judged| judged.moves);
    let [count, follow] = moving
        .fold([0; 2], |[count, follow], judged| [count + 1, follow + usize::from(judged.follows)]);
    if count < MIN_MOVING || (follow as f64) < FOLLOWED * count as f64 {
        fit.explained = [0.0; D];
    }
    Some(fit)
}

/// One pair compared with a fit.
struct Against {
    residual: f64,
    follows: bool,
    moves: bool,
}

impl<const D: usize> Regression<D> {
    fn of<'a>(pairs: impl IntoIterator<Item = &'a ([f64; D], [f64; D])>) -> Self {
        let mut regression = Self::NONE;
        pairs.into_iter().for_each(|&(x, y)| regression.push(x, y));
        regression
    }

    /// Compares the `pairs` with the fit; `None` if a measured component does not move.
    fn judge(&self, pairs: &[([f64; D], [f64; D])]) -> Option<Vec<Against>> {
        let Fit { matrix, .. } = self.fit_of_any(0.0)?;
        // Residual, and the larger of the measured and the explained displacement.
        let sizes = pairs.iter().map(|(x, y)| {
            let moved: [f64; D] = std::array::from_fn(|row| y[row] - self.mean_y[row]);
            let model: [f64; D] = std::array::from_fn(|row| {
                (0..D).map(|i| matrix[row][i] * (x[i] - self.mean_x[i])).sum()
            });
            let residual = norm(std::array::from_fn::<f64, D, _>(|row| moved[row] - model[row]));
            (residual, norm(moved).max(norm(model)))
        });
        let sizes: Vec<(f64, f64)> = sizes.collect();
        let mut residuals: Vec<f64> = sizes.iter().map(|(residual, _)| *residual).collect();
        let usual = quantile(&mut residuals, 0.5)?;
        let against = |&(residual, size): &(f64, f64)| Against {
            residual,
            follows: residual <= (NEAR * usual).max(SHARE * size),
            moves: size > MOVES * usual,
        };
        Some(sizes.iter().map(against).collect())
    }
}

/// Length of a vector.
pub(super) fn norm<const D: usize>(vector: [f64; D]) -> f64 {
    vector.into_iter().fold(0.0, f64::hypot)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_matrix_is_found_again() {
        let truth = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.5]];
        let mut regression = Regression::NONE;
        for k in 0..100 {
            let t = f64::from(k);
            let x = [t.sin(), (1.7 * t).cos(), (0.3 * t).sin()];
            let y = truth.map(|row: [f64; 3]| {
                row.iter().zip(x).map(|(entry, x)| entry * x).sum::<f64>() + 3.0
            });
            regression.push(x, y);
        }
        let fit = regression.fit(0.1).unwrap();
        for (found, expected) in fit.matrix.iter().flatten().zip(truth.iter().flatten()) {
            assert_abs_diff_eq!(found, expected, epsilon = 1e-9);
        }
        assert!(fit.explained.iter().all(|explained| *explained > 0.999));
        assert!(regression.fit(10.0).is_none());
    }

    #[test]
    fn a_scale_is_found_again_with_how_sure_it_is() {
        // Alternating errors of 0.1 that no scale explains.
        let pairs: Vec<_> = (1..=20)
            .map(|k| (f64::from(k), 0.3 * f64::from(k) + if k % 2 == 0 { 0.1 } else { -0.1 }))
            .collect();
        let Scale { scale, sigma, explained } = Scale::of(&pairs).unwrap();
        let (xx, size) = (2870.0f64, 0.1f64);
        assert_abs_diff_eq!(scale, 0.3, epsilon = 3.0 * sigma);
        assert!(explained > 0.99);
        assert_abs_diff_eq!(
            sigma / (size * (20.0f64 / 19.0).sqrt() / xx.sqrt()),
            1.0,
            epsilon = 0.01
        );
        assert_eq!(Scale::of(&[(0.0, 1.0), (0.0, 2.0)]), None);
        assert_eq!(Scale::of(&[(1.0, 1.0)]), None);
    }
}
