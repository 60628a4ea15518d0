//! The pilot: flies by hand on the truth, lets go while the autopilot flies.

use hovernav::autopilot::{ConfigError, HoverAutopilot, HoverConfig, Inputs};
use hovernav::controls::Sticks;
use hovernav::ekf::Solution;

/// A control that differs by more than this from the pilot's was moved by somebody else.
const MOVED: f64 = 0.002;

/// So long after the sticks last were moved by somebody else the pilot sees that nobody flies, s.
const NOTICES_S: f64 = 0.4;

/// A pilot who holds a hover.
pub struct Pilot {
    hands: HoverAutopilot,
    period_s: f64,
    /// Where the sticks are held.
    held: Sticks,
    /// How long the vehicle has done what the pilot's own sticks say though the switch is closed, s.
    alone_s: f64,
    lets_go: bool,
}

impl Pilot {
    /// A pilot with the skill of the autopilot `skill`.
    ///
    /// # Errors
    /// A configuration that one cannot fly with.
    pub fn new(skill: HoverConfig) -> Result<Self, ConfigError> {
        Ok(Self {
            hands: HoverAutopilot::new(skill)?,
            period_s: skill.period_s,
            held: skill.trim.sticks,
            alone_s: 0.0,
            lets_go: false,
        })
    }

    /// Where the sticks are, one period later. `commanded` is what the vehicle was commanded to do last
    /// and `switch_on` whether the pilot wants the autopilot to fly; `still` holds the sticks for a while.
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
            // Once alone the pilot flies on until the switch has been opened.
            self.lets_go = self.alone_s < NOTICES_S;
        }
        // What is not flown by hand must not wind the hands' loops up.
        let by_hand = !self.lets_go && !still;
        let inputs = Inputs {
            now: truth.time,
            solution: Some(truth),
            // Its own hands are no override of its own hands.
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
