//! Chooses the sensors of a ULog file that are read.

use std::path::Path;

use super::survey::Survey;
use super::topics::Topic;
use crate::choice::Counts;
use crate::log::Options;
use hovernav_dataset::LogError;

/// One topic and instance for each sensor; `None` for a missing sensor.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Choice {
    pub imu: Option<(Topic, u8)>,
    pub gps: Option<(Topic, u8)>,
    pub magnetometer: Option<(Topic, u8)>,
    pub baro: Option<(Topic, u8)>,
    pub rangefinder: Option<(Topic, u8)>,
}

impl Choice {
    /// The sensors to read, and one sentence for each sensor with alternatives. PX4's combined topics are
    /// preferred. An instance in `options` is first looked up in the topics of single sensors.
    ///
    /// # Errors
    /// [`LogError::Unusable`] if the log has no such instance.
    pub fn of(
        survey: &Survey,
        options: &Options,
        path: &Path,
    ) -> Result<(Self, Vec<String>), LogError> {
        let mut sentences = Vec::new();
        let mut chosen = |sensor: &str, topics: &[Topic], wanted: (&str, Option<usize>)| {
            let mut topics = topics.to_vec();
            if wanted.1.is_some() {
                topics.reverse();
            }
            let counts = Counts::new(topics.into_iter().flat_map(|topic| {
                let all = survey.counts.iter();
                all.filter(move |((found, _), _)| *found == topic)
                    .map(|(&key, &count)| (key, count.without(survey.tracks.held(&key))))
            }));
            let name = |(topic, instance): (Topic, u8)| format!("{} {instance}", topic.name());
            match counts.choose(wanted, |(_, instance)| instance.into(), name) {
                Ok((taken, sentence)) => {
                    sentences.extend(sentence.map(|sentence| format!("{sensor}: {sentence}")));
                    Ok(taken)
                }
                Err(reason) => {
                    let reason = format!("{sensor}: {reason}");
                    Err(LogError::Unusable { path: path.to_path_buf(), reason })
                }
            }
        };
        let imu = chosen(
            "inertial unit",
            &[Topic::SensorCombined, Topic::VehicleImu],
            ("--imu", options.imu),
        )?;
        let gps = chosen("GPS", &[Topic::VehicleGps, Topic::SensorGps], ("--gps", options.gps))?;
        let baro =
            chosen("barometer", &[Topic::AirData, Topic::SensorBaro], ("--baro", options.baro))?;
        // The topics of single magnetometers are not in body axes, so they are not used.
        let magnetometer =
            chosen("magnetometer", &[Topic::Magnetometer], ("--mag", options.magnetometer))?;
        let rangefinder = chosen("rangefinder", &[Topic::Distance], ("", None))?;
        Ok((Self { imu, gps, magnetometer, baro, rangefinder }, sentences))
    }
}
