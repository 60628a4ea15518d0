//! Gates, and the choice between sensor and filter when a gate stays closed.
//!
//! A gate rejects a bad fix. A diverged filter rejects *every* fix, and drifts without end. The circumstances of the
//! first rejections distinguish the two cases:
//!
//! - Positions agreed until one jumped away from the inertial path, and the velocity still agrees without bias.
//!   The sensor is at fault, even after a gap or clipping of the inertial samples: neither a vehicle nor a filter moves
//!   like that. Positions are rejected for [`GateConfig::fault_s`](crate::ekf::GateConfig::fault_s). The time is shorter if
//!   fixes at the filter's position were fused for less time.
//! - Fixes disagree after an absence, after a gap or clipping of the inertial samples, or after a series of large
//!   innovations. The filter has diverged. It is reset to the measurement after
//!   [`GateConfig::recovery_s`](crate::ekf::GateConfig::recovery_s) and three rejected fixes.
//! - Velocity jumped more than any acceleration explains: the receiver is at fault. It resets nothing until its
//!   velocity agrees again, for at most 15 s.
//! - The receiver contradicts itself in successive readings: it resets nothing. Its fixes are rejected, except a fix
//!   that agrees with the filter in all axes within the noise of the fix.
//! - The innovations of a height are biased for seconds, and the other height sensor, receiver or barometer, agrees
//!   with the filter. The sensor with the biased innovations drifts. It is rejected although each single innovation
//!   lies within the gate.
//! - A distance to the ground jumped: a roof, a tree or a false reading. It is rejected for
//!   [`GateConfig::recovery_s`](crate::ekf::GateConfig::recovery_s), then attributed to other ground, never to height.
//! - A barometer disagrees with a height by a constant amount, while both agree about each change of height.
//!   The barometer's level came from earlier heights of this receiver. Either these or the present height are wrong.
//!   The filter uses the height that was reported for longer.
//! - In all other cases the fault is unknown, and the filter is reset to the measurement after
//!   [`GateConfig::lockout_s`](crate::ekf::GateConfig::lockout_s) of rejections. A height is not accepted while a barometer
//!   disagrees with it. A heading is accepted only after two minutes without confirmation of the filter's own heading
//!   by fixes or another sensor.
//!
//! A position may be accepted without other evidence. Then the previous position stays a second hypothesis. It decays
//! with the time for which it had been reported as time constant. The one-sigma of the solution reaches back to it, and
//! three fixes that return to it are accepted. If positions drift away from the receiver's own velocity, too slowly for
//! a gate, the one-sigma reaches back to the start of the drift.
//!
//! A reset to the measurement ("reopening") widens the covariance by the size of the innovation and keeps the
//! correlations. Both hypotheses then lie within it. Then the fix is fused. The report is always
//! [`Verdict::Reset`](crate::ekf::Verdict::Reset).

mod position_drift;
mod previous;
mod rejection;

use crate::ekf::outcome::group::Group;
use crate::ekf::watch::BETWEEN_FIXES_S;
use crate::matrix::square;
use crate::time::Time;
pub(super) use position_drift::PositionDrift;
use previous::Previous;

/// States that are reset to a measurement that was rejected for too long.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reopening {
    /// The measured state.
    State,
    /// Position and velocity, for a receiver that reports no velocity. The position was not fused for `lost_s`, s.
    Motion { lost_s: f64 },
}

/// Innovation of a group.
#[derive(Clone, Copy, Debug)]
pub(super) struct Off {
    /// Innovation of the first two axes; zero for a missing one.
    pub axes: [f64; 2],
    /// Variance of the innovation of the first axis.
    pub variance: f64,
}

impl Off {
    /// One-sigma of the first axis.
    fn sigma(&self) -> f64 {
        libm::sqrt(self.variance)
    }

    /// Length of the innovation.
    fn size(&self) -> f64 {
        let [first, second] = self.axes;
        libm::sqrt(square(first) + square(second))
    }

    /// The axes in single precision.
    fn single(&self) -> [f32; 2] {
        self.axes.map(|axis| axis as f32)
    }
}

/// Evidence against the receiver from its successive fixes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contradiction {
    /// The receiver may contradict itself: the filter is not reset to its fixes.
    pub suspected: bool,
    /// The receiver contradicts itself: its fixes are rejected.
    pub proven: bool,
}

impl Contradiction {
    const NONE: Self = Self { suspected: false, proven: false };
}

/// State of the gates of all groups.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gates {
    gates: [Gate; Group::COUNT],
    /// Time of the last gap or clipping of the inertial samples: the filter is suspect after it.
    pub suspected: Time,
    /// Time of the last sign that the filter's velocity has diverged: a reset to a velocity, or to a position without
    /// velocity.
    pub velocity_diverged: Time,
    /// Time at which the heading was found or replaced. If fixes disagree in the time after it, the heading is wrong.
    pub heading_replaced: Time,
    /// Horizontal position and height of the fixes.
    places: [Place; 2],
    pub drift: PositionDrift,
    /// Means of recent normalised innovations of the [heights](Group::height), which show their bias.
    height_bias_sigmas: [f32; Group::HEIGHTS],
    pub contradiction: Contradiction,
    /// Whether the last reading of the barometer disagrees with the filter's height.
    pub baro_disagrees: bool,
    /// Whether the filter's heading is consistent with recent fixes.
    pub heading_is_consistent: bool,
}

/// Horizontal position or height of the fixes.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// Time for which fixes of this position or height were fused, s, since the fix that made it known.
    fused_s: f32,
    /// Innovation at the first rejection of the present series, m.
    first_off_m: f32,
    /// Second hypothesis.
    previous: Previous,
}

impl Place {
    const NONE: Self = Self { fused_s: 0.0, first_off_m: 0.0, previous: Previous::NONE };
}

#[derive(Clone, Copy, Debug)]
struct Gate {
    /// Time of the last accepted measurement, if any.
    accepted: Time,
    /// Start of the present series of rejections.
    since: Time,
    /// Mean square of recent normalised innovations; 1 if filter and sensor are consistent.
    spread: f32,
    /// Number of successive rejections; zero while the gate is open.
    rejections: u8,
    /// Whether the present rejections count as errors of a diverged filter.
    filter_has_diverged: bool,
}

impl Gate {
    const NONE: Self = Self {
        accepted: Time::NEVER,
        since: Time::NEVER,
        spread: 0.0,
        rejections: 0,
        filter_has_diverged: false,
    };

    /// Whether the gate has ever been open.
    fn has_accepted(&self) -> bool {
        self.accepted != Time::NEVER
    }

    /// Whether the gate was open within the last [`ABSENCE_S`].
    fn has_accepted_lately(&self, time: Time) -> bool {
        time - self.accepted <= ABSENCE_S
    }
}

/// Time without a measurement, s, after which the filter's error is unbounded.
const ABSENCE_S: f64 = 2.5;
/// Time, s, for which the filter stays suspect after a gap, clipping, or a reset of its velocity.
const SUSPECT_TIME_S: f64 = 10.0;
/// Time, s, for which a found or replaced heading counts as unconfirmed.
const UNCONFIRMED_S: f64 = 60.0;
/// Weight of the newest innovation in the spread.
const NEWEST: f32 = 0.2;
/// Mean innovation, in one-sigmas, above which innovations count as biased: chance does not explain it. Below half of
/// it, they are unbiased.
const BIASED_SIGMAS: f32 = 1.5;
/// Bound on each innovation that enters the mean, one-sigmas.
const MAX_BIAS_SIGMAS: f32 = 5.0;
/// Minimum number of rejections before a reset to the measurement, at any measurement rate.
const MIN_REJECTIONS: u8 = 3;
/// Time constant of the mean innovation, s, for frequent innovations.
const BIAS_TIME_S: f64 = 2.0;
/// Largest position innovation with a correct filter velocity, m, right after an accepted fix. A larger innovation is a
/// jump.
const JUMP_M: f64 = 5.0;
/// Growth rate of the limit [`JUMP_M`], m/s, with the time since the last accepted fix.
const JUMP_MPS: f64 = 10.0;
/// Longest time of rejections, s, after which a heading is accepted, or a height with a constant offset from a
/// barometer. The latter time is shorter if the previous height was fused for less time.
const LONGEST_S: f64 = 120.0;
/// Fused time, s, after which a position counts as settled.
const SETTLED_S: f32 = 5.0;

impl Gates {
    /// Gates before the first measurement.
    pub const NONE: Self = Self {
        gates: [Gate::NONE; Group::COUNT],
        suspected: Time::NEVER,
        velocity_diverged: Time::NEVER,
        heading_replaced: Time::NEVER,
        places: [Place::NONE; 2],
        drift: PositionDrift::NONE,
        height_bias_sigmas: [0.0; Group::HEIGHTS],
        contradiction: Contradiction::NONE,
        baro_disagrees: false,
        heading_is_consistent: false,
    };

    /// Whether inertial samples were missing or clipped lately. Rejections then count as errors of the filter, not of
    /// the sensors.
    pub fn is_filter_suspect(&self, time: Time) -> bool {
        time - self.suspected < SUSPECT_TIME_S
    }

    /// Whether the filter's velocity was recently reset, or has probably diverged. After such a reset, innovations keep
    /// one sign for some seconds.
    pub fn has_velocity_diverged(&self, time: Time) -> bool {
        time - self.velocity_diverged < SUSPECT_TIME_S
    }

    /// Whether other evidence confirms the filter's heading when a heading of `group` is rejected. The evidence is the
    /// fixes or the other source: own attitude and magnetometer, or two antennas.
    fn is_heading_confirmed(&self, group: Group, time: Time) -> bool {
        let other = match group {
            Group::Heading => Group::BaselineHeading,
            Group::BaselineHeading => Group::Heading,
            _ => return false,
        };
        let by_fixes = self.heading_is_consistent && !self.lack_fixes(time);
        by_fixes || self.is_open(other, time)
    }

    /// Notes an innovation of a [height](Group::is_height) and its one-sigma. Returns whether such innovations are
    /// biased beyond chance while the other height sensor agrees with the filter. Of receiver and barometer, the sensor
    /// whose innovations become biased first is the one that drifts.
    pub fn is_biased(&mut self, group: Group, time: Time, off: &Off) -> bool {
        let [innovation, _] = off.axes;
        let normalised = innovation / off.sigma();
        let newest = NEWEST.min((self.since_accepted_s(group, time) / BIAS_TIME_S) as f32);
        let Some(bias) = self.height_bias_mut(group) else { return false };
        *bias += newest * ((normalised as f32).clamp(-MAX_BIAS_SIGMAS, MAX_BIAS_SIGMAS) - *bias);
        let is_biased = bias.abs() > BIASED_SIGMAS;
        is_biased
            && match group {
                Group::VerticalPosition | Group::VerticalVelocity => self.agrees(Group::Baro, time),
                Group::Baro => [Group::VerticalPosition, Group::VerticalVelocity]
                    .into_iter()
                    .all(|group| self.agrees(group, time)),
                _ => false,
            }
    }

    /// Mean of recent normalised innovations of a height.
    fn height_bias_mut(&mut self, group: Group) -> Option<&mut f32> {
        self.height_bias_sigmas.get_mut(group.height()?)
    }

    /// The gate of a group; a closed one for [`Group::Own`].
    fn gate(&self, group: Group) -> &Gate {
        self.gates.get(group as usize).unwrap_or(&Gate::NONE)
    }

    /// Whether a group is open and its innovations are unbiased. For the barometer, the last reading must also agree
    /// with the filter's height.
    // Not inlined: its copies would take 1.4 kB of a microcontroller's program.
    #[inline(never)]
    pub fn agrees(&self, group: Group, time: Time) -> bool {
        let bias = group.height().and_then(|height| self.height_bias_sigmas.get(height));
        let is_biased = bias.is_some_and(|bias| bias.abs() > 0.5 * BIASED_SIGMAS);
        let denies = group == Group::Baro && self.baro_disagrees;
        self.is_open(group, time) && !(is_biased || denies)
    }

    /// Notes an acceptance with innovation `off`; `spread` is the mean of the squared normalised innovations. A position
    /// may be accepted after rejections only because the filter has become less certain. Then the filter's position
    /// becomes the second hypothesis.
    pub fn accepted(&mut self, group: Group, time: Time, off: &Off, spread: f64) {
        let Some(gate) = self.gates.get_mut(group as usize) else { return };
        let since_s = (time - gate.accepted).clamp(0.0, BETWEEN_FIXES_S) as f32;
        let (has_accepted, rejections) = (gate.has_accepted(), gate.rejections);
        gate.accepted = time;
        gate.rejections = 0;
        gate.spread += NEWEST * (spread as f32 - gate.spread);
        let Some(place) = self.place(group) else { return };
        place.previous.forget(since_s);
        if rejections >= MIN_REJECTIONS {
            place.previous.leave(off.single(), place.fused_s, false);
        }
        if !has_accepted {
            return;
        }
        place.fused_s += since_s;
        let fused_s = place.fused_s;
        if group == Group::HorizontalPosition {
            self.drift.forget(since_s, fused_s);
        }
    }

    /// Accounts for the shift, m, north, east and down, by which a fix has moved the expected position of the next fix.
    /// The second hypotheses keep their position; only their offsets from the expected position change.
    pub fn shift_position(&mut self, [north_m, east_m, down_m]: [f32; 3]) {
        let [level, vertical] = &mut self.places;
        level.previous.shift([north_m, east_m]);
        vertical.previous.shift([down_m, 0.0]);
    }

    /// Adds the shift `moved_m`, m, north and east, of the expected position by a fix, and detects a drift of positions
    /// away from their velocity. A drift begins when the sum of the shifts exceeds `least_m`; only shifts during fused
    /// velocities count. It ends when the sum falls below half of `least_m`. During the drift, the position at its
    /// start is a second hypothesis. Returns the drift, m; zero without a drift.
    ///
    /// # Source
    /// Equation (K25) of docs/equations.md.
    pub fn observe_position_shift(&mut self, time: Time, moved_m: [f32; 2], least_m: f32) -> f32 {
        let tells_motion = self.is_open(Group::HorizontalVelocity, time);
        let is_sure = !(self.is_filter_suspect(time) || self.has_velocity_diverged(time));
        let [place, _] = &mut self.places;
        if place.fused_s < SETTLED_S {
            self.drift = PositionDrift::NONE;
            return 0.0;
        }
        if tells_motion && is_sure {
            self.drift.add(moved_m);
        }
        self.drift.judge(least_m);
        let drifted_m = self.drift.drifted_m();
        if drifted_m > 0.0 {
            place.previous.keep(self.drift.start_offset_m(), place.fused_s, false);
        }
        drifted_m
    }

    /// Distances, m, horizontal and vertical, to a previous position and height. Each is multiplied by the weight, 0 to
    /// 1, of that hypothesis.
    pub fn ambiguity_m(&self) -> [f32; 2] {
        self.places.map(|place| place.previous.ambiguity_m())
    }

    /// The position or height of a group of a fix.
    fn place(&mut self, group: Group) -> Option<&mut Place> {
        let [level, vertical] = &mut self.places;
        match group {
            Group::HorizontalPosition => Some(level),
            Group::VerticalPosition => Some(vertical),
            _ => None,
        }
    }

    /// Stores a rejected position as the second hypothesis, if no fix was accepted before. Either the position at the
    /// start or the fix may be right.
    pub fn note_rejected_position(&mut self, group: Group, off: &Off) {
        let has_accepted = self.gate(group).has_accepted();
        if let Some(place) = self.place(group).filter(|_| !has_accepted) {
            place.previous.keep(off.single(), 1.0, true);
        }
    }

    /// Drops the second hypothesis of a position to which the filter was reset.
    pub fn forget_previous(&mut self, group: Group) {
        if let Some(place) = self.place(group) {
            place.previous = Previous::NONE;
        }
    }

    /// Resets the time for which positions were fused: the position counts as unknown until the next fix.
    pub fn forget_position(&mut self) {
        let [place, _] = &mut self.places;
        place.fused_s = 0.0;
    }

    /// Whether a group was accepted at its last measurement, within the last [`ABSENCE_S`].
    pub fn is_open(&self, group: Group, time: Time) -> bool {
        let gate = self.gate(group);
        gate.rejections == 0 && gate.has_accepted_lately(time)
    }

    /// How long ago a group was last accepted, s.
    pub fn since_accepted_s(&self, group: Group, time: Time) -> f64 {
        time - self.gate(group).accepted
    }

    /// Whether a group has no recent measurement, neither accepted nor rejected.
    pub fn is_absent(&self, group: Group, time: Time) -> bool {
        let gate = self.gate(group);
        gate.rejections == 0 && !gate.has_accepted_lately(time)
    }

    /// Whether the last accepted fix is too old to bound the filter's error.
    pub fn lack_fixes(&self, time: Time) -> bool {
        self.gates.iter().take(Group::GPS).all(|gate| !gate.has_accepted_lately(time))
    }
}

#[cfg(test)]
mod tests;
