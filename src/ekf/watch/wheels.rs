//! Vehicles on wheels. They move along their road, not sideways or upwards; this constraint limits the drift while
//! fixes are absent. The [`VehicleKind`] declares whether the vehicle rolls on wheels; without a declaration, the
//! velocity from the fixes shows it.
//!
//! The velocity of a car across its own forward axis has three causes. A misaligned inertial unit adds a velocity
//! proportional to the speed. The distance from the unsteered axle adds a velocity proportional to the turn rate.
//! Springs and tyres yield to a force: a car that accelerates raises its nose, and in a turn its tyres slip. All are
//! estimated while fixes are available. The residual shows whether the vehicle rolls on wheels: no aircraft has so
//! small a residual.

use super::READING_S;
use crate::earth::STANDARD_GRAVITY_MPS2;
use crate::ekf::settings::vehicle_kind::VehicleKind;
use crate::matrix::{cross, dot, square, times};
use crate::scalar::root;
use crate::time::Time;

/// Monitor of the velocity to the right and downwards, observed while fixes are available.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct WheelWatch {
    /// Velocity to the right and downwards.
    tracks: [Track; 2],
    /// Turn accumulated while the velocity was observed well, rad.
    turned_rad: f32,
    /// Weighted sums for the bank in turns. First: sine of the bank times the centripetal acceleration in g. Second:
    /// square of that acceleration.
    banked: [f32; 2],
    /// Mean specific force forward and to the right, m/s².
    force_mps2: [f32; 2],
    /// Whether the vehicle rolls on wheels, as its user declares.
    declared: Option<bool>,
    is_active: bool,
    /// Whether [`next_report`](Self::next_report) has reported the present value of `is_active`.
    is_reported: bool,
    /// Time of the last observation or constraint.
    seen: Time,
}

/// Direction of travel of a vehicle on wheels, in the inertial unit's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::ekf) struct Line {
    /// Ratio of the velocity across to the forward velocity.
    pub slope: f32,
    /// Lever arm, m: ratio of the velocity across to an angular rate. The axis of the rate is perpendicular to both the
    /// forward axis and the velocity across.
    pub arm_m: f32,
    /// Variance of the residual, (m/s)², enlarged so that samples every [`INTERVAL_S`] count as white.
    pub variance: f32,
}

/// Velocity across, as estimated by the filter after a fix.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct VelocityAcross {
    pub forward_mps: f32,
    pub rate_radps: f32,
    /// Specific force, m/s²: forward for the velocity downwards, to the right for the velocity to the right.
    pub force_mps2: f32,
    pub across_mps: f32,
    /// Variance of the residual due to the filter's own errors, (m/s)².
    pub own_variance: f32,
}

/// Minimum speed of a motion that is used, m/s: a slower motion may be a hover.
pub(in crate::ekf) const SLOWEST_MPS: f32 = 3.0;
/// Interval of the constraint, s.
pub(in crate::ekf) const INTERVAL_S: f64 = 0.2;
/// Usual one-sigma of a car's velocity perpendicular to its forward axis, from tyre slip and uneven roads, m/s.
const USUAL_MPS: f32 = 0.1;
/// Lower limit of the residual's one-sigma, m/s.
const MIN_MPS: f32 = 0.05;
/// Correlation time of the residual, s.
const CORRELATED_S: f32 = 2.0;
/// One-sigma of the slope after estimation: it includes the mean heading error.
const SLOPE_SIGMA: f32 = 0.003;
/// One-sigmas of slope, arm and compliance before the first observation: 6°, 1 m, and 0.6° for each m/s².
const PRIORS: [f32; CAUSES] = [0.1, 1.0, 0.01];
/// Time constant of the specific force, s: springs and tyres do not follow faster changes.
const FORCE_S: f32 = 0.3;
/// Time constant, s, with which observations of the direction of travel are forgotten.
const MEMORY_S: f32 = 300.0;
/// Memory of the residual, s.
const LEFT_MEMORY_S: f32 = 60.0;
/// Residual, m/s, below which the vehicle is found to roll on wheels.
const ROLLS_MPS: f32 = 0.15;
/// Minimum time of observation, s, before the vehicle is found to roll on wheels. An observation as accurate as a car's
/// usual residual counts fully.
const ROLLS_S: f32 = 10.0;
/// Threshold of the bank in turns, as a fraction of the coordinated bank. Above it the vehicle is an aircraft: a
/// vehicle on wheels rolls outwards.
const BANKS: f32 = 0.5;
/// Residual assumed after a vehicle has violated the constraint, m/s.
const VIOLATED_MPS: f32 = 1.0;
/// Mean normalised innovation above which a vehicle slowly leaves its road. A car's mean stays within 0.3: the residual
/// is correlated, and [`Line::variance`] is enlarged for it.
const BIASED: f32 = 0.75;

/// Number of causes of a velocity across: slope, arm and compliance.
const CAUSES: usize = 3;

/// Least-squares estimate from one component of the velocity across.
#[derive(Clone, Copy, Debug)]
struct Track {
    information: [[f32; CAUSES]; CAUSES],
    moments: [f32; CAUSES],
    /// Variance of the residual beyond the filter's own variance, (m/s)²; may be negative by chance.
    left: f32,
    /// Observation time, weighted by accuracy relative to a car's usual residual, s.
    seen_s: f32,
    /// Mean normalised innovation during the constraint.
    mean_innovation: f32,
}

impl Track {
    const BEFORE_FIRST_TURN: Self = Self {
        information: PRIOR_INFORMATION,
        moments: [0.0; CAUSES],
        left: USUAL_MPS * USUAL_MPS,
        seen_s: 0.0,
        mean_innovation: 0.0,
    };

    /// Covariance of slope, arm and compliance.
    fn covariance(&self) -> [[f32; CAUSES]; CAUSES] {
        let [x, y, z] = self.information;
        let columns = [cross(y, z), cross(z, x), cross(x, y)];
        // Positive because of the prior.
        let determinant = dot(&x, &cross(y, z));
        columns.map(|column| column.map(|value| value / determinant))
    }

    /// Slope, arm, m, and compliance, s²/m, with their covariance.
    fn found(&self) -> ([f32; CAUSES], [[f32; CAUSES]; CAUSES]) {
        let covariance = self.covariance();
        (times(&covariance, &self.moments), covariance)
    }

    fn observe(&mut self, seen: &VelocityAcross, elapsed_s: f32) {
        let causes = seen.causes();
        let left = seen.across_mps - dot(&self.found().0, &causes);
        let own_variance = seen.own_variance;
        let variance = square(USUAL_MPS) + own_variance;
        let weight = elapsed_s / variance;
        let fade = 1.0 - elapsed_s / MEMORY_S;
        let rows = self.information.iter_mut().zip(PRIOR_INFORMATION).zip(causes);
        for ((row, prior), cause) in rows {
            for ((sum, prior), other) in row.iter_mut().zip(prior).zip(causes) {
                *sum = fade * *sum + (1.0 - fade) * prior + weight * cause * other;
            }
        }
        for (sum, cause) in self.moments.iter_mut().zip(causes) {
            *sum = fade * *sum + weight * cause * seen.across_mps;
        }
        let share_s = square(USUAL_MPS) * weight;
        self.seen_s = fade * self.seen_s + share_s;
        let newest = share_s / self.seen_s.clamp(1.0, LEFT_MEMORY_S);
        self.left += newest * (square(left) - own_variance - self.left);
    }
}

/// Inverse of the prior covariance of slope, arm and compliance.
const PRIOR_INFORMATION: [[f32; CAUSES]; CAUSES] = {
    let [slope, arm_m, compliance] = PRIORS;
    [
        [1.0 / (slope * slope), 0.0, 0.0],
        [0.0, 1.0 / (arm_m * arm_m), 0.0],
        [0.0, 0.0, 1.0 / (compliance * compliance)],
    ]
};

impl VelocityAcross {
    /// Factors of slope, arm and compliance in the velocity across.
    fn causes(&self) -> [f32; CAUSES] {
        [self.forward_mps, self.rate_radps, self.force_mps2 * self.forward_mps]
    }
}

impl WheelWatch {
    /// State before the first observation, for a vehicle of the declared `kind`.
    // Both cases apart, so that each is a constant and no value is built on the stack.
    pub const fn of(kind: Option<VehicleKind>) -> Self {
        match kind {
            Some(kind) => Self::declared(Some(matches!(kind, VehicleKind::Wheeled))),
            None => Self::declared(None),
        }
    }

    const fn declared(declared: Option<bool>) -> Self {
        Self {
            tracks: [Track::BEFORE_FIRST_TURN; 2],
            turned_rad: 0.0,
            banked: [0.0; 2],
            force_mps2: [0.0; 2],
            declared,
            is_active: matches!(declared, Some(true)),
            is_reported: false,
            seen: Time::ZERO,
        }
    }

    /// Returns to the state before the first observation.
    pub const fn forget(&mut self) {
        *self = Self { is_reported: self.is_reported, ..Self::declared(self.declared) };
    }

    /// Feeds the velocity to the right and downwards after a fix, and the sine of the bank to the right.
    ///
    /// # Source
    /// Equation (M17) of docs/equations.md.
    pub fn observe_velocity(&mut self, time: Time, seen: &[VelocityAcross; 2], bank: f32) {
        let elapsed_s = (time - self.seen).clamp(0.0, READING_S) as f32;
        self.seen = time;
        let size = |seen: &VelocityAcross| {
            dot(&seen.causes(), &[1.0; CAUSES]) + seen.across_mps + seen.own_variance
        };
        let [right, down] = seen;
        // The comparison also rejects NaN.
        let sizes = size(right) + size(down) + bank;
        let speed_mps = right.forward_mps.abs();
        if !(speed_mps >= SLOWEST_MPS && sizes.is_finite()) {
            return;
        }
        let centripetal = right.forward_mps * right.rate_radps / STANDARD_GRAVITY_MPS2 as f32;
        let fade = 1.0 - elapsed_s / MEMORY_S;
        for (sum, factor) in self.banked.iter_mut().zip([bank, centripetal]) {
            *sum = fade * *sum + elapsed_s * centripetal * factor;
        }
        let [Track { seen_s: before_s, .. }, _] = self.tracks;
        for (track, seen) in self.tracks.iter_mut().zip(seen) {
            track.observe(seen, elapsed_s);
        }
        let [level_s, vertical_s] = self.tracks.map(|track| track.seen_s);
        self.turned_rad += (level_s - before_s).max(0.0) * right.rate_radps.abs();
        let left = self.left();
        let [banked, turned] = self.banked;
        let banks = banked > BANKS * turned;
        self.is_active = if let Some(declared) = self.declared {
            declared
        } else if self.is_active {
            left < 2.0 * square(ROLLS_MPS) && !banks
        } else {
            left < square(ROLLS_MPS)
                && !banks
                && level_s.min(vertical_s) > ROLLS_S
                && self.turned_rad > core::f32::consts::PI
        };
    }

    /// Whether the vehicle rolls on wheels; `Some` once after each change.
    pub fn next_report(&mut self) -> Option<bool> {
        let before = core::mem::replace(&mut self.is_reported, self.is_active);
        (before != self.is_active).then_some(self.is_active)
    }

    /// Whether the constraint is due at `time`. If so, `time` becomes the time of the last constraint.
    pub fn is_due(&mut self, time: Time) -> bool {
        let is_due = self.is_active && time - self.seen >= INTERVAL_S;
        if is_due {
            self.seen = time;
        }
        is_due
    }

    /// Feeds the normalised innovations to the right and downwards, before the constraint is applied. Returns `true` if
    /// the motion is impossible on wheels: an innovation beyond `gate`, or biased innovations. The constraint then
    /// stops until fixes show wheels again.
    pub fn is_violated(&mut self, normalised: [f32; 2], gate: f32) -> bool {
        for (track, normalised) in self.tracks.iter_mut().zip(normalised) {
            track.mean_innovation +=
                INTERVAL_S as f32 / CORRELATED_S * (normalised - track.mean_innovation);
        }
        // The comparison also counts NaN as a violation.
        let unbiased = self.tracks.iter().all(|track| track.mean_innovation.abs() < BIASED);
        let violated = !(unbiased && normalised.iter().all(|size| size.abs() <= gate));
        if violated {
            self.is_active = false;
            for track in &mut self.tracks {
                (track.left, track.mean_innovation) = (square(VIOLATED_MPS), 0.0);
            }
        }
        violated
    }

    /// Direction of travel at the motion `seen`, from the velocity to the right or, if `is_down`, downwards.
    pub fn line(&self, is_down: bool, seen: &VelocityAcross) -> Line {
        let [right, down] = &self.tracks;
        let track = if is_down { down } else { right };
        let ([slope, arm_m, compliance], covariance) = track.found();
        let causes = seen.causes();
        let of_line = dot(&times(&covariance, &causes), &causes);
        let once =
            track.left.max(square(MIN_MPS)) + square(SLOPE_SIGMA * seen.forward_mps) + of_line;
        Line {
            slope: slope + compliance * seen.force_mps2,
            arm_m,
            variance: once * CORRELATED_S / INTERVAL_S as f32,
        }
    }

    /// Specific force forward and to the right, m/s².
    pub fn force_mps2(&self) -> [f32; 2] {
        self.force_mps2
    }

    /// Feeds the specific force of a sample, forward and to the right, m/s².
    pub fn observe_sample(&mut self, force_mps2: [f32; 2], interval_s: f32) {
        let newest = (interval_s / FORCE_S).min(1.0);
        for (mean, force) in self.force_mps2.iter_mut().zip(force_mps2) {
            *mean += newest * (force - *mean);
        }
    }

    /// One-sigma of the constrained velocity across, m/s.
    pub fn sigma_mps(&self) -> f32 {
        root(self.left().max(square(MIN_MPS)))
    }

    /// Larger variance of the residual of the two tracks, (m/s)².
    fn left(&self) -> f32 {
        let [right, down] = &self.tracks;
        right.left.max(down.left)
    }
}

#[cfg(test)]
mod tests;
