//! What the accelerometers say of a change of velocity, whatever the attitude.

use crate::frames::{Ned, Vector};
use crate::gps::Fix;
use crate::scalar::Scalar;
use crate::time::Time;

/// Velocity changes by specific force since the last fix, added up in axes that need not be north's:
/// an attitude that is off turns the sum, and leaves its length.
#[derive(Clone, Copy, Debug)]
pub(super) struct ForceSum<T> {
    /// Time and velocity of the last fix that told all of it.
    last: Option<(Time, Vector<Ned>)>,
    force_mps: Vector<Ned, T>,
    /// Whether samples since are missing, or stood at full scale.
    in_part: bool,
    /// By how much the fixes' velocity has changed that was not felt, and the most of it.
    stray_mps: Vector<Ned>,
    farthest_mps: f64,
    /// When a change was denied first.
    denied: Time,
    /// Since when the changes have been off by about as much each, and by how much the last was, m/s².
    steady: (Time, f64),
}

/// Fixes further apart than this, s, are not compared: gyro bias has turned the sum.
const LONGEST_S: f64 = 2.5;
/// Within this, m/s, lengths agree: what vibration and a swinging antenna leave.
const AGREEMENT_MPS: f64 = 1.0;
/// Share of the change beside gravity that times which do not agree leave.
const TIMING: f64 = 0.3;
/// Changes that are off by the same as at the fix before, within half of it, for so long, s, are those of an accelerometer
/// whose bias has stepped.
const STEADY_S: f64 = 1.9;
const STEADY: f64 = 0.5;
/// Smaller ones, m/s², are no step.
const LEAST_MPS2: f64 = 0.4;
/// Fixes that changed as was not felt are astray for this long, s, unless they come back by half.
const ASTRAY_S: f64 = 15.0;

impl<T: Scalar> ForceSum<T> {
    /// Nothing seen yet.
    pub const NONE: Self = Self {
        last: None,
        force_mps: Vector::ZERO,
        in_part: false,
        stray_mps: Vector::ZERO,
        farthest_mps: 0.0,
        denied: Time::ZERO,
        steady: (Time::ZERO, 0.0),
    };

    /// Adds a step's change by specific force; `whole` says whether the unit measured all of it.
    pub fn add(&mut self, force_mps: Vector<Ned, T>, whole: bool) {
        self.force_mps += force_mps;
        self.in_part |= !whole;
    }

    /// Starts anew at a fix. Gives whether the fixes' velocity is astray: it has changed, and not come
    /// back, while no attitude makes what was felt as long as what the fixes, of `sigma_mps`, say.
    ///
    /// # Source
    /// Equation (K15) of docs/equations.md.
    pub fn is_astray(&mut self, fix: &Fix, sigma_mps: [f64; 3], gravity_mps2: f64) -> bool {
        let Some(velocity) = fix.velocity_mps() else { return false };
        let (last, force_mps, in_part) = (self.last, self.force_mps.cast(), self.in_part);
        (self.last, self.force_mps) = (Some((fix.time, velocity)), Vector::ZERO);
        self.in_part = false;
        let mut steady = false;
        if let Some((time, before)) = last
            && !in_part
            && fix.time > time
            && fix.time - time <= LONGEST_S
        {
            let change = velocity - before;
            let asked = change - Vector::new(0.0, 0.0, gravity_mps2 * (fix.time - time));
            let (length, felt) = (asked.norm(), force_mps.norm());
            let off = libm::fabs(length - felt);
            let slack = || {
                let along: f64 =
                    asked.to_array().iter().zip(sigma_mps).map(|(a, s)| libm::fabs(a * s)).sum();
                let along = along / length.max(1e-3);
                SIGMAS * along + AGREEMENT_MPS + TIMING * change.norm().min(felt)
            };
            // The least that the slack can be first: the rest takes long.
            if off > AGREEMENT_MPS && off > slack() {
                if self.farthest_mps == 0.0 {
                    self.denied = fix.time;
                }
                self.stray_mps += asked - force_mps;
                self.farthest_mps = self.farthest_mps.max(self.stray_mps.norm());
            }
            steady = self.goes_on(fix.time, (length - felt) / (fix.time - time));
        } else {
            self.steady = (fix.time, 0.0);
        }
        let astray = self.farthest_mps > 0.0
            && !steady
            && self.stray_mps.norm() > 0.5 * self.farthest_mps
            && fix.time - self.denied < ASTRAY_S;
        if !astray {
            (self.stray_mps, self.farthest_mps) = (Vector::ZERO, 0.0);
        }
        astray
    }

    /// Whether the changes have been off by about as much, m/s², for long enough: a receiver's go astray at a stroke.
    fn goes_on(&mut self, time: Time, off_mps2: f64) -> bool {
        let (since, before) = self.steady;
        let size = libm::fabs(before);
        let is_steady = size >= LEAST_MPS2 && libm::fabs(off_mps2 - before) <= STEADY * size;
        let since = if is_steady { since } else { time };
        self.steady = (since, off_mps2);
        time - since >= STEADY_S
    }
}

/// So many one-sigmas of each of two fixes may add up.
const SIGMAS: f64 = 5.0 * core::f64::consts::SQRT_2;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::earth::Geodetic;

    const GRAVITY_MPS2: f64 = 9.8;

    /// Whether a change of velocity over a second is denied, when this was felt.
    fn denied(change: [f64; 3], felt: [f64; 3], whole: bool) -> bool {
        let mut sum = ForceSum::<f64>::NONE;
        let place = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
        let fix = |second: f64, [north, east, down]: [f64; 3]| Fix {
            horizontal_velocity_mps: Some([north, east]),
            down_velocity_mps: Some(down),
            ..Fix::at(Time::ZERO + second, place)
        };
        assert!(!sum.is_astray(&fix(1.0, [1.0, 2.0, 0.0]), [0.2; 3], GRAVITY_MPS2));
        sum.add(felt.into(), whole);
        let after = [1.0 + change[0], 2.0 + change[1], change[2]];
        sum.is_astray(&fix(2.0, after), [0.2; 3], GRAVITY_MPS2)
    }

    #[test]
    fn a_change_that_was_felt_is_not_denied_however_wrong_the_attitude() {
        assert!(!denied([6.0, 0.0, 0.0], [6.0, 0.0, -9.8], true));
        assert!(!denied([6.0, 0.0, 0.0], [0.0, -6.0, -9.8], true));
        assert!(!denied([6.0, 0.0, 0.0], [9.8, 0.0, -6.0], true));
    }

    #[test]
    fn a_change_that_was_not_felt_is_denied_where_the_samples_are_whole() {
        assert!(denied([15.0, 0.0, 0.0], [0.0, 0.0, -9.8], true));
        assert!(denied([0.0, 0.0, 6.0], [0.0, 0.0, -9.8], true));
        assert!(!denied([15.0, 0.0, 0.0], [0.0, 0.0, -9.8], false));
    }
}
