//! Reads the fixes of a receiver's stream, on the receiver's clock.

use std::collections::HashMap;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use super::for_each_piece;
use crate::assembly::Assembly;
use crate::format::Format;
use crate::log::Log;
use crate::utc;
use crate::window::Input;
use hovernav::gps::quality::{Limits, QualityCheck};
use hovernav::gps::tsip::{self, Framer, Report};
use hovernav::gps::{
    AntennaHeading, Fix, MessageCounts, Protocol, Receiver, ReceiverFix, ReceiverHeading,
    ReceiverTime, WEEK_FLOOR,
};
use hovernav::time::Time;
use hovernav_log::utc::moment;
use hovernav_log::{LogError, Manifest};

/// The fixes and headings of one protocol in the stream.
struct Heard {
    protocol: Protocol,
    receiver: Receiver,
    fixes: Vec<(u64, ReceiverFix)>,
    headings: Vec<(u64, ReceiverHeading)>,
}

pub(super) fn read(input: Input<'_>) -> Result<Log, LogError> {
    let mut assembly = Assembly::new(true);
    let floor = week_floor(input, &mut assembly)?;
    let mut heard = [Protocol::Ubx, Protocol::Nmea, Protocol::Tsip].map(|protocol| Heard {
        protocol,
        receiver: match protocol {
            Protocol::Tsip => Receiver::Tsip(tsip::Decoder::with_week_floor(floor)),
            other => Receiver::new(other),
        },
        fixes: Vec::new(),
        headings: Vec::new(),
    });
    for_each_piece(input, |bytes, offset| {
        for Heard { receiver, fixes, headings, .. } in &mut heard {
            let mut rest = bytes;
            loop {
                let fix = receiver.read(&mut rest, Time::ZERO);
                let place = offset + (bytes.len() - rest.len()) as u64;
                headings.extend(receiver.take_antenna_heading().map(|heading| (place, heading)));
                let Some(fix) = fix else { break };
                fixes.push((place, fix));
            }
        }
    })?;
    for Heard { receiver, fixes, .. } in &mut heard {
        let place = fixes.last().map_or(0, |last| last.0);
        fixes.extend(receiver.flush().map(|fix| (place, fix)));
    }
    // A receiver may send two protocols. The one with more fixes is used; if equal, the one with more messages.
    let [ubx, nmea, tsip] = heard;
    let best = [ubx, nmea, tsip]
        .into_iter()
        .max_by_key(|heard| {
            let counts = heard.receiver.counts();
            let whole = match heard.protocol {
                // TSIP has no checksum: other bytes may look like unknown packets.
                Protocol::Tsip => counts.read,
                _ => counts.read + counts.unknown,
            };
            (heard.fixes.len(), whole)
        })
        .ok_or_else(|| LogError::bytes(input.path, 0, "found no packet".into()))?;
    let name = match best.protocol {
        Protocol::Tsip => "TSIP",
        Protocol::Nmea => "NMEA 0183",
        Protocol::Ubx => "UBX",
    };
    let MessageCounts { read, unknown, damaged, impossible, no_fix } = best.receiver.counts();
    assembly.note(format!(
        "receiver with {name}: {read} messages read, {unknown} not needed, {damaged} damaged, \
         {impossible} with impossible values, {no_fix} epochs without a fix"
    ));
    let manifest = gather(&best.fixes, &best.headings, &mut assembly);
    assembly.finish(input.path, Format::Raw, manifest, "")
}

/// Adds the fixes to the assembly, with times since the first fix.
fn gather(
    fixes: &[(u64, ReceiverFix)],
    headings: &[(u64, ReceiverHeading)],
    assembly: &mut Assembly,
) -> Manifest {
    let mut manifest = Manifest::default();
    let first_utc = fixes.iter().find_map(|(_, fix)| fix.time?.unix_ns());
    if let Some(unix_ns) = first_utc {
        let utc_s = unix_ns as f64 * 1e-9;
        let day = utc::date(utc_s);
        manifest.date = moment(unix_ns);
        let of_day_s = utc_s.rem_euclid(86_400.0);
        let (hour, minute) = (of_day_s / 3600.0, of_day_s / 60.0 % 60.0);
        manifest.time = format!(
            "s since {} {:02}:{:02}:{:06.3} UTC, on the receiver's clock",
            day.unwrap_or_default(),
            hour as u8,
            minute as u8,
            of_day_s % 60.0
        );
    }
    let mut quality = QualityCheck::new(Limits::default());
    let mut poor: Option<(usize, String)> = None;
    let (mut seconds, mut before) = (0.0, None::<ReceiverTime>);
    let (mut without_time, mut above_sea, mut without_height) = (0usize, 0usize, 0usize);
    let mut last_height_m = 0.0;
    let mut epochs = HashMap::new();
    for (index, (place, fix)) in fixes.iter().enumerate() {
        let step_s = fix.time.zip(before).and_then(|(now, before)| now.since(&before));
        without_time += usize::from(fix.time.is_none());
        seconds += match step_s {
            Some(step_s) => step_s,
            None if index == 0 => 0.0,
            None => 1.0,
        };
        before = fix.time.or(before);
        if let Some(failure) = quality.check(fix).iter().next() {
            let (count, _) = poor.get_or_insert_with(|| (0, failure.to_string()));
            *count += 1;
        }
        above_sea += usize::from(fix.height_m.is_none() && fix.altitude_msl_m.is_some());
        let time = Time::try_from_seconds(seconds).unwrap_or_default();
        if let Some(ReceiverTime::Gps { time_of_week_ns, .. }) = fix.time {
            // Epochs are whole milliseconds; the time of a fix may differ by some nanoseconds.
            epochs.insert((time_of_week_ns + 500_000) / 1_000_000, time);
        }
        // A fix without a height keeps the last height and is marked as two-dimensional.
        let flat = fix.height_m.is_none() && fix.altitude_msl_m.is_none();
        let mut fix = fix.with_geoid_separation(0.0);
        fix.height_m = fix.height_m.or(Some(last_height_m));
        if let Some(fix) = fix.at(time) {
            last_height_m = fix.position.height_m;
            let two_dimensional = fix.two_dimensional || flat;
            assembly.fix(*place, Fix { two_dimensional, ..fix });
        }
        without_height += usize::from(flat);
    }
    for (place, ReceiverHeading { time_of_week_ms, heading }) in headings {
        // A heading without a fix has no time on this clock.
        if let Some(&time) = epochs.get(&u64::from(*time_of_week_ms)) {
            assembly.heading(*place, AntennaHeading { time, ..*heading });
        }
    }
    if without_height > 0 {
        assembly.say(format!(
            "{without_height} fixes without a height: used for the horizontal \
                              position only"
        ));
    }
    if without_time > 0 {
        assembly.say(format!("{without_time} fixes without a time: assumed to be one per second"));
    }
    if above_sea > 0 {
        assembly.say(format!(
            "{above_sea} fixes have only a height above sea level: it is used as height above the \
             ellipsoid; the error is up to 107 m"
        ));
    }
    if let Some((count, first)) = poor {
        assembly.say(format!(
            "{count} fixes fail the quality check of the flight software, the \
                              first because of: {first}"
        ));
    }
    manifest
}

/// The earliest GPS week of a TSIP stream.
///
/// A full week number is used as sent. A week number of ten bits is ambiguous; the latest week that is not after
/// the file was written is used.
fn week_floor(input: Input<'_>, assembly: &mut Assembly) -> Result<u16, LogError> {
    /// Number of weeks in ten bits.
    const TURN: u16 = 1024;
    let mut framer = Framer::default();
    let mut weeks: Option<(u16, u16)> = None;
    for_each_piece(input, |bytes, _| {
        let mut rest = bytes;
        while let Some(packet) = framer.next(&mut rest, Time::ZERO) {
            if let Ok(Report::GpsTime(time)) = Report::read(packet.id, packet.payload) {
                let week = time.week as u16;
                weeks = Some(weeks.map_or((week, week), |(a, b)| (a.min(week), b.max(week))));
            }
        }
    })?;
    Ok(match weeks {
        None => WEEK_FLOOR,
        Some((_, most)) if most >= TURN => TURN,
        Some(_) => {
            let written = written_week(input.path).unwrap_or(WEEK_FLOOR);
            assembly.say(
                "the receiver sends only ten bits of the week: the latest such week before the \
                 file was written is used",
            );
            written.saturating_sub(TURN - 1)
        }
    })
}

/// The GPS week in which `path` was last written.
fn written_week(path: &Path) -> Option<u16> {
    let written: SystemTime = std::fs::metadata(path).ok()?.modified().ok()?;
    let unix_s = written.duration_since(UNIX_EPOCH).ok()?.as_secs();
    u16::try_from(unix_s.checked_sub(315_964_800)? / 604_800).ok()
}
