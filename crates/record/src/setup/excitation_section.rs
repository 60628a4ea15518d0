//! `[autopilot.excitation]` of `fly.toml`: test inputs that the autopilot flies automatically.

use serde::{Deserialize, Serialize};

use hovernav::autopilot::{ExcitationLimits, ExcitationProgramme, Maneuver, TestInput};
use hovernav::controls::Channel;

/// `[autopilot.excitation]`: test inputs for an identification flight. The autopilot flies them automatically while it
/// holds, one after the other.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExcitationSection {
    /// Time from engagement to the first input, s, 2 to 600.
    pub first_s: f64,
    /// Time from the end of one input to the start of the next, s, 1 to 600.
    pub pause_s: f64,
    /// Deflection of a pilot's stick from its position at engagement that ends all inputs until the next engagement,
    /// 0.01 to 0.5.
    pub dead_band: f64,
    /// Rate limit of the inputs, full travels a second, 0.1 to 50.
    pub stick_rate_per_s: f64,
    /// Roll or pitch that ends the inputs, rad, 0.02 to 0.8.
    pub tilt_rad: f64,
    /// Angular rate that ends the inputs, rad/s, 0.05 to 10.
    pub rate_radps: f64,
    /// Deviation from the commanded velocity that ends the inputs, m/s, 0.2 to 20.
    pub speed_mps: f64,
    /// The inputs, in the order of flight; 1 to 16 including repetitions.
    pub inputs: Vec<InputSection>,
}

impl Default for ExcitationSection {
    fn default() -> Self {
        let limits = ExcitationLimits::default();
        Self {
            first_s: 15.0,
            pause_s: 8.0,
            dead_band: 0.05,
            stick_rate_per_s: 4.0,
            tilt_rad: limits.tilt_rad,
            rate_radps: limits.rate_radps,
            speed_mps: limits.speed_mps,
            inputs: Vec::new(),
        }
    }
}

/// `[[autopilot.excitation.inputs]]`: one test input.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct InputSection {
    /// Stick that is moved.
    pub stick: StickName,
    /// Shape of the input.
    pub kind: InputKind,
    /// Amplitude from the current position, as a fraction of full stick, −0.5 to 0.5; 0.1 where not set.
    #[serde(default = "amplitude")]
    pub amplitude: f64,
    /// Length, s: of a step (1.5 where not set), of each side of a doublet (1), of a unit of a 3-2-1-1 (0.5), of a
    /// whole sweep (60).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_s: Option<f64>,
    /// Start frequency of a sweep, Hz, 0.01 to 20; 0.1 where not set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first_hz: Option<f64>,
    /// End frequency of a sweep, Hz, up to 20; 3 where not set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_hz: Option<f64>,
    /// Number of repetitions, 1 to 16; 1 where not set.
    #[serde(default = "once")]
    pub times: u8,
}

const fn amplitude() -> f64 {
    0.1
}

const fn once() -> u8 {
    1
}

/// A stick of the helicopter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum StickName {
    /// Lateral cyclic.
    Lateral,
    /// Longitudinal cyclic.
    Longitudinal,
    /// Collective.
    Collective,
    /// Pedal.
    Pedal,
}

/// Shape of a test input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum InputKind {
    /// Out, held, and back.
    #[serde(rename = "step")]
    Step,
    /// Equal times to one side and to the other.
    #[serde(rename = "doublet")]
    Doublet,
    /// Pulses of 3, 2, 1 and 1 units to alternating sides.
    #[serde(rename = "3211")]
    ThreeTwoOneOne,
    /// A sine with rising frequency, slow at first.
    #[serde(rename = "sweep")]
    Sweep,
}

/// Fraction of a sweep over which it fades in, and over which it fades out.
const FADE: f64 = 0.05;

impl InputSection {
    fn test_input(&self) -> TestInput {
        let stick = match self.stick {
            StickName::Lateral => Channel::Lateral,
            StickName::Longitudinal => Channel::Longitudinal,
            StickName::Collective => Channel::Collective,
            StickName::Pedal => Channel::Pedal,
        };
        let amplitude = self.amplitude;
        let length_s = |default_s| self.length_s.unwrap_or(default_s);
        let maneuver = match self.kind {
            InputKind::Step => Maneuver::Step { amplitude, hold_s: length_s(1.5) },
            InputKind::Doublet => Maneuver::Doublet { amplitude, hold_s: length_s(1.0) },
            InputKind::ThreeTwoOneOne => {
                Maneuver::ThreeTwoOneOne { amplitude, unit_s: length_s(0.5) }
            }
            InputKind::Sweep => Maneuver::Sweep {
                amplitude,
                first_hz: self.first_hz.unwrap_or(0.1),
                last_hz: self.last_hz.unwrap_or(3.0),
                duration_s: length_s(60.0),
                fade_s: FADE * length_s(60.0),
            },
        };
        TestInput { stick, maneuver }
    }

    /// The name of a key that is set but does not apply to this kind of input.
    fn meaningless(&self) -> Option<&'static str> {
        let sweeps = self.kind == InputKind::Sweep;
        let first = self.first_hz.map(|_| "first_hz");
        first.or(self.last_hz.map(|_| "last_hz")).filter(|_| !sweeps)
    }
}

impl ExcitationSection {
    /// The excitation for flight control.
    ///
    /// # Errors
    /// A sentence with found and expected values.
    pub(super) fn programme(&self) -> Result<ExcitationProgramme, String> {
        let flown: Vec<TestInput> = self
            .inputs
            .iter()
            .flat_map(|input| (0..input.times).map(|_| input.test_input()))
            .collect();
        let (count, most) = (flown.len(), ExcitationProgramme::MAX);
        if count == 0 || count > most || self.inputs.iter().any(|input| input.times == 0) {
            return Err(format!(
                "inputs: found {count} including repetitions, expected 1 to {most}, each at least once"
            ));
        }
        if let Some(key) = self.inputs.iter().find_map(InputSection::meaningless) {
            return Err(format!("inputs: found {key}, expected it for a sweep only"));
        }
        let programme = ExcitationProgramme {
            inputs: std::array::from_fn(|index| flown.get(index).copied()),
            first_s: self.first_s,
            pause_s: self.pause_s,
            dead_band: self.dead_band,
            limits: ExcitationLimits {
                tilt_rad: self.tilt_rad,
                rate_radps: self.rate_radps,
                speed_mps: self.speed_mps,
                stick_rate_per_s: self.stick_rate_per_s,
            },
        };
        programme.check().map_err(|error| error.to_string())?;
        Ok(programme)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FlyConfig;

    fn parsed(excitation: &str) -> Result<FlyConfig, String> {
        let text = format!(
            "[dmu]\nport = 'a'\n[receiver]\nport = 'b'\n[servo.capture]\nserial = {{ port = 'c' }}\n\
             [autopilot]\nfile = 'autopilot.toml'\n[autopilot.excitation]\n{excitation}"
        );
        FlyConfig::parse(&text, "fly.toml".as_ref()).map_err(|error| error.to_string())
    }

    #[test]
    fn inputs_with_their_repetitions_become_a_programme() {
        let text = "inputs = [{ stick = 'pedal', kind = '3211', times = 3 }, \
                    { stick = 'lateral', kind = 'sweep', amplitude = -0.05, last_hz = 2.0 }]";
        let section = parsed(text).unwrap().autopilot.unwrap().excitation.unwrap();
        let programme = section.programme().unwrap();
        let sticks: Vec<Channel> =
            programme.inputs.iter().flatten().map(|input| input.stick).collect();
        assert_eq!(sticks, [Channel::Pedal, Channel::Pedal, Channel::Pedal, Channel::Lateral]);
        let sweep = Maneuver::Sweep {
            amplitude: -0.05,
            first_hz: 0.1,
            last_hz: 2.0,
            duration_s: 60.0,
            fade_s: 3.0,
        };
        assert_eq!(programme.inputs[3].map(|input| input.maneuver), Some(sweep));
    }

    #[test]
    fn what_cannot_be_flown_is_refused_with_what_was_found() {
        let one = "inputs = [{ stick = 'pedal', kind = 'step' }]";
        for (text, expected) in [
            (String::new(), "found 0 including repetitions, expected 1 to 16"),
            (one.replace("'step'", "'step', times = 17"), "times: found 17, expected 1 to 16"),
            (one.replace("'step'", "'step', times = 0"), "times: found 0, expected 1 to 16"),
            (
                one.replace(
                    "'step' }",
                    "'step', times = 9 }, { stick = 'pedal', kind = 'step', times = 8 }",
                ),
                "found 17 including repetitions",
            ),
            (
                one.replace("'step'", "'step', last_hz = 2.0"),
                "found last_hz, expected it for a sweep",
            ),
            (one.replace("'step'", "'step', amplitude = 0.9"), "amplitude: found 0.9"),
            (one.replace("'step'", "'step', amplitude = nan"), "amplitude: found NaN"),
            (one.replace("'pedal'", "'throttle'"), "throttle"),
            (one.replace("'step'", "'step', hold = 3"), "hold"),
            (format!("{one}\nspeed_mps = nan"), "speed_mps: found NaN"),
            (format!("{one}\nfirst_s = 0.1"), "first_s: found 0.1, expected 2 to 600 s"),
            (format!("{one}\nstick_rate_per_s = 0"), "stick_rate_per_s: found 0"),
        ] {
            let error = parsed(&text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
