//! Whether the servos reach the deflections of the autopilot's sticks.

use super::error::FlyConfigError;
use super::sections::ServoSection;
use hovernav::autopilot::{HoverConfig, StickLimits};
use hovernav::controls::{Channel, Sticks};
use hovernav::servo::SwashplateKind;

/// Smallest travel of a control from hover trim to each of its limits, as a fraction of full stick.
pub(super) const ROOM: f64 = 0.01;
/// Smallest travel of a servo from its `trim_ms` to each end of its range, as a fraction of full stick.
const TRAVEL: f64 = 0.1;
/// Tolerance of pulse widths, ms, below the resolution of a servo.
const RESOLUTION_MS: f64 = 1e-3;

/// The channels of the autopilot, in the order of [`Sticks`].
const MOVED: [Channel; 4] =
    [Channel::Lateral, Channel::Longitudinal, Channel::Collective, Channel::Pedal];

/// Rejects a servo of the autopilot that can move one way only from trim.
pub(super) fn check_travel(servo: &ServoSection) -> Result<(), FlyConfigError> {
    for channel in MOVED {
        let config = servo.channels[channel];
        let way_ms = TRAVEL * config.travel_ms;
        for (key, end_ms, has) in [
            ("min_ms", config.min_ms, config.trim_ms - config.min_ms),
            ("max_ms", config.max_ms, config.max_ms - config.trim_ms),
        ] {
            if has < way_ms {
                let why = format!(
                    "found {} with {key} = {end_ms}, expected at least {way_ms} ms between them, {TRAVEL} of \
                     full stick: the autopilot moves the servo both ways",
                    config.trim_ms
                );
                return Err(FlyConfigError::value(section(channel), "trim_ms", &why));
            }
        }
    }
    Ok(())
}

/// The limits of `config`, reduced to the range of the servos and of collective. If a deflection were limited outside
/// the autopilot, the integrators of the autopilot would wind up.
///
/// # Errors
/// A servo range without room on both sides of hover trim. A swashplate on which a control does not reach its limits
/// while the others are at hover trim.
pub(super) fn within_servos(
    config: &HoverConfig,
    servo: &ServoSection,
) -> Result<StickLimits, FlyConfigError> {
    let (plate, trim) = (&servo.swashplate, config.trim.sticks);
    let mut limits = config.limits;
    limits.lowest.collective = limits.lowest.collective.max(plate.lowest_collective);
    limits.highest.collective = limits.highest.collective.min(plate.highest_collective);
    let collective = trim.collective;
    for (key, limit, room) in [
        ("lowest_collective", plate.lowest_collective, collective - limits.lowest.collective),
        ("highest_collective", plate.highest_collective, limits.highest.collective - collective),
    ] {
        if room < ROOM {
            let why = format!(
                "found {limit}, expected {ROOM} of full stick beyond the autopilot's hover trim, {collective}"
            );
            return Err(FlyConfigError::value("servo.swashplate", key, &why));
        }
    }
    let mixes = plate.kind != SwashplateKind::H1;
    let (mut lowest, mut highest) = (limits.lowest.to_array(), limits.highest.to_array());
    for (stick, channel) in MOVED.into_iter().enumerate() {
        if mixes && channel != Channel::Pedal {
            let ends = [lowest[stick], highest[stick]];
            check_mixing(servo, trim, stick, ends)?;
            continue;
        }
        let own = servo.channels[channel];
        let ends = [own.stick(own.min_ms), own.stick(own.max_ms)];
        let (least, most) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let at = trim.to_array()[stick];
        if at - least < ROOM || most - at < ROOM {
            let why = format!(
                "found {} to {} ms, which is {least:.2} to {most:.2} of full stick, expected {ROOM} of full stick to \
                 either side of the autopilot's hover trim, {at}",
                own.min_ms, own.max_ms
            );
            return Err(FlyConfigError::value(section(channel), "min_ms, max_ms", &why));
        }
        lowest[stick] = lowest[stick].max(least);
        highest[stick] = highest[stick].min(most);
    }
    limits.lowest = Sticks::from_array(lowest);
    limits.highest = Sticks::from_array(highest);
    Ok(limits)
}

/// Checks that the servos of a mixed plate reach both `ends` of the control `stick`, with the others at hover `trim`.
fn check_mixing(
    servo: &ServoSection,
    trim: Sticks,
    stick: usize,
    ends: [f64; 2],
) -> Result<(), FlyConfigError> {
    for end in ends {
        let mut sticks = trim.to_array();
        sticks[stick] = end;
        let widths_ms =
            servo.swashplate.widths_ms(&servo.channels, Sticks::from_array(sticks), f64::NAN);
        for channel in &MOVED[..3] {
            let (own, width_ms) = (servo.channels[*channel], widths_ms[*channel]);
            if width_ms >= own.min_ms - RESOLUTION_MS && width_ms <= own.max_ms + RESOLUTION_MS {
                continue;
            }
            let why = format!(
                "found a mixing that moves the servo {channel} to {width_ms:.3} ms with this stick at the \
                 autopilot's limit, {end}, and the others at hover trim, expected {} to {} ms: reduce it, or \
                 limits.lowest and limits.highest in the autopilot's file",
                own.min_ms, own.max_ms
            );
            return Err(FlyConfigError::value("servo.swashplate", MOVED[stick].name(), &why));
        }
    }
    Ok(())
}

fn section(channel: Channel) -> String {
    format!("servo.channels.{}", channel.name())
}
