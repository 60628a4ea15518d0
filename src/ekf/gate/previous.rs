//! Second hypothesis of a position.

use super::position_drift::MAX_MEMORY_S;
use crate::matrix::square;

/// Second hypothesis of the horizontal or vertical position: the filter's position before a fix moved it without other
/// evidence. Either position may be right.
#[derive(Clone, Copy, Debug)]
pub(super) struct Previous {
    /// Offset from the position that the filter expects of the next fix, m: north and east, or down and zero.
    offset_m: [f32; 2],
    /// Weight, 0 to 1. It decreases while fixes at the filter's position are fused.
    weight: f32,
    /// Time constant of the decrease, s: total time of the fixes fused at this position.
    reported_s: u8,
    /// Whether a fix at this position resets the filter to it. Otherwise the filter left it in ordinary updates, which
    /// moved its slow position errors too.
    can_return: bool,
}

/// Minimum distance, m; a nearer position is no second hypothesis.
const MIN_M: f32 = 0.1;
/// Minimum weight of a position to which fixes may return.
const MIN_WEIGHT: f32 = 0.2;

impl Previous {
    pub const NONE: Self =
        Self { offset_m: [0.0; 2], weight: 0.0, reported_s: 1, can_return: false };

    /// Distance to the filter's position, m, times the weight.
    pub fn ambiguity_m(&self) -> f32 {
        self.weight * length(self.offset_m)
    }

    /// Replaces the hypothesis by the position at `offset_m`, m, if its ambiguity is larger. Fixes at that position
    /// were fused for `reported_s`, s.
    pub fn keep(&mut self, offset_m: [f32; 2], reported_s: f32, can_return: bool) {
        if length(offset_m) > self.ambiguity_m() {
            let reported_s = reported_s.clamp(1.0, MAX_MEMORY_S) as u8;
            *self = Self { offset_m, weight: 1.0, reported_s, can_return };
        }
    }

    /// Stores the filter's present position as the hypothesis, before the filter moves by about `off_m`, m. Fixes at
    /// that position were fused for `reported_s`, s. The earlier hypothesis stays if its ambiguity is then larger.
    pub fn leave(&mut self, off_m: [f32; 2], reported_s: f32, in_reset: bool) {
        self.shift(off_m);
        self.keep(off_m.map(|off_m| -off_m), reported_s, in_reset);
        self.shift(off_m.map(|off_m| -off_m));
    }

    /// Updates the offset after fixes moved the filter's position by `moved_m`, m: north and east, or down and zero.
    pub fn shift(&mut self, moved_m: [f32; 2]) {
        for (offset, moved) in self.offset_m.iter_mut().zip(moved_m) {
            *offset -= moved;
        }
    }

    /// Lets the weight decrease by another `fused_s` of fused fixes.
    pub fn forget(&mut self, fused_s: f32) {
        if self.weight == 0.0 {
            return;
        }
        self.weight *= (1.0 - fused_s / f32::from(self.reported_s)).max(0.0);
        if self.ambiguity_m() < MIN_M {
            *self = Self::NONE;
        }
    }

    /// Whether a fix at `off_m` from the filter's position, within `limit_m` of this position, resets the filter to it.
    pub fn is_at(&self, [north_m, east_m]: [f64; 2], limit_m: f64) -> bool {
        let [north, east] = self.offset_m.map(f64::from);
        let apart_m2 = square(north_m - north) + square(east_m - east);
        self.can_return && self.weight > MIN_WEIGHT && apart_m2 <= square(limit_m)
    }
}

fn length([north, east]: [f32; 2]) -> f32 {
    libm::hypotf(north, east)
}
