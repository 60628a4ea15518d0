//! The ranges of the numbers in `fly.toml` that nothing else checks.

use super::error::FlyConfigError;
use super::fly_config::FlyConfig;
use super::sections::CaptureSection;

impl FlyConfig {
    /// Whether every number is one that a flight can be flown with; a NaN, which would switch a check off,
    /// never is.
    pub(super) fn check_ranges(&self) -> Result<(), FlyConfigError> {
        let limits = &self.receiver.limits;
        let signal = &self.servo.signal;
        let imu = &self.navigation.imu;
        let line = |section, baud: u32| (section, "baud", f64::from(baud), 300.0, 4e6);
        let mut numbers = vec![
            ("receiver.limits", "max_position_dilution", limits.max_position_dilution, 1.0, 99.0),
            (
                "receiver.limits",
                "max_horizontal_dilution",
                limits.max_horizontal_dilution,
                0.5,
                99.0,
            ),
            ("receiver.limits", "max_horizontal_sigma_m", limits.max_horizontal_sigma_m, 0.1, 1e3),
            ("receiver.limits", "max_vertical_sigma_m", limits.max_vertical_sigma_m, 0.1, 1e3),
            (
                "receiver.limits",
                "max_velocity_sigma_mps",
                limits.max_velocity_sigma_mps,
                0.05,
                100.0,
            ),
            ("receiver.limits", "max_ground_speed_mps", limits.max_ground_speed_mps, 1.0, 500.0),
            (
                "receiver.limits",
                "max_vertical_speed_mps",
                limits.max_vertical_speed_mps,
                1.0,
                500.0,
            ),
            ("receiver.limits", "max_jump_m", limits.max_jump_m, 1.0, 1e4),
            ("receiver.limits", "max_delay_s", limits.max_delay_s, 0.01, 10.0),
            ("receiver.limits", "min_satellites", f64::from(limits.min_satellites), 0.0, 50.0),
            ("servo", "hold_s", self.servo.hold_s, 0.0, 10.0),
            ("servo.signal", "stale_after_s", signal.stale_after_s, 0.02, 2.0),
            ("servo.signal", "failsafe_throttle_ms", signal.failsafe_throttle_ms, 0.0, 2.5),
            (
                "navigation.imu",
                "gyro_range_degps",
                imu.gyro_range_degps.unwrap_or(200.0),
                10.0,
                1e4,
            ),
            ("navigation.imu", "accel_range_g", imu.accel_range_g.unwrap_or(4.0), 0.5, 200.0),
            line("dmu", self.dmu.baud),
            line("receiver", self.receiver.baud()),
        ];
        numbers.extend(self.telemetry.as_ref().map(|section| line("telemetry", section.baud)));
        numbers.extend(self.mavlink.as_ref().map(|section| line("mavlink", section.baud)));
        numbers
            .extend(self.servo.stream.as_ref().map(|section| line("servo.stream", section.baud)));
        if let Some(CaptureSection::Serial(pilot)) = &self.servo.capture {
            numbers.push(line("servo.capture", pilot.baud));
        }
        if let Some(site) = self.site {
            numbers.extend([
                ("site", "latitude_deg", site.latitude_deg, -90.0, 90.0),
                ("site", "longitude_deg", site.longitude_deg, -180.0, 360.0),
                ("site", "height_m", site.height_m, -500.0, 9e3),
            ]);
        }
        for (section, key, found, from, to) in numbers {
            if !(from..=to).contains(&found) {
                let why = format!("found {found}, expected {from} to {to}");
                return Err(FlyConfigError::value(section, key, &why));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_would_switch_a_check_off_are_refused_with_their_key() {
        let good = "[dmu]\nport = 'a'\n[receiver]\nport = 'b'\n";
        FlyConfig::parse(good, "fly.toml".as_ref()).unwrap();
        for (text, key) in [
            ("[receiver.limits]\nmax_jump_m = nan\n", "max_jump_m"),
            ("[receiver.limits]\nmax_ground_speed_mps = inf\n", "max_ground_speed_mps"),
            ("[servo.signal]\nstale_after_s = 1e9\n", "stale_after_s"),
            ("[servo]\nhold_s = nan\n", "hold_s"),
            ("[navigation.imu]\ngyro_range_degps = 1e9\n", "gyro_range_degps"),
            ("[mavlink]\nport = 'c'\nspeaker = { system_id = 0 }\n", "system_id"),
            ("[mavlink]\nport = 'c'\nspeaker = { gate_sigmas = 0 }\n", "gate_sigmas"),
            ("[mavlink]\nport = 'c'\nspeaker = { rates = { attitude_hz = nan } }\n", "attitude_hz"),
            ("[site]\nlatitude_deg = 91\nlongitude_deg = 0\n", "latitude_deg"),
            ("[telemetry]\nport = 'd'\nbaud = 5\n", "baud"),
            ("[servo.capture]\nserial = { port = 'c', baud = 5 }\n", "baud"),
            ("[mavlink]\nport = 'c'\nspeaker = { component_id = 0 }\n", "component_id"),
            (
                "[servo.capture]\nserial = { port = 'c' }\n[autopilot]\nfile = 'a'\n\
                 fence = { radius_m = 50, height_m = 50 }\n\
                 [site]\nlatitude_deg = 1\nlongitude_deg = 2\n",
                "[site] height_m",
            ),
            ("[telemetry]\nport = 'd'\nudp = 'ground:14551'\n", "udp"),
            ("[telemetry]\nudp = 'ground'\n", "udp"),
            ("[telemetry]\nudp = 'ground:0'\n", "udp"),
            ("[mavlink]\nbaud = 9600\n", "port"),
        ] {
            let error = FlyConfig::parse(&format!("{good}{text}"), "fly.toml".as_ref())
                .expect_err(text)
                .to_string();
            assert!(error.contains(key) && error.contains("expected"), "{text}: {error}");
        }
    }
}
