//! The present state carried back to an earlier time, and the relation of its errors at both times: (M1) and (M2).

use std::collections::VecDeque;

use hovernav::time::Time;
use nalgebra::{Matrix3, UnitQuaternion};

use crate::mechanization::{Advance, Earth, Increment, Nominal, Vector};

/// Number of entries.
const ENTRIES: usize = 51;
/// Largest total duration of steps in one entry, s.
const ENTRY_S: f64 = 0.0101;
/// Longest look-back for a fix, s.
const REACH_S: f64 = 0.5;
/// Half-width of the window for the mean acceleration, s.
const ABOUT_S: f64 = 0.06;

/// One or a few steps of the mechanization.
#[derive(Clone, Copy, Debug)]
struct Entry {
    end: Time,
    seconds: f64,
    /// From the body axes at the end to those at the start.
    rotation: UnitQuaternion<f64>,
    /// Velocity change by specific force, body axes at the start, and by all other effects, NED, m/s.
    force_mps: Vector,
    fall_mps: Vector,
    /// Whether the entry is a gap in the samples.
    coasted: bool,
}

/// The latest steps, newest first.
#[derive(Clone, Debug, Default)]
pub struct History(VecDeque<Entry>);

/// The present state carried back to an earlier moment.
#[derive(Clone, Copy, Debug)]
pub struct Back {
    pub state: Nominal,
    /// Angular rate of the body then, rad/s; mean acceleration, NED, m/s²; and its averaging time, s.
    pub rate_radps: Vector,
    pub acceleration_mps2: Vector,
    pub acceleration_over_s: f64,
    /// Age a of that moment, and the part of this age within gaps of the samples, s.
    pub age_s: f64,
    pub hidden_s: f64,
    /// F, G and J of (M2): Σ C Δv, its integral, and ∫ C dt, from then to now.
    pub force_mps: Vector,
    pub force_m: Vector,
    pub turn_s: Matrix3<f64>,
}

impl History {
    pub fn clear(&mut self) {
        self.0.clear();
    }

    /// Adds a step that ended at `end`. Steps of fast IMUs use the same entry. They are combined exactly here, and to
    /// second order of the rotation in the shipped filter.
    pub fn push(&mut self, end: Time, step: &Increment, advance: &Advance) {
        let rotation = UnitQuaternion::from_scaled_axis(step.rotation_rad);
        if let Some(entry) = self.0.front_mut().filter(|e| e.seconds + step.seconds <= ENTRY_S) {
            entry.end = end;
            entry.seconds += step.seconds;
            entry.force_mps += entry.rotation * step.velocity_mps;
            entry.rotation *= rotation;
            entry.fall_mps += advance.fall_mps;
            return;
        }
        self.add(Entry {
            end,
            seconds: step.seconds,
            rotation,
            force_mps: step.velocity_mps,
            fall_mps: advance.fall_mps,
            coasted: false,
        });
    }

    /// Adds a gap that ended at `end`, and the rotation of the body over it.
    pub fn coast(&mut self, end: Time, seconds: f64, rotation_rad: &Vector) {
        self.clear();
        self.add(Entry {
            end,
            seconds,
            rotation: UnitQuaternion::from_scaled_axis(*rotation_rad),
            force_mps: Vector::zeros(),
            fall_mps: Vector::zeros(),
            coasted: true,
        });
    }

    fn add(&mut self, entry: Entry) {
        self.0.push_front(entry);
        self.0.truncate(ENTRIES);
    }

    /// Largest look-back before `time`, s.
    pub fn reach_s(&self, time: Time) -> f64 {
        match self.0.get(ENTRIES - 1) {
            Some(oldest) => (time - oldest.end).clamp(0.0, REACH_S),
            None => REACH_S,
        }
    }

    /// Carries `now` back to `time`, over whole entries and a fraction of the last one. A `time` after `now` is reached
    /// forward with the newest entry's mean motion. `None` if `time` is before the first entry.
    pub fn look_back(&self, now: &Nominal, time: Time) -> Option<Back> {
        let mut back = Back {
            state: *now,
            rate_radps: Vector::zeros(),
            acceleration_mps2: Vector::zeros(),
            acceleration_over_s: 0.0,
            age_s: 0.0,
            hidden_s: 0.0,
            force_mps: Vector::zeros(),
            force_m: Vector::zeros(),
            turn_s: Matrix3::zeros(),
        };
        let mut way_m = Vector::zeros();
        let mut reached = None;
        for (index, entry) in self.0.iter().enumerate() {
            let share = ((back.state.time - time) / entry.seconds).min(1.0);
            way_m += back.step(entry, share);
            if back.state.time <= time || share < 1.0 {
                reached = Some(index);
                break;
            }
        }
        let Some(reached) = reached else {
            return (self.0.is_empty() && time == now.time).then_some(back);
        };
        back.rate_radps = self.0[reached].rotation.scaled_axis() / self.0[reached].seconds;
        back.state.place = Earth::at(&now.place).carried(&now.place, &way_m);
        self.accelerate(now, time, reached, &mut back);
        Some(back)
    }

    /// Mean acceleration about `time`, which lies in the entry `reached`. Each entry counts with its whole duration.
    fn accelerate(&self, now: &Nominal, time: Time, reached: usize, back: &mut Back) {
        let (mut attitude, mut start) = (now.attitude, now.time);
        let mut change_mps = Vector::zeros();
        for (index, entry) in self.0.iter().enumerate() {
            let before = attitude * entry.rotation.inverse();
            start = start.offset_by(-entry.seconds);
            let is_about = if index < reached {
                start <= time.offset_by(ABOUT_S)
            } else {
                index == reached || entry.end >= time.offset_by(-ABOUT_S)
            };
            // The entry that contains the moment is resolved with the attitude at the moment.
            let resolved = if index == reached { back.state.attitude } else { before };
            if is_about {
                change_mps += resolved * entry.force_mps + entry.fall_mps;
                back.acceleration_over_s += entry.seconds;
            } else if index > reached {
                break;
            }
            attitude = before;
        }
        back.acceleration_mps2 = change_mps / back.acceleration_over_s.max(1e-3);
    }
}

impl Back {
    /// One step back over an entry or a fraction of it: (M1), and the sums of (M2). Returns the displacement, m.
    fn step(&mut self, entry: &Entry, share: f64) -> Vector {
        let seconds = share * entry.seconds;
        let turned = UnitQuaternion::from_scaled_axis(-entry.rotation.scaled_axis() * share);
        let state = &mut self.state;
        state.attitude *= turned;
        let force_mps = state.attitude * entry.force_mps * share;
        let after_mps = state.velocity_mps;
        state.velocity_mps = after_mps - force_mps - entry.fall_mps * share;
        state.time = state.time.offset_by(-seconds);
        self.force_m += (self.force_mps + force_mps / 2.0) * seconds;
        self.force_mps += force_mps;
        self.age_s += seconds;
        if entry.coasted {
            self.hidden_s += seconds.max(0.0);
        } else {
            self.turn_s += self.state.cosines() * seconds;
        }
        -(after_mps + self.state.velocity_mps) * (seconds / 2.0)
    }
}
