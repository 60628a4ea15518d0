//! A cut link, or a source that stops: the past is never shown as the present.

use crate::common::sender::Sender;
use crate::common::{Client, cycle, serve, supplement};
use hovernav::telemetry::frame;
use hovernav_ground::channel::Id;
use hovernav_ground::frames::Rigging;
use hovernav_ground::lamps::{Lamp, Light, control, lamps};
use hovernav_ground::link::lock;
use hovernav_ground::station::{Clock, Station};
use mavlink::dialects::common::{
    ESTIMATOR_STATUS_DATA, EstimatorStatusFlags, MavAutopilot, MavMessage, MavSysStatusSensor,
    MavType, SYS_STATUS_DATA,
};

fn station() -> Station {
    Station::new(Rigging::default(), None, "test")
}

fn lamps_of(station: &Station, now_s: f64) -> Vec<Lamp> {
    let silence = station.silence(now_s);
    lamps(|id| station.latest(id, now_s), silence.as_deref())
}

fn lamp(station: &Station, now_s: f64, name: &str) -> Lamp {
    lamps_of(station, now_s).into_iter().find(|lamp| lamp.name == name).unwrap()
}

#[test]
fn a_link_cut_at_any_moment_leaves_no_value_and_no_lamp_that_looks_alive() {
    let mut station = station();
    let mut number = 0;
    // Twenty cuts, of 0.9 to 12.3 s, after 4.5 s of flight each.
    for cut in 0..20 {
        for _ in 0..150 {
            let at_s = 1e9 + f64::from(number) / 33.0;
            station.receive(&cycle(number), at_s);
            assert!(station.silence(at_s).is_none());
            number += 1;
        }
        let last_s = 1e9 + f64::from(number - 1) / 33.0;
        assert_eq!(lamp(&station, last_s + 0.03, "inertial unit").light, Light::Good);
        let length_s = 0.9 + 0.6 * f64::from(cut);
        for step in 0..(length_s / 0.05) as u32 {
            let now_s = last_s + 0.05 * f64::from(step);
            station.tick(now_s);
            let age_s = now_s - last_s;
            let value = |id| station.latest(id, now_s);
            // The limit is two periods of the link, and 0.2 s for its delays. An earlier cut may have left a longer
            // average period.
            if age_s > 0.5 {
                let known: Vec<_> = Id::all().filter(|id| !value(*id).is_nan()).collect();
                assert!(known.is_empty(), "{age_s} s after cut {cut}: {known:?}");
                let lamps = lamps_of(&station, now_s);
                assert!(lamps.iter().all(|lamp| lamp.light == Light::Unknown), "{lamps:?}");
                let silence = station.silence(now_s);
                let control = control(value, silence.as_deref());
                assert_eq!((control.mode, control.engagement.light), (None, Light::Unknown));
            }
            if age_s > 1.1 {
                let words = format!("no telemetry for {age_s:.0} s");
                assert_eq!(station.silence(now_s).as_deref(), Some(words.as_str()));
                assert_eq!(lamp(&station, now_s, "GPS").why, words);
                assert_eq!(control(value, Some(&words)).flies, words);
            }
        }
        number += (33.0 * length_s) as u32;
    }
}

/// A relay that drops the longer frames passes supplements only.
#[test]
fn supplements_without_snapshots_are_no_telemetry() {
    let mut station = station();
    let seconds = |number: u32| 1e9 + f64::from(number) / 33.0;
    (0..100).for_each(|number| station.receive(&cycle(number), seconds(number)));
    for number in 100..200 {
        let alone = frame::pack_supplement(&supplement(f64::from(number) / 33.0), number as u8);
        station.receive(&alone, seconds(number));
        station.tick(seconds(number));
    }
    assert_eq!(station.silence(seconds(199)).as_deref(), Some("no telemetry for 3 s"));
    let (lines, _) = station.store.texts_from(0);
    assert_eq!(lines.filter(|line| line.text.contains("no frame for")).count(), 1);
}

#[test]
fn a_link_that_is_slow_but_alive_is_not_silent() {
    for period_s in [0.03, 0.2, 1.0, 2.0] {
        let mut station = station();
        for k in 0..40 {
            let at_s = 1e9 + period_s * f64::from(k);
            let number = (33.0 * period_s * f64::from(k)) as u32;
            station.receive(&cycle(number), at_s);
            for part in [0.3, 0.6, 0.99] {
                let now_s = at_s + part * period_s;
                // The period is unknown until two frames have arrived.
                if k > 1 {
                    assert_eq!(station.silence(now_s), None, "{period_s} s, frame {k}");
                    assert!(!station.latest(Id::Roll, now_s).is_nan(), "{period_s} s, frame {k}");
                }
            }
        }
    }
}

#[test]
fn telemetry_that_arrives_late_is_called_late_and_is_no_present_value() {
    let mut station = station();
    for number in 0..200u32 {
        let sent_s = 1e9 + f64::from(number) / 33.0;
        // A queue in the link grows to 4 s.
        let delay_s = 0.04 * f64::from(number.saturating_sub(100));
        station.receive(&cycle(number), sent_s + delay_s);
    }
    let now_s = 1e9 + 199.0 / 33.0 + 3.96;
    assert_eq!(station.silence(now_s).as_deref(), Some("telemetry arrives 4 s late"));
    assert!(station.latest(Id::Roll, now_s).is_nan());
}

#[test]
fn a_source_that_stops_loses_its_lamps_while_others_keep_theirs() {
    let (mut vehicle, mut station) = (Sender::new(1, 1), station());
    let sensors = MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_3D_GYRO
        | MavSysStatusSensor::MAV_SYS_STATUS_SENSOR_3D_ACCEL;
    let status = SYS_STATUS_DATA {
        onboard_control_sensors_present: sensors,
        onboard_control_sensors_enabled: sensors,
        onboard_control_sensors_health: sensors,
        ..SYS_STATUS_DATA::DEFAULT
    };
    let estimate = ESTIMATOR_STATUS_DATA {
        flags: EstimatorStatusFlags::ESTIMATOR_ATTITUDE,
        ..ESTIMATOR_STATUS_DATA::DEFAULT
    };
    for k in 0..200u32 {
        let now_s = 1e9 + 0.1 * f64::from(k);
        let mut bytes = vehicle.attitude(100 * k, 0.1);
        if k % 10 == 0 {
            bytes.extend(vehicle.heartbeat(
                MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
                MavType::MAV_TYPE_HELICOPTER,
            ));
            bytes.extend(vehicle.say(&MavMessage::ESTIMATOR_STATUS(estimate.clone())));
            if k < 100 {
                bytes.extend(vehicle.say(&MavMessage::SYS_STATUS(status.clone())));
            }
        }
        station.receive(&bytes, now_s);
        if k == 105 {
            assert_eq!(lamp(&station, now_s, "inertial unit").light, Light::Good);
        }
    }
    let now_s = 1e9 + 19.95;
    assert_eq!(lamp(&station, now_s, "attitude").light, Light::Good);
    let unit = lamp(&station, now_s, "inertial unit");
    assert_eq!((unit.light, unit.why.as_str()), (Light::Unknown, "not reported"));
}

#[test]
fn a_client_of_a_cut_link_gets_words_instead_of_values() {
    let served = serve(None);
    for number in 0..330 {
        let arrival_s = served.start_s - 60.0 + f64::from(number) / 33.0;
        lock(&served.station).receive(&cycle(number), arrival_s);
    }
    lock(&served.station).clock = Clock::Stopped(served.start_s);
    let mut client = Client::connect(&served, "").unwrap();
    let tick = client.observe("tick");
    assert!(tick["now"].as_array().unwrap().iter().all(serde_json::Value::is_null), "{tick}");
    // The time of the page advances without data.
    assert!(tick["t"].as_f64().unwrap() > tick["newest"].as_f64().unwrap() + 40.0, "{tick}");
    let state = client.observe("state");
    let silence = state["what"]["silence"].as_str().unwrap();
    assert!(silence.starts_with("no telemetry for 5") && silence.ends_with(" s"), "{silence}");
    assert_eq!(state["what"]["control"]["engagement"]["why"], silence);
    assert_eq!(state["what"]["control"]["engagement"]["light"], "unknown");
    assert!(state["what"]["under_way"].is_null() && state["what"]["since"].is_null());
}
