//! Messages about the mode of the vehicle.

use mavlink::dialects::common;

use hovernav::telemetry::{Snapshot, SystemMode};

/// First number of the vehicle's own modes. pymavlink names the smaller numbers of any helicopter by ArduCopter's
/// modes, as "AUTO" while the pilot flies.
pub const FIRST_CUSTOM_MODE: u32 = 100;

/// The number of a mode in `custom_mode`.
pub(super) fn custom_mode(mode: SystemMode) -> u32 {
    FIRST_CUSTOM_MODE + u32::from(mode.code())
}

/// The extended state. It is not known whether the vehicle is in the air.
pub(super) fn extended_state() -> common::EXTENDED_SYS_STATE_DATA {
    common::EXTENDED_SYS_STATE_DATA {
        vtol_state: common::MavVtolState::MAV_VTOL_STATE_UNDEFINED,
        landed_state: common::MavLandedState::MAV_LANDED_STATE_UNDEFINED,
    }
}

pub(super) fn current_mode(snapshot: &Snapshot) -> common::CURRENT_MODE_DATA {
    common::CURRENT_MODE_DATA {
        custom_mode: custom_mode(snapshot.mode),
        intended_custom_mode: 0,
        standard_mode: common::MavStandardMode::MAV_STANDARD_MODE_NON_STANDARD,
    }
}

pub(super) fn heartbeat(snapshot: &Snapshot) -> common::HEARTBEAT_DATA {
    use common::{MavModeFlag as Flag, MavState as State};
    let system_status = match snapshot.mode {
        SystemMode::Starting => State::MAV_STATE_BOOT,
        SystemMode::Aligning | SystemMode::SearchingHeading => State::MAV_STATE_CALIBRATING,
        SystemMode::Pilot | SystemMode::Autopilot => State::MAV_STATE_ACTIVE,
        SystemMode::Failsafe => State::MAV_STATE_CRITICAL,
    };
    let mut base_mode = Flag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
    base_mode.set(Flag::MAV_MODE_FLAG_MANUAL_INPUT_ENABLED, snapshot.status.pilot_signal);
    // Armed means that the servos are driven.
    let driven = snapshot.commanded_ms.iter().any(|(_, width_ms)| width_ms.is_some());
    base_mode.set(Flag::MAV_MODE_FLAG_SAFETY_ARMED, driven && snapshot.status.servos);
    base_mode.set(
        Flag::MAV_MODE_FLAG_STABILIZE_ENABLED | Flag::MAV_MODE_FLAG_AUTO_ENABLED,
        snapshot.mode == SystemMode::Autopilot,
    );
    common::HEARTBEAT_DATA {
        custom_mode: custom_mode(snapshot.mode),
        mavtype: common::MavType::MAV_TYPE_HELICOPTER,
        autopilot: common::MavAutopilot::MAV_AUTOPILOT_GENERIC,
        base_mode,
        system_status,
        mavlink_version: 3,
    }
}
