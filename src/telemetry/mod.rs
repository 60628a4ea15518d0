//! Telemetry: the state of the flight, sent to the ground in every cycle.
//!
//! A [`Snapshot`] is the state at one moment. While the ground requests frames ([`Flow`]), each snapshot is sent as a
//! [`frame`] of 145 bytes. A modem of 57 600 baud carries 33 frames a second. A [`Supplement`] reports flight control
//! in detail at a lower rate, and a [`Text`] reports events.
//!
//! ```
//! use hovernav::telemetry::{Flow, Snapshot, frame};
//! use hovernav::time::Time;
//!
//! let mut flow = Flow::default();
//! flow.receive(b"#");
//! assert!(flow.is_on());
//!
//! let mut snapshot = Snapshot::at(Time::ZERO);
//! snapshot.temperature_degc = Some(31.5);
//! let bytes = frame::pack(&snapshot, 0);
//!
//! let mut decoder = frame::Decoder::default();
//! let frames: Vec<_> = bytes.iter().filter_map(|byte| decoder.push(*byte)).collect();
//! assert_eq!(frames[0].unwrap().snapshot, snapshot);
//! ```

mod flow;
pub mod frame;
mod sequence;
mod snapshot;
mod supplement;
mod text;
mod wire;

pub use flow::Flow;
pub use sequence::Sequence;
pub use snapshot::{
    Drops, FixKind, GpsSummary, Innovations, LoopTiming, Sigmas, Snapshot, StatusFlags, SystemMode,
};
pub use supplement::{ControlFlags, Supplement};
pub use text::{Severity, Text};
