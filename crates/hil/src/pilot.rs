//! The simulated pilot: flies by hand with the true state, and releases the sticks while the autopilot flies.

use hovernav::autopilot::{ConfigError, HoverAutopilot, HoverConfig, Inputs};
use hovernav::controls::Sticks;
use hovernav::ekf::Solution;

/// Smallest difference between a command and the pilot's control which shows that another source moves the control.
const MOVED: f64 = 0.002;

/// Delay, after the last control movement by another source, until the pilot notices that the vehicle is not being
/// flown, s.
const NOTICES_S: f64 = 0.4;

/// A pilot who holds the hover.
pub struct Pilot {
    hands: HoverAutopilot,
    period_s: f64,
    /// Positions of the sticks.
    held: Sticks,
    /// Time for which the vehicle has followed the pilot's sticks although the switch is closed, s.
    alone_s: f64,
    lets_go: bool,
}

impl Pilot {
    /// A pilot who flies with the gains of the autopilot `skill`.
    ///
    /// # Errors
    /// An invalid configuration.
    pub fn new(skill: HoverConfig) -> Result<Self, ConfigError> {
        Ok(Self {
            hands: HoverAutopilot::new(skill)?,
            period_s: skill.period_s,
            held: skill.trim.sticks,
            alone_s: 0.0,
            lets_go: false,
        })
    }

    /// The positions of the pilot's sticks one period later. `commanded` is the vehicle's last command, and `switch_on`
    /// whether the pilot wants the autopilot to fly. `still` keeps the sticks unchanged.
    pub fn sticks(
        &mut self,
        truth: &Solution,
        commanded: Sticks,
        switch_on: bool,
        still: bool,
    ) -> Sticks {
        if !switch_on {
            (self.lets_go, self.alone_s) = (false, 0.0);
        } else if !self.lets_go && self.alone_s == 0.0 {
            self.lets_go = true;
        }
        if self.lets_go {
            let apart = commanded.to_array().into_iter().zip(self.held.to_array());
            let moved = apart.map(|(commanded, held)| (commanded - held).abs()).fold(0.0, f64::max);
            self.alone_s = if moved > MOVED { 0.0 } else { self.alone_s + self.period_s };
            // After this time the pilot flies until the switch is opened.
            self.lets_go = self.alone_s < NOTICES_S;
        }
        // While another source flies, the integrators of the pilot's loops must not wind up.
        let by_hand = !self.lets_go && !still;
        let inputs = Inputs {
            now: truth.time,
            solution: Some(truth),
            // The pilot's sticks must not count as an override of the pilot's own loops.
            pilot: Some(self.held).filter(|_| !by_hand),
            engage: by_hand,
        };
        let sticks = self.hands.step(&inputs).sticks;
        if by_hand {
            self.held = sticks;
        }
        self.held
    }
}
