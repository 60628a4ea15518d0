//! Ranges of the numbers of a flight's devices, servos and autopilot, wide enough for any hardware.

use super::range::{Range, Section, range};

const BAUD: Range = range("baud", 300.0, 4e6, "baud");

/// Ranges of the devices, their lines, and the servos. `*` matches any key.
pub(super) const DEVICES: &[Section] = &[
    ("", &[range("realtime_priority", 1.0, 99.0, "")]),
    ("dmu", &[BAUD, range("rate_hz", 20.0, 70.0, "Hz"), range("latency_s", 0.0, 0.1, "s")]),
    (
        "receiver",
        &[BAUD, range("rate_hz", 0.0, 25.0, "Hz"), range("geoid_separation_m", -120.0, 100.0, "m")],
    ),
    (
        "receiver.limits",
        &[
            range("min_satellites", 0.0, 50.0, ""),
            range("max_position_dilution", 1.0, 99.0, ""),
            range("max_horizontal_dilution", 0.5, 99.0, ""),
            range("max_horizontal_sigma_m", 0.01, 1e3, "m"),
            range("max_vertical_sigma_m", 0.1, 1e3, "m"),
            range("max_velocity_sigma_mps", 0.05, 100.0, "m/s"),
            range("max_ground_speed_mps", 1.0, 500.0, "m/s"),
            range("max_vertical_speed_mps", 1.0, 500.0, "m/s"),
            range("max_jump_m", 1.0, 1e4, "m"),
            range("max_delay_s", 0.01, 10.0, "s"),
        ],
    ),
    (
        "site",
        &[
            range("latitude_deg", -90.0, 90.0, "°"),
            range("longitude_deg", -180.0, 360.0, "°"),
            range("height_m", -500.0, 9e3, "m"),
        ],
    ),
    ("servo", &[range("hold_s", 0.0, 10.0, "s")]),
    (
        "servo.signal",
        &[range("stale_after_s", 0.02, 2.0, "s"), range("failsafe_throttle_ms", 0.0, 2.5, "ms")],
    ),
    ("servo.capture.serial", &[BAUD]),
    ("servo.capture.gpio", &[range("aux", 0.0, 1023.0, "")]),
    ("servo.capture.gpio.lines", &[range("*", 0.0, 1023.0, "")]),
    ("servo.output.*", &[range("chip", 0.0, 255.0, ""), range("output", 0.0, 255.0, "")]),
    ("servo.stream", &[BAUD]),
    (
        "servo.channels.*",
        &[
            range("trim_ms", 0.5, 2.5, "ms"),
            range("min_ms", 0.5, 2.5, "ms"),
            range("max_ms", 0.5, 2.5, "ms"),
            range("travel_ms", 0.05, 2.0, "ms"),
            range("failsafe_ms", 0.5, 2.5, "ms"),
            range("rate_limit_ms_per_s", 0.1, 1e3, "ms/s"),
        ],
    ),
    (
        "servo.swashplate",
        &[
            range("phase_deg", -45.0, 45.0, "°"),
            range("lateral", -1.0, 1.0, ""),
            range("longitudinal", -1.0, 1.0, ""),
            range("collective", -1.0, 1.0, ""),
            range("lowest_collective", -1.0, -0.05, ""),
            range("highest_collective", 0.05, 1.0, ""),
        ],
    ),
    ("telemetry", &[BAUD]),
    ("mavlink", &[BAUD]),
    (
        "mavlink.speaker",
        &[
            range("system_id", 1.0, 255.0, ""),
            range("component_id", 1.0, 255.0, ""),
            range("gate_sigmas", 0.1, 1e3, "one-sigmas"),
        ],
    ),
    ("mavlink.speaker.rates", &[range("*", 0.01, 1e3, "Hz").or_zero()]),
];

/// Ranges of `[autopilot]` and of the autopilot's file, whose keys are below `flown` once the file is loaded.
pub(super) const AUTOPILOT: &[Section] = &[
    ("autopilot", &[range("override_travel", 0.01, 1.0, "of full stick")]),
    (
        "autopilot.switch",
        &[
            range("threshold_ms", 0.5, 2.5, "ms"),
            range("hysteresis_ms", 0.0, 0.5, "ms"),
            range("pulses", 1.0, 100.0, ""),
        ],
    ),
    (
        "autopilot.ready",
        &[
            range("estimate_age_s", 0.02, 1.0, "s"),
            range("tilt_sigma_rad", 0.005, 0.5, "rad"),
            range("heading_sigma_rad", 0.01, 1.6, "rad"),
            range("velocity_sigma_mps", 0.02, 5.0, "m/s"),
            range("vertical_velocity_sigma_mps", 0.02, 5.0, "m/s"),
            range("position_sigma_m", 0.02, 50.0, "m"),
            range("fix_age_s", 0.1, 10.0, "s"),
            range("speed_mps", 0.1, 20.0, "m/s"),
            range("rate_radps", 0.05, 5.0, "rad/s"),
            range("level_rad", 0.02, 1.0, "rad"),
            range("stick", 0.02, 2.0, "of full stick"),
            range("period", 0.001, 0.2, "of the period"),
            range("gyro_bias_sigma_radps", 1e-5, 0.1, "rad/s"),
        ],
    ),
    (
        "autopilot.steering",
        &[
            range("dead_band", 0.01, 0.5, "of full stick"),
            range("full_stick", 0.06, 1.0, "of full stick"),
            range("speed_mps", 0.1, 10.0, "m/s"),
            range("climb_mps", 0.1, 3.0, "m/s"),
            range("yaw_rate_radps", 0.05, 2.0, "rad/s"),
        ],
    ),
    ("autopilot.steering.signs", &[range("*", -1.0, 1.0, "")]),
    (
        "autopilot.failsafe",
        &[
            range("pilot_lost_hold_s", 0.0, 600.0, "s"),
            range("descent_mps", 0.1, 2.0, "m/s"),
            range("late_cycles", 1.0, 100.0, "cycles"),
            range("saturation_s", 0.1, 60.0, "s"),
        ],
    ),
    ("autopilot.geofence", &[range("radius_m", 5.0, 1e4, "m"), range("height_m", 5.0, 1e3, "m")]),
    (
        "autopilot.excitation",
        &[
            range("first_s", 2.0, 600.0, "s"),
            range("pause_s", 1.0, 600.0, "s"),
            range("dead_band", 0.01, 0.5, "of full stick"),
            range("stick_rate_per_s", 0.1, 50.0, "full travels a second"),
            range("tilt_rad", 0.02, 0.8, "rad"),
            range("rate_radps", 0.05, 10.0, "rad/s"),
            range("speed_mps", 0.2, 20.0, "m/s"),
        ],
    ),
    (
        "autopilot.excitation.inputs",
        &[
            range("amplitude", -0.5, 0.5, "of full stick"),
            range("length_s", 0.05, 300.0, "s"),
            range("first_hz", 0.01, 20.0, "Hz"),
            range("last_hz", 0.01, 20.0, "Hz"),
            range("times", 1.0, 16.0, ""),
        ],
    ),
    ("autopilot.flown", &[range("period_s", 0.001, 0.2, "s")]),
    (
        "autopilot.flown.trim",
        &[range("roll_rad", -0.5, 0.5, "rad"), range("pitch_rad", -0.5, 0.5, "rad")],
    ),
    ("autopilot.flown.trim.sticks", &[range("*", -1.0, 1.0, "")]),
    ("autopilot.flown.limits.lowest", &[range("*", -1.0, 0.0, "")]),
    ("autopilot.flown.limits.highest", &[range("*", 0.0, 1.0, "")]),
    ("autopilot.flown.limits.rate_per_s", &[range("*", 0.05, 1e3, "full travels a second")]),
    (
        "autopilot.flown.guidance",
        &[
            range("position_gain_per_s", 0.01, 2.0, "1/s"),
            range("height_gain_per_s", 0.01, 2.0, "1/s"),
            range("speed_mps", 0.1, 15.0, "m/s"),
            range("climb_mps", 0.1, 5.0, "m/s"),
            range("acceleration_mps2", 0.05, 5.0, "m/s²"),
            range("climb_acceleration_mps2", 0.05, 5.0, "m/s²"),
            range("yaw_rate_radps", 0.01, 3.0, "rad/s"),
        ],
    ),
    (
        "autopilot.flown.health",
        &[
            range("tilt_sigma_rad", 0.005, 1.0, "rad"),
            range("heading_sigma_rad", 0.01, 3.2, "rad"),
            range("velocity_sigma_mps", 0.02, 20.0, "m/s"),
            range("vertical_velocity_sigma_mps", 0.02, 20.0, "m/s"),
            range("position_sigma_m", 0.02, 200.0, "m"),
            range("age_s", 0.02, 2.0, "s"),
            range("dead_reckoning_s", 0.1, 120.0, "s"),
            range("disagreement_s", 0.1, 120.0, "s"),
            range("recovery_s", 0.0, 120.0, "s"),
        ],
    ),
    (
        "autopilot.flown.transfer",
        &[
            range("fade_s", 0.05, 60.0, "s"),
            range("hand_back_s", 0.02, 10.0, "s"),
            range("neutral_s", 0.05, 60.0, "s"),
            range("override_travel", 0.01, 1.0, "of full stick"),
            range("patience_s", 0.0, 600.0, "s"),
            range("descent_mps", 0.1, 3.0, "m/s"),
            range("descent_collective", 0.005, 0.5, "of full stick"),
            range("trim_s", 0.1, 1e4, "s"),
        ],
    ),
    ("autopilot.flown.gains", &[range("pedal_per_collective", -10.0, 10.0, "")]),
    ("autopilot.flown.gains.heave", GAINS),
    ("autopilot.flown.gains.yaw", GAINS),
    ("autopilot.flown.gains.roll_pitch", GAINS),
    ("autopilot.flown.gains.attitude", GAINS),
];

/// Ranges of the gains. At the end of its range, a gain commands full stick for an error of a hundredth of a rad, m/s
/// or rad/s.
const GAINS: &[Range] = &[
    range("derivative_filter_s", 0.0, 100.0, "s"),
    range("tracking_time_s", 0.01, 1e6, "s"),
    range("hidden_from_hidden", -1e3, 1e3, ""),
    range("hidden_from_measured", -1e3, 1e3, ""),
    range("hidden_from_pending", -1e3, 1e3, ""),
    range("*", -100.0, 100.0, "full sticks per unit of feedback"),
];
