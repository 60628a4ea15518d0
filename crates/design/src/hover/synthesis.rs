//! Gains for a model, and the resulting closed loops.

use super::closed_loop::{self, Cut, FlightMode, Parts};
use super::config::{HeavePoles, HoverDesign};
use super::forward::require_hover;
use super::gusts::{self, GustResponse, Gusts};
use super::limited;
use super::plant::{normalised, other_states, rotor_states};
use super::regulator::{self, Weights};
use crate::{DesignError, DisturbanceResponse, Loop, Margins};
use hovernav::autopilot::{Gains, PidGains, RegulatorGains, StickLimits};
use hovernav_model::StateSpace;

/// Largest integration time, s, from which the tracking time of a slow heading integral is computed.
const SLOWEST_TRACKING_S: f64 = 1e3;
/// Ratio of integration time to tracking time above which an integral is slow.
const SLOW_INTEGRAL: f64 = 10.0;

impl HoverDesign {
    /// The gains for `model`, which is continuous. Its states are p, q, phi, theta, u, v, w, r and its inputs lateral,
    /// longitudinal, collective, pedal, in any order. Optional states are a, b, c, d (flapping and bar) and one of the
    /// yaw gyro.
    ///
    /// # Errors
    /// [`DesignError`], and [`DesignError::At`] for a model of forward flight.
    ///
    /// # Source
    /// The tracking time of a slow yaw integral is half its integration time: Åström and Hägglund, *Advanced PID
    /// Control* (2006), section 3.5, between the derivative and the integral time.
    pub fn synthesise(&self, model: &StateSpace) -> Result<Gains, DesignError> {
        self.check()?;
        require_hover(model)?;
        let whole = normalised(model)?;
        let rotor = rotor_states(&whole);
        let others = other_states(&whole);
        let velocity = ["p", "q", "phi", "theta", "u", "v"];
        let cyclic = ["lateral", "longitudinal"];

        let weights = &self.roll_pitch;
        let roll_pitch = self.regulator::<6, 6, 2>(
            &whole.subsystem(&[&velocity[..], &rotor].concat(), &cyclic)?,
            self.servo_s,
            &Weights {
                states: &weights.states,
                integrated: &[4, 5],
                integrals: &weights.integrals,
                sticks: &weights.sticks,
                decay_per_s: weights.decay_per_s,
            },
        )?;
        let weights = &self.attitude;
        let attitude = self.regulator::<4, 6, 2>(
            &whole.subsystem(&[&velocity[..4], &rotor].concat(), &cyclic)?,
            self.servo_s,
            &Weights {
                states: &weights.states,
                integrated: &[2, 3],
                integrals: &weights.integrals,
                sticks: &weights.sticks,
                decay_per_s: weights.decay_per_s,
            },
        )?;
        let weights = &self.yaw;
        let mut yaw = self.regulator::<2, 2, 1>(
            &whole.subsystem(&[&["r", "psi"], &others[..]].concat(), &["pedal"])?,
            self.tail_servo_s,
            &Weights {
                states: &weights.states,
                integrated: &[1],
                integrals: &[weights.integral],
                sticks: &[weights.stick],
                decay_per_s: weights.decay_per_s,
            },
        )?;
        // During a short saturation of the pedal, fast tracking would move a slow integral, which recovers only as
        // slowly as it integrates. A slow integral is therefore tracked slowly. A fast integral must be tracked fast to
        // avoid windup.
        let [[_, stiffness], [_, integral_per_s]] = [yaw.measured[0], yaw.integral_per_s[0]];
        let integral_s = (stiffness / integral_per_s).abs().min(SLOWEST_TRACKING_S);
        if integral_s > SLOW_INTEGRAL * self.tracking_s {
            yaw.tracking_time_s = 0.5 * integral_s;
        }
        let heave = whole.subsystem(&["w"], &["collective"])?;
        let turn = whole.subsystem(&["r"], &["collective", "pedal"])?;
        Ok(Gains {
            heave: self.heave_gains(heave.a()[(0, 0)], heave.b()[(0, 0)])?,
            yaw,
            pedal_per_collective: -turn.b()[(0, 0)] / turn.b()[(0, 1)],
            roll_pitch,
            attitude,
        })
    }

    /// The loops closed around `model` by `gains`, as by the autopilot when it holds velocity and heading. The four
    /// loops control model, servos and delay. They are broken at the commands to the actuators: lateral, longitudinal,
    /// collective, pedal.
    ///
    /// # Errors
    /// [`DesignError`].
    pub fn close(&self, model: &StateSpace, gains: &Gains) -> Result<Loop, DesignError> {
        self.close_in(model, gains, FlightMode::Velocity, Cut::Actuators)
    }

    /// The loops closed in the flight mode `mode`, broken at `cut`.
    ///
    /// # Errors
    /// [`DesignError`].
    pub fn close_in(
        &self,
        model: &StateSpace,
        gains: &Gains,
        mode: FlightMode,
        cut: Cut,
    ) -> Result<Loop, DesignError> {
        self.check()?;
        let Parts { plant, controller } =
            closed_loop::parts(self, &normalised(model)?, gains, mode)?;
        match cut {
            Cut::Actuators => Loop::at_plant_input(&plant, &controller),
            Cut::Outputs => Loop::at_plant_output(&plant, &controller),
        }
    }

    /// Margins in each flight mode, with the loops broken at the actuators; `None` where the mode is unstable.
    ///
    /// # Errors
    /// [`DesignError`].
    pub fn margins_in_modes(
        &self,
        model: &StateSpace,
        gains: &Gains,
    ) -> Result<Vec<(FlightMode, Option<Margins>)>, DesignError> {
        let in_mode = |mode| -> Result<_, DesignError> {
            Ok((mode, self.close_in(model, gains, mode, Cut::Actuators)?.margins().ok()))
        };
        FlightMode::ALL.into_iter().map(in_mode).collect()
    }

    /// Closed-loop response to `disturbance`, a state of [`DISTURBED`](crate::DISTURBED) and its size in SI units, in
    /// the loops of [`close`](Self::close). It is computed at every sample, without the limits of the servos.
    ///
    /// # Errors
    /// [`DesignError`].
    pub fn respond(
        &self,
        model: &StateSpace,
        gains: &Gains,
        disturbance: (&str, f64),
        duration_s: f64,
    ) -> Result<DisturbanceResponse, DesignError> {
        self.check()?;
        closed_loop::respond(self, &normalised(model)?, gains, disturbance, duration_s)
    }

    /// As [`respond`](Self::respond), with the stick `limits` on travel and rate. As in the autopilot, integrals track
    /// the limited commands. Trim is in the middle of the travel.
    ///
    /// # Errors
    /// [`DesignError`].
    pub fn respond_within(
        &self,
        model: &StateSpace,
        gains: &Gains,
        disturbance: (&str, f64),
        duration_s: f64,
        limits: &StickLimits,
    ) -> Result<DisturbanceResponse, DesignError> {
        self.check()?;
        limited::respond(self, &normalised(model)?, gains, disturbance, duration_s, limits)
    }

    /// Standard deviations of velocities, attitude, rates and sticks in stationary `gusts`, with the loops closed as in
    /// `mode`.
    ///
    /// # Errors
    /// [`DesignError::UnstableLoop`] where the mode is unstable, [`DesignError::Range`] for invalid gusts, and other
    /// [`DesignError`]s.
    pub fn in_gusts(
        &self,
        model: &StateSpace,
        gains: &Gains,
        mode: FlightMode,
        gusts: &Gusts,
    ) -> Result<GustResponse, DesignError> {
        self.check()?;
        gusts::respond(self, &normalised(model)?, gains, mode, gusts)
    }

    /// Response to `disturbance` with every stick at trim, in the form of [`respond`](Self::respond).
    ///
    /// # Errors
    /// [`DesignError`].
    pub fn drift(
        &self,
        model: &StateSpace,
        disturbance: (&str, f64),
        duration_s: f64,
    ) -> Result<DisturbanceResponse, DesignError> {
        self.check()?;
        closed_loop::drift(&normalised(model)?, self.period_s, disturbance, duration_s)
    }

    fn regulator<const Y: usize, const H: usize, const U: usize>(
        &self,
        part: &StateSpace,
        servo_s: f64,
        weights: &Weights<'_>,
    ) -> Result<RegulatorGains<Y, H, U>, DesignError> {
        let found = part.states().len() - Y + U;
        if found > H {
            return Err(DesignError::Shape {
                matrix: "the number of unmeasured states",
                rows: found - U,
                columns: 1,
                expected_rows: H - U,
                expected_columns: 1,
            });
        }
        regulator::regulate(part, servo_s, self.period_s, self.tracking_s, weights)
    }

    /// Gains of heave by pole placement on ẇ = Zw w + Zcol δ under PI: s² + (Zcol Kp − Zw) s + Zcol Ki.
    ///
    /// # Source
    /// Equation (L9) of docs/equations.md.
    fn heave_gains(&self, zw: f64, zcol: f64) -> Result<PidGains, DesignError> {
        let HeavePoles { frequency_radps, damping, derivative_s, derivative_filter_s } = self.heave;
        let proportional = (2.0 * damping * frequency_radps + zw) / zcol;
        if !proportional.is_finite() {
            return Err(DesignError::Singular { matrix: "Zcol, the effect of collective on w," });
        }
        Ok(PidGains {
            proportional,
            integral_per_s: frequency_radps * frequency_radps / zcol,
            derivative_s: derivative_s * proportional,
            derivative_filter_s,
            tracking_time_s: self.tracking_s,
        })
    }
}
