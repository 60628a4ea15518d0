//! Error models of the sensors in the filter, with a unit for every number.

use super::mechanisms::Mechanisms;
use super::setting::settings;

/// Settings of the filter. [`EkfConfig::default`] suits a consumer or tactical-grade MEMS IMU on a vibrating vehicle
/// and a stand-alone GPS. Set the values that you know better by name.
///
/// ```
/// use hovernav::ekf::{EkfConfig, GateConfig};
///
/// let gate = GateConfig { sigmas: 4.0, ..GateConfig::default() };
/// let config = EkfConfig { gate, ..EkfConfig::default() };
/// assert_eq!(config.gate.lockout_s, 8.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct EkfConfig {
    /// Inertial sensors.
    pub imu: ImuModel,
    /// GPS.
    pub gps: GpsModel,
    /// The inertial unit's own attitude, when used as a measurement.
    pub attitude: AttitudeModel,
    /// Magnetometer, when it is the source of heading.
    pub magnetometer: MagnetometerModel,
    /// Barometer.
    pub baro: BaroModel,
    /// Gates and recovery.
    pub gate: GateConfig,
    /// Switches of the mechanisms that the filter has beyond a textbook filter.
    pub mechanisms: Mechanisms,
}

settings! {
    /// Errors of the inertial sensors.
    ImuModel {
        /// Angle random walk, rad/√s.
        angle_random_walk_rad = 5e-4, 1e-8..=0.1 "rad/√s";
        /// Velocity random walk, m/s/√s.
        velocity_random_walk_mps = 0.05, 1e-6..=5.0 "m/s/√s";
        /// Fraction of the gyros' measured vibration that counts as white noise.
        gyro_vibration_share = 0.3, 0.0..=5.0 "";
        /// Fraction of the accelerometers' measured vibration that counts as white noise.
        accel_vibration_share = 0.1, 0.0..=5.0 "";
        /// Correlation time of the accelerometers' vibration error, s: faster sampling does not reduce rectification
        /// and aliasing.
        accel_vibration_time_s = 0.05, 0.0..=1.0 "s";
        /// One-sigma of the gyro bias, rad/s.
        gyro_bias_sigma_radps = 0.005, 1e-8..=0.35 "rad/s";
        /// Correlation time of the gyro bias, s.
        gyro_bias_time_s = 8e3, 1.0..=1e7 "s";
        /// One-sigma of the accelerometer bias, m/s².
        accel_bias_sigma_mps2 = 0.05, 1e-6..=5.0 "m/s²";
        /// Correlation time of the accelerometer bias, s.
        accel_bias_time_s = 1e4, 1.0..=1e7 "s";
        /// Gyro error about the axis of a turn, as a fraction of the turn, if the layout has no states for it. It
        /// contains scale factor error and lag. The error across the axis, by misalignment, is 2.5 times as large.
        turn_error_share = 0.0012, 0.0..=0.3 "";
        /// Time, s, for which the error of a turn keeps its sign.
        turn_error_time_s = 2.0, 0.05..=1e3 "s";
        /// One-sigma of each gyro's scale factor error, as a fraction of the net turn about its axis. Used if the
        /// layout has no states for this error.
        net_turn_error_share = 0.003, 0.0..=0.3 "";
        /// Time constant with which the filter forgets a net turn, s.
        net_turn_memory_s = 30.0, 0.5..=1e5 "s";
        /// Full scale of the gyros, rad/s. 0 if unknown: the filter then learns it.
        gyro_range_radps = 0.0, 0.17..=175.0 or 0 "rad/s";
        /// Full scale of the accelerometers, m/s². 0 if unknown: the filter then learns it.
        accel_range_mps2 = 0.0, 4.9..=2e3 or 0 "m/s²";
        /// Longest interval between samples, s, that is not a gap. A gap is bridged with a larger uncertainty.
        gap_s = 0.25, 0.05..=5.0 "s";
        /// One-sigma of the acceleration that a gap may have hidden, m/s².
        gap_acceleration_mps2 = 3.0, 0.1..=100.0 "m/s²";
        /// One-sigma of the angular rate that a gap may have hidden, rad/s.
        gap_rate_radps = 0.5, 0.01..=20.0 "rad/s";
        /// Interval of covariance propagation, s. The covariance is also propagated before each measurement. With 0, it
        /// is propagated with every sample, like the state.
        covariance_interval_s = 0.0075, 0.0..=0.1 "s";
    }
}

settings! {
    /// Errors of the GPS.
    GpsModel {
        /// One-sigma of horizontal position, each axis, used where a fix states no accuracy of its own, m.
        horizontal_sigma_m = 1.5, 0.005..=100.0 "m";
        /// One-sigma of height, used where a fix states no accuracy of its own, m.
        vertical_sigma_m = 3.0, 0.005..=200.0 "m";
        /// One-sigma of horizontal velocity, each axis, used where a fix states no accuracy of its own, m/s.
        horizontal_velocity_sigma_mps = 0.2, 0.002..=20.0 "m/s";
        /// One-sigma of vertical velocity, used where a fix states no accuracy of its own, m/s.
        vertical_velocity_sigma_mps = 0.4, 0.002..=20.0 "m/s";
        /// Minimum one-sigma of the position's white error, m: residual errors of clocks and lever arms.
        position_floor_m = 0.05, 1e-3..=50.0 "m";
        /// Minimum one-sigma of the velocity's white error, m/s.
        velocity_floor_mps = 0.03, 1e-3..=10.0 "m/s";
        /// Fraction of the position's one-sigma that varies slowly, 0 to 1. The remaining variance is white.
        position_wander_share = 0.97 to 1, 0.0..=1.0 "";
        /// Correlation time of the position's slow error, s.
        position_wander_time_s = 200.0, 1.0..=1e5 "s";
        /// Fraction of the velocity's one-sigma that varies slowly, 0 to 1. The remaining variance is white.
        velocity_wander_share = 0.45 to 1, 0.0..=1.0 "";
        /// Correlation time of the velocity's slow error, s.
        velocity_wander_time_s = 15.0, 0.1..=1e5 "s";
        /// One-sigma of the time over which a receiver averages its velocity, s. The resulting error under acceleration
        /// counts as noise.
        velocity_smoothing_s = 0.03, 0.0..=2.0 "s";
        /// Learning rate, 0 to 1: weight of one innovation in a learned GPS variance. The filter learns one-sigmas that
        /// fixes do not state, or state too small.
        learning_rate = 0.01 to 1, 0.0..=0.5 "";
        /// One-sigma of the time between a fix's position and its velocity, s.
        position_latency_sigma_s = 0.1, 0.0..=2.0 "s";
        /// One-sigma of the time by which a fix is valid earlier than declared, s.
        delay_sigma_s = 0.1, 0.0..=2.0 "s";
    }
}

settings! {
    /// Errors of an attitude reference.
    AttitudeModel {
        /// Shortest time between two updates with an attitude, s: closer samples repeat the same information.
        interval_s = 0.1, 0.0..=10.0 "s";
        /// One-sigma of the attitude's slow error in roll and pitch, rad.
        tilt_wander_rad = 0.025, 1e-4..=1.0 "rad";
        /// One-sigma of the attitude's slow error in heading, rad.
        heading_wander_rad = 0.021, 1e-4..=3.0 "rad";
        /// Correlation time of the attitude's slow error, s.
        wander_time_s = 40.0, 0.1..=1e5 "s";
        /// One-sigma of the attitude's white error, rad.
        noise_rad = 0.009, 1e-4..=1.0 "rad";
    }
}

settings! {
    /// Errors of a heading from a magnetometer.
    MagnetometerModel {
        /// Shortest time between two updates with a magnetic heading, s.
        interval_s = 0.1, 0.0..=10.0 "s";
        /// One-sigma of the magnetic heading's slow error, rad: residual hard and soft iron after calibration, and
        /// currents.
        heading_wander_rad = 0.06, 1e-4..=3.0 "rad";
        /// Correlation time of the magnetic heading's slow error, s.
        wander_time_s = 100.0, 0.1..=1e5 "s";
        /// One-sigma of the magnetic heading's white error, rad.
        noise_rad = 0.03, 1e-4..=1.5 "rad";
    }
}

settings! {
    /// Errors of a barometric height.
    BaroModel {
        /// One-sigma of the barometric height's white error, m.
        noise_m = 0.5, 0.01..=100.0 "m";
        /// One-sigma of the barometric height's slow error, m, relative to a level that is estimated from the other
        /// sensors.
        wander_m = 3.0, 0.01..=500.0 "m";
        /// Correlation time of the barometric height's slow error, s. Within half of this time the error changes by 0.9
        /// wander_m.
        wander_time_s = 300.0, 1.0..=1e6 "s";
    }
}

settings! {
    /// Errors of a distance to the ground, and variation of the ground height.
    RangeModel {
        /// Shortest distance that the sensor measures, m.
        least_m = 0.1, 0.0..=50.0 "m";
        /// Longest distance that the sensor measures, m.
        most_m = 100.0, 0.5..=1e4 "m";
        /// Minimum quality, 0 to 1, of a reading that is used.
        least_quality = 0.1 to 1, 0.0..=1.0 "";
        /// One-sigma of the distance's white error, m, used where a reading states no accuracy of its own.
        noise_m = 0.05, 1e-3..=50.0 "m";
        /// One-sigma of an additional error that grows with the distance, as a fraction of the distance.
        noise_share = 0.01, 0.0..=0.5 "";
        /// One-sigma of the change of the ground height over a metre of ground, m. It grows with the square root of the
        /// length.
        ground_walk_m = 0.1, 1e-4..=20.0 "m";
    }
}

settings! {
    /// Errors of the heading of two antennas.
    AntennaHeadingModel {
        /// Shortest time between two updates with a two-antenna heading, s.
        interval_s = 0.1, 0.0..=10.0 "s";
        /// One-sigma of the heading, used where a reading states no accuracy of its own, rad.
        sigma_rad = 0.01, 1e-4..=1.0 "rad";
        /// Minimum one-sigma of the heading, rad: residual error of the mounting of the antennas.
        floor_rad = 0.003, 1e-5..=1.0 "rad";
        /// Fraction of the heading's one-sigma that varies slowly, 0 to 1. The remaining variance is white.
        wander_share = 0.7 to 1, 0.0..=1.0 "";
        /// Correlation time of the heading's slow error, s.
        wander_time_s = 10.0, 0.1..=1e5 "s";
        /// Largest accepted difference between the reported and the mounted length of the baseline, m.
        length_tolerance_m = 0.1, 1e-3..=10.0 "m";
    }
}

settings! {
    /// Limits for the rejection of measurements, and for the reset of a filter that rejects everything.
    GateConfig {
        /// Largest accepted innovation, in one-sigmas.
        sigmas = 5.0, 2.0..=50.0 "one-sigmas";
        /// Time of rejections, s, before the filter is reset to the measurement if the filter is suspect. It is suspect
        /// after an absence, after a gap or clipping of the inertial samples, or if it was already diverging.
        recovery_s = 1.0, 0.1..=120.0 "s";
        /// Time of rejections, s, before a jumped position is accepted while the velocity still agrees. It is shorter
        /// if the previous position was reported for less time.
        fault_s = 30.0, 1.0..=600.0 "s";
        /// Time of uninterrupted rejections, s, before the filter is reset to the measurement in all other cases.
        lockout_s = 8.0, 0.5..=600.0 "s";
    }
}

impl GpsModel {
    /// One-sigma of position, north, east, down, m, used where a fix states no accuracy of its own.
    pub(crate) fn position_sigma_m(&self) -> [f64; 3] {
        [self.horizontal_sigma_m, self.horizontal_sigma_m, self.vertical_sigma_m]
    }

    /// One-sigma of velocity, north, east, down, m/s, used where a fix states no accuracy of its own.
    pub(crate) fn velocity_sigma_mps(&self) -> [f64; 3] {
        let horizontal = self.horizontal_velocity_sigma_mps;
        [horizontal, horizontal, self.vertical_velocity_sigma_mps]
    }
}
