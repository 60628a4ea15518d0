//! Whiteness of the residuals, and their independence of the inputs.

use nalgebra::{DMatrix, DVector};

/// The 99 % bound of a standard normal variable, two-sided.
const NORMAL_99: f64 = 2.575_829;

/// A correlation function with its confidence bound.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrelationTest {
    /// Correlation coefficients, −1 to 1, from lag `first_lag` on.
    pub correlations: Vec<f64>,
    /// The first lag, samples.
    pub first_lag: usize,
    /// 99 % confidence bound of the coefficients of an uncorrelated residual.
    pub bound: f64,
}

impl CorrelationTest {
    /// Number of coefficients outside the bound.
    #[must_use]
    pub fn outside(&self) -> usize {
        self.correlations.iter().filter(|value| value.abs() > self.bound).count()
    }

    /// Whether the residual is significantly correlated: more coefficients outside the bound than chance causes in 1 %
    /// of all cases.
    #[must_use]
    pub fn something_left(&self) -> bool {
        self.outside() > chance_outside(self.correlations.len())
    }
}

/// Smallest number that a binomial count exceeds in less than 1 % of all cases. The count has `lags` trials with a
/// probability of 1 % each.
fn chance_outside(lags: usize) -> usize {
    let mut exactly = 0.99_f64.powi(lags as i32);
    let mut at_most = exactly;
    let mut count = 0;
    while at_most < 0.99 && count < lags {
        exactly *= (lags - count) as f64 / (count + 1) as f64 * (0.01 / 0.99);
        at_most += exactly;
        count += 1;
    }
    count
}

/// Tests of all residuals.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualTest {
    /// Each output's residual against its own past, lags 1 and up: correlation means coloured noise that the noise
    /// model misses.
    pub own_past: Vec<CorrelationTest>,
    /// Each output's residual (outer) against each input (inner), lags 0 and up: correlation means dynamics that the
    /// model misses.
    pub inputs: Vec<Vec<CorrelationTest>>,
}

impl ResidualTest {
    /// Whether no residual is correlated with its past or the inputs.
    #[must_use]
    pub fn nothing_left(&self) -> bool {
        let all = self.own_past.iter().chain(self.inputs.iter().flatten());
        !all.into_iter().any(CorrelationTest::something_left)
    }
}

/// Tests `residuals` (samples × outputs) against their own past and the `inputs` (samples × inputs)
/// up to `lags`.
///
/// # Panics
/// Where the numbers of samples differ, or are not above `lags`.
///
/// # Source
/// Ljung, eqs. 16.65 to 16.68: against the own past the bound is that of white noise; against an input that of two
/// independent coloured signals. Equation (I24) of docs/equations.md.
#[must_use]
pub fn residual_test(residuals: &DMatrix<f64>, inputs: &DMatrix<f64>, lags: usize) -> ResidualTest {
    assert!(residuals.nrows() == inputs.nrows() && residuals.nrows() > lags);
    let samples = residuals.nrows() as f64;
    let centred = |signals: &DMatrix<f64>| -> Vec<DVector<f64>> {
        signals.column_iter().map(|signal| signal.add_scalar(-signal.mean())).collect()
    };
    let (residuals, inputs) = (centred(residuals), centred(inputs));
    let own = |signal: &DVector<f64>| correlations(signal, signal, 0..=lags);
    let input_own: Vec<Vec<f64>> = inputs.iter().map(own).collect();
    let mut test = ResidualTest { own_past: Vec::new(), inputs: Vec::new() };
    for residual in &residuals {
        let residual_own = own(residual);
        let against_input = |(input, input_own): (&DVector<f64>, &Vec<f64>)| {
            let both: f64 = residual_own[1..].iter().zip(&input_own[1..]).map(|(a, b)| a * b).sum();
            let spread = (1.0 + 2.0 * both).max(0.1);
            CorrelationTest {
                correlations: correlations(residual, input, 0..=lags),
                first_lag: 0,
                bound: NORMAL_99 * (spread / samples).sqrt(),
            }
        };
        test.inputs.push(inputs.iter().zip(&input_own).map(against_input).collect());
        test.own_past.push(CorrelationTest {
            correlations: residual_own[1..].to_vec(),
            first_lag: 1,
            bound: NORMAL_99 / samples.sqrt(),
        });
    }
    test
}

/// Correlation of `later` with `earlier`, shifted by each lag; zero where a signal is constant.
fn correlations(
    later: &DVector<f64>,
    earlier: &DVector<f64>,
    lags: std::ops::RangeInclusive<usize>,
) -> Vec<f64> {
    let scale = later.norm() * earlier.norm();
    lags.map(|lag| {
        let both = later.len() - lag;
        let sum = later.rows(lag, both).dot(&earlier.rows(0, both));
        if scale > 0.0 { sum / scale } else { 0.0 }
    })
    .collect()
}
