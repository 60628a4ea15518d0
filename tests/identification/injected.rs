//! Test inputs that an autopilot injects, with good sensors: the bounds are then small.
//!
//! Seeds 1, 11 to 18 and 21 to 33 were used in the development of the method. Seeds 2101 to 2110, 3000 to 3007 and 3100
//! to 3109 were each evaluated once.

use hovernav::autopilot::{Excitation, ExcitationLimits, HoverConfig, Maneuver};
use hovernav::controls::Sticks;
use hovernav::ekf::Solution;
use hovernav_dataset::Dataset;
use hovernav_design::hover::HoverDesign;
use hovernav_model::shipped;
use hovernav_sim::campaign::SensorGrade;
use hovernav_sim::{FlightConfig, FlightEvent, WindConfig};

use crate::chain;
use crate::data;

/// The flight, and its smoothed estimate.
fn flown(seed: u64) -> (Dataset, Vec<Solution>) {
    let model = shipped::raptor60();
    let design = HoverDesign::for_model(&model);
    let autopilot = HoverConfig::new(design.period_s, design.synthesise(&model).unwrap());
    let mut config = FlightConfig { seed, wind: wind(), ..FlightConfig::new(autopilot) };
    (config.dmu, config.gps) = SensorGrade::Modern.sensors();
    let maneuvers = [
        Maneuver::Doublet { amplitude: 0.1, hold_s: 1.0 },
        Maneuver::ThreeTwoOneOne { amplitude: 0.08, unit_s: 0.5 },
        Maneuver::Doublet { amplitude: -0.1, hold_s: 1.0 },
    ];
    let mut at_s = 45.0;
    for (maneuver, stick) in
        maneuvers.into_iter().flat_map(|own| [0, 1, 2, 3].map(|stick| (own, stick)))
    {
        let mut direction = [0.0; 4];
        direction[stick] = 1.0;
        let direction = Sticks::from_array(direction);
        let limits = ExcitationLimits::default();
        config.events.push((at_s, FlightEvent::Excite(Excitation { direction, maneuver, limits })));
        at_s += maneuver.duration_s() + 8.0;
    }
    config.duration_s = at_s + 22.0;
    chain::smoothed(&config)
}

/// The likelihood takes the height controller's response to gusts for the effect of the collective: Zcol of these flights
/// would be 7.6 and 6.5 % too weak. The sag of the rotor's speed under its governor, 3 %, is not modelled.
#[test]
fn a_controller_in_gusts_does_not_weaken_the_collective() {
    let truth = chain::truth_in(wind().steady_mps);
    let true_strength = truth.b()[(truth.state("w").unwrap(), truth.input("collective").unwrap())];
    let errors = [11, 14].map(|seed| {
        let (dataset, solutions) = flown(seed);
        let found = data::identified(&dataset, &solutions, "heave");
        let strength = found.identified.estimates.get("Zcol").unwrap();
        println!("{seed}: Zcol {} ± {}, {true_strength}", strength.value, strength.bound);
        strength.value / true_strength - 1.0
    });
    assert!(errors.iter().all(|error| error.abs() < 0.05), "{errors:?}");
}

fn wind() -> WindConfig {
    WindConfig::from_direction(1.0, 135f64.to_radians(), 0.5)
}

/// Errors of the derivatives of the flights `seeds`, each divided by its bound.
fn normalised_errors(structure: &str, seeds: impl Iterator<Item = u64>) -> Vec<f64> {
    let truth = chain::truth_in(wind().steady_mps);
    let mut all = Vec::new();
    for seed in seeds {
        let (dataset, solutions) = flown(seed);
        let found = data::identified(&dataset, &solutions, structure);
        let own = chain::normalised_errors(&found.vehicle().unwrap(), &truth);
        println!("{seed}: dead bands {:.4?}, {own:.1?}", found.dead_bands);
        all.extend(own.into_iter().map(|(_, error)| error));
    }
    all
}

fn assert_bounds_hold(errors: &[f64]) {
    let rms = (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
    let largest = errors.iter().fold(0.0, |most: f64, error| most.max(error.abs()));
    println!("{} entries: {rms:.2} rms, largest {largest:.1}", errors.len());
    assert!(rms < 1.4 && largest < 4.0);
}

/// With the mean of the lagged pedal over each interval, and with every recorded command as a movement of the servo, the
/// errors of seed 11 are up to 4.6 bounds.
#[test]
fn a_fast_yaw_behind_a_servo_with_a_dead_band_keeps_its_bounds() {
    assert_bounds_hold(&normalised_errors("yaw", [11, 14].into_iter()));
}

#[test]
#[ignore = "minutes: eight flights and identifications"]
fn derivatives_from_injected_inputs_keep_within_their_bounds() {
    assert_bounds_hold(&normalised_errors("hybrid", 3100..3108));
}
