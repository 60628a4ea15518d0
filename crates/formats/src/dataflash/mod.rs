//! Reads ArduPilot's DataFlash logs, binary and text.
//!
//! The log is read twice: a survey counts the messages, then the messages of the chosen sensors are decoded. Memory
//! holds the samples and a window of the file.

mod binary;
mod inputs;
mod item;
mod lines;
mod message;
mod rows;
mod schema;
mod used;

use std::collections::{BTreeMap, HashMap};

use crate::assembly::Assembly;
use crate::choice::{Counts, Tally};
use crate::damages::Damages;
use crate::format::Format;
use crate::integrals::{integrate, remark_points};
use crate::latency::USUAL_LATENCY_S;
use crate::log::{Log, Options};
use crate::receivers::Tracks;
use crate::window::Input;
use hovernav::frames::Vector;
use hovernav_dataset::utc::moment;
use hovernav_dataset::{LogError, Manifest};
use item::Item;
use message::Message;
use rows::Rows;
use used::Used;

/// Contents of a log.
#[derive(Debug, Default)]
struct Survey {
    counts: BTreeMap<(Message, usize), Tally>,
    /// Number of errors that each sensor has counted.
    errors: BTreeMap<(Message, usize), f64>,
    used: Used,
    /// Readings of the receivers.
    tracks: Tracks<usize>,
    parameters: HashMap<String, f64>,
    /// The text with the autopilot's name and version, otherwise the first text.
    text: String,
    start_s: Option<f64>,
}

/// Prefixes of the parameters that are read.
const PARAMETERS: [&str; 9] =
    ["GPS", "INS_POS", "RC", "AHRS_ORIENT", "AHRS_EKF", "EK2_IMU", "EK3_IMU", "RNGFND", "FRAME_"];
/// Largest number of parameters that are kept.
const MAX_PARAMETERS: usize = 10_000;
/// Reads a DataFlash log, binary or text as in `format`.
///
/// # Errors
/// [`LogError::Unusable`] for a log without inertial samples and fixes, or without the instance that
/// `options` name.
pub(crate) fn read(input: Input<'_>, format: Format, options: &Options) -> Result<Log, LogError> {
    let path = input.path;
    let is_text = format == Format::DataflashText;
    let each = |take: &mut dyn FnMut(Item<'_>)| {
        let window = input.window()?;
        let each = if is_text { lines::each } else { binary::each };
        each(window, take).map_err(LogError::io(path))
    };
    let mut survey = Survey::default();
    let damages = each(&mut |item| survey.take(item))?;

    let mut assembly = Assembly::new(!is_text);
    assembly.select_input(options);
    remark_damages(&damages, is_text, &mut assembly);
    let mut rows = survey
        .choose(options, &mut assembly)
        .map_err(|reason| LogError::Unusable { path: path.to_path_buf(), reason })?;
    each(&mut |item| rows.take(&item, &mut assembly))?;
    rows.flush(&mut assembly);
    survey.remark(&rows, &mut assembly);
    let manifest = survey.manifest(&rows);
    let mut log = assembly.finish(path, format, manifest, survey.estimator())?;
    if rows.integrals.are_whole() {
        integrate(&mut log.dataset.imu);
    } else {
        remark_points(&mut log.dataset);
    }
    Ok(log)
}

fn remark_damages(damages: &Damages, is_text: bool, to: &mut Assembly) {
    let place = if is_text { "line" } else { "byte" };
    for (at, reason) in damages.iter() {
        to.say(format!("at {place} {at}: {reason}"));
    }
}

impl Survey {
    fn take(&mut self, item: Item<'_>) {
        match item {
            Item::Row { message, instance, ref row, .. } => {
                let sensor = (message, instance);
                let has_new_errors = message.errors(row).is_some_and(|errors| {
                    self.errors.insert(sensor, errors).is_some_and(|before| errors > before)
                });
                let is_good = message.is_good(row) && !has_new_errors;
                let tally = self.counts.entry(sensor).or_default();
                tally.count(is_good, &[message.reading(row)]);
                self.used.take(message, instance, row);
                let clock_s = Rows::default().clock_s(message, row);
                if message == Message::Gps {
                    let (place_deg, velocity_mps) = Message::place_and_velocity(row);
                    self.tracks.push(instance, clock_s, place_deg, velocity_mps);
                }
                if self.start_s.is_none() && clock_s > 0.0 {
                    self.start_s = Some(clock_s);
                }
            }
            Item::Parameter { name, value } => {
                let is_read = PARAMETERS.iter().any(|wanted| name.starts_with(wanted));
                if is_read && self.parameters.len() < MAX_PARAMETERS {
                    self.parameters.insert(name.to_owned(), value);
                }
            }
            Item::Text(text) => {
                // Texts with warnings may precede the text with the version.
                let is_better = names_firmware(text) && !names_firmware(&self.text);
                if self.text.is_empty() || is_better {
                    self.text = text.to_owned();
                }
            }
        }
    }

    /// The first of these parameters that the log has.
    fn parameter(&self, names: &[&str]) -> Option<f64> {
        names.iter().find_map(|name| self.parameters.get(*name).copied())
    }

    /// Bits of the IMUs that the cores of the EKF use, if the log has this parameter.
    fn imus_of_cores(&self) -> Option<f64> {
        let is_ekf2 = self.parameter(&["AHRS_EKF_TYPE"]) == Some(2.0);
        self.parameter(&[if is_ekf2 { "EK2_IMU_MASK" } else { "EK3_IMU_MASK" }])
    }

    /// Chooses the sensors to read; an error message if the wanted instance is missing.
    fn choose(&self, options: &Options, to: &mut Assembly) -> Result<Rows, String> {
        let mut chosen = |sensor: &str, messages: &[Message], wanted: (&str, Option<usize>)| {
            let counts = Counts::new(messages.iter().flat_map(|&message| {
                let of_kind = move |&((found, _), _): &(&(Message, usize), _)| *found == message;
                let mut found: Vec<_> = self.counts.iter().filter(of_kind).collect();
                let used = self.used.mostly(message, self.imus_of_cores());
                found.sort_by_key(|((_, instance), _)| Some(*instance) != used);
                found.into_iter().map(move |(&(_, instance), &count)| {
                    let is_gps = message == Message::Gps;
                    let held = if is_gps { self.tracks.held(&instance) } else { 0 };
                    ((message, instance), count.without(held))
                })
            }));
            let name =
                |(message, instance): (Message, usize)| format!("{} {instance}", message.name());
            let taken = counts.choose(wanted, |(_, instance)| instance, name);
            let (taken, sentence) = taken.map_err(|reason| format!("{sensor}: {reason}"))?;
            if let Some(sentence) = sentence {
                to.note(format!("{sensor}: {sentence}"));
            }
            Ok::<_, String>(taken)
        };
        let imu = chosen("inertial unit", &[Message::Imt, Message::Imu], ("--imu", options.imu))?;
        let gps = chosen("GPS", &[Message::Gps], ("--gps", options.gps))?;
        let baro = chosen("barometer", &[Message::Baro], ("--baro", options.baro))?;
        let magnetometer =
            chosen("magnetometer", &[Message::Magnetometer], ("--mag", options.magnetometer))?;
        let rangefinder = chosen("rangefinder", &[Message::Rangefinder], ("", None))?;
        let trim = |channel: usize| {
            let name = format!("RC{channel}_TRIM");
            self.parameter(&[&name])
                .filter(|trim| (800.0..=2200.0).contains(trim))
                .unwrap_or(1500.0)
        };
        let latency_s = self.parameter(&["GPS_DELAY_MS", "GPS1_DELAY_MS"]).unwrap_or(0.0) / 1e3;
        let is_given = latency_s > 0.0 && latency_s <= 10.0;
        if !is_given && gps.is_some() {
            to.note(format!(
                "GPS: the log does not state the latency of fixes; {USUAL_LATENCY_S} s is assumed, \
                 as for u-blox receivers. Set [gps] latency_s to change it"
            ));
        }
        Ok(Rows {
            imu,
            gps: gps.map(|(_, instance)| instance),
            baro: baro.map(|(_, instance)| instance),
            magnetometer: magnetometer.map(|(_, instance)| instance),
            rangefinder: rangefinder.map(|(_, instance)| instance),
            cores: self
                .counts
                .keys()
                .filter(|key| key.0 == Message::Velocity)
                .map(|key| key.1)
                .collect(),
            has_quaternion: self.counts.contains_key(&(Message::Quaternion, 0)),
            start_s: self.start_s.unwrap_or(0.0),
            latency_s: if is_given { latency_s } else { USUAL_LATENCY_S },
            // The throttle trim is the lower end of the travel, but hovernav counts the stick position from the middle.
            trims_us: [trim(1), trim(2), 1500.0, trim(4)],
            mixer: inputs::mixer(self.parameter(&["FRAME_CLASS"]), self.parameter(&["FRAME_TYPE"])),
            ..Rows::default()
        })
    }

    /// Adds warnings and notes about the rows.
    fn remark(&self, rows: &Rows, to: &mut Assembly) {
        if rows.fixes > 0 {
            to.say(
                "GPS: heights are above mean sea level and are used as heights above the \
                 ellipsoid; the error is up to 100 m",
            );
        }
        if self.parameter(&["AHRS_ORIENTATION"]).is_some_and(|turn| turn != 0.0) {
            to.note(
                "AHRS_ORIENTATION is set: ArduPilot has already converted the samples to body axes",
            );
        }
    }

    /// Name of the onboard estimator.
    fn estimator(&self) -> &'static str {
        if self.counts.contains_key(&(Message::Velocity, 0)) { "EKF" } else { "AHRS" }
    }

    fn manifest(&self, rows: &Rows) -> Manifest {
        let arm = |names: [&str; 2]| {
            let axis = |axis: &str| {
                let names = names.map(|name| format!("{name}{axis}"));
                let value = self.parameter(&[&names[0], &names[1]]);
                value.filter(|value| value.abs() <= 100.0).unwrap_or_default()
            };
            Vector::new(axis("X"), axis("Y"), axis("Z"))
        };
        let mut manifest = Manifest {
            vehicle: self.text.clone(),
            kind: "recorded".to_owned(),
            origin: "ArduPilot DataFlash log".to_owned(),
            time: "seconds since the first message".to_owned(),
            ..Manifest::default()
        };
        let unit = rows.imu.map_or(0, |(_, instance)| instance) + 1;
        let receiver = rows.gps.map_or(0, |instance| instance) + 1;
        let (imu, old) = (format!("INS_POS{unit}_"), format!("GPS_POS{receiver}_"));
        manifest.imu.lever_arm_m = arm([&imu, &imu]);
        manifest.gps.antenna_lever_arm_m = arm([&old, &format!("GPS{receiver}_POS_")]);
        if let Some(rangefinder) = rows.rangefinder {
            let place = format!("RNGFND{}_POS_", rangefinder + 1);
            manifest.rangefinder.lever_arm_m = arm([&place, &place]);
        }
        manifest.gps.latency_s = rows.latency_s;
        manifest.date = rows.utc_at_zero.first().and_then(moment);
        manifest
    }
}

/// Whether a text contains a firmware's name and version, as in "ArduCopter V4.5.1 (hash)".
fn names_firmware(text: &str) -> bool {
    let version = text.split_whitespace().nth(1).and_then(|word| word.strip_prefix('V'));
    version.is_some_and(|version| version.starts_with(|first: char| first.is_ascii_digit()))
}
