//! Outputs of the frequency responses.

use nalgebra::DVector;

use super::flight::GRAVITY_MPS2;
use crate::record::Experiment;

/// Outputs of the responses: rates, and the accelerations that accelerometers at the centre of gravity measure.
///
/// Attitude and velocity are not outputs: as integrals of these signals they add no information. Their initial values
/// would last through a window of some seconds.
pub(super) const OUTPUTS: [Output; 6] = [
    Output { name: "p", state: "p", felt: None },
    Output { name: "q", state: "q", felt: None },
    Output { name: "r", state: "r", felt: None },
    Output { name: "ax", state: "u", felt: Some(("ku", "theta", GRAVITY_MPS2)) },
    Output { name: "ay", state: "v", felt: Some(("kv", "phi", -GRAVITY_MPS2)) },
    Output { name: "az", state: "w", felt: Some(("kw", "theta", 0.0)) },
];

/// An output of the responses.
pub(super) struct Output {
    pub name: &'static str,
    pub state: &'static str,
    /// For an acceleration three values: the kinematic term to subtract from the state's rate of change, the tilt to
    /// add, and the factor of this tilt, m/s².
    pub felt: Option<(&'static str, &'static str, f64)>,
}

impl Output {
    /// The output in the record; `None` where a signal is missing.
    pub fn measured(&self, piece: &Experiment) -> Option<DVector<f64>> {
        let state = piece.signal(self.state).ok()?;
        let Some((kinematic, tilt, gravity_mps2)) = self.felt else { return Some(state) };
        let (kinematic, tilt) = (piece.signal(kinematic).ok()?, piece.signal(tilt).ok()?);
        let last = state.len().checked_sub(1)?;
        Some(DVector::from_fn(state.len(), |sample, _| {
            let (before, after) = (sample.max(1) - 1, (sample + 1).min(last));
            let rate = (state[after] - state[before]) / (2.0 * piece.period_s);
            rate - kinematic[sample] + gravity_mps2 * tilt[sample]
        }))
    }
}
