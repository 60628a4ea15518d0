//! Uncertainty of the airframe.

use nalgebra::{DMatrix, DVector};

use crate::noise::Noise;
use hovernav_model::StateSpace;
use hovernav_model::helicopter::HelicopterParameters;

/// Uncertain properties of the airframe. Each is a derivative of the hover model; in the simulated airframe its
/// physical cause has the same relative error.
pub const UNCERTAIN: [&str; 10] =
    ["mass", "Lb", "Ma", "Blat", "Alon", "Zcol", "Nr", "Nped", "Xu", "Yv"];

/// Uncertainty of the airframe: the joint distribution of the relative errors of [`UNCERTAIN`].
#[derive(Clone, Debug, PartialEq)]
pub struct AirframeUncertainty {
    /// L with L Lᵀ the covariance of the relative errors.
    root: DMatrix<f64>,
    /// Properties of [`UNCERTAIN`] whose covariance was identified.
    identified: Vec<&'static str>,
}

impl Default for AirframeUncertainty {
    /// Independent errors, one sigma: mass 5 %, all others 10 %.
    fn default() -> Self {
        let shares = UNCERTAIN.map(|name| if name == "mass" { 0.05 } else { 0.1 });
        let root = DMatrix::from_diagonal(&DVector::from_row_slice(&shares));
        Self { root, identified: Vec::new() }
    }
}

impl AirframeUncertainty {
    /// Uncertainty of an identified `model`: the covariance of its parameters with all correlations, and the default
    /// for properties that it does not contain. In a model without flapping, Lp and Mq replace Lb and Ma, and Llat and
    /// Mlon replace Blat and Alon. They have the corresponding effect on the rates.
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
        let mut shares = &known.root * known.root.transpose();
        for (row, at_row) in places.iter().enumerate() {
            for (column, at_column) in places.iter().enumerate() {
                if let (&Some(one), &Some(other)) = (at_row, at_column) {
                    let scale = parameters[one].value * parameters[other].value;
                    let share = covariance[(one, other)] / scale;
                    shares[(row, column)] = if share.is_finite() { share } else { 0.0 };
                }
            }
        }
        let eigen = shares.symmetric_eigen();
        let spreads = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
        known.root = eigen.eigenvectors * DMatrix::from_diagonal(&spreads);
        known.identified = UNCERTAIN
            .into_iter()
            .zip(places)
            .filter_map(|(name, place)| place.map(|_| name))
            .collect();
        known
    }

    /// Properties of [`UNCERTAIN`] whose covariance was identified.
    #[must_use]
    pub fn identified(&self) -> &[&'static str] {
        &self.identified
    }

    /// Factors on [`UNCERTAIN`], limited to between a third and three.
    pub(super) fn draw(&self, noise: &mut Noise) -> [f64; UNCERTAIN.len()] {
        let normal = DVector::from_fn(UNCERTAIN.len(), |_, _| noise.normal());
        let off = &self.root * normal;
        UNCERTAIN.map(|name| {
            let at = UNCERTAIN.iter().position(|own| *own == name).unwrap_or_default();
            (1.0 + off[at]).clamp(1.0 / 3.0, 3.0)
        })
    }
}

/// The airframe with the physical causes of [`UNCERTAIN`] multiplied by `factors`.
pub(super) fn airframe(
    nominal: &HelicopterParameters,
    factors: &[f64; UNCERTAIN.len()],
) -> HelicopterParameters {
    let [mass, lb, ma, blat, alon, zcol, nr, nped, xu, yv] = *factors;
    let mut airframe = *nominal;
    airframe.mass_kg *= mass;
    // Lb is the hub moment per flapping angle over the inertia.
    airframe.inertia_kgm2[0] /= lb;
    airframe.inertia_kgm2[1] /= ma;
    airframe.lateral_cyclic_rad *= blat;
    airframe.bar.lateral_tilt_rad *= blat;
    airframe.longitudinal_cyclic_rad *= alon;
    airframe.bar.longitudinal_tilt_rad *= alon;
    airframe.collective_rad *= zcol;
    // The tail's gyro provides the damping; full pedal commands it a rate.
    airframe.gyro_gain_s *= nr;
    airframe.pedal_rate_radps *= nped / nr;
    airframe.fuselage_area_m2[0] *= xu;
    airframe.fuselage_area_m2[1] *= yv;
    airframe
}
