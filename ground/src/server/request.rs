//! What a client may ask for: JSON, one request a message.

use serde::Deserialize;

use crate::channel::Id;

/// Channels that one client may look at.
pub const WATCHED: usize = 48;
/// Columns of pixels of one plot.
pub const COLUMNS: usize = 4096;
/// Characters of a note.
const NOTE: usize = 200;

/// One request.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
pub enum Request {
    /// Look at these channels from now on.
    Watch {
        /// Their names.
        channels: Vec<String>,
    },
    /// Send a stretch of the watched channels, as a plot so many pixels wide shows it.
    View {
        /// A number that comes back with the answer.
        id: u32,
        /// First second since the start of 1970.
        from: f64,
        /// Last second.
        to: f64,
        /// Columns of pixels.
        columns: usize,
    },
    /// Record to a new file of this name.
    Record {
        /// The name.
        name: String,
    },
    /// End the record.
    Stop {},
    /// List the records.
    List {},
    /// Look at a record.
    Open {
        /// Its name.
        name: String,
    },
    /// Look at the vehicle again.
    Live {},
    /// Go to this moment of the record.
    Seek {
        /// Seconds since the start of 1970.
        to: f64,
    },
    /// Play the record.
    Play {
        /// Times as fast as it was.
        speed: f64,
    },
    /// Stay where it is.
    Pause {},
    /// Mark this moment.
    Mark {
        /// What is said of it.
        note: String,
    },
    /// Let frames flow, or pause them: `#` and `$` to the vehicle.
    Flow {
        /// Whether they flow.
        on: bool,
    },
    /// Estimate and identify from a record.
    Evaluate {
        /// Its name.
        name: String,
    },
}

impl Request {
    /// The request in `text`.
    ///
    /// # Errors
    /// Why there is none: what was found and expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let request: Self = serde_json::from_str(text)
            .map_err(|error| format!("request not understood: {error}"))?;
        match &request {
            Self::Watch { channels } if channels.len() > WATCHED => {
                Err(format!("found {} channels, expected up to {WATCHED}", channels.len()))
            }
            Self::View { columns, .. } if !(1..=COLUMNS).contains(columns) => {
                Err(format!("found {columns} columns, expected 1 to {COLUMNS}"))
            }
            Self::View { from, to, .. } if !(from.is_finite() && to.is_finite() && from < to) => {
                Err(format!(
                    "found a view from {from} to {to} s, expected one that is longer than 0 s"
                ))
            }
            Self::Mark { note }
                if note.chars().count() > NOTE || note.chars().any(char::is_control) =>
            {
                Err(format!(
                    "found a note that is too long, expected up to {NOTE} characters on one line"
                ))
            }
            _ => Ok(request),
        }
    }
}

/// The channels of these names.
///
/// # Errors
/// The first name that no channel has.
pub fn channels<'a>(names: impl IntoIterator<Item = &'a str>) -> Result<Vec<Id>, String> {
    let id = |name: &str| {
        Id::of(name).ok_or_else(|| {
            let found: String = name.chars().take(40).collect();
            format!("found \"{found}\", expected the name of a channel")
        })
    };
    names.into_iter().map(id).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_request_is_refused_with_what_was_expected() {
        let good = Request::parse(r#"{"do":"watch","channels":["roll_deg"]}"#);
        assert_eq!(good, Ok(Request::Watch { channels: vec!["roll_deg".into()] }));
        assert_eq!(Request::parse(r#"{"do":"stop"}"#), Ok(Request::Stop {}));
        let many = format!(r#"{{"do":"watch","channels":{:?}}}"#, vec!["roll_deg"; WATCHED + 1]);
        for bad in [
            "",
            "{",
            "[]",
            "null",
            r#"{"do":"arm"}"#,
            r#"{"do":"stop","now":1}"#,
            r#"{"do":"seek","to":"x"}"#,
            r#"{"do":"view","id":1,"from":1,"to":1,"columns":10}"#,
            r#"{"do":"view","id":1,"from":0,"to":1,"columns":0}"#,
            r#"{"do":"view","id":1,"from":0,"to":1,"columns":1000000000}"#,
            r#"{"do":"mark","note":"a\nb"}"#,
            &many,
        ] {
            assert!(Request::parse(bad).is_err(), "{bad}");
        }
        assert!(channels(["roll_deg", "nonsense"]).unwrap_err().contains("nonsense"));
    }
}
