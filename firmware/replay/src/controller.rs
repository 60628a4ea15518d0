//! Controllers that fly on the estimate: the autopilot alone, or flight control with the autopilot.

use hovernav::autopilot::{HoverAutopilot, Inputs};
use hovernav::controls::{Channels, Sticks};
use hovernav::ekf::{Notice, Solution};
use hovernav::event::Event;
use hovernav::flight_control::{ControlInputs, FlightControl};
use hovernav::scalar::Scalar;
use hovernav::servo::{Captured, PilotPulses, Pulse};
use hovernav::time::Time;

use crate::Work;

/// A controller that flies on the estimate, stepped once per sample.
pub trait Controller<T> {
    /// Kind of work that one step of this controller counts as.
    const WORK: Work;

    /// Receives a sensor event.
    fn observe(&mut self, event: &Event);

    /// Receives a notice of the estimator.
    fn observe_notice(&mut self, notice: &Notice);

    /// Runs one step; `engage` is the pilot's switch.
    fn step(&mut self, now: Time, solution: Option<&Solution<T>>, engage: bool) -> Sticks<T>;
}

impl<T: Scalar> Controller<T> for HoverAutopilot<T> {
    const WORK: Work = Work::Autopilot;

    fn observe(&mut self, event: &Event) {
        self.observe(event);
    }

    fn observe_notice(&mut self, notice: &Notice) {
        self.observe_notice(notice);
    }

    fn step(&mut self, now: Time, solution: Option<&Solution<T>>, engage: bool) -> Sticks<T> {
        self.step(&Inputs { now, solution, pilot: Some(Sticks::NEUTRAL), engage }).sticks
    }
}

/// Flight control, and a pilot whose sticks are centred.
pub struct Computer<T> {
    control: FlightControl<T>,
    last_fix: Option<Time>,
}

impl<T> Computer<T> {
    /// Creates the controller around `control`.
    #[must_use]
    pub const fn new(control: FlightControl<T>) -> Self {
        Self { control, last_fix: None }
    }
}

impl<T: Scalar> Controller<T> for Computer<T> {
    const WORK: Work = Work::Control;

    fn observe(&mut self, event: &Event) {
        if let Event::Gps(fix) = event {
            self.last_fix = Some(fix.time);
        }
        self.control.observe(event);
    }

    fn observe_notice(&mut self, notice: &Notice) {
        self.control.observe_notice(notice);
    }

    fn step(&mut self, now: Time, solution: Option<&Solution<T>>, engage: bool) -> Sticks<T> {
        let pulse = |width_ms| Captured { pulse: Some(Pulse { width_ms, at: now }), errors: 0 };
        let pulses = PilotPulses {
            channels: Channels::from_fn(|_| pulse(1.5)),
            aux: pulse(if engage { 2.0 } else { 1.0 }),
            receiver_failsafe: false,
        };
        let inputs = ControlInputs {
            now,
            solution,
            fix_age_s: self.last_fix.map(|fix| now - fix),
            pulses: &pulses,
            servos_good: true,
            late_cycles: 0,
        };
        let outputs = self.control.step(&inputs, |_| {});
        // The hash covers the widths as well as the sticks.
        let widths: f64 = outputs.widths_ms.to_array().iter().sum();
        let sticks = outputs.sticks.unwrap_or(Sticks::NEUTRAL);
        Sticks { collective: sticks.collective + widths, ..sticks }.cast()
    }
}
