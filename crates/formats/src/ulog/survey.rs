//! First pass over a ULog file: counts messages and reads parameters.

use std::collections::{BTreeMap, HashMap};
use std::io;

use super::definitions::{Cell, Definitions};
use super::messages::Messages;
use super::rows::place_deg;
use super::topics::Topic;
use crate::choice::{Tally, is_alive, is_fix};
use crate::receivers::Tracks;
use hovernav_dataset::Dimensions;

/// Contents of a ULog file.
#[derive(Debug, Default)]
pub(super) struct Survey {
    /// Number of messages of each topic and instance that is read.
    pub counts: BTreeMap<(Topic, u8), Tally>,
    /// Readings of the receivers.
    pub tracks: Tracks<(Topic, u8)>,
    /// Last values of numeric parameters.
    pub parameters: HashMap<String, f64>,
    /// Information about the vehicle, such as `ver_hw`.
    pub information: HashMap<String, String>,
    /// Durations of the logger's dropouts, ms.
    pub dropouts_ms: Vec<u16>,
    /// Byte offset of the first invalid definition, subscription or value.
    pub senseless: Option<u64>,
}

/// Parts of the names of parameters that are kept; others would only take memory.
const PARAMETERS: [&str; 4] = ["EKF2_GPS_", "EKF2_IMU_POS_", "SENS_BOARD_", "CA_ROTOR"];
/// Names of the information that is kept.
const INFORMATION: [&str; 4] = ["sys_name", "ver_hw", "ver_sw", "ver_sw_branch"];
/// Largest number of dropouts that are kept; a log has a handful.
const DROPOUTS: usize = 100_000;

impl Survey {
    /// Reads `messages` to the end.
    pub fn of(messages: &mut Messages<'_>) -> io::Result<Self> {
        let mut survey = Self::default();
        let mut subscriptions = Subscriptions::default();
        while let Some(message) = messages.next()? {
            let body = message.body;
            let makes_sense = match message.kind {
                b'D' => {
                    if let Some(subscription) = subscriptions.of(body) {
                        let (topic, instance) = (subscription.topic, subscription.instance);
                        let row = subscription.row(body);
                        let tally = survey.counts.entry((topic, instance)).or_default();
                        tally.count(topic.is_good(&row), &topic.reading(&row));
                        if matches!(topic, Topic::VehicleGps | Topic::SensorGps) {
                            let is_valid = row[12] != 0.0;
                            let velocity = if is_valid { [row[9], row[10]] } else { [f64::NAN; 2] };
                            let receiver = (topic, instance);
                            survey.tracks.push(receiver, 1e-6 * row[0], place_deg(&row), velocity);
                        }
                    }
                    true
                }
                b'F' | b'A' => subscriptions.define(message.kind, body),
                b'P' => survey.parameter(body).is_some(),
                b'I' => survey.information(body).is_some(),
                b'O' => {
                    let length = body.first_chunk().map(|bytes| u16::from_le_bytes(*bytes));
                    if survey.dropouts_ms.len() < DROPOUTS {
                        survey.dropouts_ms.extend(length);
                    }
                    length.is_some()
                }
                _ => true,
            };
            if !makes_sense && survey.senseless.is_none() {
                survey.senseless = Some(message.offset);
            }
        }
        Ok(survey)
    }

    fn parameter(&mut self, body: &[u8]) -> Option<()> {
        let (key, value) = keyed(body)?;
        if PARAMETERS.iter().any(|wanted| key.contains(wanted)) {
            let (name, number) = Cell::keyed(key, value)?;
            self.parameters.insert(name.to_owned(), number);
        }
        Some(())
    }

    fn information(&mut self, body: &[u8]) -> Option<()> {
        let (key, value) = keyed(body)?;
        let name = key.split_once(' ').map_or(key, |(_, name)| name);
        if INFORMATION.contains(&name) {
            let text = String::from_utf8_lossy(value).trim_end_matches('\0').to_owned();
            self.information.insert(name.to_owned(), text);
        }
        Some(())
    }
}

/// The length-prefixed key, a type and a name, and the value after it.
fn keyed(body: &[u8]) -> Option<(&str, &[u8])> {
    let (&length, rest) = body.split_first()?;
    let (key, value) = rest.split_at_checked(usize::from(length))?;
    Some((std::str::from_utf8(key).ok()?, value))
}

impl Topic {
    /// Whether a message with this row has a measurement that may be used.
    fn is_good(self, row: &[f64]) -> bool {
        match self {
            Self::VehicleGps | Self::SensorGps => {
                is_fix(Dimensions::of_type(row[16]), place_deg(row))
            }
            Self::SensorCombined | Self::VehicleImu => is_alive([row[6], row[7], row[8]]),
            Self::Magnetometer => is_alive([row[2], row[3], row[4]]),
            _ => true,
        }
    }

    /// The values that change from each measurement to the next.
    fn reading(self, row: &[f64]) -> [&[f64]; 2] {
        match self {
            Self::SensorCombined => [&row[1..4], &row[6..9]],
            Self::VehicleImu => [&row[2..5], &row[6..9]],
            _ => [&[], &[]],
        }
    }
}

/// Topic and layout of the data messages of one number.
#[derive(Debug)]
pub(super) struct Subscription {
    pub topic: Topic,
    pub instance: u8,
    /// Offset and type of each of the topic's columns.
    cells: Vec<Option<Cell>>,
}

impl Subscription {
    /// The topic's columns in `body`; NaN for missing ones.
    pub fn row(&self, body: &[u8]) -> [f64; Topic::WIDTH] {
        let mut row = [f64::NAN; Topic::WIDTH];
        let body = body.get(2..).unwrap_or_default();
        for (number, cell) in row.iter_mut().zip(&self.cells) {
            if let Some(cell) = cell {
                *number = cell.number(body);
            }
        }
        row
    }
}

/// The topics that are read, by their number in the file.
#[derive(Debug, Default)]
pub(super) struct Subscriptions {
    definitions: Definitions,
    by_number: Vec<Option<Subscription>>,
}

impl Subscriptions {
    /// Reads a definition (`F`) or a subscription (`A`); false if it is invalid.
    pub fn define(&mut self, kind: u8, body: &[u8]) -> bool {
        match kind {
            b'F' => self.definitions.add(body),
            _ => self.subscribe(body).is_some(),
        }
    }

    fn subscribe(&mut self, body: &[u8]) -> Option<()> {
        let (&[instance, low, high], name) = body.split_first_chunk()?;
        let name = std::str::from_utf8(name).ok()?;
        let number = usize::from(u16::from_le_bytes([low, high]));
        let Some(topic) = Topic::named(name) else {
            if let Some(place) = self.by_number.get_mut(number) {
                *place = None;
            }
            return Some(());
        };
        let cells = self.definitions.cells(name, topic.columns())?;
        if self.by_number.len() <= number {
            self.by_number.resize_with(number + 1, || None);
        }
        self.by_number[number] = Some(Subscription { topic, instance, cells });
        Some(())
    }

    /// The subscription of the data message `body`, if it is read.
    pub fn of(&self, body: &[u8]) -> Option<&Subscription> {
        let number = u16::from_le_bytes(*body.first_chunk()?);
        self.by_number.get(usize::from(number))?.as_ref()
    }
}
