//! Where a log is damaged, and how.

/// Damages described one by one.
const MOST: usize = 5;

/// What is wrong with a log, each with its byte or line: the first few, and where there are more.
#[derive(Debug, Default)]
pub(crate) struct Damages(Vec<(u64, String)>);

impl Damages {
    /// Adds a damage at `place`, a byte or a line.
    pub fn add(&mut self, place: u64, reason: impl Into<String>) {
        if self.0.len() < MOST {
            self.0.push((place, reason.into()));
        } else if self.0.len() == MOST {
            self.0.push((place, "and more damage from here on".to_owned()));
        }
    }

    /// The damages in the order found, each with its place.
    pub fn iter(&self) -> impl Iterator<Item = (u64, &str)> {
        self.0.iter().map(|(place, reason)| (*place, reason.as_str()))
    }
}
