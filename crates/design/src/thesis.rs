//! The design printed by Paw (2005): continuous gains for a continuous model.
//!
//! The design serves reproduction and comparison only, not flight. With sticks held between samples at 33 Hz it is
//! violently unstable, see [`PrintedDesign::spectral_radii`]. [`HoverDesign`](super::hover::HoverDesign) designs at the
//! sample rate of the loop.
//!
//! ```
//! use hovernav_design::thesis::PrintedDesign;
//!
//! let design = PrintedDesign::new()?;
//! let gain = &design.roll_pitch.gain;
//! assert_eq!((gain[(0, 0)] * 1e3).round() / 1e3, -38.312);
//! let [roll_pitch, heave] = design.spectral_radii(1.0 / 33.0)?;
//! assert!(roll_pitch > 7.0 && heave > 24.0);
//! # Ok::<(), hovernav_design::DesignError>(())
//! ```

use nalgebra::{Complex, DMatrix, DVector, dmatrix};

use super::disturbance::{DisturbanceResponse, FreeResponse};
use super::{DesignError, Reachability, Regulator};
use super::{lqr, observability, reachability, zero_order_hold};
use hovernav_model::linalg::{eigenvalues, exponential};
use hovernav_model::{StateSpace, hover, shipped};

/// The gains of Paw (2005), chapter 6, on his model.
#[derive(Clone, Debug, PartialEq)]
pub struct PrintedDesign {
    /// Roll and pitch: Q = diag(1, 1, 1, 1, 2, 1), and R = diag(0.01, 0.001). R is not printed, but reproduces every
    /// printed digit of K.
    pub roll_pitch: Regulator,
    /// Yaw with heading: Q = diag(1, 100), R = I.
    pub yaw: Regulator,
    /// Heave, w from collective.
    pub heave: StateSpace,
    /// Proportional, integral and derivative gain on w: (55.1 s² + 661.2 s + 1983.6)/s.
    pub heave_gains: [f64; 3],
    model: StateSpace,
}

/// Index in the closed loop of each state of [`DISTURBED`](super::DISTURBED).
const PLACES: [usize; 9] = [0, 1, 7, 2, 3, 8, 4, 5, 6];
/// Number of states of the closed loop: p, q, phi, theta, u, v, w, r, psi, and the integral of w.
const SIZE: usize = 10;
/// Index of w in the closed loop.
const W: usize = 6;
/// Index of r in the closed loop.
const R: usize = 7;
/// Index of psi in the closed loop.
const PSI: usize = 8;
/// Index of the integral of w in the closed loop.
const W_INTEGRAL: usize = 9;
/// Full stick in the unit of the thesis's inputs, percent.
const FULL_STICK: f64 = 100.0;

impl PrintedDesign {
    /// The design, with its two Riccati equations solved.
    ///
    /// # Errors
    /// [`DesignError`]; the shipped model causes none.
    pub fn new() -> Result<Self, DesignError> {
        let model = shipped::thesis();
        let diagonal = |values: &[f64]| DMatrix::from_diagonal(&DVector::from_row_slice(values));
        Ok(Self {
            roll_pitch: lqr(
                &hover::roll_pitch(&model)?,
                &diagonal(&[1.0, 1.0, 1.0, 1.0, 2.0, 1.0]),
                &diagonal(&[0.01, 0.001]),
            )?,
            yaw: lqr(&hover::yaw(&model)?, &diagonal(&[1.0, 100.0]), &diagonal(&[1.0, 1.0]))?,
            heave: hover::heave(&model)?,
            heave_gains: [661.2, 1983.6, 55.1],
            model,
        })
    }

    /// Reachability and observability of the states: roll and pitch, then yaw.
    ///
    /// # Errors
    /// As [`reachability`].
    pub fn reach(&self) -> Result<[(Reachability, Reachability); 2], DesignError> {
        let both = |model: &StateSpace| -> Result<_, DesignError> {
            Ok((reachability(model, 1.0)?, observability(model, 1.0)?))
        };
        Ok([both(&self.roll_pitch.model)?, both(&self.yaw.model)?])
    }

    /// Derivatives Zw, 1/s, and Zcol of the heave model.
    fn heave_terms(&self) -> [f64; 2] {
        [self.heave.a()[(0, 0)], self.heave.b()[(0, 0)]]
    }

    /// The poles of the closed heave loop, 1/s. The derivative of w depends on the collective that it determines; the
    /// equation is solved for the collective.
    ///
    /// # Errors
    /// [`DesignError::Model`] where the eigenvalue computation does not converge.
    pub fn heave_poles(&self) -> Result<Vec<Complex<f64>>, DesignError> {
        let ([zw, zcol], [kp, ki, kd]) = (self.heave_terms(), self.heave_gains);
        let around = 1.0 + kd * zcol;
        let closed = dmatrix![(zw - zcol * kp) / around, -zcol * ki / around; 1.0, 0.0];
        Ok(eigenvalues(&closed)?)
    }

    /// Spectral radius of the roll-and-pitch loop and of the heave loop with these gains, with sticks held for
    /// `period_s`; unstable above 1. The derivative gain of heave acts on the derivative of w just before each sample,
    /// which the previous stick determines.
    ///
    /// # Errors
    /// [`DesignError::Range`] for a period that is not above zero.
    pub fn spectral_radii(&self, period_s: f64) -> Result<[f64; 2], DesignError> {
        let radius = |closed: &DMatrix<f64>| -> Result<f64, DesignError> {
            Ok(eigenvalues(closed)?.iter().map(|value| value.norm()).fold(0.0, f64::max))
        };
        let held = zero_order_hold(&self.roll_pitch.model, period_s, 0.0)?;
        let roll_pitch = radius(&(held.a() - held.b() * &self.roll_pitch.gain))?;

        let ([zw, zcol], [kp, ki, kd]) = (self.heave_terms(), self.heave_gains);
        let generator = dmatrix![zw, 0.0, zcol; 1.0, 0.0, 0.0; 0.0, 0.0, 0.0];
        let mut step = exponential(&generator, period_s);
        // The third state is the held stick, which the gains compute at each sample.
        let command = -dmatrix![kp + kd * zw, ki, kd * zcol];
        let onto = step.column(2) * &command;
        step.column_mut(2).fill(0.0);
        let mut closed = step;
        closed.rows_mut(0, 2).zip_apply(&onto.rows(0, 2), |value, onto| *value += onto);
        closed.row_mut(2).copy_from(&command);
        Ok([roll_pitch, radius(&closed)?])
    }

    /// Sticks in percent from the closed loop's state, 4×10.
    fn sticks(&self) -> DMatrix<f64> {
        let ([zw, zcol], [kp, ki, kd]) = (self.heave_terms(), self.heave_gains);
        let mut sticks = DMatrix::zeros(4, SIZE);
        sticks.view_mut((0, 0), (2, 6)).copy_from(&-&self.roll_pitch.gain);
        // Collective δ = −(Kp w + Ki ∫w + Kd (Zw w + Zcol δ)) + the collective command of the yaw gains.
        let around = 1.0 + kd * zcol;
        sticks[(2, W)] = -(kp + kd * zw) / around;
        sticks[(2, W_INTEGRAL)] = -ki / around;
        sticks[(2, R)] = -self.yaw.gain[(0, 0)] / around;
        sticks[(2, PSI)] = -self.yaw.gain[(0, 1)] / around;
        sticks[(3, R)] = -self.yaw.gain[(1, 0)];
        sticks[(3, PSI)] = -self.yaw.gain[(1, 1)];
        sticks
    }

    /// A of the whole closed loop, with states p, q, phi, theta, u, v, w, r, psi and the integral of w.
    fn generator(&self, sticks: &DMatrix<f64>) -> DMatrix<f64> {
        let mut a = DMatrix::zeros(SIZE, SIZE);
        a.view_mut((0, 0), (8, 8)).copy_from(self.model.a());
        a[(PSI, R)] = 1.0;
        a[(W_INTEGRAL, W)] = 1.0;
        let moved = self.model.b() * sticks;
        let mut vehicle = a.rows_mut(0, 8);
        vehicle += moved;
        a
    }

    /// Response to `size` in `state` in continuous time, exact at every `interval_s`.
    ///
    /// # Errors
    /// [`DesignError::Range`] for a state that is not in [`DISTURBED`](super::DISTURBED), or an invalid time.
    pub fn respond(
        &self,
        state: &str,
        size: f64,
        duration_s: f64,
        interval_s: f64,
    ) -> Result<DisturbanceResponse, DesignError> {
        let sticks = self.sticks();
        let step = exponential(&self.generator(&sticks), interval_s);
        let sticks = sticks / FULL_STICK;
        let response = FreeResponse { step: &step, interval_s, states: PLACES, sticks: &sticks };
        response.respond(state, size, duration_s)
    }
}
