//! Which matrix takes what was measured to what it should have been.

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

/// What a regression found.
#[derive(Clone, Debug)]
pub(super) struct Fit<const D: usize> {
    /// Row by row, from measured to expected.
    pub matrix: [[f64; D]; D],
    /// How much of each expected component the measured ones explain, 0 to 1.
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

    /// Takes in a pair, and keeps the running means and products about them (Welford).
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

    /// The fit; `None` of too few pairs, or where a measured component does not move by `least`, rms, by itself: of what
    /// moves only with another nobody can tell which of the two it was.
    pub fn fit(&self, least: f64) -> Option<Fit<D>> {
        let few = LEAST + LEAST_EACH * D as f64;
        if self.count < few { None } else { self.fit_of_any(least) }
    }

    /// [`fit`](Self::fit) of however few.
    fn fit_of_any(&self, least: f64) -> Option<Fit<D>> {
        // xxᵀ M ᵀ = xy, by elimination; the matrix is positive definite but for rounding.
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

/// Fewer pairs than these, and these for each number of a row, tell nothing.
const LEAST: f64 = 12.0;
const LEAST_EACH: f64 = 4.0;
/// Share of the pairs that a [`fit`] leaves out.
const TRIMMED: f64 = 0.2;

/// The fit of pairs `(x, y)` without the fifth of them that it explains least well: a receiver that jumps or stands
/// still for some seconds is no wrong unit. `None` as of [`Regression::fit`].
pub(super) fn fit<const D: usize>(pairs: &[([f64; D], [f64; D])], least: f64) -> Option<Fit<D>> {
    let of = |pairs: &mut dyn Iterator<Item = &([f64; D], [f64; D])>| {
        let mut regression = Regression::NONE;
        for &(x, y) in pairs {
            regression.push(x, y);
        }
        regression
    };
    let whole = of(&mut pairs.iter());
    let Fit { matrix, .. } = whole.fit(least)?;
    let left = |&(x, y): &([f64; D], [f64; D])| -> f64 {
        let off = |row: usize| {
            let model: f64 = (0..D).map(|i| matrix[row][i] * (x[i] - whole.mean_x[i])).sum();
            y[row] - whole.mean_y[row] - model
        };
        (0..D).map(|row| off(row).powi(2)).sum()
    };
    let mut ordered: Vec<_> = pairs.iter().collect();
    ordered.sort_by(|a, b| left(a).total_cmp(&left(b)));
    let kept = ordered.len() - (TRIMMED * ordered.len() as f64) as usize;
    of(&mut ordered[..kept].iter().copied()).fit_of_any(least)
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert!((found - expected).abs() < 1e-9);
        }
        assert!(fit.explained.iter().all(|explained| *explained > 0.999));
        assert!(regression.fit(10.0).is_none());
    }
}
