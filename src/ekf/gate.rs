//! Gates, and which is at fault when one stays shut: the sensor or the filter.
//!
//! A gate keeps a bad fix out. A filter that has gone wrong keeps *every* fix out, and drifts for
//! ever. How the refusals began tells the two apart:
//!
//! - Positions agreed until one jumped away from the inertial path, and the velocity goes on agreeing and leans to no
//!   side: the sensor is at fault, even if the inertial samples had trouble, for no vehicle and no filter moves like
//!   that. Positions are refused for [`GateConfig::fault_s`](super::GateConfig::fault_s). Where the filter knew nothing
//!   of the place before its last series of fixes, they are refused for no longer than that series has lasted.
//! - Fixes disagree after an absence, after trouble with the inertial samples, or after a series of
//!   innovations that were too large already: the filter is lost. It is reopened as soon as
//!   [`GateConfig::recovery_s`](super::GateConfig::recovery_s) have passed and three fixes were refused.
//! - Velocity jumped as no acceleration explains: the receiver is at fault. It reopens nothing until its velocity is
//!   back, for at most 15 s.
//! - The receiver contradicts itself, reading after reading: it reopens nothing, and its fixes are rejected unless all
//!   of them lies at the filter.
//! - The innovations of a height lean to one side for seconds: those of the receiver while a barometer agrees with the
//!   filter, or those of a barometer while the receiver agrees. The sensor that leans drifts. It is refused although
//!   each single innovation lies within the gate.
//! - A distance to the ground jumped: a roof, a tree or a false reading. It is refused for
//!   [`GateConfig::recovery_s`](super::GateConfig::recovery_s), then taken for another ground, never for height.
//! - A barometer denies a height by always the same amount, while both agree about each change of it: the barometer's
//!   level came from this receiver, and one of the two heights was wrong. The one that was told for longer is believed.
//! - In all other cases nobody knows, and the filter gives way after
//!   [`GateConfig::lockout_s`](super::GateConfig::lockout_s) of refusals. A height is not believed while a barometer
//!   denies it. A heading is believed only after two minutes in which neither the fixes nor another sensor bore out the
//!   filter's own.
//!
//! Where a place is believed by its word alone, the one before stays in dispute for as long as it was told: the one-sigma of
//! the solution reaches back to it, and three fixes that return to it are believed. Where places walk away
//! from the receiver's own velocity, too slowly for a gate, the one-sigma reaches back to where the walk began.
//!
//! Reopening widens the covariance by the size of the innovation and keeps the correlations, so that both
//! answers lie within it; the fix is then taken. That is reported as
//! [`Verdict::Reopened`](super::Verdict::Reopened), never silent.

mod refusal;
mod walk;

use crate::time::Time;
use walk::Walk;

/// Kinds of measurement that are refused, and reopened, together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    HorizontalPosition,
    VerticalPosition,
    HorizontalVelocity,
    VerticalVelocity,
    Tilt,
    Heading,
    Baro,
    RestRate,
    RestVelocity,
    Range,
    BaselineHeading,
}

impl Group {
    const COUNT: usize = 11;
    /// The first so many are those of the GPS.
    const GPS: usize = 4;

    /// Whether it is one axis and tells height: what [`leans`](Gates::leans) is asked of.
    pub const fn is_height(self) -> bool {
        matches!(self, Self::VerticalPosition | Self::VerticalVelocity | Self::Baro)
    }
}

/// What a measurement that was refused for too long reopens.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reopening {
    /// The state that it measures.
    State,
    /// A position, and the velocity which the receiver does not tell: it was not taken in for so long, s.
    Motion { lost_s: f64 },
}

/// Evidence against the receiver from its successive fixes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contradiction {
    /// The receiver may contradict itself: its fixes reopen nothing.
    pub suspected: bool,
    /// The receiver contradicts itself: its fixes are rejected.
    pub proven: bool,
}

impl Contradiction {
    const NONE: Self = Self { suspected: false, proven: false };

    /// Whether a group must not reset anything.
    fn forbids_reset(self, group: Group) -> bool {
        self.suspected && (group as usize) < Group::GPS
    }
}

/// What each gate has seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gates {
    gates: [Gate; Group::COUNT],
    /// Until when trouble with the inertial samples puts the filter itself in doubt.
    doubted_until: Time,
    /// Until when a velocity that had to be reopened puts the filter in doubt.
    lost_until: Time,
    /// Until when a heading that was found or replaced has yet to prove itself.
    unproven_until: Time,
    /// For how long the receiver's height has been taken in, s.
    height_taken_s: f32,
    /// For how long the receiver's place has been taken in, s, since the fix that first made it known.
    place_taken_s: f32,
    walk: Walk,
    /// How far the receiver's height was off when its refusal began, m.
    height_off_m: f32,
    pub contradiction: Contradiction,
    /// Whether the barometer's last reading denied the filter's height.
    baro_denies: bool,
    /// Whether the fixes have borne out the filter's heading of late.
    heading_borne_out: bool,
}

#[derive(Clone, Copy, Debug)]
struct Gate {
    /// When it was last open, if it ever was.
    accepted: Time,
    /// When the refusals that count began.
    since: Time,
    /// Mean square of the normalised innovations of late; 1 where filter and sensor agree.
    spread: f32,
    /// Of a height: the mean of the normalised innovations of late, and so to which side they lean. Of a horizontal
    /// position that is refused: how far it was off at first, m.
    lean: f32,
    /// Of a position that was believed although nothing else speaks for it: how far off, m, the one before may still
    /// be right; zero where none is in dispute.
    disputed_m: f32,
    /// In how many seconds of being taken in that is forgotten: as many as the one before was told for.
    disputed_s: u8,
    /// Refusals in a row; zero while the gate is open.
    refusals: u8,
    /// Whether these refusals are the filter's own fault.
    filter_is_lost: bool,
    /// Whether it was ever open.
    was_open: bool,
}

impl Gate {
    const NONE: Self = Self {
        accepted: NEVER,
        since: NEVER,
        spread: 0.0,
        lean: 0.0,
        disputed_m: 0.0,
        disputed_s: 0,
        refusals: 0,
        filter_is_lost: false,
        was_open: false,
    };

    /// Whether it was open within the last [`ABSENCE_S`].
    fn was_open_lately(&self, time: Time) -> bool {
        self.was_open && time - self.accepted <= ABSENCE_S
    }

    /// Forgets of a dispute what `taken_s` more of being taken in leave of it.
    fn settle(&mut self, taken_s: f32) {
        if self.disputed_m > 0.0 {
            self.disputed_m *= (1.0 - taken_s / f32::from(self.disputed_s)).max(0.0);
            if self.disputed_m < DISPUTED_LEAST_M {
                self.disputed_m = 0.0;
            }
        }
    }
}

/// Without a measurement for this long, s, the filter may have gone anywhere.
const ABSENCE_S: f64 = 2.5;
/// Before every time there is.
pub(super) const NEVER: Time = Time::from_nanoseconds(i64::MIN);
/// A doubt of the filter explains a disagreement for this long, s.
const DOUBT_S: f64 = 10.0;
/// A heading that is found has proven itself after this, s.
const UNPROVEN_S: f64 = 60.0;
/// Weight of the newest innovation in the spread.
const NEWEST: f32 = 0.2;
/// Innovations whose mean is more one-sigmas than this lean to one side, and not by chance.
const LEANING: f32 = 1.5;
/// No single innovation counts for more one-sigmas than this in that mean.
const MOST_LEAN: f32 = 5.0;
/// Memory of that mean, s, where innovations come often.
const LEANING_S: f64 = 2.0;
/// Innovations whose mean is less than this lean to no side.
const UPRIGHT: f32 = 0.75;
/// Where the filter's velocity is right, a place is off by no more than this, m, and this for each second since the last
/// fix, m/s: one that is further off has jumped.
const JUMP_M: f64 = 5.0;
const JUMP_MPS: f64 = 10.0;
/// A heading that is refused for this long, s, is believed in the end.
const HEADING_S: f64 = 120.0;
/// A height that a barometer denies by always the same amount is believed after this long, s, at most: sooner where the
/// height before was believed for less.
const LEVEL_S: f64 = 120.0;
/// A dispute about a position is forgotten within so many seconds at most.
const DISPUTED_MOST_S: f32 = 200.0;
/// What is left of a dispute below this, m, is nothing.
const DISPUTED_LEAST_M: f32 = 0.1;
/// A place that has been taken in for less than this, s, has yet to settle.
const SETTLED_S: f32 = 5.0;
/// Of the time between two fixes no more than this, s, counts as time in which a height or a place was taken in.
const MOST_BETWEEN_S: f32 = 3.0;

impl Gates {
    /// Gates that have seen nothing.
    pub const NONE: Self = Self {
        gates: [Gate::NONE; Group::COUNT],
        doubted_until: NEVER,
        lost_until: NEVER,
        unproven_until: NEVER,
        height_taken_s: 0.0,
        place_taken_s: 0.0,
        walk: Walk::NONE,
        height_off_m: 0.0,
        contradiction: Contradiction::NONE,
        baro_denies: false,
        heading_borne_out: false,
    };

    /// Forgets everything that the gates have seen. Field by field: [`NONE`](Self::NONE) as a whole would be stored as
    /// a constant beside the program.
    pub fn clear(&mut self) {
        self.gates = [Gate::NONE; Group::COUNT];
        self.doubted_until = NEVER;
        self.lost_until = NEVER;
        self.unproven_until = NEVER;
        self.height_taken_s = 0.0;
        self.place_taken_s = 0.0;
        self.walk = Walk::NONE;
        self.height_off_m = 0.0;
        self.contradiction = Contradiction::NONE;
        self.baro_denies = false;
        self.heading_borne_out = false;
    }

    /// The inertial samples had a gap, or were clipped: what disagrees now is the filter's own fault.
    pub fn doubt_filter(&mut self, time: Time) {
        self.doubted_until = time + DOUBT_S;
    }

    /// A heading was found or replaced: where fixes disagree in the time after it, the heading is wrong.
    pub fn doubt_heading(&mut self, time: Time) {
        self.unproven_until = time + UNPROVEN_S;
    }

    /// Whether the inertial samples had trouble of late.
    pub fn doubts_filter(&self, time: Time) -> bool {
        time < self.doubted_until
    }

    /// Whether the inertial samples have had trouble since `time`.
    pub fn doubted_after(&self, time: Time) -> bool {
        self.doubted_until - time > DOUBT_S
    }

    /// Whether a velocity was reopened of late, which leaves innovations that are alike for a while.
    pub fn were_reopened(&self, time: Time) -> bool {
        time < self.lost_until
    }

    /// Notes whether the fixes have borne out the filter's heading of late.
    pub fn set_heading_borne_out(&mut self, borne_out: bool) {
        self.heading_borne_out = borne_out;
    }

    /// Whether the filter's heading, with which a heading disagrees, is borne out by something else: by the fixes, or
    /// by the other kind of heading.
    fn is_heading_borne_out(&self, group: Group, time: Time) -> bool {
        let other = match group {
            Group::Heading => Group::BaselineHeading,
            Group::BaselineHeading => Group::Heading,
            _ => return false,
        };
        let by_fixes = self.heading_borne_out && !self.lack_fixes(time);
        by_fixes || self.is_open(other, time)
    }

    /// Notes whether a reading of the barometer denies the filter's height.
    pub fn set_baro_denies(&mut self, denies: bool) {
        self.baro_denies = denies;
    }

    /// Whether a group is that of a receiver which is proven to contradict itself.
    pub fn is_contradicted(&self, group: Group) -> bool {
        self.contradiction.proven && (group as usize) < Group::GPS
    }

    /// Notes an innovation of a [height](Group::is_height) and its one-sigma. Gives whether such innovations lean to
    /// one side by more than chance makes them, while the other sensor of height agrees with the filter: of receiver
    /// and barometer the one that leans first drifts.
    pub fn leans(&mut self, group: Group, time: Time, [off, sigma]: [f64; 2]) -> bool {
        let normalised = off / sigma;
        let Some(gate) = self.gates.get_mut(group as usize) else { return false };
        let newest = NEWEST.min(((time - gate.accepted) / LEANING_S) as f32);
        gate.lean += newest * ((normalised as f32).clamp(-MOST_LEAN, MOST_LEAN) - gate.lean);
        let leans = gate.lean.abs() > LEANING;
        leans
            && match group {
                Group::VerticalPosition | Group::VerticalVelocity => self.agrees(Group::Baro, time),
                Group::Baro => [Group::VerticalPosition, Group::VerticalVelocity]
                    .into_iter()
                    .all(|group| self.agrees(group, time)),
                _ => false,
            }
    }

    /// Whether a group is open and leans to no side.
    fn agrees(&self, group: Group, time: Time) -> bool {
        let leans = self.gates.get(group as usize).is_some_and(|gate| gate.lean.abs() > UPRIGHT);
        let denies = group == Group::Baro && self.baro_denies;
        self.is_open(group, time) && !(leans || denies)
    }

    /// Notes an acceptance; `spread` is the mean of the squared normalised innovations.
    pub fn accepted(&mut self, group: Group, time: Time, spread: f64) {
        if let Some(gate) = self.gates.get_mut(group as usize) {
            let since_s = ((time - gate.accepted) as f32).clamp(0.0, MOST_BETWEEN_S);
            match group {
                Group::VerticalPosition if gate.was_open => self.height_taken_s += since_s,
                Group::HorizontalPosition if gate.was_open => {
                    self.place_taken_s += since_s;
                    self.walk.forget(since_s, self.place_taken_s);
                }
                _ => {}
            }
            (gate.accepted, gate.was_open) = (time, true);
            gate.refusals = 0;
            gate.settle(since_s);
            gate.spread += NEWEST * (spread as f32 - gate.spread);
        }
    }

    /// Notes by how much, m, north and east, a fix has moved where the next is expected. Where fixes whose velocity was
    /// taken in too have moved it by more than `least_m`, their places walk away from that velocity, until they are back
    /// within half of it; meanwhile where the walk began is in dispute. Gives how far that is, m; zero where they do not.
    ///
    /// # Source
    /// Equation (K25) of docs/equations.md.
    pub fn place_moved(&mut self, time: Time, moved_m: [f32; 2], least_m: f32) -> f32 {
        if self.place_taken_s < SETTLED_S {
            self.forget_walk();
            return 0.0;
        }
        let tells_motion = self.is_open(Group::HorizontalVelocity, time);
        if tells_motion && !self.doubts_filter(time) && !self.were_reopened(time) {
            self.walk.add(moved_m);
        }
        self.walk.judge(least_m);
        self.walk.walked_m()
    }

    /// Adds to how far where the next fix is expected has moved, other than with the vehicle, north and east, m.
    pub fn expect_elsewhere(&mut self, moved_m: [f32; 2]) {
        self.walk.add(moved_m);
    }

    /// Counts anew how far fixes move where the next is expected.
    pub fn forget_walk(&mut self) {
        self.walk = Walk::NONE;
    }

    /// How far off, m, the place and the height that were told before lie, where they may still be right.
    pub fn disputed_m(&self) -> [f32; 2] {
        let [level_m, vertical_m] = [Group::HorizontalPosition, Group::VerticalPosition]
            .map(|group| self.gates.get(group as usize).map_or(0.0, |gate| gate.disputed_m));
        [level_m.max(self.walk.walked_m()), vertical_m]
    }

    /// Counts anew for how long the place has been taken in: the fix that comes next first makes it known.
    pub fn forget_place(&mut self) {
        self.place_taken_s = 0.0;
    }

    /// Whether a group was accepted when it was last heard, not long ago.
    pub fn is_open(&self, group: Group, time: Time) -> bool {
        self.gates
            .get(group as usize)
            .is_some_and(|gate| gate.refusals == 0 && gate.was_open_lately(time))
    }

    /// How long ago a group was last accepted, s.
    pub fn since_accepted_s(&self, group: Group, time: Time) -> f64 {
        self.gates.get(group as usize).map_or(0.0, |gate| time - gate.accepted)
    }

    /// Whether a group has not been heard for long, neither accepted nor refused.
    pub fn is_absent(&self, group: Group, time: Time) -> bool {
        self.gates
            .get(group as usize)
            .is_some_and(|gate| gate.refusals == 0 && !gate.was_open_lately(time))
    }

    fn was_open_lately(&self, group: Group, time: Time) -> bool {
        self.gates.get(group as usize).is_some_and(|gate| gate.was_open_lately(time))
    }

    /// Whether no fix was accepted for so long that the filter may have gone anywhere.
    pub fn lack_fixes(&self, time: Time) -> bool {
        self.gates.iter().take(Group::GPS).all(|gate| !gate.was_open_lately(time))
    }

    /// Whether a barometer agrees with the filter, and so denies what a receiver says of the height.
    pub fn barometer_agrees(&self, time: Time) -> bool {
        self.agrees(Group::Baro, time)
    }
}

#[cfg(test)]
mod tests;
