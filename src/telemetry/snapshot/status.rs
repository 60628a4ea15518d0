//! Mode of the system, and flags of the functions that work.

use crate::health::Health;

/// Mode of the system: who flies, and the progress of the navigation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SystemMode {
    /// Waiting for sensors.
    #[default]
    Starting,
    /// Sensors are present; attitude, position and biases are being determined.
    Aligning,
    /// Navigating; the heading is still unknown.
    SearchingHeading,
    /// Navigating; the pilot flies.
    Pilot,
    /// Navigating; the autopilot flies.
    Autopilot,
    /// A function required for flight is lost; the safe state is active.
    Failsafe,
}

impl SystemMode {
    /// All modes, in the order of their codes.
    pub const ALL: [Self; 6] = [
        Self::Starting,
        Self::Aligning,
        Self::SearchingHeading,
        Self::Pilot,
        Self::Autopilot,
        Self::Failsafe,
    ];

    /// Code of the mode in a frame.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// Name for people.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Starting => "starting",
            Self::Aligning => "aligning",
            Self::SearchingHeading => "searching for the heading",
            Self::Pilot => "the pilot",
            Self::Autopilot => "the autopilot",
            Self::Failsafe => "failsafe",
        }
    }

    /// The mode of a code in a frame.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }
}

/// Flags of the functions that work at this moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StatusFlags {
    /// Inertial samples arrive and are accepted.
    pub imu: bool,
    /// Fixes arrive and are accepted.
    pub gps: bool,
    /// Roll and pitch are good enough to fly on, by the autopilot's limits: see [`Health`].
    pub attitude: bool,
    /// The heading is good enough to fly on.
    pub heading: bool,
    /// The velocity, horizontal and vertical, is good enough to fly on.
    pub velocity: bool,
    /// The position is good enough to fly on.
    pub position: bool,
    /// The pilot's pulses are fresh on every channel.
    pub pilot_signal: bool,
    /// The receiver reports the loss of the transmitter.
    pub receiver_failsafe: bool,
    /// The servos receive their commands.
    pub servos: bool,
    /// The flight is being recorded.
    pub recorder: bool,
    /// The loop has been on time since the last snapshot.
    pub on_time: bool,
}

impl StatusFlags {
    /// All flags set.
    pub const ALL: Self = Self::from_bits(u16::MAX);

    /// The flags as bits, in the order of the fields; the first field is the lowest bit.
    #[must_use]
    pub fn bits(self) -> u16 {
        [
            self.imu,
            self.gps,
            self.attitude,
            self.heading,
            self.velocity,
            self.position,
            self.pilot_signal,
            self.receiver_failsafe,
            self.servos,
            self.recorder,
            self.on_time,
        ]
        .into_iter()
        .rev()
        .fold(0, |bits, flag| bits << 1 | u16::from(flag))
    }

    /// Adds the flags of the estimate's health.
    #[must_use]
    pub const fn with_estimate(self, health: &Health) -> Self {
        Self {
            attitude: health.tilt.is_ok(),
            heading: health.heading.is_ok(),
            velocity: health.velocity.is_ok() && health.vertical_velocity.is_ok(),
            position: health.position.is_ok(),
            ..self
        }
    }

    /// The inverse of [`StatusFlags::bits`]; bits beyond the fields are ignored.
    #[must_use]
    pub const fn from_bits(bits: u16) -> Self {
        Self {
            imu: bits & 1 != 0,
            gps: bits & 1 << 1 != 0,
            attitude: bits & 1 << 2 != 0,
            heading: bits & 1 << 3 != 0,
            velocity: bits & 1 << 4 != 0,
            position: bits & 1 << 5 != 0,
            pilot_signal: bits & 1 << 6 != 0,
            receiver_failsafe: bits & 1 << 7 != 0,
            servos: bits & 1 << 8 != 0,
            recorder: bits & 1 << 9 != 0,
            on_time: bits & 1 << 10 != 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::health::Distrust;

    #[test]
    fn every_code_names_one_mode() {
        for code in 0..=u8::MAX {
            assert!(SystemMode::from_code(code).is_none_or(|mode| mode.code() == code));
        }
        assert!(
            SystemMode::ALL.iter().all(|mode| SystemMode::from_code(mode.code()) == Some(*mode))
        );
    }

    #[test]
    fn each_flag_has_a_bit_of_its_own() {
        for bit in 0..11 {
            assert_eq!(StatusFlags::from_bits(1 << bit).bits(), 1 << bit);
        }
        assert_eq!(StatusFlags { imu: true, ..StatusFlags::default() }.bits(), 1);
        assert_eq!(StatusFlags { on_time: true, ..StatusFlags::default() }.bits(), 1 << 10);
        assert_eq!(StatusFlags::from_bits(0xF800), StatusFlags::default());
    }

    #[test]
    fn what_the_autopilot_does_not_fly_on_is_not_reported_as_good() {
        let flags = StatusFlags::from_bits(u16::MAX);
        let health = Health::none(Distrust::Stale);
        let StatusFlags { attitude, heading, velocity, position, .. } =
            flags.with_estimate(&health);
        assert_eq!([attitude, heading, velocity, position], [false; 4]);
        let health = Health { tilt: Ok(()), velocity: Ok(()), ..health };
        let StatusFlags { attitude, velocity, .. } = flags.with_estimate(&health);
        assert_eq!((attitude, velocity), (true, false), "vertical velocity is missing");
    }
}
