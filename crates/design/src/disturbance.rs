//! Disturbances of a hover, and the responses to them.

use nalgebra::{DMatrix, DVector};

use super::error::DesignError;

/// States that a disturbance changes, in the order of [`DisturbanceResponse::states`]: rates, rad/s, attitude, rad,
/// velocity, m/s, as in the hover models.
pub const DISTURBED: [&str; 9] = ["p", "q", "r", "phi", "theta", "psi", "u", "v", "w"];

/// The nine disturbances, each alone: state and size in its SI unit.
///
/// # Source
/// Paw (2005), table 6.1.
pub const TABLE_6_1: [(&str, f64); 9] = [
    ("phi", 0.5),
    ("theta", 0.5),
    ("psi", 0.3),
    ("p", 1.0),
    ("q", 1.0),
    ("r", 1.0),
    ("u", 2.0),
    ("v", 2.0),
    ("w", 2.0),
];

/// Largest deviations that count as trim, in the order of [`DISTURBED`]: a twentieth of the state's disturbance in
/// [`TABLE_6_1`].
pub const SETTLED: [f64; 9] = [0.05, 0.05, 0.05, 0.025, 0.025, 0.015, 0.1, 0.1, 0.1];

/// Response to one disturbance.
#[derive(Clone, Debug, PartialEq)]
pub struct DisturbanceResponse {
    /// The disturbed state.
    pub state: String,
    /// Size of the disturbance, in the state's SI unit.
    pub size: f64,
    /// Time since the disturbance, s.
    pub time_s: Vec<f64>,
    /// Deviations from trim at the times `time_s`, in the order of [`DISTURBED`].
    pub states: Vec<[f64; 9]>,
    /// Lateral, longitudinal, collective, pedal about trim; full travel is −1…1. Without limits unless the function
    /// that computed the response documents them.
    pub sticks: Vec<[f64; 4]>,
}

impl DisturbanceResponse {
    /// Time of the last sample with a state outside [`SETTLED`] about trim, s; 0 without one, `None` if a state does not
    /// settle by the end.
    #[must_use]
    pub fn settled_s(&self) -> Option<f64> {
        let is_away = |states: &[f64; 9]| {
            states.iter().zip(SETTLED).any(|(&value, band)| is_beyond(value, band))
        };
        match self.states.iter().rposition(is_away) {
            None => Some(0.0),
            Some(last) if last + 1 < self.states.len() => Some(self.time_s[last]),
            Some(_) => None,
        }
    }

    /// Time from which the disturbed state stays below the fraction `share` of its disturbance, s; `None` if it does
    /// not settle by the end.
    #[must_use]
    pub fn recovered_s(&self, share: f64) -> Option<f64> {
        let row = DISTURBED.iter().position(|name| *name == self.state)?;
        let band = share * self.size.abs();
        match self.states.iter().rposition(|states| is_beyond(states[row], band)) {
            None => Some(0.0),
            Some(last) => self.time_s.get(last + 1).copied(),
        }
    }

    /// Largest deviation of the disturbed state from `time_s` on, in its SI unit; infinite for NaN.
    #[must_use]
    pub fn largest_from(&self, time_s: f64) -> f64 {
        let Some(row) = DISTURBED.iter().position(|name| *name == self.state) else { return 0.0 };
        let later = self.time_s.iter().zip(&self.states).filter(|(time, _)| **time >= time_s);
        largest_of(later.map(|(_, states)| states[row]))
    }

    /// Largest deviation of each state, in the order of [`DISTURBED`].
    #[must_use]
    pub fn peaks(&self) -> [f64; 9] {
        largest(&self.states)
    }

    /// Largest deviation of each stick.
    #[must_use]
    pub fn stick_peaks(&self) -> [f64; 4] {
        largest(&self.sticks)
    }
}

/// Whether `value` is outside ±`band`. A NaN counts as outside.
fn is_beyond(value: f64, band: f64) -> bool {
    value.is_nan() || value.abs() > band
}

/// Largest magnitude of each column; infinite for NaN.
fn largest<const N: usize>(rows: &[[f64; N]]) -> [f64; N] {
    core::array::from_fn(|column| largest_of(rows.iter().map(|row| row[column])))
}

/// Largest magnitude of `values`; infinite for NaN.
fn largest_of(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(
        0.0,
        |largest, value| {
            if value.is_nan() { f64::INFINITY } else { f64::max(largest, value.abs()) }
        },
    )
}

/// Index of the disturbed state in [`DISTURBED`], and a response with its times but no samples yet.
pub(super) fn followed(
    (state, size): (&str, f64),
    duration_s: f64,
    interval_s: f64,
) -> Result<(usize, DisturbanceResponse), DesignError> {
    let unknown = || {
        let (name, expected) = ("disturbance", "one of p, q, r, phi, theta, psi, u, v, w");
        DesignError::Range { name, value: size, expected }
    };
    let row = DISTURBED.iter().position(|name| *name == state).ok_or_else(unknown)?;
    let rows = duration_s / interval_s;
    if !(0.0..1e6).contains(&rows) {
        let expected = "at most a million intervals";
        return Err(DesignError::Range { name: "duration_s", value: duration_s, expected });
    }
    let rows = (rows + 1e-9) as usize + 1;
    let response = DisturbanceResponse {
        state: state.into(),
        size,
        time_s: (0..rows).map(|k| k as f64 * interval_s).collect(),
        states: Vec::with_capacity(rows),
        sticks: Vec::with_capacity(rows),
    };
    Ok((row, response))
}

/// A linear system without external inputs, and its outputs.
pub(super) struct FreeResponse<'a> {
    /// Transition matrix over `interval_s`.
    pub step: &'a DMatrix<f64>,
    pub interval_s: f64,
    /// Index in this system of each state of [`DISTURBED`].
    pub states: [usize; 9],
    /// Sticks, −1…1, as a function of the state, 4×n.
    pub sticks: &'a DMatrix<f64>,
}

impl FreeResponse<'_> {
    /// Response to an initial value `size` of `state`, with all other states at trim.
    pub fn respond(
        &self,
        state: &str,
        size: f64,
        duration_s: f64,
    ) -> Result<DisturbanceResponse, DesignError> {
        let (row, mut response) = followed((state, size), duration_s, self.interval_s)?;
        let mut x = DVector::zeros(self.step.nrows());
        x[self.states[row]] = size;
        for _ in 0..response.time_s.len() {
            response.states.push(self.states.map(|index| x[index]));
            let sticks = self.sticks * &x;
            response.sticks.push([0, 1, 2, 3].map(|stick| sticks[stick]));
            x = self.step * x;
        }
        Ok(response)
    }
}
