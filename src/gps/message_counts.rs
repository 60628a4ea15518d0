//! A decoder's account of what it took and what it left.

/// What became of the messages on the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MessageCounts {
    /// Read, every value possible.
    pub read: u32,
    /// Whole, of a kind that this decoder has no use for.
    pub unknown: u32,
    /// Started but cut off, of the wrong length, or with a checksum or a text that does not hold.
    pub damaged: u32,
    /// Whole, with a value that cannot be: left out.
    pub impossible: u32,
    /// Epochs that the receiver itself declared to be no fix.
    pub no_fix: u32,
}
