//! The thesis's velocity: a fourth-order polynomial through 1 Hz GPS.

use nalgebra::DMatrix;

use super::PreprocessError;
use hovernav_model::linalg::least_squares;

/// Order of the thesis's polynomial.
const ORDER: usize = 4;
/// Length of the fitted pieces, s.
const PIECE_S: f64 = 12.0;

/// One component of GPS velocity, smoothed by a fourth-order least-squares polynomial per 12 s piece and evaluated at
/// `at_s`. For comparison only: it lags, cuts corners and jumps between pieces. [`hovernav::ekf`] is better in all
/// three respects.
///
/// Times are seconds on one clock; values and result have the same unit. Each piece contains the fixes from its start
/// to its end, both included.
///
/// # Errors
/// [`PreprocessError::TooShort`] where a piece contains too few fixes.
///
/// # Source
/// Paw (2005), chapter 5: GPS velocity is held at 1 Hz and smoothed in this way.
pub fn polynomial_velocity(
    times_s: &[f64],
    values: &[f64],
    at_s: &[f64],
) -> Result<Vec<f64>, PreprocessError> {
    let start = times_s.first().copied().unwrap_or(0.0);
    let span = times_s.last().copied().unwrap_or(0.0) - start;
    // An incomplete last piece is fitted together with the one before.
    let pieces = ((span / PIECE_S) as usize).max(1);
    let mut fitted: Vec<Option<[f64; ORDER + 1]>> = vec![None; pieces];
    at_s.iter()
        .map(|&time_s| {
            let piece = (((time_s - start) / PIECE_S).max(0.0) as usize).min(pieces - 1);
            let from = start + piece as f64 * PIECE_S;
            let coefficients = match fitted[piece] {
                Some(coefficients) => coefficients,
                None => {
                    let to = if piece + 1 == pieces { f64::INFINITY } else { from + PIECE_S };
                    *fitted[piece].insert(polynomial(times_s, values, from, to)?)
                }
            };
            let scaled = (time_s - from) / PIECE_S;
            Ok(coefficients.iter().rev().fold(0.0, |sum, value| sum * scaled + value))
        })
        .collect()
}

/// Coefficients of the least-squares polynomial.
///
/// # Source
/// Equation (I4) of docs/equations.md.
fn polynomial(
    times_s: &[f64],
    values: &[f64],
    from: f64,
    to: f64,
) -> Result<[f64; ORDER + 1], PreprocessError> {
    let inside: Vec<(f64, f64)> = times_s
        .iter()
        .zip(values)
        .filter(|(time_s, _)| (from..=to).contains(*time_s))
        .map(|(time_s, value)| ((time_s - from) / PIECE_S, *value))
        .collect();
    if inside.len() <= ORDER {
        return Err(PreprocessError::TooShort {
            what: "a fourth-order polynomial",
            samples: inside.len(),
            needed: ORDER,
        });
    }
    let powers =
        DMatrix::from_fn(inside.len(), ORDER + 1, |row, power| inside[row].0.powi(power as i32));
    let values = DMatrix::from_fn(inside.len(), 1, |row, _| inside[row].1);
    let solution = least_squares(powers, &values);
    Ok(std::array::from_fn(|power| solution[(power, 0)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_quartic_is_reproduced_and_a_quick_reversal_is_not() {
        let times: Vec<f64> = (0..=24).map(f64::from).collect();
        let quartic = |t: f64| 0.3 - 0.2 * t + 0.01 * t.powi(4) / 100.0;
        let values: Vec<f64> = times.iter().map(|&t| quartic(t)).collect();
        let smooth = polynomial_velocity(&times, &values, &[0.0, 3.3, 11.9, 12.1, 24.0]).unwrap();
        for (value, t) in smooth.iter().zip([0.0, 3.3, 11.9, 12.1, 24.0]) {
            assert_abs_diff_eq!(*value, quartic(t), epsilon = 1e-9);
        }
        let doublet: Vec<f64> =
            times.iter().map(|&t| if (t - 6.0).abs() < 1.5 { 1.0 } else { 0.0 }).collect();
        let cut = polynomial_velocity(&times, &doublet, &[6.0]).unwrap();
        assert!(cut[0] < 0.8, "a pulse of three seconds is cut to {}", cut[0]);
    }

    #[test]
    fn too_few_fixes_are_refused() {
        assert!(polynomial_velocity(&[0.0, 1.0, 2.0, 3.0], &[0.0; 4], &[1.0]).is_err());
    }
}
