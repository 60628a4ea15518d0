//! Gains of the hover autopilot from a model, at the loop's own sample period.
//!
//! The plant of the design is what the loop meets: the model's exact step over one period, behind
//! servos that lag and one sample of delay. Each regulator minimises Σ e^(2αkT)(yᵀQy + zᵀQᵢz + uᵀRu)
//! over that plant with integral action z, so that what it promises holds for the digital loop and
//! not for a continuous one it stands for.
//!
//! ```
//! use hovernav_design::hover::HoverDesign;
//! use hovernav_model::shipped;
//!
//! let design = HoverDesign::default();
//! let model = shipped::raptor60();
//! let gains = design.synthesise(&model)?;
//! let margins = design.close(&model, &gains)?.margins()?;
//! for channel in &margins.channels {
//!     assert!(channel.phase.is_none_or(|phase| phase.margin.to_degrees() > 45.0));
//! }
//! # Ok::<(), hovernav_design::DesignError>(())
//! ```

mod closed_loop;
mod regulator;

use std::path::Path;

use super::{DesignError, DisturbanceResponse, Loop};
use hovernav::autopilot::{Gains, PidGains, RegulatorGains};
use hovernav_model::StateSpace;
use regulator::{Plant, Weights};

/// What the design is to weigh, and what stands between a command and the model.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct HoverDesign {
    /// The loop's period, s.
    pub period_s: f64,
    /// Time constant of the servos of cyclic and collective, s.
    pub servo_s: f64,
    /// Time constant of the tail's servo, s.
    pub tail_servo_s: f64,
    /// How fast integrals follow a limited command, s.
    pub tracking_s: f64,
    /// Roll and pitch with velocity.
    pub roll_pitch: RollPitchWeights,
    /// Roll and pitch alone.
    pub attitude: AttitudeWeights,
    /// Yaw.
    pub yaw: YawWeights,
    /// Heave.
    pub heave: HeavePoles,
}

/// Weights of the velocity regulator. Sticks count from −1 to 1.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub struct RollPitchWeights {
    /// Of p, q, φ, θ, u, v squared, per (rad/s)², rad², (m/s)².
    pub states: [f64; 6],
    /// Of the integrals of u and v squared, per m².
    pub integrals: [f64; 2],
    /// Of lateral and longitudinal stick squared.
    pub sticks: [f64; 2],
    /// Least rate at which every disturbance shall die out, α, 1/s.
    pub decay_per_s: f64,
}

/// Weights of the attitude regulator.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub struct AttitudeWeights {
    /// Of p, q, φ, θ squared.
    pub states: [f64; 4],
    /// Of the integrals of φ and θ squared.
    pub integrals: [f64; 2],
    /// Of lateral and longitudinal stick squared.
    pub sticks: [f64; 2],
    /// As [`RollPitchWeights::decay_per_s`].
    pub decay_per_s: f64,
}

/// Weights of the yaw regulator.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub struct YawWeights {
    /// Of r and ψ squared.
    pub states: [f64; 2],
    /// Of the integral of ψ squared.
    pub integral: f64,
    /// Of pedal squared.
    pub stick: f64,
    /// As [`RollPitchWeights::decay_per_s`].
    pub decay_per_s: f64,
}

/// Where the PID shall put the poles of heave.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub struct HeavePoles {
    /// Natural frequency, rad/s.
    pub frequency_radps: f64,
    /// Damping ratio.
    pub damping: f64,
    /// Derivative gain as a share of the proportional one, s.
    pub derivative_s: f64,
    /// Time constant of the derivative's filter, s.
    pub derivative_filter_s: f64,
}

impl Default for HoverDesign {
    /// For a 60-class helicopter at 33 Hz with the servos that [`sim`](hovernav_sim) gives it.
    fn default() -> Self {
        Self {
            period_s: 1.0 / 33.0,
            servo_s: 0.02,
            tail_servo_s: 0.0133,
            tracking_s: 0.5,
            roll_pitch: RollPitchWeights {
                states: [1.0, 1.0, 10.0, 10.0, 0.6, 0.6],
                integrals: [0.2, 0.2],
                sticks: [10.0, 10.0],
                decay_per_s: 0.1,
            },
            attitude: AttitudeWeights {
                states: [0.1, 0.1, 3.0, 3.0],
                integrals: [1.0, 1.0],
                sticks: [1.0, 1.0],
                decay_per_s: 0.0,
            },
            yaw: YawWeights { states: [0.03, 10.0], integral: 10.0, stick: 0.05, decay_per_s: 0.0 },
            heave: HeavePoles {
                frequency_radps: 3.0,
                damping: 1.0,
                derivative_s: 0.0,
                derivative_filter_s: 0.05,
            },
        }
    }
}

impl HoverDesign {
    /// For the model as Paw (2005) prints it, in which every mode is unstable and full stick is a
    /// hundred times what hover needs. The weights were searched for 45° and 6 dB in every loop with
    /// every disturbance gone within 8 s: that model leaves room for little more.
    #[must_use]
    pub fn thesis() -> Self {
        Self {
            roll_pitch: RollPitchWeights {
                states: [0.23, 0.23, 1.76, 0.79, 0.31, 7.0],
                integrals: [0.05, 0.098],
                sticks: [5100.0, 1450.0],
                decay_per_s: 0.24,
            },
            yaw: YawWeights {
                states: [0.3, 10.0],
                integral: 0.005,
                stick: 1000.0,
                decay_per_s: 0.0,
            },
            ..Self::default()
        }
    }

    /// The design for `model`: the thesis's own weights for its model, the default for any other.
    #[must_use]
    pub fn for_model(model: &StateSpace) -> Self {
        match model.name() {
            "thesis-hover" => Self::thesis(),
            _ => Self::default(),
        }
    }

    /// Reads weights, poles and times from a TOML file; what it leaves out is as by default.
    ///
    /// # Errors
    /// [`DesignError::File`], and [`DesignError::Range`] for what no design can have: a weight below
    /// zero makes the cost indefinite.
    pub fn read(path: &Path) -> Result<Self, DesignError> {
        let refused = |line, reason| DesignError::File { path: path.into(), line, reason };
        let text = std::fs::read_to_string(path).map_err(|error| refused(0, error.to_string()))?;
        let design: Self = toml::from_str(&text).map_err(|error| {
            let start = error.span().map_or(0, |span| span.start);
            let line = 1 + text.bytes().take(start).filter(|&byte| byte == b'\n').count();
            refused(line, error.message().into())
        })?;
        design.check()?;
        Ok(design)
    }

    /// The gains for `model`: continuous, with the states p, q, phi, theta, u, v, w, r and the inputs
    /// lateral, longitudinal, collective, pedal, in any order; a, b, c, d, flapping and bar, and one
    /// more of the yaw gyro may be there.
    ///
    /// # Errors
    /// [`DesignError`].
    pub fn synthesise(&self, model: &StateSpace) -> Result<Gains, DesignError> {
        self.check()?;
        let whole = Plant::of(model)?;
        let rotor = whole.rotor_states();
        let others = whole.other_states();
        let velocity = ["p", "q", "phi", "theta", "u", "v"];
        let cyclic = ["lateral", "longitudinal"];

        let weights = &self.roll_pitch;
        let roll_pitch = self.regulator::<6, 6, 2>(
            &whole.part(&velocity, &rotor, &cyclic),
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
            &whole.part(&velocity[..4], &rotor, &cyclic),
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
        let yaw = self.regulator::<2, 2, 1>(
            &whole.part(&["r", "psi"], &others, &["pedal"]),
            self.tail_servo_s,
            &Weights {
                states: &weights.states,
                integrated: &[1],
                integrals: &[weights.integral],
                sticks: &[weights.stick],
                decay_per_s: weights.decay_per_s,
            },
        )?;
        let heave = whole.part(&["w"], &[], &["collective"]);
        let turn = whole.part(&["r"], &[], &["collective", "pedal"]);
        Ok(Gains {
            heave: self.heave_gains(heave.a[(0, 0)], heave.b[(0, 0)])?,
            yaw,
            pedal_per_collective: -turn.b[(0, 0)] / turn.b[(0, 1)],
            roll_pitch,
            attitude,
        })
    }

    /// The loops closed around `model` by `gains`, as the autopilot closes them when it holds
    /// velocity and heading: model, servos and delay under the four loops, cut where the commands go
    /// to the actuators lateral, longitudinal, collective, pedal.
    ///
    /// # Errors
    /// [`DesignError`].
    pub fn close(&self, model: &StateSpace, gains: &Gains) -> Result<Loop, DesignError> {
        self.check()?;
        closed_loop::cut_at_actuators(self, &Plant::of(model)?, gains)
    }

    /// What becomes of `disturbance`, a state of [`DISTURBED`](super::DISTURBED) and by how much in its
    /// SI unit, in the loops that [`close`](Self::close) closes: at every sample, without the limits of
    /// the servos.
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
        closed_loop::respond(self, &Plant::of(model)?, gains, disturbance, duration_s)
    }

    /// What becomes of `disturbance` with every stick left at trim, as [`respond`](Self::respond)
    /// tells it.
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
        closed_loop::drift(&Plant::of(model)?, self.period_s, disturbance, duration_s)
    }

    fn regulator<const Y: usize, const H: usize, const U: usize>(
        &self,
        part: &Plant,
        servo_s: f64,
        weights: &Weights<'_>,
    ) -> Result<RegulatorGains<Y, H, U>, DesignError> {
        let found = part.a.nrows() - Y + U;
        if found > H {
            return Err(DesignError::Shape {
                matrix: "states that nothing measures",
                rows: found - U,
                columns: 1,
                expected_rows: H - U,
                expected_columns: 1,
            });
        }
        regulator::regulate(part, servo_s, self.period_s, self.tracking_s, weights)
    }

    /// Pole placement on ẇ = Zw w + Zcol δ under PI: s² + (Zcol Kp − Zw) s + Zcol Ki.
    fn heave_gains(&self, zw: f64, zcol: f64) -> Result<PidGains, DesignError> {
        let HeavePoles { frequency_radps, damping, derivative_s, derivative_filter_s } = self.heave;
        let proportional = (2.0 * damping * frequency_radps + zw) / zcol;
        if !proportional.is_finite() {
            return Err(DesignError::Singular { matrix: "Zcol, what collective does to w," });
        }
        Ok(PidGains {
            proportional,
            integral_per_s: frequency_radps * frequency_radps / zcol,
            derivative_s: derivative_s * proportional,
            derivative_filter_s,
            tracking_time_s: self.tracking_s,
        })
    }

    fn check(&self) -> Result<(), DesignError> {
        let (roll_pitch, attitude, yaw) = (&self.roll_pitch, &self.attitude, &self.yaw);
        let times = [
            ("period_s", self.period_s),
            ("servo_s", self.servo_s),
            ("tail_servo_s", self.tail_servo_s),
            ("tracking_s", self.tracking_s),
            ("heave.frequency_radps", self.heave.frequency_radps),
            ("heave.damping", self.heave.damping),
            ("yaw.integral", yaw.integral),
            ("yaw.stick", yaw.stick),
        ];
        let weights = (roll_pitch.states.iter().chain(&roll_pitch.integrals))
            .chain(&roll_pitch.sticks)
            .chain(attitude.states.iter().chain(&attitude.integrals).chain(&attitude.sticks))
            .chain(&yaw.states)
            .map(|&weight| ("a weight of Q or R", weight));
        match times.into_iter().chain(weights).find(|(_, v)| !(*v > 0.0 && v.is_finite())) {
            Some((name, value)) => {
                Err(DesignError::Range { name, value, expected: "a finite number above 0" })
            }
            None => Ok(()),
        }
    }
}
