//! What the filter assumes of its sensors, a unit for every number.

use crate::frames::{Body, Vector};

/// Settings of the filter. [`EkfConfig::default`] suits a consumer or tactical-grade MEMS unit on a
/// vibrating vehicle and a stand-alone GPS; what is known better goes in by name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EkfConfig {
    /// The inertial unit from the point of the solution, body axes, m.
    pub imu_lever_arm_m: Vector<Body>,
    /// The GPS antenna from the same point, body axes, m.
    pub antenna_lever_arm_m: Vector<Body>,
    /// Inertial sensors.
    pub imu: ImuModel,
    /// GPS.
    pub gps: GpsModel,
    /// The unit's own attitude or magnetic heading, when used as an aid.
    pub attitude: AttitudeModel,
    /// Barometer.
    pub baro: BaroModel,
    /// Gates and recovery.
    pub gate: GateConfig,
}

/// Errors of the inertial sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuModel {
    /// Angle random walk, rad/√s.
    pub angle_random_walk_rad: f64,
    /// Velocity random walk, m/s/√s.
    pub velocity_random_walk_mps: f64,
    /// Share of the measured vibration of the gyros that counts as noise without memory.
    pub gyro_vibration_share: f64,
    /// Share of the measured vibration of the accelerometers that counts as noise without memory.
    pub accel_vibration_share: f64,
    /// One-sigma of the gyro bias, rad/s.
    pub gyro_bias_sigma_radps: f64,
    /// Correlation time of the gyro bias, s.
    pub gyro_bias_time_s: f64,
    /// One-sigma of the accelerometer bias, m/s².
    pub accel_bias_sigma_mps2: f64,
    /// Correlation time of the accelerometer bias, s.
    pub accel_bias_time_s: f64,
    /// One-sigma of each scale factor error, where the layout has them.
    pub scale_sigma: f64,
    /// Intervals longer than this, s, are gaps: bridged, and paid for in uncertainty.
    pub gap_s: f64,
    /// Acceleration that a gap may have hidden, one-sigma, m/s².
    pub gap_acceleration_mps2: f64,
    /// Angular rate that a gap may have hidden, one-sigma, rad/s.
    pub gap_rate_radps: f64,
}

/// Errors of the GPS.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GpsModel {
    /// One-sigma of position where a fix does not say, horizontal and down, m.
    pub position_sigma_m: [f64; 2],
    /// One-sigma of velocity where a fix does not say, horizontal and down, m/s.
    pub velocity_sigma_mps: [f64; 2],
    /// Least one-sigma of position believed, m.
    pub position_floor_m: f64,
    /// Least one-sigma of velocity believed, m/s.
    pub velocity_floor_mps: f64,
    /// Share of the position's one-sigma that wanders slowly; the rest, in squares, is white.
    pub position_wander_share: f64,
    /// Correlation time of the position's slow error, s.
    pub position_wander_time_s: f64,
    /// Share of the velocity's one-sigma that wanders slowly.
    pub velocity_wander_share: f64,
    /// Correlation time of the velocity's slow error, s.
    pub velocity_wander_time_s: f64,
    /// One-sigma of the latency left after what the dataset states, s.
    pub latency_sigma_s: f64,
}

/// Errors of an attitude reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttitudeModel {
    /// Shortest time between two uses, s: samples closer than this tell the same thing twice.
    pub interval_s: f64,
    /// One-sigma of its slow error in roll and pitch, rad.
    pub tilt_wander_rad: f64,
    /// One-sigma of its slow error in heading, rad.
    pub heading_wander_rad: f64,
    /// Correlation time of its slow error, s.
    pub wander_time_s: f64,
    /// One-sigma of its white error, rad.
    pub noise_rad: f64,
}

/// Errors of a barometric height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaroModel {
    /// One-sigma of its white error, m.
    pub noise_m: f64,
    /// One-sigma of its slow error, m, after the offset found at its first use.
    pub wander_m: f64,
    /// Correlation time of its slow error, s.
    pub wander_time_s: f64,
}

/// When a measurement is refused, and when a filter that refuses everything is reopened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GateConfig {
    /// Innovations beyond this many one-sigma are refused.
    pub sigmas: f64,
    /// After this long, s, of refusing everything of one kind, the filter concludes that the error is
    /// its own and reopens.
    pub lockout_s: f64,
}

impl Default for EkfConfig {
    fn default() -> Self {
        Self {
            imu_lever_arm_m: Vector::ZERO,
            antenna_lever_arm_m: Vector::ZERO,
            imu: ImuModel {
                angle_random_walk_rad: 5e-4,
                velocity_random_walk_mps: 0.02,
                gyro_vibration_share: 0.3,
                accel_vibration_share: 0.2,
                gyro_bias_sigma_radps: 0.005,
                gyro_bias_time_s: 1000.0,
                accel_bias_sigma_mps2: 0.15,
                accel_bias_time_s: 1000.0,
                scale_sigma: 0.01,
                gap_s: 0.25,
                gap_acceleration_mps2: 3.0,
                gap_rate_radps: 0.5,
            },
            gps: GpsModel {
                position_sigma_m: [1.5, 3.0],
                velocity_sigma_mps: [0.2, 0.4],
                position_floor_m: 0.02,
                velocity_floor_mps: 0.03,
                position_wander_share: 0.9,
                position_wander_time_s: 100.0,
                velocity_wander_share: 0.5,
                velocity_wander_time_s: 3.0,
                latency_sigma_s: 0.05,
            },
            attitude: AttitudeModel {
                interval_s: 0.1,
                tilt_wander_rad: 1f64.to_radians(),
                heading_wander_rad: 2f64.to_radians(),
                wander_time_s: 60.0,
                noise_rad: 0.5f64.to_radians(),
            },
            baro: BaroModel { noise_m: 0.5, wander_m: 3.0, wander_time_s: 300.0 },
            gate: GateConfig { sigmas: 5.0, lockout_s: 8.0 },
        }
    }
}
