//! Is a flight fit to be identified from? What a reader must know before the numbers.

use super::flight::MOTION;
use super::kind::Kind;
use crate::methods::excitation::check_inputs;
use crate::record::preprocess::{KinematicChannels, check_kinematics};
use crate::record::{Experiment, STICKS};

/// What is wrong with the sticks and the motion of `record`, one plain sentence each: sticks that do
/// not move or move together, attitude, rates and velocity that are not of one body.
///
/// `record` has the signals of [`FlightRecord`](super::FlightRecord); only the sticks and
/// outputs that `kind` uses are looked at.
#[must_use]
pub fn flight_warnings(record: &Experiment, kind: Kind) -> Vec<String> {
    let structure = kind.structure();
    let names = |names: &[String]| -> Vec<&'static str> {
        let known = STICKS.into_iter().chain(MOTION);
        known.filter(|known| names.iter().any(|name| name == known)).collect()
    };
    let mut warnings = Vec::new();
    if let Ok(used) = record.select(&names(&structure.inputs), &names(&structure.outputs)) {
        warnings.extend(check_inputs(&used).faults.iter().map(ToString::to_string));
    }
    let every = KinematicChannels {
        roll: Some("phi"),
        pitch: Some("theta"),
        p: Some("p"),
        q: Some("q"),
        r: Some("r"),
        u: Some("u"),
        v: Some("v"),
        w: Some("w"),
        specific_force: None,
    };
    if let Ok(report) = check_kinematics(record, &every) {
        warnings.extend(report.faults.iter().map(|fault| format!("kinematics: {fault}")));
    }
    warnings
}
