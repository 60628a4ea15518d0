//! Ranges in flight for the numbers of sensors, alignment and additional measurements. A log may be estimated with
//! numbers outside these ranges.

use super::range::{Section, range};

/// `[navigation]`, whose keys are those of a `dataset.toml`.
pub(super) const NAVIGATION: &[Section] = &[
    (
        "navigation.imu",
        &[
            range("rate_hz", 1.0, 1e4, "Hz"),
            range("lever_arm_m", -20.0, 20.0, "m"),
            range("angle_random_walk_deg_per_sqrt_h", 1e-4, 300.0, "°/√h"),
            range("velocity_random_walk_mps_per_sqrt_h", 1e-4, 300.0, "m/s/√h"),
            range("gyro_bias_sigma_degps", 1e-6, 20.0, "°/s"),
            range("accel_bias_sigma_mps2", 1e-6, 5.0, "m/s²"),
            range("magnetic_declination_deg", -180.0, 180.0, "°"),
            range("gyro_range_degps", 10.0, 1e4, "°/s"),
            range("accel_range_g", 0.5, 200.0, "g"),
            range("mounting_deg", -360.0, 360.0, "°"),
        ],
    ),
    (
        "navigation.imu.notch",
        &[
            range("frequency_hz", 0.1, 5e3, "Hz").or_zero(),
            range("width_hz", 0.05, 1e3, "Hz"),
            range("harmonics", 1.0, 4.0, ""),
            range("least_hz", 0.0, 1e3, "Hz"),
        ],
    ),
    (
        "navigation.gps",
        &[
            range("rate_hz", 0.01, 100.0, "Hz"),
            range("antenna_lever_arm_m", -20.0, 20.0, "m"),
            range("latency_s", 0.0, 2.0, "s"),
        ],
    ),
    ("navigation.second_antenna", &[range("lever_arm_m", -20.0, 20.0, "m")]),
    (
        "navigation.rangefinder",
        &[range("lever_arm_m", -20.0, 20.0, "m"), range("beam", -1e6, 1e6, "")],
    ),
    (
        "navigation.reference",
        &[
            range("skip_s", 0.0, 1e6, "s"),
            range("position_sigma_m", 0.0, 1e3, "m"),
            range("velocity_sigma_mps", 0.0, 1e3, "m/s"),
            range("attitude_sigma_deg", 0.0, 1e3, "°"),
        ],
    ),
    (
        "navigation.alignment",
        &[
            range("duration_s", 0.1, 120.0, "s"),
            range("attitude_tilt_sigma_rad", 1e-3, 1.0, "rad"),
            range("heading_sigma_rad", 1e-3, 3.2, "rad"),
            range("level_sigma_rad", 1e-4, 1.0, "rad"),
            range("moving_level_sigma_rad", 1e-3, 1.5, "rad"),
            range("position_sigma_m", 0.01, 1e3, "m"),
            range("velocity_sigma_mps", 0.01, 50.0, "m/s"),
            range("course_speed_mps", 0.3, 50.0, "m/s"),
        ],
    ),
];
