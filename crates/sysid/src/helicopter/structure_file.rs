//! A structure of a model as written in a TOML file.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use hovernav_toml::TomlError;
use serde::Deserialize;
use thiserror::Error;

use super::flight::{KINEMATIC, MOTION};
use super::flight_condition::FlightCondition;
use crate::methods::structure::{Parameter, Structure, StructureError};
use crate::record::STICKS;

/// Why a text is not a structure of a model.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ModelStructureError {
    /// Neither a built-in structure nor a TOML file.
    #[error("found no file `{text}`, expected a TOML file or one of {}", names())]
    Unknown {
        /// The text.
        text: String,
    },
    /// The file is unreadable or not TOML, or a value has the wrong kind.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// A key, name, number or part that is not permitted.
    #[error("{}: {reason}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Found and expected values.
        reason: String,
    },
    /// The equations are invalid. Lines are counted over `equations`, `disturbances` and `errors` together.
    #[error("{}, lines counted over the equations: {source}", path.display())]
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
pub(super) struct File {
    pub summary: String,
    pub parts: Vec<String>,
    pub inputs: Vec<String>,
    pub outputs: Vec<String>,
    pub offsets: Vec<String>,
    pub equations: Vec<String>,
    pub disturbances: Vec<String>,
    pub errors: Vec<String>,
    pub delays: BTreeMap<String, String>,
    pub lags: BTreeMap<String, String>,
    pub noises: BTreeMap<String, f64>,
    pub output_noises: BTreeMap<String, f64>,
    pub starts: Vec<Start>,
    pub stick_travel: Option<f64>,
    pub trim_speed_mps: Option<f64>,
    pub within_mps: Option<f64>,
    pub parameters: Vec<Row>,
}

/// A parameter as written in a file.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Row {
    pub name: String,
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
pub(super) const BUILT_IN: [(&str, &str); 12] = [
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
    ("short-period", include_str!("../../structures/short-period.toml")),
];

/// Largest numbers of states, parameters and starts.
const MAX: [(&str, usize); 3] = [("states", 40), ("parameters", 200), ("starts", 16)];

/// Names of the built-in structures, separated by commas.
fn names() -> String {
    BUILT_IN.map(|(name, _)| name).join(", ")
}

/// The file of the built-in structure `name`.
pub(super) fn built_in_text(name: &str) -> Option<&'static str> {
    BUILT_IN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
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
    pub fn built_in(name: &str) -> Option<Self> {
        Self::parse(built_in_text(name)?, Path::new(name)).ok()
    }

    pub fn parse(text: &str, path: &Path) -> Result<Self, ModelStructureError> {
        let (file, unknown): (Self, Vec<String>) = hovernav_toml::parse(text, path)?;
        match unknown.first() {
            Some(key) => Err(content(path, format!("found the unknown key `{key}`"))),
            None => Ok(file),
        }
    }

    /// Checks every number of the file except the initial values, which [`Structure::new`] checks.
    pub fn check(&self, equations: &Structure) -> Result<(), String> {
        let is_sigma = |sigma: f64| sigma > 0.0 && sigma.is_finite();
        let is_estimated = |noise: &str| matches!(noise, "n_eu" | "n_ev" | "n_ew");
        for noise in equations.noises.iter().filter(|noise| !is_estimated(noise)) {
            if !self.noises.get(noise).copied().is_some_and(is_sigma) {
                return Err(format!("expected an initial sigma of {noise} above 0 in `noises`"));
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
            if !parameter.is_some_and(|own| !own.fixed && (own.lower..=own.upper).contains(value)) {
                return Err(format!(
                    "starts: found {name} = {value}, expected a free parameter and a value in its range"
                ));
            }
        }
        let known = |names: &[String], own: &str| names.iter().any(|name| name == own);
        let noises =
            self.starts.iter().flat_map(|start| start.noises.keys()).chain(self.noises.keys());
        for name in noises {
            if !known(&equations.noises, name) {
                return Err(format!("found the noise `{name}`, expected one that an equation has"));
            }
        }
        let mut outputs = self.output_noises.keys();
        if let Some(name) = outputs.find(|name| !known(&equations.outputs, name)) {
            return Err(format!("output_noises: found `{name}`, expected an output"));
        }
        let motion = |name: &str| MOTION.contains(&name);
        let is_input =
            |name: &str| motion(name) || STICKS.contains(&name) || KINEMATIC.contains(&name);
        if let Some(name) = equations.inputs.iter().find(|name| !is_input(name)) {
            return Err(format!(
                "found the input `{name}`, expected a stick, a motion or a kinematic term"
            ));
        }
        if let Some(name) = equations.outputs.iter().find(|name| !motion(name)) {
            return Err(format!(
                "found the output `{name}`, expected one of {}",
                MOTION.join(", ")
            ));
        }
        let mut lags = equations.lags.iter().flatten().map(|place| &equations.parameters[*place]);
        if let Some(lag) = lags.find(|lag| lag.lower < 0.0 || lag.upper > 1.0) {
            return Err(format!("{}: expected the range of a lag within 0 to 1 s", lag.name));
        }
        let counts = [equations.states.len(), equations.parameters.len(), self.starts.len()];
        for ((what, most), found) in MAX.iter().zip(counts) {
            if found > *most {
                return Err(format!("found {found} {what}, expected at most {most}"));
            }
        }
        Ok(())
    }

    /// Range of flight in which the derivatives are valid; `None` for impossible numbers.
    pub fn condition(&self) -> Option<FlightCondition> {
        let hover = FlightCondition::HOVER;
        let condition = FlightCondition {
            speed_mps: self.trim_speed_mps.unwrap_or(hover.speed_mps),
            within_mps: self.within_mps.unwrap_or(hover.within_mps),
        };
        condition.is_valid().then_some(condition)
    }

    /// Checks names and lists as written.
    pub fn check_names(&self) -> Result<(), String> {
        fn twice<'a>(mut names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
            let mut seen = BTreeSet::new();
            names.find(|name| !seen.insert(*name))
        }
        let lines = || [&self.equations, &self.disturbances, &self.errors].into_iter().flatten();
        let lists = [&self.inputs, &self.outputs, &self.offsets];
        let maps = [&self.delays, &self.lags];
        let sigmas = [&self.noises, &self.output_noises];
        let has_others = lines().next().is_some()
            || lists.iter().any(|list| !list.is_empty())
            || maps.iter().any(|map| !map.is_empty())
            || sigmas.iter().any(|map| !map.is_empty())
            || !self.starts.is_empty()
            || self.stick_travel.is_some();
        if !self.parts.is_empty() && has_others {
            return Err(
                "found `parts` and other keys, expected only `summary` and `parameters` with it"
                    .into(),
            );
        }
        if self.stick_travel.is_some_and(|own| !(0.0..=1.0).contains(&own) || own == 0.0) {
            return Err("stick_travel: expected a number above 0 and at most 1".into());
        }
        let parameters = || self.parameters.iter().map(|row| row.name.as_str());
        let states = lines().filter_map(|line| line.split_once('=')).map(|(left, _)| left.trim());
        let mut lists_with_parts = lists.into_iter().chain([&self.parts]);
        let repeated = lists_with_parts.find_map(|list| twice(list.iter().map(String::as_str)));
        if let Some(name) = twice(parameters()).or_else(|| twice(states)).or(repeated) {
            return Err(format!("found `{name}` twice"));
        }
        let states = || lines().filter_map(|line| line.split_once('\'')).map(|(own, _)| own.trim());
        let inputs = || self.inputs.iter().map(String::as_str);
        if let Some(name) = states().find(|name| inputs().any(|own| own == *name)) {
            return Err(format!("found the input `{name}`, expected a name that no state has"));
        }
        let is_signal =
            |name: &str| name.starts_with("n_") || states().chain(inputs()).any(|own| own == name);
        if let Some(name) = parameters().find(|name| is_signal(name)) {
            return Err(format!(
                "found the parameter `{name}`, expected a name that no signal has"
            ));
        }
        let is_name = |name: &str| {
            name.starts_with(|c: char| c.is_alphabetic())
                && name.chars().all(|c| c.is_alphanumeric() || c == '_')
                && name.parse::<f64>().is_err()
        };
        let all = lists.iter().flat_map(|list| list.iter().map(String::as_str));
        let late = maps.iter().flat_map(|map| map.iter());
        let late = late.flat_map(|(input, name)| [input.as_str(), name.as_str()]);
        if let Some(name) = all.chain(late).chain(parameters()).find(|name| !is_name(name)) {
            return Err(format!("found the name `{name}`, expected letters, digits and `_`"));
        }
        if let Some(line) = lines().find(|line| !line.contains('=') || line.contains('\n')) {
            return Err(format!("found `{line}`, expected an equation"));
        }
        if let Some(row) = self.parameters.iter().find(|row| {
            row.range.is_some_and(|[from, to]| from.partial_cmp(&to) != Some(Ordering::Less))
        }) {
            return Err(format!("{}: expected a range of two numbers, the lower first", row.name));
        }
        Ok(())
    }

    /// Adds the equations of `part`. An output of another part is not an input of the whole.
    pub fn join(&mut self, part: &Self) {
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
        self.stick_travel = self.stick_travel.or(part.stick_travel);
        let (outputs, inputs) = (&self.outputs, &mut self.inputs);
        inputs.retain(|input| !outputs.contains(input));
        for (to, new) in [(&mut self.delays, &part.delays), (&mut self.lags, &part.lags)] {
            for (input, name) in new {
                // The part with one stick alone knows its delay best.
                if new.len() == 1 || !to.contains_key(input) {
                    to.insert(input.clone(), name.clone());
                }
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
    pub fn equations(&self, name: &str, path: &Path) -> Result<Structure, ModelStructureError> {
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
        let parameters = self.parameters.iter().map(Row::parameter).collect();
        let structure = Structure::new(name, parameters, &lines.join("\n")).map_err(|source| {
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

pub(super) fn content(path: &Path, reason: String) -> ModelStructureError {
    ModelStructureError::Content { path: path.to_path_buf(), reason }
}
