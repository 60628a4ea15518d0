//! The verdict on a recorded flight, in a few sentences.

use std::collections::BTreeMap;

use hovernav::autopilot::Mode;
use hovernav::time::Time;
use hovernav_pages::{Level, Verdict};
use hovernav_record::{Call, Level as EventLevel, Record, RecordedEvent};

/// Number of reasons that are listed.
const NAMED: usize = 5;
/// Largest time difference, s, of the last bytes of lines that count as silent together. A receiver sends once a
/// second.
const TOGETHER_S: f64 = 2.5;
/// Time, s, within which lines end one after the other at the end of a flight.
const CLOSING_S: f64 = 0.25;
/// Minimum silence, s, at the end of a record that the verdict mentions.
const SILENT_S: f64 = 0.5;
/// Time, s, before the end in which the vehicle's motion shows how the flight ended.
const ENDING_S: f64 = 2.0;
/// Tilt, rad, above which the vehicle counts as upset. No hover and no landing reaches it.
const UPSET_RAD: f64 = 0.5;
/// Sink rate, m/s, above which the vehicle counts as upset. No hover and no landing reaches it.
const UPSET_MPS: f64 = 4.0;
/// Number of cycles among which one late cycle is acceptable.
const LATE_IN: usize = 1000;

/// Input of the verdict in addition to the record.
pub struct Grounds<'a> {
    /// The result of the replay in words, and whether it was identical.
    pub replay: &'a str,
    pub is_reproduced: bool,
    pub engagements: usize,
    pub autopilot_s: f64,
}

/// The verdict on `record`.
pub fn of_record(record: &Record, grounds: &Grounds<'_>) -> Verdict {
    let mut reasons: Vec<(Level, String)> = Vec::new();
    if !grounds.is_reproduced {
        reasons
            .push((Level::Bad, format!("the replay differs from the flight: {}", grounds.replay)));
    }
    if record.solutions.is_empty() {
        reasons.push((Level::Bad, "the estimator never aligned: there is no solution".into()));
    }
    reasons.extend(event_reasons(record));
    reasons.extend(upset_at_the_end(record));
    if record.cycles.last().is_some_and(|last| last.cycle.mode != Mode::Manual) {
        reasons.push((Level::Care, "the record ends while the autopilot flies".into()));
    }
    let late = record.events.iter().filter(|event| event.kind == "deadline_missed").count();
    if late * LATE_IN > record.cycles.len().max(LATE_IN) {
        reasons.push((
            Level::Care,
            format!("{late} cycles were late: the computer was too busy, or too slow"),
        ));
    }
    reasons.extend(record.warnings.iter().map(|warning| (Level::Care, warning.clone())));
    reasons.sort_by_key(|(level, _)| std::cmp::Reverse(*level));
    let level = reasons.first().map_or(Level::Good, |(level, _)| *level);
    let judged = match level {
        Level::Good => "Good",
        Level::Care => "With care",
        Level::Bad => "Faulty",
    };
    let unnamed = reasons.len().saturating_sub(NAMED);
    reasons.truncate(NAMED);
    let mut reasons: Vec<String> = reasons.into_iter().map(|(_, words)| words).collect();
    if unnamed > 0 {
        reasons.push(format!("and {unnamed} more in the list of events"));
    }
    Verdict { level, words: format!("{judged}: {}", in_words(record, grounds)), reasons }
}

/// A summary of the flight, independent of faults.
fn in_words(record: &Record, grounds: &Grounds<'_>) -> String {
    let duration_s = record.end - record.header.start;
    let flew = match (grounds.engagements, record.header.config.autopilot.is_some()) {
        (0, false) => format!("{duration_s:.0} s without an autopilot"),
        (0, true) => format!("{duration_s:.0} s by hand, the autopilot was not engaged"),
        (count, _) => {
            let times = if count == 1 { "once".into() } else { format!("{count} times") };
            format!(
                "the autopilot was engaged {times} and flew {:.1} of {duration_s:.0} s",
                grounds.autopilot_s
            )
        }
    };
    let replayed = if grounds.is_reproduced { "; the replay is identical to the bit" } else { "" };
    let silent = lines_end(record).map(|end| record.end - end).filter(|silent| *silent > SILENT_S);
    let silent = silent.map_or(String::new(), |silent_s| {
        format!("; all lines fell silent together {silent_s:.1} s before the end of the record")
    });
    format!("{flew}{replayed}{silent}.")
}

/// Time of the last byte, if all active lines fell silent together while the pilot flew. The flight computer's messages
/// after that are an ordinary end: it was switched off later than the sensors or the simulation. Under the autopilot,
/// silence is the loss of all sensors.
pub fn lines_end(record: &Record) -> Option<Time> {
    let mut last: [Option<Time>; 3] = [None; 3];
    for (time, call) in &record.calls {
        let (line, bytes) = match call {
            Call::Dmu(bytes) => (0, bytes),
            Call::Gps(bytes) => (1, bytes),
            Call::Servo(bytes) => (2, bytes),
            Call::RestartGps => continue,
        };
        if !bytes.is_empty() {
            last[line] = Some(*time);
        }
    }
    let end = last.into_iter().flatten().max()?;
    let mut cycles = record.cycles.iter().rev();
    let by_hand =
        cycles.find(|cycle| cycle.time <= end).is_none_or(|cycle| cycle.cycle.mode == Mode::Manual);
    let together = last.into_iter().flatten().all(|one| end - one < TOGETHER_S);
    (by_hand && together).then_some(end)
}

/// The finding for a flight that ends with a tilt or a sink rate impossible in a hover or a landing.
fn upset_at_the_end(record: &Record) -> Option<(Level, String)> {
    let end = lines_end(record).unwrap_or(record.end);
    let late = record.solutions.iter().filter(|one| one.time <= end && end - one.time < ENDING_S);
    let worst = late
        .map(|solution| {
            let angles = solution.body_to_ned.euler();
            let tilt_rad = angles.roll_rad.abs().max(angles.pitch_rad.abs());
            (tilt_rad, solution.velocity_mps.z())
        })
        .fold((0.0_f64, 0.0_f64), |(tilt, sink), (own_tilt, own_sink)| {
            (tilt.max(own_tilt), sink.max(own_sink))
        });
    (worst.0 > UPSET_RAD || worst.1 > UPSET_MPS).then(|| {
        let words = format!(
            "at the end the vehicle tilted up to {:.0}° and sank at up to {:.1} m/s: did it crash?",
            worst.0.to_degrees(),
            worst.1
        );
        (Level::Bad, words)
    })
}

/// The events of the flight itself: from its first solution to the silence of all lines.
pub fn of_flight(record: &Record) -> impl Iterator<Item = &RecordedEvent> {
    let start = record.solutions.first().map_or(record.end, |solution| solution.time);
    let end = lines_end(record).map_or(record.end, |end| end + -CLOSING_S);
    record.events.iter().filter(move |event| {
        // Before alignment, a missing sensor has no effect on the flight; only critical events count.
        event.time <= end && (event.time >= start || event.level == EventLevel::Critical)
            || event.kind == "untried_gains"
    })
}

/// Reasons from the events: each kind of text once, with its count.
fn event_reasons(record: &Record) -> Vec<(Level, String)> {
    let mut all: BTreeMap<(&str, String), (usize, &RecordedEvent)> = BTreeMap::new();
    for event in of_flight(record) {
        // Skipped: late cycles (counted separately), failed checks (listed with the refusal), and remarks on priority
        // and UTC.
        let is_counted = ["deadline_missed", "not_ready", "priority", "utc"];
        if event.level < EventLevel::Warning || is_counted.contains(&event.kind.as_str()) {
            continue;
        }
        let letters = event.text.chars().filter(|letter| !letter.is_ascii_digit()).collect();
        all.entry((&event.kind, letters)).or_insert((0, event)).0 += 1;
    }
    let mut kinds: Vec<(usize, &RecordedEvent)> = all.into_values().collect();
    kinds.sort_by(|(_, a), (_, b)| b.level.cmp(&a.level).then(a.time.cmp(&b.time)));
    kinds
        .into_iter()
        // An occasional rejected measurement is normal for a gate.
        .filter(|(count, event)| event.kind != "innovation_rejected" || *count > 2)
        .map(|(count, event)| {
            let level = if event.level == EventLevel::Critical { Level::Bad } else { Level::Care };
            (level, sentence(event, count, record))
        })
        .collect()
}

/// An event in words; the warnings of the page use it with a `count` of 1.
pub fn sentence(event: &RecordedEvent, count: usize, record: &Record) -> String {
    let refusal = event.kind == "autopilot" && event.text.contains("does not take over");
    let checks: Vec<&str> = record
        .events
        .iter()
        .filter(|other| refusal && other.kind == "not_ready" && other.time == event.time)
        .map(|other| other.text.as_str())
        .collect();
    let checks = if checks.is_empty() { String::new() } else { format!(": {}", checks.join("; ")) };
    let times =
        if count > 1 { format!(" ({count} times, first at this time)") } else { String::new() };
    let whose = if event.part.is_empty() || event.text.contains(&event.part) {
        String::new()
    } else {
        format!(" [{}]", event.part)
    };
    format!("{:.2} s: {}{checks}{whose}{times}", event.time.seconds(), event.text)
}
