//! Which of several sensors is read.

use std::path::Path;

use super::survey::Survey;
use super::topics::Topic;
use crate::open::Options;
use hovernav_log::LogError;

/// One topic of one instance for each sensor; none where the log has none.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Choice {
    pub imu: Option<(Topic, u8)>,
    pub gps: Option<(Topic, u8)>,
    pub magnetometer: Option<(Topic, u8)>,
    pub baro: Option<(Topic, u8)>,
}

/// Another topic than the first is taken where it has so many times as many messages.
const MUCH_MORE: f64 = 1.5;

impl Choice {
    /// What is read of the log surveyed, and a sentence about each sensor with a choice. Of topics in
    /// order of preference the first, unless another has many more messages; an instance that
    /// `options` name is taken from the topic that counts sensors.
    ///
    /// # Errors
    /// [`LogError::Unusable`] where the log has no such instance.
    pub fn of(
        survey: &Survey,
        options: &Options,
        path: &Path,
    ) -> Result<(Self, Vec<String>), LogError> {
        let mut sentences = Vec::new();
        let mut chosen = |sensor: &str, topics: &[Topic], counting: &[Topic], wanted| {
            choose(survey, topics, counting, wanted)
                .map(|(taken, sentence)| {
                    sentences.extend(sentence.map(|sentence| format!("{sensor}: {sentence}")));
                    taken
                })
                .map_err(|reason| LogError::Unusable {
                    path: path.to_path_buf(),
                    reason: format!("{sensor}: {reason}"),
                })
        };
        let imu = [Topic::SensorCombined, Topic::VehicleImu];
        let gps = [Topic::VehicleGps, Topic::SensorGps];
        let baro = [Topic::AirData, Topic::SensorBaro];
        let choice = Self {
            imu: chosen("inertial unit", &imu, &[Topic::VehicleImu], options.imu)?,
            gps: chosen("GPS", &gps, &[Topic::SensorGps, Topic::VehicleGps], options.gps)?,
            magnetometer: chosen(
                "magnetometer",
                &[Topic::Magnetometer],
                &[Topic::Magnetometer],
                options.magnetometer,
            )?,
            baro: chosen("barometer", &baro, &[Topic::SensorBaro], options.baro)?,
        };
        Ok((choice, sentences))
    }
}

type Taken = (Option<(Topic, u8)>, Option<String>);

/// One of `topics`, or of the instances of `counting` the one `wanted`; and what there was to choose
/// from.
fn choose(
    survey: &Survey,
    topics: &[Topic],
    counting: &[Topic],
    wanted: Option<usize>,
) -> Result<Taken, String> {
    let messages = |topic: Topic, instance| survey.counts.get(&(topic, instance)).copied();
    let present: Vec<(Topic, u8)> = topics
        .iter()
        .flat_map(|&topic| survey.counts.keys().copied().filter(move |found| found.0 == topic))
        .collect();
    let in_words = |found: (Topic, u8)| {
        let count = messages(found.0, found.1).unwrap_or_default();
        format!("{} {} ({count} messages)", found.0.name(), found.1)
    };
    let taken = match wanted {
        // What PX4 itself uses is instance 0 of a log that does not count its sensors.
        Some(wanted) => {
            let instance = u8::try_from(wanted).ok();
            let counted =
                counting.iter().chain(topics.iter().filter(|_| wanted == 0)).find_map(|&topic| {
                    instance.filter(|&i| messages(topic, i).is_some()).map(|i| (topic, i))
                });
            Some(counted.ok_or_else(|| {
                let present: Vec<String> = present.iter().copied().map(in_words).collect();
                let present = if present.is_empty() { "none".into() } else { present.join(", ") };
                format!("found no instance {wanted}; the log has {present}")
            })?)
        }
        None => {
            let mut best: Option<((Topic, u8), usize)> = None;
            for &found in &present {
                let count = messages(found.0, found.1).unwrap_or_default();
                if best.is_none_or(|(_, most)| count as f64 > MUCH_MORE * most as f64) {
                    best = Some((found, count));
                }
            }
            best.map(|(found, _)| found)
        }
    };
    let others: Vec<String> =
        present.iter().copied().filter(|&found| Some(found) != taken).map(in_words).collect();
    let sentence = taken.filter(|_| !others.is_empty()).map(|taken| {
        format!("{} is read; the log also has {}", in_words(taken), others.join(", "))
    });
    Ok((taken, sentence))
}
