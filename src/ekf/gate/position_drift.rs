//! Drift of the positions of fixes away from the velocity that they report.

/// Recent sum of the corrections by which fixes shifted the expected position. It decays with time.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct PositionDrift {
    /// Shift north and east, m.
    moved_m: [f32; 2],
    /// Whether the shift exceeds that of correct fixes: the positions drift.
    is_drifting: bool,
}

/// Shortest time constant of the shift's decay, s.
const MIN_MEMORY_S: f32 = 20.0;
pub(super) const MAX_MEMORY_S: f32 = 200.0;

impl PositionDrift {
    pub const NONE: Self = Self { moved_m: [0.0; 2], is_drifting: false };

    /// Adds a shift north and east, m.
    pub fn add(&mut self, moved_m: [f32; 2]) {
        for (sum, moved) in self.moved_m.iter_mut().zip(moved_m) {
            *sum += moved;
        }
    }

    /// Lets the shift decay over `elapsed_s`. The time constant is 20 s; while positions drift it is `taken_s`, the
    /// time for which positions were fused.
    pub fn forget(&mut self, elapsed_s: f32, taken_s: f32) {
        let memory_s = if self.is_drifting { taken_s } else { MIN_MEMORY_S };
        let left = 1.0 - elapsed_s / memory_s.clamp(MIN_MEMORY_S, MAX_MEMORY_S);
        self.moved_m = self.moved_m.map(|moved_m| left * moved_m);
    }

    /// Decides whether positions drift. A drift starts when the shift exceeds `least_m`, m, and ends when the shift is
    /// below half of `least_m`.
    pub fn judge(&mut self, least_m: f32) {
        let [north, east] = self.moved_m;
        self.is_drifting =
            libm::hypotf(north, east) > if self.is_drifting { 0.5 * least_m } else { least_m };
    }

    /// Offset of the position at the start of the drift, m, north and east.
    pub fn start_offset_m(&self) -> [f32; 2] {
        self.moved_m.map(|moved_m| -moved_m)
    }

    /// Drift of the positions, m; zero without a drift.
    pub fn drifted_m(&self) -> f32 {
        let [north, east] = self.moved_m;
        if self.is_drifting { libm::hypotf(north, east) } else { 0.0 }
    }
}
