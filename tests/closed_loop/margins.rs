//! What the loops can stand.

use hovernav::design::hover::HoverDesign;
use hovernav::model::{StateSpace, shipped};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Every loop broken at its actuator, all others closed.
#[track_caller]
fn assert_margins(design: &HoverDesign, model: &StateSpace) {
    let gains = design.synthesise(model).unwrap();
    let margins = design.close(model, &gains).unwrap().margins().unwrap();
    assert_eq!(margins.channels.len(), 4);
    for channel in &margins.channels {
        let db = |factor: f64| (20.0 * factor.log10()).abs();
        let up = channel.gain_up.map_or(f64::INFINITY, |crossing| db(crossing.margin));
        let down = channel.gain_down.map_or(f64::INFINITY, |crossing| db(crossing.margin));
        let phase = channel.phase.map_or(f64::INFINITY, |crossing| crossing.margin.to_degrees());
        println!("{} {}: +{up:.1} dB -{down:.1} dB {phase:.1}°", model.name(), channel.name);
        assert!(up.min(down) >= 6.0, "{}: {up} {down} dB", channel.name);
        assert!(phase >= 45.0, "{}: {phase}°", channel.name);
    }
}

#[test]
fn every_loop_of_the_60_class_has_6_db_and_45_degrees() {
    assert_margins(&HoverDesign::default(), &shipped::raptor60());
}

#[test]
fn every_loop_of_the_printed_model_has_6_db_and_45_degrees() {
    assert_margins(&HoverDesign::thesis(), &shipped::thesis());
}

/// `model` with every derivative off by up to `share` of it, each for itself; what is kinematics or
/// gravity stays.
fn perturbed(model: &StateSpace, share: f64, random: &mut ChaCha8Rng) -> StateSpace {
    let mut off = || 1.0 + share * (2.0 * f64::from(random.next_u32()) / f64::from(u32::MAX) - 1.0);
    let names: Vec<&str> = model.states().iter().map(|state| state.name.as_str()).collect();
    let angle = |name: &str| matches!(name, "phi" | "theta" | "psi");
    let (mut a, mut b) = (model.a().clone(), model.b().clone());
    for (row, _) in names.iter().enumerate().filter(|(_, to)| !angle(to)) {
        for (column, _) in names.iter().enumerate().filter(|(_, from)| !angle(from)) {
            a[(row, column)] *= off();
        }
        for column in 0..b.ncols() {
            b[(row, column)] *= off();
        }
    }
    let (states, inputs) = (model.states().to_vec(), model.inputs().to_vec());
    StateSpace::new("perturbed", model.time(), states, inputs, a, b).unwrap()
}

/// How many of 500 perturbed models the gains of the nominal one keep stable.
fn stable_of_500(design: &HoverDesign, model: &StateSpace) -> usize {
    let gains = design.synthesise(model).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    (0..500)
        .filter(|_| {
            let other = perturbed(model, 0.2, &mut random);
            let poles = design.close(&other, &gains).unwrap().closed_poles().unwrap();
            poles.iter().all(|pole| pole.norm() < 1.0)
        })
        .count()
}

#[test]
fn every_derivative_off_by_a_fifth_leaves_the_60_class_stable() {
    let stable = stable_of_500(&HoverDesign::default(), &shipped::raptor60());
    println!("raptor60: {stable} of 500 stable");
    assert!(stable >= 495, "{stable}");
}

#[test]
fn every_derivative_off_by_a_fifth_leaves_the_printed_model_stable() {
    let stable = stable_of_500(&HoverDesign::thesis(), &shipped::thesis());
    println!("thesis: {stable} of 500 stable");
    assert!(stable >= 495, "{stable}");
}
