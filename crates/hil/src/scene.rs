//! What the pilot does and what is lost, and when.

use std::str::FromStr;

use hovernav::controls::{Channel, Sticks};

/// Something that happens in a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Act {
    /// The pilot's switch is closed.
    Engage,
    /// The pilot moves the sticks by this from where they are held.
    Move(Sticks),
    /// The pilot holds the sticks where they are, but for what `Move` adds: as in a test point.
    Still,
    /// No pulses come from the pilot's receiver.
    PilotLost,
    /// The receiver says that it has lost the transmitter, and sends pulses of its own.
    ReceiverFailsafe,
    /// The aux channel alone has no pulses.
    AuxLost,
    /// The wire of the inertial unit is cut.
    DmuCut,
    /// The port of the inertial unit is pulled out.
    DmuPulled,
    /// The wire of the GPS receiver is cut.
    GpsCut,
    /// The port of the GPS receiver is pulled out.
    GpsPulled,
    /// The receiver sends no fixes.
    NoFix,
    /// The receiver repeats its last fix.
    FrozenFix,
    /// The inertial unit repeats its last sample.
    FrozenImu,
    /// Packets towards the servos do not arrive: the microcontroller passes the pilot through.
    ServosCut,
}

impl Act {
    /// The names of all but `stick`.
    const NAMED: [(&'static str, Self); 13] = [
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
        ("frozen-imu", Self::FrozenImu),
        ("servos-cut", Self::ServosCut),
    ];
}

/// An act, when it begins and how long it lasts, s of the flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedAct {
    /// What.
    pub act: Act,
    /// From when on, s.
    pub start_s: f64,
    /// How long, s; infinite to the end.
    pub duration_s: f64,
}

impl TimedAct {
    fn covers(&self, time_s: f64) -> bool {
        time_s >= self.start_s && time_s - self.start_s < self.duration_s
    }
}

/// Why an act is not understood.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "found \"{found}\", expected ACT@START[:DURATION] in seconds, ACT one of engage, \
     stick-CHANNEL=VALUE, still, pilot-lost, failsafe, aux-lost, dmu-cut, dmu-pulled, gps-cut, gps-pulled, \
     no-fix, frozen-fix, frozen-imu, servos-cut"
)]
pub struct ActError {
    found: String,
}

impl FromStr for TimedAct {
    type Err = ActError;

    /// `ACT@START[:DURATION]`, `stick-pedal=0.3@50:2` say.
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

/// Everything that happens in a flight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// In any order.
    pub acts: Vec<TimedAct>,
}

impl Scene {
    /// Whether `act` is under way.
    #[must_use]
    pub fn has(&self, act: Act, time_s: f64) -> bool {
        self.acts.iter().any(|timed| timed.act == act && timed.covers(time_s))
    }

    /// By how much the pilot moves the sticks.
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

    /// The spans, start and duration in s, in which `act` is under way.
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
    fn acts_are_read_and_what_is_none_is_refused_with_what_was_expected() {
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
