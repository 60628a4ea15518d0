//! A short, bounded memory of the way that led here, for fixes that come late.
//!
//! A fix that was true a moment ago is compared with where the *present* state was then: the state
//! is carried back through the increments that led from then to now, and the measurement's
//! sensitivity with it. Nothing is rolled back and no past covariance is kept; what is neglected is
//! the noise the sensors added in between, which the caller adds to the measurement's.

use glam::{DMat3, DVec3};

use crate::earth::Local;
use crate::frames::{Body, Ned, Vector};
use crate::ins::{Advance, Increment, NavState};
use crate::time::Time;

/// Number of entries kept.
const CAPACITY: usize = 64;

/// Steps shorter than this share an entry, s: with [`CAPACITY`] entries the memory reaches back at
/// least 0.6 s whatever the sample rate.
const ENTRY_S: f64 = 0.01;

/// What happened between two moments.
#[derive(Clone, Copy, Debug)]
struct Entry {
    end: Time,
    interval_s: f64,
    /// Rotation vector from the body axes at the end to those at the start.
    rotation_rad: Vector<Body>,
    /// Velocity change by specific force, body axes at the start.
    force_mps: Vector<Body>,
    /// Velocity change by all else.
    fall_mps: Vector<Ned>,
}

/// Ring of the last entries, newest last.
#[derive(Clone, Copy, Debug)]
pub(super) struct History {
    entries: [Option<Entry>; CAPACITY],
    next: usize,
}

/// The present state as it must have been at an earlier moment, and how its errors hang together
/// with the present ones.
#[derive(Clone, Copy, Debug)]
pub(super) struct LookBack {
    /// The state then.
    pub state: NavState,
    /// Angular rate of the body then, rad/s.
    pub angular_rate_radps: Vector<Body>,
    /// How long ago it was, s.
    pub age_s: f64,
    /// Velocity change by specific force since then, m/s.
    pub force_mps: DVec3,
    /// Its integral from then to now, m.
    pub force_m: DVec3,
    /// Integral of the direction cosines since then, s.
    pub turn_s: DMat3,
}

impl Default for History {
    fn default() -> Self {
        Self { entries: [None; CAPACITY], next: 0 }
    }
}

impl History {
    /// Takes in one step of the mechanization that ended at `end`.
    pub fn push(&mut self, end: Time, increment: &Increment, advance: &Advance) {
        let fall_mps = advance.velocity_mps - advance.from_specific_force_mps;
        let newest = (self.next + CAPACITY - 1) % CAPACITY;
        if let Some(Some(entry)) = self.entries.get_mut(newest)
            && entry.interval_s + increment.interval_s <= ENTRY_S
        {
            entry.end = end;
            entry.interval_s += increment.interval_s;
            // Second order in the rotation within an entry: enough for 10 ms.
            let (turned, turn) = (entry.rotation_rad, increment.rotation_rad);
            entry.force_mps += increment.velocity_mps + turned.cross(increment.velocity_mps);
            entry.rotation_rad = turned + turn + turned.cross(turn) * 0.5;
            entry.fall_mps += fall_mps;
            return;
        }
        if let Some(slot) = self.entries.get_mut(self.next) {
            *slot = Some(Entry {
                end,
                interval_s: increment.interval_s,
                rotation_rad: increment.rotation_rad,
                force_mps: increment.velocity_mps,
                fall_mps,
            });
        }
        self.next = (self.next + 1) % CAPACITY;
    }

    /// Forgets everything: after a gap the increments no longer connect.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    fn newest_first(&self) -> impl Iterator<Item = &Entry> {
        (1..=CAPACITY).map_while(move |back| {
            self.entries.get((self.next + CAPACITY - back) % CAPACITY)?.as_ref()
        })
    }

    /// Carries `now` back to `time`. `None` when `time` is older than the memory. A `time` after
    /// `now` carries forward at the last entry's mean specific force and rate.
    ///
    /// # Source
    /// Equations (M1) and (M2) of docs/equations.md.
    pub fn look_back(&self, now: &NavState, time: Time) -> Option<LookBack> {
        let mut back = LookBack {
            state: *now,
            angular_rate_radps: Vector::ZERO,
            age_s: 0.0,
            force_mps: DVec3::ZERO,
            force_m: DVec3::ZERO,
            turn_s: DMat3::ZERO,
        };
        let mut travel_m = Vector::ZERO;
        for entry in self.newest_first() {
            back.angular_rate_radps = entry.rotation_rad * (1.0 / entry.interval_s);
            let share = ((back.state.time - time) / entry.interval_s).min(1.0);
            travel_m += back.step(entry, share);
            if back.state.time <= time || share < 1.0 {
                back.state.position = Local::at(&now.position).carried(&now.position, travel_m);
                return Some(back);
            }
        }
        // Without history only the present can be asked for.
        (back.age_s == 0.0 && time == now.time).then_some(back)
    }
}

impl LookBack {
    /// Back by `share` of an entry, negative shares lead forward; gives the way that position has to
    /// go, m, for the caller to do in one go.
    fn step(&mut self, entry: &Entry, share: f64) -> Vector<Ned> {
        let interval_s = share * entry.interval_s;
        let state = &mut self.state;
        state.body_to_ned = state.body_to_ned.turned_in_from(entry.rotation_rad * -share);
        // Resolved in the axes at the start of what is stepped over, also for a part of the entry.
        let force = (state.body_to_ned * entry.force_mps).components() * share;
        let after = state.velocity_mps;
        state.velocity_mps -= Vector::claim(force) + entry.fall_mps * share;
        let travel_m = (after + state.velocity_mps) * (-0.5 * interval_s);
        state.time = state.time.offset_by(-interval_s);
        self.force_m += (self.force_mps + force * 0.5) * interval_s;
        self.force_mps += force;
        self.turn_s += state.body_to_ned.matrix() * interval_s;
        self.age_s += interval_s;
        travel_m
    }
}
