//! A short, bounded history of increments, for fixes that come late.
//!
//! A late fix is compared with the *present* state carried back to the time of the fix. The state goes back through the
//! increments since then, and the measurement's sensitivity with it. Nothing is rolled back and no past covariance is
//! kept. The comparison neglects the sensor noise added in between; the caller adds it to the measurement's noise.

use crate::earth::LocalEarth;
use crate::frames::{Body, Ned, Rotation, Vector};
use crate::ins::{Advance, Increment, NavState};
use crate::scalar::Scalar;
use crate::time::Time;

/// Number of entries kept.
const CAPACITY: usize = 51;

/// Longest duration of an entry, s: several sample intervals are merged into one entry. [`CAPACITY`] entries then reach
/// back at least half a second at any sample rate.
const ENTRY_S: f64 = 0.0101;

/// Guaranteed reach of the memory, s.
const REACH_S: f64 = 0.5;

/// Half-width of the window for the mean acceleration, ns. It is short compared to a vehicle's manoeuvres. A mean that
/// lags would appear as an additional GPS delay.
pub(in crate::ekf) const ABOUT_NS: i64 = 60_000_000;

/// Motion between two moments, corrected by the biases of the filter that recorded it.
#[derive(Clone, Copy, Debug)]
struct Entry<T> {
    end: Time,
    interval_s: T,
    /// Rotation vector from the body axes at the end to those at the start.
    rotation_rad: Vector<Body, T>,
    /// Velocity change by specific force, body axes at the start.
    force_mps: Vector<Body, T>,
    /// Velocity change by gravity and Earth rotation; zero where the state coasted without inertial samples.
    fall_mps: Vector<Ned, T>,
}

/// Ring of the last entries, newest last.
#[derive(Clone, Debug)]
pub struct History<T> {
    entries: [Entry<T>; CAPACITY],
    next: usize,
    len: usize,
}

/// The present state carried back to an earlier moment, and how its errors depend on the present errors.
#[derive(Clone, Copy, Debug)]
pub struct LookBack<T> {
    /// State at the earlier moment.
    pub state: NavState<T>,
    /// Angular rate of the body at the earlier moment, rad/s.
    pub angular_rate_radps: Vector<Body, T>,
    /// Acceleration at the earlier moment, low-passed, m/s²; zero if not requested.
    pub acceleration_mps2: Vector<Ned, T>,
    /// Duration, s, over which the acceleration is averaged.
    pub acceleration_over_s: T,
    /// Time from the earlier moment to now, s.
    pub age_s: T,
    /// Part of `age_s` within gaps of the inertial samples, s.
    pub hidden_s: T,
    /// Velocity change by specific force since the earlier moment, m/s.
    pub force_mps: Vector<Ned, T>,
    /// Integral of `force_mps` from the earlier moment to now, m.
    pub force_m: Vector<Ned, T>,
    /// Integral of the direction cosines from the earlier moment to now, rows north, east, down, s.
    pub turn_s: [[T; 3]; 3],
}

/// Motion since an earlier moment, from inertial samples alone.
#[derive(Clone, Copy, Debug)]
pub struct MotionSince<To, T> {
    /// Velocity change by specific force, m/s.
    pub velocity_mps: Vector<To, T>,
    /// Duration, s.
    pub duration_s: T,
    /// Attitude at the earlier moment.
    pub attitude: Rotation<Body, To, T>,
    /// Angular rate of the body at the earlier moment, rad/s.
    pub angular_rate_radps: Vector<Body, T>,
}

impl<T: Scalar> Entry<T> {
    const NONE: Self = Self {
        end: Time::ZERO,
        interval_s: T::ZERO,
        rotation_rad: Vector::ZERO,
        force_mps: Vector::ZERO,
        fall_mps: Vector::ZERO,
    };

    fn is_coasted(&self) -> bool {
        self.fall_mps == Vector::ZERO
    }
}

impl<T: Scalar> History<T> {
    /// Empty history.
    pub const EMPTY: Self = Self { entries: [Entry::NONE; CAPACITY], next: 0, len: 0 };

    /// Appends one mechanization step that ended at `end`.
    pub fn push(&mut self, end: Time, increment: &Increment<T>, advance: &Advance<T>) {
        let fall_mps = advance.velocity_mps - advance.from_specific_force_mps;
        if let Some(entry) = self.newest_mut()
            && entry.interval_s + increment.interval_s <= T::of(ENTRY_S)
        {
            entry.end = end;
            entry.interval_s += increment.interval_s;
            // Second order in the rotation within an entry: enough for 10 ms.
            let (turned, turn) = (entry.rotation_rad, increment.rotation_rad);
            entry.force_mps += increment.velocity_mps + turned.cross(increment.velocity_mps);
            entry.rotation_rad = turned + turn + turned.cross(turn) * T::of(0.5);
            entry.fall_mps += fall_mps;
            return;
        }
        self.append(Entry {
            end,
            interval_s: increment.interval_s,
            rotation_rad: increment.rotation_rad,
            force_mps: increment.velocity_mps,
            fall_mps,
        });
    }

    /// Appends a gap in the samples that ended at `end`, over which the state coasted.
    pub fn coast(&mut self, end: Time, interval_s: T, rotation_rad: Vector<Body, T>) {
        self.append(Entry { end, interval_s, rotation_rad, ..Entry::NONE });
    }

    fn append(&mut self, entry: Entry<T>) {
        if let Some(slot) = self.entries.get_mut(self.next) {
            *slot = entry;
        }
        self.next = (self.next + 1) % CAPACITY;
        self.len = CAPACITY.min(self.len + 1);
    }

    /// Clears the history: after a gap the increments no longer connect.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Largest look-back before `time`, s. Limited to [`REACH_S`], which every sample rate covers, and to the oldest
    /// entry of a full memory.
    pub fn reach_s(&self, time: Time) -> T {
        let least = T::of(REACH_S);
        let oldest = self.newest(CAPACITY - 1);
        oldest.map_or(least, |entry| time.seconds_since::<T>(entry.end).max(T::ZERO).min(least))
    }

    fn slot(&self, back: usize) -> Option<usize> {
        (back < self.len).then(|| (self.next + CAPACITY - 1 - back) % CAPACITY)
    }

    fn newest(&self, back: usize) -> Option<&Entry<T>> {
        self.entries.get(self.slot(back)?)
    }

    fn newest_mut(&mut self) -> Option<&mut Entry<T>> {
        let slot = self.slot(0)?;
        self.entries.get_mut(slot)
    }

    fn newest_first(&self) -> impl Iterator<Item = &Entry<T>> {
        (0..CAPACITY).map_while(move |back| self.newest(back))
    }

    /// Motion measured since `time`, in the axes `To`. `attitude` is the present rotation from the body to these axes.
    /// `None` if `time` is before the oldest entry.
    pub fn motion_since<To>(
        &self,
        time: Time,
        attitude: Rotation<Body, To, T>,
    ) -> Option<MotionSince<To, T>> {
        let mut felt = MotionSince {
            velocity_mps: Vector::ZERO,
            duration_s: T::ZERO,
            attitude,
            angular_rate_radps: Vector::ZERO,
        };
        // Iterations: at most CAPACITY, one an entry.
        for entry in self.newest_first() {
            felt.angular_rate_radps = entry.rotation_rad * (T::ONE / entry.interval_s);
            let left_s: T = entry.end.seconds_since(time);
            if left_s <= T::ZERO {
                return Some(felt);
            }
            let share = (left_s / entry.interval_s).min(T::ONE);
            felt.attitude = felt.attitude.turned_in_from(entry.rotation_rad * -share);
            felt.velocity_mps += felt.attitude * entry.force_mps * share;
            felt.duration_s += share * entry.interval_s;
            if share < T::ONE {
                return Some(felt);
            }
        }
        None
    }

    /// Carries `now` back to `time`, with the Earth model `earth` at `now`. `None` if `time` is before the oldest
    /// entry. A `time` after `now` is reached forward with the last entry's mean specific force and rate. The
    /// acceleration costs a third of the run time, and is zero unless `with_acceleration`.
    ///
    /// # Source
    /// Equations (M1) and (M2) of docs/equations.md.
    pub fn look_back(
        &self,
        now: &NavState<T>,
        earth: &LocalEarth<T>,
        time: Time,
        with_acceleration: bool,
    ) -> Option<LookBack<T>> {
        let mut back = LookBack {
            state: *now,
            angular_rate_radps: Vector::ZERO,
            acceleration_mps2: Vector::ZERO,
            acceleration_over_s: T::ZERO,
            age_s: T::ZERO,
            hidden_s: T::ZERO,
            force_mps: Vector::ZERO,
            force_m: Vector::ZERO,
            turn_s: [[T::ZERO; 3]; 3],
        };
        // Integer nanoseconds compare directly; seconds would each need a conversion.
        let [earliest, latest] = [-ABOUT_NS, ABOUT_NS]
            .map(|away| Time::from_nanoseconds(time.nanoseconds().saturating_add(away)));
        let mut travel_m = Vector::ZERO;
        let mut entries = self.newest_first();
        // Iterations: at most CAPACITY, one an entry.
        while let Some(entry) = entries.next() {
            back.angular_rate_radps = entry.rotation_rad * (T::ONE / entry.interval_s);
            let left_s: T = back.state.time.seconds_since(time);
            let share = (left_s / entry.interval_s).min(T::ONE);
            travel_m += back.step(entry, share);
            // An entry that `time` divides counts fully, with the attitude at `time`.
            if with_acceleration && back.state.time <= latest {
                back.add_change(back.state.body_to_ned, entry);
            }
            if back.state.time <= time || share < T::ONE {
                if with_acceleration {
                    let rest = entry.rotation_rad * -(T::ONE - share);
                    let mut earlier = back.state.body_to_ned.turned_in_from(rest);
                    for entry in entries.take_while(|entry| entry.end >= earliest) {
                        earlier = earlier.turned_in_from(-entry.rotation_rad);
                        back.add_change(earlier, entry);
                    }
                    let over_s = back.acceleration_over_s.max(T::of(1e-3));
                    back.acceleration_mps2 = back.acceleration_mps2 * (T::ONE / over_s);
                }
                back.state.position = earth.carried(&now.position, travel_m);
                return Some(back);
            }
        }
        // Without history, only the present state can be returned.
        (back.age_s == T::ZERO && time == now.time).then_some(back)
    }
}

impl<T: Scalar> LookBack<T> {
    /// Adds the velocity change of an entry, with the attitude at about its start. The sum is divided by its duration
    /// at the end.
    fn add_change(&mut self, body_to_ned: Rotation<Body, Ned, T>, entry: &Entry<T>) {
        self.acceleration_mps2 += body_to_ned * entry.force_mps + entry.fall_mps;
        self.acceleration_over_s += entry.interval_s;
    }

    /// Carries the state back by the fraction `share` of an entry, or forward if `share` is negative. Returns the
    /// displacement of the position, m, which the caller applies once at the end.
    fn step(&mut self, entry: &Entry<T>, share: T) -> Vector<Ned, T> {
        let interval_s = share * entry.interval_s;
        let state = &mut self.state;
        state.body_to_ned = state.body_to_ned.turned_in_from(entry.rotation_rad * -share);
        // Resolved in the axes at the start of the stepped interval, also for a part of an entry.
        let force = state.body_to_ned * entry.force_mps * share;
        let after = state.velocity_mps;
        state.velocity_mps -= force + entry.fall_mps * share;
        let travel_m = (after + state.velocity_mps) * (T::of(-0.5) * interval_s);
        state.time = state.time.offset_by(-interval_s);
        self.force_m += (self.force_mps + force * T::of(0.5)) * interval_s;
        self.force_mps += force;
        if entry.is_coasted() {
            self.hidden_s += interval_s.max(T::ZERO);
        } else {
            for (sum, row) in self.turn_s.iter_mut().zip(state.body_to_ned.rows()) {
                for (sum, cosine) in sum.iter_mut().zip(row) {
                    *sum += cosine * interval_s;
                }
            }
        }
        self.age_s += interval_s;
        travel_m
    }
}
