//! A linear model in place of the nonlinear helicopter.

use hovernav::autopilot::HoverConfig;
use hovernav::controls::Sticks;
use hovernav_design::hover::HoverDesign;
use hovernav_model::{Parameter, StateSpace, shipped};
use hovernav_sim::{Crash, Disturbance, Feedback, Flight, FlightConfig, FlightEvent, WindConfig};

/// A hover of 60 s of `model` with an autopilot designed for it.
fn config(model: &StateSpace) -> FlightConfig {
    let design = HoverDesign::for_model(model);
    let autopilot = HoverConfig::new(design.period_s, design.synthesise(model).unwrap());
    FlightConfig { model: Some(model.clone()), duration_s: 60.0, ..FlightConfig::new(autopilot) }
}

fn late(model: StateSpace, name: &str, value: f64) -> StateSpace {
    let own = Parameter { name: name.into(), value, unit: "s".into() };
    model.with_parameters(vec![own], None).unwrap()
}

#[test]
fn a_helicopter_four_times_as_large_hovers_in_gusts_with_the_estimator() {
    let flight = config(&shipped::mettler_r50()).fly().unwrap();
    assert_eq!(flight.crash, None);
    let [u, v, w] = flight.statistics(25.0).velocity_rms_mps;
    assert!(u.max(v) < 0.6 && w < 0.5, "{u} {v} {w}");
}

/// Rates after a small step of a stick without autopilot, within the first half second, rad/s.
fn step(config: &FlightConfig, stick: usize) -> Vec<[f64; 3]> {
    let mut sticks = [0.0; 4];
    sticks[stick] = 0.05;
    let config = FlightConfig {
        feedback: Feedback::Truth,
        wind: WindConfig::calm(),
        engage_s: 0.0,
        duration_s: 0.5,
        events: vec![
            (0.0, FlightEvent::Engage(false)),
            (0.0, FlightEvent::PilotSticks(Sticks::from_array(sticks))),
        ],
        ..config.clone()
    };
    let flight: Flight = config.fly().unwrap();
    flight.samples.iter().map(|sample| sample.truth.angular_rate_radps.to_array()).collect()
}

#[test]
fn the_linearised_helicopter_answers_a_small_step_as_the_nonlinear_one_does() {
    let linear = config(&shipped::raptor60());
    let nonlinear = FlightConfig { model: None, ..linear.clone() };
    for (stick, axis) in [(0, 0), (1, 1), (3, 2)] {
        let (one, other) = (step(&linear, stick), step(&nonlinear, stick));
        let largest = other.iter().map(|rate| rate[axis].abs()).fold(0.0, f64::max);
        let off = one.iter().zip(&other).map(|(one, other)| (one[axis] - other[axis]).abs());
        let off = off.fold(0.0, f64::max);
        assert!(largest > 0.02 && off < 0.1 * largest, "{stick}: {off} of {largest}");
    }
}

#[test]
fn a_delay_of_the_model_delays_its_own_stick_alone() {
    let prompt = config(&shipped::raptor60());
    let slow = FlightConfig {
        model: Some(late(shipped::raptor60(), "tau_ped", 0.03 + 5.0 / 33.0)),
        ..prompt.clone()
    };
    let begin = |config: &FlightConfig, stick, axis: usize| {
        let rates = step(config, stick);
        rates.iter().position(|rate| rate[axis].abs() > 1e-3).unwrap()
    };
    assert_eq!(begin(&slow, 3, 2), begin(&prompt, 3, 2) + 5);
    assert_eq!(begin(&slow, 0, 0), begin(&prompt, 0, 0));
}

#[test]
fn what_a_linear_model_does_not_describe_ends_the_flight_or_is_refused() {
    let calm = config(&shipped::raptor60());
    let with = |event| FlightConfig { events: vec![(20.0, event)], ..calm.clone() };
    for (event, expected) in [
        (FlightEvent::PowerLoss, "at 20 s: found a loss of power, expected"),
        (FlightEvent::Mass(7.0), "at 20 s: found a change of mass, expected"),
    ] {
        let error = with(event).fly().unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let dive = Disturbance::of_state("u", 30.0).unwrap();
    let fast = with(FlightEvent::Disturb(dive)).fly().unwrap();
    assert!(matches!(fast.crash, Some(Crash::TooFast { .. })), "{:?}", fast.crash);
    assert!(fast.crashed_s.is_some_and(|at_s| (20.0..20.2).contains(&at_s)));
    let drop = Disturbance::of_state("w", 18.0).unwrap();
    let low = FlightConfig {
        start: hovernav::earth::Geodetic { height_m: 3.0, ..calm.start },
        ..with(FlightEvent::Disturb(drop))
    };
    let struck = low.fly().unwrap();
    assert!(matches!(struck.crash, Some(Crash::Ground { .. })), "{:?}", struck.crash);
}
