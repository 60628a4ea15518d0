//! MAVLink messages: sender and rates.

/// Largest rate of each message, Hz; 0 is never. The rate is also limited by the calls of the sender.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MavlinkRates {
    /// HEARTBEAT; ground stations report a loss after some seconds without it.
    pub heartbeat_hz: f64,
    /// ATTITUDE.
    pub attitude_hz: f64,
    /// HIGHRES_IMU.
    pub highres_imu_hz: f64,
    /// LOCAL_POSITION_NED.
    pub local_position_hz: f64,
    /// GLOBAL_POSITION_INT.
    pub global_position_hz: f64,
    /// GPS_RAW_INT.
    pub gps_raw_hz: f64,
    /// SERVO_OUTPUT_RAW.
    pub servo_output_hz: f64,
    /// ESTIMATOR_STATUS.
    pub estimator_status_hz: f64,
}

impl Default for MavlinkRates {
    /// Fills two thirds of 57 600 baud.
    fn default() -> Self {
        Self {
            heartbeat_hz: 1.0,
            attitude_hz: 33.0,
            highres_imu_hz: 20.0,
            local_position_hz: 10.0,
            global_position_hz: 2.0,
            gps_raw_hz: 2.0,
            servo_output_hz: 10.0,
            estimator_status_hz: 2.0,
        }
    }
}

impl MavlinkRates {
    /// The rates, with their keys.
    fn named(&self) -> [(&'static str, f64); 8] {
        [
            ("heartbeat_hz", self.heartbeat_hz),
            ("attitude_hz", self.attitude_hz),
            ("highres_imu_hz", self.highres_imu_hz),
            ("local_position_hz", self.local_position_hz),
            ("global_position_hz", self.global_position_hz),
            ("gps_raw_hz", self.gps_raw_hz),
            ("servo_output_hz", self.servo_output_hz),
            ("estimator_status_hz", self.estimator_status_hz),
        ]
    }
}

impl MavlinkConfig {
    /// Checks every value: returns the key of the first invalid one, with found and expected values.
    pub(super) fn check(&self) -> Result<(), (&'static str, String)> {
        for (key, found) in
            [("speaker.system_id", self.system_id), ("speaker.component_id", self.component_id)]
        {
            if found == 0 {
                return Err((key, "found 0, expected 1 to 255".into()));
            }
        }
        let gate = self.gate_sigmas;
        if !(0.1..=1e3).contains(&gate) {
            let why = format!("found {gate}, expected 0.1 to 1000 one-sigmas");
            return Err(("speaker.gate_sigmas", why));
        }
        let bad = self.rates.named().into_iter().find(|(_, hz)| !(0.0..=1e3).contains(hz));
        match bad {
            Some((key, found)) => Err((key, format!("found {found}, expected 0 to 1000 a second"))),
            None => Ok(()),
        }
    }
}

/// Sender of MAVLink messages, and its rates.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct MavlinkConfig {
    /// System ID of the vehicle, 1 to 255.
    pub system_id: u8,
    /// Component ID of the sender, 1 to 255; 1 is the autopilot.
    pub component_id: u8,
    /// Innovations beyond this number of one-sigmas are rejected; test ratios are relative to it.
    pub gate_sigmas: f64,
    /// Rates of the messages.
    pub rates: MavlinkRates,
}

impl Default for MavlinkConfig {
    fn default() -> Self {
        Self { system_id: 1, component_id: 1, gate_sigmas: 5.0, rates: MavlinkRates::default() }
    }
}
