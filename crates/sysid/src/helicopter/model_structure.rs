//! Structures of models, as TOML files: equations, initial values, limits and priors.
//!
//! States and inputs have the names of a flight record. The states are u, v, w, m/s; p, q, r, rad/s; phi, theta, rad.
//! The inputs are lateral, longitudinal, collective and pedal, −1…1 about trim, and the terms ku, kv, kw, kphi and
//! ktheta that rigid-body kinematics add to the linear equations. They are known from the flight. Derivatives are in
//! SI, per unit stick. Every structure is continuous in time.
//!
//! In all structures the effect of gusts on an axis is a slow acceleration of its own, dp to dw. The response to a gust
//! can then exceed what the derivative predicts, and no gust grows as its derivative vanishes. MIL-F-8785C gives a
//! turbulence scale of 67 m for horizontal and 10 m for vertical gusts at a height of 10 m. The wind carries the
//! turbulence past the vehicle at a few m/s. Servos are first-order lags, typically with corners from 5 to 13 Hz. A
//! delay is negative where a stick is recorded after it moved; a movement between samples is recorded half a period
//! late.
//!
//! # Source
//! Paw (2005), *System identification and control system design for a model helicopter in hover*, NTU,
//! doi:10.32657/10356/47095, equations 3.39–3.57 and section 5.6.1.3. Priors: Padfield, *Helicopter Flight Dynamics*,
//! section 4.3.3; Mettler, Tischler and Kanade (2002), *J. AHS* 47(1), table 2; Gavrilets, Mettler and Feron (2003),
//! MIT LIDS P-2580.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::str::FromStr;
use std::sync::LazyLock;

use super::flight_condition::FlightCondition;
use super::structure_file::{BUILT_IN, File, ModelStructureError, Start, built_in_text, content};
use super::velocity_error::{SlowError, VelocityError};
use crate::methods::structure::Structure;

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
    /// Range of a stick in a typical flight, as a fraction of full travel to one side. With it, the travel in the
    /// flight converts initial values and limits of control derivatives to the unit of the record. `None` if they are
    /// in this unit already.
    pub(super) stick_travel: Option<f64>,
    /// Range of flight in which the derivatives are valid.
    pub condition: FlightCondition,
}

/// Parameters of a stabiliser bar.
const BAR: [&str; 5] = ["Ac", "Bd", "tau_s", "Clon", "Dlat"];
/// Initial σ of the noise that drives the error of a smoothed velocity, as a fraction of the σ for the whole error. A
/// smoother counts vibration as noise, but notches have removed it from these data. With too large a σ the likelihood
/// assigns the helicopter's motion to the measurement error.
const DRIVEN: f64 = 0.5;
/// σ of the white part of a smoothed velocity's error, in units of the slow error's change within a sample.
const WHITE: f64 = 0.03;

impl FromStr for ModelStructure {
    type Err = ModelStructureError;

    /// The built-in structure of this name, or the structure in this file.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        if let Some(own) = Self::built_in(text) {
            return Ok(own);
        }
        let path = Path::new(text);
        if !path.is_file() {
            return Err(ModelStructureError::Unknown { text: text.to_owned() });
        }
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        Self::of_file(File::parse(&hovernav_toml::read_text(path)?, path)?, &name, path)
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
        Self::of_file(File::built_in(name)?, name, Path::new(name)).ok()
    }

    /// The TOML file of the built-in structure `name`.
    #[must_use]
    pub fn text(name: &str) -> Option<&'static str> {
        built_in_text(name)
    }

    /// Name: that of the built-in structure, or the file's name without its ending.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.equations.name
    }

    /// The structure in `file`. A structure of parts has the equations of all its parts. A parameter of the file
    /// replaces the parameter of a part with the same name.
    fn of_file(mut file: File, name: &str, path: &Path) -> Result<Self, ModelStructureError> {
        file.check_names().map_err(|reason| content(path, reason))?;
        let mut parts = Vec::new();
        let own = std::mem::take(&mut file.parameters);
        for name in std::mem::take(&mut file.parts) {
            let mut part = File::built_in(&name).filter(|part| part.parts.is_empty());
            let Some(part) = part.as_mut() else {
                return Err(content(
                    path,
                    format!("found the part `{name}`, expected a built-in structure without parts"),
                ));
            };
            for parameter in &mut part.parameters {
                if let Some(own) = own.iter().find(|own| own.name == parameter.name) {
                    *parameter = own.clone();
                    for start in &mut part.starts {
                        start.values.remove(&own.name);
                    }
                }
            }
            file.join(part);
            parts.push(Self::of_file(part.clone(), &name, path)?);
        }
        file.check_names().map_err(|reason| content(path, reason))?;
        let new = own
            .into_iter()
            .filter(|own| !file.parameters.iter().any(|known| known.name == own.name));
        file.parameters.extend(new.collect::<Vec<_>>());
        let equations = file.equations(name, path)?;
        file.check(&equations).map_err(|reason| content(path, reason))?;
        let condition = file.condition().ok_or_else(|| {
            let [speed, within] = [file.trim_speed_mps, file.within_mps].map(Option::unwrap_or_default);
            content(path, format!("found trim_speed_mps = {speed} and within_mps = {within}, expected two numbers, the second above 0"))
        })?;
        let with_error = file.errors.iter().filter_map(|line| {
            let output = line.split_once('=')?.0.trim();
            (!output.ends_with('\'')).then(|| output.to_owned())
        });
        Ok(Self {
            summary: file.summary,
            equations,
            parts,
            starts: file.starts,
            noises: file.noises,
            output_noises: file.output_noises,
            with_error: with_error.collect(),
            stick_travel: file.stick_travel,
            condition,
        })
    }

    /// Stick and delay of a part with exactly one delay parameter. If several inputs share it, the stick is the last of
    /// them.
    pub(super) fn own_delay(&self) -> Option<(&str, &str)> {
        let equations = &self.equations;
        let delays = equations.inputs.iter().zip(&equations.delays);
        let mut delays = delays.filter_map(|(input, delay)| Some((input.as_str(), (*delay)?)));
        let (mut stick, first) = delays.next()?;
        for (input, delay) in delays {
            if delay != first {
                return None;
            }
            stick = input;
        }
        Some((stick, &equations.parameters[first].name))
    }

    /// Whether all outputs are angular rates. Such a model can be identified without GPS.
    #[must_use]
    pub fn has_rates_alone(&self) -> bool {
        self.equations.outputs.iter().all(|output| ["p", "q", "r"].contains(&output.as_str()))
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
        BAR.iter().all(|name| {
            let place = self.equations.parameter(name);
            place.is_some_and(|place| self.equations.parameters[place].fixed)
        })
    }
}

/// The built-in structure `name`.
pub(super) fn built_in(name: &str) -> ModelStructure {
    let own = ModelStructure::built_in(name);
    own.unwrap_or_else(|| unreachable!("{name} is part of the program"))
}

/// Whether a built-in structure has the parameter `name`.
pub(super) fn is_known(name: &str) -> bool {
    static KNOWN: LazyLock<BTreeSet<String>> = LazyLock::new(|| {
        let all = ModelStructure::all().flat_map(|known| known.equations.parameters);
        all.map(|own| own.name).collect()
    });
    KNOWN.contains(name)
}

/// Upper limits of process noises, by name: σ as an acceleration per sample of `period_s`. The error of the vertical
/// velocity is at most as large as `error`, the value of the smoother. A smoother counts vibration as noise, so its
/// value is too large for data without vibration. Without the limit the likelihood has a second optimum: gusts count as
/// velocity errors, and the collective acts too weakly and too late.
pub(super) fn largest_process_sigma(error: &VelocityError, period_s: f64) -> Vec<(String, f64)> {
    vec![("n_ew".to_owned(), error.vertical.drive(period_s))]
}
