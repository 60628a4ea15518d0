//! A linear hover model as an airframe: linear forces, full rigid-body kinematics and gravity.

use hovernav::controls::Sticks;
use hovernav::earth::STANDARD_GRAVITY_MPS2;
use hovernav::frames::{Ned, Vector};
use hovernav::glam::DQuat;

use super::helicopter::{HelicopterState, StateDerivative};
use super::hover::unit_of;
use super::{ModelError, StateSpace};

/// States whose derivatives come from the linear model, one row each, in this order. The derivative of the attitude is
/// kinematic.
const ROWS: [&str; 11] = ["u", "v", "w", "p", "q", "r", "a", "b", "c", "d", "rfb"];
/// Number of velocity and rate states at the start of [`ROWS`]; every model must have them.
const RIGID: usize = 6;
/// Number of columns of the slopes: the states of [`ROWS`], roll and pitch, then the sticks.
const COLUMNS: usize = ROWS.len() + 2 + Sticks::NAMES.len();
/// Column of the roll angle.
const PHI: usize = ROWS.len();
/// Column of the pitch angle.
const THETA: usize = PHI + 1;
/// Column of the first stick.
const FIRST_STICK: usize = THETA + 1;
/// Largest difference between the gravity of a model and standard gravity, m/s² per rad of tilt.
const GRAVITY_MPS2: f64 = 0.5;

/// Reasons why a linear model cannot be used as an airframe.
#[derive(Debug, thiserror::Error)]
pub enum AirframeError {
    /// A state or stick is missing, or the model is discrete.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A state that a hover model does not have.
    #[error("state {state}: found a state without a meaning in flight, expected one of {}", ROWS.join(", "))]
    State {
        /// The state.
        state: String,
    },
    /// A unit other than the airframe's.
    #[error("{signal}: found the unit \"{found}\", expected \"{expected}\"")]
    Unit {
        /// State or stick.
        signal: String,
        /// Unit in the model.
        found: String,
        /// Unit of the airframe.
        expected: &'static str,
    },
    /// A gravity term of the model differs from that of a hover.
    #[error(
        "A, row {row}, column {column}: found {found} m/s² per rad, expected gravity, {expected}"
    )]
    Gravity {
        /// State of the row.
        row: &'static str,
        /// State of the column.
        column: &'static str,
        /// Value of the entry.
        found: f64,
        /// Gravity with the sign of the entry, m/s².
        expected: f64,
    },
    /// A model of forward flight. Its derivatives are about the velocity of its trim, not about hover. The model also
    /// contains the kinematics of that trim.
    #[error("found a model of forward flight at {speed_mps} m/s, expected a model of hover")]
    Forward {
        /// Forward speed of the trim, m/s.
        speed_mps: f64,
    },
    /// The forces depend on the heading.
    #[error(
        "A, row {row}, column psi: found {found}, expected 0: no aerodynamic force depends on the heading"
    )]
    Heading {
        /// State of the row.
        row: String,
        /// Value of the entry.
        found: f64,
    },
}

/// An airframe whose forces, moments and rotor follow a linear hover model.
///
/// The forces of the model act on a rigid body with the full kinematics: gravity turns with the attitude, and a rate
/// turns the velocity. The columns of u, v and w are multiplied by the velocity relative to the air. Valid near a
/// hover: up to a few m/s of airspeed and a few tens of degrees of tilt. Beyond these limits the forces stay linear.
///
/// # Source
/// Equation (V20) of docs/equations.md.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearAirframe {
    /// Derivatives of the rate of change of each of [`ROWS`] with respect to each column, without gravity.
    slopes: [[f64; COLUMNS]; ROWS.len()],
}

impl LinearAirframe {
    /// The airframe of `model`. The model must be continuous and have the states u, v, w, p, q, r and the four sticks.
    /// phi, theta, psi, a, b, c, d and rfb are optional.
    ///
    /// # Errors
    /// [`AirframeError`].
    pub fn new(model: &StateSpace) -> Result<Self, AirframeError> {
        model.require_continuous()?;
        let speed_mps = model.trim_speed_mps();
        if speed_mps != 0.0 {
            return Err(AirframeError::Forward { speed_mps });
        }
        for name in &ROWS[..RIGID] {
            model.state(name)?;
        }
        for state in model.states() {
            let expected = unit_of(&state.name);
            if expected.is_empty() {
                return Err(AirframeError::State { state: state.name.clone() });
            }
            if expected != state.unit {
                let (signal, found) = (state.name.clone(), state.unit.clone());
                return Err(AirframeError::Unit { signal, found, expected });
            }
        }
        let mut slopes = [[0.0; COLUMNS]; ROWS.len()];
        for (row, name) in slopes.iter_mut().zip(ROWS) {
            let Ok(state) = model.state(name) else { continue };
            let of_state =
                |column: &str| model.state(column).map_or(0.0, |at| model.a()[(state, at)]);
            for (slope, column) in row.iter_mut().zip(ROWS.into_iter().chain(["phi", "theta"])) {
                *slope = of_state(column);
            }
            for (slope, stick) in row[FIRST_STICK..].iter_mut().zip(Sticks::NAMES) {
                *slope = model.b()[(state, model.input(stick)?)] * full_travel(model, stick)?;
            }
            let by_heading = of_state("psi");
            if by_heading != 0.0 {
                return Err(AirframeError::Heading { row: name.into(), found: by_heading });
            }
        }
        for (row, column, name, sign) in
            [(0, THETA, ("u", "theta"), -1.0), (1, PHI, ("v", "phi"), 1.0)]
        {
            let expected = sign * STANDARD_GRAVITY_MPS2;
            let found = slopes[row][column];
            if (found - expected).abs() > GRAVITY_MPS2 {
                return Err(AirframeError::Gravity {
                    row: name.0,
                    column: name.1,
                    found,
                    expected,
                });
            }
            slopes[row][column] = 0.0;
        }
        Ok(Self { slopes })
    }

    /// Time derivative of `state` with the sticks at `sticks`, −1…1 about trim, in the wind `wind_mps`. It does not
    /// allocate or panic. A NaN input gives a NaN output.
    #[must_use]
    pub fn derivative(
        &self,
        state: &HelicopterState,
        sticks: &Sticks,
        wind_mps: Vector<Ned>,
    ) -> StateDerivative {
        let to_body = state.body_to_ned.inverse();
        let [u, v, w] = (state.velocity_mps - to_body * wind_mps).to_array();
        let [p, q, r] = state.rate_radps.to_array();
        let (a, b) = (state.longitudinal_flapping_rad, state.lateral_flapping_rad);
        let (c, d) = (state.longitudinal_bar_rad, state.lateral_bar_rad);
        let angles = state.body_to_ned.euler();
        let [lateral, longitudinal, collective, pedal] = sticks.to_array();
        let columns: [f64; COLUMNS] = [
            u,
            v,
            w,
            p,
            q,
            r,
            a,
            b,
            c,
            d,
            state.yaw_feedback_radps,
            angles.roll_rad,
            angles.pitch_rad,
            lateral,
            longitudinal,
            collective,
            pedal,
        ];
        let change = self
            .slopes
            .map(|row| row.iter().zip(columns).map(|(slope, value)| slope * value).sum::<f64>());
        let [fx, fy, fz, mx, my, mz, da, db, dc, dd, drfb] = change;
        let specific_force_mps2 = Vector::new(fx, fy, fz - STANDARD_GRAVITY_MPS2);
        let gravity = to_body * Vector::new(0.0, 0.0, STANDARD_GRAVITY_MPS2);
        let spin = DQuat::from_xyzw(p, q, r, 0.0);
        StateDerivative {
            velocity_mps2: specific_force_mps2 + gravity
                - state.rate_radps.cross(state.velocity_mps),
            rate_radps2: Vector::new(mx, my, mz),
            body_to_ned_per_s: state.body_to_ned.quaternion() * spin * 0.5,
            longitudinal_flapping_radps: da,
            lateral_flapping_radps: db,
            longitudinal_bar_radps: dc,
            lateral_bar_radps: dd,
            yaw_feedback_radps2: drfb,
            specific_force_mps2,
            rotor_torque_nm: 0.0,
        }
    }
}

/// Value of `stick` at full travel to one side, in the unit of `model`.
fn full_travel(model: &StateSpace, stick: &str) -> Result<f64, AirframeError> {
    match model.inputs()[model.input(stick)?].unit.as_str() {
        "stick" => Ok(1.0),
        "percent" | "%" => Ok(100.0),
        found => {
            let (signal, found) = (stick.to_owned(), found.to_owned());
            Err(AirframeError::Unit { signal, found, expected: "stick" })
        }
    }
}
