//! A topic of a log, and the time stamps of its messages.

use mcap::records::MessageHeader;

use super::container::ChannelId;
use super::message::{Header, Kind};

/// A channel with messages that are read.
#[derive(Debug)]
pub(super) struct Topic {
    /// Channels of the topic: one in each file of the log.
    pub channels: Vec<ChannelId>,
    pub name: String,
    /// Frame of the topic's first message.
    pub frame: String,
    pub kind: Kind,
    pub stamps: Stamps,
}

/// Statistics of the time stamps of a channel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stamps {
    pub messages: usize,
    /// Number of messages with a measurement that may be used.
    pub good: usize,
    pub stamped: usize,
    /// Smallest delay from the stamp of a message to its log time, ns.
    pub min_delay_ns: i64,
}

impl Topic {
    /// Whether both have the same channels.
    pub fn is(&self, other: &Self) -> bool {
        self.channels == other.channels
    }
}

impl Stamps {
    /// Adds the messages of another file.
    pub fn add(&mut self, other: Self) {
        self.messages += other.messages;
        self.good += other.good;
        self.stamped += other.stamped;
        self.min_delay_ns = self.min_delay_ns.min(other.min_delay_ns);
    }

    pub const NONE: Self = Self { messages: 0, good: 0, stamped: 0, min_delay_ns: i64::MAX };

    /// Counts a message with its log time in `sent` and its stamp in `header`.
    pub fn count(&mut self, sent: &MessageHeader, header: Option<&Header<'_>>, is_good: bool) {
        self.messages += 1;
        self.good += usize::from(is_good);
        let stamp_ns = header.map(|header| header.stamp_ns);
        if let Some(stamp_ns) = stamp_ns.filter(|stamp_ns| *stamp_ns != 0) {
            self.stamped += 1;
            let logged_ns = i64::try_from(sent.log_time).unwrap_or(i64::MAX);
            let delay_ns = logged_ns.saturating_sub(stamp_ns);
            self.min_delay_ns = self.min_delay_ns.min(delay_ns);
        }
    }
}
