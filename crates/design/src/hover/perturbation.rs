//! Models with perturbed derivatives.

use super::closed_loop::{self, FlightMode};
use super::config::HoverDesign;
use super::evolution::Random;
use super::plant::normalised;
use super::uncertainty::Uncertainty;
use crate::DesignError;
use hovernav_model::StateSpace;

/// Seed of the draw from the covariance.
const SEED: u64 = 20_050_613;

/// Perturbed plants in the mode that holds velocity, for the evaluation of a candidate.
///
/// Independent perturbations of every derivative demand robustness against errors of well-known and unknown parameters
/// alike. The covariance distinguishes them, if the model has one, but contains only the information of the
/// identification. A design has to withstand both: the set with the worse result counts.
pub(super) struct Perturbed {
    /// Plants with every derivative perturbed.
    off: Vec<StateSpace>,
    /// Plants drawn from the covariance; empty without one.
    drawn: Vec<StateSpace>,
}

impl Perturbed {
    /// `of` plants with every derivative changed by up to the fraction `share`. If `model` has a covariance and slopes
    /// of its parameters, the same number of plants is also drawn from the covariance.
    pub fn new(
        design: &HoverDesign,
        model: &StateSpace,
        (share, of): (f64, usize),
        random: &mut Random,
    ) -> Result<Self, DesignError> {
        let off = plants_off_by(design, model, (share, of), random)?;
        let mut drawn = Vec::new();
        if let Some(uncertainty) = Uncertainty::of(model) {
            let mut random = Random(SEED);
            // A vehicle whose transition matrix is not finite is omitted: it contains no information on the weights.
            let draw = |_| {
                let vehicle = uncertainty.vehicle(&uncertainty.draw(&mut random)).ok()?;
                vehicle.plant(design, FlightMode::Velocity).ok()
            };
            drawn = (0..of).filter_map(draw).collect();
        }
        Ok(Self { off, drawn })
    }

    /// The larger of the mean `cost` over both sets. A drawn vehicle costs `most` at most. A normal distribution
    /// includes vehicles that cannot be controlled, and no weights should be adapted to these.
    pub fn worst(
        &self,
        most: f64,
        cost: impl Fn(&StateSpace) -> Result<f64, DesignError>,
    ) -> Result<f64, DesignError> {
        let mean = |plants: &[StateSpace], most: f64| {
            let costs = plants.iter().map(|plant| Ok(cost(plant)?.min(most)));
            let sum = costs.sum::<Result<f64, DesignError>>()?;
            Ok::<_, DesignError>(sum / plants.len().max(1) as f64)
        };
        Ok(mean(&self.off, f64::INFINITY)?.max(mean(&self.drawn, most)?))
    }
}

/// List of plants, `of` in number, in the mode that holds velocity, behind the servos of `design`. Every derivative is
/// changed by up to the fraction `share`.
fn plants_off_by(
    design: &HoverDesign,
    model: &StateSpace,
    (share, of): (f64, usize),
    random: &mut Random,
) -> Result<Vec<StateSpace>, DesignError> {
    let models = models_off_by(&normalised(model)?, (share, of), random)?;
    models.iter().map(|other| closed_loop::plant(design, other, FlightMode::Velocity)).collect()
}

/// List of models like `whole`, `of` in number. Every derivative is changed by up to the fraction `share`.
pub(super) fn models_off_by(
    whole: &StateSpace,
    (share, of): (f64, usize),
    random: &mut Random,
) -> Result<Vec<StateSpace>, DesignError> {
    (0..of).map(|_| off_by(whole, share, random)).collect()
}

/// `model` with every derivative changed independently by up to the fraction `share`. Kinematics and gravity stay
/// unchanged.
fn off_by(model: &StateSpace, share: f64, random: &mut Random) -> Result<StateSpace, DesignError> {
    let is_angle: Vec<bool> = model
        .states()
        .iter()
        .map(|state| matches!(state.name.as_str(), "phi" | "theta" | "psi"))
        .collect();
    let (mut a, mut b) = (model.a().clone(), model.b().clone());
    let mut off = || 1.0 + share * (2.0 * random.uniform() - 1.0);
    for row in (0..a.nrows()).filter(|&row| !is_angle[row]) {
        for column in (0..a.ncols()).filter(|&column| !is_angle[column]) {
            a[(row, column)] *= off();
        }
        for column in 0..b.ncols() {
            b[(row, column)] *= off();
        }
    }
    let (states, inputs) = (model.states().to_vec(), model.inputs().to_vec());
    Ok(StateSpace::new(model.name(), model.time(), states, inputs, a, b)?)
}

#[cfg(test)]
mod tests {
    use super::super::uncertainty::tests::known_to;
    use super::*;

    #[test]
    fn one_vehicle_that_nothing_can_fly_counts_for_one() {
        let model = known_to(0.1);
        let design = HoverDesign::default();
        let perturbed = Perturbed::new(&design, &model, (0.2, 10), &mut Random(1)).unwrap();
        let wild = &perturbed.drawn[3];
        let cost = |plant: &StateSpace| Ok(if plant == wild { 1e6 } else { 0.0 });
        assert_eq!(perturbed.worst(f64::INFINITY, cost).unwrap(), 1e5);
        assert_eq!(perturbed.worst(0.2, cost).unwrap(), 0.02);
        let wild = &perturbed.off[3];
        let cost = |plant: &StateSpace| Ok(if plant == wild { 1e6 } else { 0.0 });
        assert_eq!(perturbed.worst(0.2, cost).unwrap(), 1e5);
    }
}
