//! The flight record: all input as raw bytes, and the results, in one MCAP file.
//!
//! [`Recorder`] writes it in parallel to the loop. [`Record`] reads it, even if it was cut off at any byte.
//! [`Record::dataset`] converts the bytes to a dataset, from which the estimator reproduces the flight bit for bit.
//!
//! Every message is JSON with a JSON schema; a few have Foxglove's own schemas. `log_time` is the time at which the
//! loop received it, `publish_time` its time of validity, both on UTC from the start in `configuration`. `sequence`
//! counts the recorded entries over all topics. Axes and units are in the names: `_ned` and `_body` axes, `xyzw`
//! quaternions.
//!
//! | topic | content |
//! |---|---|
//! | `configuration` | first message: `fly.toml`, the start on both clocks, the version |
//! | `dmu/raw`, `gps/raw`, `servo/raw` | the bytes of one call, if any, and its time |
//! | `gps/restart` | a restart of the dialogue with the receiver |
//! | `imu`, `gps/fix`, `gps/location` | decoded: every packet with a time, every fix, used or not |
//! | `solution`, `solution/location` | after every inertial sample; `solution` holds every bit |
//! | `innovations` | innovations of every measurement that the filter compared |
//! | `servo`, `controls` | pulse widths, stick positions |
//! | `autopilot` | each cycle of flight control: mode, switch, checks, sticks of pilot and autopilot, commands |
//! | `events` | events in words, with a `name` for programs |
//! | `lost` | number of entries without room before this message |

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
