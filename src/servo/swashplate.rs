//! The swashplate: conversion from sticks to servo positions, and back.

use super::config::{ChannelConfig, ConfigError, within};
use crate::controls::{Channel, Channels, Sticks};
use crate::scalar::Scalar;

/// Arrangement of the servos under the swashplate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(rename_all = "lowercase")
)]
pub enum SwashplateKind {
    /// Mechanical mixing: each control has its own servo.
    #[default]
    H1,
    /// Three servos: one at the rear, two at 90° to it.
    Ccpm90,
    /// Three servos: one at the rear, two at 120° to it.
    Ccpm120,
    /// Three servos: one at the rear, two at 135° to it.
    Ccpm135,
    /// Three servos: one at the rear, two at 140° to it.
    Ccpm140,
}

impl SwashplateKind {
    /// Angle from the nose to the servos at the sides, rad; `None` for a swashplate without mixing.
    fn side_rad(self) -> Option<f64> {
        let from_behind_deg: f64 = match self {
            Self::H1 => return None,
            Self::Ccpm90 => 90.0,
            Self::Ccpm120 => 120.0,
            Self::Ccpm135 => 135.0,
            Self::Ccpm140 => 140.0,
        };
        Some((180.0 - from_behind_deg).to_radians())
    }
}

/// The swashplate and its mixing.
///
/// The plate is a plane over servos at equal distances from the mast. In a CCPM plate the channel `longitudinal` drives
/// the servo at the rear, `lateral` the servo at the right, and `collective` the servo at the left. A positive
/// longitudinal stick raises the front, a positive lateral stick the right, a positive collective all three.
/// `direction` of a channel reverses its servo; a negative `longitudinal` or `lateral` of this structure reverses the
/// control.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct Swashplate {
    /// Arrangement of the servos.
    pub kind: SwashplateKind,
    /// Angle by which the direction of the plate's tilt leads that of the control, °, within ±45. Positive from the
    /// nose to the right.
    pub phase_deg: f64,
    /// Rise of the plate at full lateral stick, at the side that rises most, in stick fractions of a servo. Magnitude
    /// 0.05 to 1, either sign.
    pub lateral: f64,
    /// Rise of the plate at full longitudinal stick, at the side that rises most, in stick fractions of a servo.
    /// Magnitude 0.05 to 1, either sign.
    pub longitudinal: f64,
    /// Travel of all servos at full collective stick, in stick fractions of a servo. Magnitude 0.05 to 1, either sign.
    pub collective: f64,
    /// Lower limit of the collective stick, −1 to −0.05.
    pub lowest_collective: f64,
    /// Upper limit of the collective stick, 0.05 to 1.
    pub highest_collective: f64,
    /// Whether the pilot's pulses are captured after the receiver's own mixer. They are then the positions of the
    /// servos, not of the sticks.
    pub pilot_is_mixed: bool,
}

impl Default for Swashplate {
    fn default() -> Self {
        Self {
            kind: SwashplateKind::H1,
            phase_deg: 0.0,
            lateral: 0.5,
            longitudinal: 0.5,
            collective: 0.5,
            lowest_collective: -1.0,
            highest_collective: 1.0,
            pilot_is_mixed: false,
        }
    }
}

impl Swashplate {
    /// Checks that the settings are finite and in their ranges. Each control alone must be able to reach its end within
    /// the range of the servos of `channels`.
    ///
    /// # Errors
    /// [`ConfigError`] with the first invalid setting, or with the channel whose servo reaches its end before the
    /// control does.
    pub fn check(&self, channels: &Channels<ChannelConfig>) -> Result<(), ConfigError> {
        within("swashplate.phase_deg", self.phase_deg, -45.0, 45.0)?;
        within("swashplate.lowest_collective", self.lowest_collective, -1.0, 0.0)?;
        within("swashplate.highest_collective", self.highest_collective, 0.0, 1.0)?;
        // A plate without mixing does not use these settings, but they must be numbers.
        let mixes = self.kind != SwashplateKind::H1;
        for (key, travel) in [
            ("swashplate.lateral", self.lateral),
            ("swashplate.longitudinal", self.longitudinal),
            ("swashplate.collective", self.collective),
        ] {
            within(key, libm::fabs(travel), if mixes { 0.05 } else { 0.0 }, 1.0)?;
        }
        if !mixes {
            return Ok(());
        }
        let ends = [
            Sticks { lateral: 1.0, ..Sticks::NEUTRAL },
            Sticks { lateral: -1.0, ..Sticks::NEUTRAL },
            Sticks { longitudinal: 1.0, ..Sticks::NEUTRAL },
            Sticks { longitudinal: -1.0, ..Sticks::NEUTRAL },
            Sticks { collective: 1.0, ..Sticks::NEUTRAL },
            Sticks { collective: -1.0, ..Sticks::NEUTRAL },
        ];
        for end in ends {
            let servos = self.servos(end);
            for (channel, stick) in [
                (Channel::Lateral, servos.lateral),
                (Channel::Longitudinal, servos.longitudinal),
                (Channel::Collective, servos.collective),
            ] {
                let config = channels[channel];
                let value = config.width_ms(stick);
                let (from, to) = (config.min_ms, config.max_ms);
                // A microsecond is below the resolution of a servo. Written so that a NaN is rejected.
                if !(value >= from - 1e-3 && value <= to + 1e-3) {
                    let key = "swashplate: width at full stick, ms,";
                    return Err(ConfigError { channel: Some(channel), key, value, from, to });
                }
            }
        }
        Ok(())
    }

    /// Whether the pilot's pulses can go to the servos unchanged: no mixing is needed, or the receiver mixes.
    #[must_use]
    pub fn passes_through(&self) -> bool {
        self.kind == SwashplateKind::H1 || self.pilot_is_mixed
    }

    /// Positions of the servos, each a stick fraction of its own channel, for `sticks`; collective is limited. A stick
    /// that is NaN or infinite gives NaN for every servo that it moves. On a mixed plate these are all three servos,
    /// because two servos alone cannot keep the plate level. The limiter holds servos whose command is NaN.
    ///
    /// # Source
    /// Equation (C10) of docs/equations.md.
    #[must_use]
    pub fn servos(&self, sticks: Sticks) -> Sticks {
        let sticks = Sticks::from_array(sticks.to_array().map(finite));
        // `max` and `min` would replace a NaN by a limit: full collective instead of no command.
        let collective = if sticks.collective.is_nan() {
            f64::NAN
        } else {
            sticks.collective.max(self.lowest_collective).min(self.highest_collective)
        };
        let Some(side_rad) = self.kind.side_rad() else { return Sticks { collective, ..sticks } };
        let plate = sticks.lateral + sticks.longitudinal + collective;
        if plate.is_nan() {
            let none = f64::NAN;
            return Sticks { lateral: none, longitudinal: none, collective: none, ..sticks };
        }
        let (sin_phase, cos_phase) = self.phase_deg.to_radians().sincos();
        let (right, front) =
            (self.lateral * sticks.lateral, self.longitudinal * sticks.longitudinal);
        let (right, front) =
            (cos_phase * right + sin_phase * front, cos_phase * front - sin_phase * right);
        let (sin, cos) = side_rad.sincos();
        let all = self.collective * collective;
        Sticks {
            longitudinal: all - front,
            lateral: all + cos * front + sin * right,
            collective: all + cos * front - sin * right,
            pedal: sticks.pedal,
        }
    }

    /// The sticks for the servo positions `servos`: the inverse of [`servos`](Self::servos) within the limits of
    /// collective.
    ///
    /// # Source
    /// Equation (C10) of docs/equations.md.
    #[must_use]
    pub fn sticks(&self, servos: Sticks) -> Sticks {
        let Some(side_rad) = self.kind.side_rad() else { return servos };
        let (sin, cos) = side_rad.sincos();
        let right = (servos.lateral - servos.collective) / (2.0 * sin);
        let sides = 0.5 * (servos.lateral + servos.collective);
        let front = (sides - servos.longitudinal) / (1.0 + cos);
        let all = servos.longitudinal + front;
        let (sin_phase, cos_phase) = self.phase_deg.to_radians().sincos();
        Sticks {
            lateral: (cos_phase * right - sin_phase * front) / self.lateral,
            longitudinal: (cos_phase * front + sin_phase * right) / self.longitudinal,
            collective: all / self.collective,
            pedal: servos.pedal,
        }
    }

    /// The pilot's sticks from the widths of the pulses, ms; `None` unless all four are present and finite.
    #[must_use]
    pub fn pilot_sticks(
        &self,
        channels: &Channels<ChannelConfig>,
        pilot_ms: &Channels<Option<f64>>,
    ) -> Option<Sticks> {
        let fraction = pilot_ms
            .zip(*channels)
            .map(|(width_ms, config)| width_ms.map(|width_ms| config.stick(width_ms)));
        let said = Sticks {
            lateral: fraction.lateral?,
            longitudinal: fraction.longitudinal?,
            collective: fraction.collective?,
            pedal: fraction.pedal?,
        };
        let sticks = if self.pilot_is_mixed { self.sticks(said) } else { said };
        sticks.is_finite().then_some(sticks)
    }

    /// The widths, ms, for the servos from the pilot's pulses: unchanged where no mixing is needed, otherwise mixed. A
    /// width is NaN if its pulse is missing or not a number. If the pulse of one mixed control is missing, the widths
    /// of all three servos are NaN. Unmixed pulses would tilt the plate in any direction.
    #[must_use]
    pub fn passed_on_ms(
        &self,
        channels: &Channels<ChannelConfig>,
        pilot_ms: &Channels<Option<f64>>,
    ) -> Channels<f64> {
        let mut own_ms = pilot_ms.map(|width_ms| width_ms.map_or(f64::NAN, finite));
        if self.passes_through() {
            let plate = [own_ms.lateral, own_ms.longitudinal, own_ms.collective];
            if self.kind != SwashplateKind::H1 && plate.iter().any(|width_ms| width_ms.is_nan()) {
                (own_ms.lateral, own_ms.longitudinal, own_ms.collective) =
                    (f64::NAN, f64::NAN, f64::NAN);
            }
            return own_ms;
        }
        let said = own_ms.zip(*channels).map(|(width_ms, config)| config.stick(width_ms));
        let Channels { lateral, longitudinal, collective, pedal, throttle: _ } = said;
        let sticks = Sticks { lateral, longitudinal, collective, pedal };
        self.widths_ms(channels, sticks, own_ms.throttle)
    }

    /// The widths, ms, that move the servos to the positions for `sticks`; not limited. The throttle is passed
    /// through.
    #[must_use]
    pub fn widths_ms(
        &self,
        channels: &Channels<ChannelConfig>,
        sticks: Sticks,
        throttle_ms: f64,
    ) -> Channels<f64> {
        let servos = self.servos(sticks);
        Channels {
            throttle: throttle_ms,
            collective: channels.collective.width_ms(servos.collective),
            longitudinal: channels.longitudinal.width_ms(servos.longitudinal),
            lateral: channels.lateral.width_ms(servos.lateral),
            pedal: channels.pedal.width_ms(servos.pedal),
        }
    }
}

/// `value` if finite; otherwise NaN.
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    use super::*;

    const MIXED: [SwashplateKind; 4] = [
        SwashplateKind::Ccpm90,
        SwashplateKind::Ccpm120,
        SwashplateKind::Ccpm135,
        SwashplateKind::Ccpm140,
    ];

    fn close(a: Sticks, b: Sticks) -> bool {
        a.farthest_from(b) < 1e-12
    }

    proptest! {
        #[test]
        fn sticks_and_servos_are_inverse_for_every_plate(
            sticks in prop::array::uniform4(-1.0f64..1.0).prop_map(Sticks::from_array),
            kind in prop::sample::select(&[SwashplateKind::H1, MIXED[0], MIXED[1], MIXED[2], MIXED[3]]),
            phase_deg in -45.0f64..45.0,
            gains in prop::array::uniform3(0.05f64..1.0),
            turned in any::<[bool; 2]>(),
        ) {
            let sign = |turned, gain: f64| if turned { -gain } else { gain };
            let plate = Swashplate {
                kind,
                phase_deg,
                lateral: sign(turned[0], gains[0]),
                longitudinal: sign(turned[1], gains[1]),
                collective: gains[2],
                ..Swashplate::default()
            };
            prop_assert!(close(plate.sticks(plate.servos(sticks)), sticks));
        }

        #[test]
        fn the_pilots_pulses_come_out_as_they_went_in_before_and_behind_the_receivers_mixer(
            sticks in prop::array::uniform4(-0.9f64..0.9).prop_map(Sticks::from_array),
            kind in prop::sample::select(&MIXED),
        ) {
            let channels = Channels::<ChannelConfig>::default();
            let plate = Swashplate { kind, pilot_is_mixed: true, ..Swashplate::default() };
            let mixed = plate.widths_ms(&channels, sticks, 1.2);
            let read = plate.pilot_sticks(&channels, &mixed.map(Some)).unwrap();
            prop_assert!(close(read, sticks));
            let again = plate.widths_ms(&channels, read, 1.2);
            let same = again.zip(mixed).to_array().iter().all(|(a, b)| (a - b).abs() < 1e-12);
            prop_assert!(same);
        }
    }

    /// The plane through the three servos of a plate of radius 1 is level at collective. Cyclic tilts its normal by
    /// the commanded angle in the commanded direction.
    #[test]
    fn the_plane_through_the_servos_rises_where_it_should() {
        for kind in MIXED {
            let plate = Swashplate { kind, ..Swashplate::default() };
            let side = kind.side_rad().unwrap();
            let height = |sticks: Sticks, azimuth: f64| {
                // The plane through the servos, from their heights alone.
                let at = plate.servos(sticks);
                let right = (at.lateral - at.collective) / (2.0 * side.sin());
                let front =
                    (0.5 * (at.lateral + at.collective) - at.longitudinal) / (1.0 + side.cos());
                let middle = at.longitudinal + front;
                middle + front * azimuth.cos() + right * azimuth.sin()
            };
            let quarter = std::f64::consts::FRAC_PI_2;
            let forward = Sticks { longitudinal: 1.0, ..Sticks::NEUTRAL };
            let right = Sticks { lateral: 1.0, ..Sticks::NEUTRAL };
            let up = Sticks { collective: 1.0, ..Sticks::NEUTRAL };
            for azimuth in [0.0, 0.4, quarter, 2.0, 3.0, 4.5] {
                assert_abs_diff_eq!(height(forward, azimuth), 0.5 * azimuth.cos(), epsilon = 1e-12);
                assert_abs_diff_eq!(height(right, azimuth), 0.5 * azimuth.sin(), epsilon = 1e-12);
                assert_abs_diff_eq!(height(up, azimuth), 0.5, epsilon = 1e-12);
            }
        }
    }

    #[test]
    fn a_phase_angle_turns_the_tilt_towards_the_right() {
        let plate =
            Swashplate { kind: SwashplateKind::Ccpm90, phase_deg: 30.0, ..Swashplate::default() };
        let servos = plate.servos(Sticks { longitudinal: 1.0, ..Sticks::NEUTRAL });
        assert_abs_diff_eq!(servos.longitudinal, -0.5 * 30f64.to_radians().cos(), epsilon = 1e-12);
        assert_abs_diff_eq!(servos.lateral, 0.25, epsilon = 1e-12);
    }

    #[test]
    fn collective_keeps_to_its_limits() {
        for kind in [SwashplateKind::H1, SwashplateKind::Ccpm120] {
            let plate = Swashplate { kind, highest_collective: 0.4, ..Swashplate::default() };
            let wide_open = plate.servos(Sticks { collective: 1.0, ..Sticks::NEUTRAL });
            let limit = plate.servos(Sticks { collective: 0.4, ..Sticks::NEUTRAL });
            assert_eq!(wide_open, limit);
        }
    }

    #[test]
    fn mixing_that_cannot_reach_its_ends_is_refused_with_the_servo() {
        let plate = Swashplate { kind: SwashplateKind::Ccpm120, ..Swashplate::default() };
        let channels = Channels::<ChannelConfig>::default();
        assert_eq!(plate.check(&channels), Ok(()));
        let mut narrow = channels;
        narrow.lateral.max_ms = 1.6;
        assert_eq!(plate.check(&narrow).unwrap_err().channel, Some(Channel::Lateral));
        let error = Swashplate { longitudinal: 0.0, ..plate }.check(&channels).unwrap_err();
        assert_eq!(error.key, "swashplate.longitudinal");
        let error = Swashplate { phase_deg: f64::NAN, ..plate }.check(&channels).unwrap_err();
        assert_eq!(error.key, "swashplate.phase_deg");
    }

    /// A missing command must not become full-down collective, nor an incomplete command for a plate on three servos.
    #[test]
    fn a_stick_that_is_no_number_commands_no_servo_that_it_moves() {
        let channels = Channels::<ChannelConfig>::default();
        for kind in [SwashplateKind::H1, MIXED[0], MIXED[1], MIXED[2], MIXED[3]] {
            for pilot_is_mixed in [false, true] {
                let plate = Swashplate { kind, pilot_is_mixed, ..Swashplate::default() };
                for (stick, none) in (0..4).flat_map(|stick| {
                    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].map(|none| (stick, none))
                }) {
                    let mut sticks = [0.1; 4];
                    sticks[stick] = none;
                    let sticks = Sticks::from_array(sticks);
                    let widths_ms = plate.widths_ms(&channels, sticks, 1.2);
                    let said = [
                        widths_ms.lateral,
                        widths_ms.longitudinal,
                        widths_ms.collective,
                        widths_ms.pedal,
                    ];
                    let mixed = kind != SwashplateKind::H1;
                    for (servo, width_ms) in said.into_iter().enumerate() {
                        let moved = servo == stick || (mixed && servo < 3 && stick < 3);
                        let what = format!("{kind:?}: {sticks:?}: {said:?}");
                        assert_eq!(width_ms.is_nan(), moved, "{what}");
                        assert!(moved || (1.0..=2.0).contains(&width_ms), "{what}");
                    }
                    assert_eq!(plate.pilot_sticks(&channels, &widths_ms.map(Some)), None);
                }
            }
        }
    }

    #[test]
    fn pulses_of_a_mixed_plate_are_passed_on_mixed_or_not_at_all() {
        let channels = Channels::<ChannelConfig>::default();
        let plate = Swashplate { kind: SwashplateKind::Ccpm120, ..Swashplate::default() };
        let whole = Channels::from_fn(|_| Some(1.6));
        let mixed = plate.passed_on_ms(&channels, &whole);
        let sticks = plate.pilot_sticks(&channels, &whole).unwrap();
        assert_eq!(mixed, plate.widths_ms(&channels, sticks, 1.6));
        for missing in [Channel::Lateral, Channel::Longitudinal, Channel::Collective] {
            let mut part = whole;
            part[missing] = None;
            let passed = plate.passed_on_ms(&channels, &part);
            let servos = [passed.lateral, passed.longitudinal, passed.collective];
            assert!(servos.iter().all(|width_ms| width_ms.is_nan()), "{missing}: {passed:?}");
            assert_eq!((passed.pedal, passed.throttle), (1.6, 1.6));
        }
        let mixed_by_receiver = Swashplate { pilot_is_mixed: true, ..plate };
        assert_eq!(mixed_by_receiver.passed_on_ms(&channels, &whole), Channels::from_fn(|_| 1.6));
        for missing in [Channel::Lateral, Channel::Longitudinal, Channel::Collective] {
            let mut part = whole;
            part[missing] = None;
            let passed = mixed_by_receiver.passed_on_ms(&channels, &part);
            let servos = [passed.lateral, passed.longitudinal, passed.collective];
            assert!(servos.iter().all(|width_ms| width_ms.is_nan()), "{missing}: {passed:?}");
            assert_eq!((passed.pedal, passed.throttle), (1.6, 1.6));
        }
        let tailless = plate.passed_on_ms(&channels, &Channels { pedal: None, ..whole });
        assert_eq!(tailless.lateral, mixed.lateral);
        assert!(tailless.pedal.is_nan());
    }

    #[test]
    fn mixing_by_no_numbers_is_refused_whatever_the_plate() {
        let channels = Channels::<ChannelConfig>::default();
        for kind in [SwashplateKind::H1, SwashplateKind::Ccpm120] {
            for none in [f64::NAN, f64::INFINITY] {
                let good = Swashplate { kind, ..Swashplate::default() };
                for bad in [
                    Swashplate { phase_deg: none, ..good },
                    Swashplate { lateral: none, ..good },
                    Swashplate { longitudinal: none, ..good },
                    Swashplate { collective: none, ..good },
                    Swashplate { lowest_collective: none, ..good },
                    Swashplate { highest_collective: none, ..good },
                ] {
                    assert!(bad.check(&channels).is_err(), "{bad:?}");
                }
            }
        }
        let plate = Swashplate { kind: SwashplateKind::Ccpm120, ..Swashplate::default() };
        let mut bad = channels;
        bad.collective.trim_ms = f64::NAN;
        assert_eq!(plate.check(&bad).unwrap_err().channel, Some(Channel::Collective));
    }
}
