//! `model.toml`: a model as a file.

use std::path::Path;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use hovernav_toml::TomlError;

use super::error::ModelError;
use super::linear::TimeDomain;
use super::parameter::{Parameter, Slope};
use super::signal::Signal;
use super::state_space::StateSpace;
use super::verdict::{Grade, Verdict};

type Rows = Vec<Vec<f64>>;

/// Key of the covariance of the parameters.
const COVARIANCE: &str = "parameter_covariance";

/// Content of `model.toml`. Matrices are lists of rows.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    name: String,
    #[serde(default)]
    source: String,
    time_domain: Domain,
    period_s: Option<f64>,
    #[serde(default)]
    trim_speed_mps: f64,
    #[serde(rename = "A")]
    a: Rows,
    #[serde(rename = "B")]
    b: Rows,
    #[serde(rename = "C")]
    c: Option<Rows>,
    #[serde(rename = "D")]
    d: Option<Rows>,
    parameter_covariance: Option<Rows>,
    states: Vec<Signal>,
    inputs: Vec<Signal>,
    outputs: Option<Vec<Signal>>,
    #[serde(default)]
    parameters: Vec<Parameter>,
    slopes: Option<Vec<Slope>>,
    verdict: Option<Grade>,
    #[serde(default)]
    reasons: Vec<String>,
}

#[derive(Clone, Copy, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
enum Domain {
    Continuous,
    Discrete,
}

impl StateSpace {
    /// Reads `model.toml`.
    ///
    /// # Errors
    /// [`ModelError::Toml`], as [`StateSpace::parse`].
    pub fn read(path: &Path) -> Result<Self, ModelError> {
        Self::parse(&hovernav_toml::read_text(path)?, path)
    }

    /// The model in the text `text`; `path` is its name in messages.
    ///
    /// The keys `name`, `source` and `time_domain` (`"continuous"` or `"discrete"`) are required, and `period_s` (s)
    /// for a discrete model only. `trim_speed_mps` is the forward speed about which the model is linear, 0 without the
    /// key. The matrices `A`, `B` and optionally `C`, `D` are lists of rows. `states`, `inputs`
    /// and optionally `outputs` are tables of `name` and `unit`. `parameters` are tables of `name`, `value`, `unit`,
    /// with the matrix `parameter_covariance`. `slopes` are tables of `parameter`, `row`, `column`, `slope` as in
    /// [`Slope`]. The `verdict` is `"good"`, `"care"` or `"do not fly"`; its `reasons` are required unless it is
    /// `"good"`. Without `outputs` the states are the outputs. A variance must not exceed 1e12, or 1e6 s² for a delay
    /// or a lag.
    ///
    /// # Errors
    /// [`ModelError::Toml`] with the line of the error: invalid TOML, a missing or unknown key, or an invalid model.
    pub fn parse(text: &str, path: &Path) -> Result<Self, ModelError> {
        let rejected = |key: &str, reason: String| -> ModelError {
            TomlError::at(path, text, hovernav_toml::offset_of_key(text, key), &reason).into()
        };
        // Unknown keys are rejected with their line.
        let (written, _): (Written, _) = hovernav_toml::parse(text, path)?;
        let time = match (written.time_domain, written.period_s) {
            (Domain::Continuous, None) => TimeDomain::Continuous,
            (Domain::Discrete, Some(period_s)) => TimeDomain::Discrete { period_s },
            (Domain::Continuous, Some(_)) => {
                let reason = "found period_s in a continuous model, expected it in a discrete one";
                return Err(rejected("period_s", reason.into()));
            }
            (Domain::Discrete, None) => {
                let reason = "found a discrete model without its period, expected period_s";
                return Err(rejected("time_domain", reason.into()));
            }
        };
        let read = |key: &str, name: &str, rows: &Rows| {
            matrix(rows).map_err(|reason| rejected(key, format!("{name}: {reason}")))
        };
        let a = read("A", "A", &written.a)?;
        let b = read("B", "B", &written.b)?;
        let c = written.c.as_ref().map(|rows| read("C", "C", rows)).transpose()?;
        let d = written.d.as_ref().map(|rows| read("D", "D", rows)).transpose()?;
        let covariance = written.parameter_covariance.as_ref();
        let covariance = covariance.map(|rows| read(COVARIANCE, "covariance", rows)).transpose()?;
        // An error of the model is reported at the line of the matrix or list that contains it.
        let placed = |error: ModelError| {
            let key = match &error {
                ModelError::Shape { matrix, .. } | ModelError::NotFinite { matrix, .. } => {
                    match *matrix {
                        matrix @ ("A" | "B" | "C" | "D") => matrix,
                        _ => COVARIANCE,
                    }
                }
                ModelError::Name { list, .. } => list,
                ModelError::Period { .. } => "period_s",
                ModelError::Speed { .. } => "trim_speed_mps",
                ModelError::Parameter { .. } => COVARIANCE,
                ModelError::Slope { .. } => "slopes",
                _ => "",
            };
            rejected(key, error.to_string())
        };
        if let Some(covariance) = covariance.as_ref().filter(|own| own.is_square()) {
            for (parameter, variance) in written.parameters.iter().zip(&covariance.diagonal()) {
                let (name, unit) = (&parameter.name, &parameter.unit);
                let (sigma, most) = (variance.sqrt(), least_known(name));
                if sigma.is_finite() && sigma > most {
                    let reason = format!(
                        "{COVARIANCE}: found {variance:e} for {name}, a standard error of {sigma:.0e} {unit}, \
                         expected at most {most:e}, a thousand times the value of any helicopter"
                    );
                    return Err(rejected(COVARIANCE, reason));
                }
            }
        }
        let Written { name, source, states, inputs, outputs, parameters, slopes, .. } = written;
        let mut model =
            Self::new(&name, time, states, inputs, a, b).map_err(placed)?.with_source(&source);
        model = model.with_trim_speed(written.trim_speed_mps).map_err(placed)?;
        if let Some(verdict) = verdict(written.verdict, written.reasons)
            .map_err(|(key, reason)| rejected(key, reason))?
        {
            model = model.with_verdict(verdict);
        }
        match (outputs, c) {
            (Some(outputs), Some(c)) => {
                let d = d.unwrap_or_else(|| DMatrix::zeros(outputs.len(), model.inputs().len()));
                model = model.with_outputs(outputs, c, d).map_err(placed)?;
            }
            (None, None) if d.is_none() => {}
            _ => {
                let reason = "found only some of outputs, C and D, expected outputs and C together";
                return Err(rejected("outputs", reason.into()));
            }
        }
        let model = model.with_parameters(parameters, covariance).map_err(placed)?;
        model.with_slopes(slopes.unwrap_or_default()).map_err(placed)
    }

    /// The text of `model.toml`: [`StateSpace::parse`] restores the same model exactly.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        let quoted = |value: &str| toml::Value::from(value).to_string();
        text += &format!("name = {}\n", quoted(self.name()));
        text += &format!("source = {}\n", quoted(self.source()));
        text += &format!("time_domain = \"{}\"\n", self.time().name());
        if let TimeDomain::Discrete { period_s } = self.time() {
            text += &format!("period_s = {}\n", toml::Value::from(period_s));
        }
        if self.trim_speed_mps() != 0.0 {
            text += &format!("trim_speed_mps = {}\n", toml::Value::from(self.trim_speed_mps()));
        }
        if let Some(Verdict { grade, reasons }) = self.verdict() {
            let reasons = reasons.iter().map(|reason| format!("    {},\n", quoted(reason)));
            text += &format!("verdict = \"{grade}\"\n");
            text += &format!("reasons = [\n{}]\n", reasons.collect::<String>());
        }
        let signals = |key: &str, list: &[Signal]| {
            let rows = list.iter().map(|signal| {
                let (name, unit) = (quoted(&signal.name), quoted(&signal.unit));
                format!("    {{ name = {name}, unit = {unit} }},\n")
            });
            format!("{key} = [\n{}]\n", rows.collect::<String>())
        };
        text += &signals("states", self.states());
        text += &signals("inputs", self.inputs());
        text += &rows_of("A", self.a());
        text += &rows_of("B", self.b());
        let trivial = self.outputs() == self.states()
            && self.c().is_identity(0.0)
            && self.d().iter().all(|&value| value == 0.0);
        if !trivial {
            text += &signals("outputs", self.outputs());
            text += &rows_of("C", self.c());
            text += &rows_of("D", self.d());
        }
        if !self.parameters().is_empty() {
            let rows = self.parameters().iter().map(|parameter| {
                let (name, unit) = (quoted(&parameter.name), quoted(&parameter.unit));
                let value = toml::Value::from(parameter.value);
                format!("    {{ name = {name}, value = {value}, unit = {unit} }},\n")
            });
            text += &format!("parameters = [\n{}]\n", rows.collect::<String>());
        }
        if let Some(covariance) = self.covariance() {
            text += &rows_of("parameter_covariance", covariance);
        }
        if !self.slopes().is_empty() {
            let rows = self.slopes().iter().map(|slope| {
                let [parameter, row, column] =
                    [&slope.parameter, &slope.row, &slope.column].map(|name| quoted(name));
                let value = toml::Value::from(slope.slope);
                format!(
                    "    {{ parameter = {parameter}, row = {row}, column = {column}, slope = {value} }},\n"
                )
            });
            text += &format!("slopes = [\n{}]\n", rows.collect::<String>());
        }
        text
    }

    /// Writes `model.toml`.
    ///
    /// # Errors
    /// [`ModelError::Toml`].
    pub fn write(&self, path: &Path) -> Result<(), ModelError> {
        hovernav_toml::write_whole(path, self.to_toml())
            .map_err(|source| TomlError::Io { path: path.into(), source }.into())
    }
}

/// Largest plausible standard error of the parameter `name`, in its unit: a thousand times its largest possible value.
/// That value is 1 s for a stick's delay or a servo's lag, and about 1000 for a derivative in SI. A larger standard
/// error means that the parameter is unknown and that no design is possible.
fn least_known(name: &str) -> f64 {
    match name.split_once('_') {
        Some(("tau", "lat" | "lon" | "col" | "ped") | ("lag", _)) => 1e3,
        _ => 1e6,
    }
}

/// Verdict in the model file. An error consists of the key and the reason for the rejection. Verdict and reasons are
/// written together. If one of them is missing or contradicts the other, the file was edited.
fn verdict(
    grade: Option<Grade>,
    reasons: Vec<String>,
) -> Result<Option<Verdict>, (&'static str, String)> {
    let count = reasons.len();
    let counted = format!("{count} reason{}", if count == 1 { "" } else { "s" });
    match grade {
        Some(Grade::Good) if count > 0 => Err((
            "verdict",
            format!(
                "found the verdict \"good\" and {counted} against it, expected the original verdict of these \
                 reasons"
            ),
        )),
        Some(grade) if grade != Grade::Good && count == 0 => Err((
            "verdict",
            format!("found the verdict \"{grade}\" without reasons, expected its original reasons"),
        )),
        None if count > 0 => Err((
            "reasons",
            format!("found {counted} without a verdict, expected their original verdict"),
        )),
        grade => Ok(grade.map(|grade| Verdict { grade, reasons })),
    }
}

fn rows_of(key: &str, matrix: &DMatrix<f64>) -> String {
    let rows = matrix.row_iter().map(|row| {
        let values: Vec<String> =
            row.iter().map(|&value| toml::Value::from(value).to_string()).collect();
        format!("    [{}],\n", values.join(", "))
    });
    format!("{key} = [\n{}]\n", rows.collect::<String>())
}

fn matrix(rows: &Rows) -> Result<DMatrix<f64>, String> {
    let columns = rows.first().map_or(0, Vec::len);
    if let Some((row, found)) = rows.iter().enumerate().find(|(_, row)| row.len() != columns) {
        let found = found.len();
        return Err(format!(
            "found {found} numbers in row {}, expected {columns} as in row 1",
            row + 1
        ));
    }
    Ok(DMatrix::from_fn(rows.len(), columns, |row, column| rows[row][column]))
}
