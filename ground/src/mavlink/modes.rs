//! The names of the flight modes of other vehicles.
//!
//! Source: MAVLink, *ardupilotmega message set*, COPTER_MODE, PLANE_MODE, ROVER_MODE and SUB_MODE;
//! PX4 Autopilot, `px4_custom_mode.h`.

/// ArduPilot's number in HEARTBEAT.
const ARDUPILOT: u8 = 3;
/// PX4's number in HEARTBEAT.
const PX4: u8 = 12;

const COPTER: &[(u32, &str)] = &[
    (0, "STABILIZE"),
    (1, "ACRO"),
    (2, "ALT_HOLD"),
    (3, "AUTO"),
    (4, "GUIDED"),
    (5, "LOITER"),
    (6, "RTL"),
    (7, "CIRCLE"),
    (9, "LAND"),
    (11, "DRIFT"),
    (13, "SPORT"),
    (14, "FLIP"),
    (15, "AUTOTUNE"),
    (16, "POSHOLD"),
    (17, "BRAKE"),
    (18, "THROW"),
    (19, "AVOID_ADSB"),
    (20, "GUIDED_NOGPS"),
    (21, "SMART_RTL"),
    (22, "FLOWHOLD"),
    (23, "FOLLOW"),
    (24, "ZIGZAG"),
    (25, "SYSTEMID"),
    (26, "AUTOROTATE"),
    (27, "AUTO_RTL"),
    (28, "TURTLE"),
];
const PLANE: &[(u32, &str)] = &[
    (0, "MANUAL"),
    (1, "CIRCLE"),
    (2, "STABILIZE"),
    (3, "TRAINING"),
    (4, "ACRO"),
    (5, "FLY_BY_WIRE_A"),
    (6, "FLY_BY_WIRE_B"),
    (7, "CRUISE"),
    (8, "AUTOTUNE"),
    (10, "AUTO"),
    (11, "RTL"),
    (12, "LOITER"),
    (13, "TAKEOFF"),
    (14, "AVOID_ADSB"),
    (15, "GUIDED"),
    (16, "INITIALIZING"),
    (17, "QSTABILIZE"),
    (18, "QHOVER"),
    (19, "QLOITER"),
    (20, "QLAND"),
    (21, "QRTL"),
    (22, "QAUTOTUNE"),
    (23, "QACRO"),
    (24, "THERMAL"),
];
const ROVER: &[(u32, &str)] = &[
    (0, "MANUAL"),
    (1, "ACRO"),
    (3, "STEERING"),
    (4, "HOLD"),
    (5, "LOITER"),
    (6, "FOLLOW"),
    (7, "SIMPLE"),
    (10, "AUTO"),
    (11, "RTL"),
    (12, "SMART_RTL"),
    (15, "GUIDED"),
    (16, "INITIALIZING"),
];
const SUB: &[(u32, &str)] = &[
    (0, "STABILIZE"),
    (1, "ACRO"),
    (2, "ALT_HOLD"),
    (3, "AUTO"),
    (4, "GUIDED"),
    (7, "CIRCLE"),
    (9, "SURFACE"),
    (16, "POSHOLD"),
    (19, "MANUAL"),
];
/// Modes of PX4: the main mode in the lower 8 bits, the sub-mode above.
const OF_PX4: &[(u32, &str)] = &[
    (1, "MANUAL"),
    (2, "ALTCTL"),
    (3, "POSCTL"),
    (0x103, "ORBIT"),
    (5, "ACRO"),
    (6, "OFFBOARD"),
    (7, "STABILIZED"),
    (8, "RATTITUDE"),
    (0x104, "AUTO READY"),
    (0x204, "AUTO TAKEOFF"),
    (0x304, "AUTO LOITER"),
    (0x404, "AUTO MISSION"),
    (0x504, "AUTO RTL"),
    (0x604, "AUTO LAND"),
    (0x804, "AUTO FOLLOW"),
    (0x904, "AUTO PRECLAND"),
];

/// The name of the mode in HEARTBEAT, from the numbers of autopilot, vehicle type and mode.
pub fn name(autopilot: u8, vehicle: u8, mode: u32) -> String {
    let (table, number) = match (autopilot, vehicle) {
        (PX4, _) => (OF_PX4, mode >> 16),
        (ARDUPILOT, 1 | 19..=25) => (PLANE, mode),
        (ARDUPILOT, 10 | 11) => (ROVER, mode),
        (ARDUPILOT, 12) => (SUB, mode),
        // Helicopters, and vehicles with three or more rotors.
        (ARDUPILOT, 2..=4 | 13..=15 | 29 | 35) => (COPTER, mode),
        _ => (&[][..], mode),
    };
    match table.iter().find(|(known, _)| *known == number) {
        Some((_, name)) => (*name).to_owned(),
        None => format!("mode {mode}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_are_named_by_the_autopilot_and_the_kind_of_vehicle() {
        assert_eq!(name(ARDUPILOT, 12, 19), "MANUAL");
        assert_eq!(name(ARDUPILOT, 4, 4), "GUIDED");
        assert_eq!(name(ARDUPILOT, 1, 10), "AUTO");
        assert_eq!(name(ARDUPILOT, 7, 10), "mode 10");
        assert_eq!(name(PX4, 2, 3 << 16), "POSCTL");
        assert_eq!(name(PX4, 2, 4 << 16 | 4 << 24), "AUTO MISSION");
        assert_eq!(name(PX4, 2, u32::MAX), "mode 4294967295");
        assert_eq!(name(8, 0, 0), "mode 0");
    }
}
