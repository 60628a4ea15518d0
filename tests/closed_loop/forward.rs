//! Slow forward flight: one set of gains from hover to 8 m/s.

use hovernav::autopilot::{HoverConfig, Mode, SetPoint};
use hovernav_design::CheckedDesign;
use hovernav_design::hover::{Cut, FlightMode, HoverDesign, Wanted};
use hovernav_model::{StateSpace, shipped};
use hovernav_sim::{Flight, FlightConfig, FlightEvent};

use crate::autopilot;

/// Fastest flight of these tests, m/s.
const FASTEST_MPS: f64 = 8.0;

fn at(speed_mps: f64) -> StateSpace {
    shipped::raptor60_at(speed_mps).unwrap()
}

fn ahead(forward_mps: f64) -> SetPoint {
    SetPoint::Velocity { forward_mps, right_mps: 0.0, down_mps: 0.0, yaw_rate_radps: 0.0 }
}

/// A flight in the usual wind of 3 m/s with gusts of 1.5 m/s.
fn flight(seed: u64, duration_s: f64, events: Vec<(f64, FlightEvent)>) -> Flight {
    let mut autopilot: HoverConfig = autopilot();
    autopilot.guidance.speed_mps = FASTEST_MPS;
    let config = FlightConfig { seed, duration_s, events, ..FlightConfig::new(autopilot) };
    let flight = config.fly().unwrap();
    assert_eq!(flight.crashed_s, None, "seed {seed}");
    flight
}

/// The gains of hover do not change with speed. They control the velocity, or the attitude alone, of the helicopter
/// linearised at each speed.
#[test]
fn the_gains_of_hover_have_6_db_and_45_degrees_up_to_8_m_per_s() {
    let design = HoverDesign::default();
    let gains = design.synthesise(&shipped::raptor60()).unwrap();
    for speed_mps in [-3.0, 0.0, 2.0, 4.0, 6.0, FASTEST_MPS] {
        for mode in [FlightMode::Velocity, FlightMode::Attitude] {
            let closed = design.close_in(&at(speed_mps), &gains, mode, Cut::Actuators).unwrap();
            for channel in closed.margins().unwrap().channels {
                let (db, phase_deg) = (channel.smallest_gain_db(), channel.phase_deg());
                let name = format!("{speed_mps} m/s, {}, {}", mode.name(), channel.name);
                assert!(db >= 6.0 && phase_deg >= 45.0, "{name}: {db} dB {phase_deg}°");
            }
        }
    }
}

/// Position hold with the usual weights has a phase margin of 45.8° in hover and of 44.7° at 4 m/s.
#[test]
fn the_fastest_speed_is_the_last_with_its_margins_in_every_mode() {
    let hover = shipped::raptor60();
    let checked = CheckedDesign::new(hover.clone(), HoverDesign::default()).unwrap();
    let warned = checked.warnings.len();
    let checked = checked.with_forward(&[at(4.0), at(-2.0)]).unwrap();
    let forward = checked.forward.as_ref().unwrap();
    let speeds: Vec<(f64, bool)> =
        forward.points.iter().map(|point| (point.speed_mps, point.is_given)).collect();
    assert_eq!(speeds[..4], [(-2.0, true), (-1.5, false), (-1.0, false), (-0.5, false)]);
    assert_eq!(speeds[4..], [(0.0, true), (1.0, false), (2.0, false), (3.0, false), (4.0, true)]);
    assert_eq!(forward.fastest_mps, [Some(3.0), Some(2.0)]);
    assert_eq!(checked.autopilot().guidance.speed_mps, 2.0);
    assert_eq!(checked.warnings.len(), warned + 1);
    assert!(checked.warnings[warned].starts_with("at 4.0 m/s the weakest margins"));
    for point in &forward.points {
        let [gain_db, phase_deg, disk] = point.weakest().unwrap();
        assert!(gain_db > 9.0 && phase_deg > 44.0 && disk > 0.6, "{} m/s", point.speed_mps);
    }
    // Models of the same speed contradict each other.
    let doubled = CheckedDesign::new(hover, HoverDesign::default()).unwrap();
    assert!(doubled.with_forward(&[at(0.0)]).is_err());
}

#[test]
#[ignore = "half a minute of search"]
fn a_search_for_hover_and_8_m_per_s_keeps_its_margins_between_them() {
    let hover = shipped::raptor60();
    let models = [at(FASTEST_MPS)];
    let design = HoverDesign::for_model(&hover);
    let search = design.searched(&hover, &models, &Wanted::default()).unwrap();
    let checked = CheckedDesign::new(hover, search.design).unwrap().with_forward(&models).unwrap();
    let forward = checked.forward.unwrap();
    assert_eq!(forward.fastest_mps, [Some(FASTEST_MPS), None]);
    for point in &forward.points {
        let [gain_db, phase_deg, _] = point.weakest().unwrap();
        assert!(gain_db >= 9.0 && phase_deg >= 53.0, "{gain_db} dB {phase_deg}°");
    }
}

/// An error of the heading turns the velocity: 3° at 8 m/s are 0.4 m/s to the side.
#[test]
fn forward_flight_in_gusts_keeps_its_velocity() {
    for (seed, speed_mps, max_mps) in
        [(1, 5.0, 0.3), (2, 5.0, 0.3), (3, 5.0, 0.3), (4, FASTEST_MPS, 0.5)]
    {
        let flight = flight(seed, 100.0, vec![(20.0, FlightEvent::SetPoint(ahead(speed_mps)))]);
        let found = flight.velocity_deviation_mps(35.0..100.0, [speed_mps, 0.0, 0.0]).unwrap();
        println!("seed {seed}, {speed_mps} m/s: {found:?} m/s");
        assert!(found.iter().all(|rms| *rms <= max_mps), "seed {seed}: {found:?} m/s");
        assert_eq!(flight.samples.last().unwrap().mode, Mode::Position);
    }
}

/// The pilot takes the helicopter at 8 m/s and gives it back half a second later.
#[test]
fn engagement_at_8_m_per_s_stops_and_holds() {
    let events = vec![
        (20.0, FlightEvent::SetPoint(ahead(FASTEST_MPS))),
        (45.0, FlightEvent::Engage(false)),
        (45.5, FlightEvent::Engage(true)),
    ];
    let flight = flight(5, 100.0, events);
    let fast = flight.excursion(40.0, 5.0).speed_mps;
    assert!(fast > FASTEST_MPS - 1.0, "{fast} m/s");
    let tilt_rad = flight.excursion(45.0, 55.0).tilt_rad;
    assert!(tilt_rad < 0.35, "{tilt_rad} rad");
    let stopped = flight.velocity_deviation_mps(75.0..100.0, [0.0; 3]).unwrap();
    assert!(stopped.iter().all(|rms| *rms <= 0.3), "{stopped:?} m/s");
}
