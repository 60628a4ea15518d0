//! How well the airframe is known.

use nalgebra::{DMatrix, DVector};

use crate::noise::Noise;
use hovernav_model::StateSpace;
use hovernav_model::helicopter::HelicopterParameters;

/// What of the airframe is not exactly known. Each is a derivative of the hover model, and the airframe
/// flown has the physical cause of it off by the same share.
pub const UNCERTAIN: [&str; 10] =
    ["mass", "Lb", "Ma", "Blat", "Alon", "Zcol", "Nr", "Nped", "Xu", "Yv"];

/// How well the airframe is known: the joint spread of [`UNCERTAIN`], as shares.
#[derive(Clone, Debug, PartialEq)]
pub struct AirframeUncertainty {
    /// L with L Lᵀ the covariance of the shares.
    root: DMatrix<f64>,
    /// Those of [`UNCERTAIN`] that an identified covariance gave.
    identified: Vec<&'static str>,
}

impl Default for AirframeUncertainty {
    /// Each for itself: mass 5 %, all others 10 %, one sigma.
    fn default() -> Self {
        let shares = UNCERTAIN.map(|name| if name == "mass" { 0.05 } else { 0.1 });
        let root = DMatrix::from_diagonal(&DVector::from_row_slice(&shares));
        Self { root, identified: Vec::new() }
    }
}

impl AirframeUncertainty {
    /// As an identified `model` knows it: where its parameters have a covariance, that, correlations
    /// and all; the default for what it does not name. In a model without flapping, Lp and Mq stand for
    /// Lb and Ma, Llat and Mlon for Blat and Alon: by whichever the stick or the damping reaches the
    /// rate.
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

    /// Those of [`UNCERTAIN`] that an identified covariance gave.
    #[must_use]
    pub fn identified(&self) -> &[&'static str] {
        &self.identified
    }

    /// Factors on [`UNCERTAIN`], none further off than from a third to three times.
    pub(super) fn draw(&self, noise: &mut Noise) -> [f64; UNCERTAIN.len()] {
        let normal = DVector::from_fn(UNCERTAIN.len(), |_, _| noise.normal());
        let off = &self.root * normal;
        UNCERTAIN.map(|name| {
            let at = UNCERTAIN.iter().position(|own| *own == name).unwrap_or_default();
            (1.0 + off[at]).clamp(1.0 / 3.0, 3.0)
        })
    }
}

/// The airframe with the causes of [`UNCERTAIN`] off by `factors`.
pub(super) fn airframe(
    nominal: &HelicopterParameters,
    factors: &[f64; UNCERTAIN.len()],
) -> HelicopterParameters {
    let [mass, lb, ma, blat, alon, zcol, nr, nped, xu, yv] = *factors;
    let mut airframe = *nominal;
    airframe.mass_kg *= mass;
    // The hub's sample per flapping over the inertia.
    airframe.inertia_kgm2[0] /= lb;
    airframe.inertia_kgm2[1] /= ma;
    airframe.lateral_cyclic_rad *= blat;
    airframe.bar.lateral_tilt_rad *= blat;
    airframe.longitudinal_cyclic_rad *= alon;
    airframe.bar.longitudinal_tilt_rad *= alon;
    airframe.collective_rad *= zcol;
    // The tail's gyro damps; full pedal asks it for a rate.
    airframe.gyro_gain_s *= nr;
    airframe.pedal_rate_radps *= nped / nr;
    airframe.fuselage_area_m2[0] *= xu;
    airframe.fuselage_area_m2[1] *= yv;
    airframe
}
