//! Evaluation of a rejection: which side is at fault, the time until a reopening, and the reopened states.

use super::super::config::GateConfig;
use super::{DISPUTED_MOST_S, Gate, Gates, Group, HEADING_S, JUMP_M, JUMP_MPS, LEVEL_S, Reopening};
use crate::time::Time;

/// Fewest rejections before a reopening, at any spacing in time.
const LEAST_REFUSALS: u8 = 3;
/// Time, s, for which the filter is suspect after its velocity was reopened.
const LOST_S: f64 = super::DOUBT_S;
/// Largest spread of a filter that had not diverged before the first rejection.
const DIVERGING: f32 = 4.0;
/// Growth factor of a position innovation without a reported velocity that shows a diverged filter.
const GROWN: f32 = 2.0;

/// Evidence for and against the filter when a measurement is rejected.
#[derive(Clone, Copy, Debug)]
struct Evidence {
    /// A barometer agrees with the filter, so the receiver's height is wrong.
    witness: bool,
    /// The level of the agreeing barometer came from this receiver, and the height has a constant offset.
    level_disputed: bool,
    /// A velocity was reopened recently.
    was_lost: bool,
    /// The samples had trouble, or the heading is unconfirmed, or a velocity was reopened.
    doubted: bool,
    /// For a position: the receiver's velocity agrees with the filter.
    velocity_agrees: bool,
    /// A position from a receiver that does not report its velocity.
    alone: bool,
    /// For a heading: another source confirms the filter's own.
    borne_out: bool,
    /// For a position: it may be at the second hypothesis again.
    back: bool,
}

impl Gates {
    /// Notes a rejection. `off` is the size of the innovation, and for a [height](Group::is_height) its one-sigma.
    /// Returns the states to reopen, if any.
    pub fn refused(
        &mut self,
        group: Group,
        time: Time,
        off: [f64; 2],
        config: &GateConfig,
    ) -> Option<Reopening> {
        let evidence = self.evidence(group, time, off, config);
        let told_s = match group {
            Group::HorizontalPosition => self.place_taken_s,
            Group::VerticalPosition => self.height_taken_s,
            _ => 0.0,
        };
        let denied = (evidence.witness && !evidence.level_disputed)
            || self.contradiction.forbids_reset(group);
        let gate = self.gates.get_mut(group as usize)?;
        gate.refuse(group, time, off[0], &evidence);
        let patience_s = gate.patience_s(group, off[0], f64::from(told_s), &evidence, config);
        let reopens = !denied && gate.refusals >= LEAST_REFUSALS && time - gate.since >= patience_s;
        if !reopens {
            return None;
        }
        let lost_s = time - if gate.was_open { gate.accepted } else { gate.since };
        gate.reopen(group, time, off[0], told_s, &evidence);
        match group {
            Group::VerticalPosition => self.height_taken_s = 0.0,
            Group::HorizontalPosition => {
                self.place_taken_s = 0.0;
                self.forget_walk();
            }
            _ => {}
        }
        if evidence.alone || matches!(group, Group::HorizontalVelocity | Group::VerticalVelocity) {
            // A filter that diverged in velocity has diverged in position too.
            self.lost_until = time + LOST_S;
        }
        Some(if evidence.alone { Reopening::Motion { lost_s } } else { Reopening::State })
    }

    /// Notes that the filter may have diverged in position: a position that it rejects is right.
    pub fn lose_position(&mut self, time: Time) {
        self.lost_until = time + LOST_S;
    }

    fn evidence(
        &mut self,
        group: Group,
        time: Time,
        off: [f64; 2],
        config: &GateConfig,
    ) -> Evidence {
        let witness = matches!(group, Group::VerticalPosition | Group::VerticalVelocity)
            && self.barometer_agrees(time);
        let was_lost = self.were_reopened(time);
        Evidence {
            witness,
            level_disputed: witness
                && group == Group::VerticalPosition
                && self.is_level_disputed(time, off, config),
            was_lost,
            doubted: was_lost || self.doubts_filter(time) || time < self.unproven_until,
            velocity_agrees: match group {
                // A single rejected velocity among accepted ones is no disagreement.
                Group::HorizontalPosition => self.was_open_lately(Group::HorizontalVelocity, time),
                // A biased vertical velocity follows the height.
                Group::VerticalPosition => self.agrees(Group::VerticalVelocity, time),
                _ => false,
            },
            alone: self.tells_motion_alone(group, time),
            borne_out: self.is_heading_borne_out(group, time),
            back: self.may_be_back(group, off[0], config),
        }
    }

    /// Whether a position lies within reach of the second hypothesis.
    fn may_be_back(&self, group: Group, off_m: f64, config: &GateConfig) -> bool {
        let disputed_m = self.gates.get(group as usize).map_or(0.0, |gate| gate.disputed_m);
        off_m.abs() <= config.sigmas * f64::from(disputed_m)
    }

    /// Whether a group is a position of a receiver that does not report its velocity.
    fn tells_motion_alone(&self, group: Group, time: Time) -> bool {
        let velocity = match group {
            Group::HorizontalPosition => Group::HorizontalVelocity,
            Group::VerticalPosition => Group::VerticalVelocity,
            _ => return false,
        };
        self.is_absent(velocity, time)
    }

    /// Whether a height that disagrees with a barometer keeps the offset from the start of its rejection. Then only the
    /// barometer's level is ambiguous, not the motion. If the offset changes, the rejection starts again.
    fn is_level_disputed(
        &mut self,
        time: Time,
        [off_m, sigma_m]: [f64; 2],
        config: &GateConfig,
    ) -> bool {
        let moves = !self.is_open(Group::VerticalVelocity, time);
        let Some(gate) = self.gates.get_mut(Group::VerticalPosition as usize) else { return false };
        let moved_m = off_m - f64::from(self.height_off_m);
        let is_steady = moved_m.abs() <= config.sigmas * sigma_m;
        if gate.refusals == 0 || !is_steady {
            self.height_off_m = off_m as f32;
            gate.since = time;
        }
        is_steady && !moves
    }
}

impl Gate {
    /// Counts a rejection, and decides at the first one which side is at fault.
    fn refuse(&mut self, group: Group, time: Time, off: f64, evidence: &Evidence) {
        if evidence.borne_out {
            self.since = time;
        }
        if self.refusals == 0 {
            let was_open_lately = self.was_open_lately(time);
            // No trouble of the filter makes a position jump while the velocity agrees.
            let reach_m = JUMP_M + JUMP_MPS * (time - self.accepted);
            let jumped = group == Group::HorizontalPosition
                && evidence.velocity_agrees
                && was_open_lately
                && off.abs() > reach_m;
            self.since = time;
            if group == Group::HorizontalPosition {
                self.lean = off as f32;
            }
            let may_be_lost = evidence.doubted || !was_open_lately || self.spread > DIVERGING;
            self.filter_is_lost = if jumped { evidence.was_lost } else { may_be_lost };
        }
        self.refusals = self.refusals.saturating_add(1);
        self.filter_is_lost |= evidence.was_lost || (evidence.doubted && !evidence.velocity_agrees);
    }

    /// Time, s, for which the filter rejects a measurement with innovation `off`, where the filter's own value was
    /// reported for `told_s`.
    fn patience_s(
        &self,
        group: Group,
        off: f64,
        told_s: f64,
        evidence: &Evidence,
        config: &GateConfig,
    ) -> f64 {
        match group {
            Group::Heading | Group::BaselineHeading => HEADING_S,
            // A distance that jumped and stays comes from other ground.
            Group::Range => config.recovery_s,
            _ if evidence.back => config.recovery_s,
            _ if evidence.witness => told_s.min(LEVEL_S).max(config.fault_s),
            _ if self.filter_is_lost => config.recovery_s,
            // A position that jumped keeps a constant offset; a diverged filter moves away from it.
            Group::HorizontalPosition if evidence.alone && off > f64::from(GROWN * self.lean) => {
                config.recovery_s
            }
            // A position from a few fixes is no more certain than the same number of fixes against it.
            Group::HorizontalPosition if evidence.velocity_agrees => {
                config.fault_s.min(told_s.max(config.recovery_s))
            }
            _ if evidence.velocity_agrees => config.fault_s,
            _ => config.lockout_s,
        }
    }

    /// Reopens at a measurement with innovation `off`. A position may have no other evidence than its repetition. Then
    /// the previous position stays a second hypothesis for as long as it was reported.
    fn reopen(&mut self, group: Group, time: Time, off: f64, told_s: f32, evidence: &Evidence) {
        let off_m = off.abs() as f32;
        let is_place = matches!(group, Group::HorizontalPosition | Group::VerticalPosition);
        let told_s = told_s.clamp(1.0, DISPUTED_MOST_S) as u8;
        let (disputed_m, disputed_s) = if evidence.back && self.disputed_m > 0.0 {
            // The fix may be at the previous position or at a third one: only the size of the offset is stored.
            (self.disputed_m.max(off_m), self.disputed_s)
        } else if is_place && (evidence.level_disputed || evidence.back || !self.filter_is_lost) {
            (off_m, told_s)
        } else {
            (0.0, 0)
        };
        *self = Self { accepted: time, was_open: true, disputed_m, disputed_s, ..Self::NONE };
    }
}
