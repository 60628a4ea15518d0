//! A model of forward flight, from a simulated flight.

use hovernav::autopilot::{Excitation, ExcitationLimits, HoverConfig, Maneuver, SetPoint};
use hovernav::controls::Sticks;
use hovernav_design::hover::HoverDesign;
use hovernav_model::shipped;
use hovernav_replay::smooth;
use hovernav_sim::campaign::SensorGrade;
use hovernav_sim::{FlightConfig, FlightEvent, WindConfig};
use hovernav_sysid::helicopter::{
    FlightRecord, FrequencyDomain, IdentifyError, Request, Velocity, identify,
};

/// Speed of the flight, m/s.
const SPEED_MPS: f64 = 5.0;

/// Doublets to both sides and 3-2-1-1 on each stick in turn, from `start_s` on.
fn test_inputs(start_s: f64) -> Vec<(f64, FlightEvent)> {
    let maneuvers = [
        Maneuver::Doublet { amplitude: 0.1, hold_s: 1.0 },
        Maneuver::ThreeTwoOneOne { amplitude: 0.08, unit_s: 0.5 },
        Maneuver::Doublet { amplitude: -0.1, hold_s: 1.0 },
    ];
    let each =
        maneuvers.into_iter().flat_map(|maneuver| [0, 1, 2, 3].map(|stick| (maneuver, stick)));
    each.enumerate()
        .map(|(turn, (maneuver, stick))| {
            let mut direction = [0.0; 4];
            direction[stick] = 1.0;
            let direction = Sticks::from_array(direction);
            let limits = ExcitationLimits::default();
            let at_s = start_s + 12.0 * turn as f64;
            (at_s, FlightEvent::Excite(Excitation { direction, maneuver, limits }))
        })
        .collect()
}

/// Zw is half as large again as in hover, and the kinematics of the trim couple q to w.
#[test]
fn a_flight_at_5_m_per_s_gives_the_model_of_this_speed() {
    let design = HoverDesign::default();
    let gains = design.synthesise(&shipped::raptor60()).unwrap();
    let mut config = FlightConfig::new(HoverConfig::new(design.period_s, gains));
    (config.dmu, config.gps) = SensorGrade::Modern.sensors();
    config.dmu.rate_hz = 1.0 / design.period_s;
    config.wind = WindConfig::from_direction(1.0, 135f64.to_radians(), 0.5);
    let (forward_mps, right_mps, down_mps) = (SPEED_MPS, 0.0, 0.0);
    let ahead = SetPoint::Velocity { forward_mps, right_mps, down_mps, yaw_rate_radps: 0.0 };
    config.events = vec![(25.0, FlightEvent::SetPoint(ahead))];
    config.events.extend(test_inputs(45.0));
    config.duration_s = 195.0;
    let flight = config.fly().unwrap();
    assert!(flight.crashed_s.is_none() && flight.aborted.is_empty(), "{:?}", flight.aborted);
    let (mut dataset, _) = flight.dataset();
    let settings = dataset.settings().unwrap();
    let solutions = smooth(&dataset, &settings, |_| ()).solutions;
    let of = |speed_mps| {
        let wanted = Request { structure: None, speed_mps: Some(speed_mps) };
        identify(&dataset, &solutions, wanted, Velocity::Estimated)
    };
    let found = of(SPEED_MPS).unwrap();
    let record = FlightRecord::new(&dataset, &solutions, Velocity::Estimated).unwrap();
    let frequency = FrequencyDomain::of(&found, &record).unwrap();
    assert!(frequency.costs.len() >= 4, "{:?}", frequency.costs);
    let vehicle = found.vehicle().unwrap();
    assert!((vehicle.trim_speed_mps() - SPEED_MPS).abs() < 0.1, "{}", vehicle.trim_speed_mps());
    let truth = shipped::raptor60_at(SPEED_MPS).unwrap();
    for (row, column, within) in [
        ("w", "w", 0.25),
        ("w", "q", 0.1),
        ("w", "collective", 0.1),
        ("r", "r", 0.15),
        ("r", "pedal", 0.15),
    ] {
        let value = |model: &hovernav_model::StateSpace| {
            let row = model.state(row).unwrap();
            match model.state(column) {
                Ok(column) => model.a()[(row, column)],
                Err(_) => model.b()[(row, model.input(column).unwrap())],
            }
        };
        let (own, expected) = (value(&vehicle), value(&truth));
        println!("{row} from {column}: {own:.3}, expected {expected:.3}");
        assert!((own / expected - 1.0).abs() < within, "{row} from {column}: {own}, {expected}");
    }
    // Nothing of the flight is near 12 m/s.
    let refused = of(12.0).unwrap_err();
    assert!(matches!(refused, IdentifyError::NotFlown { .. }), "{refused}");
    assert!(refused.to_string().contains("near 12 m/s"), "{refused}");
}
