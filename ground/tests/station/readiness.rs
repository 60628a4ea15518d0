//! Arming state and age of the GPS fix of a vehicle from another maker.

use crate::common::sender::Sender;
use crate::common::{newest, snapshot};
use approx::assert_abs_diff_eq;
use hovernav::time::Time;
use hovernav_ground::channel::Id;
use hovernav_ground::frames::Rigging;
use hovernav_ground::lamps::lamps;
use hovernav_ground::station::Station;
use hovernav_record::MavlinkConfig;
use mavlink::dialects::common::{
    GPS_RAW_INT_DATA, GpsFixType, HEARTBEAT_DATA, MavAutopilot, MavMessage, MavModeFlag,
    MavSysStatusSensor, MavType, SYS_STATUS_DATA, SYSTEM_TIME_DATA,
};

fn station() -> Station {
    Station::new(Rigging::default(), None, "test")
}

/// The reason of the lamp with this name.
fn why(station: &Station, name: &str) -> String {
    let lamps = lamps(|id| newest(station, id), None);
    lamps.into_iter().find(|lamp| lamp.name == name).unwrap().why
}

#[test]
fn what_its_own_checks_say_before_arming_is_reported_in_words() {
    let check = MavSysStatusSensor::MAV_SYS_STATUS_PREARM_CHECK;
    let none = MavSysStatusSensor::empty();
    let (mut vehicle, mut station) = (Sender::new(1, 1), station());
    let mut at_s = 1e9;
    let mut observe = |base_mode, present, enabled, health| {
        let beat = HEARTBEAT_DATA {
            autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
            mavtype: MavType::MAV_TYPE_HELICOPTER,
            base_mode,
            ..HEARTBEAT_DATA::DEFAULT
        };
        let status = SYS_STATUS_DATA {
            onboard_control_sensors_present: present,
            onboard_control_sensors_enabled: enabled,
            onboard_control_sensors_health: health,
            ..SYS_STATUS_DATA::DEFAULT
        };
        let mut bytes = vehicle.say(&MavMessage::HEARTBEAT(beat));
        bytes.extend(vehicle.say(&MavMessage::SYS_STATUS(status)));
        at_s += 1.0;
        station.receive(&bytes, at_s);
        why(&station, "arming")
    };
    let (rests, armed) = (MavModeFlag::empty(), MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
    let fails = "not armed: its pre-arm checks fail, see its messages";
    assert_eq!(observe(rests, check, check, none), fails);
    assert_eq!(observe(rests, check, check, check), "not armed: its pre-arm checks pass");
    // Disabled or missing checks are not reported.
    assert_eq!(observe(rests, check, none, check), "not armed");
    assert_eq!(observe(rests, none, none, check), "not armed");
    assert_eq!(observe(armed, check, check, check), "armed");
}

/// A fix taken `time_usec` after boot or after the start of 1970.
fn fix(time_usec: u64) -> MavMessage {
    MavMessage::GPS_RAW_INT(GPS_RAW_INT_DATA {
        time_usec,
        fix_type: GpsFixType::GPS_FIX_TYPE_3D_FIX,
        satellites_visible: 12,
        ..GPS_RAW_INT_DATA::DEFAULT
    })
}

#[test]
fn a_fix_grows_old_whichever_clock_dates_it() {
    const UNIX_US: u64 = 1_800_000_000_000_000;
    for epoch_us in [0, UNIX_US] {
        let (mut vehicle, mut station) = (Sender::new(1, 1), station());
        for k in 0..100u32 {
            // One fix per second, 0.3 s old when first sent; no new one after 5 s.
            let taken_ms = 10_000 + (100 * k.min(50)) / 1000 * 1000 - 300;
            let clock = SYSTEM_TIME_DATA {
                time_boot_ms: 10_000 + 100 * k,
                time_unix_usec: UNIX_US + u64::from(10_000_000 + 100_000 * k),
            };
            let mut bytes = vehicle.attitude(10_000 + 100 * k, 0.1);
            bytes.extend(vehicle.say(&MavMessage::SYSTEM_TIME(clock)));
            bytes.extend(vehicle.say(&fix(epoch_us + 1000 * u64::from(taken_ms))));
            station.receive(&bytes, 1e9 + 0.1 * f64::from(k));
            let expected = 0.1 * f64::from(k) - 1e-3 * (f64::from(taken_ms) - 10_000.0);
            let found = newest(&station, Id::GpsAge);
            assert_abs_diff_eq!(found, expected, epsilon = 0.06);
        }
        assert_eq!(why(&station, "GPS"), "no fix for 5.2 s");
        for id in [Id::GpsFix, Id::GpsLatitude, Id::GpsVelN, Id::Satellites] {
            assert!(newest(&station, id).is_nan(), "{id:?}");
        }
        assert!(Id::GpsAge.channel().alarms(newest(&station, Id::GpsAge)));
    }
}

#[test]
fn a_fix_whose_age_nobody_reports_has_none() {
    // No time stamp; a time stamp of an unknown clock; a time stamp in the future.
    for time_usec in [0, 1_800_000_000_000_000, 60_000_000] {
        let (mut vehicle, mut station) = (Sender::new(1, 1), station());
        let mut bytes = vehicle.attitude(10_000, 0.1);
        bytes.extend(vehicle.say(&fix(time_usec)));
        station.receive(&bytes, 1e9);
        assert!(newest(&station, Id::GpsAge).is_nan(), "{time_usec}");
        assert_eq!(why(&station, "GPS"), "3D fix, 12 satellites");
    }
}

#[test]
fn a_vehicle_of_this_project_reports_the_age_of_its_fix_by_mavlink_too() {
    for utc_us in [None, Some(1_800_000_000_000_000)] {
        let mut mavlink = hovernav_fly::Mavlink::new(MavlinkConfig::default(), Time::ZERO);
        if let Some(utc_us) = utc_us {
            mavlink.set_utc(1000 * utc_us, Time::ZERO);
        }
        let mut station = station();
        for k in 0..100 {
            let time_s = 5.0 + f64::from(k) / 33.0;
            let mut bytes = Vec::new();
            mavlink.encode(&snapshot(time_s), &mut bytes);
            station.receive(&bytes, 1e9 + time_s);
        }
        let found = newest(&station, Id::GpsAge);
        assert!((found - 0.4).abs() < 0.15, "{found} s with {utc_us:?}");
    }
}
