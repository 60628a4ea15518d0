//! Minimum requirements of a design, and a search for weights that meet them.

use super::closed_loop::{self, Cut, FlightMode};
use super::config::HoverDesign;
use super::evolution::{Random, minimise};
use super::limited::back_with_stops_s;
use super::perturbation::{Perturbed, models_off_by};
use super::plant::normalised;
use crate::{DesignError, Loop, TABLE_6_1};
use hovernav::autopilot::Gains;
use hovernav_model::StateSpace;

/// Requirements of a design.
struct Requirements {
    /// Longest recovery time of a disturbance, s, for three groups: φ, θ, p, q, u and v; heading and yaw rate; w.
    back_s: [f64; 3],
    /// Fraction of its size within which a disturbance counts as recovered.
    band: f64,
    /// Gain margin of every loop, dB.
    gain_db: f64,
    /// Phase margin of every loop, °.
    phase_deg: f64,
    /// Slowest decay of a model with perturbed derivatives, 1/s.
    decay_per_s: f64,
}

/// Requirements of every design.
const REQUIRED: Requirements = Requirements {
    back_s: [8.0, 1.0, 2.0],
    band: 0.02,
    gain_db: 6.0,
    phase_deg: 45.0,
    decay_per_s: 0.0,
};
/// Targets of the search. They are slightly stricter than [`REQUIRED`], because the search uses few frequencies and few
/// models.
const AIMED: Requirements = Requirements {
    back_s: [7.9, 0.97, 1.95],
    band: 0.019,
    gain_db: 6.2,
    phase_deg: 45.8,
    decay_per_s: 0.01,
};
/// Number of frequencies for margins.
const FREQUENCIES: usize = 90;
/// Largest relative change of every derivative.
const OFF: f64 = 0.2;
/// Number of perturbed models for the evaluation of a candidate.
const PERTURBED: usize = 48;
/// Seed of the draw of the models.
const SEED: u64 = 20_050_612;
/// Acceptable mean excess growth over the perturbed models, 1/s: for example 0.2 1/s of one model in twenty.
const FEW_PER_S: f64 = 0.01;
/// Largest counted growth of a vehicle drawn from a covariance, 1/s. With it, one in twenty vehicles of at least this
/// growth reaches the limit [`FEW_PER_S`].
const GROWN_PER_S: f64 = 20.0 * FEW_PER_S;
/// Number of designs to try.
const TRIALS: usize = 2400;
/// Initial step of the search, in logarithms of the weights.
const STEP: f64 = 0.8;

/// Replacement for a design that violates requirements. It differs in the weights of roll and pitch.
pub(super) struct Alternative {
    pub design: HoverDesign,
    /// Violation of the requirements, by the original design and by this one.
    pub violation: [f64; 2],
    /// Number of designs tried.
    pub trials: usize,
}

/// Searches for a design that meets the requirements; `None` where `design` meets all of them.
///
/// # Errors
/// [`DesignError`] where `design` is impossible for `model`.
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
    // The cost has a separate valley: weights with fast control of velocity, which depends on the position of the
    // zeros. From the default weights the search also reaches robust designs, so it starts there.
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

/// The value where it is positive, else 0; infinite for NaN.
fn positive(value: f64) -> f64 {
    if value.is_nan() { f64::INFINITY } else { value.max(0.0) }
}

/// Logarithms of the search variables. The last stick's weight is fixed, because a common factor of all weights does
/// not change the regulator.
fn logarithms(design: &HoverDesign) -> Vec<f64> {
    let weights = &design.roll_pitch;
    let of_states = weights.states.iter().chain(&weights.integrals).chain(&weights.sticks[..1]);
    of_states.chain([&weights.decay_per_s]).map(|weight| weight.ln()).collect()
}

/// `design` with these search variables.
fn with_logarithms(design: &HoverDesign, point: &[f64]) -> HoverDesign {
    /// Largest magnitude of the logarithm of a weight.
    const LARGEST: f64 = 16.0;
    /// Fastest prescribed decay of disturbances, 1/s.
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

/// Violation of the requirements by a design.
struct Violation {
    /// Violation by disturbances that are outside their band at the recovery time, and by the margins in the modes that
    /// hold velocity and position.
    nominal: f64,
    /// Mean over the perturbed models of the excess of the slowest mode's growth over its limit, 1/s.
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
            let max_s = 2.0 * asked.back_s[0];
            nominal += 6.0 * positive((stopped_s.min(max_s) / asked.back_s[0]).ln());
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

/// Controller of a design at its sample rate.
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

    /// Growth rate of the slowest mode of `plant` under this autopilot, 1/s, accurate to some hundredths.
    fn growth_per_s(&self, plant: &StateSpace) -> Result<f64, DesignError> {
        let closed = Loop::at_plant_input(plant, &self.controller)?;
        Ok(growth_per_s(&closed, self.period_s))
    }
}

/// Growth rate of the slowest mode of a `closed` loop, 1/s, accurate to some hundredths; infinite where the computation
/// overflows.
pub(super) fn growth_per_s(closed: &Loop, period_s: f64) -> f64 {
    /// Number of squarings of the transition matrix. After 2¹⁴ samples only the slowest mode remains.
    const SQUARINGS: i32 = 14;
    let open = closed.open();
    let mut step = open.a() - open.b() * open.c();
    // The transition matrix is `step` times the exponential of `logarithm`.
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

/// Number of models with perturbed derivatives that a design keeps stable, in each flight mode.
#[derive(Clone, Debug, PartialEq)]
pub struct PerturbedStability {
    /// Largest relative change of every derivative.
    pub off: f64,
    /// Number of models tried.
    pub of: usize,
    /// Number of models that stay stable in each mode.
    pub modes: Vec<(FlightMode, usize)>,
    /// Number of models that stay stable in every mode.
    pub in_every_mode: usize,
}

impl PerturbedStability {
    /// Varies the derivatives of `model` 500 times, each by up to 20 %, and counts the variants that are stable with
    /// `gains`. Kinematics and gravity stay unchanged. The search for the gains uses other variants.
    ///
    /// # Errors
    /// [`DesignError`] where the loops cannot be closed around `model`.
    pub fn of(
        design: &HoverDesign,
        model: &StateSpace,
        gains: &Gains,
    ) -> Result<Self, DesignError> {
        /// Number of models tried.
        const OF: usize = 500;
        let whole = normalised(model)?;
        let others = models_off_by(&whole, (OFF, OF), &mut Random(SEED + 1))?;
        let mut in_every_mode = vec![true; OF];
        let mut modes = Vec::new();
        for mode in FlightMode::ALL {
            let flown = Flown::by(design, &whole, gains, mode)?;
            let mut stable = 0;
            for (other, is_stable) in others.iter().zip(&mut in_every_mode) {
                let plant = closed_loop::plant(design, other, mode)?;
                let is_own = flown.growth_per_s(&plant)? < 0.0;
                stable += usize::from(is_own);
                *is_stable &= is_own;
            }
            modes.push((mode, stable));
        }
        let in_every_mode = in_every_mode.into_iter().filter(|is_stable| *is_stable).count();
        Ok(Self { off: OFF, of: OF, modes, in_every_mode })
    }

    /// The mode in which the fewest models stay stable, and their number; `None` without modes.
    #[must_use]
    pub fn worst(&self) -> Option<(FlightMode, usize)> {
        self.modes.iter().copied().min_by_key(|(_, stable)| *stable)
    }
}
