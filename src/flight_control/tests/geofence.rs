//! Tests of the geofence: the vehicle reaches it, returns, and is inside again.

use super::*;

fn geofenced(steering: Option<SteeringConfig>) -> FlightControlConfig {
    let geofence = Geofence { centre: place(0.0, 0.0), radius_m: 50.0, height_m: 40.0 };
    let mut config = FlightControlConfig { geofence: Some(geofence), steering, ..config() };
    config.hover.transfer.override_travel = 0.8;
    config
}

fn north_asked_mps(bench: &Bench) -> f64 {
    bench.control.autopilot().reference().0.x()
}

#[test]
fn the_geofence_is_reported_once_and_again_when_it_is_left() {
    let mut bench = Bench::engaged(geofenced(None));
    let count = |bench: &Bench, wanted| bench.told.iter().filter(|told| **told == wanted).count();
    for position in [place(51.0, 10.0), place(52.0, 10.0), place(10.0, 10.0), place(0.0, 41.0)] {
        bench.solution.as_mut().unwrap().position = position;
        bench.cycles(5);
    }
    assert_eq!(count(&bench, ControlNotice::GeofenceReached), 2);
    assert_eq!(count(&bench, ControlNotice::InsideGeofenceAgain), 1);
}

#[test]
fn a_stick_held_outwards_does_not_fly_through_the_geofence() {
    let mut bench = Bench::engaged(geofenced(Some(SteeringConfig::default())));
    bench.solution.as_mut().unwrap().body_to_ned =
        Rotation::from_euler(EulerAngles::from_degrees(0.0, 0.0, 0.0));
    let hands_off = bench.pilot_ms.unwrap();
    bench.pilot_ms = Some(Channels { longitudinal: 1.75, ..hands_off });
    bench.cycles(100);
    assert!(north_asked_mps(&bench) > 1.0, "it goes north: {}", north_asked_mps(&bench));
    bench.solution.as_mut().unwrap().position = place(51.0, 10.0);
    bench.cycles(200);
    assert!(north_asked_mps(&bench) < -1.0, "it goes back: {}", north_asked_mps(&bench));
    bench.pilot_ms = Some(hands_off);
    bench.cycles(100);
    assert!(north_asked_mps(&bench) < -1.0, "and stays on its way: {}", north_asked_mps(&bench));
    bench.solution.as_mut().unwrap().position = place(30.0, 10.0);
    bench.pilot_ms = Some(Channels { longitudinal: 1.75, ..hands_off });
    bench.cycles(400);
    assert!(north_asked_mps(&bench) > 1.0, "inside it steers again: {}", north_asked_mps(&bench));
}

#[test]
fn it_goes_back_though_velocity_or_the_pilot_was_lost_meanwhile() {
    let mut bench = Bench::engaged(geofenced(None));
    bench.solution.as_mut().unwrap().position = place(51.0, 10.0);
    bench.cycles(100);
    let good = bench.solution.unwrap();
    bench.solution.as_mut().unwrap().velocity_sigma_mps = Vector::new(3.0, 3.0, 3.0);
    assert_eq!(bench.cycles(30).mode, Mode::Attitude);
    bench.solution = Some(good);
    assert_eq!(bench.cycles(200).mode, Mode::Position);
    assert!(north_asked_mps(&bench) < -1.0, "after velocity: {}", north_asked_mps(&bench));

    let (pilot_ms, aux_ms) = (bench.pilot_ms, bench.aux_ms);
    (bench.pilot_ms, bench.aux_ms) = (None, None);
    bench.cycles(700);
    assert!(bench.told(ControlNotice::DescentStarted) && north_asked_mps(&bench).abs() < 0.1);
    (bench.pilot_ms, bench.aux_ms) = (pilot_ms, aux_ms);
    bench.cycles(200);
    assert!(bench.told(ControlNotice::PilotSignalRestored));
    assert!(north_asked_mps(&bench) < -1.0, "after the pilot: {}", north_asked_mps(&bench));
}

#[test]
fn outside_the_geofence_it_does_not_take_over() {
    let mut bench = Bench::new(geofenced(None));
    bench.solution.as_mut().unwrap().position = place(0.0, 60.0);
    bench.cycles(20);
    bench.aux_ms = Some(CLOSED_MS);
    assert_eq!(bench.cycles(10).mode, Mode::Manual);
    let failed: Vec<String> =
        bench.last.unwrap().readiness.failed().map(ToString::to_string).collect();
    assert_eq!(failed, ["share of the way to the geofence: 1.500, at most 1"]);
}
