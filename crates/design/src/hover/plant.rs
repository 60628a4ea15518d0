//! Plant of the design: the model with its sticks in one unit, a heading, and its servos.

use nalgebra::DMatrix;

use crate::DesignError;
use hovernav::controls::Sticks;
use hovernav_model::hover::unit_of;
use hovernav_model::{LinearModel, Signal, StateSpace, TimeDomain};

/// States required in every hover model.
const MEASURED: [&str; 8] = ["p", "q", "phi", "theta", "u", "v", "w", "r"];
/// Sticks, in the order of the controls.
const STICKS: [&str; 4] = Sticks::NAMES;
/// Names of the states of flapping and bar.
const ROTOR: [&str; 4] = ["a", "b", "c", "d"];

/// `model` with every stick scaled to −1…1, in the order lateral, longitudinal, collective, pedal. A heading is added
/// to a model without heading.
pub(super) fn normalised(model: &StateSpace) -> Result<StateSpace, DesignError> {
    model.require_continuous()?;
    for name in MEASURED {
        model.state(name)?;
    }
    for state in model.states() {
        let counts = state.name == "psi" || MEASURED.contains(&state.name.as_str());
        let expected = unit_of(&state.name);
        if counts && expected != state.unit {
            let (state, unit) = (state.name.clone(), state.unit.clone());
            return Err(DesignError::StateUnit { state, unit, expected });
        }
    }
    let mut states = model.states().to_vec();
    let mut a = model.a().clone();
    let mut b = DMatrix::zeros(states.len(), STICKS.len());
    for (column, name) in STICKS.into_iter().enumerate() {
        let input = model.input(name)?;
        let full = match model.inputs()[input].unit.as_str() {
            "stick" => 1.0,
            "percent" | "%" => 100.0,
            unit => {
                return Err(DesignError::InputUnit { input: name.into(), unit: unit.into() });
            }
        };
        b.set_column(column, &(model.b().column(input) * full));
    }
    if model.state("psi").is_err() {
        let n = states.len();
        let rate = model.state("r")?;
        a = a.insert_row(n, 0.0).insert_column(n, 0.0);
        a[(n, rate)] = 1.0;
        b = b.insert_row(n, 0.0);
        states.push(Signal::new("psi", "rad"));
    }
    let inputs = STICKS.map(|name| Signal::new(name, "stick")).to_vec();
    let plant = StateSpace::new(model.name(), TimeDomain::Continuous, states, inputs, a, b)?;
    Ok(plant.with_trim_speed(model.trim_speed_mps())?)
}

/// Flapping and bar states of `plant`.
pub(super) fn rotor_states(plant: &StateSpace) -> Vec<&str> {
    named(plant, |name| ROTOR.contains(&name))
}

/// States of `plant` that are neither measured nor part of the rotor.
pub(super) fn other_states(plant: &StateSpace) -> Vec<&str> {
    named(plant, |name| name != "psi" && !MEASURED.contains(&name) && !ROTOR.contains(&name))
}

fn named(plant: &StateSpace, keep: impl Fn(&str) -> bool) -> Vec<&str> {
    plant.states().iter().map(|state| state.name.as_str()).filter(|name| keep(name)).collect()
}

/// Indices of the states `names` of `plant`.
pub(super) fn places<const N: usize>(
    plant: &StateSpace,
    names: [&str; N],
) -> Result<[usize; N], DesignError> {
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        *place = plant.state(name)?;
    }
    Ok(places)
}

/// The exact step over `period_s` of `plant` behind first-order servos with held commands, n + m states and m inputs.
/// The states are those of the plant, then the positions of the servos.
pub(super) fn stepped(
    plant: &StateSpace,
    servos_s: &[f64],
    period_s: f64,
) -> Result<LinearModel, DesignError> {
    let (n, m) = plant.b().shape();
    let mut a = DMatrix::zeros(n + m, n + m);
    a.view_mut((0, 0), (n, n)).copy_from(plant.a());
    a.view_mut((0, n), (n, m)).copy_from(plant.b());
    let mut b = DMatrix::zeros(n + m, m);
    for (servo, lag_s) in servos_s.iter().enumerate() {
        a[(n + servo, n + servo)] = -1.0 / lag_s;
        b[(n + servo, servo)] = 1.0 / lag_s;
    }
    let actuated = LinearModel::of_states(TimeDomain::Continuous, a, b);
    actuated.held(period_s).ok_or(DesignError::NotFinite { matrix: "AT" })
}
