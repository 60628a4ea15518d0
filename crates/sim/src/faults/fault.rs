//! A fault in text form: `NAME[=VALUE][@[START][:DURATION]]`.

use std::fmt;
use std::str::FromStr;

use super::catalogue::{CATALOGUE, Kind, Lasts, Values};
use super::window::{Window, drawn_start_s};
use crate::noise::Noise;

/// A fault to inject: its kind, severity and time.
///
/// ```
/// use hovernav_sim::faults::{Fault, Kind};
/// let fault: Fault = "glitch-step=60@120:15".parse()?;
/// assert_eq!(fault.kind, Kind::GlitchStep);
/// assert_eq!((fault.number, fault.start_s, fault.duration_s), (60.0, Some(120.0), Some(15.0)));
/// assert!("glitch-step=far".parse::<Fault>().is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// Kind.
    pub kind: Kind,
    /// Number of the fault, in the unit of its [`Entry`](super::Entry); NaN for a kind without a number.
    pub number: f64,
    /// Word of the fault; empty for a kind without a word.
    pub word: &'static str,
    /// Start, s on the log's clock; random if `None`.
    pub start_s: Option<f64>,
    /// Duration, s; the default duration in the fault's [`Entry`](super::Entry) if `None`.
    pub duration_s: Option<f64>,
}

impl Fault {
    /// Time window of the fault in a log that spans `span_s`.
    pub(super) fn window(&self, span_s: (f64, f64), noise: &mut Noise) -> Window {
        let lasts = self.kind.entry().lasts;
        let duration_s = match (self.duration_s, lasts) {
            (Some(duration_s), _) => duration_s,
            (None, Lasts::For(duration_s)) => duration_s,
            (None, Lasts::ItsValue) => self.number,
            (None, Lasts::Throughout | Lasts::Onwards) => f64::INFINITY,
        };
        // The random number is always drawn, so that the other draws of a seed do not depend on its use.
        let share = noise.uniform();
        match (self.start_s, lasts) {
            (Some(start_s), _) => Window { start_s, duration_s },
            (None, Lasts::Throughout) if self.duration_s.is_none() => Window::ALL,
            (None, Lasts::Onwards) if self.duration_s.is_none() => {
                Window { start_s: drawn_start_s(span_s, 60.0, share), duration_s }
            }
            (None, _) => Window { start_s: drawn_start_s(span_s, duration_s, share), duration_s },
        }
    }
}

impl Fault {
    /// Whether the fault has a random part.
    #[must_use]
    pub fn is_drawn(&self) -> bool {
        let moves = self.start_s.is_none()
            && (self.duration_s.is_some() || self.kind.entry().lasts != Lasts::Throughout);
        let has_random_values = matches!(
            self.kind,
            Kind::Vibration
                | Kind::ClipBurst
                | Kind::PacketLoss
                | Kind::Jitter
                | Kind::GyroBias
                | Kind::AccelBias
                | Kind::GlitchStep
                | Kind::GlitchRamp
                | Kind::GlitchFollow
                | Kind::GpsGarbage
                | Kind::MagVector
                | Kind::MagVectorOnly
                | Kind::LeverArm
                | Kind::RangeOutliers
        );
        moves || has_random_values
    }
}

impl FromStr for Fault {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (what, when) = text.split_once('@').map_or((text, None), |(a, b)| (a, Some(b)));
        let (name, value) = what.split_once('=').map_or((what, None), |(a, b)| (a, Some(b)));
        let entry = CATALOGUE.iter().find(|entry| entry.name == name).ok_or_else(|| {
            let names = CATALOGUE.map(|entry| entry.name).join(", ");
            format!("found fault \"{name}\", expected one of {names}")
        })?;
        let rejected = |found: &str, expected: String| {
            Err(format!("{name}: found \"{found}\", expected {expected}"))
        };
        let (number, word) = match (entry.values, value) {
            (Values::None, None) => (f64::NAN, ""),
            (Values::None, Some(found)) => return rejected(found, "no value".into()),
            (Values::Number(_, default, _), None) => (default, ""),
            (Values::Number(low, _, high), Some(found)) => match found.trim().parse::<f64>() {
                Ok(number) if (low..=high).contains(&number) => (number, ""),
                _ => return rejected(found, format!("{low} to {high} {}", entry.unit)),
            },
            (Values::Words(words), found) => {
                let wanted = found.unwrap_or(words[0]);
                match words.iter().find(|word| **word == wanted) {
                    Some(word) => (f64::NAN, *word),
                    None => return rejected(wanted, format!("one of {}", words.join(", "))),
                }
            }
        };
        let (start_s, duration_s) = match when {
            None => (None, None),
            Some(when) => {
                let (start, duration) =
                    when.split_once(':').map_or((when, None), |(a, b)| (a, Some(b)));
                let seconds =
                    |text: &str| text.trim().parse::<f64>().ok().filter(|s| s.is_finite());
                let expected = || "START, START:DURATION or :DURATION in seconds".into();
                let start_s = match start.is_empty() && duration.is_some() {
                    true => None,
                    false => match seconds(start) {
                        Some(start_s) => Some(start_s),
                        None => return rejected(when, expected()),
                    },
                };
                let duration_s = match duration.map(seconds) {
                    None => None,
                    Some(Some(duration_s)) if duration_s > 0.0 => Some(duration_s),
                    Some(_) => return rejected(when, expected()),
                };
                (start_s, duration_s)
            }
        };
        Ok(Self { kind: entry.kind, number, word, start_s, duration_s })
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let entry = self.kind.entry();
        f.write_str(entry.name)?;
        match entry.values {
            Values::Number(..) => write!(f, "={}", self.number)?,
            Values::Words(_) => write!(f, "={}", self.word)?,
            Values::None => {}
        }
        match (self.start_s, self.duration_s) {
            (None, None) => Ok(()),
            (Some(start_s), None) => write!(f, "@{start_s}"),
            (None, Some(duration_s)) => write!(f, "@:{duration_s}"),
            (Some(start_s), Some(duration_s)) => write!(f, "@{start_s}:{duration_s}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_is_written_as_it_is_read() {
        for text in [
            "vibration=4",
            "gap=2@100",
            "stuck=ax@:5",
            "stuck=gz@7:0.5",
            "no-velocity",
            "swap-axes=yz",
        ] {
            assert_eq!(text.parse::<Fault>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn what_is_no_fault_is_refused_by_name() {
        for (text, words) in [
            ("vibrations=4", "found fault \"vibrations\""),
            ("vibration=-1", "expected 0 to 20"),
            ("vibration=nan", "expected 0 to 20"),
            ("stuck=p", "expected one of all"),
            ("no-velocity=1", "expected no value"),
            ("gap@x", "START, START:DURATION or"),
            ("gap@1:0", "START, START:DURATION or"),
            ("", "found fault \"\""),
        ] {
            let refusal = text.parse::<Fault>().unwrap_err();
            assert!(refusal.contains(words), "{text}: {refusal}");
        }
    }
}
