//! The flight record: everything that came in, as it came, and what was made of it, in one MCAP file.
//!
//! [`Recorder`] writes it beside the loop, [`Record`] reads it, also one that was cut off at any
//! byte, and [`Record::dataset`] makes the bytes a dataset again, from which the estimator
//! reproduces what it flew, bit for bit.
//!
//! Every message is JSON with a JSON schema; a few have schemas that Foxglove knows. `log_time` is
//! when the loop came to it, `publish_time` when what it says was true, both on UTC from the start
//! in `configuration`; `sequence` counts what the loop recorded, over all topics. Angles, vectors and
//! units are as in the names: `_ned` and `_body` axes, `xyzw` quaternions.
//!
//! | topic | what |
//! |---|---|
//! | `configuration` | first of all: `fly.toml`, the start on both clocks, the version |
//! | `dmu/raw`, `gps/raw`, `servo/raw` | the bytes of one call and its time, none where it had none |
//! | `gps/restart` | the receiver's conversation began anew |
//! | `imu`, `gps/fix`, `gps/location` | decoded: every packet with a time, every fix, used or not |
//! | `solution`, `solution/location` | after every inertial sample; `solution` holds every bit |
//! | `innovations` | of every measurement the filter compared |
//! | `servo`, `controls` | pulse widths, stick positions |
//! | `autopilot` | each cycle of flight control: mode, switch, checks, sticks of pilot and autopilot, what was asked for |
//! | `events` | in words, with a `name` for programs |
//! | `lost` | how many entries found no room before this point |

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
mod spool;
mod status;
mod writer;

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
pub use status::Status;
