//! Flight control: it turns the pilot's pulses and the estimate into servo commands, with the failsafes.
//!
//! The pilot closes a switch on the aux channel. If every check of [`Readiness`] passes, the autopilot takes over;
//! otherwise flight control reports the failed checks and the pilot continues to fly. Opening the switch, losing the
//! aux channel alone or moving a stick far gives the sticks back in the same cycle.
//!
//! | loss | response | within |
//! |---|---|---|
//! | the pilot's signal | holds position, later descends | 1 cycle after the signal counts as lost |
//! | the aux channel alone | the pilot flies | the same |
//! | position | holds velocity | 1 cycle |
//! | velocity | holds attitude, after `transfer.patience_s` descends | 1 cycle |
//! | attitude or inertial unit | the pilot flies; without a pilot, sticks to trim | 1 cycle after `health.age_s` |
//! | time: [`FailsafeConfig::late_cycles`] late cycles in a row | the pilot flies | 1 cycle |
//! | the geofence reached | goes back to its centre | 1 cycle |
//!
//! The pilot's signal counts as lost if the receiver reports the loss, or after
//! [`SignalConfig::stale_after_s`](crate::servo::SignalConfig) without pulses. The autopilot descends after
//! [`FailsafeConfig::pilot_lost_hold_s`], at [`FailsafeConfig::descent_mps`].
//!
//! Like the autopilot, flight control is plain data with bounded work, and depends only on its inputs. The same inputs
//! give the same pulse widths, so a replayed record gives the same bits.

mod bounces;
mod config;
mod geofence;
mod notice;

pub use config::{FailsafeConfig, FlightControlConfig, FlightControlError, Geofence};
pub use notice::{ControlNotice, HandedBack};

use crate::autopilot::{
    Engagement, EngagementChange, ExcitationAbort, HoverAutopilot, Inputs, Mode, Observed,
    ProgrammeFlight, Readiness, Reason, SetPoint, Steering, Transition,
};
use crate::controls::{Channels, Sticks};
use crate::earth::Geodetic;
use crate::ekf::{Notice, Solution};
use crate::event::Event;
use crate::scalar::Scalar;
use crate::servo::{PilotPulses, Signal, Switch};
use crate::time::Time;
use bounces::Bounces;
use geofence::{GeofenceChange, GeofenceMonitor};

/// Fraction of its range beyond which a stick counts as at its end.
const AT_END: f64 = 0.995;
/// Weight of the newest period in the running mean of the loop's period.
const PERIOD_SHARE: f64 = 0.05;

/// Inputs of one cycle.
#[derive(Clone, Copy, Debug)]
pub struct ControlInputs<'a, T = f64> {
    /// Time of the cycle, on the clock of the pulses and of the estimator.
    pub now: Time,
    /// The estimator's latest solution.
    pub solution: Option<&'a Solution<T>>,
    /// Age of the last good fix, s.
    pub fix_age_s: Option<f64>,
    /// State of the pilot's pulses.
    pub pulses: &'a PilotPulses,
    /// Whether the servos receive their commands.
    pub servos_good: bool,
    /// Number of consecutive late cycles, this one included.
    pub late_cycles: u8,
}

/// Outputs of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlOutputs {
    /// Positions of the controls.
    pub sticks: Option<Sticks>,
    /// Contribution of the test input to `sticks`; zero without a test input.
    pub injected: Sticks,
    /// The pilot's own sticks, if all four are fresh and are not the receiver's failsafe.
    pub pilot: Option<Sticks>,
    /// Pulse widths for the servos, ms, not limited; NaN without a command.
    pub widths_ms: Channels<f64>,
    /// State of the pilot's signal.
    pub signal: Signal,
    /// The active mode.
    pub mode: Mode,
    /// Whether the pilot's switch is closed.
    pub switch_on: bool,
    /// Whether the autopilot could take over now, and the result of each check.
    pub readiness: Readiness,
}

/// The pilot's signal in this cycle.
#[derive(Clone, Copy, Debug)]
struct AtStick {
    signal: Signal,
    sticks: Option<Sticks>,
    widths_ms: Channels<Option<f64>>,
}

/// Pilot, autopilot and the choice between them. It runs one step in each cycle.
///
/// The autopilot, its estimate and the geofence monitor compute in `T`: `f64`, or `f32` for processors without double
/// precision. For `f32`, use `FlightControl::<f32>::new(config)` with the same configuration. Sticks, widths and times
/// of inputs and outputs are `f64`.
#[derive(Clone, Copy, Debug)]
pub struct FlightControl<T = f64> {
    config: FlightControlConfig,
    autopilot: HoverAutopilot<T>,
    switch: Switch,
    /// Whether the notice that the switch must be opened was sent.
    is_reported_closed: bool,
    bounces: Bounces,
    engagement: Engagement,
    steering: Option<Steering>,
    programme: Option<ProgrammeFlight>,
    /// Pulse width, ms, of the pilot's last throttle, or of the throttle at engagement.
    throttle_ms: f64,
    before: Option<Time>,
    period_s: Option<f64>,
    pilot_lost_s: Option<f64>,
    descends: bool,
    geofence: GeofenceMonitor<T>,
    saturated_s: f64,
}

impl<T: Scalar> FlightControl<T> {
    /// Creates the flight control; the pilot flies.
    ///
    /// # Errors
    /// [`FlightControlError`] with the first invalid value of `config`.
    pub fn new(config: FlightControlConfig) -> Result<Self, FlightControlError> {
        config.check()?;
        let neutral = config.hover.trim.sticks;
        Ok(Self {
            autopilot: HoverAutopilot::new(config.hover.cast())?,
            switch: Switch::new(config.switch)?,
            is_reported_closed: false,
            bounces: Bounces::default(),
            engagement: Engagement::default(),
            steering: match config.steering {
                Some(steering) => Some(Steering::new(steering, neutral)?),
                None => None,
            },
            programme: config.excitation.map(ProgrammeFlight::new),
            throttle_ms: f64::NAN,
            before: None,
            period_s: None,
            pilot_lost_s: None,
            descends: false,
            geofence: GeofenceMonitor::new(config.geofence),
            saturated_s: 0.0,
            config,
        })
    }

    /// The autopilot that this flight control contains.
    #[must_use]
    pub const fn autopilot(&self) -> &HoverAutopilot<T> {
        &self.autopilot
    }

    /// Whether the autopilot flies.
    #[must_use]
    pub fn is_engaged(&self) -> bool {
        self.engagement.is_engaged()
    }

    /// Whether the switch has no effect until it has been opened. The cause is one of four: it was closed at the start,
    /// it bounced, or the autopilot refused to engage or gave the sticks back.
    #[must_use]
    pub fn is_refused(&self) -> bool {
        self.engagement == Engagement::Refused
            || self.switch.must_be_opened()
            || !self.is_engaged() && self.bounces.is_locked()
    }

    /// Whether the pilot's signal is lost while the autopilot flies.
    #[must_use]
    pub const fn pilot_is_lost(&self) -> bool {
        self.pilot_lost_s.is_some()
    }

    /// Whether the autopilot descends because the pilot's signal did not return.
    #[must_use]
    pub const fn descends(&self) -> bool {
        self.descends
    }

    /// Whether the vehicle reached the geofence and is not yet well inside again.
    #[must_use]
    pub const fn is_outside_geofence(&self) -> bool {
        self.geofence.is_outside()
    }

    /// Whether a stick of the autopilot is at its end.
    #[must_use]
    pub fn is_at_end(&self) -> bool {
        self.saturated_s > 0.0
    }

    /// Distance from the centre of the geofence as a fraction of the distance to the geofence: the greater of the
    /// fractions to the side and to the top. 1 at the geofence; `None` without a geofence.
    #[must_use]
    pub fn geofence_share(&self, position: &Geodetic) -> Option<f64> {
        self.geofence.share(position)
    }

    /// Passes a sensor event to the health monitor: see [`HoverAutopilot::observe`].
    pub fn observe(&mut self, event: &Event) {
        self.autopilot.observe(event);
    }

    /// Passes an estimator notice to the health monitor: see [`HoverAutopilot::observe_notice`].
    pub fn observe_notice(&mut self, notice: &Notice) {
        self.autopilot.observe_notice(notice);
    }

    /// Runs one cycle; `notify` receives its notices.
    pub fn step(
        &mut self,
        inputs: &ControlInputs<'_, T>,
        mut notify: impl FnMut(ControlNotice),
    ) -> ControlOutputs {
        let now = inputs.now;
        let elapsed_s = self.before.replace(now).map_or(0.0, |before| (now - before).max(0.0));
        if elapsed_s > 0.0 {
            let mean = self.period_s.unwrap_or(elapsed_s);
            self.period_s = Some(mean + PERIOD_SHARE * (elapsed_s - mean));
        }
        let config = &self.config;
        let signal = inputs.pulses.signal(now, &config.signal);
        let stale_s = config.signal.stale_after_s;
        let fresh = inputs.pulses.channels.map(|channel| channel.fresh_ms(now, stale_s));
        // In failsafe the receiver generates the pulses, not the pilot.
        let pilot_ms = fresh.map(|width_ms| width_ms.filter(|_| signal != Signal::Failsafe));
        let pilot = config.swashplate.pilot_sticks(&config.channels, &pilot_ms);
        let at_stick = AtStick { signal, sticks: pilot, widths_ms: pilot_ms };

        let trim = self.autopilot.learned_trim().cast();
        let geofence_share = inputs.solution.and_then(|one| self.geofence.share(&one.position));
        let readiness = Readiness::assess(
            &Observed {
                now,
                solution: inputs.solution,
                fix_age_s: inputs.fix_age_s,
                pilot,
                trim: &trim,
                loop_period_s: self.period_s,
                design_period_s: config.hover.period_s,
                pilot_signal: signal == Signal::Good,
                servos: inputs.servos_good,
                geofence_share,
            },
            &config.ready,
        );
        if !(self.engagement.is_engaged() && self.config.hold_throttle) {
            self.throttle_ms = pilot_ms.throttle.unwrap_or(self.throttle_ms);
        }
        let switch_on = self.engage(inputs, &at_stick, elapsed_s, &readiness, &mut notify);
        self.request(inputs, pilot, geofence_share, &mut notify);
        self.fly_programme(pilot, elapsed_s, &mut notify);

        let engaged = self.engagement.is_engaged();
        let outputs = self.autopilot.step(&Inputs {
            now,
            solution: inputs.solution,
            pilot: pilot.map(Sticks::cast),
            engage: engaged,
        });
        let steered = outputs.sticks.cast();
        if let Some(why) = outputs.aborted {
            self.end_programme(why, &mut notify);
        }
        if let Some(transition) = outputs.transition {
            if self.is_change(&transition, engaged && pilot.is_some()) {
                notify(ControlNotice::Mode(transition));
            }
            if engaged && transition.to == Mode::Manual && transition.reason == Reason::Override {
                self.hand_back(HandedBack::Override, &mut notify);
            }
        }
        if engaged && outputs.mode == Mode::Neutral && pilot.is_some() {
            self.hand_back(HandedBack::NoAttitude, &mut notify);
        }
        // In the cycle in which an autopilot without attitude hands back, its sticks are still used: the next cycle
        // fades from them.
        let flies = engaged && outputs.mode != Mode::Manual;
        self.monitor_ends(flies.then_some(steered), elapsed_s, &mut notify);
        let (sticks, widths_ms) = self.command(flies, steered, outputs.mode, &at_stick);
        ControlOutputs {
            sticks,
            injected: if flies { outputs.injected.cast() } else { Sticks::NEUTRAL },
            pilot,
            widths_ms,
            signal,
            mode: outputs.mode,
            switch_on,
            readiness,
        }
    }

    /// Processes the switch and the loss of the pilot's signal. Returns whether the switch is closed; always `true`
    /// while the autopilot is engaged and the pilot's signal is not good.
    fn engage(
        &mut self,
        inputs: &ControlInputs<'_, T>,
        pilot: &AtStick,
        elapsed_s: f64,
        readiness: &Readiness,
        notify: &mut impl FnMut(ControlNotice),
    ) -> bool {
        let stale_s = self.config.signal.stale_after_s;
        if self.engagement.is_engaged() && pilot.signal != Signal::Good {
            // Without a pilot the sticks cannot be given back; the switch acts again when the signal returns.
            if self.pilot_lost_s.is_none() {
                notify(ControlNotice::PilotLost);
            }
            self.pilot_lost_s = Some(self.pilot_lost_s.unwrap_or(0.0) + elapsed_s);
            return true;
        }
        if self.pilot_lost_s.take().is_some() {
            if core::mem::take(&mut self.descends) {
                let _ = self.autopilot.set(SetPoint::Hold);
            }
            notify(ControlNotice::PilotSignalRestored);
        }
        let switch_on = self.switch.update(&inputs.pulses.aux, inputs.now, stale_s);
        let must_be_opened = self.switch.must_be_opened();
        if !core::mem::replace(&mut self.is_reported_closed, must_be_opened) && must_be_opened {
            notify(ControlNotice::SwitchMustBeReset);
        }
        let bounces = self.bounces.update(switch_on, inputs.now);
        match self.engagement.update(switch_on, readiness.is_ready() && !bounces) {
            Some(EngagementChange::Engaged) => {
                self.bounces.engaged();
                if let (Some(steering), Some(pilot)) = (&mut self.steering, pilot.sticks) {
                    steering.engage(pilot);
                }
                if let (Some(programme), Some(pilot)) = (&mut self.programme, pilot.sticks) {
                    programme.engage(pilot);
                }
                self.geofence.engage();
                self.descends = false;
                notify(ControlNotice::Engaged);
            }
            Some(EngagementChange::Refused) if bounces => notify(ControlNotice::SwitchBounces),
            Some(EngagementChange::Refused) => notify(ControlNotice::Refused(*readiness)),
            Some(EngagementChange::Released) => {
                let heard = inputs.pulses.aux.fresh_ms(inputs.now, stale_s).is_some();
                notify(if heard { ControlNotice::Released } else { ControlNotice::SwitchLost });
            }
            None => {}
        }
        if self.engagement.is_engaged() && inputs.late_cycles >= self.config.failsafe.late_cycles {
            self.hand_back(HandedBack::Late, notify);
        }
        switch_on
    }

    /// Whether a change of mode causes a notice of its own. A change to `Manual` does not, nor a change to `Neutral` if
    /// the pilot takes over: another notice reports that the pilot flies. During a descent without a pilot only a
    /// change to `Neutral` causes a notice.
    fn is_change(&self, transition: &Transition, pilot_takes_over: bool) -> bool {
        match transition.to {
            Mode::Manual => false,
            Mode::Neutral => !pilot_takes_over,
            _ => !self.descends,
        }
    }

    fn hand_back(&mut self, why: HandedBack, notify: &mut impl FnMut(ControlNotice)) {
        // The switch must be opened before it acts again, as after a refusal.
        self.engagement = Engagement::Refused;
        notify(ControlNotice::HandedBack(why));
    }

    /// Flies the test inputs while the autopilot only holds.
    fn fly_programme(
        &mut self,
        pilot: Option<Sticks>,
        elapsed_s: f64,
        notify: &mut impl FnMut(ControlNotice),
    ) {
        let may_go_on = self.engagement.is_engaged()
            && self.pilot_lost_s.is_none()
            && !self.geofence.is_outside();
        let Self { programme, autopilot, .. } = self;
        let change = programme
            .as_mut()
            .and_then(|programme| programme.step(autopilot, pilot, may_go_on, elapsed_s));
        if let Some(change) = change {
            notify(ControlNotice::TestInputs(change));
        }
    }

    fn end_programme(&mut self, why: ExcitationAbort, notify: &mut impl FnMut(ControlNotice)) {
        if let Some(change) = self.programme.as_mut().and_then(|programme| programme.end(why)) {
            notify(ControlNotice::TestInputs(change));
        }
    }

    /// Chooses the set-point. Priority: the descent without a pilot, the return from the geofence, the pilot's sticks.
    fn request(
        &mut self,
        inputs: &ControlInputs<'_, T>,
        pilot: Option<Sticks>,
        geofence_share: Option<f64>,
        notify: &mut impl FnMut(ControlNotice),
    ) {
        if !self.engagement.is_engaged() {
            return;
        }
        let steered = self.steering.as_mut().and_then(|steering| steering.set_point(pilot));
        match inputs.solution.and_then(|one| self.geofence.step(&one.position, geofence_share)) {
            Some(GeofenceChange::Reached) => notify(ControlNotice::GeofenceReached),
            Some(GeofenceChange::Left) => notify(ControlNotice::InsideGeofenceAgain),
            None => {}
        }
        let lost_s = self.pilot_lost_s.unwrap_or(0.0);
        let set_point = if lost_s > self.config.failsafe.pilot_lost_hold_s {
            if !core::mem::replace(&mut self.descends, true) {
                notify(ControlNotice::DescentStarted);
            }
            Some(SetPoint::Velocity {
                forward_mps: 0.0,
                right_mps: 0.0,
                down_mps: self.config.failsafe.descent_mps,
                yaw_rate_radps: 0.0,
            })
        } else {
            self.geofence.home().or(steered)
        };
        if let Some(set_point) = set_point {
            // If guidance rejects the set-point, the previous set-point stays active, in the worst case a hold.
            let _ = self.autopilot.set(set_point);
        }
    }

    fn monitor_ends(
        &mut self,
        sticks: Option<Sticks>,
        elapsed_s: f64,
        notify: &mut impl FnMut(ControlNotice),
    ) {
        let limits = &self.config.hover.limits;
        let at_end = sticks.is_some_and(|sticks| {
            let high = sticks.zip(limits.highest, |stick, end| stick - AT_END * end).to_array();
            let low = sticks.zip(limits.lowest, |stick, end| AT_END * end - stick).to_array();
            high.iter().chain(&low).any(|beyond| *beyond >= 0.0)
        });
        let before_s = self.saturated_s;
        self.saturated_s = if at_end { before_s + elapsed_s } else { 0.0 };
        let long_s = self.config.failsafe.saturation_s;
        if self.saturated_s >= long_s && before_s < long_s {
            notify(ControlNotice::Saturated);
        }
    }

    /// Sticks and pulse widths of the pilot or the autopilot, whichever flies.
    fn command(
        &self,
        flies: bool,
        sticks: Sticks,
        mode: Mode,
        pilot: &AtStick,
    ) -> (Option<Sticks>, Channels<f64>) {
        let config = &self.config;
        let AtStick { sticks: pilot, widths_ms: pilot_ms, .. } = *pilot;
        // Without a pilot the engine keeps running as long as the autopilot controls the vehicle.
        let throttle_ms = if flies && (config.hold_throttle || mode != Mode::Neutral) {
            self.throttle_ms
        } else {
            pilot_ms.throttle.unwrap_or(f64::NAN)
        };
        let mixed = |sticks| config.swashplate.widths_ms(&config.channels, sticks, throttle_ms);
        if flies {
            return (Some(sticks), mixed(sticks));
        }
        // After the autopilot hands back, the difference between its sticks and the pilot's fades out: see
        // `hand_back_s`.
        if mode == Mode::Manual
            && let Some(own) = pilot
            && sticks.farthest_from(own) > 1e-9
        {
            return (Some(sticks), mixed(sticks));
        }
        // Where no mixing is needed, the output is the pilot's own pulses, to the last bit.
        (pilot, config.swashplate.passed_on_ms(&config.channels, &pilot_ms))
    }
}

#[cfg(test)]
mod tests;
