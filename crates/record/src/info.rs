//! Description of a record, without the sensors' data, for people.

use std::collections::BTreeMap;
use std::fmt;

use crate::entry::Level;
use crate::read::{Record, RecordedEvent};
use hovernav_findings::paragraph;

/// The description of a record, by its [`Display`](fmt::Display): start, length, losses, events.
#[derive(Clone, Copy, Debug)]
pub struct RecordInfo<'a>(pub &'a Record);

impl fmt::Display for RecordInfo<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Record { header, solutions, lost_raw, lost_decoded, .. } = self.0;
        writeln!(f, "\nrecord")?;
        let end = if self.0.is_ended { "ended" } else { "cut off" };
        writeln!(f, "  by        hovernav {}, {end}", header.version)?;
        if let Some(repair) = &self.0.repair {
            writeln!(f, "  repaired  {repair}")?;
        }
        let (unix_s, start) = (header.start_unix_ns.div_euclid(1_000_000_000), header.start);
        if let Some(utc) = chrono::DateTime::<chrono::Utc>::from_timestamp(unix_s, 0) {
            writeln!(f, "  start     {utc}, {start} on the flight's clock")?;
        }
        writeln!(f, "  length    {:.3} s", self.0.end - start)?;
        writeln!(f, "  flown     {} solutions", solutions.len())?;
        writeln!(f, "  no room   for {lost_raw} raw and {lost_decoded} decoded entries")?;
        let mut kinds: BTreeMap<(std::cmp::Reverse<Level>, &str), Vec<&RecordedEvent>> =
            BTreeMap::new();
        for event in &self.0.events {
            kinds.entry((std::cmp::Reverse(event.level), &event.kind)).or_default().push(event);
        }
        if !kinds.is_empty() {
            writeln!(f, "\nevents")?;
        }
        for ((_, kind), events) in kinds {
            let [first, rest @ ..] = &events[..] else { continue };
            let more = if rest.is_empty() { String::new() } else { ", first".into() };
            let after_s = first.time - start;
            let text = format!("{}{more} after {after_s:.3} s: {}", events.len(), first.text);
            paragraph(f, &format!("  {kind:<20} "), &text)?;
        }
        Ok(())
    }
}
