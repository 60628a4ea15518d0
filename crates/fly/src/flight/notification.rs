//! What happens in flight, in words: to the record, and to whoever watches.

use std::fmt;
use std::sync::mpsc::SyncSender;

use super::downlink::Downlinks;
use super::messages::port_level;
use super::repeats::Repeats;
use hovernav::time::Time;
use hovernav_log::record::{Entry, Level, Part, Recorder, ShortText};

/// Something that happened, for whoever watches the flight.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Notification {
    /// When, on the flight's clock.
    pub time: Time,
    /// How much it matters.
    pub level: Level,
    /// Whose it is: which sensor or part did it or is at fault.
    pub part: Part,
    /// In words.
    pub text: ShortText,
}

/// The record of a flight, the queue to whoever watches it and the lines to the ground. Neither is ever waited for.
pub struct EventLog {
    pub recorder: Recorder,
    notifications: SyncSender<Notification>,
    repeats: Repeats,
    pub downlinks: Downlinks,
}

impl EventLog {
    pub fn new(
        recorder: Recorder,
        notifications: SyncSender<Notification>,
        downlinks: Downlinks,
    ) -> Self {
        Self { recorder, notifications, repeats: Repeats::default(), downlinks }
    }

    /// Records an event under the name `kind`, which tells whose it is, and notifies of it.
    pub fn event(&mut self, now: Time, level: Level, kind: &'static str, text: impl fmt::Display) {
        self.event_of(Part::of_kind(kind), now, level, kind, text);
    }

    /// The same of `part`, where the kind does not tell.
    pub fn event_of(
        &mut self,
        part: Part,
        now: Time,
        level: Level,
        kind: &'static str,
        text: impl fmt::Display,
    ) {
        let text = ShortText::new(text);
        self.recorder.push(now, Entry::Event { level, kind, part, text });
        self.notify(part, now, level, text);
    }

    /// Records an event each time, and notifies of it with growing pauses.
    pub fn repeated_event(
        &mut self,
        now: Time,
        level: Level,
        kind: &'static str,
        text: impl fmt::Display,
    ) {
        let (part, text) = (Part::of_kind(kind), ShortText::new(text));
        self.recorder.push(now, Entry::Event { level, kind, part, text });
        self.repeated(part, now, level, text);
    }

    /// Notifies with growing pauses of what the record holds each time in another form.
    pub fn repeated(&mut self, part: Part, now: Time, level: Level, text: impl fmt::Display) {
        let text = ShortText::new(text);
        if let Some(text) = self.repeats.hear(now, level, part, text) {
            self.notify(part, now, level, text);
        }
    }

    /// Once a cycle: says what is left to say of what no longer repeats.
    pub fn settle_repeats(&mut self, now: Time) {
        if let Some(rest) = self.repeats.over(now) {
            self.notify(rest.part, now, rest.level, rest.text);
        }
    }

    /// At the end: says all that is left.
    pub fn end_repeats(&mut self, now: Time) {
        while let Some(rest) = self.repeats.last() {
            self.notify(rest.part, now, rest.level, rest.text);
        }
    }

    /// Records and tells what a port to the ground did.
    pub fn tell_changed_ports(&mut self, now: Time) {
        if let Some((port, event)) = self.downlinks.change() {
            let text = ShortText::new(port.changed(&event));
            self.event(now, port_level(&event), "ground_port", text);
        }
    }

    /// Tells the ground what UTC is less the flight's clock, ns.
    pub fn tell_utc(&self, offset_ns: i64) {
        self.downlinks.tell_utc(offset_ns);
    }

    fn notify(&self, part: Part, time: Time, level: Level, text: ShortText) {
        // Where the queue is full, the watcher misses it and the record has it.
        let _ = self.notifications.try_send(Notification { time, level, part, text });
        self.downlinks.say(time, level, text);
    }
}
