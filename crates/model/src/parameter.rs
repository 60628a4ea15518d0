//! Parameters of a model, their uncertainty, and their effect on its matrices.

use nalgebra::DMatrix;

use super::error::ModelError;
use super::signal::check_unique;

/// A parameter from which the matrices were computed.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub struct Parameter {
    /// Name, for example `Lp`.
    pub name: String,
    /// Value, in the unit `unit`.
    pub value: f64,
    /// Unit.
    pub unit: String,
}

/// Derivative of an entry of A or B with respect to a parameter.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub struct Slope {
    /// Name of the parameter.
    pub parameter: String,
    /// State of the row. The parameter changes its derivative, or its next value in a discrete model.
    pub row: String,
    /// The state or input that the entry multiplies: a state for an entry of A, an input for B.
    pub column: String,
    /// Derivative of the entry with respect to the parameter: unit of the entry per unit of the parameter.
    pub slope: f64,
}

/// Lowest eigenvalue of a correlation matrix, divided by the number of parameters, that rounding can cause. With a
/// lower one the matrix is invalid.
const ROUNDING: f64 = -1e-6;

/// Rejects an empty or repeated name, a value that is not finite, and an impossible stick delay or servo lag.
pub(super) fn check_parameters(parameters: &[Parameter]) -> Result<(), ModelError> {
    check_unique("parameters", parameters.iter().map(|parameter| parameter.name.as_str()))?;
    for parameter in parameters {
        let found = parameter.value;
        if !found.is_finite() {
            return Err(rejected(parameter, "found a value that is not finite, expected a number"));
        }
        match parameter.name.split_once('_') {
            Some(("tau", "lat" | "lon" | "col" | "ped")) if !(-0.05..=1.0).contains(&found) => {
                return Err(rejected(parameter, "found a stick's delay outside -0.05 to 1 s"));
            }
            Some(("lag", _)) if !(0.0..=1.0).contains(&found) => {
                return Err(rejected(parameter, "found a servo's lag outside 0 to 1 s"));
            }
            _ => {}
        }
    }
    Ok(())
}

/// Rejects a `covariance` that is invalid for `parameters`. The caller must have checked its size and that its values
/// are finite.
pub(super) fn check_covariance(
    parameters: &[Parameter],
    covariance: &DMatrix<f64>,
) -> Result<(), ModelError> {
    for (row, parameter) in parameters.iter().enumerate() {
        if covariance[(row, row)] < 0.0 {
            return Err(rejected(parameter, "found a variance below 0"));
        }
        for column in 0..row {
            let [above, below] = [covariance[(column, row)], covariance[(row, column)]];
            let scale = covariance[(row, row)].sqrt() * covariance[(column, column)].sqrt();
            // The comparison also rejects a NaN.
            let even = (above - below).abs() <= 1e-9 * scale;
            if !even {
                return Err(rejected(parameter, "found a covariance that is not symmetric"));
            }
            if above.abs() > (1.0 + 1e-6) * scale {
                return Err(rejected(parameter, "found a correlation beyond 1"));
            }
        }
    }
    let known: Vec<usize> =
        (0..parameters.len()).filter(|&at| covariance[(at, at)] > 0.0).collect();
    if known.is_empty() {
        return Ok(());
    }
    let correlations = DMatrix::from_fn(known.len(), known.len(), |row, column| {
        let (row, column) = (known[row], known[column]);
        covariance[(row, column)]
            / covariance[(row, row)].sqrt()
            / covariance[(column, column)].sqrt()
    });
    let axes = correlations.symmetric_eigen();
    let least = (0..known.len())
        .min_by(|&one, &other| axes.eigenvalues[one].total_cmp(&axes.eigenvalues[other]));
    match least {
        Some(least) if axes.eigenvalues[least] < ROUNDING * known.len() as f64 => {
            let most = axes.eigenvectors.column(least).iamax();
            let parameter = &parameters[known[most]];
            Err(rejected(parameter, "found correlations that are impossible together"))
        }
        _ => Ok(()),
    }
}

fn rejected(parameter: &Parameter, reason: &'static str) -> ModelError {
    ModelError::Parameter { name: parameter.name.clone(), reason }
}
