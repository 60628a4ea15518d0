//! What happens in flight, in words: to the record, and to whoever watches.

use std::fmt;
use std::sync::mpsc::SyncSender;

use super::downlink::Downlinks;
use hovernav::time::Time;
use hovernav_log::record::{Entry, Level, Recorder, ShortText};

/// Something that happened, for whoever watches the flight.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Notification {
    /// When, on the flight's clock.
    pub time: Time,
    /// How much it matters.
    pub level: Level,
    /// In words.
    pub text: ShortText,
}

/// The record of a flight, the queue to whoever watches it and the lines to the ground. Neither is ever waited for.
pub struct EventLog {
    pub recorder: Recorder,
    notifications: SyncSender<Notification>,
    pub downlinks: Downlinks,
}

impl EventLog {
    pub fn new(
        recorder: Recorder,
        notifications: SyncSender<Notification>,
        downlinks: Downlinks,
    ) -> Self {
        Self { recorder, notifications, downlinks }
    }

    /// Records an event under the name `kind`, and notifies of it.
    pub fn event(&mut self, now: Time, level: Level, kind: &'static str, text: impl fmt::Display) {
        let text = ShortText::new(text);
        self.recorder.push(now, Entry::Event { level, kind, text });
        self.notify(now, level, text.as_str());
    }

    /// Tells the ground what UTC is less the flight's clock, ns.
    pub fn tell_utc(&self, offset_ns: i64) {
        self.downlinks.tell_utc(offset_ns);
    }

    /// Notifies of what the record holds in another form.
    pub fn notify(&self, time: Time, level: Level, text: impl fmt::Display) {
        // Where the queue is full, the watcher misses it and the record has it.
        let text = ShortText::new(text);
        let _ = self.notifications.try_send(Notification { time, level, text });
        self.downlinks.say(time, level, text);
    }
}
