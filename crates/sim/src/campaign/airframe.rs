//! Uncertainty of the airframe.

use nalgebra::{DMatrix, DVector};

use crate::noise::Noise;
use hovernav_model::helicopter::HelicopterParameters;
use hovernav_model::{ModelError, Parameter, Slope, StateSpace};

/// Uncertain properties of the airframe. Each is a derivative of the hover model; in the simulated airframe its
/// physical cause has the same relative error.
pub const UNCERTAIN: [&str; 10] =
    ["mass", "Lb", "Ma", "Blat", "Alon", "Zcol", "Nr", "Nped", "Xu", "Yv"];

/// Relative error, one sigma, of each derivative of a linear model without a covariance.
const BY_HAND: f64 = 0.1;

/// Uncertainty of the airframe: the joint distribution of what differs from flight to flight.
#[derive(Clone, Debug, PartialEq)]
pub struct AirframeUncertainty {
    /// Properties that vary.
    names: Vec<String>,
    /// Nominal values: 1 for the factors of a helicopter, the values of a linear model's parameters.
    nominal: Vec<f64>,
    /// Covariance of the values.
    covariance: DMatrix<f64>,
    /// L with L Lᵀ the covariance.
    root: DMatrix<f64>,
    /// Names of the properties whose covariance was identified.
    identified: Vec<String>,
    /// Whether the values are factors on [`UNCERTAIN`], and not parameters of a linear model.
    is_helicopter: bool,
}

/// Error: a spread was given for a property that does not vary.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("found \"{name}\", expected one of {}", .known.join(", "))]
pub struct UnknownSpread {
    /// Name found.
    pub name: String,
    /// Names of the properties that vary.
    pub known: Vec<String>,
}

impl Default for AirframeUncertainty {
    /// Independent errors of the 60-class helicopter, one sigma: mass 5 %, all others 10 %.
    fn default() -> Self {
        let shares = UNCERTAIN.map(|name| if name == "mass" { 0.05 } else { 0.1 });
        let root = DMatrix::from_diagonal(&DVector::from_row_slice(&shares));
        Self {
            names: UNCERTAIN.map(str::to_owned).to_vec(),
            nominal: vec![1.0; UNCERTAIN.len()],
            covariance: &root * root.transpose(),
            root,
            identified: Vec::new(),
            is_helicopter: true,
        }
    }
}

impl AirframeUncertainty {
    /// Uncertainty of the 60-class helicopter as an identified `model` states it: the covariance of its parameters with
    /// all correlations, and the default for properties that it does not contain. In a model without flapping, Lp and
    /// Mq replace Lb and Ma, and Llat and Mlon replace Blat and Alon. They have the corresponding effect on the rates.
    #[must_use]
    pub fn of_model(model: &StateSpace) -> Self {
        let stands_for = |name: &'static str| match name {
            "Lb" => "Lp",
            "Ma" => "Mq",
            "Blat" => "Llat",
            "Alon" => "Mlon",
            other => other,
        };
        let parameters = model.parameters();
        let place = |name: &str| parameters.iter().position(|parameter| parameter.name == name);
        let places = UNCERTAIN.map(|name| place(name).or_else(|| place(stands_for(name))));
        let mut known = Self::default();
        let Some(covariance) = model.covariance() else { return known };
        for (row, at_row) in places.iter().enumerate() {
            for (column, at_column) in places.iter().enumerate() {
                if let (&Some(one), &Some(other)) = (at_row, at_column) {
                    let scale = parameters[one].value * parameters[other].value;
                    let share = covariance[(one, other)] / scale;
                    known.covariance[(row, column)] = if share.is_finite() { share } else { 0.0 };
                }
            }
        }
        let own = UNCERTAIN.into_iter().zip(places);
        known.identified = own.filter_map(|(name, place)| place.map(|_| name.into())).collect();
        known.rooted()
    }

    /// The linear `model` with the parameters that vary, and their uncertainty: the covariance of an identified model,
    /// or else independent errors of 10 %, one sigma, of every derivative. A derivative is then named after its row and
    /// column, as `p_lateral`.
    ///
    /// # Errors
    /// [`ModelError`] where the model does not take its own derivatives as parameters.
    pub fn of_linear(model: &StateSpace) -> Result<(StateSpace, Self), ModelError> {
        let model = match model.covariance() {
            Some(_) if !model.slopes().is_empty() => model.clone(),
            _ => by_hand(model)?,
        };
        let covariance = model.covariance().cloned().unwrap_or_default();
        let parameters = model.parameters();
        let varied: Vec<usize> =
            (0..covariance.nrows()).filter(|&own| covariance[(own, own)] > 0.0).collect();
        let names: Vec<String> = varied.iter().map(|&own| parameters[own].name.clone()).collect();
        let known = Self {
            nominal: varied.iter().map(|&own| parameters[own].value).collect(),
            covariance: covariance.select_rows(&varied).select_columns(&varied),
            root: DMatrix::default(),
            identified: if model.verdict().is_some() { names.clone() } else { Vec::new() },
            names,
            is_helicopter: false,
        };
        Ok((model, known.rooted()))
    }

    /// The uncertainty with a relative error of `share`, one sigma as a fraction, of the property `name`, independent
    /// of the others.
    ///
    /// # Errors
    /// [`UnknownSpread`] for a property that does not vary.
    pub fn with_spread(mut self, name: &str, share: f64) -> Result<Self, UnknownSpread> {
        let Some(place) = self.names.iter().position(|own| own == name) else {
            return Err(UnknownSpread { name: name.into(), known: self.names });
        };
        self.covariance.row_mut(place).fill(0.0);
        self.covariance.column_mut(place).fill(0.0);
        self.covariance[(place, place)] = (share * self.nominal[place]).powi(2);
        self.identified.retain(|own| own != name);
        Ok(self.rooted())
    }

    fn rooted(mut self) -> Self {
        let eigen = self.covariance.clone().symmetric_eigen();
        let spreads = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
        self.root = eigen.eigenvectors * DMatrix::from_diagonal(&spreads);
        self
    }

    /// Properties whose covariance was identified.
    #[must_use]
    pub fn identified(&self) -> &[String] {
        &self.identified
    }

    /// Name of each drawn value: `factor_mass` for a factor on a property of the helicopter, and else the parameter.
    pub fn columns(&self) -> impl Iterator<Item = String> {
        let prefix = if self.is_helicopter { "factor_" } else { "" };
        self.names.iter().map(move |name| format!("{prefix}{name}"))
    }

    /// Values of the properties. Factors on the helicopter are limited to between a third and three.
    pub(super) fn draw(&self, noise: &mut Noise) -> Vec<f64> {
        let normal = DVector::from_fn(self.names.len(), |_, _| noise.normal());
        let off = &self.root * normal;
        let drawn = self.nominal.iter().zip(off.iter()).map(|(nominal, off)| nominal + off);
        if self.is_helicopter {
            drawn.map(|factor| factor.clamp(1.0 / 3.0, 3.0)).collect()
        } else {
            drawn.collect()
        }
    }

    /// `model` with the `drawn` values of its parameters.
    ///
    /// # Errors
    /// [`ModelError`] where a matrix does not stay finite.
    pub(super) fn moved(
        &self,
        model: &StateSpace,
        drawn: &[f64],
    ) -> Result<StateSpace, ModelError> {
        let by: Vec<f64> = (model.parameters().iter())
            .map(|parameter| {
                let place = self.names.iter().position(|own| *own == parameter.name);
                place.map_or(0.0, |place| drawn[place] - self.nominal[place])
            })
            .collect();
        model.moved(&by)
    }
}

/// `model` with every derivative of its forces, moments and rotor as a parameter. Each added parameter has an
/// independent relative error of [`BY_HAND`].
fn by_hand(model: &StateSpace) -> Result<StateSpace, ModelError> {
    const KINEMATIC: [&str; 3] = ["phi", "theta", "psi"];
    // Exact derivatives, which do not vary: gravity, and the body rates in the flapping equations.
    const EXACT: [(&str, &str); 6] =
        [("u", "theta"), ("v", "phi"), ("a", "q"), ("b", "p"), ("c", "q"), ("d", "p")];
    let (mut parameters, mut slopes) = (model.parameters().to_vec(), Vec::new());
    let own = parameters.len();
    for (row, state) in model.states().iter().enumerate() {
        let (a, b) = (model.a().row(row), model.b().row(row));
        let of_states = model.states().iter().zip(a.iter().copied());
        let of_inputs = model.inputs().iter().zip(b.iter().copied());
        let entries = of_states.chain(of_inputs).filter(|(column, value)| {
            let exact = EXACT.contains(&(&*state.name, &*column.name));
            *value != 0.0 && !exact && !KINEMATIC.contains(&&*state.name)
        });
        for (column, value) in entries {
            let name = format!("{}_{}", state.name, column.name);
            let (row, column) = (state.name.clone(), column.name.clone());
            slopes.push(Slope { parameter: name.clone(), row, column, slope: 1.0 });
            parameters.push(Parameter { name, value, unit: String::new() });
        }
    }
    let variances = parameters.iter().enumerate().map(|(place, parameter)| {
        if place < own { 0.0 } else { (BY_HAND * parameter.value).powi(2) }
    });
    let covariance = DMatrix::from_diagonal(&DVector::from_iterator(parameters.len(), variances));
    model.clone().with_parameters(parameters, Some(covariance))?.with_slopes(slopes)
}

/// The airframe with the physical causes of [`UNCERTAIN`] multiplied by `factors`.
pub(super) fn airframe(nominal: &HelicopterParameters, factors: &[f64]) -> HelicopterParameters {
    let mut airframe = *nominal;
    let &[mass, lb, ma, blat, alon, zcol, nr, nped, xu, yv] = factors else { return airframe };
    airframe.mass_kg *= mass;
    // Lb is the hub moment per flapping angle, divided by the inertia.
    airframe.inertia_kgm2[0] /= lb;
    airframe.inertia_kgm2[1] /= ma;
    airframe.lateral_cyclic_rad *= blat;
    airframe.bar.lateral_tilt_rad *= blat;
    airframe.longitudinal_cyclic_rad *= alon;
    airframe.bar.longitudinal_tilt_rad *= alon;
    airframe.collective_rad *= zcol;
    // The gyro of the tail provides the damping, and full pedal commands a yaw rate to this gyro.
    airframe.gyro_gain_s *= nr;
    airframe.pedal_rate_radps *= nped / nr;
    airframe.fuselage_area_m2[0] *= xu;
    airframe.fuselage_area_m2[1] *= yv;
    airframe
}
