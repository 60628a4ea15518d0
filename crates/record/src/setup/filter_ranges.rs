//! Ranges of the numbers of sensors, alignment, aids and filter in flight. A log may be estimated with others.

use super::range::{Section, range};

/// Unit and remark for bias times: the filter would stop estimating a bias that never changes.
const BIAS_TIME: &str = "s; write 10000000 for a bias that hardly changes";

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
        "navigation.second_antenna.model",
        &[
            range("interval_s", 0.0, 10.0, "s"),
            range("sigma_rad", 1e-4, 1.0, "rad"),
            range("floor_rad", 1e-5, 1.0, "rad"),
            range("wander_share", 0.0, 1.0, ""),
            range("wander_time_s", 0.1, 1e5, "s"),
            range("length_tolerance_m", 1e-3, 10.0, "m"),
        ],
    ),
    (
        "navigation.rangefinder",
        &[range("lever_arm_m", -20.0, 20.0, "m"), range("beam", -1e6, 1e6, "")],
    ),
    (
        "navigation.rangefinder.model",
        &[
            range("least_m", 0.0, 50.0, "m"),
            range("most_m", 0.5, 1e4, "m"),
            range("least_quality", 0.0, 1.0, ""),
            range("noise_m", 1e-3, 50.0, "m"),
            range("noise_share", 0.0, 0.5, ""),
            range("ground_walk_m", 1e-4, 20.0, "m"),
        ],
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
    (
        "navigation.filter.imu",
        &[
            range("angle_random_walk_rad", 1e-8, 0.1, "rad/√s"),
            range("velocity_random_walk_mps", 1e-6, 5.0, "m/s/√s"),
            range("gyro_vibration_share", 0.0, 5.0, ""),
            range("accel_vibration_share", 0.0, 5.0, ""),
            range("accel_vibration_time_s", 0.0, 1.0, "s"),
            range("gyro_bias_sigma_radps", 1e-8, 0.35, "rad/s"),
            range("gyro_bias_time_s", 1.0, 1e7, BIAS_TIME),
            range("accel_bias_sigma_mps2", 1e-6, 5.0, "m/s²"),
            range("accel_bias_time_s", 1.0, 1e7, BIAS_TIME),
            range("gyro_scale_sigma", 0.0, 0.3, ""),
            range("accel_scale_sigma", 0.0, 0.3, ""),
            range("turn_error_share", 0.0, 0.3, ""),
            range("turn_error_time_s", 0.05, 1e3, "s"),
            range("net_turn_error_share", 0.0, 0.3, ""),
            range("net_turn_memory_s", 0.5, 1e5, "s"),
            range("gyro_range_radps", 0.17, 175.0, "rad/s").or_zero(),
            range("accel_range_mps2", 4.9, 2e3, "m/s²").or_zero(),
            range("gap_s", 0.05, 5.0, "s"),
            range("gap_acceleration_mps2", 0.1, 100.0, "m/s²"),
            range("gap_rate_radps", 0.01, 20.0, "rad/s"),
            range("covariance_interval_s", 0.0, 0.1, "s"),
        ],
    ),
    (
        "navigation.filter.gps",
        &[
            range("horizontal_sigma_m", 0.005, 100.0, "m"),
            range("vertical_sigma_m", 0.005, 200.0, "m"),
            range("horizontal_velocity_sigma_mps", 0.002, 20.0, "m/s"),
            range("vertical_velocity_sigma_mps", 0.002, 20.0, "m/s"),
            range("position_floor_m", 1e-3, 50.0, "m"),
            range("velocity_floor_mps", 1e-3, 10.0, "m/s"),
            range("position_wander_share", 0.0, 1.0, ""),
            range("position_wander_time_s", 1.0, 1e5, "s"),
            range("velocity_wander_share", 0.0, 1.0, ""),
            range("velocity_wander_time_s", 0.1, 1e5, "s"),
            range("velocity_smoothing_s", 0.0, 2.0, "s"),
            range("learning_rate", 0.0, 0.5, ""),
            range("position_latency_sigma_s", 0.0, 2.0, "s"),
            range("delay_sigma_s", 0.0, 2.0, "s"),
        ],
    ),
    (
        "navigation.filter.attitude",
        &[
            range("interval_s", 0.0, 10.0, "s"),
            range("tilt_wander_rad", 1e-4, 1.0, "rad"),
            range("heading_wander_rad", 1e-4, 3.0, "rad"),
            range("wander_time_s", 0.1, 1e5, "s"),
            range("noise_rad", 1e-4, 1.0, "rad"),
        ],
    ),
    (
        "navigation.filter.magnetometer",
        &[
            range("interval_s", 0.0, 10.0, "s"),
            range("heading_wander_rad", 1e-4, 3.0, "rad"),
            range("wander_time_s", 0.1, 1e5, "s"),
            range("noise_rad", 1e-4, 1.5, "rad"),
        ],
    ),
    (
        "navigation.filter.baro",
        &[
            range("noise_m", 0.01, 100.0, "m"),
            range("wander_m", 0.01, 500.0, "m"),
            range("wander_time_s", 1.0, 1e6, "s"),
        ],
    ),
    (
        "navigation.filter.gate",
        &[
            range("sigmas", 2.0, 50.0, "one-sigmas"),
            range("recovery_s", 0.1, 120.0, "s"),
            range("fault_s", 1.0, 600.0, "s"),
            range("lockout_s", 0.5, 600.0, "s"),
        ],
    ),
];
