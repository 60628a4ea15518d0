//! Margins that a design promises for a model identified from a flight, beside those it has on the vehicle that flew.
//!
//! Seeds 1500 to 1503 are flown here; none was looked at while identification was made.

use hovernav::autopilot::HoverConfig;
use hovernav::frames::Vector;
use hovernav_design::Margins;
use hovernav_design::hover::{HoverDesign, Wanted};
use hovernav_model::helicopter::{Helicopter, HelicopterParameters};
use hovernav_model::{Grade, StateSpace, shipped};
use hovernav_sim::{Feedback, FlightConfig, FlightEvent, WindConfig};
use hovernav_sysid::helicopter::{FlightRecord, FrequencyDomain, Kind, Velocity, identify};

/// Calm, 3 m/s with gusts of 1.0 and 1.5 m/s, 5 m/s with 1.25, in turn.
fn wind_of(seed: u64) -> WindConfig {
    match seed % 4 {
        0 => WindConfig::calm(),
        1 => WindConfig::from_direction(3.0, 135f64.to_radians(), 1.0),
        2 => WindConfig::from_direction(3.0, 45f64.to_radians(), 1.5),
        _ => WindConfig::from_direction(5.0, 80f64.to_radians(), 1.25),
    }
}

/// Test points as `hovernav simulate --test-points` flies them, and the model that `hovernav identify` makes of them.
fn identified(seed: u64) -> StateSpace {
    let (design, model) = (HoverDesign::default(), shipped::raptor60());
    let autopilot = HoverConfig::new(design.period_s, design.synthesise(&model).unwrap());
    let mut config = FlightConfig { seed, wind: wind_of(seed), ..FlightConfig::new(autopilot) };
    config.feedback = Feedback::Truth;
    config.events = FlightEvent::test_points(30.0, 0.12);
    config.duration_s = config.events.last().unwrap().0 + 30.0;
    let flight = config.fly().unwrap();
    assert_eq!(flight.crashed_s, None);
    let (mut dataset, _) = flight.dataset();
    let settings = dataset.settings().unwrap();
    let solutions = dataset.smooth(&settings, |_| ()).solutions;
    let found = identify(&dataset, &solutions, Kind::Hybrid, Velocity::Estimated).unwrap();
    let record = FlightRecord::new(&dataset, &solutions, Velocity::Estimated).unwrap();
    let verdict = found.verdict(FrequencyDomain::of(&found, &record).ok().as_ref());
    found.identified.vehicle().unwrap().with_verdict(verdict)
}

/// The vehicle's own linearisation in the wind of `seed`.
fn truth(seed: u64) -> StateSpace {
    let helicopter = Helicopter::new(HelicopterParameters::raptor60()).unwrap();
    let wind = wind_of(seed).steady_mps;
    let trim = helicopter.trim(Vector::ZERO, wind, 60f64.to_radians()).unwrap();
    helicopter.linearise(&trim, wind)
}

/// Smallest gain and phase margin of all loops, dB and °.
fn weakest(margins: &Margins) -> [f64; 2] {
    let channels = || margins.channels.iter();
    [
        channels().map(|channel| channel.smallest_gain_db()).fold(f64::INFINITY, f64::min),
        channels().map(|channel| channel.phase_deg()).fold(f64::INFINITY, f64::min),
    ]
}

/// Margins as promised for the model of `seed`, and on the vehicle; `None` where the model is not to be flown by.
fn margins(seed: u64) -> Option<[[f64; 2]; 2]> {
    let vehicle = identified(seed);
    let grade = vehicle.verdict().unwrap().grade;
    if grade == Grade::DoNotFly {
        println!("seed {seed}: {grade}");
        return None;
    }
    let wanted = Wanted { trials: 150, ..Wanted::default() };
    let design = HoverDesign::for_model(&vehicle).searched(&vehicle, &wanted).unwrap().design;
    let gains = design.synthesise(&vehicle).unwrap();
    let promised = weakest(&design.close(&vehicle, &gains).unwrap().margins().unwrap());
    let own = HoverDesign::for_model(&shipped::raptor60());
    let had = weakest(&own.close(&truth(seed), &gains).unwrap().margins().unwrap());
    println!(
        "seed {seed}, {grade}: promised {:.1} dB and {:.1}°, on the vehicle {:.1} dB and {:.1}°",
        promised[0], promised[1], had[0], had[1]
    );
    Some([promised, had])
}

fn assert_kept(seeds: std::ops::RangeInclusive<u64>) {
    let found: Vec<_> = seeds.filter_map(margins).collect();
    for [promised, had] in &found {
        assert!(had[0] > promised[0] - 2.0 && had[1] > promised[1] - 8.0, "{promised:?} {had:?}");
    }
    println!("{} models designed for", found.len());
}

#[test]
fn margins_on_the_vehicle_are_no_more_than_2_db_and_8_degrees_below_those_promised() {
    assert_kept(1500..=1503);
}
