//! Structures of models, as TOML files: equations, initial values, limits and priors.
//!
//! States and inputs have the names of a flight record. The states are u, v, w, m/s; p, q, r, rad/s; phi, theta, rad.
//! The inputs are lateral, longitudinal, collective and pedal, −1…1 about trim, and the terms ku, kv, kw, kphi and
//! ktheta that rigid-body kinematics add to the linear equations. They are known from the flight. Derivatives are in SI,
//! per unit stick. Every structure is continuous in time.
//!
//! In all structures the effect of gusts on an axis is a slow acceleration of its own, dp to dw. The response to a gust
//! can then exceed what the derivative predicts, and no gust grows as its derivative vanishes. MIL-F-8785C gives a
//! turbulence scale of 67 m for horizontal and 10 m for vertical gusts at a height of 10 m. The wind carries the
//! turbulence past the vehicle at a few m/s. Servos are first-order lags, typically with corners from 5 to 13 Hz. A delay
//! is negative where a stick is recorded after it moved; a movement between samples is recorded half a period late.
//!
//! # Source
//! Paw (2005), *System identification and control system design for a model helicopter in hover*, NTU,
//! doi:10.32657/10356/47095, equations 3.39–3.57 and section 5.6.1.3. Priors: Padfield, *Helicopter Flight Dynamics*,
//! section 4.3.3; Mettler, Tischler and Kanade (2002), *J. AHS* 47(1), table 2; Gavrilets, Mettler and Feron (2003), MIT
//! LIDS P-2580.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use hovernav_toml::TomlError;
use serde::Deserialize;
use thiserror::Error;

use super::velocity_error::{SlowError, VelocityError};
use crate::methods::structure::{Parameter, Structure, StructureError};
use crate::record::STICKS;

/// Structure of a model: equations with parameters, and what a search starts from.
///
/// ```
/// use hovernav_sysid::helicopter::ModelStructure;
///
/// let yaw = ModelStructure::built_in("yaw").expect("it exists");
/// assert_eq!(yaw.equations.outputs, ["r"]);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ModelStructure {
    /// The model in one line.
    pub summary: String,
    /// Equations and parameters.
    pub equations: Structure,
    /// Parts into which the equations decouple. Each part is identified on its own, with the motion of the other parts
    /// as known inputs. Empty for equations that do not decouple.
    pub(super) parts: Vec<Self>,
    /// Searches, each from its own initial values. The most likely result counts.
    pub(super) starts: Vec<Start>,
    /// Initial σ of the process noises, by name: accelerations per sample, in SI.
    noises: BTreeMap<String, f64>,
    /// σ of outputs whose noise is fixed instead of estimated, by name.
    output_noises: BTreeMap<String, f64>,
    /// Outputs with an error of the estimator in the equations.
    with_error: Vec<String>,
}

/// Why a text is not a structure of a model.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ModelStructureError {
    /// Neither a built-in structure nor a TOML file.
    #[error("found `{text}`, expected a TOML file or one of {}", names())]
    Unknown {
        /// The text.
        text: String,
    },
    /// The file is unreadable or not TOML, or a value has the wrong kind.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// An unknown key, a missing value or an unknown part.
    #[error("{}: {reason}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Found and expected values.
        reason: String,
    },
    /// The equations are invalid. Lines are counted over `equations`, `disturbances` and `errors` together.
    #[error("{}: {source}", path.display())]
    Equations {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: StructureError,
    },
}

/// Initial values of a search.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default)]
pub(super) struct Start {
    /// Values of parameters, by name.
    pub values: BTreeMap<String, f64>,
    /// σ of process noises, by name.
    pub noises: BTreeMap<String, f64>,
}

/// A structure as written in a file.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
struct File {
    summary: String,
    parts: Vec<String>,
    inputs: Vec<String>,
    outputs: Vec<String>,
    offsets: Vec<String>,
    equations: Vec<String>,
    disturbances: Vec<String>,
    errors: Vec<String>,
    delays: BTreeMap<String, String>,
    lags: BTreeMap<String, String>,
    noises: BTreeMap<String, f64>,
    output_noises: BTreeMap<String, f64>,
    starts: Vec<Start>,
    parameters: Vec<Row>,
}

/// A parameter as written in a file.
#[derive(Debug, Clone, Deserialize)]
struct Row {
    name: String,
    #[serde(default)]
    unit: String,
    start: f64,
    range: Option<[f64; 2]>,
    expected: Option<[f64; 2]>,
    #[serde(default)]
    fixed: bool,
    #[serde(default)]
    needed: bool,
}

/// The built-in structures: name and file.
const BUILT_IN: [(&str, &str); 11] = [
    ("yaw", include_str!("../../structures/yaw.toml")),
    ("heave", include_str!("../../structures/heave.toml")),
    ("roll", include_str!("../../structures/roll.toml")),
    ("pitch", include_str!("../../structures/pitch.toml")),
    ("rates", include_str!("../../structures/rates.toml")),
    ("roll-pitch", include_str!("../../structures/roll-pitch.toml")),
    ("flapping", include_str!("../../structures/flapping.toml")),
    ("hybrid", include_str!("../../structures/hybrid.toml")),
    ("hover", include_str!("../../structures/hover.toml")),
    ("multirotor", include_str!("../../structures/multirotor.toml")),
    ("r50", include_str!("../../structures/r50.toml")),
];

/// Initial σ of the noise that drives the error of a smoothed velocity, as a fraction of the σ for the whole error. A
/// smoother counts vibration as noise, but notches have removed it from these data. With too large a σ the likelihood
/// assigns the helicopter's motion to the measurement error.
const DRIVEN: f64 = 0.5;
/// σ of the white part of a smoothed velocity's error, in units of the slow error's change within a sample.
const WHITE: f64 = 0.03;

/// Names of the built-in structures, separated by commas.
fn names() -> String {
    BUILT_IN.map(|(name, _)| name).join(", ")
}

impl FromStr for ModelStructure {
    type Err = ModelStructureError;

    /// The built-in structure of this name, or the structure in this file.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if let Some(file) = File::built_in(text) {
            return file.structure(Path::new(text));
        }
        let path = Path::new(text);
        if !path.is_file() {
            return Err(ModelStructureError::Unknown { text: text.to_owned() });
        }
        File::parse(&hovernav_toml::read_text(path)?, path)?.structure(path)
    }
}

impl ModelStructure {
    /// The built-in structures.
    pub fn all() -> impl Iterator<Item = Self> {
        BUILT_IN.iter().map(|(name, _)| built_in(name))
    }

    /// The built-in structure `name`.
    #[must_use]
    pub fn built_in(name: &str) -> Option<Self> {
        File::built_in(name)?.structure(Path::new(name)).ok()
    }

    /// The TOML file of the built-in structure `name`.
    #[must_use]
    pub fn text(name: &str) -> Option<&'static str> {
        BUILT_IN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
    }

    /// Name: that of the built-in structure, or the file's name without its ending.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.equations.name
    }

    /// The only stick of a part with one delay, and the name of the delay.
    pub(super) fn own_delay(&self) -> Option<(&str, &str)> {
        let mut delays = self.equations.delays.iter().flatten();
        let first = delays.next()?;
        let stick = self.equations.inputs_of_pilot().last()?;
        let name = &self.equations.parameters[*first].name;
        delays.all(|other| other == first).then_some((stick, name))
    }

    /// Initial σ of each process noise. Gusts and unmodelled dynamics are accelerations per sample of `period_s`; the
    /// noise of the velocity error starts at half the σ that explains `error`.
    #[must_use]
    pub fn process_sigma(&self, error: &VelocityError, period_s: f64) -> Vec<f64> {
        let of = |noise: &String| match noise.as_str() {
            "n_eu" | "n_ev" => DRIVEN * error.horizontal.drive(period_s),
            "n_ew" => DRIVEN * error.vertical.drive(period_s),
            name => self.noises.get(name).copied().unwrap_or_default(),
        };
        self.equations.noises.iter().map(of).collect()
    }

    /// Outputs whose noise is fixed instead of estimated, with its σ, rad and m/s. A velocity with a slow `error` has
    /// hardly any white noise. Its σ is a small fraction of the slow error's change within a sample of `period_s`.
    #[must_use]
    pub fn held_sigma(&self, error: &VelocityError, period_s: f64) -> Vec<(String, f64)> {
        let white = |error: &SlowError| WHITE * error.drive(period_s) * period_s;
        let velocities = self.with_error.iter().filter(|_| *error != VelocityError::NONE);
        let velocities = velocities.map(|name| {
            let own = if name == "w" { &error.vertical } else { &error.horizontal };
            (name.clone(), white(own))
        });
        let others = self.output_noises.iter().map(|(name, sigma)| (name.clone(), *sigma));
        others.chain(velocities).collect()
    }

    /// Whether the equations have a stabiliser bar that a search may add.
    pub(super) fn may_have_bar(&self) -> bool {
        let bar = self.equations.parameter("Ac");
        bar.is_some_and(|bar| self.equations.parameters[bar].fixed)
    }
}

/// The built-in structure `name`.
pub(super) fn built_in(name: &str) -> ModelStructure {
    name.parse().unwrap_or_else(|error| unreachable!("it is part of the program: {error}"))
}

/// Upper limits of process noises, by name: σ as an acceleration per sample of `period_s`. The error of the vertical
/// velocity is at most as large as `error`, the value of the smoother. A smoother counts vibration as noise, so its
/// value is too large for data without vibration. Without the limit the likelihood has a second optimum: gusts count as
/// velocity errors, and the collective acts too weakly and too late.
pub(super) fn largest_process_sigma(error: &VelocityError, period_s: f64) -> Vec<(String, f64)> {
    vec![("n_ew".to_owned(), error.vertical.drive(period_s))]
}

impl Row {
    fn parameter(&self) -> Parameter {
        let parameter = Parameter::new(&self.name, &self.unit, self.start);
        let parameter = match self.range {
            Some([lower, upper]) => parameter.within(lower, upper),
            None => parameter,
        };
        let parameter = match self.expected {
            Some([value, sigma]) => parameter.expected(value, sigma),
            None => parameter,
        };
        let needed = parameter.needed || self.needed;
        Parameter { needed, fixed: self.fixed, ..parameter }
    }
}

impl File {
    fn built_in(name: &str) -> Option<Self> {
        let file = Self::parse(ModelStructure::text(name)?, Path::new(name));
        file.ok()
    }

    fn parse(text: &str, path: &Path) -> Result<Self, ModelStructureError> {
        let (file, unknown): (Self, Vec<String>) = hovernav_toml::parse(text, path)?;
        match unknown.first() {
            Some(key) => Err(content(path, format!("found the unknown key `{key}`"))),
            None => Ok(file),
        }
    }

    /// The structure in this file. A structure of parts has the equations of all its parts; its own parameters replace
    /// theirs of the same name.
    fn structure(mut self, path: &Path) -> Result<ModelStructure, ModelStructureError> {
        let mut parts = Vec::new();
        let own = std::mem::take(&mut self.parameters);
        for name in std::mem::take(&mut self.parts) {
            let mut part = Self::built_in(&name).filter(|part| part.parts.is_empty());
            let Some(part) = part.as_mut() else {
                return Err(content(
                    path,
                    format!("found the part `{name}`, expected one of {}", names()),
                ));
            };
            for parameter in &mut part.parameters {
                if let Some(own) = own.iter().find(|own| own.name == parameter.name) {
                    *parameter = own.clone();
                }
            }
            self.join(part);
            parts.push(part.clone().structure(Path::new(&name))?);
        }
        let new = own
            .into_iter()
            .filter(|own| !self.parameters.iter().any(|known| known.name == own.name));
        self.parameters.extend(new.collect::<Vec<_>>());
        let equations = self.equations(path)?;
        self.check(&equations).map_err(|reason| content(path, reason))?;
        let with_error = self.errors.iter().filter_map(|line| {
            let output = line.split_once('=')?.0.trim();
            (!output.ends_with('\'')).then(|| output.to_owned())
        });
        Ok(ModelStructure {
            summary: self.summary,
            equations,
            parts,
            starts: self.starts,
            noises: self.noises,
            output_noises: self.output_noises,
            with_error: with_error.collect(),
        })
    }

    /// Checks every number of the file except the initial values, which [`Structure::new`] checks.
    fn check(&self, equations: &Structure) -> Result<(), String> {
        let is_sigma = |sigma: f64| sigma > 0.0 && sigma.is_finite();
        let is_estimated = |noise: &str| matches!(noise, "n_eu" | "n_ev" | "n_ew");
        for noise in equations.noises.iter().filter(|noise| !is_estimated(noise)) {
            if !self.noises.get(noise).copied().is_some_and(is_sigma) {
                return Err(format!("found no initial sigma of {noise} in `noises`"));
            }
        }
        for parameter in &equations.parameters {
            if parameter.prior.is_some_and(|(value, sigma)| !value.is_finite() || !is_sigma(sigma))
            {
                return Err(format!(
                    "{}: expected a value and a sigma above 0 in `expected`",
                    parameter.name
                ));
            }
        }
        let sigmas = self.starts.iter().flat_map(|start| &start.noises).chain(&self.output_noises);
        for (name, sigma) in sigmas {
            if !is_sigma(*sigma) {
                return Err(format!("{name}: found a sigma of {sigma}, expected one above 0"));
            }
        }
        for (name, value) in self.starts.iter().flat_map(|start| &start.values) {
            let place = equations.parameter(name);
            let parameter = place.map(|place| &equations.parameters[place]);
            if !parameter.is_some_and(|own| (own.lower..=own.upper).contains(value)) {
                return Err(format!(
                    "starts: found {name} = {value}, expected a parameter and a value in its range"
                ));
            }
        }
        Ok(())
    }

    /// Adds the equations of `part`. An input that is a state of another part is none of the whole.
    fn join(&mut self, part: &Self) {
        fn add<T: Clone + PartialEq>(to: &mut Vec<T>, new: &[T]) {
            for one in new {
                if !to.contains(one) {
                    to.push(one.clone());
                }
            }
        }
        add(&mut self.inputs, &part.inputs);
        add(&mut self.outputs, &part.outputs);
        add(&mut self.offsets, &part.offsets);
        add(&mut self.equations, &part.equations);
        add(&mut self.disturbances, &part.disturbances);
        add(&mut self.errors, &part.errors);
        let (outputs, inputs) = (&self.outputs, &mut self.inputs);
        inputs.retain(|input| !outputs.contains(input));
        for (to, new) in [(&mut self.delays, &part.delays), (&mut self.lags, &part.lags)] {
            for (input, name) in new {
                to.entry(input.clone()).or_insert_with(|| name.clone());
            }
        }
        for (to, new) in
            [(&mut self.noises, &part.noises), (&mut self.output_noises, &part.output_noises)]
        {
            to.extend(new.iter().map(|(name, sigma)| (name.clone(), *sigma)));
        }
        for parameter in &part.parameters {
            if !self.parameters.iter().any(|known| known.name == parameter.name) {
                self.parameters.push(parameter.clone());
            }
        }
    }

    /// The equations, then the disturbances, then the errors of the outputs, which a [`Structure`] requires last.
    fn equations(&self, path: &Path) -> Result<Structure, ModelStructureError> {
        let mut lines = [&self.equations[..], &self.disturbances, &self.errors].concat();
        let is_name = |c: char| c.is_alphanumeric() || c == '_';
        let mut noises: Vec<String> = Vec::new();
        for word in lines.iter().flat_map(|line| line.split(|c| !is_name(c))) {
            if word.starts_with("n_") && !noises.iter().any(|known| known == word) {
                noises.push(word.to_owned());
            }
        }
        for (keyword, names) in [
            ("inputs", &self.inputs),
            ("outputs", &self.outputs),
            ("offsets", &self.offsets),
            ("noise", &noises),
        ] {
            lines.push(format!("{keyword} {}", names.join(" ")));
        }
        for (keyword, names) in [("delay", &self.delays), ("lag", &self.lags)] {
            lines.extend(names.iter().map(|(input, name)| format!("{keyword} {input} {name}")));
        }
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let parameters = self.parameters.iter().map(Row::parameter).collect();
        let structure = Structure::new(&name, parameters, &lines.join("\n")).map_err(|source| {
            ModelStructureError::Equations { path: path.to_path_buf(), source }
        })?;
        if structure.inputs_of_pilot().next().is_none() {
            let sticks = STICKS.join(", ");
            return Err(content(
                path,
                format!("found no stick in `inputs`, expected one of {sticks}"),
            ));
        }
        Ok(structure)
    }
}

fn content(path: &Path, reason: String) -> ModelStructureError {
    ModelStructureError::Content { path: path.to_path_buf(), reason }
}
