//! Actions of the pilot and failures, with their times.

use std::str::FromStr;

use hovernav::controls::{Channel, Sticks};

/// An action or a failure in a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Act {
    /// The pilot's switch is closed.
    Engage,
    /// The pilot moves the sticks by these values from their held positions.
    Move(Sticks),
    /// The pilot holds the sticks unchanged, except for `Move`, as at a test point.
    Still,
    /// The pilot's receiver sends no pulses.
    PilotLost,
    /// The receiver reports the loss of the transmitter and sends its failsafe pulses.
    ReceiverFailsafe,
    /// Only the aux channel has no pulses.
    AuxLost,
    /// The wire of the IMU is cut.
    DmuCut,
    /// The port of the IMU is unplugged.
    DmuPulled,
    /// The wire of the GPS receiver is cut.
    GpsCut,
    /// The port of the GPS receiver is unplugged.
    GpsPulled,
    /// The receiver sends no fixes.
    NoFix,
    /// The receiver repeats its last fix.
    FrozenFix,
    /// Fixes are damaged on the way: 60 m and 20 m/s off.
    WildFix,
    /// The IMU repeats its last sample.
    FrozenImu,
    /// Packets of the IMU arrive damaged with a valid checksum: every gyro at 1.5 times its rated range.
    WildPacket,
    /// One byte in a hundred of the IMU's packets is damaged.
    DmuNoise,
    /// One byte in a hundred of the receiver's messages is damaged.
    GpsNoise,
    /// Packets to the servos do not arrive: the microcontroller passes the pilot's pulses through.
    ServosCut,
}

impl Act {
    /// Names of all acts except `stick`.
    const NAMED: [(&'static str, Self); 17] = [
        ("engage", Self::Engage),
        ("still", Self::Still),
        ("pilot-lost", Self::PilotLost),
        ("failsafe", Self::ReceiverFailsafe),
        ("aux-lost", Self::AuxLost),
        ("dmu-cut", Self::DmuCut),
        ("dmu-pulled", Self::DmuPulled),
        ("gps-cut", Self::GpsCut),
        ("gps-pulled", Self::GpsPulled),
        ("no-fix", Self::NoFix),
        ("frozen-fix", Self::FrozenFix),
        ("wild-fix", Self::WildFix),
        ("frozen-imu", Self::FrozenImu),
        ("wild-packet", Self::WildPacket),
        ("dmu-noise", Self::DmuNoise),
        ("gps-noise", Self::GpsNoise),
        ("servos-cut", Self::ServosCut),
    ];
}

/// An act with its start and duration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedAct {
    /// The act.
    pub act: Act,
    /// Start, s of the flight.
    pub start_s: f64,
    /// Duration, s; infinite until the end of the flight.
    pub duration_s: f64,
}

impl TimedAct {
    fn covers(&self, time_s: f64) -> bool {
        time_s >= self.start_s && time_s - self.start_s < self.duration_s
    }
}

/// An act that cannot be parsed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "found \"{found}\", expected ACT@START[:DURATION] in seconds, ACT one of engage, \
     stick-CHANNEL=VALUE, still, pilot-lost, failsafe, aux-lost, dmu-cut, dmu-pulled, gps-cut, gps-pulled, \
     no-fix, frozen-fix, wild-fix, frozen-imu, wild-packet, dmu-noise, gps-noise, servos-cut"
)]
pub struct ActError {
    found: String,
}

impl FromStr for TimedAct {
    type Err = ActError;

    /// `ACT@START[:DURATION]`, for example `stick-pedal=0.3@50:2`.
    fn from_str(text: &str) -> Result<Self, ActError> {
        let error = || ActError { found: text.chars().take(60).collect() };
        let (act, when) = text.split_once('@').ok_or_else(error)?;
        let (start, duration) = when.split_once(':').unwrap_or((when, "inf"));
        let number = |text: &str| text.trim().parse::<f64>().ok();
        let start_s =
            number(start).filter(|start| (0.0..=1e6).contains(start)).ok_or_else(error)?;
        let duration_s = number(duration).filter(|length| *length > 0.0).ok_or_else(error)?;
        let named = Act::NAMED.iter().find(|(name, _)| *name == act.trim());
        let act = match (named, act.trim().strip_prefix("stick-")) {
            (Some((_, act)), _) => *act,
            (None, Some(stick)) => {
                let (name, value) = stick.split_once('=').ok_or_else(error)?;
                let value = number(value).filter(|value| value.abs() <= 1.0).ok_or_else(error)?;
                let stick = Sticks::NAMES.iter().position(|own| *own == name).ok_or_else(error)?;
                let mut moved = [0.0; 4];
                moved[stick] = value;
                Act::Move(Sticks::from_array(moved))
            }
            (None, None) => return Err(error()),
        };
        Ok(Self { act, start_s, duration_s })
    }
}

/// All acts of a flight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// The acts, in any order.
    pub acts: Vec<TimedAct>,
}

impl Scene {
    /// Whether `act` is active.
    #[must_use]
    pub fn has(&self, act: Act, time_s: f64) -> bool {
        self.acts.iter().any(|timed| timed.act == act && timed.covers(time_s))
    }

    /// Sum of all active `Move` acts.
    #[must_use]
    pub fn moved(&self, time_s: f64) -> Sticks {
        let mut sum = [0.0; 4];
        for timed in self.acts.iter().filter(|timed| timed.covers(time_s)) {
            if let Act::Move(sticks) = timed.act {
                for (sum, stick) in sum.iter_mut().zip(sticks.to_array()) {
                    *sum += stick;
                }
            }
        }
        Sticks::from_array(sum)
    }

    /// Start and duration, s, of each span in which `act` is active.
    pub fn spans(&self, act: Act) -> impl Iterator<Item = (f64, f64)> + '_ {
        let of = move |timed: &&TimedAct| timed.act == act;
        self.acts.iter().filter(of).map(|timed| (timed.start_s, timed.duration_s))
    }
}

/// The channel that carries each stick, in the order of [`Sticks::to_array`].
pub(crate) const STICK_CHANNELS: [Channel; 4] =
    [Channel::Lateral, Channel::Longitudinal, Channel::Collective, Channel::Pedal];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn acts_are_parsed_and_invalid_ones_are_rejected_with_the_expected_form() {
        let act: TimedAct = "engage@20:60".parse().unwrap();
        assert_eq!(act, TimedAct { act: Act::Engage, start_s: 20.0, duration_s: 60.0 });
        let act: TimedAct = "stick-pedal=-0.3@50:2".parse().unwrap();
        assert_eq!(act.act, Act::Move(Sticks { pedal: -0.3, ..Sticks::NEUTRAL }));
        assert_eq!("still@5:2".parse::<TimedAct>().unwrap().act, Act::Still);
        assert_eq!("gps-cut@5".parse::<TimedAct>().unwrap().duration_s, f64::INFINITY);
        for bad in [
            "",
            "engage",
            "engage@",
            "engage@-1",
            "engage@1:0",
            "engage@nan",
            "lost@3",
            "stick-pedal@3",
            "stick-pedal=2@3",
            "stick-rudder=0.1@3",
        ] {
            let error = bad.parse::<TimedAct>().unwrap_err().to_string();
            assert!(error.contains("expected ACT@START"), "{bad}: {error}");
        }
    }

    #[test]
    fn an_act_lasts_from_its_start_to_its_end() {
        let scene = Scene {
            acts: vec!["engage@10:5".parse().unwrap(), "stick-lateral=0.2@12:1".parse().unwrap()],
        };
        let engaged: Vec<bool> =
            [9.9, 10.0, 14.9, 15.0].map(|time_s| scene.has(Act::Engage, time_s)).into();
        assert_eq!(engaged, [false, true, true, false]);
        assert_eq!(scene.moved(12.5).lateral, 0.2);
        assert_eq!(scene.moved(13.5), Sticks::NEUTRAL);
    }
}
