//! The status of each sensor and function of the vehicle, with the reason in words.

use hovernav::autopilot::{Check, Mode};
use hovernav::telemetry::{ControlFlags, StatusFlags, SystemMode};
use serde::Serialize;

use crate::channel::{CHANNELS, Id};
use crate::mavlink::modes;

/// The state of a lamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Light {
    /// Normal.
    Good,
    /// Degraded.
    Care,
    /// Failed or lost.
    Bad,
    /// Unknown.
    Unknown,
}

/// The kinds of a fix, by their numbers.
const FIXES: [&str; 7] =
    ["no receiver", "no fix", "2D fix", "3D fix", "differential fix", "RTK float", "RTK fixed"];

/// The names of a channel's values 0, 1, 2, …; empty for a channel of numbers.
#[must_use]
pub fn value_names(id: Id) -> Vec<&'static str> {
    match id {
        Id::SystemMode => (0..).map_while(SystemMode::from_code).map(SystemMode::name).collect(),
        Id::AutopilotMode => Mode::ALL.iter().map(|mode| mode.name()).collect(),
        Id::GpsFix => FIXES.to_vec(),
        _ => Vec::new(),
    }
}

/// One lamp.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Lamp {
    /// Name of the sensor or function.
    pub name: &'static str,
    /// State.
    pub light: Light,
    /// Reason.
    pub why: String,
}

fn lamp(name: &'static str, light: Light, why: impl Into<String>) -> Lamp {
    Lamp { name, light, why: why.into() }
}

/// A number with its unit; `?` if unknown.
fn said(value: f64, digits: usize, unit: &str) -> String {
    if value.is_nan() { "?".into() } else { format!("{value:.digits$} {unit}") }
}

/// The status flags, and the flags that the vehicle reports.
fn statuses(value: &impl Fn(Id) -> f64) -> (StatusFlags, StatusFlags) {
    let bits = |id| Some(value(id)).filter(|bits| !bits.is_nan()).map(|bits| bits as u16);
    // Each pair is sent at its own rate. Old records contain only the status of hovernav vehicles, which report all
    // flags.
    let pairs = [(Id::Status, Id::StatusKnown), (Id::EstimateStatus, Id::EstimateStatusKnown)];
    let (mut all, mut all_known) = (0, 0);
    for (status, known) in pairs {
        let Some(status) = bits(status) else { continue };
        let known = bits(known).unwrap_or(StatusFlags::ALL.bits());
        all |= status & known;
        all_known |= known;
    }
    (StatusFlags::from_bits(all), StatusFlags::from_bits(all_known))
}

/// Age, s, after which the values of a fix are no present values: three periods of a slow receiver.
pub const OLD_FIX_S: f64 = 3.0;
/// Largest age of a fix that a frame holds, s, less its rounding.
const OLDEST_S: f64 = 25.0;

/// The lamps for channel values; `value` returns NaN for unknown channels. `silence` is the reason if no present values
/// exist.
#[must_use]
pub fn lamps(value: impl Fn(Id) -> f64, silence: Option<&str>) -> Vec<Lamp> {
    let (status, known) = statuses(&value);
    let is_heard = known != StatusFlags::default() || !value(Id::BaseMode).is_nan();
    let silent = silence.unwrap_or(if is_heard { "not reported" } else { "no telemetry" });
    let mut lamps = Vec::new();
    let mut light = |name, known: bool, light, why: String| {
        let unknown = || lamp(name, Light::Unknown, silent);
        lamps.push(if known { lamp(name, light, why) } else { unknown() });
    };
    let or = |good, light| if good { Light::Good } else { light };
    let either = |good: bool, yes: &str, no: &str| if good { yes.into() } else { no.into() };

    if let Some((is_armed, why)) = arming(&value, status, known) {
        light("arming", true, or(is_armed, Light::Care), why.into());
    } else if silence.is_some() || !is_heard {
        light("arming", false, Light::Unknown, String::new());
    }
    let why = either(status.imu, "samples arrive", "no valid samples");
    light("inertial unit", known.imu, or(status.imu, Light::Bad), why);
    let fix = value(Id::GpsFix);
    let kind = FIXES.get(fix as usize).copied().unwrap_or("unknown fix");
    let age_s = value(Id::GpsAge);
    let satellites = said(value(Id::Satellites), 0, "satellites");
    let why = match age_s {
        _ if age_s.is_nan() => format!("{kind}, {satellites}"),
        _ if age_s > OLDEST_S => format!("no fix for more than {OLDEST_S} s"),
        _ if age_s > OLD_FIX_S => format!("no fix for {age_s:.1} s"),
        _ => format!("{kind}, {satellites}, {age_s:.1} s old"),
    };
    let is_good = if known.gps { status.gps } else { fix >= 3.0 };
    let is_known = known.gps || !(fix.is_nan() && age_s.is_nan());
    light("GPS", is_known, or(is_good, Light::Bad), why);

    let mut estimate = |name, known, good, id: Id, otherwise| {
        let (limit, unit) = (CHANNELS[id as usize].alarm.1, CHANNELS[id as usize].unit);
        let size = value(id);
        let why = match (size.is_nan(), good) {
            (true, true) => "reported by its estimator".to_owned(),
            (true, false) => "no estimate".to_owned(),
            (false, true) => format!("one-sigma {}", said(size, 2, unit)),
            _ if size > limit => {
                format!("one-sigma {}, at most {limit} {unit}", said(size, 2, unit))
            }
            _ => format!("not usable for flight, one-sigma {}", said(size, 2, unit)),
        };
        light(name, known, or(good, otherwise), why);
    };
    use Light::{Bad, Care};
    estimate("attitude", known.attitude, status.attitude, Id::SigmaTilt, Bad);
    estimate("heading", known.heading, status.heading, Id::SigmaHeading, Care);
    estimate("velocity", known.velocity, status.velocity, Id::SigmaVelHorizontal, Care);
    estimate("position", known.position, status.position, Id::SigmaHorizontal, Care);

    let is_lost = status.receiver_failsafe;
    let why = match (is_lost, status.pilot_signal) {
        (true, _) => "the receiver has lost the transmitter",
        (_, true) => "pulses are fresh",
        _ => "no fresh pulses",
    };
    let is_good = status.pilot_signal && !is_lost;
    light("pilot", known.pilot_signal, or(is_good, Light::Bad), why.into());
    let why = either(status.servos, "accept commands", "do not accept commands");
    light("servos", known.servos, or(status.servos, Light::Bad), why);
    let why = either(status.recorder, "the flight is being recorded", "the flight is not recorded");
    light("onboard record", known.recorder, or(status.recorder, Light::Care), why);
    let overruns = said(value(Id::Overruns), 0, "");
    let longest = said(value(Id::LongestWork), 1, "ms");
    let why = format!("late cycles: {}, longest computing time {longest}", overruns.trim());
    light("loop", known.on_time, or(status.on_time, Light::Care), why);
    let geofence = value(Id::GeofenceShare);
    if !geofence.is_nan() {
        let light = if geofence >= 100.0 {
            Light::Bad
        } else if geofence > 80.0 {
            Light::Care
        } else {
            Light::Good
        };
        lamps.push(lamp("geofence", light, format!("{geofence:.0} % of the distance to it")));
    }
    lamps
}

/// Whether the vehicle is armed, with a description; `None` if the vehicle does not report it.
fn arming(
    value: &impl Fn(Id) -> f64,
    status: StatusFlags,
    known: StatusFlags,
) -> Option<(bool, &'static str)> {
    const SAFETY_ARMED: u8 = 0b1000_0000;
    let mode = value(Id::BaseMode);
    if !mode.is_nan() {
        let is_armed = mode as u8 & SAFETY_ARMED != 0;
        let passes = value(Id::ArmingChecks);
        let why = match is_armed {
            true => "armed",
            false if passes == 1.0 => "not armed: its pre-arm checks pass",
            false if passes == 0.0 => "not armed: its pre-arm checks fail, see its messages",
            false => "not armed",
        };
        return Some((is_armed, why));
    }
    let servos = [Id::ServoCollective, Id::ServoLongitudinal, Id::ServoLateral, Id::ServoPedal];
    let is_driven = servos.iter().any(|id| !value(*id).is_nan());
    known.servos.then_some(match (is_driven, status.servos) {
        (true, true) => (true, "armed: the servos are driven"),
        (true, false) => (false, "not armed: the servos do not accept commands"),
        (false, _) => (false, "not armed: no commands are sent to the servos"),
    })
}

/// Flight control: mode, state, and the checks that would prevent an engagement now.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Control {
    /// `pilot` or `autopilot`, whichever flies; for a vehicle of another project, its flight mode.
    pub flies: String,
    /// Mode of the autopilot; `None` without an autopilot.
    pub mode: Option<&'static str>,
    /// The present states in words.
    pub states: Vec<&'static str>,
    /// The checks that would prevent an engagement now.
    pub refusals: Vec<&'static str>,
    /// Whether an engagement is possible now.
    pub engagement: Lamp,
}

/// The flight control for channel values, and `silence` as in [`lamps`].
#[must_use]
pub fn control(value: impl Fn(Id) -> f64, silence: Option<&str>) -> Control {
    let place = |id| {
        let number = value(id);
        (number >= 0.0).then_some(number as usize)
    };
    let other = || {
        let kind = [Id::Autopilot, Id::VehicleKind].map(|id| place(id).unwrap_or(0) as u8);
        Some(modes::name(kind[0], kind[1], u32::try_from(place(Id::CustomMode)?).ok()?))
    };
    let own =
        place(Id::SystemMode).and_then(|mode| SystemMode::from_code(u8::try_from(mode).ok()?));
    let own = own.map(|mode| mode.name().to_owned());
    let unknown = silence.unwrap_or("unknown");
    let flies = own.or_else(other).unwrap_or_else(|| unknown.into());
    let mode = place(Id::AutopilotMode).and_then(|mode| Some(Mode::ALL.get(mode)?.name()));
    let flags = ControlFlags::from_bits(place(Id::Control).unwrap_or(0) as u8);
    let states = [
        (flags.switch_on, "the switch is closed"),
        (flags.refused, "the switch has no effect until it is opened once"),
        (flags.pilot_lost, "the pilot's signal is lost: the autopilot holds"),
        (flags.descends, "no pilot: the autopilot descends"),
        (flags.outside_geofence, "the geofence is reached: the autopilot returns"),
        (flags.at_end, "a control is at its limit"),
        (flags.excited, "the autopilot flies a test input"),
    ];
    let failed = place(Id::FailedChecks);
    let refusals: Vec<_> = Check::ALL
        .iter()
        .enumerate()
        .filter(|(bit, _)| failed.unwrap_or(0) >> bit & 1 != 0)
        .map(|(_, check)| check.name())
        .collect();
    let (light, why) = match (mode.and(failed), refusals.len()) {
        (None, _) => (Light::Unknown, silence.unwrap_or("not reported").to_owned()),
        (_, 1) => (Light::Bad, "refused: 1 check fails".into()),
        (_, 2..) => (Light::Bad, format!("refused: {} checks fail", refusals.len())),
        _ if flags.refused => (Light::Care, "open the switch first".into()),
        _ => (Light::Good, "ready".into()),
    };
    Control {
        flies,
        mode,
        states: states.into_iter().filter(|(is, _)| *is).map(|(_, words)| words).collect(),
        refusals,
        engagement: lamp("engagement", light, why),
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
        let lamps = lamps(value, None);
        let of = |name| lamps.iter().find(|lamp| lamp.name == name).unwrap();
        assert_eq!(of("inertial unit").light, Light::Good);
        assert_eq!(of("GPS").why, "no fix, 3 satellites");
        assert_eq!(of("attitude").why, "one-sigma 9.50 °, at most 6.9 °");
        assert_eq!(of("velocity").why, "no estimate");
    }

    #[test]
    fn what_a_vehicle_does_not_tell_is_no_fault_of_its() {
        let own = |id| match id {
            Id::Status => f64::from(StatusFlags { attitude: true, ..Default::default() }.bits()),
            Id::StatusKnown => {
                let known = StatusFlags { attitude: true, position: true, ..Default::default() };
                f64::from(known.bits())
            }
            Id::BaseMode => 0x51.into(),
            _ => f64::NAN,
        };
        let lamps = lamps(own, None);
        let of = |name| lamps.iter().find(|lamp| lamp.name == name).unwrap();
        assert_eq!((of("pilot").light, of("pilot").why.as_str()), (Light::Unknown, "not reported"));
        assert_eq!((of("attitude").light, of("position").light), (Light::Good, Light::Care));
        assert_eq!(of("arming").why, "not armed");
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
        let control = control(value, None);
        assert_eq!((control.flies.as_str(), control.mode), ("the pilot", Some("manual")));
        assert_eq!(control.refusals, ["age of the last fix, s", "servos"]);
        assert_eq!(control.states, ["the switch is closed"]);
        assert_eq!(control.engagement.why, "refused: 2 checks fail");
    }
}
