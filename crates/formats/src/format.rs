//! Formats of logs.

use std::fmt;

/// The format of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// A directory of CSV files in hovernav's own columns.
    Dataset,
    /// hovernav's own flight record.
    Record,
    /// PX4's ULog.
    Ulog,
    /// ArduPilot's DataFlash log, binary.
    Dataflash,
    /// ArduPilot's DataFlash log as text.
    DataflashText,
    /// A MAVLink telemetry log.
    Tlog,
    /// MCAP with ROS 2 messages.
    Ros2,
    /// Raw bytes of a DMU or a receiver.
    Raw,
    /// Text in columns.
    Text,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Dataset => "dataset directory",
            Self::Record => "flight record",
            Self::Ulog => "PX4 ULog",
            Self::Dataflash => "ArduPilot DataFlash log",
            Self::DataflashText => "ArduPilot DataFlash log, text",
            Self::Tlog => "MAVLink telemetry log",
            Self::Ros2 => "MCAP with ROS 2 messages",
            Self::Raw => "capture of raw bytes",
            Self::Text => "text in columns",
        })
    }
}

impl Format {
    /// The name with its article.
    pub(crate) fn with_article(self) -> String {
        let article = match self {
            Self::Dataflash | Self::DataflashText | Self::Ros2 => "an",
            _ => "a",
        };
        format!("{article} {self}")
    }

    /// The feature of this crate that reads the format; `None` if no feature is needed.
    pub(crate) const fn feature(self) -> Option<&'static str> {
        match self {
            Self::Dataset => None,
            Self::Record => Some("record"),
            Self::Ulog => Some("ulog"),
            Self::Dataflash | Self::DataflashText => Some("dataflash"),
            Self::Tlog => Some("tlog"),
            Self::Ros2 => Some("ros2"),
            Self::Raw => Some("raw"),
            Self::Text => Some("text"),
        }
    }
}
