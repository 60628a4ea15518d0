//! The requests of a client: JSON, one request per message.

use serde::Deserialize;

use crate::channel::Id;

/// Largest number of channels that one client may watch.
pub const WATCHED: usize = 48;
/// Largest number of pixel columns of one plot.
pub const COLUMNS: usize = 4096;
/// Largest number of characters in a note.
const NOTE: usize = 200;

/// One request.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
pub enum Request {
    /// Watch these channels from now on.
    Watch {
        /// Their names.
        channels: Vec<String>,
    },
    /// Send a time range of the watched channels, reduced for a plot with this number of columns.
    View {
        /// A number that is returned with the answer.
        id: u32,
        /// Start of the range, s since the start of 1970.
        from: f64,
        /// End of the range, s since the start of 1970.
        to: f64,
        /// Number of pixel columns.
        columns: usize,
    },
    /// Record to a new file with this name.
    Record {
        /// The name.
        name: String,
    },
    /// End the record.
    Stop {},
    /// List the records.
    List {},
    /// Open a record.
    Open {
        /// Its name.
        name: String,
    },
    /// Return to the live vehicle.
    Live {},
    /// Move to this time of the record.
    Seek {
        /// Seconds since the start of 1970.
        to: f64,
    },
    /// Play the record.
    Play {
        /// Speed, as a factor of real time.
        speed: f64,
    },
    /// Pause the playback.
    Pause {},
    /// Mark the present time.
    Mark {
        /// Text of the marker.
        note: String,
    },
    /// Start the telemetry frames with `#`, or stop them with `$`; the station sends this byte to the vehicle.
    Flow {
        /// Whether frames are sent.
        on: bool,
    },
    /// Run estimate and identify on a record.
    Evaluate {
        /// Its name.
        name: String,
    },
}

impl Request {
    /// Parses the request in `text`.
    ///
    /// # Errors
    /// The value found and the value expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let request: Self =
            serde_json::from_str(text).map_err(|error| format!("invalid request: {error}"))?;
        match &request {
            Self::Watch { channels } if channels.len() > WATCHED => {
                Err(format!("found {} channels, expected up to {WATCHED}", channels.len()))
            }
            Self::View { columns, .. } if !(1..=COLUMNS).contains(columns) => {
                Err(format!("found {columns} columns, expected 1 to {COLUMNS}"))
            }
            Self::View { from, to, .. } if !(from.is_finite() && to.is_finite() && from < to) => {
                Err(format!("found a view from {from} to {to} s, expected an end after the start"))
            }
            Self::Mark { note }
                if note.chars().count() > NOTE || note.chars().any(char::is_control) =>
            {
                Err(format!(
                    "found a note that is too long or has line breaks, expected up to {NOTE} characters on one line"
                ))
            }
            _ => Ok(request),
        }
    }
}

/// The channels with these names.
///
/// # Errors
/// The first unknown name.
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
