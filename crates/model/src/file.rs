//! `model.toml`: a model as a file.

use std::path::Path;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};
use toml::Spanned;

use hovernav_toml::TomlError;

use super::error::ModelError;
use super::linear::TimeDomain;
use super::parameter::{Parameter, Slope};
use super::signal::Signal;
use super::state_space::StateSpace;
use super::verdict::{Grade, Verdict};

type Rows = Vec<Vec<f64>>;

/// The file as it stands. Matrices are lists of rows.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    name: String,
    #[serde(default)]
    source: String,
    time_domain: Domain,
    period_s: Option<Spanned<f64>>,
    #[serde(rename = "A")]
    a: Spanned<Rows>,
    #[serde(rename = "B")]
    b: Spanned<Rows>,
    #[serde(rename = "C")]
    c: Option<Spanned<Rows>>,
    #[serde(rename = "D")]
    d: Option<Spanned<Rows>>,
    parameter_covariance: Option<Spanned<Rows>>,
    states: Spanned<Vec<Signal>>,
    inputs: Spanned<Vec<Signal>>,
    outputs: Option<Spanned<Vec<Signal>>>,
    #[serde(default)]
    parameters: Vec<Parameter>,
    slopes: Option<Spanned<Vec<Slope>>>,
    verdict: Option<Spanned<Grade>>,
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

    /// The model that `text` spells; `path` names it in messages.
    ///
    /// Keys: `name`, `source`, `time_domain` (`"continuous"` or `"discrete"`, never left out),
    /// `period_s` (s, with a discrete model alone), matrices `A`, `B` and optionally `C`, `D` as lists
    /// of rows, `states`, `inputs` and optionally `outputs` as tables of `name` and `unit`,
    /// `parameters` as tables of `name`, `value`, `unit`, `parameter_covariance`, `slopes` as tables of
    /// `parameter`, `row`, `column`, `slope` as [`Slope`] has them, and `verdict` (`"good"`, `"care"` or
    /// `"do not fly"`) with its `reasons`. Without
    /// `outputs` the states are the outputs.
    ///
    /// # Errors
    /// [`ModelError::Toml`] with the line, where the text is not TOML, a key is missing or not known,
    /// or what it says is not a model.
    pub fn parse(text: &str, path: &Path) -> Result<Self, ModelError> {
        let refused = |start: usize, reason: String| -> ModelError {
            TomlError::at(path, text, start, &reason).into()
        };
        let written: Written =
            toml::from_str(text).map_err(|error| TomlError::of(path, text, &error))?;
        let time = match (written.time_domain, &written.period_s) {
            (Domain::Continuous, None) => TimeDomain::Continuous,
            (Domain::Discrete, Some(period)) => {
                TimeDomain::Discrete { period_s: *period.get_ref() }
            }
            (Domain::Continuous, Some(period)) => {
                let reason = "found period_s in a continuous model, expected it in a discrete one";
                return Err(refused(period.span().start, reason.into()));
            }
            (Domain::Discrete, None) => {
                let reason = "found a discrete model without its period, expected period_s";
                return Err(refused(0, reason.into()));
            }
        };
        let read = |name: &str, rows: &Spanned<Rows>| {
            matrix(rows.get_ref())
                .map_err(|reason| refused(rows.span().start, format!("{name}: {reason}")))
        };
        let a = read("A", &written.a)?;
        let b = read("B", &written.b)?;
        let c = written.c.as_ref().map(|rows| read("C", rows)).transpose()?;
        let d = written.d.as_ref().map(|rows| read("D", rows)).transpose()?;
        let covariance = written.parameter_covariance.as_ref();
        let covariance = covariance.map(|rows| read("covariance", rows)).transpose()?;
        // An error of the model points at the matrix or list it speaks of.
        let placed = |error: ModelError| {
            let start_of = |rows: &Option<Spanned<Rows>>| rows.as_ref().map(|r| r.span().start);
            let start = match &error {
                ModelError::Shape { matrix, .. } | ModelError::NotFinite { matrix, .. } => {
                    match *matrix {
                        "A" => Some(written.a.span().start),
                        "B" => Some(written.b.span().start),
                        "C" => start_of(&written.c),
                        "D" => start_of(&written.d),
                        _ => start_of(&written.parameter_covariance),
                    }
                }
                ModelError::Name { list: "states", .. } => Some(written.states.span().start),
                ModelError::Name { list: "inputs", .. } => Some(written.inputs.span().start),
                ModelError::Name { list: "outputs", .. } => {
                    written.outputs.as_ref().map(|list| list.span().start)
                }
                ModelError::Period { .. } => {
                    written.period_s.as_ref().map(|period| period.span().start)
                }
                ModelError::Parameter { .. } => start_of(&written.parameter_covariance),
                ModelError::Slope { .. } => {
                    written.slopes.as_ref().map(|slopes| slopes.span().start)
                }
                _ => None,
            };
            refused(start.unwrap_or(0), error.to_string())
        };
        let mut model = Self::new(
            &written.name,
            time,
            written.states.get_ref().clone(),
            written.inputs.get_ref().clone(),
            a,
            b,
        )
        .map_err(placed)?
        .with_source(&written.source);
        if let Some(grade) = &written.verdict {
            let (start, grade) = (grade.span().start, *grade.get_ref());
            // Its reasons were written with another grade.
            if grade == Grade::Good && !written.reasons.is_empty() {
                let reasons = written.reasons.len();
                let reasons = format!("{reasons} reason{}", if reasons == 1 { "" } else { "s" });
                return Err(refused(
                    start,
                    format!(
                        "found the verdict \"good\" and {reasons} against it, expected the verdict that was written \
                     with the reasons"
                    ),
                ));
            }
            model = model.with_verdict(Verdict { grade, reasons: written.reasons.clone() });
        }
        match (&written.outputs, c) {
            (Some(outputs), Some(c)) => {
                let outputs = outputs.get_ref().clone();
                let d = d.unwrap_or_else(|| DMatrix::zeros(outputs.len(), model.inputs().len()));
                model = model.with_outputs(outputs, c, d).map_err(placed)?;
            }
            (None, None) if d.is_none() => {}
            (outputs, _) => {
                let start = outputs.as_ref().map_or(0, |list| list.span().start);
                let reason = "found only some of outputs, C and D, expected outputs and C together";
                return Err(refused(start, reason.into()));
            }
        }
        let model =
            model.with_parameters(written.parameters.clone(), covariance).map_err(placed)?;
        let slopes = written.slopes.as_ref().map(|slopes| slopes.get_ref().clone());
        model.with_slopes(slopes.unwrap_or_default()).map_err(placed)
    }

    /// The text of `model.toml`: [`StateSpace::parse`] gives the same model back, to the last bit.
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
