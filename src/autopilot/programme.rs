//! A programme of test inputs, flown one after another while the autopilot holds.

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
    /// The manoeuvre.
    pub maneuver: Maneuver,
}

/// Test inputs for an identification flight. The first input begins [`first_s`](Self::first_s) after the autopilot took
/// over. Each further input begins [`pause_s`](Self::pause_s) after the end of the previous input.
///
/// The programme ends when a pilot's stick moves beyond the dead band or the pilot's signal is lost. It also ends at
/// the geofence, and when an input ends early: a limit is exceeded, or the autopilot does not hold velocity. Between
/// inputs the programme waits until the autopilot holds velocity. The next engagement of the autopilot starts the
/// programme again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExcitationProgramme {
    /// The test inputs in their order, up to the first `None`.
    pub inputs: [Option<TestInput>; Self::MAX],
    /// Time from engagement to the first input, s, 2 to 600.
    pub first_s: f64,
    /// Time between inputs, s, 1 to 600.
    pub pause_s: f64,
    /// Deflection of a pilot's stick from its position at engagement that ends the programme, 0.01 to 0.5.
    pub dead_band: f64,
    /// Limits that end an input early.
    pub limits: ExcitationLimits,
}

impl ExcitationProgramme {
    /// Largest number of test inputs in a programme.
    pub const MAX: usize = 16;

    /// Checks that the autopilot can fly every input.
    ///
    /// # Errors
    /// [`ExcitationError::Value`] with the first number that is out of range.
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

/// Change of a programme in a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProgrammeChange {
    /// An input begins.
    Begins {
        /// Number of the input, counted from 1.
        number: u8,
        /// The stick that is moved.
        stick: Channel,
    },
    /// All inputs have been flown.
    Done,
    /// The programme ended early: no further input until the autopilot takes over again.
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

/// Progress of a programme.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    /// The autopilot does not fly, or the programme has ended.
    Off,
    /// The next input begins after this time, s.
    Waits(f64),
    /// The next input is being flown.
    Flies,
}

/// A programme in flight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProgrammeFlight {
    programme: ExcitationProgramme,
    stage: Stage,
    next: usize,
    /// Positions of the pilot's sticks at engagement.
    neutral: Sticks,
}

impl ProgrammeFlight {
    pub const fn new(programme: ExcitationProgramme) -> Self {
        Self { programme, stage: Stage::Off, next: 0, neutral: Sticks::NEUTRAL }
    }

    /// Starts the programme at engagement; `neutral` are the pilot's sticks at that moment.
    pub const fn engage(&mut self, neutral: Sticks) {
        (self.stage, self.next) = (Stage::Waits(self.programme.first_s), 0);
        self.neutral = neutral;
    }

    /// Runs one step of the programme; call it before each step of the autopilot. `elapsed_s` is the time since the
    /// previous step. `may_go_on` is whether all conditions except those on the pilot's sticks are met.
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
        // Written so that NaN counts as a moved stick.
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
            // The autopilot rejects the input while it does not hold velocity: the programme waits.
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

    /// Ends the programme after an aborted input or a released switch.
    pub fn end(&mut self, why: ExcitationAbort) -> Option<ProgrammeChange> {
        let before = core::mem::replace(&mut self.stage, Stage::Off);
        (before != Stage::Off).then_some(ProgrammeChange::Ended(why))
    }
}
