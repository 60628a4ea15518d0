//! Whether a log can be what its set-up says: units, signs, axes, clocks.
//!
//! Gravity, the unit's own attitude, the fixes' own velocity and the Earth's magnetic field are
//! witnesses that need no estimator. Each is asked only for what is certain, or nearly: a wrong alarm
//! would teach people not to read.

mod alternatives;
mod attitude;
mod clocks;
mod fixes;
mod gravity;
mod magnetic;
mod regression;

use std::path::Path;

use hovernav::earth::STANDARD_GRAVITY_MPS2;

use crate::dataset::Dataset;
use crate::error::LogError;
use crate::finding::SetupFinding;
use crate::rates::{Rates, rates};

pub use alternatives::alternative;

impl Dataset {
    /// What of this log's set-up cannot be, the certain first: see [`SetupFinding`]. Reads no
    /// reference and runs no filter.
    #[must_use]
    pub fn check_setup(&self) -> Vec<SetupFinding> {
        let log = Judged { dataset: self, rates: rates(&self.imu) };
        let mut found = Vec::new();
        clocks::check(&log, &mut found);
        gravity::check(&log, &mut found);
        attitude::check(&log, &mut found);
        fixes::check(&log, &mut found);
        magnetic::check(&log, &mut found);
        found.sort_by_key(|finding| !finding.is_certain);
        found
    }
}

impl Dataset {
    /// Refuses a log whose set-up certainly cannot be; `path` names it in the message.
    ///
    /// # Errors
    /// [`LogError::Setup`] with all that cannot be, its likely cause and how to mend it.
    pub fn ensure_possible(&self, path: &Path) -> Result<(), LogError> {
        let mut findings = self.check_setup();
        findings.retain(|finding| finding.is_certain);
        if findings.is_empty() {
            return Ok(());
        }
        Err(LogError::Setup { path: path.to_path_buf(), findings })
    }
}

struct Judged<'a> {
    dataset: &'a Dataset,
    rates: Vec<Rates>,
}

/// Means over a second or so: vibration is gone, motion is still there.
struct Second {
    turn_radps: [f64; 3],
    force_mps2: [f64; 3],
}

impl Judged<'_> {
    /// Means over each `length_s` of the log; parts with fewer than three samples are left out.
    fn means(&self, length_s: f64) -> Vec<Second> {
        let Some(first) = self.rates.first() else { return Vec::new() };
        let part = |at: &Rates| ((at.time - first.time) / length_s) as u64;
        let parts = self.rates.chunk_by(|a, b| part(a) == part(b));
        let mean = |part: &[Rates], of: fn(&Rates) -> [f64; 3]| {
            let sum = part.iter().map(of).fold([0.0; 3], |s, v| [0, 1, 2].map(|i| s[i] + v[i]));
            sum.map(|sum| sum / part.len() as f64)
        };
        parts
            .filter(|part| part.len() >= 3)
            .map(|part| Second {
                turn_radps: mean(part, |at| at.turn_radps),
                force_mps2: mean(part, |at| at.force_mps2),
            })
            .collect()
    }
}

fn norm([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

const G: f64 = STANDARD_GRAVITY_MPS2;
