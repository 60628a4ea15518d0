//! Events of a flight as text, to the record and to observers.

use std::fmt;
use std::sync::mpsc::SyncSender;

use super::downlink::Downlinks;
use super::messages::port_level;
use super::repeats::Repeats;
use super::sensor_monitor::Report;
use hovernav::time::Time;
use hovernav_record::{Entry, Level, Part, Recorder, ShortText};

/// An event, for an observer of the flight.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Notification {
    /// Time on the flight clock.
    pub time: Time,
    /// Severity.
    pub level: Level,
    /// The sensor or function that caused the event.
    pub part: Part,
    /// Text of the event.
    pub text: ShortText,
}

/// The record of a flight, the queue to the observer and the lines to the ground. The flight never waits for them.
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

    /// Records an event under the name `kind`, which determines the part, and sends a notification.
    pub fn event(&mut self, now: Time, level: Level, kind: &'static str, text: impl fmt::Display) {
        self.event_of(Part::of_kind(kind), now, level, kind, text);
    }

    /// Records a finding, under the name of its kind in `hovernav estimate`, and sends a notification.
    pub fn found(&mut self, now: Time, (level, kind, text): Report) {
        self.event(now, level, kind.name(), text);
    }

    /// Records an event as [`event`](Self::event) does, for a `part` that `kind` does not determine.
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

    /// Records every event, and sends notifications with growing pauses.
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

    /// Sends notifications with growing pauses, for events that the record already contains in another form.
    pub fn repeated(&mut self, part: Part, now: Time, level: Level, text: impl fmt::Display) {
        let text = ShortText::new(text);
        if let Some(text) = self.repeats.observe(now, level, part, text) {
            self.notify(part, now, level, text);
        }
    }

    /// Sends the count of an event that has stopped repeating; call once per cycle.
    pub fn settle_repeats(&mut self, now: Time) {
        if let Some(rest) = self.repeats.over(now) {
            self.notify(rest.part, now, rest.level, rest.text);
        }
    }

    /// Sends the counts of all repeated events, at the end of the flight.
    pub fn end_repeats(&mut self, now: Time) {
        while let Some(rest) = self.repeats.last() {
            self.notify(rest.part, now, rest.level, rest.text);
        }
    }

    /// Records and reports a change of a port to the ground.
    pub fn report_changed_ports(&mut self, now: Time) {
        if let Some((port, event)) = self.downlinks.change() {
            let text = ShortText::new(port.changed(&event));
            self.event(now, port_level(&event), "ground_port", text);
        }
    }

    /// Sends the offset from the flight clock to UTC, ns, to the ground.
    pub fn report_utc(&self, offset_ns: i64) {
        self.downlinks.report_utc(offset_ns);
    }

    fn notify(&self, part: Part, time: Time, level: Level, text: ShortText) {
        // If the queue is full, the observer misses the event; the record has it.
        let _ = self.notifications.try_send(Notification { time, level, part, text });
        self.downlinks.say(time, level, text);
    }
}
