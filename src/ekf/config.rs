//! What the filter assumes of its sensors, a unit for every number.

/// Settings of the filter. [`EkfConfig::default`] suits a consumer or tactical-grade MEMS unit on a
/// vibrating vehicle and a stand-alone GPS; what is known better goes in by name.
///
/// ```
/// use hovernav::ekf::{EkfConfig, GateConfig};
///
/// let mut gate = GateConfig::default();
/// gate.sigmas = 4.0;
/// let config = EkfConfig::default().with_gate(gate);
/// assert_eq!(config.gate.lockout_s, 8.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct EkfConfig {
    /// Inertial sensors.
    pub imu: ImuModel,
    /// GPS.
    pub gps: GpsModel,
    /// The unit's own attitude or magnetic heading, when used as an aid.
    pub attitude: AttitudeModel,
    /// Magnetometer, when it gives the heading.
    pub magnetometer: MagnetometerModel,
    /// Barometer.
    pub baro: BaroModel,
    /// Gates and recovery.
    pub gate: GateConfig,
}

impl EkfConfig {
    /// With these errors of the inertial sensors.
    #[must_use]
    pub const fn with_imu(mut self, imu: ImuModel) -> Self {
        self.imu = imu;
        self
    }

    /// With these errors of the GPS.
    #[must_use]
    pub const fn with_gps(mut self, gps: GpsModel) -> Self {
        self.gps = gps;
        self
    }

    /// With these errors of attitude and heading references.
    #[must_use]
    pub const fn with_attitude(mut self, attitude: AttitudeModel) -> Self {
        self.attitude = attitude;
        self
    }

    /// With these errors of the barometer.
    #[must_use]
    pub const fn with_baro(mut self, baro: BaroModel) -> Self {
        self.baro = baro;
        self
    }

    /// With these gates.
    #[must_use]
    pub const fn with_gate(mut self, gate: GateConfig) -> Self {
        self.gate = gate;
        self
    }
}

/// More than any setting is, in whatever unit; its square is finite in single precision too.
const MOST_SETTING: f64 = 1e9;

/// The most a setting can be, and its range in words.
macro_rules! most {
    () => {
        (MOST_SETTING, "0 to 1e9")
    };
    ($most:literal) => {
        (f64::from($most), concat!("0 to ", stringify!($most)))
    };
}

/// Declares a group of settings: each with its doc, its default and, where that is less than
/// [`MOST_SETTING`], the most it can be; all `f64`, all readable by name from a configuration file.
macro_rules! settings {
    ($(#[$group:meta])* $name:ident {
        $($(#[$field:meta])* $key:ident = $default:literal $(to $most:literal)?,)*
    }) => {
        $(#[$group])*
        ///
        /// To change some, take the default and assign to its fields.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[non_exhaustive]
        #[cfg_attr(
            feature = "serde",
            derive(serde::Deserialize, serde::Serialize),
            serde(default, deny_unknown_fields)
        )]
        pub struct $name { $($(#[$field])* pub $key: f64,)* }

        impl Default for $name {
            fn default() -> Self {
                Self { $($key: $default,)* }
            }
        }

        impl $name {
            /// The first setting that is not a number in its range, with what was found and what was
            /// expected: 0 to 1 for what says so, 0 to 1e9 for all others.
            #[must_use]
            pub fn out_of_range(&self) -> Option<(&'static str, f64, &'static str)> {
                [$((stringify!($key), self.$key, most!($($most)?))),*]
                    .into_iter()
                    .find(|(_, value, (most, _))| !(0.0..=*most).contains(value))
                    .map(|(key, value, (_, expected))| (key, value, expected))
            }
        }
    };
}

settings! {
    /// Errors of the inertial sensors.
    ImuModel {
        /// Angle random walk, rad/√s.
        angle_random_walk_rad = 5e-4,
        /// Velocity random walk, m/s/√s.
        velocity_random_walk_mps = 0.05,
        /// Share of the measured vibration of the gyros that counts as noise without memory.
        gyro_vibration_share = 0.3,
        /// Share of the measured vibration of the accelerometers that counts as noise without
        /// memory.
        accel_vibration_share = 0.1,
        /// Accelerometer samples closer than this, s, share one error by vibration: what vibration
        /// leaves behind (rectification, aliasing) does not shrink by sampling faster.
        accel_vibration_time_s = 0.05,
        /// One-sigma of the gyro bias, rad/s.
        gyro_bias_sigma_radps = 0.005,
        /// Correlation time of the gyro bias, s.
        gyro_bias_time_s = 8e3,
        /// One-sigma of the accelerometer bias, m/s².
        accel_bias_sigma_mps2 = 0.05,
        /// Correlation time of the accelerometer bias, s.
        accel_bias_time_s = 1e4,
        /// One-sigma of each gyro's scale factor error, where the layout has them.
        gyro_scale_sigma = 0.005,
        /// One-sigma of each accelerometer's scale factor error, where the layout has them.
        accel_scale_sigma = 0.005,
        /// Share of a turn by which gyros err about its axis, scale and lag together, where the layout has no states
        /// for it; those across it, by misalignment, by two and a half times as much.
        turn_error_share = 0.0012,
        /// A turn errs to one side for about this long, s.
        turn_error_time_s = 2.0,
        /// One-sigma of each gyro's scale factor error as a share of the net turn about its axis, where the layout
        /// has no states for it.
        net_turn_error_share = 0.003,
        /// A net turn is forgotten with this time constant, s.
        net_turn_memory_s = 30.0,
        /// Full scale of the gyros, rad/s; 0 where it is not known and has to be learned.
        gyro_range_radps = 0.0,
        /// Full scale of the accelerometers, m/s²; 0 where it is not known.
        accel_range_mps2 = 0.0,
        /// Intervals longer than this, s, are gaps: bridged, and paid for in uncertainty.
        gap_s = 0.25,
        /// Acceleration that a gap may have hidden, one-sigma, m/s².
        gap_acceleration_mps2 = 3.0,
        /// Angular rate that a gap may have hidden, one-sigma, rad/s.
        gap_rate_radps = 0.5,
        /// The covariance is propagated once so much time has come together, s, and before each measurement; 0 at
        /// every sample, as the state is.
        covariance_interval_s = 0.0075,
    }
}

settings! {
    /// Errors of the GPS.
    GpsModel {
        /// One-sigma of horizontal position, each axis, where a fix does not say, m.
        horizontal_sigma_m = 1.5,
        /// One-sigma of height where a fix does not say, m.
        vertical_sigma_m = 3.0,
        /// One-sigma of horizontal velocity, each axis, where a fix does not say, m/s.
        horizontal_velocity_sigma_mps = 0.2,
        /// One-sigma of vertical velocity where a fix does not say, m/s.
        vertical_velocity_sigma_mps = 0.4,
        /// Least one-sigma of the white part of position, m: what clocks and lever arms leave.
        position_floor_m = 0.05,
        /// Least one-sigma of the white part of velocity, m/s.
        velocity_floor_mps = 0.03,
        /// Share of the position's one-sigma that wanders slowly, 0 to 1; the rest, in squares, is white.
        position_wander_share = 0.97 to 1,
        /// Correlation time of the position's slow error, s.
        position_wander_time_s = 200.0,
        /// Share of the velocity's one-sigma that wanders slowly, 0 to 1.
        velocity_wander_share = 0.45 to 1,
        /// Correlation time of the velocity's slow error, s.
        velocity_wander_time_s = 15.0,
        /// Time over which a receiver may have taken its velocity, one-sigma, s: what an acceleration makes of
        /// it counts as noise.
        velocity_smoothing_s = 0.03,
        /// Where fixes state no one-sigma, or one of velocity that is too small, its size is learned from the
        /// innovations: the share by which one innovation moves it, 0 to 1.
        learning_rate = 0.01 to 1,
        /// One-sigma of the time between a fix's position and its velocity, s.
        position_latency_sigma_s = 0.1,
        /// One-sigma of the time by which a fix holds earlier than declared, s.
        delay_sigma_s = 0.1,
    }
}

settings! {
    /// Errors of an attitude reference.
    AttitudeModel {
        /// Shortest time between two uses, s: samples closer than this tell the same thing twice.
        interval_s = 0.1,
        /// One-sigma of its slow error in roll and pitch, rad.
        tilt_wander_rad = 0.025,
        /// One-sigma of its slow error in heading, rad.
        heading_wander_rad = 0.021,
        /// Correlation time of its slow error, s.
        wander_time_s = 40.0,
        /// One-sigma of its white error, rad.
        noise_rad = 0.009,
    }
}

settings! {
    /// Errors of a heading from a magnetometer.
    MagnetometerModel {
        /// Shortest time between two uses, s.
        interval_s = 0.1,
        /// One-sigma of its slow error, rad: hard and soft iron left after calibration, currents.
        heading_wander_rad = 0.06,
        /// Correlation time of its slow error, s.
        wander_time_s = 100.0,
        /// One-sigma of its white error, rad.
        noise_rad = 0.03,
    }
}

settings! {
    /// Errors of a barometric height.
    BaroModel {
        /// One-sigma of its white error, m.
        noise_m = 0.5,
        /// One-sigma of its slow error, m, about a level that is found from the other sensors.
        wander_m = 3.0,
        /// Correlation time of its slow error, s: in half of it, it changes by 0.9 wander_m.
        wander_time_s = 300.0,
    }
}

settings! {
    /// Errors of a distance to the ground, and of the ground.
    RangeModel {
        /// Shortest distance that the sensor measures, m.
        least_m = 0.1,
        /// Longest distance that the sensor measures, m.
        most_m = 100.0,
        /// Readings below this quality, 0 to 1, are not used.
        least_quality = 0.1 to 1,
        /// One-sigma of its white error where a reading does not say, m.
        noise_m = 0.05,
        /// Share of the distance that adds to it.
        noise_share = 0.01,
        /// One-sigma by which the ground rises or falls over a metre, m; over more it grows with the
        /// square root of the way.
        ground_walk_m = 0.1,
    }
}

settings! {
    /// Errors of the heading of two antennas.
    AntennaHeadingModel {
        /// Shortest time between two uses, s.
        interval_s = 0.1,
        /// One-sigma where a reading does not say, rad.
        sigma_rad = 0.01,
        /// Least one-sigma, rad: what the mounting of the antennas leaves.
        floor_rad = 0.003,
        /// Share of the one-sigma that wanders slowly, 0 to 1; the rest, in squares, is white.
        wander_share = 0.7 to 1,
        /// Correlation time of what wanders, s.
        wander_time_s = 10.0,
        /// A baseline that differs by more than this from the one that is mounted, m, is refused.
        length_tolerance_m = 0.1,
    }
}

settings! {
    /// When a measurement is refused, and when a filter that refuses everything is reopened.
    GateConfig {
        /// Innovations beyond this many one-sigma are refused.
        sigmas = 5.0,
        /// Refused after an absence, after trouble with the inertial samples or in a filter that was
        /// diverging already, s: then the filter is reopened.
        recovery_s = 1.0,
        /// Positions refused that jumped while velocity goes on agreeing, s: then they are believed, sooner where the
        /// position before was told for less.
        fault_s = 30.0,
        /// Anything else refused without a break, s: then the filter is reopened.
        lockout_s = 8.0,
    }
}

impl GpsModel {
    /// One-sigma of position where a fix does not say, north, east, down, m.
    pub(crate) fn position_sigma_m(&self) -> [f64; 3] {
        [self.horizontal_sigma_m, self.horizontal_sigma_m, self.vertical_sigma_m]
    }

    /// One-sigma of velocity where a fix does not say, north, east, down, m/s.
    pub(crate) fn velocity_sigma_mps(&self) -> [f64; 3] {
        let horizontal = self.horizontal_velocity_sigma_mps;
        [horizontal, horizontal, self.vertical_velocity_sigma_mps]
    }
}
