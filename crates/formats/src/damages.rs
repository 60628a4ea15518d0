//! Damage in a log, with its position.

/// Number of damages that are described individually.
const MAX: usize = 5;

/// The first damages of a log, each with its byte offset or line. The last entry has the offset or line from which
/// there are more.
#[derive(Debug, Default)]
pub(crate) struct Damages(Vec<(u64, String)>);

impl Damages {
    /// Adds a damage at `place`, a byte offset or a line.
    pub fn add(&mut self, place: u64, reason: impl Into<String>) {
        if self.0.len() < MAX {
            self.0.push((place, reason.into()));
        } else if self.0.len() == MAX {
            self.0.push((place, "and more damage from here on".to_owned()));
        }
    }

    /// The damages in the order found, each with its byte offset or line.
    pub fn iter(&self) -> impl Iterator<Item = (u64, &str)> {
        self.0.iter().map(|(place, reason)| (*place, reason.as_str()))
    }
}
