//! Lever arms in files: three numbers in metres, limited to the size of a vehicle.

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use hovernav::frames::{Body, Vector};

/// Largest component of a lever arm, m.
const LONGEST_M: f64 = 100.0;

pub(crate) fn serialize<S: Serializer>(
    arm: &Vector<Body>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    arm.to_array().serialize(serializer)
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vector<Body>, D::Error> {
    let arm = <[f64; 3]>::deserialize(deserializer)?;
    if arm.iter().all(|component| component.abs() <= LONGEST_M) {
        return Ok(arm.into());
    }
    Err(de::Error::custom(format!("found {arm:?}, expected metres within ±{LONGEST_M}")))
}
