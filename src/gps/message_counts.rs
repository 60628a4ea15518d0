//! Counts of the messages that a decoder received, by outcome.

/// Counts of the messages on the line, by outcome.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MessageCounts {
    /// Messages read, with every value possible.
    pub read: u32,
    /// Complete messages of a kind that this decoder does not use.
    pub unknown: u32,
    /// Messages that are cut off, have a wrong length, or have an invalid checksum or text.
    pub damaged: u32,
    /// Complete messages rejected because of an impossible value.
    pub impossible: u32,
    /// Epochs for which the receiver itself reported no fix.
    pub no_fix: u32,
}
