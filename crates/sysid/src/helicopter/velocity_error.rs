//! Error of the velocity used for identification.

use hovernav::ekf::Solution;
use hovernav::gps::Fix;

/// The error of a measured velocity: first-order Gauss–Markov on each axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityError {
    /// Error of u and v.
    pub horizontal: SlowError,
    /// Error of w.
    pub vertical: SlowError,
}

/// A first-order Gauss–Markov error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowError {
    /// One sigma, m/s.
    pub sigma: f64,
    /// Correlation time, s.
    pub time_s: f64,
}

impl SlowError {
    /// σ of the noise that drives the error, held from sample to sample, m/s².
    #[must_use]
    pub fn drive(&self, period_s: f64) -> f64 {
        let kept = (-period_s / self.time_s).exp();
        self.sigma * (1.0 - kept * kept).sqrt() / (self.time_s * (1.0 - kept))
    }
}

impl VelocityError {
    /// Negligible error.
    pub const NONE: Self = Self {
        horizontal: SlowError { sigma: 1e-6, time_s: 1.0 },
        vertical: SlowError { sigma: 1e-6, time_s: 1.0 },
    };

    /// Error of smoothed `solutions`, from their own one-sigma and the scatter of the fixes about them.
    ///
    /// A smoother blends accelerometers of white error with velocity fixes of density r = σ²T. Here σ is the one-sigma
    /// of a fix, and T the interval between fixes. The error of the blend is exactly first-order Gauss–Markov. Its
    /// correlation time is r / 2σₑ², with its one-sigma σₑ.
    ///
    /// # Source
    /// Equation (I26) of docs/equations.md.
    #[must_use]
    pub fn of(solutions: &[Solution], fixes: &[Fix]) -> Self {
        let (mut scatter, mut stated, mut count) = ([0.0; 3], [0.0; 3], 0.0);
        for fix in fixes {
            let at = solutions.partition_point(|solution| solution.time < fix.time);
            let (Some(solution), Some(velocity)) = (solutions.get(at), fix.velocity_mps()) else {
                continue;
            };
            if solution.time - fix.time > FAR_S {
                continue;
            }
            let off = (velocity - solution.velocity_mps).to_array();
            let sigma = solution.velocity_sigma_mps.to_array();
            for axis in 0..3 {
                scatter[axis] += off[axis] * off[axis];
                stated[axis] += sigma[axis] * sigma[axis];
            }
            count += 1.0;
        }
        let span_s = match (solutions.first(), solutions.last()) {
            (Some(first), Some(last)) if count > 1.0 => last.time - first.time,
            _ => return Self::UNKNOWN,
        };
        let interval_s = span_s / count;
        let error = |scatter: f64, stated: f64| {
            let (scatter, stated) = (scatter / count, (stated / count).max(1e-8));
            let time_s = (scatter + stated) * interval_s / (2.0 * stated);
            SlowError { sigma: stated.sqrt(), time_s: time_s.clamp(SHORTEST_S, LONGEST_S) }
        };
        Self {
            horizontal: error(0.5 * (scatter[0] + scatter[1]), 0.5 * (stated[0] + stated[1])),
            vertical: error(scatter[2], stated[2]),
        }
    }

    /// Error of a typical receiver, assumed for flights without velocity fixes.
    const UNKNOWN: Self = Self {
        horizontal: SlowError { sigma: 0.05, time_s: 5.0 },
        vertical: SlowError { sigma: 0.08, time_s: 8.0 },
    };
}

/// Longest time from a fix to the solution that it is compared with, s.
const FAR_S: f64 = 0.2;
/// Smallest correlation time, s.
const SHORTEST_S: f64 = 0.5;
/// Largest correlation time, s.
const LONGEST_S: f64 = 60.0;

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn the_drive_keeps_the_error_at_its_size() {
        let error = SlowError { sigma: 0.05, time_s: 8.0 };
        let period_s = 0.03;
        let kept = f64::exp(-period_s / error.time_s);
        let step = error.drive(period_s) * error.time_s * (1.0 - kept);
        let variance = (0..10_000).fold(0.0, |variance, _| kept * kept * variance + step * step);
        assert_abs_diff_eq!(variance.sqrt() / 0.05, 1.0, epsilon = 1e-9);
    }
}
