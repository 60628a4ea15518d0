//! Models that come with the library, each with its source.

use std::path::Path;

use super::error::ModelError;
use super::helicopter::{Helicopter, HelicopterParameters};
use super::state_space::StateSpace;
use hovernav::frames::Vector;

/// The model printed by Paw (2005): 8 states, continuous according to him, inputs in percent of stick. It reproduces
/// his eigenvalues and gains; [`StateSpace::step_taken_for_rate`] detects that its A is a one-step transition matrix.
#[must_use]
pub fn thesis() -> StateSpace {
    parsed("thesis.toml", include_str!("data/thesis.toml"))
}

/// Mettler's identified Yamaha R-50 in hover: 13 states with stabilizer bar and yaw-rate feedback, SI units, normalised
/// sticks. Its source names the numbers that are not checked against the printed paper.
#[must_use]
pub fn mettler_r50() -> StateSpace {
    parsed("mettler_r50.toml", include_str!("data/mettler_r50.toml"))
}

/// The shipped 60-class helicopter linearised in hover: 13 states, stick −1…1. Equal to the result of
/// [`Helicopter::linearise`](super::helicopter::Helicopter::linearise).
#[must_use]
pub fn raptor60() -> StateSpace {
    parsed("raptor60.toml", include_str!("data/raptor60.toml"))
}

/// Speed, m/s, beyond which no trim of the shipped helicopter is searched.
const FASTEST_MPS: f64 = 50.0;

/// The shipped 60-class helicopter linearised in steady forward flight at `speed_mps` in calm air; backward flight is
/// negative. Its states and inputs are those of [`raptor60`].
///
/// # Errors
/// [`ModelError::Speed`] for a speed at which it has no trim within the travel of its sticks.
pub fn raptor60_at(speed_mps: f64) -> Result<StateSpace, ModelError> {
    if speed_mps.abs() > FASTEST_MPS || !speed_mps.is_finite() {
        let is_long = speed_mps.abs() >= 1e6;
        let found = if is_long { format!("{speed_mps:e}") } else { speed_mps.to_string() };
        return Err(ModelError::Speed { found });
    }
    let (calm, ahead) = (Vector::ZERO, Vector::new(speed_mps, 0.0, 0.0));
    let trimmed = Helicopter::new(HelicopterParameters::raptor60())
        .and_then(|helicopter| Ok((helicopter.trim(ahead, calm, 0.0)?, helicopter)));
    match trimmed {
        Ok((trim, helicopter)) => helicopter
            .linearise(&trim, calm)
            .named(&format!("raptor60@{speed_mps}"))
            .with_trim_speed(speed_mps),
        Err(error) => Err(ModelError::Speed { found: format!("{speed_mps}: {error}") }),
    }
}

/// A shipped model by its name: `thesis`, `mettler_r50`, `r50` for short, or `raptor60`.
#[must_use]
pub fn by_name(name: &str) -> Option<StateSpace> {
    match name {
        "thesis" => Some(thesis()),
        "mettler_r50" | "r50" => Some(mettler_r50()),
        "raptor60" => Some(raptor60()),
        _ => None,
    }
}

/// The shipped model with the name `name_or_file`, or [`raptor60_at`] `SPEED`, m/s, for `raptor60@SPEED`. For any other
/// name the model in the file of this name.
///
/// # Errors
/// As [`StateSpace::read`] and [`raptor60_at`].
pub fn open(name_or_file: &str) -> Result<StateSpace, ModelError> {
    if let Some(speed) = name_or_file.strip_prefix("raptor60@") {
        let no_number = |_| ModelError::Speed { found: format!("\"{speed}\"") };
        return raptor60_at(speed.parse().map_err(no_number)?);
    }
    by_name(name_or_file).map_or_else(|| StateSpace::read(Path::new(name_or_file)), Ok)
}

fn parsed(name: &str, text: &str) -> StateSpace {
    StateSpace::parse(text, Path::new(name)).expect("shipped models are read by the tests")
}
