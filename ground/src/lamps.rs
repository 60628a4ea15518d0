//! What works and what does not, with the reason in words.

use hovernav::autopilot::{Check, Mode};
use hovernav::telemetry::{ControlFlags, StatusFlags};
use serde::Serialize;

use crate::channel::{CHANNELS, Id};

/// How it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Light {
    /// As it should be.
    Good,
    /// Less well.
    Care,
    /// Something is lost.
    Bad,
    /// Nothing is known of it.
    Unknown,
}

/// One lamp.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lamp {
    /// What of.
    pub name: &'static str,
    /// How it is.
    pub light: Light,
    /// Why.
    pub why: String,
}

fn lamp(name: &'static str, light: Light, why: impl Into<String>) -> Lamp {
    Lamp { name, light, why: why.into() }
}

/// A number in words, `?` where it is not known.
fn said(value: f64, digits: usize, unit: &str) -> String {
    if value.is_nan() { "?".into() } else { format!("{value:.digits$} {unit}") }
}

/// The lamps, of values by channel, NaN of what is not known.
#[must_use]
pub fn lamps(value: impl Fn(Id) -> f64) -> Vec<Lamp> {
    let bits = value(Id::Status);
    if bits.is_nan() {
        return [
            "inertial unit",
            "GPS",
            "attitude",
            "velocity",
            "position",
            "pilot",
            "servos",
            "loop",
        ]
        .map(|name| lamp(name, Light::Unknown, "nothing heard"))
        .into();
    }
    let status = StatusFlags::from_bits(bits as u16);
    let or = |good, light| if good { Light::Good } else { light };
    let sigma = |id: Id, good: bool, light| {
        let limit = CHANNELS[id as usize].alarm.1;
        let unit = CHANNELS[id as usize].unit;
        let size = value(id);
        let why = if size.is_nan() {
            "no estimate".to_owned()
        } else if good {
            format!("one-sigma {}", said(size, 2, unit))
        } else if size > limit {
            format!("one-sigma {}, at most {limit} {unit}", said(size, 2, unit))
        } else {
            format!("not to be flown by, one-sigma {}", said(size, 2, unit))
        };
        (or(good, light), why)
    };
    let mut lamps = vec![lamp(
        "inertial unit",
        or(status.imu, Light::Bad),
        if status.imu { "samples come" } else { "no samples that are believed" },
    )];
    let kinds =
        ["no receiver", "no fix", "2D fix", "3D fix", "differential fix", "RTK float", "RTK fixed"];
    let kind = kinds.get(value(Id::GpsFix) as usize).copied().unwrap_or("unknown fix");
    let age = said(value(Id::GpsAge), 1, "s");
    let satellites = said(value(Id::Satellites), 0, "satellites");
    lamps.push(lamp("GPS", or(status.gps, Light::Bad), format!("{kind}, {satellites}, {age} old")));
    let (light, why) = sigma(Id::SigmaTilt, status.attitude, Light::Bad);
    lamps.push(lamp("attitude", light, why));
    let (light, why) = sigma(Id::SigmaHeading, status.heading, Light::Care);
    lamps.push(lamp("heading", light, why));
    let (light, why) = sigma(Id::SigmaVelHorizontal, status.velocity, Light::Care);
    lamps.push(lamp("velocity", light, why));
    let (light, why) = sigma(Id::SigmaHorizontal, status.position, Light::Care);
    lamps.push(lamp("position", light, why));
    lamps.push(match (status.receiver_failsafe, status.pilot_signal) {
        (true, _) => lamp("pilot", Light::Bad, "the receiver has lost the transmitter"),
        (_, true) => lamp("pilot", Light::Good, "pulses are fresh"),
        _ => lamp("pilot", Light::Bad, "no fresh pulses"),
    });
    lamps.push(lamp(
        "servos",
        or(status.servos, Light::Bad),
        if status.servos { "take what they are sent" } else { "do not take what they are sent" },
    ));
    lamps.push(lamp(
        "record aboard",
        or(status.recorder, Light::Care),
        if status.recorder { "the flight is being recorded" } else { "the flight is not recorded" },
    ));
    let overruns = value(Id::Overruns);
    let longest = said(value(Id::LongestWork), 1, "ms");
    lamps.push(lamp(
        "loop",
        or(status.on_time, Light::Care),
        format!("{} cycles late, the longest {longest} of work", said(overruns, 0, "").trim()),
    ));
    let fence = value(Id::FenceShare);
    if !fence.is_nan() {
        let light = if fence >= 100.0 {
            Light::Bad
        } else if fence > 80.0 {
            Light::Care
        } else {
            Light::Good
        };
        lamps.push(lamp("fence", light, format!("{fence:.0} % of the way to it")));
    }
    lamps
}

/// Flight control: who flies, why, and what would refuse engagement now.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Control {
    /// Who flies.
    pub flies: &'static str,
    /// What the autopilot is doing; `None` where there is no autopilot.
    pub mode: Option<&'static str>,
    /// What holds now, in words.
    pub states: Vec<&'static str>,
    /// What would refuse engagement now.
    pub refusals: Vec<&'static str>,
}

/// Flight control, of values by channel.
#[must_use]
pub fn control(value: impl Fn(Id) -> f64) -> Control {
    let modes =
        ["starting", "aligning", "searching the heading", "the pilot", "the autopilot", "failsafe"];
    let place = |id| {
        let number = value(id);
        (number >= 0.0).then_some(number as usize)
    };
    let flies =
        place(Id::SystemMode).and_then(|mode| modes.get(mode).copied()).unwrap_or("unknown");
    let mode = place(Id::AutopilotMode).and_then(|mode| Some(Mode::ALL.get(mode)?.name()));
    let flags = ControlFlags::from_bits(place(Id::Control).unwrap_or(0) as u8);
    let states = [
        (flags.switch_on, "the switch is closed"),
        (flags.refused, "the switch does not count until it has been opened"),
        (flags.pilot_lost, "the pilot's signal is lost: the autopilot holds"),
        (flags.descends, "no pilot: the autopilot descends"),
        (flags.outside_fence, "the fence is reached: the autopilot goes back"),
        (flags.at_end, "a control is at its end"),
        (flags.excited, "the autopilot flies a test input"),
    ];
    let failed = place(Id::FailedChecks).unwrap_or(0);
    Control {
        flies,
        mode,
        states: states.into_iter().filter(|(is, _)| *is).map(|(_, words)| words).collect(),
        refusals: Check::ALL
            .iter()
            .enumerate()
            .filter(|(bit, _)| failed >> bit & 1 != 0)
            .map(|(_, check)| check.name())
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lamp_that_is_not_good_says_why() {
        let value = |id| match id {
            Id::Status => f64::from(StatusFlags { imu: true, ..StatusFlags::default() }.bits()),
            Id::GpsFix => 1.0,
            Id::Satellites => 3.0,
            Id::SigmaTilt => 9.5,
            _ => f64::NAN,
        };
        let lamps = lamps(value);
        let of = |name| lamps.iter().find(|lamp| lamp.name == name).unwrap();
        assert_eq!(of("inertial unit").light, Light::Good);
        assert_eq!(of("GPS").why, "no fix, 3 satellites, ? old");
        assert_eq!(of("attitude").why, "one-sigma 9.50 °, at most 6.9 °");
        assert_eq!(of("velocity").why, "no estimate");
    }

    #[test]
    fn what_refuses_engagement_is_named() {
        let value = |id| match id {
            Id::SystemMode => 3.0,
            Id::AutopilotMode => 0.0,
            Id::FailedChecks => f64::from(1 << 6 | 1 << 13),
            Id::Control => 1.0,
            _ => f64::NAN,
        };
        let control = control(value);
        assert_eq!((control.flies, control.mode), ("the pilot", Some("manual")));
        assert_eq!(control.refusals, ["age of the last fix, s", "servos"]);
        assert_eq!(control.states, ["the switch is closed"]);
    }
}
