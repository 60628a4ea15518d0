//! Test inputs that are flown by themselves, one after the other, while the autopilot holds.

use core::fmt;

use super::excitation::{Excitation, ExcitationAbort, ExcitationError, ExcitationLimits, within};
use super::hover::HoverAutopilot;
use super::maneuver::Maneuver;
use crate::controls::{Channel, Sticks};
use crate::scalar::Scalar;

/// A test input of a programme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TestInput {
    /// The stick that is moved.
    pub stick: Channel,
    /// How.
    pub maneuver: Maneuver,
}

/// Test inputs for an identification flight. The first begins [`first_s`](Self::first_s) after the autopilot
/// took over, the next [`pause_s`](Self::pause_s) after the one before is over. Any of the pilot's sticks
/// moved beyond the dead band, the loss of the pilot, the fence, a limit crossed, or velocity no longer
/// held ends all of them until the autopilot takes over again, which begins the programme anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExcitationProgramme {
    /// What is flown, in this order, up to the first `None`.
    pub inputs: [Option<TestInput>; Self::MOST],
    /// From engagement to the first, s, 2 to 600.
    pub first_s: f64,
    /// From one to the next, s, 1 to 600.
    pub pause_s: f64,
    /// A pilot's stick this far from where it was at engagement ends them, 0.01 to 0.5.
    pub dead_band: f64,
    /// Bounds of what is flown.
    pub limits: ExcitationLimits,
}

impl ExcitationProgramme {
    /// As many test inputs a programme may have.
    pub const MOST: usize = 16;

    /// Whether every input can be flown.
    ///
    /// # Errors
    /// The first number that is out of range.
    pub fn check(&self) -> Result<(), ExcitationError> {
        within("first_s", self.first_s, 2.0, 600.0, "2 to 600 s")?;
        within("pause_s", self.pause_s, 1.0, 600.0, "1 to 600 s")?;
        within("dead_band", self.dead_band, 0.01, 0.5, "0.01 to 0.5")?;
        self.limits.check()?;
        self.inputs.iter().flatten().try_for_each(|input| {
            let excitation = self.excitation(input);
            let sticks = excitation.direction.to_array().iter().sum();
            within("stick", sticks, 1.0, 1.0, "one of the four sticks, not the throttle")?;
            excitation.check()
        })
    }

    fn excitation(&self, input: &TestInput) -> Excitation {
        let one = |channel| f64::from(u8::from(input.stick == channel));
        let direction = Sticks {
            lateral: one(Channel::Lateral),
            longitudinal: one(Channel::Longitudinal),
            collective: one(Channel::Collective),
            pedal: one(Channel::Pedal),
        };
        Excitation { direction, maneuver: input.maneuver, limits: self.limits }
    }
}

/// What became of a programme in a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProgrammeChange {
    /// An input begins.
    Begins {
        /// Which, counted from 1.
        number: u8,
        /// The stick that is moved.
        stick: Channel,
    },
    /// All have been flown.
    Done,
    /// No more are flown until the autopilot takes over again.
    Ended(ExcitationAbort),
}

impl fmt::Display for ProgrammeChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Begins { number, stick } => write!(f, "test input {number}: {}", stick.name()),
            Self::Done => f.write_str("all test inputs are flown"),
            Self::Ended(why) => write!(f, "no more test inputs: {why}"),
        }
    }
}

/// How far a programme is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    /// The autopilot does not fly, or the programme has ended.
    Off,
    /// The next begins in so many seconds.
    Waits(f64),
    /// The next is under way.
    Flies,
}

/// A programme as it is flown.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProgrammeFlight {
    programme: ExcitationProgramme,
    stage: Stage,
    next: usize,
    /// Where the pilot's sticks were at engagement.
    neutral: Sticks,
}

impl ProgrammeFlight {
    pub const fn new(programme: ExcitationProgramme) -> Self {
        Self { programme, stage: Stage::Off, next: 0, neutral: Sticks::NEUTRAL }
    }

    /// The autopilot takes over with the pilot's sticks here.
    pub const fn engage(&mut self, neutral: Sticks) {
        (self.stage, self.next) = (Stage::Waits(self.programme.first_s), 0);
        self.neutral = neutral;
    }

    /// Before a step of the autopilot, `elapsed_s` after the one before. `may_go_on` is whether nothing but
    /// the pilot's sticks speaks against it.
    pub fn step(
        &mut self,
        autopilot: &mut HoverAutopilot<impl Scalar>,
        pilot: Option<Sticks>,
        may_go_on: bool,
        elapsed_s: f64,
    ) -> Option<ProgrammeChange> {
        if self.stage == Stage::Off {
            return None;
        }
        // Written so that NaN is a stick moved.
        let still = |pilot: Sticks| pilot.farthest_from(self.neutral) <= self.programme.dead_band;
        if !may_go_on || !pilot.is_some_and(still) {
            autopilot.end_excitation();
            let why = if may_go_on { ExcitationAbort::Stick } else { ExcitationAbort::Mode };
            return self.end(why);
        }
        let Some(input) = self.programme.inputs.get(self.next).copied().flatten() else {
            self.stage = Stage::Off;
            return Some(ProgrammeChange::Done);
        };
        match self.stage {
            Stage::Waits(left_s) if left_s > elapsed_s => {
                self.stage = Stage::Waits(left_s - elapsed_s);
            }
            // Refused while velocity is not held: it waits on.
            Stage::Waits(_) if autopilot.excite(self.programme.excitation(&input)).is_ok() => {
                self.stage = Stage::Flies;
                let number = u8::try_from(self.next + 1).unwrap_or(u8::MAX);
                return Some(ProgrammeChange::Begins { number, stick: input.stick });
            }
            Stage::Flies if !autopilot.is_excited() => {
                (self.stage, self.next) = (Stage::Waits(self.programme.pause_s), self.next + 1);
            }
            _ => {}
        }
        None
    }

    /// Ends it; the autopilot ended its input, or was switched off.
    pub fn end(&mut self, why: ExcitationAbort) -> Option<ProgrammeChange> {
        let before = core::mem::replace(&mut self.stage, Stage::Off);
        (before != Stage::Off).then_some(ProgrammeChange::Ended(why))
    }
}
