//! Comparison of a record's solution with its replay.

use hovernav_record::Reproduction;
use serde::Serialize;

/// The difference between the replayed solution and the one computed in flight.
#[derive(Clone, Debug, Serialize)]
pub struct ReproductionSummary {
    compared: usize,
    identical: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    first_difference_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    position_difference_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    velocity_difference_mps: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    attitude_difference_deg: Option<f64>,
}

impl From<Reproduction> for ReproductionSummary {
    fn from(reproduction: Reproduction) -> Self {
        let difference = reproduction.first_difference;
        let distance = difference.and_then(|difference| difference.distance);
        Self {
            compared: reproduction.compared,
            identical: difference.is_none(),
            first_difference_s: difference.map(|difference| difference.time.seconds()),
            position_difference_m: distance.map(|[position_m, ..]| position_m),
            velocity_difference_mps: distance.map(|[_, velocity_mps, _]| velocity_mps),
            attitude_difference_deg: distance.map(|[.., attitude_rad]| attitude_rad.to_degrees()),
        }
    }
}

impl ReproductionSummary {
    /// The comparison in one line.
    #[must_use]
    pub fn in_words(&self) -> String {
        let Some(first_s) = self.first_difference_s else {
            return format!("flown solution reproduced bit for bit ({} samples)", self.compared);
        };
        let far = match (
            self.position_difference_m,
            self.velocity_difference_mps,
            self.attitude_difference_deg,
        ) {
            (Some(m), Some(mps), Some(deg)) => format!("by {m:.3e} m, {mps:.3e} m/s, {deg:.3e}°"),
            _ => "where only one of them has a solution".into(),
        };
        format!("flown solution not reproduced: it first differs at {first_s:.6} s, {far}")
    }
}
