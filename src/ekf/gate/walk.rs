//! Whether the places of fixes walk away from the velocity that they tell.

/// How far fixes have moved of late where the next is expected, other than with the vehicle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walk {
    /// North and east, m.
    moved_m: [f32; 2],
    /// Whether that is further than right ones do.
    walks: bool,
}

/// Memory of that, s, at least and at most.
const LEAST_MEMORY_S: f32 = 20.0;
const MOST_MEMORY_S: f32 = super::DISPUTED_MOST_S;

impl Walk {
    pub const NONE: Self = Self { moved_m: [0.0; 2], walks: false };

    /// Adds a move north and east, m.
    pub fn add(&mut self, moved_m: [f32; 2]) {
        for (sum, moved) in self.moved_m.iter_mut().zip(moved_m) {
            *sum += moved;
        }
    }

    /// Forgets what `elapsed_s` leave: in 20 s, or while places walk in the time that they have been taken in.
    pub fn forget(&mut self, elapsed_s: f32, taken_s: f32) {
        let memory_s = if self.walks { taken_s } else { LEAST_MEMORY_S };
        let left = 1.0 - elapsed_s / memory_s.clamp(LEAST_MEMORY_S, MOST_MEMORY_S);
        self.moved_m = self.moved_m.map(|moved_m| left * moved_m);
    }

    /// Judges it: places walk from `least_m` on until they are back within half of that.
    pub fn judge(&mut self, least_m: f32) {
        let [north, east] = self.moved_m;
        self.walks = libm::hypotf(north, east) > if self.walks { 0.5 * least_m } else { least_m };
    }

    /// How far places have walked, m; zero where they do not.
    pub fn walked_m(&self) -> f32 {
        let [north, east] = self.moved_m;
        if self.walks { libm::hypotf(north, east) } else { 0.0 }
    }
}
