//! The linear model about a steady flight.

use nalgebra::DMatrix;

use super::dynamics::{Change, Drive, Motion};
use super::trim::{body_axes, in_body};
use super::{Helicopter, Trim};
use crate::hover::unit_of;
use crate::real::{Dual, Real};
use crate::{Signal, StateSpace, TimeDomain};
use hovernav::controls::Sticks;
use hovernav::frames::{EulerAngles, Ned, Vector};

/// Names of the states of the linear model.
const STATES: [&str; 13] =
    ["u", "v", "w", "p", "q", "r", "phi", "theta", "psi", "a", "b", "c", "d"];
/// Names of the inputs of the linear model.
const STICKS: [&str; 4] = Sticks::NAMES;

impl Helicopter {
    /// The continuous linear model about `trim` in a steady wind. Its 13 states are u, v, w, p, q, r, phi, theta, psi,
    /// a, b, c, d. Its inputs are lateral, longitudinal, collective, pedal in stick −1…1. States and inputs are
    /// deviations from the trim.
    ///
    /// The derivatives of the equations come from forward-mode differentiation and are exact to rounding. Valid at a
    /// pitch other than ±90°, as in every trim.
    #[must_use]
    pub fn linearise(&self, trim: &Trim, wind_mps: Vector<Ned>) -> StateSpace {
        let state = &trim.state;
        let EulerAngles { roll_rad, pitch_rad, yaw_rad } = state.body_to_ned.euler();
        let [u, v, w] = state.velocity_mps.to_array();
        let [p, q, r] = state.rate_radps.to_array();
        let controls = &trim.controls;
        let about = [
            u,
            v,
            w,
            p,
            q,
            r,
            roll_rad,
            pitch_rad,
            yaw_rad,
            state.longitudinal_flapping_rad,
            state.lateral_flapping_rad,
            state.longitudinal_bar_rad,
            state.lateral_bar_rad,
            controls.lateral,
            controls.longitudinal,
            controls.collective,
            controls.pedal,
        ];
        let mut a = DMatrix::zeros(13, 13);
        let mut b = DMatrix::zeros(13, 4);
        for direction in 0..about.len() {
            let mut point = about.map(Dual::constant);
            point[direction].slope = 1.0;
            let along = self.euler_derivative(&point, wind_mps);
            for (row, derivative) in along.iter().enumerate() {
                if direction < 13 {
                    a[(row, direction)] = derivative.slope;
                } else {
                    b[(row, direction - 13)] = derivative.slope;
                }
            }
        }
        let states = STATES.map(|name| Signal::new(name, unit_of(name))).to_vec();
        let inputs = STICKS.map(|name| Signal::new(name, "stick")).to_vec();
        StateSpace::new("helicopter", TimeDomain::Continuous, states, inputs, a, b)
            .expect("the trim of a valid helicopter has finite derivatives")
            .with_source("linearised from the nonlinear helicopter")
    }

    /// Derivatives of the 13 states, given the states and then the sticks.
    ///
    /// # Source
    /// Equation (V12) of docs/equations.md.
    fn euler_derivative<T: Real>(&self, point: &[T; 17], wind_mps: Vector<Ned>) -> [T; 13] {
        let [
            u,
            v,
            w,
            p,
            q,
            r,
            roll,
            pitch,
            yaw,
            a,
            b,
            c,
            d,
            lateral,
            longitudinal,
            collective,
            pedal,
        ] = *point;
        let axes = body_axes([roll, pitch, yaw]);
        let motion = Motion {
            velocity: [u, v, w],
            wind: in_body(&axes, wind_mps),
            down: axes.map(|axis| axis[2]),
            rate: [p, q, r],
            flapping: [a, b],
            bar: [c, d],
            drive: Drive::nominal(),
        };
        let Change { velocity, rate, flapping, bar, .. } =
            self.unstopped(&motion, &[lateral, longitudinal, collective, pedal]);
        let (sin_roll, cos_roll) = roll.sin_cos();
        let (sin_pitch, cos_pitch) = pitch.sin_cos();
        let heading_rate = (q * sin_roll + r * cos_roll) / cos_pitch;
        let [du, dv, dw] = velocity;
        let [dp, dq, dr] = rate;
        [
            du,
            dv,
            dw,
            dp,
            dq,
            dr,
            p + heading_rate * sin_pitch,
            q * cos_roll - r * sin_roll,
            heading_rate,
            flapping[0],
            flapping[1],
            bar[0],
            bar[1],
        ]
    }
}
