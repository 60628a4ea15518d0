//! What a DataFlash log holds, one item after another, whether it is of bytes or text.

use super::message::Message;

/// Something of a log that is read.
#[derive(Debug)]
pub(super) enum Item<'a> {
    /// A message, at a byte or line.
    Row { message: Message, instance: usize, place: u64, row: [f64; Message::WIDTH] },
    /// A parameter of the autopilot.
    Parameter { name: &'a str, value: f64 },
    /// What the autopilot said, such as its name and version.
    Text(&'a str),
}
