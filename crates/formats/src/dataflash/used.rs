//! The sensors that the autopilot itself used, as the log states them.

use std::collections::BTreeMap;

use super::message::Message;

/// Number of IMUs of a log at most.
const MAX_IMUS: usize = 8;
/// `EK3_IMU_MASK` if the log does not have it: the first two IMUs.
const USUAL_MASK: f64 = 3.0;

/// Counts of the messages in which each sensor was in use.
///
/// # Source
/// ArduPilot, `libraries/AP_NavEKF3/AP_NavEKF3_Logging.cpp` (XKF4 and XKFS) and `libraries/AP_GPS/LogStructure.h` (`U`).
#[derive(Debug, Default)]
pub(super) struct Used {
    /// The primary core of the EKF in the last message that states it.
    primary: usize,
    cores: BTreeMap<usize, usize>,
    sensors: BTreeMap<(Message, usize), usize>,
}

/// The number in a cell; `None` for a missing or impossible one.
pub(super) fn index(cell: f64) -> Option<usize> {
    (0.0..MAX_IMUS as f64).contains(&cell).then_some(cell as usize)
}

impl Used {
    pub fn take(&mut self, message: Message, instance: usize, row: &[f64]) {
        match message {
            Message::Core => {
                if let Some(core) = index(row[2]) {
                    self.primary = core;
                    *self.cores.entry(core).or_default() += 1;
                }
            }
            Message::Selection if instance == self.primary => {
                let sensors = [Message::Magnetometer, Message::Baro, Message::Gps];
                for (sensor, cell) in sensors.into_iter().zip(&row[2..5]) {
                    if let Some(used) = index(*cell) {
                        *self.sensors.entry((sensor, used)).or_default() += 1;
                    }
                }
            }
            Message::Gps if row[21] == 1.0 => {
                *self.sensors.entry((message, instance)).or_default() += 1;
            }
            _ => {}
        }
    }

    /// The sensor of this kind that was in use most of the time. The cores of the EKF have the IMUs of the bits of
    /// `mask`, in this order.
    pub fn mostly(&self, message: Message, mask: Option<f64>) -> Option<usize> {
        if matches!(message, Message::Imu | Message::Imt) {
            let (core, _) = self.cores.iter().max_by_key(|(_, count)| **count)?;
            let mask = mask.unwrap_or(USUAL_MASK) as u32;
            return (0..MAX_IMUS).filter(|imu| mask >> imu & 1 == 1).nth(*core);
        }
        let of_kind = self.sensors.iter().filter(|((sensor, _), _)| *sensor == message);
        of_kind.max_by_key(|(_, count)| **count).map(|((_, instance), _)| *instance)
    }
}
