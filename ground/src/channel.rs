//! The channels of telemetry, with units and ranges.

/// A channel: one number over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// Name in records, files and requests; it ends with the unit.
    pub name: &'static str,
    /// Label for users.
    pub label: &'static str,
    /// Unit; empty for plain numbers.
    pub unit: &'static str,
    /// Group of channels.
    pub group: &'static str,
    /// Number of significant decimals.
    pub digits: u8,
    /// Smallest and largest possible value. Values outside are rejected.
    pub range: (f64, f64),
    /// Limits of the alarm: below the first or above the second value.
    pub alarm: (f64, f64),
    /// The channel that contains the one-sigma of this channel.
    pub sigma: Option<Id>,
}

impl Channel {
    /// `value` rounded to the significant decimals; NaN if it is impossible or missing.
    #[must_use]
    pub fn plausible(&self, value: Option<f64>) -> f64 {
        let scale = 10f64.powi(i32::from(self.digits));
        match value {
            Some(value) if (self.range.0..=self.range.1).contains(&value) => {
                (value * scale).round() / scale
            }
            _ => f64::NAN,
        }
    }

    /// Whether `value` is outside the alarm limits.
    #[must_use]
    pub fn alarms(&self, value: f64) -> bool {
        value < self.alarm.0 || value > self.alarm.1
    }
}

const NEVER: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

macro_rules! channels {
    ($($group:literal { $($id:ident $name:literal $label:literal $unit:literal $digits:literal
        $low:literal $high:literal $(alarm $below:literal $above:literal)? $(sigma $sigma:ident)?;)* })*) => {
        /// The number of a channel: its index in [`CHANNELS`].
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[allow(missing_docs, reason = "`CHANNELS` describes each channel")]
        #[repr(u16)]
        pub enum Id { $($($id,)*)* }

        /// All channels, in the order of [`Id`].
        pub const CHANNELS: &[Channel] = &[$($(Channel {
            name: $name, label: $label, unit: $unit, group: $group, digits: $digits,
            range: ($low as f64, $high as f64),
            alarm: channels!(@alarm $($below $above)?),
            sigma: channels!(@sigma $($sigma)?),
        },)*)*];

        const IDS: &[Id] = &[$($(Id::$id,)*)*];
    };
    (@alarm) => { NEVER };
    (@alarm $below:literal $above:literal) => { ($below as f64, $above as f64) };
    (@sigma) => { None };
    (@sigma $sigma:ident) => { Some(Id::$sigma) };
}

channels! {
    "Angular rate" {
        RateP "p_degps" "Roll rate p" "°/s" 2 -1000 1000;
        RateQ "q_degps" "Pitch rate q" "°/s" 2 -1000 1000;
        RateR "r_degps" "Yaw rate r" "°/s" 2 -1000 1000;
    }
    "Attitude" {
        Roll "roll_deg" "Roll" "°" 2 -180 180 alarm -45 45 sigma SigmaTilt;
        Pitch "pitch_deg" "Pitch" "°" 2 -90 90 alarm -45 45 sigma SigmaTilt;
        Yaw "yaw_deg" "Heading" "°" 2 -180 180 sigma SigmaHeading;
    }
    "Acceleration" {
        AccelX "accel_x_g" "Specific force x" "g" 4 -50 50;
        AccelY "accel_y_g" "Specific force y" "g" 4 -50 50;
        AccelZ "accel_z_g" "Specific force z" "g" 4 -50 50;
    }
    "Magnetic field" {
        MagX "mag_x_gauss" "Magnetic field x" "gauss" 4 -4 4;
        MagY "mag_y_gauss" "Magnetic field y" "gauss" 4 -4 4;
        MagZ "mag_z_gauss" "Magnetic field z" "gauss" 4 -4 4;
        Temperature "temp_degc" "Temperature" "°C" 2 -80 150 alarm -40 70;
    }
    "Pilot PWM" {
        PilotThrottle "pilot_throttle_ms" "Pilot throttle" "ms" 4 0 4;
        PilotCollective "pilot_collective_ms" "Pilot collective" "ms" 4 0 4;
        PilotLongitudinal "pilot_longitudinal_ms" "Pilot longitudinal" "ms" 4 0 4;
        PilotLateral "pilot_lateral_ms" "Pilot lateral" "ms" 4 0 4;
        PilotPedal "pilot_pedal_ms" "Pilot pedal" "ms" 4 0 4;
        Aux "aux_ms" "Aux switch" "ms" 4 0 4;
    }
    "Servo PWM" {
        ServoThrottle "servo_throttle_ms" "Servo throttle" "ms" 4 0 4;
        ServoCollective "servo_collective_ms" "Servo collective" "ms" 4 0 4;
        ServoLongitudinal "servo_longitudinal_ms" "Servo longitudinal" "ms" 4 0 4;
        ServoLateral "servo_lateral_ms" "Servo lateral" "ms" 4 0 4;
        ServoPedal "servo_pedal_ms" "Servo pedal" "ms" 4 0 4;
    }
    "Sticks" {
        StickLateral "stick_lateral_pct" "Pilot's stick, lateral" "%" 2 -400 400;
        StickLongitudinal "stick_longitudinal_pct" "Pilot's stick, longitudinal" "%" 2 -400 400;
        StickCollective "stick_collective_pct" "Pilot's stick, collective" "%" 2 -400 400;
        StickPedal "stick_pedal_pct" "Pilot's stick, pedal" "%" 2 -400 400;
        FlownLateral "flown_lateral_pct" "Flown, lateral" "%" 2 -400 400;
        FlownLongitudinal "flown_longitudinal_pct" "Flown, longitudinal" "%" 2 -400 400;
        FlownCollective "flown_collective_pct" "Flown, collective" "%" 2 -400 400;
        FlownPedal "flown_pedal_pct" "Flown, pedal" "%" 2 -400 400;
    }
    "Position" {
        Latitude "lat_deg" "Latitude" "°" 8 -90 90;
        Longitude "lon_deg" "Longitude" "°" 8 -180 180;
        Height "height_m" "Height above ellipsoid" "m" 3 -1000 50000 sigma SigmaVertical;
        Altitude "altitude_m" "Altitude above sea level" "m" 3 -1000 50000 sigma SigmaVertical;
        AboveHome "above_home_m" "Height above home" "m" 3 -50000 50000 sigma SigmaVertical;
    }
    "Velocity" {
        VelE "vel_e_mps" "VelE, east" "m/s" 3 -400 400 sigma SigmaVelHorizontal;
        VelN "vel_n_mps" "VelN, north" "m/s" 3 -400 400 sigma SigmaVelHorizontal;
        VelU "vel_u_mps" "VelU, up" "m/s" 3 -400 400 sigma SigmaVelVertical;
        BodyU "u_mps" "u, forward" "m/s" 3 -400 400 sigma SigmaVelHorizontal;
        BodyV "v_mps" "v, right" "m/s" 3 -400 400 sigma SigmaVelHorizontal;
        BodyW "w_mps" "w, down" "m/s" 3 -400 400 sigma SigmaVelVertical;
    }
    "One-sigma" {
        SigmaHorizontal "sigma_horizontal_m" "Position, horizontal" "m" 2 0 100000 alarm 0 8;
        SigmaVertical "sigma_vertical_m" "Position, vertical" "m" 2 0 100000 alarm 0 8;
        SigmaVelHorizontal "sigma_vel_horizontal_mps" "Velocity, horizontal" "m/s" 3 0 1000 alarm 0 0.8;
        SigmaVelVertical "sigma_vel_vertical_mps" "Velocity, vertical" "m/s" 3 0 1000 alarm 0 1;
        SigmaTilt "sigma_tilt_deg" "Roll and pitch" "°" 3 0 360 alarm 0 6.9;
        SigmaHeading "sigma_heading_deg" "Heading" "°" 2 0 360 alarm 0 20;
    }
    "Biases" {
        GyroBiasX "gyro_bias_x_degps" "Gyro bias x" "°/s" 4 -20 20 sigma GyroBiasSigmaX;
        GyroBiasY "gyro_bias_y_degps" "Gyro bias y" "°/s" 4 -20 20 sigma GyroBiasSigmaY;
        GyroBiasZ "gyro_bias_z_degps" "Gyro bias z" "°/s" 4 -20 20 sigma GyroBiasSigmaZ;
        AccelBiasX "accel_bias_x_g" "Accelerometer bias x" "g" 5 -4 4 sigma AccelBiasSigmaX;
        AccelBiasY "accel_bias_y_g" "Accelerometer bias y" "g" 5 -4 4 sigma AccelBiasSigmaY;
        AccelBiasZ "accel_bias_z_g" "Accelerometer bias z" "g" 5 -4 4 sigma AccelBiasSigmaZ;
        GyroBiasSigmaX "gyro_bias_sigma_x_degps" "Gyro bias x, one-sigma" "°/s" 4 0 50;
        GyroBiasSigmaY "gyro_bias_sigma_y_degps" "Gyro bias y, one-sigma" "°/s" 4 0 50;
        GyroBiasSigmaZ "gyro_bias_sigma_z_degps" "Gyro bias z, one-sigma" "°/s" 4 0 50;
        AccelBiasSigmaX "accel_bias_sigma_x_g" "Accelerometer bias x, one-sigma" "g" 5 0 10;
        AccelBiasSigmaY "accel_bias_sigma_y_g" "Accelerometer bias y, one-sigma" "g" 5 0 10;
        AccelBiasSigmaZ "accel_bias_sigma_z_g" "Accelerometer bias z, one-sigma" "g" 5 0 10;
    }
    "GPS" {
        GpsLatitude "gps_lat_deg" "GPS latitude" "°" 7 -90 90;
        GpsLongitude "gps_lon_deg" "GPS longitude" "°" 7 -180 180;
        GpsHeight "gps_height_m" "GPS height above ellipsoid" "m" 3 -1000 50000;
        GpsAltitude "gps_altitude_m" "GPS altitude above sea level" "m" 3 -1000 50000;
        GpsVelE "gps_vel_e_mps" "GPS VelE" "m/s" 2 -400 400;
        GpsVelN "gps_vel_n_mps" "GPS VelN" "m/s" 2 -400 400;
        GpsVelU "gps_vel_u_mps" "GPS VelU" "m/s" 2 -400 400;
        GpsFix "gps_fix" "Fix type" "" 0 0 8;
        Satellites "satellites" "Satellites" "" 0 0 100 alarm 5 100;
        GpsAge "gps_age_s" "Age of the fix" "s" 1 0 1000 alarm 0 3;
        Hdop "hdop" "Horizontal dilution" "" 1 0 100 alarm 0 4;
        Vdop "vdop" "Vertical dilution" "" 1 0 100;
    }
    "Innovations" {
        InnovationPosition "innovation_position" "GPS position" "σ" 2 0 100 alarm 0 5;
        InnovationVelocity "innovation_velocity" "GPS velocity" "σ" 2 0 100 alarm 0 5;
        InnovationAttitude "innovation_attitude" "IMU roll and pitch" "σ" 2 0 100 alarm 0 5;
        InnovationHeading "innovation_heading" "Heading" "σ" 2 0 100 alarm 0 5;
        InnovationBaro "innovation_baro" "Barometric height" "σ" 2 0 100 alarm 0 5;
        Rejected "rejected_updates" "Updates rejected" "" 0 0 65535;
    }
    "Set-points" {
        AskedVelE "asked_vel_e_mps" "Commanded VelE" "m/s" 2 -400 400;
        AskedVelN "asked_vel_n_mps" "Commanded VelN" "m/s" 2 -400 400;
        AskedVelU "asked_vel_u_mps" "Commanded VelU" "m/s" 2 -400 400;
        AskedHeading "asked_heading_deg" "Commanded heading" "°" 2 -180 180;
        GeofenceShare "geofence_pct" "Distance to the geofence, share" "%" 1 -100 1000 alarm -100 80;
    }
    "Loop" {
        Period "loop_period_ms" "Period" "ms" 2 0 655 alarm 0 45;
        Work "loop_work_ms" "Computing time" "ms" 2 0 655 alarm 0 25;
        LongestWork "loop_longest_work_ms" "Longest computing time" "ms" 2 0 655;
        Overruns "loop_overruns" "Late cycles" "" 0 0 65535;
        LostImu "lost_imu_packets" "Inertial packets lost" "" 0 0 65535;
        LostGps "lost_gps_messages" "GPS messages lost" "" 0 0 65535;
        LostPulses "lost_pilot_pulses" "Pilot pulses lost" "" 0 0 65535;
        LostFrames "lost_telemetry_frames" "Telemetry frames dropped" "" 0 0 65535;
    }
    "State" {
        SystemMode "system_mode" "System mode" "" 0 0 255;
        AutopilotMode "autopilot_mode" "Autopilot mode" "" 0 0 255;
        Status "status_bits" "Status, bits" "" 0 0 65535;
        Control "control_bits" "Flight control, bits" "" 0 0 255;
        FailedChecks "failed_checks_bits" "Failed checks, bits" "" 0 0 65535;
        StatusKnown "status_known_bits" "Reported status, bits" "" 0 0 65535;
        ArmingChecks "arming_checks" "Pre-arm checks pass" "" 0 0 1;
        BaseMode "mav_base_mode" "MAVLink base mode, bits" "" 0 0 255;
        CustomMode "mav_custom_mode" "MAVLink custom mode" "" 0 0 4294967295.0;
        Autopilot "mav_autopilot" "MAVLink autopilot type" "" 0 0 255;
        VehicleKind "mav_type" "MAVLink vehicle type" "" 0 0 255;
        EstimateStatus "estimate_status_bits" "Status of the estimate, bits" "" 0 0 65535;
        EstimateStatusKnown "estimate_status_known_bits" "Reported status of the estimate, bits" "" 0 0 65535;
    }
    "Other vehicles" {
        Radio1 "radio_1_ms" "Radio channel 1" "ms" 4 0 4;
        Radio2 "radio_2_ms" "Radio channel 2" "ms" 4 0 4;
        Radio3 "radio_3_ms" "Radio channel 3" "ms" 4 0 4;
        Radio4 "radio_4_ms" "Radio channel 4" "ms" 4 0 4;
        Radio5 "radio_5_ms" "Radio channel 5" "ms" 4 0 4;
        Radio6 "radio_6_ms" "Radio channel 6" "ms" 4 0 4;
        Radio7 "radio_7_ms" "Radio channel 7" "ms" 4 0 4;
        Radio8 "radio_8_ms" "Radio channel 8" "ms" 4 0 4;
        Output1 "output_1_ms" "Output 1" "ms" 4 0 4;
        Output2 "output_2_ms" "Output 2" "ms" 4 0 4;
        Output3 "output_3_ms" "Output 3" "ms" 4 0 4;
        Output4 "output_4_ms" "Output 4" "ms" 4 0 4;
        Output5 "output_5_ms" "Output 5" "ms" 4 0 4;
        Output6 "output_6_ms" "Output 6" "ms" 4 0 4;
        Output7 "output_7_ms" "Output 7" "ms" 4 0 4;
        Output8 "output_8_ms" "Output 8" "ms" 4 0 4;
        Battery "battery_v" "Battery" "V" 2 0 1000;
        BatteryLeft "battery_pct" "Battery left" "%" 0 0 100 alarm 20 100;
    }
}

impl Id {
    /// Number of channels.
    pub const COUNT: usize = CHANNELS.len();

    /// The description of the channel.
    #[must_use]
    pub const fn channel(self) -> &'static Channel {
        &CHANNELS[self as usize]
    }

    /// The channel with a name.
    #[must_use]
    pub fn of(name: &str) -> Option<Self> {
        let place = CHANNELS.iter().position(|channel| channel.name == name)?;
        IDS.get(place).copied()
    }

    /// All channels.
    pub fn all() -> impl Iterator<Item = Self> {
        IDS.iter().copied()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn names_are_unlike_and_end_with_their_unit() {
        let names: BTreeSet<_> = CHANNELS.iter().map(|channel| channel.name).collect();
        assert_eq!(names.len(), Id::COUNT);
        for id in Id::all() {
            let channel = id.channel();
            assert_eq!(Id::of(channel.name), Some(id));
            let ending = match channel.unit {
                "°/s" => "degps",
                "°" => "deg",
                "m/s" => "mps",
                "°C" => "degc",
                "%" => "pct",
                "V" => "v",
                "" | "σ" => "",
                unit => unit,
            };
            assert!(channel.name.ends_with(ending), "{} in {}", channel.name, channel.unit);
        }
        assert_eq!(Id::of("no such channel"), None);
    }

    #[test]
    fn what_cannot_be_is_rejected() {
        let roll = Id::Roll.channel();
        assert_eq!(roll.plausible(Some(12.345_6)), 12.35);
        assert!(roll.plausible(Some(181.0)).is_nan() && roll.plausible(Some(f64::NAN)).is_nan());
        assert!(roll.plausible(None).is_nan());
        assert!(roll.alarms(50.0) && !roll.alarms(10.0) && !roll.alarms(f64::NAN));
    }
}
