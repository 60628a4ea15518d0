//! Models whose derivatives are not what was identified.

use super::evolution::Random;
use crate::DesignError;
use hovernav_model::StateSpace;

/// `model` with every derivative off by up to `share` of it, each for itself; kinematics and gravity stay.
pub(super) fn off_by(
    model: &StateSpace,
    share: f64,
    random: &mut Random,
) -> Result<StateSpace, DesignError> {
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
