//! Reads PX4's ULog.
//!
//! The file is read twice: a survey counts the messages, then the messages of the chosen sensors are decoded.
//! Memory holds the samples and a window of the file.

mod choice;
mod definitions;
mod innovations;
mod inputs;
mod messages;
mod rows;
mod survey;
mod topics;

use crate::assembly::Assembly;
use crate::format::Format;
use crate::integrals::integrate;
use crate::log::{Log, Options};
use crate::window::Input;
use choice::Choice;
use hovernav::frames::Vector;
use hovernav_dataset::utc::moment;
use hovernav_dataset::{LogError, Manifest};
use inputs::Inputs;
use messages::Messages;
use rows::{Clipping, Rows};
use survey::{Subscriptions, Survey};
use topics::Topic;

/// Reads a ULog file.
///
/// # Errors
/// [`LogError::Bytes`] for a file that ends within its header; [`LogError::Unusable`] for one without
/// inertial samples and fixes, or without the instance that `options` name.
pub(crate) fn read(input: Input<'_>, options: &Options) -> Result<Log, LogError> {
    let path = input.path;
    let messages = || {
        Messages::new(input.window()?).map_err(LogError::io(path))?.ok_or_else(|| {
            LogError::bytes(
                path,
                0,
                "found a PX4 ULog that ends within its header, expected 16 bytes or more"
                    .to_owned(),
            )
        })
    };
    let mut surveyed = messages()?;
    let survey = Survey::of(&mut surveyed).map_err(LogError::io(path))?;
    let (choice, sentences) = Choice::of(&survey, options, path)?;

    let parameter = |name: &str| survey.parameters.get(name).copied();
    let latency_s = parameter("EKF2_GPS_DELAY").map_or(0.0, |delay_ms| delay_ms / 1e3);
    let mut rows = Rows::default();
    rows.start_us = surveyed.start_us as f64;
    rows.latency_s = if (-1.0..=10.0).contains(&latency_s) { latency_s } else { 0.0 };
    rows.has_magnetometer = choice.magnetometer.is_some();
    rows.has_baro = choice.baro.is_some();
    rows.has_global_position = survey.counts.contains_key(&(Topic::GlobalPosition, 0));
    rows.inputs = Inputs::of(&survey.parameters);
    let mut assembly = Assembly::new(true);
    assembly.select_input(options);
    remark_file(&surveyed, &survey, &mut assembly);
    for sentence in sentences {
        assembly.note(sentence);
    }
    let mut messages = messages()?;
    let mut subscriptions = Subscriptions::default();
    while let Some(message) = messages.next().map_err(LogError::io(path))? {
        match message.kind {
            b'F' | b'A' => {
                subscriptions.define(message.kind, message.body);
            }
            b'D' => {
                let Some(subscription) = subscriptions.of(message.body) else { continue };
                let (topic, instance) = (subscription.topic, subscription.instance);
                if is_read(&choice, topic, instance) {
                    let row = subscription.row(message.body);
                    rows.take(topic, &row, message.offset, &mut assembly);
                }
            }
            _ => {}
        }
    }
    rows.innovations.flush(&mut assembly);
    remark_rows(&rows, &survey, &mut assembly);
    let manifest = manifest(&survey, &rows);
    let mut log = assembly.finish(path, Format::Ulog, manifest, "EKF2")?;
    if rows.integrals.are_whole() {
        integrate(&mut log.dataset.imu);
    }
    Ok(log)
}

/// Whether messages of this topic and instance are read: those of the chosen sensors, and the first instance of
/// other topics.
fn is_read(choice: &Choice, topic: Topic, instance: u8) -> bool {
    let found = Some((topic, instance));
    match topic {
        Topic::SensorCombined | Topic::VehicleImu => choice.imu == found,
        Topic::VehicleGps | Topic::SensorGps => choice.gps == found,
        Topic::Magnetometer => choice.magnetometer == found,
        Topic::AirData | Topic::SensorBaro => choice.baro == found,
        Topic::Distance => choice.rangefinder == found,
        Topic::Sticks
        | Topic::RateControls
        | Topic::Torque
        | Topic::Thrust
        | Topic::Motors
        | Topic::Attitude
        | Topic::LocalPosition
        | Topic::GlobalPosition
        | Topic::Innovations
        | Topic::InnovationVariances
        | Topic::OldInnovations => instance == 0,
    }
}

/// Adds warnings about the file.
fn remark_file(messages: &Messages<'_>, survey: &Survey, to: &mut Assembly) {
    for (offset, reason) in messages.damages.iter() {
        to.say(format!("at byte {offset}: {reason}"));
    }
    if let Some(offset) = survey.senseless {
        to.say(format!("at byte {offset}: found an invalid message; ignored"));
    }
    if !survey.dropouts_ms.is_empty() {
        let total_ms: f64 = survey.dropouts_ms.iter().map(|&length| f64::from(length)).sum();
        let longest_ms = survey.dropouts_ms.iter().max().copied().unwrap_or_default();
        let times = match survey.dropouts_ms.len() {
            1 => "once".to_owned(),
            count => format!("{count} times"),
        };
        to.say(format!(
            "the logger dropped data {times}, {:.3} s in all, at most {:.3} s at once",
            total_ms / 1e3,
            f64::from(longest_ms) / 1e3
        ));
    }
}

/// Adds warnings and notes about the rows.
fn remark_rows(rows: &Rows, survey: &Survey, to: &mut Assembly) {
    for (sensors, clipping) in
        [("accelerometers", &rows.accel_clipping), ("gyros", &rows.gyro_clipping)]
    {
        if let Clipping { samples: [x, y, z], span: Some((first, last)) } = clipping {
            to.say(format!(
                "{sensors} at full scale between {first} and {last}, as marked in the log: {x} \
                 samples in x, {y} in y, {z} in z. Motion beyond full scale is lost"
            ));
        }
    }
    if let Some(share) = rows.integrals.share().filter(|_| !rows.integrals.are_whole()) {
        let percent = 100.0 * share;
        to.say(format!(
            "inertial samples integrate over {percent:.0} % of their interval: they are logged \
             less often than measured, so vibration aliases"
        ));
    }
    if rows.without_ellipsoid > 0 {
        to.say(format!(
            "GPS: {} fixes have only a height above mean sea level. It is used as height above the \
             ellipsoid; the error is up to 100 m",
            rows.without_ellipsoid
        ));
    }
    let is_turned =
        |(name, &value): (&String, &f64)| name.starts_with("SENS_BOARD_") && value != 0.0;
    if survey.parameters.iter().any(is_turned) {
        to.note(
            "SENS_BOARD_ROT or one of its offsets is set: PX4 has already converted the samples to \
             body axes",
        );
    }
}

/// The manifest, from the information and parameters of the log.
fn manifest(survey: &Survey, rows: &Rows) -> Manifest {
    let information = |name: &str| survey.information.get(name).map_or("", String::as_str);
    let arm = |prefix: &str| {
        let axis = |axis: &str| {
            let value = survey.parameters.get(&format!("{prefix}{axis}")).copied();
            value.filter(|value| value.abs() <= 100.0).unwrap_or_default()
        };
        Vector::new(axis("X"), axis("Y"), axis("Z"))
    };
    let mut manifest = Manifest {
        vehicle: format!("{} on {}", information("sys_name"), information("ver_hw")),
        kind: "recorded".to_owned(),
        origin: format!(
            "PX4 ULog, software {} {}",
            information("ver_sw_branch"),
            information("ver_sw")
        ),
        time: "seconds since logging began".to_owned(),
        ..Manifest::default()
    };
    manifest.imu.lever_arm_m = arm("EKF2_IMU_POS_");
    manifest.gps.antenna_lever_arm_m = arm("EKF2_GPS_POS_");
    manifest.rangefinder.lever_arm_m = arm("EKF2_RNG_POS_");
    manifest.gps.latency_s = rows.latency_s;
    manifest.date = rows.utc_at_zero.first().and_then(moment);
    manifest
}
