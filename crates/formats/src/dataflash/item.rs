//! The items of a DataFlash log, binary or text.

use super::message::Message;

/// An item of a log, of one of the kinds that the reader uses.
#[derive(Debug)]
pub(super) enum Item<'a> {
    /// A message; `place` is its byte offset or line.
    Row { message: Message, instance: usize, place: u64, row: [f64; Message::WIDTH] },
    /// A parameter of the autopilot.
    Parameter { name: &'a str, value: f64 },
    /// A text of the autopilot, such as its name and version.
    Text(&'a str),
}
