//! What a design must have, searched for where the weights that were found do not give it.

use super::closed_loop::{self, Cut, FlightMode};
use super::config::HoverDesign;
use super::evolution::{Random, minimise};
use super::limited::back_with_stops_s;
use super::perturbation::{Perturbed, plants_off_by};
use super::plant::normalised;
use crate::{DesignError, Loop, TABLE_6_1};
use hovernav::autopilot::Gains;
use hovernav_model::StateSpace;

/// What is asked of a design.
struct Requirements {
    /// Seconds within which a disturbance is over: of φ, θ, p, q, u and v, of heading and yaw rate, of w.
    back_s: [f64; 3],
    /// Share of its size within which it is over.
    band: f64,
    /// Margins of every loop, dB and °.
    gain_db: f64,
    phase_deg: f64,
    /// Slowest decay on a model whose derivatives are off, 1/s.
    decay_per_s: f64,
}

/// What every design must have.
const REQUIRED: Requirements = Requirements {
    back_s: [8.0, 1.0, 2.0],
    band: 0.02,
    gain_db: 6.0,
    phase_deg: 45.0,
    decay_per_s: 0.0,
};
/// What is aimed at for it: a little more, for the search sees few frequencies and few models.
const AIMED: Requirements = Requirements {
    back_s: [7.9, 0.97, 1.95],
    band: 0.019,
    gain_db: 6.2,
    phase_deg: 45.8,
    decay_per_s: 0.01,
};
/// Frequencies at which margins are looked at.
const FREQUENCIES: usize = 90;
/// Share by which every derivative may be off.
const OFF: f64 = 0.2;
/// Models that a candidate is tried on, and seed of their draw.
const PERTURBED: usize = 48;
const SEED: u64 = 20_050_612;
/// Mean growth of those that grow, 1/s, that is not searched on for: some one in twenty of them.
const FEW_PER_S: f64 = 0.01;
/// Growth, 1/s, as which that of a vehicle drawn from a covariance counts at most: one in twenty that grow so or
/// faster are few.
const GROWN_PER_S: f64 = 20.0 * FEW_PER_S;
/// Designs to try.
const TRIALS: usize = 2400;
/// First step, of the logarithms of the weights.
const STEP: f64 = 0.8;

/// A design with other weights of roll and pitch than the one that lacks what is required.
pub(super) struct Alternative {
    pub design: HoverDesign,
    /// By how much the requirements are violated, by the design there was and by this one.
    pub violation: [f64; 2],
    /// Designs tried.
    pub trials: usize,
}

/// Searches for what is required where `design` lacks some of it; `None` where it has all of it.
///
/// # Errors
/// [`DesignError`] where `design` is none for `model`.
pub(super) fn alternative(
    design: &HoverDesign,
    model: &StateSpace,
) -> Result<Option<Alternative>, DesignError> {
    let perturbed = Perturbed::new(design, model, (OFF, PERTURBED), &mut Random(SEED))?;
    let required = |design: &HoverDesign| -> Result<f64, DesignError> {
        let violation = violation(design, model, &perturbed, &REQUIRED)?;
        let few = violation.growth_per_s < FEW_PER_S;
        Ok(if few { violation.nominal } else { violation.cost() })
    };
    let now = required(design)?;
    if now <= 0.0 {
        return Ok(None);
    }
    // Weights that are fast in velocity and lean on where the zeros are lie in a valley of their own; from even
    // ones the way leads to what withstands, too.
    let even = HoverDesign { roll_pitch: HoverDesign::default().roll_pitch, ..design.clone() };
    let cost = |point: &[f64]| {
        let aimed = violation(&with_logarithms(&even, point), model, &perturbed, &AIMED);
        aimed.map_or(f64::INFINITY, |violation| violation.cost())
    };
    let found = minimise(&logarithms(&even), STEP, TRIALS, SEED, cost);
    let other = with_logarithms(&even, &found.at);
    let violation = [now, required(&other).unwrap_or(f64::INFINITY)];
    Ok(Some(Alternative { design: other, violation, trials: found.trials }))
}

/// A number where it is positive, else none; what is no number lacks everything.
fn positive(value: f64) -> f64 {
    if value.is_nan() { f64::INFINITY } else { value.max(0.0) }
}

/// The logarithms of what is searched. The last stick's weight stays: all of them times a number are the same
/// regulator.
fn logarithms(design: &HoverDesign) -> Vec<f64> {
    let weights = &design.roll_pitch;
    let of_states = weights.states.iter().chain(&weights.integrals).chain(&weights.sticks[..1]);
    of_states.chain([&weights.decay_per_s]).map(|weight| weight.ln()).collect()
}

/// `design` with what is searched.
fn with_logarithms(design: &HoverDesign, point: &[f64]) -> HoverDesign {
    const LARGEST: f64 = 16.0;
    const FASTEST_DECAY_PER_S: f64 = 0.6;
    let mut next = design.clone();
    let weights = &mut next.roll_pitch;
    let of_states = weights.states.iter_mut().chain(&mut weights.integrals);
    let all = of_states.chain(&mut weights.sticks[..1]).chain([&mut weights.decay_per_s]);
    for (weight, value) in all.zip(point) {
        *weight = value.clamp(-LARGEST, LARGEST).exp();
    }
    weights.decay_per_s = weights.decay_per_s.min(FASTEST_DECAY_PER_S);
    next
}

/// By how much a design violates what is asked of it.
struct Violation {
    /// By what disturbances are out of their band when they are to be back, and by margins where velocity is
    /// known.
    nominal: f64,
    /// By how much the modes of perturbed models grow faster than they should, 1/s, on average.
    growth_per_s: f64,
}

impl Violation {
    fn cost(&self) -> f64 {
        self.nominal + 20.0 * self.growth_per_s
    }
}

fn violation(
    design: &HoverDesign,
    model: &StateSpace,
    perturbed: &Perturbed,
    asked: &Requirements,
) -> Result<Violation, DesignError> {
    let gains = design.synthesise(model)?;
    let whole = normalised(model)?;
    let growth_in = |mode| {
        Flown::by(design, &whole, &gains, mode)?
            .growth_per_s(&closed_loop::plant(design, &whole, mode)?)
    };
    let growth = growth_in(FlightMode::Velocity)?;
    if growth.is_nan() || growth >= 0.0 {
        return Ok(Violation { nominal: 100.0 + growth, growth_per_s: 1.0 });
    }
    let mut nominal = 0.0;
    for disturbance in TABLE_6_1 {
        let (state, size) = disturbance;
        let back_s = match state {
            "psi" | "r" => asked.back_s[1],
            "w" => asked.back_s[2],
            _ => asked.back_s[0],
        };
        let response = design.respond(model, &gains, disturbance, 2.0 * asked.back_s[0])?;
        nominal += 6.0 * positive((response.largest_from(back_s) / (asked.band * size)).ln());
        if let Some(stopped_s) = back_with_stops_s(design, model, &gains, &response)? {
            let most_s = 2.0 * asked.back_s[0];
            nominal += 6.0 * positive((stopped_s.min(most_s) / asked.back_s[0]).ln());
        }
    }
    for mode in [FlightMode::Velocity, FlightMode::Position] {
        let growth = growth_in(mode)?;
        if growth.is_nan() || growth >= 0.0 {
            nominal += 25.0;
            continue;
        }
        let closed = design.close_in(model, &gains, mode, Cut::Actuators)?;
        let (gain_db, phase_deg) = closed.weakest(FREQUENCIES);
        let below = |found: f64, least: f64| positive(1.0 - found / least);
        nominal += 25.0 * (below(gain_db, asked.gain_db) + below(phase_deg, asked.phase_deg));
    }
    let flown = Flown::by(design, &whole, &gains, FlightMode::Velocity)?;
    let growth_per_s = perturbed
        .worst(GROWN_PER_S, |other| Ok(positive(flown.growth_per_s(other)? + asked.decay_per_s)))?;
    Ok(Violation { nominal, growth_per_s })
}

/// The autopilot of a design at its rate.
struct Flown {
    controller: StateSpace,
    period_s: f64,
}

impl Flown {
    fn by(
        design: &HoverDesign,
        whole: &StateSpace,
        gains: &Gains,
        mode: FlightMode,
    ) -> Result<Self, DesignError> {
        let controller = closed_loop::controller(design, whole.inputs(), gains, mode)?;
        Ok(Self { controller, period_s: design.period_s })
    }

    /// How fast the slowest mode of `plant` grows under it, 1/s, to some hundredths.
    fn growth_per_s(&self, plant: &StateSpace) -> Result<f64, DesignError> {
        let closed = Loop::at_plant_input(plant, &self.controller)?;
        Ok(growth_per_s(&closed, self.period_s))
    }
}

/// How fast the slowest mode of a `closed` loop grows, 1/s, to some hundredths; infinite where that is no number.
pub(super) fn growth_per_s(closed: &Loop, period_s: f64) -> f64 {
    /// After 2 to the power of this many samples only the slowest mode is left.
    const SQUARINGS: i32 = 14;
    let open = closed.open();
    let mut step = open.a() - open.b() * open.c();
    // The step is what is left of it times the exponential of this.
    let mut logarithm = 0.0;
    for _ in 0..SQUARINGS {
        let size = step.amax();
        if !(size > 0.0 && size.is_finite()) {
            break;
        }
        logarithm = 2.0 * (logarithm + size.ln());
        step /= size;
        step = &step * &step;
    }
    if step.iter().any(|value| !value.is_finite()) {
        return f64::INFINITY;
    }
    let size = step.amax().max(f64::MIN_POSITIVE);
    (logarithm + size.ln()) / (2f64.powi(SQUARINGS) * period_s)
}

/// How many of some models whose derivatives are off a design keeps stable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerturbedStability {
    /// Share by which every derivative of them is off, at most.
    pub off: f64,
    /// Models that stay stable, holding velocity.
    pub stable: usize,
    /// Models tried.
    pub of: usize,
}

impl PerturbedStability {
    /// How many of 500 models `gains` keep stable whose every derivative is off by up to a fifth, each for
    /// itself; what is kinematics or gravity stays. None of them is one that the search saw.
    ///
    /// # Errors
    /// [`DesignError`] where the loops cannot be closed around `model`.
    pub fn of(
        design: &HoverDesign,
        model: &StateSpace,
        gains: &Gains,
    ) -> Result<Self, DesignError> {
        const OF: usize = 500;
        let flown = Flown::by(design, &normalised(model)?, gains, FlightMode::Velocity)?;
        let mut stable = 0;
        for other in plants_off_by(design, model, (OFF, OF), &mut Random(SEED + 1))? {
            if flown.growth_per_s(&other)? < 0.0 {
                stable += 1;
            }
        }
        Ok(Self { off: OFF, stable, of: OF })
    }
}
