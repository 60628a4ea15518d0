//! A small helicopter in six degrees of freedom.
//!
//! The model is a rigid body (Paw, 3.5–3.10) with a main rotor and a stabilizer bar. The tip-path plane of the main
//! rotor tilts with first-order lag (3.39–3.40); the bar has the form of Mettler. Hub forces and moments follow
//! 3.41–3.49; thrust, torque and inflow come from blade-element and momentum theory. A tail rotor with a rate gyro,
//! fuselage and fins complete the model. The rotor turns at its nominal speed unless [`Helicopter::driven`] sets
//! another; this module does not model the governor.
//!
//! The controls are [`Sticks`] about hover trim, limited to ±1. Signs follow the initial motion: lateral rolls right,
//! longitudinal raises the nose, collective climbs, pedal turns the nose right.
//!
//! Valid from hover to slow flight, about 15 m/s, and for sink rates at which the rotor still thrusts against its own
//! inflow. Beyond these limits the model stays finite and continuous but is not physical.
//!
//! ```
//! use hovernav::controls::Sticks;
//! use hovernav::frames::{Ned, Vector};
//! use hovernav_model::helicopter::{Helicopter, HelicopterParameters};
//!
//! let helicopter = Helicopter::new(HelicopterParameters::raptor60())?;
//! let calm = Vector::<Ned>::ZERO;
//! let mut state = *helicopter.hover();
//! for _ in 0..100 {
//!     state = helicopter.step(&state, &Sticks::NEUTRAL, calm, 0.01);
//! }
//! assert!(state.velocity_mps.norm() < 1e-6); // sticks at trim: it hovers
//! # Ok::<(), hovernav_model::helicopter::HelicopterError>(())
//! ```

use hovernav::glam::DQuat;

use hovernav::controls::Sticks;
use hovernav::frames::{Body, Ned, Rotation, Vector};

mod dynamics;
mod forces;
mod linearise;
mod parameters;
mod trim;

pub use parameters::{Fin, HelicopterParameters, Rotor, StabilizerBar};
pub use trim::Trim;

use dynamics::{Constants, Drive, Motion, Rigging};

/// State of the helicopter's motion, without its position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HelicopterState {
    /// Velocity of the centre of gravity over the ground (u, v, w), m/s.
    pub velocity_mps: Vector<Body>,
    /// Angular rate (p, q, r), rad/s.
    pub rate_radps: Vector<Body>,
    /// Attitude.
    pub body_to_ned: Rotation<Body, Ned>,
    /// Longitudinal flapping a, rad; positive tilts the disc back.
    pub longitudinal_flapping_rad: f64,
    /// Lateral flapping b, rad; positive tilts the disc to the right.
    pub lateral_flapping_rad: f64,
    /// Longitudinal tilt of the bar c, rad; positive back.
    pub longitudinal_bar_rad: f64,
    /// Lateral tilt of the bar d, rad; positive to the right.
    pub lateral_bar_rad: f64,
    /// Low-passed yaw rate of the tail's gyro rfb, rad/s; 0 for a gyro without low-pass.
    pub yaw_feedback_radps: f64,
}

/// Time derivative of the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateDerivative {
    /// Derivative of the components of velocity, m/s².
    pub velocity_mps2: Vector<Body>,
    /// Derivative of the angular rate, rad/s².
    pub rate_radps2: Vector<Body>,
    /// Derivative of the attitude quaternion, 1/s.
    pub body_to_ned_per_s: DQuat,
    /// Derivative of longitudinal flapping, rad/s.
    pub longitudinal_flapping_radps: f64,
    /// Derivative of lateral flapping, rad/s.
    pub lateral_flapping_radps: f64,
    /// Derivative of the longitudinal tilt of the bar, rad/s.
    pub longitudinal_bar_radps: f64,
    /// Derivative of the lateral tilt of the bar, rad/s.
    pub lateral_bar_radps: f64,
    /// Derivative of the gyro's low-passed yaw rate, rad/s².
    pub yaw_feedback_radps2: f64,
    /// Specific force at the centre of gravity, as an accelerometer there measures it, m/s².
    pub specific_force_mps2: Vector<Body>,
    /// Torque at the main shaft that keeps both rotors at constant speed, N·m; negative where the air drives them.
    pub rotor_torque_nm: f64,
}

/// Drive of the rotors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorDrive {
    /// Speed of the main rotor divided by its nominal speed; the tail rotor is geared to it. Limited to at least 0.1: a
    /// slower rotor carries no weight.
    pub speed: f64,
    /// Whether an engine drives the rotors. If so, the reaction to its torque acts on the fuselage; otherwise the
    /// rotors turn freely.
    pub powered: bool,
}

impl RotorDrive {
    /// An engine at the nominal speed.
    pub const NOMINAL: Self = Self { speed: 1.0, powered: true };
}

/// Lowest rotor speed divided by the nominal speed. A slower rotor carries no weight, and the equations divide by the
/// speed.
const SLOWEST: f64 = 0.1;

/// Reasons for rejecting a helicopter or a trim.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HelicopterError {
    /// A parameter is out of its physical range.
    #[error("helicopter parameter {name}: found {value}, expected a finite number in its range")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Value found.
        value: f64,
    },
    /// No steady flight was found.
    #[error(
        "no trim at {north_mps} m/s north, {east_mps} m/s east, {down_mps} m/s down: \
         {residual} m/s² or rad/s² remain, expected none"
    )]
    NoTrim {
        /// North component of the requested velocity through the air, m/s.
        north_mps: f64,
        /// East component of the requested velocity through the air, m/s.
        east_mps: f64,
        /// Down component of the requested velocity through the air, m/s.
        down_mps: f64,
        /// Norm of the remaining derivatives, m/s² and rad/s².
        residual: f64,
    },
    /// The trim needs a control beyond its stop.
    #[error("trim needs {control} at {value}, expected it in -1 to 1")]
    ControlAtStop {
        /// The control.
        control: &'static str,
        /// Position that the trim requires; the stops are at −1 and 1.
        value: f64,
    },
}

/// A helicopter: its parameters and the rigging of its sticks. [`Helicopter::new`] rigs them so that all sticks at zero
/// are hover in calm air.
#[derive(Clone, Debug, PartialEq)]
pub struct Helicopter {
    parameters: HelicopterParameters,
    constants: Constants,
    rigging: Rigging,
    hover: HelicopterState,
    hover_sticks: Sticks,
    /// Pitch at which the tail blades are jammed, rad; `None` for a working tail.
    stuck_tail_rad: Option<f64>,
}

impl Helicopter {
    /// Parameters of the helicopter.
    #[must_use]
    pub fn parameters(&self) -> &HelicopterParameters {
        &self.parameters
    }

    /// Hover in calm air heading north, with the sticks at [`hover_sticks`](Self::hover_sticks).
    #[must_use]
    pub fn hover(&self) -> &HelicopterState {
        &self.hover
    }

    /// Stick positions in hover: all zero if the helicopter was rigged for these parameters. A helicopter with a
    /// position beyond ±1 cannot hover.
    #[must_use]
    pub const fn hover_sticks(&self) -> Sticks {
        self.hover_sticks
    }

    /// Pitch of the tail blades in `state` under `pedal`, rad: the sum of pedal and gyro, within its limits.
    #[must_use]
    pub fn tail_pitch_rad(&self, state: &HelicopterState, pedal: f64) -> f64 {
        self.tail_pitch(pedal.clamp(-1.0, 1.0), state.rate_radps.z())
    }

    /// The helicopter with tail blades jammed at `pitch_rad`: pedal and gyro have no effect.
    #[must_use]
    pub const fn with_stuck_tail(mut self, pitch_rad: f64) -> Self {
        self.stuck_tail_rad = Some(pitch_rad);
        self
    }

    /// Time derivative of `state` with `controls` in the wind `wind_mps`, with the rotors at their nominal speed. It
    /// does not allocate or panic. A NaN input gives a NaN output.
    #[must_use]
    pub fn derivative(
        &self,
        state: &HelicopterState,
        controls: &Sticks,
        wind_mps: Vector<Ned>,
    ) -> StateDerivative {
        self.driven(state, controls, wind_mps, RotorDrive::NOMINAL)
    }

    /// As [`derivative`](Self::derivative), with the rotors driven by `drive`.
    #[must_use]
    pub fn driven(
        &self,
        state: &HelicopterState,
        controls: &Sticks,
        wind_mps: Vector<Ned>,
        drive: RotorDrive,
    ) -> StateDerivative {
        let to_body = state.body_to_ned.inverse();
        let rate = state.rate_radps.components();
        let motion = Motion {
            velocity: state.velocity_mps.to_array(),
            wind: (to_body * wind_mps).to_array(),
            down: (to_body * Vector::new(0.0, 0.0, 1.0)).to_array(),
            rate: state.rate_radps.to_array(),
            flapping: [state.longitudinal_flapping_rad, state.lateral_flapping_rad],
            bar: [state.longitudinal_bar_rad, state.lateral_bar_rad],
            drive: Drive { speed: drive.speed.max(SLOWEST), powered: drive.powered },
        };
        let sticks = controls.to_array();
        let change = self.change(&motion, &sticks);
        let spin = DQuat::from_xyzw(rate.x, rate.y, rate.z, 0.0);
        StateDerivative {
            velocity_mps2: change.velocity.into(),
            rate_radps2: change.rate.into(),
            body_to_ned_per_s: state.body_to_ned.quaternion() * spin * 0.5,
            longitudinal_flapping_radps: change.flapping[0],
            lateral_flapping_radps: change.flapping[1],
            longitudinal_bar_radps: change.bar[0],
            lateral_bar_radps: change.bar[1],
            yaw_feedback_radps2: 0.0,
            specific_force_mps2: change.specific_force.into(),
            rotor_torque_nm: change.torque_nm,
        }
    }

    /// `state` after `interval_s` with constant controls and wind: a classical Runge-Kutta step.
    ///
    /// The fastest mode of the shipped helicopter is near 30 rad/s. Up to 0.02 s the step is stable, and its error is
    /// far below that of the model.
    ///
    /// # Source
    /// Equation (V11) of docs/equations.md.
    #[must_use]
    pub fn step(
        &self,
        state: &HelicopterState,
        controls: &Sticks,
        wind_mps: Vector<Ned>,
        interval_s: f64,
    ) -> HelicopterState {
        state.integrated(interval_s, |state| self.derivative(state, controls, wind_mps))
    }
}

impl HelicopterState {
    /// State at rest and level, heading north, without flapping.
    pub const LEVEL: Self = Self {
        velocity_mps: Vector::ZERO,
        rate_radps: Vector::ZERO,
        body_to_ned: Rotation::IDENTITY,
        longitudinal_flapping_rad: 0.0,
        lateral_flapping_rad: 0.0,
        longitudinal_bar_rad: 0.0,
        lateral_bar_rad: 0.0,
        yaw_feedback_radps: 0.0,
    };

    /// This state integrated over `interval_s` by one classical fourth-order Runge-Kutta step. `derivative` returns the
    /// derivative of a state. The quaternion is normalised at the end.
    #[must_use]
    pub fn integrated(
        &self,
        interval_s: f64,
        derivative: impl Fn(&Self) -> StateDerivative,
    ) -> Self {
        let half_s = 0.5 * interval_s;
        let first = derivative(self);
        let second = derivative(&self.moved(&first, half_s));
        let third = derivative(&self.moved(&second, half_s));
        let fourth = derivative(&self.moved(&third, interval_s));
        let sixth_s = interval_s / 6.0;
        let mut end = self
            .moved(&first, sixth_s)
            .moved(&second, 2.0 * sixth_s)
            .moved(&third, 2.0 * sixth_s)
            .moved(&fourth, sixth_s);
        end.body_to_ned = Rotation::claim(end.body_to_ned.quaternion().normalize());
        end
    }

    /// This state plus `change` times `interval_s`, without normalisation of the quaternion.
    fn moved(&self, change: &StateDerivative, interval_s: f64) -> Self {
        Self {
            velocity_mps: self.velocity_mps + change.velocity_mps2 * interval_s,
            rate_radps: self.rate_radps + change.rate_radps2 * interval_s,
            body_to_ned: Rotation::claim(
                self.body_to_ned.quaternion() + change.body_to_ned_per_s * interval_s,
            ),
            longitudinal_flapping_rad: self.longitudinal_flapping_rad
                + change.longitudinal_flapping_radps * interval_s,
            lateral_flapping_rad: self.lateral_flapping_rad
                + change.lateral_flapping_radps * interval_s,
            longitudinal_bar_rad: self.longitudinal_bar_rad
                + change.longitudinal_bar_radps * interval_s,
            lateral_bar_rad: self.lateral_bar_rad + change.lateral_bar_radps * interval_s,
            yaw_feedback_radps: self.yaw_feedback_radps + change.yaw_feedback_radps2 * interval_s,
        }
    }

    /// Velocity over the ground in north, east, down, m/s.
    #[must_use]
    pub fn velocity_ned_mps(&self) -> Vector<Ned> {
        self.body_to_ned * self.velocity_mps
    }
}
