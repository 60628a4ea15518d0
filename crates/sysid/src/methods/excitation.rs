//! Checks that the inputs excite the system independently of each other.

use std::fmt;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::methods::frequency::{Band, SpectrumSettings, Window, spectra};
use crate::record::Experiment;
use hovernav_model::linalg::least_squares;

/// A fault of the inputs of a record.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum InputFault {
    /// The input never moves.
    Constant {
        /// The input.
        input: String,
    },
    /// The input is exactly constant for a large part of the record.
    Still {
        /// The input.
        input: String,
        /// Rows of its longest rest.
        rows: Range<usize>,
        /// Start and end of the longest rest, s from the first sample.
        span_s: [f64; 2],
    },
    /// The input is nearly a combination of the others: their effects cannot be separated.
    Collinear {
        /// The input.
        input: String,
        /// Fraction of the input's variance that the other inputs explain, 0 to 1.
        explained: f64,
    },
    /// Two inputs move together over the frequencies at which the first moves.
    Coherent {
        /// The inputs.
        inputs: [String; 2],
        /// Coherence of both inputs, averaged over frequency with the power of the first input as weight, 0 to 1.
        coherence: f64,
    },
}

impl fmt::Display for InputFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Constant { input } => write!(f, "input `{input}` never moves"),
            Self::Still { input, span_s: [from, to], .. } => write!(
                f,
                "input `{input}` does not move from {from:.2} s to {to:.2} s: this part contains \
                     no information about it"
            ),
            Self::Collinear { input, explained } => write!(
                f,
                "input `{input}` is to {:.0} % a combination of the others: their effects cannot \
                     be separated",
                100.0 * explained
            ),
            Self::Coherent { inputs: [one, other], coherence } => write!(
                f,
                "inputs `{one}` and `{other}` move together: average coherence {coherence:.2}"
            ),
        }
    }
}

/// Properties of the inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct InputReport {
    /// Correlation of the inputs, inputs × inputs; zero in the rows of constant inputs.
    pub correlation: DMatrix<f64>,
    /// Power-averaged coherence of each pair, inputs × inputs, 1 on the diagonal. Empty where the
    /// record is too short for spectra.
    pub coherence: DMatrix<f64>,
    /// Condition number of the moving inputs' correlation: 1 is ideal.
    pub condition: f64,
    /// Faults found.
    pub faults: Vec<InputFault>,
}

/// Longest permitted rest of an input, as a fraction of the record.
const STILL_PART: f64 = 0.4;
/// Largest fraction of an input's variance that the other inputs may explain.
const COLLINEAR: f64 = 0.9;
/// Largest average coherence of two inputs: the limit of Tischler & Remple, section 5.7.
const COHERENT: f64 = 0.5;

/// Checks each input, each pair, and all inputs together.
#[must_use]
pub fn check_inputs(experiment: &Experiment) -> InputReport {
    let samples = experiment.samples();
    let names = &experiment.input_names;
    let mut faults = Vec::new();
    let mut moving = Vec::new();
    for (column, input) in experiment.inputs.column_iter().enumerate() {
        let rest = longest_rest(input.as_slice());
        if rest.len() == samples {
            faults.push(InputFault::Constant { input: names[column].clone() });
            continue;
        }
        moving.push(column);
        if rest.len() as f64 > STILL_PART * samples as f64 {
            let span_s = [rest.start, rest.end].map(|row| row as f64 * experiment.period_s);
            faults.push(InputFault::Still { input: names[column].clone(), rows: rest, span_s });
        }
    }

    let inputs = names.len();
    let unit: Vec<DVector<f64>> = moving
        .iter()
        .map(|&column| {
            let input = experiment.inputs.column(column);
            (input.add_scalar(-input.mean())).normalize()
        })
        .collect();
    let mut correlation = DMatrix::zeros(inputs, inputs);
    for (&row, one) in moving.iter().zip(&unit) {
        for (&column, other) in moving.iter().zip(&unit) {
            correlation[(row, column)] = one.dot(other);
        }
    }
    for (index, &column) in moving.iter().enumerate().filter(|_| moving.len() > 1) {
        let others: Vec<_> = unit
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != index)
            .map(|(_, u)| u.clone())
            .collect();
        let others = DMatrix::from_columns(&others);
        let own = DMatrix::from_columns(&unit[index..=index]);
        let left = &own - &others * least_squares(others.clone(), &own);
        let explained = 1.0 - left.norm_squared();
        if explained > COLLINEAR {
            faults.push(InputFault::Collinear { input: names[column].clone(), explained });
        }
    }
    let condition = if moving.is_empty() {
        f64::INFINITY
    } else {
        let values =
            correlation.select_rows(&moving).select_columns(&moving).symmetric_eigenvalues();
        values.max() / values.min().max(0.0)
    };
    let coherence = coherence(experiment, &moving);
    for row in 0..coherence.nrows() {
        for column in row + 1..coherence.ncols() {
            let largest: f64 = coherence[(row, column)].max(coherence[(column, row)]);
            if largest > COHERENT {
                let inputs = [names[row].clone(), names[column].clone()];
                faults.push(InputFault::Coherent { inputs, coherence: largest });
            }
        }
    }
    InputReport { correlation, coherence, condition, faults }
}

/// Rows of the longest run of a single value.
fn longest_rest(values: &[f64]) -> Range<usize> {
    let (mut longest, mut start) = (0..0, 0);
    for sample in 0..values.len() {
        if values[sample] != values[start] {
            start = sample;
        }
        if sample + 1 - start > longest.len() {
            longest = start..sample + 1;
        }
    }
    longest
}

/// Coherence of each pair of inputs: mean over frequency, weighted by the power spectrum of the row's input. Zero
/// for a pair with a constant input. Empty if the spectra cannot be computed.
fn coherence(experiment: &Experiment, moving: &[usize]) -> DMatrix<f64> {
    let window = experiment.samples() / 8;
    let rate_hz = experiment.period_s.recip();
    let settings = SpectrumSettings {
        window_s: window as f64 * experiment.period_s,
        overlap: 0.5,
        window: Window::Hann,
        band: Band {
            first_hz: rate_hz / window.max(1) as f64,
            last_hz: 0.5 * rate_hz,
            points: window / 2,
        },
    };
    let Ok(spectra) = spectra(&[&experiment.inputs], experiment.period_s, &settings) else {
        return DMatrix::zeros(0, 0);
    };
    let inputs = experiment.inputs.ncols();
    DMatrix::from_fn(inputs, inputs, |row, column| {
        if row == column {
            return 1.0;
        }
        if !(moving.contains(&row) && moving.contains(&column)) {
            return 0.0;
        }
        let (mut sum, mut power) = (0.0, 0.0);
        for density in &spectra.densities {
            let (own, other) = (density[(row, row)].re, density[(column, column)].re);
            if own > 0.0 && other > 0.0 {
                sum += density[(row, column)].norm_sqr() / other;
                power += own;
            }
        }
        if power > 0.0 { sum / power } else { 0.0 }
    })
}
