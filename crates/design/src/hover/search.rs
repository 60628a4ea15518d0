//! Bounded, seeded search for the weights that meet a user's requirements on a loop.

use super::closed_loop::{self, Cut, FlightMode};
use super::config::HoverDesign;
use super::evolution::Random;
use super::forward::{self, FlownModel};
use super::limited::back_with_stops_s;
use super::perturbation::Perturbed;
use super::plant::normalised;
use super::required;
use crate::{DISTURBED, DesignError, Loop as ClosedLoop, TABLE_6_1};
use hovernav::autopilot::Gains;
use hovernav_model::StateSpace;

/// Requirements of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Time within which each disturbance of table 6.1 decays to 2 % of its size, s: of φ, θ, p, q, u and v; of heading
    /// and yaw rate; of w.
    pub settled_s: [f64; 3],
    /// Phase margin of every loop at its actuator, °.
    pub phase_deg: f64,
    /// Gain margin of every loop, dB.
    pub gain_db: f64,
    /// Largest relative change of every derivative.
    pub off: f64,
    /// Number of designs to try.
    pub trials: usize,
}

impl Default for Wanted {
    /// Default requirements: settling just within 8 s, heading within 1 s, height within 2 s; 54° and 9 dB; ±20 %; 720
    /// designs.
    fn default() -> Self {
        Self { settled_s: [7.7, 0.97, 1.95], phase_deg: 54.0, gain_db: 9.0, off: 0.2, trials: 720 }
    }
}

/// Result of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Search {
    /// The best design found.
    pub design: HoverDesign,
    /// Shortfall of the best design and of the initial one; 0 meets all requirements.
    pub shortfall: [f64; 2],
    /// Number of designs tried.
    pub trials: usize,
}

/// Number of perturbed models for the evaluation of a candidate.
const PERTURBED: usize = 24;
/// Number of frequencies for a candidate's margins.
const FREQUENCIES: usize = 90;
/// Seed of the search.
const SEED: u64 = 20_050_611;

impl HoverDesign {
    /// Searches the weights of this design for `wanted` on `model`, the vehicle in hover. The same start gives the same
    /// result. With models of the vehicle `at_speed`, the required margins also apply to each of them with the gains of
    /// hover.
    ///
    /// Each trial multiplies one or a few weights by random factors. A design with a smaller shortfall is kept. The
    /// range of the factors widens after success and narrows after failure. The shortfall is a sum over settling,
    /// margins in every flight mode, sticks within their travel, and stability with perturbed derivatives. Where a
    /// stick reaches a stop, settling with stops is added. If the model contains its uncertainty, stability is also
    /// evaluated on vehicles drawn from it. The worse result counts.
    ///
    /// A second search follows if the best design violates a minimum requirement. These are 45° and 6 dB, the times of
    /// the table, and stability of nine in ten models perturbed by 20 %. The search varies the weights of roll and
    /// pitch for these requirements alone; its result is selected where it violates them less.
    ///
    /// # Errors
    /// [`DesignError`] where the initial design is impossible for the model, and [`DesignError::At`] for models that
    /// contradict each other or cannot be used.
    ///
    /// # Source
    /// The step rule is Rechenberg's one-fifth rule: Schwefel, *Evolution and Optimum Seeking* (1995).
    pub fn searched(
        &self,
        model: &StateSpace,
        at_speed: &[StateSpace],
        wanted: &Wanted,
    ) -> Result<Search, DesignError> {
        let models = forward::models(self, model, at_speed)?;
        self.synthesise(model)?;
        let mut random = Random(SEED);
        let perturbed = Perturbed::new(self, model, (wanted.off, PERTURBED), &mut random)?;
        let in_flight = |design: &HoverDesign, least: f64| {
            in_flight(design, &models, &perturbed, wanted, least).unwrap_or(f64::INFINITY)
        };
        let in_attitude =
            |design: &HoverDesign| in_attitude(design, &models, wanted).unwrap_or(f64::INFINITY);
        let evaluated = |design: Self| {
            let (flight, attitude) = (in_flight(&design, f64::INFINITY), in_attitude(&design));
            Evaluated { design, flight, attitude }
        };
        let start = evaluated(self.clone());
        let at_start = start.shortfall();
        // An integral overshoots in proportion to its initial error. It must settle within the required time, or so
        // slowly that its tail stays within the band. No step of the search crosses the ridge between the two.
        let mut slow = self.clone();
        slow.yaw.integral = SLOW * slow.yaw.states[1];
        let mut trials = 0;
        let mut climb = |mut best: Evaluated, most: usize, order: &[Loop]| {
            // One step length per loop.
            let (mut steps, first) = ([0.8; 4], trials);
            while trials - first < most && best.shortfall() > 0.0 {
                trials += 1;
                let mut next = best.design.clone();
                // The loops are nearly independent. Each trial changes one loop only. A bad draw in another loop then
                // cannot hide an improvement.
                let turn = order[trials % order.len()];
                let at =
                    if turn == Loop::Attitude && best.attitude <= 0.0 { Loop::Yaw } else { turn };
                let of_attitude = at == Loop::Attitude;
                let mut weights = weights(&mut next, at);
                let step = &mut steps[at as usize];
                let moved = 1 + (random.uniform() * 3.0) as usize;
                for _ in 0..moved {
                    let at = (random.uniform() * weights.len() as f64) as usize;
                    let by = (*step * (2.0 * random.uniform() - 1.0)).exp();
                    if let Some((weight, [lowest, highest])) = weights.get_mut(at) {
                        **weight = (**weight * by).clamp(*lowest, *highest);
                    }
                }
                let now = best.shortfall();
                let flight = if of_attitude { best.flight } else { in_flight(&next, now) };
                let attitude = if flight < now { in_attitude(&next) } else { f64::INFINITY };
                if flight + attitude < now {
                    best = Evaluated { design: next, flight, attitude };
                    *step = f64::min(1.4 * *step, 1.5);
                } else {
                    *step = f64::max(0.92 * *step, 0.05);
                }
            }
            best
        };
        let best = if slow.yaw.integral < self.yaw.integral {
            let each = wanted.trials / 10;
            let fast = climb(start, each, &[Loop::Yaw]);
            let slow = climb(evaluated(slow), each, &[Loop::Yaw]);
            let better = if slow.shortfall() < fast.shortfall() { slow } else { fast };
            climb(better, wanted.trials - 2 * each, &ORDER)
        } else {
            climb(start, wanted.trials, &ORDER)
        };
        let best = match required::alternative(&best.design, model)? {
            None => best,
            Some(other) => {
                trials += other.trials;
                best.or(evaluated(other.design), other.violation)
            }
        };
        Ok(Search { shortfall: [best.shortfall(), at_start], design: best.design, trials })
    }
}

/// A design and its shortfall.
struct Evaluated {
    design: HoverDesign,
    /// Shortfall with known velocity.
    flight: f64,
    /// Shortfall without known velocity.
    attitude: f64,
}

impl Evaluated {
    fn shortfall(&self) -> f64 {
        self.flight + self.attitude
    }

    /// Selects the design that violates the requirements less, this one or `other`; for equal violations the one with
    /// the smaller shortfall. `violation` contains the violations of this design and of the other.
    fn or(self, other: Self, violation: [f64; 2]) -> Self {
        let [own, of_other] = violation;
        let is_better = (of_other, other.shortfall()) < (own, self.shortfall());
        if is_better { other } else { self }
    }
}

/// Ratio of the weight of a slow heading integral to that of the heading, 1/s²; the integration time is then seventeen
/// seconds.
const SLOW: f64 = 1.0 / 300.0;

/// A search variable with its limits.
type BoundedWeight<'a> = (&'a mut f64, [f64; 2]);

/// A loop that is searched separately.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Loop {
    RollPitch,
    Yaw,
    Heave,
    Attitude,
}

/// Order in which the loops are searched.
const ORDER: [Loop; 6] =
    [Loop::RollPitch, Loop::Yaw, Loop::RollPitch, Loop::Attitude, Loop::Yaw, Loop::Heave];

/// Weights of one loop.
fn weights(design: &mut HoverDesign, of: Loop) -> Vec<BoundedWeight<'_>> {
    /// Limits of a weight.
    const WEIGHT: [f64; 2] = [1e-5, 1e6];
    /// Limits of the decay rate, 1/s.
    const DECAY: [f64; 2] = [1e-3, 0.6];
    let HoverDesign { roll_pitch, attitude, yaw, heave, .. } = design;
    let mut weights: Vec<BoundedWeight<'_>> = Vec::new();
    match of {
        Loop::RollPitch => {
            weights.extend(roll_pitch.states.iter_mut().map(|weight| (weight, WEIGHT)));
            weights.extend(roll_pitch.integrals.iter_mut().map(|weight| (weight, WEIGHT)));
            weights.extend(roll_pitch.sticks.iter_mut().map(|weight| (weight, WEIGHT)));
            weights.push((&mut roll_pitch.decay_per_s, DECAY));
        }
        Loop::Yaw => {
            weights.extend(yaw.states.iter_mut().map(|weight| (weight, WEIGHT)));
            weights.push((&mut yaw.integral, WEIGHT));
            weights.push((&mut yaw.stick, WEIGHT));
            weights.push((&mut yaw.decay_per_s, [1e-3, 2.0]));
        }
        Loop::Heave => {
            weights.push((&mut heave.frequency_radps, [0.5, 6.0]));
            weights.push((&mut heave.damping, [0.5, 3.0]));
        }
        Loop::Attitude => {
            weights.extend(attitude.states.iter_mut().map(|weight| (weight, WEIGHT)));
            weights.extend(attitude.integrals.iter_mut().map(|weight| (weight, WEIGHT)));
            weights.extend(attitude.sticks.iter_mut().map(|weight| (weight, WEIGHT)));
        }
    }
    weights
}

/// Shortfall of `design` from `wanted` in the modes with known velocity. The first of `models` is that of hover. The
/// evaluation stops early once the shortfall is at least `least`.
fn in_flight(
    design: &HoverDesign,
    models: &[FlownModel],
    perturbed: &Perturbed,
    wanted: &Wanted,
    least: f64,
) -> Result<f64, DesignError> {
    let Some(FlownModel { model, .. }) = models.first() else { return Ok(f64::INFINITY) };
    let gains = design.synthesise(model)?;
    if !is_stable(design, model, &gains, FlightMode::Velocity)? {
        return Ok(f64::INFINITY);
    }
    let mut short = 0.0;
    for disturbance in TABLE_6_1 {
        let (state, _) = disturbance;
        let response = design.respond(model, &gains, disturbance, 2.5 * wanted.settled_s[0])?;
        let allowed_s = match state {
            "psi" | "r" => wanted.settled_s[1],
            "w" => wanted.settled_s[2],
            _ => wanted.settled_s[0],
        };
        debug_assert!(DISTURBED.contains(&state));
        let settled_s = response.recovered_s(0.02).unwrap_or(5.0 * wanted.settled_s[0]);
        short += 4.0 * (settled_s / allowed_s - 1.0).clamp(0.0, 5.0);
        // Commands beyond full travel count as a shortfall, because such a design ignores the limits.
        let asked = response.stick_peaks().into_iter().fold(0.0, f64::max);
        short += 0.05 * (asked - 1.0).clamp(0.0, 5.0);
        if let Some(back_s) = back_with_stops_s(design, model, &gains, &response)? {
            short += 4.0 * (back_s / wanted.settled_s[0] - 1.0).clamp(0.0, 5.0);
        }
        if short >= least {
            return Ok(short);
        }
    }
    for mode in [FlightMode::Velocity, FlightMode::Position] {
        for own in models {
            short += margins_short(&own.flown_by(design), &own.model, &gains, mode, wanted)?;
            if short >= least {
                return Ok(short);
            }
        }
    }
    let sticks = normalised(model)?.inputs().to_vec();
    let controller = closed_loop::controller(design, &sticks, &gains, FlightMode::Velocity)?;
    let lost = perturbed.worst(1.0, |plant| {
        let closed = ClosedLoop::at_plant_input(plant, &controller)?;
        Ok(if dies_out(&closed) { 0.0 } else { 1.0 })
    })?;
    Ok(short + 6.0 * lost)
}

/// Shortfall of `design` without known velocity.
fn in_attitude(
    design: &HoverDesign,
    models: &[FlownModel],
    wanted: &Wanted,
) -> Result<f64, DesignError> {
    let Some(hover) = models.first() else { return Ok(f64::INFINITY) };
    let gains = design.synthesise(&hover.model)?;
    let short = |own: &FlownModel| {
        margins_short(&own.flown_by(design), &own.model, &gains, FlightMode::Attitude, wanted)
    };
    models.iter().map(short).sum()
}

fn margins_short(
    design: &HoverDesign,
    model: &StateSpace,
    gains: &Gains,
    mode: FlightMode,
    wanted: &Wanted,
) -> Result<f64, DesignError> {
    /// Minimum margins with the highest weight: slightly more than 6 dB and 45°.
    const MIN: (f64, f64) = (6.3, 46.0);
    if !is_stable(design, model, gains, mode)? {
        return Ok(10.0);
    }
    let (gain_db, phase_deg) =
        design.close_in(model, gains, mode, Cut::Actuators)?.weakest(FREQUENCIES);
    let below = |found: f64, wanted: f64| (1.0 - found / wanted).max(0.0);
    Ok(25.0 * (below(gain_db, MIN.0) + below(phase_deg, MIN.1))
        + below(gain_db, wanted.gain_db)
        + below(phase_deg, wanted.phase_deg))
}

fn is_stable(
    design: &HoverDesign,
    model: &StateSpace,
    gains: &Gains,
    mode: FlightMode,
) -> Result<bool, DesignError> {
    Ok(dies_out(&design.close_in(model, gains, mode, Cut::Actuators)?))
}

/// Whether every disturbance has decayed after 2¹⁴ samples.
fn dies_out(closed: &ClosedLoop) -> bool {
    let open = closed.open();
    let mut step = open.a() - open.b() * open.c();
    for _ in 0..14 {
        step = &step * &step;
        let size = step.amax();
        if !(1e-3..1e12).contains(&size) {
            return size < 1e-3;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_designs_the_one_that_lacks_less_is_taken_then_the_smaller_shortfall() {
        let evaluated = |flight: f64, servo_s: f64| Evaluated {
            design: HoverDesign { servo_s, ..HoverDesign::default() },
            flight,
            attitude: 0.5,
        };
        let taken = |violation: [f64; 2], shortfalls: [f64; 2]| {
            let [first, second] = [evaluated(shortfalls[0], 0.01), evaluated(shortfalls[1], 0.02)];
            first.or(second, violation).design.servo_s
        };
        // The second violates as much and has the larger shortfall.
        assert_eq!(taken([0.3, 0.3], [1.0, 2.0]), 0.01);
        assert_eq!(taken([0.3, 0.3], [2.0, 1.0]), 0.02);
        assert_eq!(taken([0.3, 0.1], [1.0, 2.0]), 0.02);
        assert_eq!(taken([0.1, 0.3], [2.0, 1.0]), 0.01);
        assert_eq!(taken([0.1, f64::INFINITY], [2.0, 1.0]), 0.01);
    }
}
