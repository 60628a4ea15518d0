//! Responses to disturbances with stick stops and rate limits.

use nalgebra::DVector;

use super::closed_loop::{self, FlightMode};
use super::config::HoverDesign;
use super::plant::{normalised, places};
use crate::disturbance::followed;
use crate::{DISTURBED, DesignError, DisturbanceResponse};
use hovernav::autopilot::{ConfigError, Gains, Pid, Regulator, StickLimits};
use hovernav::controls::Sticks;
use hovernav_model::StateSpace;

/// Response to `disturbance` in the mode that holds velocity, with all other states at trim. The linear plant is
/// controlled by the regulators of the autopilot, which receive the limited commands.
///
/// # Source
/// Equations (C1) to (C4) and (C9) of docs/equations.md, in the order of the autopilot.
pub(super) fn respond(
    design: &HoverDesign,
    whole: &StateSpace,
    gains: &Gains,
    disturbance: (&str, f64),
    duration_s: f64,
    limits: &StickLimits,
) -> Result<DisturbanceResponse, DesignError> {
    let plant = closed_loop::plant(design, whole, FlightMode::Velocity)?;
    let at = places(whole, DISTURBED)?;
    let (row, mut response) = followed(disturbance, duration_s, design.period_s)?;
    let rejected = |error: ConfigError| DesignError::Range {
        name: error.what,
        value: error.found,
        expected: error.expected,
    };
    let mut roll_pitch = Regulator::new(gains.roll_pitch, design.period_s).map_err(rejected)?;
    let mut yaw = Regulator::new(gains.yaw, design.period_s).map_err(rejected)?;
    let mut heave = Pid::new(gains.heave, design.period_s).map_err(rejected)?;
    heave.start(0.0, 0.0, 0.0);

    let mut x = DVector::zeros(plant.states().len());
    x[at[row]] = response.size;
    let mut sticks = Sticks::NEUTRAL;
    for _ in 0..response.time_s.len() {
        response.states.push(at.map(|index| x[index]));
        let measured = plant.c() * &x;
        let [p, q, phi, theta, u, v, w, r, psi] = std::array::from_fn(|index| measured[index]);
        let [lateral, longitudinal] = roll_pitch.command(&[p, q, phi, theta, u, v], &[0.0; 6]);
        let collective = heave.command(0.0, w);
        let [own_pedal] = yaw.command(&[r, psi], &[0.0; 2]);
        let pedal = own_pedal + gains.pedal_per_collective * collective;
        let wanted = Sticks { lateral, longitudinal, collective, pedal };
        sticks = limits.reachable(wanted, sticks, design.period_s);
        roll_pitch.advance(&[sticks.lateral, sticks.longitudinal]);
        heave.advance(sticks.collective);
        yaw.advance(&[sticks.pedal - gains.pedal_per_collective * sticks.collective]);
        response.sticks.push(sticks.to_array());
        x = plant.a() * x + plant.b() * DVector::from_row_slice(&sticks.to_array());
    }
    Ok(response)
}

/// Time, s, after which the disturbed state stays within 5 % of its disturbance, with stick stops. `linear` is the
/// response to the same disturbance without stops. Infinite if the state has not settled by the end of `linear`; `None`
/// if no stick command exceeds its travel.
pub(super) fn back_with_stops_s(
    design: &HoverDesign,
    model: &StateSpace,
    gains: &Gains,
    linear: &DisturbanceResponse,
) -> Result<Option<f64>, DesignError> {
    // A NaN counts as a command beyond the travel.
    if linear.stick_peaks().into_iter().all(|peak| peak <= 1.0) {
        return Ok(None);
    }
    let disturbance = (linear.state.as_str(), linear.size);
    let duration_s = linear.time_s.last().copied().unwrap_or(0.0);
    let whole = normalised(model)?;
    let limits = StickLimits::default();
    let within = respond(design, &whole, gains, disturbance, duration_s, &limits)?;
    Ok(Some(within.recovered_s(0.05).unwrap_or(f64::INFINITY)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TABLE_6_1;
    use hovernav_model::shipped;

    fn limits(travel: f64, rate_per_s: f64) -> StickLimits {
        StickLimits {
            lowest: Sticks::from_array([-travel; 4]),
            highest: Sticks::from_array([travel; 4]),
            rate_per_s: Sticks::from_array([rate_per_s; 4]),
        }
    }

    #[test]
    fn with_stops_out_of_reach_the_response_is_the_linear_one() {
        for model in [shipped::raptor60(), shipped::thesis()] {
            let design = HoverDesign::for_model(&model);
            let gains = design.synthesise(&model).unwrap();
            for disturbance in TABLE_6_1 {
                let linear = design.respond(&model, &gains, disturbance, 6.0).unwrap();
                let wide = limits(1e6, 1e9);
                let found = design.respond_within(&model, &gains, disturbance, 6.0, &wide).unwrap();
                let pairs = linear.states.iter().zip(&found.states);
                for (one, other) in pairs.flat_map(|(one, other)| one.iter().zip(other)) {
                    assert!((one - other).abs() < 1e-9, "{disturbance:?}: {one} {other}");
                }
            }
        }
    }

    #[test]
    fn at_the_stop_heave_moves_as_its_closed_form() {
        // The limited collective is at its stop during the whole descent, because the descent is fast. With the servo's
        // lag τ, a sample of delay and a high rate limit, ẇ = Zw w + Zcol δ has a closed-form solution. The model is
        // heave alone: nothing else moves w.
        let coupled = shipped::raptor60();
        let w = coupled.state("w").unwrap();
        let collective = coupled.input("collective").unwrap();
        let (mut a, mut b) = (coupled.a().clone(), coupled.b().clone());
        let (zw, zcol) = (a[(w, w)], b[(w, collective)]);
        a.row_mut(w).fill(0.0);
        b.row_mut(w).fill(0.0);
        (a[(w, w)], b[(w, collective)]) = (zw, zcol);
        let (states, inputs) = (coupled.states().to_vec(), coupled.inputs().to_vec());
        let model = StateSpace::new("heave", coupled.time(), states, inputs, a, b).unwrap();
        let design = HoverDesign::default();
        let gains = design.synthesise(&model).unwrap();
        let (travel, tau) = (0.01, design.servo_s);
        let found =
            design.respond_within(&model, &gains, ("w", 2.0), 1.0, &limits(travel, 1e9)).unwrap();
        let held = found.sticks[0][2];
        assert!(held.abs() == travel && found.sticks.iter().all(|sticks| sticks[2] == held));
        for (time_s, states) in found.time_s.iter().zip(&found.states) {
            let t = time_s - design.period_s;
            let mut expected = 2.0 * (zw * time_s).exp();
            if t > 0.0 {
                let (slow, fast) = ((zw * t).exp(), (-t / tau).exp());
                expected += zcol * held * ((slow - 1.0) / zw - (slow - fast) / (zw + 1.0 / tau));
            }
            assert!((states[8] - expected).abs() < 1e-9, "{time_s}: {} {expected}", states[8]);
        }
    }

    #[test]
    fn sticks_keep_to_their_stops_and_rate_and_the_pedal_comes_back_later_for_it() {
        let (model, design) = (shipped::raptor60(), HoverDesign::default());
        let gains = design.synthesise(&model).unwrap();
        let disturbance = ("r", 1.0);
        let within = |travel: f64, rate_per_s: f64| {
            let limits = limits(travel, rate_per_s);
            design.respond_within(&model, &gains, disturbance, 20.0, &limits).unwrap()
        };
        let found = within(0.05, 0.5);
        assert!(found.sticks.iter().flatten().all(|stick| stick.abs() <= 0.05));
        for pair in found.sticks.windows(2) {
            let moved = pair[0].iter().zip(pair[1]).map(|(one, other)| (one - other).abs());
            assert!(moved.fold(0.0, f64::max) <= 0.5 * design.period_s + 1e-12);
        }
        let free = design.respond(&model, &gains, disturbance, 20.0).unwrap();
        let [free_s, found_s] = [&free, &found].map(|own| own.recovered_s(0.02).unwrap());
        assert!(found_s > free_s + 0.1, "{found_s} {free_s}");
    }

    /// A heading integral of 17 s whose tracking time is half a second leaves an error of 2° for half a minute. The
    /// nonlinear helicopter shows the same.
    #[test]
    fn a_slow_integral_is_not_moved_by_what_the_pedal_could_not_do_for_a_moment() {
        let model = shipped::raptor60();
        let mut design = HoverDesign::default();
        design.yaw.integral = design.yaw.states[1] / 300.0;
        let gains = design.synthesise(&model).unwrap();
        let limits = StickLimits::default();
        let found = design.respond_within(&model, &gains, ("psi", 0.3), 20.0, &limits).unwrap();
        assert!(found.recovered_s(0.05).unwrap() < 1.5, "{:?}", found.recovered_s(0.05));
    }

    #[test]
    fn stops_are_reported_where_a_stick_reaches_one_and_only_there() {
        let (model, design) = (shipped::raptor60(), HoverDesign::default());
        let gains = design.synthesise(&model).unwrap();
        let back_s = |size: f64| {
            let linear = design.respond(&model, &gains, ("r", size), 20.0).unwrap();
            let free_s = linear.recovered_s(0.05).unwrap();
            (free_s, back_with_stops_s(&design, &model, &gains, &linear).unwrap())
        };
        assert_eq!(back_s(0.01).1, None);
        let (free_s, Some(stopped_s)) = back_s(30.0) else { panic!("a stop is reached") };
        assert!(stopped_s > free_s, "{stopped_s} {free_s}");
    }

    #[test]
    fn limits_and_times_that_are_none_are_refused() {
        let (model, design) = (shipped::raptor60(), HoverDesign::default());
        let gains = design.synthesise(&model).unwrap();
        let wide = StickLimits::default();
        assert!(design.respond_within(&model, &gains, ("a", 1.0), 1.0, &wide).is_err());
        assert!(design.respond_within(&model, &gains, ("p", 1.0), f64::NAN, &wide).is_err());
    }
}
