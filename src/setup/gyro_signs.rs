//! Comparison of the turns that the gyros report with the accelerations of the fixes.
//!
//! A level frame that follows the gyros differs from NED by a heading alone. The specific force in that frame, summed
//! from fix to fix, then changes as the velocity of the fixes, turned by this heading. If a roll or pitch rate has the
//! wrong sign, or both are swapped, the frame tilts to the wrong side: a mirror image, which no heading explains. With a
//! yaw rate of the wrong sign the heading changes at twice the rate. Each assumption has its own frame, and the
//! coherence of forces and accelerations decides.
//!
//! # Source
//! Own. Coherence of two-dimensional series as complex numbers: J. Gonella (1972), A rotary-component method for
//! analysing meteorological and oceanographic vector time series, *Deep-Sea Research* 19, 833–846.

use super::SetupFault;
use crate::frames::{Body, Ned, Rotation, Vector};
use crate::gps::Fix;
use crate::imu::MeanRates;
use crate::time::Time;

/// Assumed wrong signs of the roll rate, which gives the same mirror image as the pitch rate, and of the yaw rate. The
/// first is the set-up as given.
const ASSUMED: [[bool; 2]; 4] = [[false, false], [true, false], [false, true], [true, true]];
/// Longest averaging interval, s; after a longer one the frames are unknown.
const LONGEST_PART_S: f32 = 0.8;
/// Shortest and longest interval between two compared fixes, s.
const BETWEEN_FIXES_S: core::ops::RangeInclusive<f64> = 0.9..=2.5;
/// Number of compared changes of acceleration for a result. A gyro bias of 1°/s turns a frame by 40° in this time.
const MIN_CHANGES: u8 = 40;
/// Smallest change of the fixes' acceleration, m/s² rms, for a result.
const MIN_CHANGE_MPS2: f32 = 0.5;
/// Smallest coherence, 0 to 1, of the best assumption for a result.
const COHERENT: f32 = 0.5;
/// Largest coherence of a refuted assumption, as a fraction of the best one.
const REFUTED: f32 = 0.5;
/// Number of results that refute the set-up as given, for a fault.
const MIN_RESULTS: u8 = 2;

/// Sum of the specific force in a level frame that follows the gyros with assumed signs.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Carried {
    /// From body axes to the level frame.
    attitude: Rotation<Body, Ned, f32>,
    /// Sum over the last averaging interval, horizontal, m/s.
    step_mps: [f32; 2],
    /// Sum up to the last averaging interval, since the previous fix, horizontal, m/s.
    before_mps: [f32; 2],
    /// Mean between the last two fixes, m/s².
    force_mps2: [f32; 2],
    /// Sum of the products of the fixes' change of acceleration and the complex conjugate of the change of force.
    product: [f32; 2],
    /// Sum of squared changes of force, (m/s²)².
    size: f32,
}

/// The comparison over the last minute of fixes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GyroSigns {
    carried: [Carried; ASSUMED.len()],
    /// Start and end of the last averaging interval.
    part: Option<(Time, Time)>,
    /// A fix that is newer than the last averaging interval.
    waiting: Option<(Time, [f32; 2])>,
    /// The last compared fix.
    fix: Option<(Time, [f32; 2])>,
    /// Mean acceleration between the last two fixes, m/s².
    acceleration_mps2: Option<[f32; 2]>,
    /// Sum of squared changes of acceleration, (m/s²)².
    size: f32,
    changes: u8,
    /// Number of results that refute each assumption.
    refuted: [u8; ASSUMED.len()],
    is_reported: bool,
}

impl Carried {
    const NONE: Self = Self {
        attitude: Rotation::IDENTITY,
        step_mps: [0.0; 2],
        before_mps: [0.0; 2],
        force_mps2: [0.0; 2],
        product: [0.0; 2],
        size: 0.0,
    };

    /// Adds an averaging interval, with half its turn as a quaternion.
    // Not inlined four times: it is called twice a second.
    #[inline(never)]
    fn push(&mut self, half_turn: [f32; 4], force_mps2: Vector<Body, f32>, interval_s: f32) {
        let half_turn = Rotation::<Body, Body, f32>::of_array(half_turn);
        self.before_mps = add(self.before_mps, self.step_mps);
        let middle = self.attitude * half_turn;
        let [north, east, _] = (middle * force_mps2 * interval_s).to_array();
        self.step_mps = [north, east];
        self.attitude = (middle * half_turn).renormalised();
    }

    /// Ends the sum at the fraction `share` of the last averaging interval, and returns it, m/s.
    fn end(&mut self, share: f32) -> [f32; 2] {
        let part = self.step_mps.map(|step| share * step);
        let sum = add(self.before_mps, part);
        self.before_mps = part.map(|part| -part);
        sum
    }

    /// Adds a mean force between two fixes, with the change of the fixes' acceleration, if known.
    #[inline(never)]
    fn add(&mut self, force_mps2: [f32; 2], changed: Option<[f32; 2]>) {
        let [a, b] = subtract(force_mps2, self.force_mps2);
        self.force_mps2 = force_mps2;
        let Some([c, d]) = changed else { return };
        self.product = add(self.product, [c * a + d * b, d * a - c * b]);
        self.size += squared([a, b]);
    }

    /// Coherence, 0 to 1, with changes of acceleration whose squares have the sum `size`.
    fn coherence(&self, size: f32) -> f32 {
        squared(self.product) / (size * self.size).max(f32::MIN_POSITIVE)
    }
}

fn add([a, b]: [f32; 2], [c, d]: [f32; 2]) -> [f32; 2] {
    [a + c, b + d]
}

fn subtract([a, b]: [f32; 2], [c, d]: [f32; 2]) -> [f32; 2] {
    [a - c, b - d]
}

fn squared([a, b]: [f32; 2]) -> f32 {
    a * a + b * b
}

impl GyroSigns {
    pub const NONE: Self = Self {
        carried: [Carried::NONE; ASSUMED.len()],
        part: None,
        waiting: None,
        fix: None,
        acceleration_mps2: None,
        size: 0.0,
        changes: 0,
        refuted: [0; ASSUMED.len()],
        is_reported: false,
    };

    /// Adds the averages of an interval that ends at `end`.
    pub fn push(&mut self, end: Time, mean: &MeanRates<f32>) {
        let interval_s = self.part.map_or(f32::INFINITY, |(_, before)| (end - before) as f32);
        if interval_s > LONGEST_PART_S {
            self.restart(end, mean);
            return;
        }
        let start = self.part.map_or(end, |(_, before)| before);
        self.part = Some((start, end));
        let half_turn = mean.angular_rate_radps * (0.5 * interval_s);
        let [x, y, z, w] =
            Rotation::<Body, Body, f32>::IDENTITY.turned_in_from(half_turn).to_array();
        for (carried, [tilts, yaw]) in self.carried.iter_mut().zip(ASSUMED) {
            // A wrong sign of a rate is a wrong sign of that component of the quaternion.
            let half_turn = [if tilts { -x } else { x }, y, if yaw { -z } else { z }, w];
            carried.push(half_turn, mean.specific_force_mps2, interval_s);
        }
        if let Some((time, velocity)) = self.waiting.take() {
            self.compare(time, velocity);
        }
    }

    /// Adds a fix. Returns the fault once.
    pub fn push_fix(&mut self, fix: &Fix) -> Option<SetupFault> {
        let velocity = fix.horizontal_velocity_mps?.map(|component| component as f32);
        let is_due = self.fix.is_none_or(|(time, _)| fix.time - time >= *BETWEEN_FIXES_S.start());
        if is_due && self.waiting.is_none() {
            self.compare(fix.time, velocity);
        }
        let [given, ..] = self.refuted;
        if given < MIN_RESULTS || self.is_reported {
            return None;
        }
        let (_, &[tilts, yaw]) =
            self.refuted.iter().zip(&ASSUMED).find(|(count, _)| **count == 0)?;
        self.is_reported = true;
        Some(SetupFault::GyroSigns { tilts, yaw })
    }

    /// Starts new frames, level by the mean specific force.
    fn restart(&mut self, end: Time, mean: &MeanRates<f32>) {
        // The shortest rotation of the specific force to the upward direction.
        let size = mean.specific_force_mps2.norm().max(f32::MIN_POSITIVE);
        let [x, y, z] = (mean.specific_force_mps2 * (1.0 / size)).to_array();
        let length = libm::sqrtf(x * x + y * y + (1.0 - z) * (1.0 - z)).max(f32::MIN_POSITIVE);
        let attitude = Rotation::of_array([-y, x, 0.0, 1.0 - z].map(|part| part / length));
        *self = Self {
            carried: [Carried { attitude, ..Carried::NONE }; ASSUMED.len()],
            part: Some((end, end)),
            refuted: self.refuted,
            is_reported: self.is_reported,
            ..Self::NONE
        };
    }

    /// Compares the change of velocity since the previous fix with the sums, if the last averaging interval contains
    /// `time`.
    fn compare(&mut self, time: Time, velocity: [f32; 2]) {
        let Some((start, end)) = self.part else { return };
        if time > end {
            self.waiting = Some((time, velocity));
        }
        if time > end || time < start {
            return;
        }
        let length_s = (end - start) as f32;
        let share = if length_s > 0.0 { (time - start) as f32 / length_s } else { 1.0 };
        let before = self.fix.replace((time, velocity));
        let sums = self.carried.each_mut().map(|carried| carried.end(share));
        let Some((before, previous)) = before else { return };
        if !BETWEEN_FIXES_S.contains(&(time - before)) {
            self.acceleration_mps2 = None;
            return;
        }
        let rate = 1.0 / (time - before) as f32;
        let acceleration = subtract(velocity, previous).map(|change| rate * change);
        let last = self.acceleration_mps2.replace(acceleration);
        let changed = last.map(|last| subtract(acceleration, last));
        for (carried, sum) in self.carried.iter_mut().zip(sums) {
            carried.add(sum.map(|sum| rate * sum), changed);
        }
        let Some(changed) = changed else { return };
        self.size += squared(changed);
        self.changes += 1;
        if self.changes >= MIN_CHANGES {
            self.judge();
        }
    }

    /// Judges the sums, and starts again.
    fn judge(&mut self) {
        let moves = self.size > MIN_CHANGE_MPS2 * MIN_CHANGE_MPS2 * f32::from(self.changes);
        let coherences = self.carried.map(|carried| carried.coherence(self.size));
        let best = coherences.into_iter().fold(0.0, f32::max);
        for (count, coherence) in self.refuted.iter_mut().zip(coherences) {
            let is_refuted = moves && best > COHERENT && coherence < REFUTED * best;
            *count = count.saturating_add(u8::from(is_refuted));
        }
        self.part = None;
    }
}
