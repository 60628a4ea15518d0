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

/// What is wrong with a log, each with its byte or line.
pub(super) type Damages = Vec<(u64, String)>;

/// Damages described one by one.
const DAMAGES: usize = 5;

/// Adds a damage, unless there are many.
pub(super) fn damage(damages: &mut Damages, place: u64, reason: &str) {
    if damages.len() < DAMAGES {
        damages.push((place, reason.to_owned()));
    } else if damages.len() == DAMAGES {
        damages.push((place, "and more damage from here on".to_owned()));
    }
}
