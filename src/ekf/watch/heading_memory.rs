//! Memory of the readings of a heading source.

use crate::time::Time;

/// Largest innovation, rad, at which a rejected heading source agrees again.
const DISAGREED_RAD: f64 = 0.3;
/// Time of agreement, s, before a rejected heading source is used again.
const AGREED_S: f64 = 20.0;

/// Previous readings of a heading source.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct HeadingMemory {
    /// Time of the last used reading.
    pub used: Option<Time>,
    /// Time at which the source last disagreed with the filter's heading, after the filter rejected the source and
    /// turned. `None` if the source is accepted.
    pub disagreed_at: Option<Time>,
}

impl HeadingMemory {
    /// The memory before the first reading.
    pub const NONE: Self = Self { used: None, disagreed_at: None };

    /// Time since the last used reading, s; infinite without one.
    pub fn since_used_s(&self, time: Time) -> f64 {
        self.used.map_or(f64::INFINITY, |used| time - used)
    }

    /// Whether the source is accepted, at an innovation of `off_rad`. After the filter turned away from the source, the
    /// source must first agree for [`AGREED_S`].
    pub fn accepts(&mut self, time: Time, off_rad: f64) -> bool {
        let Some(disagreed) = self.disagreed_at else { return true };
        if libm::fabs(off_rad) > DISAGREED_RAD {
            self.disagreed_at = Some(time);
        } else if time - disagreed > AGREED_S {
            self.disagreed_at = None;
        }
        self.disagreed_at.is_none()
    }
}
