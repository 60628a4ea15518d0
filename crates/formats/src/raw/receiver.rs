//! Reads the fixes of a receiver's stream, on the receiver's clock.

use std::collections::HashMap;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use super::frames::{self, Kind};
use super::pieces::{begin, for_each_piece};
use crate::assembly::Assembly;
use crate::utc;
use crate::window::Input;
use hovernav::frames::{Ned, Vector};
use hovernav::gps::quality::{Limits, QualityCheck};
use hovernav::gps::tsip::{self, Framer, Report};
use hovernav::gps::{
    AntennaHeading, Dimension, MessageCounts, Protocol, Receiver, ReceiverFix, ReceiverHeading,
    ReceiverTime, WEEK_FLOOR,
};
use hovernav::time::Time;
use hovernav_dataset::utc::moment;
use hovernav_dataset::{Dimensions, LogError, Manifest, StatedFix, is_unknown};

const DAY_NS: i64 = 86_400_000_000_000;

/// The fixes and headings of one protocol in the stream.
struct Received {
    name: &'static str,
    receiver: Receiver,
    fixes: Vec<(u64, ReceiverFix)>,
    headings: Vec<(u64, ReceiverHeading)>,
}

impl Received {
    fn of(name: &'static str, receiver: Receiver) -> Self {
        Self { name, receiver, fixes: Vec::new(), headings: Vec::new() }
    }

    fn take(&mut self, mut bytes: &[u8], offset: u64) {
        let length = bytes.len();
        loop {
            let fix = self.receiver.read(&mut bytes, Time::ZERO);
            let place = offset + (length - bytes.len()) as u64;
            let heading = self.receiver.take_antenna_heading();
            self.headings.extend(heading.map(|heading| (place, heading)));
            let Some(fix) = fix else { break };
            self.fixes.push((place, fix));
        }
    }

    fn finish(&mut self) {
        let place = self.fixes.last().map_or(0, |last| last.0);
        self.fixes.extend(self.receiver.flush().map(|fix| (place, fix)));
    }
}

/// Largest number of bytes whose checksum is computed in vain, for each byte of the stream.
const MAX_WORK: u64 = 64;

/// Statistics of the frames that no decoder reads.
#[derive(Default)]
struct Unread {
    /// Number of frames with a wrong checksum, or cut off.
    damaged: usize,
    rtcm: usize,
    /// Number of the receiver's raw measurements in UBX, classes RXM and TRK.
    raw_measurements: usize,
    ubx: usize,
}

pub(super) fn read(input: Input<'_>) -> Result<(Assembly, Manifest), LogError> {
    let mut assembly = Assembly::new(true);
    let floor = week_floor(input, &mut assembly)?;
    let tsip = Receiver::Tsip(tsip::Decoder::with_week_floor(floor));
    // The protocol with the most content comes first: it is used if several report one epoch.
    let mut heard = [
        Received::of("UBX", Receiver::new(Protocol::Ubx)),
        Received::of("TSIP", tsip),
        Received::of("NMEA 0183", Receiver::new(Protocol::Nmea)),
    ];
    let unread = listen(input, &mut heard)?;
    heard.iter_mut().for_each(Received::finish);
    remark_protocols(&heard, &unread, &mut assembly);
    let headings = heard.iter().flat_map(|heard| heard.headings.clone()).collect::<Vec<_>>();
    let [ubx, tsip, nmea] = heard;
    let fixes = merged(merged(ubx.fixes, tsip.fixes), nmea.fixes);
    if fixes.is_empty() {
        let reason = if unread.raw_measurements > 0 {
            "found UBX with raw measurements only: no position solution in it. Log NAV-PVT as well, or solve the \
             measurements with RTKLIB and read its .pos file with `hovernav init`"
        } else if unread.rtcm > 0 {
            "found RTCM without positions: these are corrections or measurements. Log the receiver's NMEA or UBX \
             as well, or solve the measurements with RTKLIB"
        } else {
            ""
        };
        if !reason.is_empty() {
            return Err(LogError::Unusable {
                path: input.path.to_path_buf(),
                reason: reason.into(),
            });
        }
    }
    let manifest = gather(&fixes, &headings, &mut assembly);
    Ok((assembly, manifest))
}

/// Passes each frame to the decoder of its protocol, and other bytes to that of TSIP, which has no checksums.
fn listen(input: Input<'_>, heard: &mut [Received; 3]) -> Result<Unread, LogError> {
    let mut unread = Unread::default();
    let mut window = begin(input)?;
    // Number of bytes whose checksum was computed without finding a frame.
    let mut in_vain = 0_u64;
    let [ubx, tsip, nmea] = heard;
    loop {
        let offset = window.offset();
        let bytes = window.peek(frames::LONGEST).map_err(LogError::io(input.path))?;
        if bytes.is_empty() {
            return Ok(unread);
        }
        // Only bytes that are made to look like long frames exceed the limit. A frame among them may be lost.
        let is_worthwhile = in_vain <= MAX_WORK * (offset + frames::LONGEST as u64);
        let length = match is_worthwhile.then(|| frames::at(bytes)).flatten() {
            Some((kind, length)) => {
                match kind {
                    Kind::Ubx { class } => {
                        unread.ubx += 1;
                        unread.raw_measurements += usize::from(matches!(class, 0x02 | 0x03));
                        ubx.take(&bytes[..length], offset);
                    }
                    Kind::Nmea => nmea.take(&bytes[..length], offset),
                    Kind::Rtcm => unread.rtcm += 1,
                }
                length
            }
            None => {
                in_vain += frames::work(bytes) as u64;
                unread.damaged += usize::from(frames::may_begin(bytes));
                let next = (1..bytes.len()).find(|&at| matches!(bytes[at], 0xB5 | b'$' | 0xD3));
                let length = next.unwrap_or(bytes.len()).min(bytes.len());
                tsip.take(&bytes[..length], offset);
                length
            }
        };
        window.consume(length);
    }
}

fn remark_protocols(heard: &[Received; 3], unread: &Unread, assembly: &mut Assembly) {
    let [ubx, tsip, nmea] = heard;
    // TSIP has no checksum: other bytes may look like its packets.
    let is_tsip = ubx.fixes.is_empty() && nmea.fixes.is_empty();
    for Received { name, receiver, .. } in
        [Some(ubx), is_tsip.then_some(tsip), Some(nmea)].into_iter().flatten()
    {
        let MessageCounts { read, unknown, damaged, impossible, no_fix } = receiver.counts();
        let others = if *name == "UBX" {
            unread.ubx as u64 - u64::from(read).min(unread.ubx as u64)
        } else {
            0
        };
        if read + unknown == 0 && others == 0 {
            continue;
        }
        // The checksums of the other protocols have been checked; the reader does not need the content of their other
        // messages.
        let (unneeded, damaged) = match *name {
            "TSIP" => (u64::from(unknown), u64::from(damaged)),
            _ => (u64::from(unknown) + u64::from(damaged) + others, unread.damaged as u64),
        };
        assembly.note(format!(
            "receiver with {name}: {read} messages read, {unneeded} not needed, {damaged} damaged, \
             {impossible} with impossible values, {no_fix} epochs without a fix"
        ));
    }
    if unread.rtcm > 0 {
        assembly.note(format!("RTCM: {} messages, not needed", unread.rtcm));
    }
}

/// UTC of a fix, ns since 1970. Leap seconds that the receiver does not state are those of the date.
fn unix_ns(fix: &ReceiverFix) -> Option<i64> {
    let time = fix.time?;
    time.unix_ns().or_else(|| match time {
        ReceiverTime::Gps { week, time_of_week_ns, .. } => {
            Some(utc::of_gps_week(f64::from(week?), time_of_week_ns as f64 * 1e-9))
        }
        ReceiverTime::Utc { .. } => None,
    })
}

/// Time of day of a fix, UTC, ns, also without a date. Leap seconds that the receiver does not state are those since
/// 2017.
fn of_day_ns(fix: &ReceiverFix) -> Option<i64> {
    let of_day = match fix.time? {
        ReceiverTime::Utc { time_of_day_ns, .. } => i64::try_from(time_of_day_ns).ok()?,
        ReceiverTime::Gps { time_of_week_ns, leap_seconds, .. } => {
            let leap_s = leap_seconds.map_or(18, i64::from);
            i64::try_from(time_of_week_ns).ok()? - leap_s * 1_000_000_000
        }
    };
    Some(unix_ns(fix).unwrap_or(of_day).rem_euclid(DAY_NS))
}

/// Whether a fix is in a leap second, after the last second of a day.
fn is_in_leap(fix: &ReceiverFix) -> bool {
    matches!(fix.time, Some(ReceiverTime::Utc { time_of_day_ns, .. }) if time_of_day_ns >= DAY_NS as u64)
}

/// Time between two fixes, ns; less than half a day if either has no date.
fn apart_ns(fix: &ReceiverFix, before: &ReceiverFix) -> Option<i64> {
    let dated = unix_ns(fix).zip(unix_ns(before));
    let of_day = || of_day_ns(fix).zip(of_day_ns(before));
    match dated {
        Some((fix, before)) => fix.checked_sub(before),
        None => {
            let (fix, before) = of_day()?;
            Some((fix - before + DAY_NS / 2).rem_euclid(DAY_NS) - DAY_NS / 2)
        }
    }
}

/// Merges the fixes of two protocols in the order of the stream. Of `poorer`, only fixes of epochs that `richer` lacks
/// are kept. A poorer fix without a time is kept only before or after all richer ones.
fn merged(
    richer: Vec<(u64, ReceiverFix)>,
    poorer: Vec<(u64, ReceiverFix)>,
) -> Vec<(u64, ReceiverFix)> {
    /// Largest difference of the times of one epoch, ns.
    const EPOCH_NS: i64 = 50_000_000;
    let (Some(&(first, _)), Some(&(last, _))) = (richer.first(), richer.last()) else {
        return poorer;
    };
    let mut known: Vec<(i64, ReceiverFix)> =
        richer.iter().filter_map(|(_, fix)| Some((of_day_ns(fix)?, *fix))).collect();
    known.sort_by_key(|(of_day, _)| *of_day);
    let is_new = |&(place, ref fix): &(u64, ReceiverFix)| {
        let Some(of_day) = of_day_ns(fix) else { return !(first..=last).contains(&place) };
        // An epoch at midnight may be at either end of the day.
        ![-DAY_NS, 0, DAY_NS].into_iter().any(|turn| {
            let start = known.partition_point(|(time, _)| *time < of_day + turn - EPOCH_NS);
            let near =
                known[start..].iter().take_while(|(time, _)| *time <= of_day + turn + EPOCH_NS);
            { near }.any(|(_, known)| apart_ns(fix, known).is_some_and(|ns| ns.abs() <= EPOCH_NS))
        })
    };
    let new: Vec<(u64, ReceiverFix)> = poorer.into_iter().filter(is_new).collect();
    let mut all = richer;
    all.extend(new);
    all.sort_by_key(|(place, _)| *place);
    all
}

/// Adds the fixes to the assembly, with times since the first fix.
fn gather(
    fixes: &[(u64, ReceiverFix)],
    headings: &[(u64, ReceiverHeading)],
    assembly: &mut Assembly,
) -> Manifest {
    let mut manifest = Manifest::default();
    let first_utc = fixes.iter().find_map(|(_, fix)| unix_ns(fix));
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
    let (mut seconds, mut before) = (0.0, None::<&ReceiverFix>);
    let (mut without_time, mut above_sea) = (0usize, 0usize);
    let mut epochs = HashMap::new();
    for (index, (place, fix)) in fixes.iter().enumerate() {
        let on_one_scale = before.and_then(|before| fix.time?.since(&before.time?));
        // The two fixes are from different protocols, and so from two time scales.
        let by_utc = || Some(apart_ns(fix, before?)? as f64 * 1e-9);
        let step_s = on_one_scale.or_else(by_utc);
        without_time += usize::from(fix.time.is_none());
        // The second after a leap second has the same time in UTC since 1970.
        let leap_s = f64::from(u8::from(before.is_some_and(is_in_leap) && !is_in_leap(fix)));
        seconds += match step_s {
            Some(step_s) => step_s + leap_s,
            None if index == 0 => 0.0,
            None => 1.0,
        };
        before = fix.time.map(|_| fix).or(before);
        above_sea += usize::from(fix.height_m.is_none() && fix.altitude_msl_m.is_some());
        let time = Time::try_from_seconds(seconds).unwrap_or_default();
        if let Some(ReceiverTime::Gps { time_of_week_ns, .. }) = fix.time {
            // Epochs are whole milliseconds; the time of a fix may differ by some nanoseconds.
            epochs.insert((time_of_week_ns + 500_000) / 1_000_000, time);
        }
        let vector = |of: Option<Vector<Ned>>| of.map_or([f64::NAN; 3], Vector::to_array);
        let [north, east] = fix.horizontal_velocity_mps.unwrap_or([f64::NAN; 2]);
        // A value for unknown heights is no longer one after the separation of the geoid is added.
        let is_unknown_msl = fix.altitude_msl_m.is_some_and(is_unknown);
        let height_m = fix.height_m.or(fix.altitude_msl_m).filter(|_| !is_unknown_msl);
        let position = [
            fix.latitude_rad.to_degrees(),
            fix.longitude_rad.to_degrees(),
            height_m.unwrap_or(f64::NAN),
        ];
        let stated = StatedFix {
            dimensions: match fix.dimension {
                Some(Dimension::TwoD) => Dimensions::Two,
                Some(Dimension::ThreeD) | None => Dimensions::Three,
            },
            position_sigma_m: vector(fix.position_sigma_m),
            velocity_mps: [north, east, fix.down_velocity_mps.unwrap_or(f64::NAN)],
            ground_speed_mps: fix.ground_speed_mps.unwrap_or(f64::NAN),
            velocity_sigma_mps: vector(fix.velocity_sigma_mps),
            satellites: fix.satellites.map_or(f64::NAN, f64::from),
            ..StatedFix::at(Some(time), position)
        };
        if assembly.fix(*place, stated)
            && let Some(failure) = quality.check(fix).iter().next()
        {
            let (count, _) = poor.get_or_insert_with(|| (0, failure.to_string()));
            *count += 1;
        }
    }
    for (place, ReceiverHeading { time_of_week_ms, heading }) in headings {
        // A heading without a fix of its epoch has no time on this clock.
        if let Some(&time) = epochs.get(&u64::from(*time_of_week_ms)) {
            assembly.heading(*place, AntennaHeading { time, ..*heading });
        }
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
