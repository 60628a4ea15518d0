//! Evaluation of a rejection. It decides whether sensor or filter is at fault, the time until a reset to the
//! measurement, and the states to reset.

use super::previous::Previous;
use super::{
    Gate, Gates, JUMP_M, JUMP_MPS, LONGEST_S, MIN_REJECTIONS, Off, PositionDrift, Reopening,
    UNCONFIRMED_S,
};
use crate::ekf::outcome::group::Group;
use crate::ekf::settings::config::GateConfig;
use crate::time::Time;

/// Largest spread of a filter that had not diverged before the first rejection.
const DIVERGING: f32 = 4.0;
/// Growth factor of a position innovation since its first rejection, above which the filter counts as diverged. Applies
/// to receivers that do not report velocity.
const GROWN: f32 = 2.0;

/// Evidence for and against the filter when a measurement is rejected.
#[derive(Clone, Copy, Debug)]
struct Evidence {
    /// The measurement is wrong: a barometer agrees with the filter, or the receiver contradicts itself.
    forbids_reset: bool,
    /// The rejected height has a constant offset, and the receiver's vertical velocity is accepted. The barometer's
    /// level, set from this receiver, may then be wrong.
    baro_level_is_ambiguous: bool,
    /// The filter's velocity was recently reset, or has probably diverged.
    velocity_was_reset: bool,
    /// Inertial samples were missing or clipped, the heading is unconfirmed, or `velocity_was_reset`.
    suspect: bool,
    /// Positions only: the receiver's velocity agrees with the filter's velocity.
    velocity_agrees: bool,
    /// Positions only: the receiver does not report its velocity.
    without_velocity: bool,
    /// Horizontal position without reported velocity: the innovation has grown since the first rejection.
    grows: bool,
    /// Headings only: another source confirms the filter's heading.
    is_confirmed: bool,
    /// Positions only: the fix is at the second hypothesis.
    is_at_previous: bool,
}

impl Gates {
    /// Notes a rejection. Returns the states to reset to the measurement, if any.
    pub fn note_rejection(
        &mut self,
        group: Group,
        time: Time,
        off: &Off,
        config: &GateConfig,
    ) -> Option<Reopening> {
        let evidence = self.evidence(group, time, off, config);
        let reported_s = self.place(group).map_or(0.0, |place| place.fused_s);
        let gate = self.gates.get_mut(group as usize)?;
        gate.count_rejection(time, off.size(), &evidence);
        let rejection_time_s =
            gate.rejection_time_s(group, f64::from(reported_s), &evidence, config);
        let reopens = !evidence.forbids_reset
            && gate.rejections >= MIN_REJECTIONS
            && time - gate.since >= rejection_time_s;
        if !reopens {
            return None;
        }
        let lost_s = time - if gate.has_accepted() { gate.accepted } else { gate.since };
        let filter_had_diverged = gate.filter_has_diverged;
        *gate = Gate { accepted: time, ..Gate::NONE };
        if let Some(bias) = self.height_bias_mut(group) {
            *bias = 0.0;
        }
        if let Some(place) = self.place(group) {
            place.fused_s = 0.0;
            if filter_had_diverged && !evidence.baro_level_is_ambiguous && !evidence.is_at_previous
            {
                place.previous = Previous::NONE;
            } else {
                place.previous.leave(off.single(), reported_s, true);
            }
        }
        if group == Group::HorizontalPosition {
            self.drift = PositionDrift::NONE;
        }
        if evidence.without_velocity
            || matches!(group, Group::HorizontalVelocity | Group::VerticalVelocity)
        {
            // A filter that diverged in velocity has diverged in position too.
            self.velocity_diverged = time;
        }
        Some(if evidence.without_velocity {
            Reopening::Motion { lost_s }
        } else {
            Reopening::State
        })
    }

    fn evidence(&mut self, group: Group, time: Time, off: &Off, config: &GateConfig) -> Evidence {
        let baro_agrees = matches!(group, Group::VerticalPosition | Group::VerticalVelocity)
            && self.agrees(Group::Baro, time);
        let baro_level_is_ambiguous = baro_agrees
            && group == Group::VerticalPosition
            && self.is_baro_level_ambiguous(time, off, config);
        let velocity_was_reset = self.has_velocity_diverged(time);
        let without_velocity = self.is_position_without_velocity(group, time);
        Evidence {
            forbids_reset: baro_agrees && !baro_level_is_ambiguous
                || self.contradiction.suspected && group.is_of_fix(),
            baro_level_is_ambiguous,
            velocity_was_reset,
            suspect: velocity_was_reset
                || self.is_filter_suspect(time)
                || time - self.heading_replaced < UNCONFIRMED_S,
            velocity_agrees: match group {
                // A single rejected velocity among accepted ones is no disagreement.
                Group::HorizontalPosition => {
                    self.gate(Group::HorizontalVelocity).has_accepted_lately(time)
                }
                // A biased vertical velocity follows the height.
                Group::VerticalPosition => self.agrees(Group::VerticalVelocity, time),
                _ => false,
            },
            without_velocity,
            grows: without_velocity && self.grows(group, off.size()),
            is_confirmed: self.is_heading_confirmed(group, time),
            is_at_previous: self.is_back(group, off, config),
        }
    }

    /// Whether the innovation of a horizontal position has grown since the first rejection. At the first rejection, it
    /// stores the innovation.
    fn grows(&mut self, group: Group, off_m: f64) -> bool {
        let is_first = self.gate(group).rejections == 0;
        let [place, _] = &mut self.places;
        if group != Group::HorizontalPosition {
            return false;
        }
        if is_first {
            place.first_off_m = off_m as f32;
        }
        off_m > f64::from(GROWN * place.first_off_m)
    }

    /// Whether a position lies at the second hypothesis.
    fn is_back(&mut self, group: Group, off: &Off, config: &GateConfig) -> bool {
        let limit_m = config.sigmas * off.sigma();
        self.place(group).is_some_and(|place| place.previous.is_at(off.axes, limit_m))
    }

    /// Whether a group is a position of a receiver that does not report its velocity.
    fn is_position_without_velocity(&self, group: Group, time: Time) -> bool {
        let velocity = match group {
            Group::HorizontalPosition => Group::HorizontalVelocity,
            Group::VerticalPosition => Group::VerticalVelocity,
            _ => return false,
        };
        self.is_absent(velocity, time)
    }

    /// Whether a height that disagrees with a barometer keeps the offset from the start of its rejection. Then only the
    /// barometer's level is ambiguous, not the motion. If the offset changes, the rejection starts again.
    fn is_baro_level_ambiguous(&mut self, time: Time, off: &Off, config: &GateConfig) -> bool {
        let moves = !self.is_open(Group::VerticalVelocity, time);
        let Some(gate) = self.gates.get_mut(Group::VerticalPosition as usize) else { return false };
        let [_, height] = &mut self.places;
        let [off_m, _] = off.axes;
        let moved_m = off_m - f64::from(height.first_off_m);
        let is_steady = moved_m.abs() <= config.sigmas * off.sigma();
        if gate.rejections == 0 || !is_steady {
            height.first_off_m = off_m as f32;
            gate.since = time;
        }
        is_steady && !moves
    }
}

impl Gate {
    /// Counts a rejection. At the first one, decides whether filter or sensor is at fault.
    fn count_rejection(&mut self, time: Time, off: f64, evidence: &Evidence) {
        if evidence.is_confirmed {
            self.since = time;
        }
        if self.rejections == 0 {
            let has_accepted_lately = self.has_accepted_lately(time);
            // No divergence of the filter makes a position jump while the velocity agrees.
            let reach_m = JUMP_M + JUMP_MPS * (time - self.accepted);
            let jumped = evidence.velocity_agrees && has_accepted_lately && off.abs() > reach_m;
            self.since = time;
            let may_be_lost = evidence.suspect || !has_accepted_lately || self.spread > DIVERGING;
            self.filter_has_diverged = !jumped && may_be_lost;
        }
        self.rejections = self.rejections.saturating_add(1);
        self.filter_has_diverged |=
            evidence.velocity_was_reset || (evidence.suspect && !evidence.velocity_agrees);
    }

    /// Time, s, for which the filter rejects a measurement before it is reset to it. `reported_s` is the time, s, for
    /// which fixes at the filter's present position or height were fused.
    fn rejection_time_s(
        &self,
        group: Group,
        reported_s: f64,
        evidence: &Evidence,
        config: &GateConfig,
    ) -> f64 {
        match group {
            Group::Heading | Group::BaselineHeading => LONGEST_S,
            // A distance that jumped and stays comes from other ground.
            Group::Range => config.recovery_s,
            _ if evidence.is_at_previous => config.recovery_s,
            _ if evidence.baro_level_is_ambiguous => reported_s.min(LONGEST_S).max(config.fault_s),
            // A position that jumped keeps a constant offset; a diverged filter moves away from it.
            _ if self.filter_has_diverged || evidence.grows => config.recovery_s,
            // A position from a few fixes is no more certain than the same number of fixes against it.
            Group::HorizontalPosition if evidence.velocity_agrees => {
                config.fault_s.min(reported_s.max(config.recovery_s))
            }
            _ if evidence.velocity_agrees => config.fault_s,
            _ => config.lockout_s,
        }
    }
}
