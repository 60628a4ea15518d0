#![doc = include_str!("../README.md")]

mod channel;
mod chunks;
mod damage;
mod drain;
mod encode;
mod entry;
mod happening;
mod header;
mod info;
mod message;
mod read;
mod recorder;
mod repair;
mod replay;
mod replay_control;
mod setup;
mod spool;
mod status;
mod unpack;
mod writer;

pub use chunks::{Piece, pieces, records};
pub use damage::{Damage, Repair};
pub use entry::{Cycle, Entry, Level, Line, Part, RawBytes, ShortText};
pub use happening::Happening;
pub use header::Header;
pub use info::RecordInfo;
pub use read::{Call, Record, RecordedCycle, RecordedEvent};
pub use recorder::Recorder;
pub use repair::{Repaired, repair};
pub use replay::{Difference, Reproduction};
pub use replay_control::StickReproduction;
pub use setup::{
    AccelerationSign, AutopilotFileError, AutopilotSection, CaptureSection, DmuMode, DmuSection,
    ExcitationSection, FlyConfig, FlyConfigError, GeofenceSection, InputKind, InputSection,
    LineSection, MavlinkConfig, MavlinkRates, MavlinkSection, PilotRole, PwmLine, ReceiverProtocol,
    ReceiverSection, RecordSection, ServoSection, SiteSection, StickName, TelemetrySection,
    ThrottleSource, read_autopilot, write_autopilot,
};
pub use status::Status;
pub use unpack::unpacked;
