//! From a simulated flight to a model, from the model to an autopilot, from the autopilot to a flight.
//!
//! The truth is the simulator's linearisation in the wind of the flight. Seeds 1, 4, 6, 7, 101 to 105, 200 to 219,
//! 300 to 329, 400 to 429, 500 to 529, 828 to 869, 1000 to 1015 and 1100 to 1139 were used in the development of the
//! method. Seeds 106 to 130, 600 to 629, 700 to 789, 800 to 827, 870 to 899, 1016 to 1090, 1140 to 1190, 1200 to
//! 1379, 1400 to 1407, 1410 to 1441, 1500 to 1503 and 2000 to 2031 were each evaluated once.

use std::f64::consts::TAU;

use approx::assert_abs_diff_eq;
use hovernav::autopilot::HoverConfig;
use hovernav::controls::Sticks;
use hovernav::ekf::Solution;
use hovernav::frames::{Ned, Vector};
use hovernav_dataset::Dataset;
use hovernav_design::Loop;
use hovernav_design::hover::{HoverDesign, Wanted};
use hovernav_model::helicopter::{Helicopter, HelicopterParameters, RotorDrive};
use hovernav_model::{Grade, Signal, StateSpace, TimeDomain, Verdict, shipped};
use hovernav_replay::smooth;
use hovernav_sim::{EngineConfig, Feedback, FlightConfig, FlightEvent, WindConfig};
use hovernav_sysid::helicopter::Identification;
use hovernav_sysid::methods::prediction_error::Identified;

use crate::data;

/// Stick and the output that responds to it.
const PAIRS: [(&str, &str); 4] =
    [("lateral", "p"), ("longitudinal", "q"), ("collective", "w"), ("pedal", "r")];

/// Wind in rotation: calm, 3 m/s with gusts of 1.0 m/s, 3 m/s with 1.5 m/s, 5 m/s with 1.25 m/s.
fn wind_of(seed: u64) -> WindConfig {
    match seed % 4 {
        0 => WindConfig::calm(),
        1 => WindConfig::from_direction(3.0, 135f64.to_radians(), 1.0),
        2 => WindConfig::from_direction(3.0, 45f64.to_radians(), 1.5),
        _ => WindConfig::from_direction(5.0, 80f64.to_radians(), 1.25),
    }
}

fn config(seed: u64, autopilot: HoverConfig) -> FlightConfig {
    FlightConfig { seed, wind: wind_of(seed), ..FlightConfig::new(autopilot) }
}

/// Test points flown by `hovernav simulate --test-points`, and their identification by `hovernav identify`.
fn identified(seed: u64) -> (Identification, StateSpace) {
    identified_airframe(HelicopterParameters::raptor60(), &shipped::raptor60(), seed)
}

/// The same test points and identification for another `helicopter`, held by an autopilot designed for its own `model`.
fn identified_airframe(
    helicopter: HelicopterParameters,
    model: &StateSpace,
    seed: u64,
) -> (Identification, StateSpace) {
    let (dataset, solutions) = flown(helicopter, model, seed);
    let (found, verdict) = data::judged(&dataset, &solutions);
    let vehicle = found.vehicle().unwrap().with_verdict(verdict);
    (found, vehicle)
}

/// The flight with its test points, and its smoothed estimate.
pub fn flown(
    helicopter: HelicopterParameters,
    model: &StateSpace,
    seed: u64,
) -> (Dataset, Vec<Solution>) {
    let design = HoverDesign::for_model(model);
    let autopilot = HoverConfig::new(design.period_s, design.synthesise(model).unwrap());
    let mut config = config(seed, autopilot);
    config.helicopter = helicopter;
    config.feedback = Feedback::Truth;
    config.events = FlightEvent::test_points(30.0, 0.12);
    config.duration_s = config.events.last().unwrap().0 + 30.0;
    smoothed(&config)
}

/// A flight without a crash, and its smoothed estimate.
pub fn smoothed(config: &FlightConfig) -> (Dataset, Vec<Solution>) {
    let flight = config.fly().unwrap();
    assert_eq!(flight.crashed_s, None);
    let (mut dataset, _) = flight.dataset();
    let settings = dataset.settings().unwrap();
    let solutions = smooth(&dataset, &settings, |_| ()).solutions;
    (dataset, solutions)
}

/// The vehicle's own linearisation in the wind of `seed`.
fn truth(seed: u64) -> StateSpace {
    truth_in(wind_of(seed).steady_mps)
}

/// The vehicle's own linearisation in the steady `wind`, m/s, with the rotor's speed under its governor as a state.
pub fn truth_in(wind: Vector<Ned>) -> StateSpace {
    let helicopter = Helicopter::new(HelicopterParameters::raptor60()).unwrap();
    let trim = helicopter.trim(Vector::ZERO, wind, 60f64.to_radians()).unwrap();
    let constant = helicopter.linearise(&trim, wind);
    let EngineConfig { governor_time_s, droop, .. } = EngineConfig::default();
    let at = |speed| {
        let drive = RotorDrive { speed, powered: true };
        let change = helicopter.driven(&trim.state, &trim.controls, wind, drive);
        let [u, v, w] = change.velocity_mps2.to_array();
        let [p, q, r] = change.rate_radps2.to_array();
        [("u", u), ("v", v), ("w", w), ("p", p), ("q", q), ("r", r)]
    };
    let n = constant.states().len();
    let mut a = constant.a().clone().resize(n + 1, n + 1, 0.0);
    let mut b = constant.b().clone().resize_vertically(n + 1, 0.0);
    let step = 1e-4;
    for ((state, above), (_, below)) in at(1.0 + step).into_iter().zip(at(1.0 - step)) {
        a[(constant.state(state).unwrap(), n)] = (above - below) / (2.0 * step);
    }
    a[(n, n)] = -1.0 / governor_time_s;
    b[(n, constant.input("collective").unwrap())] = -droop / governor_time_s;
    let states = [constant.states(), &[Signal::new("n", "")]].concat();
    let inputs = constant.inputs().to_vec();
    StateSpace::new("helicopter", TimeDomain::Continuous, states, inputs, a, b).unwrap()
}

/// Corner frequency of the servos except that of the tail, Hz.
const SERVO_HZ: f64 = 8.0;
/// Corner frequency of the tail servo, Hz.
const TAIL_SERVO_HZ: f64 = 12.0;
/// Delay of the commands to the servos, s: one sample.
pub const WAIT_S: f64 = 1.0 / 33.0;

fn servo_hz(stick: &str) -> f64 {
    if stick == "pedal" { TAIL_SERVO_HZ } else { SERVO_HZ }
}

/// Error of the sum of delay and lag of `stick`, and its bound, s. Delay and lag cannot be separated.
pub fn lateness(found: &Identified, stick: &str) -> (f64, f64) {
    let (delay, lag) = (found.delay(stick).unwrap(), found.lag(stick).unwrap());
    let estimates = &found.estimates;
    let both: Vec<usize> = (0..estimates.free.len())
        .filter(|&place| [delay, lag].contains(&&estimates.list[estimates.free[place]]))
        .collect();
    let variance = estimates.covariance.select_rows(&both).select_columns(&both).sum();
    (delay.value + lag.value - WAIT_S - 1.0 / (TAU * servo_hz(stick)), variance.sqrt())
}

/// The cost J of the model's response from 0.5 to 12 rad/s, compared with the true response, which includes servo and
/// one sample of delay.
fn cost(
    found: &Identification,
    vehicle: &StateSpace,
    truth: &StateSpace,
    pair: (&str, &str),
) -> f64 {
    const POINTS: i32 = 30;
    let (stick, output) = pair;
    let at = |model: &StateSpace, radps: f64| {
        let response = model.linear().frequency_response(radps).unwrap();
        response[(model.state(output).unwrap(), model.input(stick).unwrap())]
    };
    let delay_s = found.identified.delay(stick).map_or(0.0, |delay| delay.value);
    let lag_s = found.identified.lag(stick).map_or(0.0, |lag| lag.value);
    let servo_hz = servo_hz(stick);
    let apart = (0..POINTS).map(|point| {
        let radps = 0.5 * 24f64.powf(f64::from(point) / f64::from(POINTS - 1));
        let turn = nalgebra::Complex::new(0.0, radps);
        let servo = (turn / (TAU * servo_hz) + 1.0).inv() * (-turn * WAIT_S).exp();
        let ratio = at(vehicle, radps) * (-turn * delay_s).exp()
            / (turn * lag_s + 1.0)
            / (at(truth, radps) * servo);
        let (size_db, phase_deg) = (20.0 * ratio.norm().log10(), ratio.arg().to_degrees());
        size_db * size_db + 0.01745 * phase_deg * phase_deg
    });
    20.0 / f64::from(POINTS) * apart.sum::<f64>()
}

/// States of the vehicle at constant rotor speed.
const CONSTANT: [&str; 13] =
    ["u", "v", "w", "p", "q", "r", "phi", "theta", "psi", "a", "b", "c", "d"];

/// Result of one seed.
struct Outcome {
    costs: [f64; 4],
    verdict: Verdict,
    /// Weakest phase and gain margin of the designed autopilot, ° and dB, for the model and for the true vehicle if
    /// it is stable.
    margins: Option<[Option<(f64, f64)>; 2]>,
    crashed: bool,
}

/// Weakest phase and gain margin, ° and dB; `None` for an unstable loop.
fn weakest(cut: &Loop) -> Option<(f64, f64)> {
    let margins = cut.margins().ok()?;
    let channels = || margins.channels.iter();
    Some((
        channels().map(|channel| channel.phase_deg()).fold(f64::INFINITY, f64::min),
        channels().map(|channel| channel.smallest_gain_db()).fold(f64::INFINITY, f64::min),
    ))
}

fn outcome(seed: u64) -> Outcome {
    let (found, vehicle) = identified(seed);
    let truth = truth(seed);
    let costs = PAIRS.map(|pair| cost(&found, &vehicle, &truth, pair));
    let verdict = vehicle.verdict().unwrap().clone();
    let grade = verdict.grade;
    let mut outcome = Outcome { costs, verdict, margins: None, crashed: false };
    if grade != Grade::DoNotFly {
        let start = HoverDesign::for_model(&vehicle);
        let wanted = Wanted { trials: 150, ..Wanted::default() };
        let design = start.searched(&vehicle, &[], &wanted).unwrap().design;
        let gains = design.synthesise(&vehicle).unwrap();
        let own = HoverDesign::for_model(&shipped::raptor60());
        let constant = truth.subsystem(&CONSTANT, &Sticks::NAMES).unwrap();
        outcome.margins = Some([
            weakest(&design.close(&vehicle, &gains).unwrap()),
            weakest(&own.close(&constant, &gains).unwrap()),
        ]);
        let config = FlightConfig {
            duration_s: 60.0,
            ..config(seed + 1000, HoverConfig::new(design.period_s, gains))
        };
        outcome.crashed = config.fly().unwrap().crashed_s.is_some();
    }
    println!(
        "seed {seed}: J {:.0?}, {grade}, {:?}, margins promised and on the true vehicle {:?}, crashed {}",
        outcome.costs, outcome.verdict.reasons, outcome.margins, outcome.crashed
    );
    outcome
}

/// Requirements on the chain of tools: a good model or one reported as bad, and no crash.
fn assert_sound(outcome: &Outcome) {
    assert!(!outcome.crashed);
    for ((stick, output), cost) in PAIRS.into_iter().zip(outcome.costs) {
        let Verdict { grade, reasons } = &outcome.verdict;
        let named = format!("{stick} to {output}");
        let is_named = *grade != Grade::Good && reasons.iter().any(|own| own.contains(&named));
        assert!(cost <= 100.0 || is_named, "{named}: J {cost}, {grade}, {reasons:?}");
    }
}

/// Margins on the vehicle are at most 2 dB and 8° below those of the model.
fn assert_margins_hold(outcome: &Outcome) {
    let [promised, had] = outcome.margins.expect("a model that may be flown by");
    let (Some(promised), Some(had)) = (promised, had) else { panic!("not stable") };
    assert!(had.0 > promised.0 - 8.0 && had.1 > promised.1 - 2.0, "{promised:?} {had:?}");
}

/// The daily sample: one flight of five, in 3 m/s with gusts of 1 m/s. `.ci/more` flies the other four.
#[test]
fn a_flight_in_gusts_leads_to_a_model_an_autopilot_and_a_flight_with_the_margins_promised() {
    let outcome = outcome(1501);
    assert_sound(&outcome);
    assert_margins_hold(&outcome);
}

// One test per flight, so that they run in parallel.
#[test]
#[ignore = "ten seconds: a flight, its identification and design"]
fn another_flight_in_gusts_leads_to_a_model_an_autopilot_and_a_flight() {
    assert_sound(&outcome(1));
}

#[test]
#[ignore = "ten seconds: a flight, its identification and design"]
fn margins_on_the_vehicle_are_those_promised_of_a_flight_in_calm() {
    assert_margins_hold(&outcome(1500));
}

#[test]
#[ignore = "ten seconds: a flight, its identification and design"]
fn margins_on_the_vehicle_are_those_promised_in_gusts_of_1_5_mps() {
    assert_margins_hold(&outcome(1502));
}

#[test]
#[ignore = "ten seconds: a flight, its identification and design"]
fn margins_on_the_vehicle_are_those_promised_in_wind_of_5_mps() {
    assert_margins_hold(&outcome(1503));
}

/// A model without the bar would give this flight a rotor that is too slow, with its spring wrong by 7 bounds. Pitch
/// would then have a cost of 104.
#[test]
#[ignore = "ten seconds: a flight and its identification"]
fn a_stabiliser_bar_shows_through_wind_and_gusts() {
    let (found, vehicle) = identified(407);
    let truth = truth(407);
    let pitch = cost(&found, &vehicle, &truth, ("longitudinal", "q"));
    let spring = found.identified.estimates.get("Lb").unwrap();
    let true_spring = truth.a()[(truth.state("p").unwrap(), truth.state("b").unwrap())];
    println!("pitch {pitch:.0}, Lb {} ± {}, {true_spring}", spring.value, spring.bound);
    assert!(vehicle.state("c").is_ok() && pitch < 60.0, "{pitch}");
    assert_abs_diff_eq!(spring.value, true_spring, epsilon = 3.0 * spring.bound);
}

/// On only a part of this flight, the search without a bar ends with a delay error of one sample. A model with a bar is
/// then far more likely.
#[test]
fn a_helicopter_without_a_stabiliser_bar_is_not_given_one() {
    let mut bare = HelicopterParameters::raptor60();
    (bare.bar.lateral_gain, bare.bar.longitudinal_gain) = (0.0, 0.0);
    // Heavier blades with a larger pitch range replace the effect of the bar on stick and damping.
    (bare.lateral_cyclic_rad, bare.longitudinal_cyclic_rad) = (0.2, 0.25);
    bare.blade_inertia_kgm2 *= 3.0;
    let helicopter = Helicopter::new(bare).unwrap();
    let trim = helicopter.trim(Vector::ZERO, Vector::ZERO, 60f64.to_radians()).unwrap();
    let truth = helicopter.linearise(&trim, Vector::ZERO);
    let (found, vehicle) = identified_airframe(bare, &truth, 1028);
    assert!(vehicle.state("c").is_err());
    let a = |row, column| truth.a()[(truth.state(row).unwrap(), truth.state(column).unwrap())];
    let expected = [("Lb", a("p", "b")), ("Ma", a("q", "a")), ("tau_f", -1.0 / a("b", "b"))];
    for (name, expected) in expected {
        let found = found.identified.estimates.get(name).unwrap();
        println!("{name} {} ± {}, {expected}", found.value, found.bound);
        assert!((found.value - expected).abs() < 3.0 * found.bound, "{name}");
    }
}

/// If the error of the vertical velocity were unlimited, the collective of this flight would be too weak by 4.2 of its
/// bounds. Heave would then have a cost of 196.
#[test]
#[ignore = "ten seconds: a flight and its identification"]
fn gusts_are_not_taken_for_errors_of_the_vertical_velocity() {
    let (found, vehicle) = identified(505);
    let truth = truth(505);
    let (stick, output) = PAIRS[2];
    let heave = cost(&found, &vehicle, &truth, PAIRS[2]);
    let strength = found.identified.estimates.get("Zcol").unwrap();
    let true_strength = truth.b()[(truth.state(output).unwrap(), truth.input(stick).unwrap())];
    let reasons = &vehicle.verdict().unwrap().reasons;
    println!("heave {heave:.0}, Zcol {} ± {}, {true_strength}", strength.value, strength.bound);
    assert_abs_diff_eq!(strength.value, true_strength, epsilon = 2.0 * strength.bound);
    // The cost is 75: the flight's own gusts make Zcol 20 % too weak, which is one of its bounds.
    assert!(heave < 80.0, "{heave}");
    assert!(reasons.iter().any(|own| own.contains(&format!("{stick} to {output}"))), "{reasons:?}");
}

/// The likelihood alone identifies the collective of this flight as 35 ms late, an error of six bounds. The autopilot
/// responds to gusts before the measured velocity shows them.
#[test]
fn gusts_do_not_make_the_collective_late() {
    let (found, _) = identified(838);
    let (off_s, bound_s) = lateness(&found.identified, "collective");
    println!("collective {off_s:.4} ± {bound_s:.4} s late");
    assert!(off_s.abs() < 3.0 * bound_s && bound_s < 0.015);
}

/// `truth` in states in which it has the terms of the structures, and negligible others.
///
/// Speed tilts the disc within a few hundredths of a second. With tilts relative to that of the steady speed, this effect
/// belongs to Lv, Mu, Xu and Yv. Thrust of the tail rotor turns, rolls and moves the body. A roll rate and a velocity that
/// it leaves unchanged are those of a point near the centre of gravity: with the nose free to turn, its damping of v is
/// small.
fn in_terms_of_structures(truth: &StateSpace) -> StateSpace {
    let (mut a, mut b) = (truth.a().clone(), truth.b().clone());
    let place = |name: &str| truth.state(name).unwrap();
    let mut relative = |state: usize, to: usize, share: f64| {
        let (row, row_b) = (a.row(to) * share, b.row(to) * share);
        let mut own = a.row_mut(state);
        own -= row;
        let mut own = b.row_mut(state);
        own -= row_b;
        let column = a.column(state) * share;
        let mut own = a.column_mut(to);
        own += column;
    };
    let entry = |row: &str, column: &str| truth.a()[(place(row), place(column))];
    for tilt in ["a", "b"] {
        for speed in ["u", "v"] {
            relative(place(tilt), place(speed), -entry(tilt, speed) / entry(tilt, tilt));
        }
    }
    for moved in ["p", "v"] {
        relative(place(moved), place("r"), entry(moved, "r") / entry("r", "r"));
    }
    let (states, inputs) = (truth.states().to_vec(), truth.inputs().to_vec());
    StateSpace::new("helicopter", TimeDomain::Continuous, states, inputs, a, b).unwrap()
}

/// Error of each identified entry of A and B, divided by its one-sigma.
pub fn normalised_errors(vehicle: &StateSpace, truth: &StateSpace) -> Vec<(String, f64)> {
    let truth = &in_terms_of_structures(truth);
    let covariance = vehicle.covariance().unwrap();
    let place_of = |name: &str| vehicle.parameters().iter().position(|own| own.name == name);
    let mut entries: Vec<(&str, &str)> =
        vehicle.slopes().iter().map(|slope| (&*slope.row, &*slope.column)).collect();
    entries.sort_unstable();
    entries.dedup();
    let entry = |model: &StateSpace, (row, column): (&str, &str)| {
        let row = model.state(row).ok()?;
        let of_state = model.state(column).ok().map(|column| model.a()[(row, column)]);
        of_state.or_else(|| model.input(column).ok().map(|column| model.b()[(row, column)]))
    };
    let error = |at: (&str, &str)| {
        let mut slopes = nalgebra::DVector::zeros(vehicle.parameters().len());
        for own in vehicle.slopes().iter().filter(|own| (&*own.row, &*own.column) == at) {
            slopes[place_of(&own.parameter)?] = own.slope;
        }
        let sigma = (slopes.transpose() * covariance * &slopes)[0].sqrt();
        let off = entry(vehicle, at)? - entry(truth, at)?;
        (sigma > 0.0).then(|| (format!("{} of {}", at.0, at.1), off / sigma))
    };
    entries.into_iter().filter_map(error).collect()
}

/// The daily sample: three flights of thirty-two. The responses of 2021 determine Nped for one value of Nr alone: a bound
/// for this value would leave Nped 15 bounds off.
#[test]
fn derivatives_of_three_flights_keep_within_their_bounds() {
    assert_derivatives_keep_within_their_bounds(&[2021, 2022, 2023]);
}

#[test]
#[ignore = "minutes: thirty-two flights and identifications"]
fn derivatives_keep_within_their_bounds() {
    assert_derivatives_keep_within_their_bounds(&Vec::from_iter(2000..=2031));
}

fn assert_derivatives_keep_within_their_bounds(seeds: &[u64]) {
    let mut errors = Vec::new();
    for &seed in seeds {
        let vehicle = identified(seed).1;
        let own = normalised_errors(&vehicle, &truth(seed));
        let far: Vec<_> = own.iter().filter(|(_, error)| error.abs() > 2.5).collect();
        println!("{seed}: {far:.1?}");
        errors.extend(own);
    }
    let rms_of = |of: &[&(String, f64)]| {
        (of.iter().map(|(_, error)| error * error).sum::<f64>() / of.len() as f64).sqrt()
    };
    let mut names: Vec<&String> = errors.iter().map(|(name, _)| name).collect();
    names.sort_unstable();
    names.dedup();
    for name in names {
        let own: Vec<_> = errors.iter().filter(|(own, _)| own == name).collect();
        let mean = own.iter().map(|(_, error)| error).sum::<f64>() / own.len() as f64;
        println!("{name}: {} flights, mean {mean:.2}, rms {:.2}", own.len(), rms_of(&own));
    }
    let rms = rms_of(&errors.iter().collect::<Vec<_>>());
    let largest = errors.iter().fold(0.0, |most: f64, (_, error)| most.max(error.abs()));
    println!("{} entries: {rms:.2} rms, largest {largest:.1}", errors.len());
    assert!(rms < 1.3 && largest < 4.0);
}

#[test]
#[ignore = "minutes: thirty-two flights and identifications"]
fn delays_and_lags_keep_within_their_bounds() {
    let flights: Vec<Identification> = (1410..=1441).map(|seed| identified(seed).0).collect();
    for (stick, _) in PAIRS {
        let late: Vec<(f64, f64)> =
            flights.iter().map(|found| lateness(&found.identified, stick)).collect();
        let ratios: Vec<f64> = late.iter().map(|(off_s, bound_s)| off_s / bound_s).collect();
        let count = ratios.len() as f64;
        let mean_ms = 1e3 * late.iter().map(|late| late.0).sum::<f64>() / count;
        let rms = (ratios.iter().map(|ratio| ratio * ratio).sum::<f64>() / count).sqrt();
        let largest = ratios.iter().fold(0.0, |most: f64, ratio| most.max(ratio.abs()));
        println!("{stick}: mean {mean_ms:.1} ms late, {rms:.2} bounds rms, {largest:.1}");
        assert!(rms < 1.5 && largest < 4.0 && mean_ms.abs() < 10.0);
    }
}

/// If the sticks are recorded 80 ms late, the vehicle seems to respond before they move.
#[test]
fn late_sticks_and_a_collective_the_wrong_way_round_are_named() {
    let (mut dataset, solutions) =
        flown(HelicopterParameters::raptor60(), &shipped::raptor60(), 828);
    let verdict = |dataset: &Dataset| {
        let found = data::identified(dataset, &solutions, "hybrid");
        found.verdict(None)
    };
    let names = |verdict: &Verdict, what: &str| {
        println!("{}: {:?}", verdict.grade, verdict.reasons);
        verdict.grade == Grade::DoNotFly && verdict.reasons.iter().any(|own| own.contains(what))
    };
    let turned = |controls: &mut [f64; 4]| controls[2] = -controls[2];
    dataset.controls.iter_mut().for_each(|(_, controls)| turned(controls));
    dataset.injected.iter_mut().for_each(turned);
    assert!(names(&verdict(&dataset), "of the wrong sign: with a positive collective"));
    dataset.controls.iter_mut().for_each(|(_, controls)| turned(controls));
    dataset.injected.iter_mut().for_each(turned);
    dataset.controls.iter_mut().for_each(|(time, _)| *time = time.offset_by(0.08));
    let late = verdict(&dataset);
    assert!(names(&late, "the sticks are recorded late"));
    // The cause is listed before its consequences.
    assert!(late.reasons[0].starts_with("the sticks are recorded late"));
}

#[test]
#[ignore = "minutes: thirty flights, identifications and designs"]
fn thirty_flights_lead_to_a_flight_or_a_refusal() {
    let outcomes: Vec<Outcome> = (870..=899).map(outcome).collect();
    outcomes.iter().for_each(assert_sound);
    let close = |outcome: &&Outcome| outcome.costs.iter().all(|cost| *cost <= 100.0);
    println!("{} of 30 with J up to 100 in p, q, w and r", outcomes.iter().filter(close).count());
}
