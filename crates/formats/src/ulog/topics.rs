//! The topics that are read, and the fields of each.

/// A topic of PX4.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Topic {
    SensorCombined,
    VehicleImu,
    VehicleGps,
    SensorGps,
    Magnetometer,
    AirData,
    SensorBaro,
    Distance,
    Sticks,
    /// Outputs of the rate controller to the mixer, and since 2022 the topics that replace them.
    RateControls,
    Torque,
    Thrust,
    Motors,
    Attitude,
    LocalPosition,
    GlobalPosition,
    Innovations,
    InnovationVariances,
    /// Innovations and variances, in logs from before 2020.
    OldInnovations,
}

impl Topic {
    /// Number of columns, at least those of the widest topic.
    pub const WIDTH: usize = 22;

    const ALL: [Self; 19] = [
        Self::SensorCombined,
        Self::VehicleImu,
        Self::VehicleGps,
        Self::SensorGps,
        Self::Magnetometer,
        Self::AirData,
        Self::SensorBaro,
        Self::Distance,
        Self::Sticks,
        Self::RateControls,
        Self::Torque,
        Self::Thrust,
        Self::Motors,
        Self::Attitude,
        Self::LocalPosition,
        Self::GlobalPosition,
        Self::Innovations,
        Self::InnovationVariances,
        Self::OldInnovations,
    ];

    /// The topic with PX4's `name`, if it is read.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|topic| topic.name() == name)
    }

    /// PX4's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::SensorCombined => "sensor_combined",
            Self::VehicleImu => "vehicle_imu",
            Self::VehicleGps => "vehicle_gps_position",
            Self::SensorGps => "sensor_gps",
            Self::Magnetometer => "vehicle_magnetometer",
            Self::AirData => "vehicle_air_data",
            Self::SensorBaro => "sensor_baro",
            Self::Distance => "distance_sensor",
            Self::Sticks => "manual_control_setpoint",
            Self::RateControls => "actuator_controls_0",
            Self::Torque => "vehicle_torque_setpoint",
            Self::Thrust => "vehicle_thrust_setpoint",
            Self::Motors => "actuator_motors",
            Self::Attitude => "vehicle_attitude",
            Self::LocalPosition => "vehicle_local_position",
            Self::GlobalPosition => "vehicle_global_position",
            Self::Innovations => "estimator_innovations",
            Self::InnovationVariances => "estimator_innovation_variances",
            Self::OldInnovations => "ekf2_innovations",
        }
    }

    /// The fields that are read, in the order that [`super::rows`] expects.
    pub const fn columns(self) -> &'static [&'static str] {
        match self {
            Self::SensorCombined => &[
                "timestamp",
                "gyro_rad[0]",
                "gyro_rad[1]",
                "gyro_rad[2]",
                "gyro_integral_dt",
                "accelerometer_timestamp_relative",
                "accelerometer_m_s2[0]",
                "accelerometer_m_s2[1]",
                "accelerometer_m_s2[2]",
                "accelerometer_clipping",
                "gyro_clipping",
                "magnetometer_timestamp_relative",
                "magnetometer_ga[0]",
                "magnetometer_ga[1]",
                "magnetometer_ga[2]",
                "baro_timestamp_relative",
                "baro_alt_meter",
            ],
            Self::VehicleImu => &[
                "timestamp",
                "timestamp_sample",
                "delta_angle[0]",
                "delta_angle[1]",
                "delta_angle[2]",
                "delta_angle_dt",
                "delta_velocity[0]",
                "delta_velocity[1]",
                "delta_velocity[2]",
                "delta_velocity_dt",
                "delta_velocity_clipping",
                "delta_angle_clipping",
            ],
            Self::VehicleGps | Self::SensorGps => &[
                "timestamp",
                "lat",
                "lon",
                "alt",
                "alt_ellipsoid",
                "latitude_deg",
                "longitude_deg",
                "altitude_msl_m",
                "altitude_ellipsoid_m",
                "vel_n_m_s",
                "vel_e_m_s",
                "vel_d_m_s",
                "vel_ned_valid",
                "eph",
                "epv",
                "s_variance_m_s",
                "fix_type",
                "satellites_used",
                "time_utc_usec",
                "heading",
                "heading_accuracy",
            ],
            Self::Magnetometer => &[
                "timestamp",
                "timestamp_sample",
                "magnetometer_ga[0]",
                "magnetometer_ga[1]",
                "magnetometer_ga[2]",
            ],
            Self::AirData => &["timestamp", "timestamp_sample", "baro_alt_meter"],
            Self::SensorBaro => &["timestamp", "timestamp_sample", "pressure"],
            Self::Distance => &[
                "timestamp",
                "current_distance",
                "variance",
                "signal_quality",
                "orientation",
                "min_distance",
                "max_distance",
            ],
            Self::Sticks => &["timestamp", "roll", "pitch", "throttle", "yaw", "y", "x", "z", "r"],
            Self::RateControls => {
                &["timestamp", "control[0]", "control[1]", "control[2]", "control[3]"]
            }
            Self::Torque | Self::Thrust => &["timestamp", "xyz[0]", "xyz[1]", "xyz[2]"],
            Self::Motors => &[
                "timestamp",
                "control[0]",
                "control[1]",
                "control[2]",
                "control[3]",
                "control[4]",
                "control[5]",
                "control[6]",
                "control[7]",
            ],
            Self::Attitude => &["timestamp", "timestamp_sample", "q[0]", "q[1]", "q[2]", "q[3]"],
            Self::LocalPosition => &[
                "timestamp",
                "timestamp_sample",
                "ref_lat",
                "ref_lon",
                "ref_alt",
                "x",
                "y",
                "z",
                "vx",
                "vy",
                "vz",
                "xy_valid",
                "z_valid",
                "v_xy_valid",
                "v_z_valid",
                "xy_global",
                "z_global",
            ],
            Self::GlobalPosition => &[
                "timestamp",
                "timestamp_sample",
                "lat",
                "lon",
                "alt",
                "alt_ellipsoid",
                "lat_lon_valid",
                "alt_valid",
            ],
            Self::Innovations | Self::InnovationVariances => &[
                "timestamp",
                "timestamp_sample",
                "gps_hpos[0]",
                "gps_hpos[1]",
                "gps_vpos",
                "gps_hvel[0]",
                "gps_hvel[1]",
                "gps_vvel",
                "baro_vpos",
                "heading",
            ],
            Self::OldInnovations => &[
                "timestamp",
                "vel_pos_innov[3]",
                "vel_pos_innov[4]",
                "vel_pos_innov[5]",
                "vel_pos_innov[0]",
                "vel_pos_innov[1]",
                "vel_pos_innov[2]",
                "heading_innov",
                "vel_pos_innov_var[3]",
                "vel_pos_innov_var[4]",
                "vel_pos_innov_var[5]",
                "vel_pos_innov_var[0]",
                "vel_pos_innov_var[1]",
                "vel_pos_innov_var[2]",
                "heading_innov_var",
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Topic;

    #[test]
    fn no_topic_is_wider_than_a_row() {
        assert!(Topic::ALL.iter().all(|topic| topic.columns().len() <= Topic::WIDTH));
    }
}
