//! MAVLink telemetry logs, as ground stations write them.
//!
//! The log is read twice: a survey counts the messages per sender, then the messages of the chosen sensors are
//! decoded. Memory holds the samples and a window of the file.

mod frames;
mod message;
mod rows;

use std::collections::BTreeMap;

use crate::assembly::Assembly;
use crate::choice::{Counts, Tally};
use crate::format::Format;
use crate::integrals::remark_points;
use crate::latency::USUAL_LATENCY_S;
use crate::log::{Log, Options};
use crate::receivers::Tracks;
use crate::window::Input;
use frames::{Damages, Frame};
use hovernav_dataset::utc::moment;
use hovernav_dataset::{LogError, Manifest};
use message::Message;
use rows::Rows;

/// Messages per sender, and the offset of the autopilot's clock from UTC.
#[derive(Debug, Default)]
struct Survey {
    counts: BTreeMap<((u8, u8), Message), Tally>,
    /// Readings of the receivers of each sender.
    tracks: BTreeMap<(u8, u8), Tracks<Message>>,
    /// UTC of the zero of the autopilot's clock, s since 1970, from SYSTEM_TIME.
    boot_s: Option<f64>,
    first_stamp_s: Option<f64>,
}

/// Largest number of pairs of sender and message that are counted; a vehicle has dozens.
const MAX_SENDERS: usize = 4096;

/// Reads a telemetry log.
///
/// # Errors
/// [`LogError::Unusable`] for a log without inertial samples and fixes, or without the instance that
/// `options` name.
pub(crate) fn read(input: Input<'_>, options: &Options) -> Result<Log, LogError> {
    let path = input.path;
    let each = |take: &mut dyn FnMut(&Frame)| {
        frames::each(input.window()?, take).map_err(LogError::io(path))
    };
    let mut survey = Survey::default();
    let damages = each(&mut |frame| survey.take(frame))?;
    let mut assembly = Assembly::new(true);
    remark_damages(&damages, &mut assembly);
    let mut rows = survey
        .choose(options, &mut assembly)
        .map_err(|reason| LogError::Unusable { path: path.to_path_buf(), reason })?;
    each(&mut |frame| rows.take(frame, &mut assembly))?;
    if rows.without_ellipsoid > 0 {
        assembly.say(
            "GPS: heights are above mean sea level and are used as heights above the ellipsoid; \
             the error is up to 100 m",
        );
    }
    if rows.imu == Some(Message::RawImu) {
        assembly.say(
            "inertial unit: RAW_IMU states no units; thousandths of g, rad/s and gauss are \
             assumed, as ArduPilot sends them",
        );
    }
    let mut manifest = Manifest {
        kind: "recorded".to_owned(),
        origin: "MAVLink telemetry log".to_owned(),
        time: "seconds since the first message".to_owned(),
        ..Manifest::default()
    };
    manifest.gps.latency_s = rows.latency_s;
    manifest.date = survey.first_stamp_s.and_then(|stamp_s| moment((1e9 * stamp_s) as i64));
    let mut log = assembly.finish(path, Format::Tlog, manifest, "estimator")?;
    remark_points(&mut log.dataset);
    Ok(log)
}

fn remark_damages(damages: &Damages, to: &mut Assembly) {
    if let Some(first) = damages.first_wrong {
        to.say(format!(
            "at byte {first}: a frame with a wrong checksum; {} such frames skipped",
            damages.wrong_checksums
        ));
    }
    if let Some(first) = damages.first_passed {
        to.say(format!(
            "at byte {first}: found no MAVLink frame; {} such bytes ignored",
            damages.skipped
        ));
    }
    if let Some(place) = damages.cut_off {
        to.say(format!("at byte {place}: the file ends within a frame, which is ignored"));
    }
}

impl Survey {
    fn take(&mut self, frame: &Frame) {
        let key = (frame.sender, frame.message);
        if self.counts.len() < MAX_SENDERS || self.counts.contains_key(&key) {
            self.counts.entry(key).or_default().count(frame.is_good(), &[]);
            if matches!(frame.message, Message::GpsRaw | Message::Gps2Raw) {
                let [time_s, lat, lon, _, speed_mps, ..] = frame.row;
                let tracks = self.tracks.entry(frame.sender).or_default();
                tracks.push(frame.message, time_s, [lat, lon], [speed_mps, f64::NAN]);
            }
        }
        self.first_stamp_s.get_or_insert(frame.stamp_s);
        if frame.message == Message::SystemTime && frame.row[1] > 0.0 {
            self.boot_s.get_or_insert(frame.row[1] - frame.row[0]);
        }
    }

    /// Chooses the sensors to read; an error message if the wanted instance is missing.
    fn choose(&self, options: &Options, to: &mut Assembly) -> Result<Rows, String> {
        let mut by_sender: BTreeMap<(u8, u8), usize> = BTreeMap::new();
        for (&(sender, _), tally) in &self.counts {
            *by_sender.entry(sender).or_default() += tally.messages;
        }
        let most = by_sender.iter().max_by_key(|&(sender, count)| (*count, !sender.1));
        let sender = most.map_or((1, 1), |(&sender, _)| sender);
        if by_sender.len() > 1 {
            to.note(format!(
                "system {} component {} is read because it sent most messages; {} other senders \
                 are ignored",
                sender.0,
                sender.1,
                by_sender.len() - 1
            ));
        }
        let mut chosen =
            |sensor: &str, messages: &[(Message, usize)], wanted: (&str, Option<usize>)| {
                let counts = Counts::new(messages.iter().map(|&(message, instance)| {
                    let count = self.counts.get(&(sender, message)).copied().unwrap_or_default();
                    let held = self.tracks.get(&sender).map_or(0, |tracks| tracks.held(&message));
                    ((message, instance), count.without(held))
                }));
                let name = |(message, _): (Message, usize)| message.name().to_owned();
                let taken = counts.choose(wanted, |(_, instance)| instance, name);
                let (taken, sentence) = taken.map_err(|reason| format!("{sensor}: {reason}"))?;
                if let Some(sentence) = sentence {
                    to.note(format!("{sensor}: {sentence}"));
                }
                Ok::<_, String>(taken.map(|(message, _)| message))
            };
        let imu = [
            (Message::HighresImu, 0),
            (Message::ScaledImu, 0),
            (Message::RawImu, 0),
            (Message::ScaledImu2, 1),
            (Message::ScaledImu3, 2),
        ];
        let imu = chosen("inertial unit", &imu, ("--imu", options.imu))?;
        let gps = [(Message::GpsRaw, 0), (Message::Gps2Raw, 1)];
        let gps = chosen("GPS", &gps, ("--gps", options.gps))?;
        let rangefinder = [(Message::DistanceSensor, 0), (Message::Rangefinder, 1)];
        let rangefinder = chosen("rangefinder", &rangefinder, ("", None))?;
        if gps.is_some() {
            to.note(format!(
                "GPS: the log does not state the latency of fixes; {USUAL_LATENCY_S} s is assumed, \
                 as for u-blox receivers. Set [gps] latency_s to change it"
            ));
        }
        let latency_s = USUAL_LATENCY_S;
        let boot_s = self.boot_s;
        Ok(Rows { sender, imu, gps, rangefinder, latency_s, boot_s, ..Rows::default() })
    }
}
