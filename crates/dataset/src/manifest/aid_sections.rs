//! Sections of `dataset.toml` for aids other than GPS.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use hovernav::ekf::{AntennaHeadingModel, RangeModel};
use hovernav::frames::{Body, Vector};
use hovernav::imu::NotchConfig;
use hovernav::scalar::Readable;

use crate::manifest::lever_arm;

/// `[rangefinder]`: a downward-looking rangefinder; its readings are in `range.csv`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct RangefinderSection {
    /// Position of the sensor relative to the centre of gravity, m.
    #[serde(with = "lever_arm")]
    pub lever_arm_m: Vector<Body>,
    /// Direction of the rangefinder's beam in body axes, a vector of any length; 0, 0, 1 is straight down.
    #[serde(with = "direction")]
    pub beam: Vector<Body>,
    /// Measurement model of the rangefinder, including the variation of the ground.
    pub model: RangeModel,
}

impl Default for RangefinderSection {
    fn default() -> Self {
        let beam = Vector::new(0.0, 0.0, 1.0);
        Self { lever_arm_m: Vector::ZERO, beam, model: RangeModel::default() }
    }
}

/// `[second_antenna]`: the second of two GPS antennas that give a heading; its readings are in `heading.csv`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct SecondAntennaSection {
    /// Position of the second antenna relative to the centre of gravity, m. Without it, the headings are those of the
    /// vehicle, not of the baseline between the antennas.
    #[serde(with = "some_lever_arm", skip_serializing_if = "Option::is_none")]
    pub lever_arm_m: Option<Vector<Body>>,
    /// Accuracy of the heading.
    pub model: AntennaHeadingModel,
}

impl SecondAntennaSection {
    /// Vector from the first antenna to the second, m.
    pub(crate) fn baseline_m(&self, first_m: Vector<Body>) -> Option<Vector<Body>> {
        self.lever_arm_m.map(|second_m| second_m - first_m)
    }
}

/// Conversion of an optional lever arm from and to a file.
mod some_lever_arm {
    use super::{Body, Deserializer, Serialize, Serializer, Vector, lever_arm};

    pub fn serialize<S: Serializer>(
        arm: &Option<Vector<Body>>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        arm.map(Vector::to_array).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<Vector<Body>>, D::Error> {
        lever_arm::deserialize(deserializer).map(Some)
    }
}

/// Deserialises a notch filter and checks its settings.
pub(crate) fn notch<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<NotchConfig>, D::Error> {
    let notch = NotchConfig::deserialize(deserializer)?;
    match notch.out_of_range() {
        Some((key, value, expected)) => {
            let found = Readable(value);
            Err(de::Error::custom(format!("{key}: found {found}, expected {expected}")))
        }
        None => Ok(Some(notch)),
    }
}

mod direction {
    use super::{Body, Deserialize, Deserializer, Serialize, Serializer, Vector, de};

    pub fn serialize<S: Serializer>(beam: &Vector<Body>, serializer: S) -> Result<S::Ok, S::Error> {
        beam.to_array().serialize(serializer)
    }

    /// Deserialises a direction and scales it to unit length.
    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vector<Body>, D::Error> {
        let beam = <[f64; 3]>::deserialize(deserializer)?;
        let vector = Vector::<Body>::from(beam);
        let length = vector.norm();
        if (1e-3..1e6).contains(&length) {
            return Ok(vector * (1.0 / length));
        }
        Err(de::Error::custom(format!("found {beam:?}, expected a direction")))
    }
}
