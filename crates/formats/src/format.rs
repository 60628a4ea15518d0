//! What a file is, by what it holds.

use std::fmt;

/// The form of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// A directory of CSV files, as `hovernav-log` writes it.
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
    /// Bytes as a DMU or a receiver sent them.
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
            Self::Raw => "raw bytes of sensors",
            Self::Text => "text in columns",
        })
    }
}
