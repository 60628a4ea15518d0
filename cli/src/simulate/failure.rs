//! `--fault`: failures of the vehicle.

use std::str::FromStr;

use hovernav::controls::Sticks;
use hovernav_sim::FlightEvent;

use crate::arguments::second;

/// Failure and its time in the form `NAME@SECOND`.
#[derive(Clone, Debug)]
pub struct Failure {
    pub event: FlightEvent,
    pub at_s: f64,
}

impl FromStr for Failure {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "found \"{text}\", expected NAME@SECOND with NAME one of power-loss, jam-lateral, \
                 jam-longitudinal, jam-collective, jam-pedal and SECOND from 0 to a day"
            )
        };
        let (name, at) = text.split_once('@').ok_or_else(expected)?;
        let at_s = second(at).ok_or_else(expected)?;
        let jammed = name.strip_prefix("jam-");
        let stick = jammed.and_then(|stick| Sticks::NAMES.iter().position(|own| *own == stick));
        let event = match (name, stick) {
            ("power-loss", _) => FlightEvent::PowerLoss,
            (_, Some(stick)) => FlightEvent::Jam(stick),
            _ => return Err(expected()),
        };
        Ok(Self { event, at_s })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fails_is_read_and_anything_else_is_refused() {
        let read = |text: &str| text.parse::<Failure>().map(|own| (own.event, own.at_s));
        assert_eq!(read("power-loss@40"), Ok((FlightEvent::PowerLoss, 40.0)));
        assert_eq!(read("jam-pedal@12.5"), Ok((FlightEvent::Jam(3), 12.5)));
        for text in ["power-loss", "power-loss@-1", "power-loss@nan", "jam-@3", "jam-wing@3", "@"] {
            assert!(read(text).unwrap_err().contains("expected NAME@SECOND"), "{text}");
        }
    }
}
