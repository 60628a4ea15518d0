//! The hover autopilot: three loops, a choice of modes, and the pilot's override.

use super::check::ConfigError;
use super::config::HoverConfig;
use super::excitation::{Excitation, ExcitationAbort, ExcitationError, Exciter};
use super::guidance::{Guidance, Reference, SetPoint, SetPointError, Trusted};
use super::mode::{Mode, Reason, Transition};
use super::pid::Pid;
use super::regulator::Regulator;
use super::supervisor::{Request, Supervisor};
use super::trim::Trim;
use crate::controls::Sticks;
use crate::earth::STANDARD_GRAVITY_MPS2;
use crate::ekf::{Notice, Solution};
use crate::event::Event;
use crate::frames::{Ned, Vector, wrap_angle};
use crate::health::{Health, HealthMonitor};
use crate::scalar::Scalar;
use crate::time::Time;

/// Inputs of one step of the autopilot.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a, T = f64> {
    /// Time of the step, on the estimator's clock.
    pub now: Time,
    /// The estimator's latest solution, if any.
    pub solution: Option<&'a Solution<T>>,
    /// The pilot's sticks; `None` without a signal. Values that are not finite count as no signal.
    pub pilot: Option<Sticks<T>>,
    /// The pilot's switch: whether the autopilot is to fly.
    pub engage: bool,
}

/// The result of one step of the autopilot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outputs<T = f64> {
    /// Positions of the controls, within range and, when the autopilot flies, within rate limits.
    pub sticks: Sticks<T>,
    /// The active mode.
    pub mode: Mode,
    /// The change of mode in this step, if there was one.
    pub transition: Option<Transition>,
    /// The test input that is part of the sticks; see [`HoverAutopilot::excite`].
    pub injected: Sticks<T>,
    /// Reason for the early end of a test input, if one ended early in this step.
    pub aborted: Option<ExcitationAbort>,
}

/// The hover autopilot, stepped once every [`HoverConfig::period_s`].
///
/// Each step picks the best mode that the pilot and the estimate allow and computes the command of this mode. It then
/// fades out the difference from the command of the previous mode, and limits the result. Opening the pilot's switch,
/// or moving a stick by more than the override travel, gives the sticks back to the pilot at once. The switch must then
/// be opened before the autopilot takes over again. Without a usable attitude at the time of engagement, the sticks
/// stay with the pilot.
///
/// ```
/// use hovernav::autopilot::{Gains, HoverAutopilot, HoverConfig, Inputs, Mode};
/// use hovernav::controls::Sticks;
/// use hovernav::earth::Geodetic;
/// use hovernav::ekf::Solution;
/// use hovernav::frames::{EulerAngles, Rotation, Vector};
/// use hovernav::time::Time;
///
/// // Gains come from a design for the vehicle; these only damp the rates.
/// let mut gains = Gains::default();
/// gains.heave.tracking_time_s = 1.0;
/// gains.roll_pitch.measured = [[0.1, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.1, 0.0, 0.0, 0.0, 0.0]];
/// gains.yaw.measured = [[0.2, 0.0]];
/// let mut autopilot = HoverAutopilot::new(HoverConfig::new(0.03, gains))?;
///
/// // The estimator's solution of a vehicle that hovers but rolls to the right at 0.2 rad/s.
/// let place = Geodetic::from_degrees(1.35, 103.82, 50.0).expect("a place on Earth");
/// let rolling = |time| Solution {
///     body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(0.0, 0.0, 40.0)),
///     angular_rate_radps: Vector::new(0.2, 0.0, 0.0),
///     position_sigma_m: Vector::new(1.0, 1.0, 1.5),
///     velocity_sigma_mps: Vector::new(0.1, 0.1, 0.1),
///     attitude_sigma_rad: [0.01, 0.01, 0.03],
///     ..Solution::at_rest(time, place)
/// };
/// let pilot = Some(Sticks { collective: 0.1, ..Sticks::NEUTRAL });
/// let mut now = Time::ZERO;
/// let mut outputs = None;
/// for engage in [false, true, true, true] {
///     now = now + 0.03;
///     let solution = rolling(now);
///     outputs = Some(autopilot.step(&Inputs { now, solution: Some(&solution), pilot, engage }));
/// }
/// let outputs = outputs.expect("four steps");
/// assert_eq!(outputs.mode, Mode::Position);
/// assert!(outputs.sticks.lateral < 0.0); // left, against the roll
/// # Ok::<(), hovernav::autopilot::ConfigError>(())
/// ```
///
/// The autopilot computes in `T`: `f64`, or `f32` for processors without double precision. For `f32`, cast the same
/// configuration: `HoverAutopilot::new(config.cast::<f32>())`. Times and the position to hold are exact in both.
#[derive(Clone, Copy, Debug)]
pub struct HoverAutopilot<T = f64> {
    config: HoverConfig<T>,
    /// [`HoverConfig::period_s`] in the number type of the loops.
    period_s: T,
    heave: Pid<T>,
    yaw: Regulator<2, 2, 1, T>,
    roll_pitch: Regulator<6, 6, 2, T>,
    attitude: Regulator<4, 6, 2, T>,
    guidance: Guidance<T>,
    supervisor: Supervisor<T>,
    monitor: HealthMonitor<T>,
    /// The last command.
    sticks: Sticks<T>,
    /// Remaining difference between the commands of the previous and the present mode.
    fading: Sticks<T>,
    /// Remaining time, s, of the low stick rate after the switch transferred the sticks between pilot and autopilot.
    gentle_s: f64,
    /// The learned trim.
    learned: Trim<T>,
    /// The trim that the loops have used since their start.
    trim: Trim<T>,
    heave_runs: bool,
    exciter: Exciter,
}

/// The estimate in the form that the loops use.
#[derive(Clone, Copy, Debug)]
struct Flown<'a, T> {
    solution: &'a Solution<T>,
    /// Roll, pitch and yaw, rad.
    angles: [T; 3],
}

impl<T: Scalar> Flown<'_, T> {
    /// Components of each velocity along the body's forward and right axes, m/s.
    fn forward_and_right(&self, velocities: [Vector<Ned, T>; 2]) -> [[T; 2]; 2] {
        let [north, east, down] = self.solution.body_to_ned.rows();
        velocities.map(|velocity| {
            let [n, e, d] = velocity.to_array();
            [north[0] * n + east[0] * e + down[0] * d, north[1] * n + east[1] * e + down[1] * d]
        })
    }
}

impl<T: Scalar> HoverAutopilot<T> {
    /// Creates an autopilot that has not taken over; its sticks are at trim.
    ///
    /// # Errors
    /// [`ConfigError`] names the first invalid value of `config`.
    pub fn new(config: HoverConfig<T>) -> Result<Self, ConfigError> {
        config.check()?;
        let (gains, period_s) = (&config.gains, T::of(config.period_s));
        Ok(Self {
            heave: Pid::unchecked(gains.heave, period_s),
            yaw: Regulator::unchecked(gains.yaw, period_s),
            roll_pitch: Regulator::unchecked(gains.roll_pitch, period_s),
            attitude: Regulator::unchecked(gains.attitude, period_s),
            guidance: Guidance::new(config.guidance, config.period_s),
            supervisor: Supervisor::new(
                config.period_s,
                &config.transfer,
                config.health.recovery_s,
            ),
            monitor: HealthMonitor::new(config.health),
            sticks: config.trim.sticks,
            fading: Sticks::NEUTRAL,
            gentle_s: 0.0,
            learned: config.trim,
            trim: config.trim,
            heave_runs: false,
            exciter: Exciter::default(),
            period_s,
            config,
        })
    }

    /// Sets the set-point. Engagement resets it to [`SetPoint::Hold`].
    ///
    /// # Errors
    /// [`SetPointError`] for values that are not finite or too fast; the previous set-point stays active.
    pub fn set(&mut self, set_point: SetPoint) -> Result<(), SetPointError> {
        self.guidance.accept(set_point)
    }

    /// Adds a test input to the sticks from the next step on. The sticks stay within range, but their rate limits do
    /// not apply; only the test input's own limits do. It ends when it is complete, when one of its limits is exceeded,
    /// or when the autopilot does not hold velocity.
    ///
    /// # Errors
    /// [`ExcitationError`] if the autopilot does not hold velocity, another test input is active, or a number is out of
    /// range.
    pub fn excite(&mut self, excitation: Excitation) -> Result<(), ExcitationError> {
        if !self.mode().holds_velocity() {
            return Err(ExcitationError::NotFlying);
        }
        self.exciter.start(excitation)
    }

    /// Whether a test input is active.
    #[must_use]
    pub const fn is_excited(&self) -> bool {
        self.exciter.is_running()
    }

    /// Ends the active test input, if any.
    pub const fn end_excitation(&mut self) {
        self.exciter.stop();
    }

    /// The active mode.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.supervisor.mode()
    }

    /// The latest change of mode.
    #[must_use]
    pub const fn last_transition(&self) -> Option<Transition> {
        self.supervisor.last_transition()
    }

    /// Velocity, m/s, and heading, rad, that guidance last commanded to the loops. The loops follow the velocity only
    /// while [`Mode::holds_velocity`].
    #[must_use]
    pub fn reference(&self) -> (Vector<Ned, T>, T) {
        self.guidance.reference()
    }

    /// Trim learned in steady hover, flown by the pilot or the autopilot.
    #[must_use]
    pub const fn learned_trim(&self) -> Trim<T> {
        self.learned
    }

    /// Passes a sensor event to the [`HealthMonitor`], which detects frozen sensors.
    pub fn observe(&mut self, event: &Event) {
        self.monitor.observe(event);
    }

    /// Passes an estimator notice to the [`HealthMonitor`], which detects missing fixes and fixes that contradict the
    /// estimate.
    pub fn observe_notice(&mut self, notice: &Notice) {
        self.monitor.observe_notice(notice);
    }

    /// Runs one step of the autopilot; call it every [`HoverConfig::period_s`].
    ///
    /// # Source
    /// Equation (C8) of docs/equations.md.
    pub fn step(&mut self, inputs: &Inputs<'_, T>) -> Outputs<T> {
        let pilot = inputs.pilot.filter(|sticks| sticks.is_finite());
        let health = self.monitor.assess(inputs.solution, inputs.now);
        let flown = inputs
            .solution
            .filter(|_| health.tilt.is_ok())
            .map(|solution| Flown { solution, angles: solution.body_to_ned.angles() });

        let Inputs { now, engage, .. } = *inputs;
        let transition = self.supervisor.choose(&Request { now, engage, pilot, health });
        if let Some(Transition { from, to, .. }) = transition {
            self.start_loops(from, to, flown.as_ref());
        }
        let wanted = self.wanted(pilot, flown.as_ref(), &health);
        let (period_s, transfer) = (self.period_s, &self.config.transfer);
        self.gentle_s = match transition {
            Some(Transition { from: Mode::Manual, .. }) => GENTLE_S,
            // A pilot who moves a stick needs the sticks at once: the stick rate is not reduced.
            Some(Transition { to: Mode::Manual, reason: Reason::Switch, .. }) => GENTLE_S,
            Some(_) => 0.0,
            None if self.gentle_s > 0.0 => (self.gentle_s - self.config.period_s).max(0.0),
            None => 0.0,
        };
        self.fading = match (transition, self.mode()) {
            // In this mode the sticks move to trim from the previous command, so there is no difference to fade.
            (_, Mode::Neutral) => Sticks::NEUTRAL,
            (Some(_), _) => self.sticks.zip(wanted, |last, wanted| last - wanted),
            (None, Mode::Manual) if self.gentle_s > 0.0 => {
                handed_back(self.fading, period_s, transfer.hand_back_s)
            }
            (None, Mode::Manual) => {
                self.fading.scaled(T::ONE - (period_s / transfer.hand_back_s).min(T::ONE))
            }
            _ => self.fading.scaled(T::ONE - (period_s / transfer.fade_s).min(T::ONE)),
        };
        // Without this end of the decay the value would become a denormal number, which processors compute about 100
        // times slower.
        if self.fading.farthest_from(Sticks::NEUTRAL) < T::of(FADED) {
            self.fading = Sticks::NEUTRAL;
        }
        let faded = wanted.zip(self.fading, |wanted, left| wanted + left);
        let mut limits = self.config.limits;
        if self.gentle_s > 0.0 {
            // Only a pilot moves sticks beyond full travel; they return at the configured rate.
            limits.rate_per_s = limits.rate_per_s.zip(self.sticks, |rate_per_s, last| {
                if last.abs() > T::ONE { rate_per_s } else { rate_per_s.min(T::of(GENTLE_PER_S)) }
            });
        }
        self.sticks = match self.mode() {
            Mode::Manual => limits.in_range_with_pilot(faded, wanted),
            _ => limits.reachable(faded, self.sticks, period_s),
        };
        // The loops do not receive the test input; they respond to its effect on the vehicle, as to a gust.
        self.advance();
        let held = flown.filter(|_| self.mode().holds_velocity());
        let (commanded_mps, _) = self.guidance.reference();
        let held = held.map(|flown| (flown.solution, commanded_mps));
        let (added, aborted) = self.exciter.step(held, self.config.period_s);
        let added = added.cast();
        let sticks = if added == Sticks::NEUTRAL {
            self.learn(flown.as_ref());
            self.sticks
        } else {
            limits.in_range(self.sticks.zip(added, |stick, added| stick + added))
        };
        let injected = sticks.zip(self.sticks, |given, own| given - own);
        Outputs { sticks, mode: self.mode(), transition, injected, aborted }
    }

    /// Transfers control from the loops of one mode to the loops of another mode.
    fn start_loops(&mut self, from: Mode, mode: Mode, flown: Option<&Flown<'_, T>>) {
        let same_loops = (from.holds_velocity() && mode.holds_velocity())
            || (from == Mode::Attitude && mode == Mode::Descent);
        if same_loops || matches!(mode, Mode::Manual | Mode::Neutral) {
            return;
        }
        let before = self.trim.sticks;
        if self.learned.is_plausible() {
            self.trim = self.learned;
        }
        // Collective and pedal keep their trim between loops, and take their current position as trim after `Manual`.
        // Cyclic takes the learned trim, which follows the wind.
        let runs_on = !matches!(from, Mode::Manual | Mode::Neutral);
        if runs_on {
            (self.trim.sticks.collective, self.trim.sticks.pedal) =
                (before.collective, before.pedal);
        } else if from == Mode::Manual {
            (self.trim.sticks.collective, self.trim.sticks.pedal) =
                (self.sticks.collective, self.sticks.pedal);
        }
        let [lateral, longitudinal, _, pedal] =
            self.sticks.zip(self.trim.sticks, |now, trim| now - trim).to_array();
        self.roll_pitch.start([lateral, longitudinal]);
        self.attitude.start([lateral, longitudinal]);
        if !runs_on {
            self.yaw.start([pedal]);
            self.heave_runs = false;
        }
        if let Some(flown) = flown {
            let [.., yaw_rad] = flown.angles;
            self.guidance.engage(flown.solution, yaw_rad);
        }
    }

    /// The mode's command before fading and limits.
    fn wanted(
        &mut self,
        pilot: Option<Sticks<T>>,
        flown: Option<&Flown<'_, T>>,
        health: &Health,
    ) -> Sticks<T> {
        let flown = match (self.mode(), flown) {
            (Mode::Manual, _) => return pilot.unwrap_or(self.sticks),
            (Mode::Neutral, _) | (_, None) => return self.towards_trim(),
            (_, Some(flown)) => flown,
        };
        let sinks = self.mode() == Mode::Descent;
        let trusted = Trusted {
            position: self.mode() == Mode::Position && health.position.is_ok(),
            heading: health.heading.is_ok(),
            sink_mps: sinks.then_some(self.config.transfer.descent_mps),
        };
        let [.., yaw_rad] = flown.angles;
        let reference = self.guidance.step(flown.solution, yaw_rad, trusted);
        let [lateral, longitudinal] = if self.mode().holds_velocity() {
            self.velocity_loop(flown, &reference)
        } else {
            self.attitude_loop(flown)
        };
        let collective = self.heave_loop(flown, &reference, health.vertical_velocity.is_ok());
        let turn = wrap_angle(yaw_rad - reference.heading_rad);
        let yaw_rate = flown.solution.angular_rate_radps.z();
        // ψ is measured from its reference, which turns at the reference rate.
        let [pedal] = self.yaw.command(&[yaw_rate, turn], &[reference.yaw_rate_radps, T::ZERO]);
        let deviation = Sticks { lateral, longitudinal, collective, pedal };
        let mut wanted = self.trim.sticks.zip(deviation, |trim, more| trim + more);
        wanted.pedal += self.config.gains.pedal_per_collective * collective;
        wanted
    }

    fn towards_trim(&self) -> Sticks<T> {
        let share = (self.period_s / self.config.transfer.neutral_s).min(T::ONE);
        let trim = if self.learned.is_plausible() { self.learned } else { self.config.trim };
        self.sticks.zip(trim.sticks, |last, trim| last + share * (trim - last))
    }

    /// Lateral and longitudinal cyclic commands about trim, from the velocity loop: equation (C7) of docs/equations.md.
    fn velocity_loop(&mut self, flown: &Flown<'_, T>, reference: &Reference<T>) -> [T; 2] {
        let [p, q, _] = flown.solution.angular_rate_radps.to_array();
        let (roll, pitch) = self.tilt_from_trim(flown);
        let [velocity, wanted] =
            flown.forward_and_right([flown.solution.velocity_mps, level(reference.velocity_mps)]);
        let (sin, cos) = flown.solution.body_to_ned.heading_sincos();
        let acceleration = reference.acceleration_mps2;
        let forward = cos * acceleration.x() + sin * acceleration.y();
        let right = cos * acceleration.y() - sin * acceleration.x();
        let gravity_mps2 = T::of(STANDARD_GRAVITY_MPS2);
        self.roll_pitch.command(
            &[p, q, roll, pitch, velocity[0], velocity[1]],
            &[
                T::ZERO,
                T::ZERO,
                right / gravity_mps2,
                -forward / gravity_mps2,
                wanted[0],
                wanted[1],
            ],
        )
    }

    fn attitude_loop(&mut self, flown: &Flown<'_, T>) -> [T; 2] {
        let [p, q, _] = flown.solution.angular_rate_radps.to_array();
        let (roll, pitch) = self.tilt_from_trim(flown);
        self.attitude.command(&[p, q, roll, pitch], &[T::ZERO; 4])
    }

    fn tilt_from_trim(&self, flown: &Flown<'_, T>) -> (T, T) {
        let [roll_rad, pitch_rad, _] = flown.angles;
        (roll_rad - self.trim.roll_rad, pitch_rad - self.trim.pitch_rad)
    }

    /// Collective command about trim.
    fn heave_loop(&mut self, flown: &Flown<'_, T>, reference: &Reference<T>, trusted: bool) -> T {
        if !trusted {
            if self.heave_runs && self.learned.is_plausible() {
                self.trim.sticks.collective = self.learned.sticks.collective;
            }
            self.heave_runs = false;
            let sinking = if self.mode() == Mode::Descent {
                self.config.transfer.descent_collective
            } else {
                T::ZERO
            };
            // Sinking is positive w. The heave loop commands collective with the sign of the proportional gain if w is
            // too small. This collective causes sinking.
            return sinking.copysign(self.config.gains.heave.proportional);
        }
        let [.., [_, _, upright]] = flown.solution.body_to_ned.rows();
        let [w, wanted] = [flown.solution.velocity_mps.z(), reference.velocity_mps.z()]
            .map(|down| upright * down);
        if !self.heave_runs {
            self.heave_runs = true;
            self.heave.start(self.config.gains.heave.proportional * (wanted - w), wanted, w);
        }
        self.heave.command(wanted, w)
    }

    /// Advances the loops to the next sample. Their applied commands are the sticks without the fading difference
    /// between modes.
    fn advance(&mut self) {
        if matches!(self.mode(), Mode::Manual | Mode::Neutral) {
            return;
        }
        let own = self.sticks.zip(self.fading, |stick, left| stick - left);
        let [lateral, longitudinal, collective, pedal] =
            own.zip(self.trim.sticks, |stick, trim| stick - trim).to_array();
        if self.mode().holds_velocity() {
            self.roll_pitch.advance(&[lateral, longitudinal]);
        } else {
            self.attitude.advance(&[lateral, longitudinal]);
        }
        if self.heave_runs {
            self.heave.advance(collective);
        }
        self.yaw.advance(&[pedal - self.config.gains.pedal_per_collective * collective]);
    }

    /// Moves the learned trim towards the current sticks and tilt in a steady hover.
    fn learn(&mut self, flown: Option<&Flown<'_, T>>) {
        let Some(flown) = flown else { return };
        let steady = matches!(self.mode(), Mode::Manual | Mode::Position | Mode::Velocity)
            && self.fading.farthest_from(Sticks::NEUTRAL) < T::of(0.02)
            && flown.solution.velocity_mps.is_shorter_than(T::of(STEADY_MPS))
            && flown.solution.velocity_sigma_mps.is_shorter_than(T::of(STEADY_MPS))
            && flown.solution.angular_rate_radps.is_shorter_than(T::of(STEADY_RADPS));
        if steady {
            let [roll_rad, pitch_rad, _] = flown.angles;
            let now = Trim { sticks: self.sticks, roll_rad, pitch_rad };
            let share = (self.period_s / self.config.transfer.trim_s).min(T::ONE);
            self.learned = self.learned.towards(&now, share);
        }
    }
}

/// Largest speed of a steady hover, m/s.
const STEADY_MPS: f64 = 1.0;
/// Largest angular rate of a steady hover, rad/s.
const STEADY_RADPS: f64 = 0.3;

/// Largest rate of the sticks, full sticks a second, after the switch transferred them between pilot and autopilot: at
/// most 2.7 % in a cycle of 33 Hz. Motion of the vehicle at that moment therefore causes no jump of the sticks.
const GENTLE_PER_S: f64 = 0.9;
/// Duration of this lower stick rate after the transfer, s.
const GENTLE_S: f64 = 1.0;
/// Remaining difference of commands, full sticks, below which a transition is complete.
const FADED: f64 = 1e-9;
/// Difference between the sticks of autopilot and pilot, full sticks. Above it the autopilot hands the sticks back
/// without a limit on the stick rate.
const FAR_APART: f64 = 0.5;

/// Value of `fading` one sample later, while the pilot has the sticks.
fn handed_back<T: Scalar>(fading: Sticks<T>, period_s: T, hand_back_s: T) -> Sticks<T> {
    let share = (period_s / hand_back_s).min(T::ONE);
    let gently = T::of(GENTLE_PER_S) * period_s;
    Sticks::from_array(fading.to_array().map(|left| {
        let step = share * left;
        left - if left.abs() > T::of(FAR_APART) { step } else { step.max(-gently).min(gently) }
    }))
}

/// Horizontal part of a velocity.
fn level<T: Scalar>(velocity: Vector<Ned, T>) -> Vector<Ned, T> {
    Vector::new(velocity.x(), velocity.y(), T::ZERO)
}
