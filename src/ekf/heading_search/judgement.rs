//! Judgement of a known heading by the fixes.

use crate::time::Time;

/// Minimum duration of a disagreement, s.
const WRONG_S: f64 = 5.0;
/// Minimum number of fixes of a disagreement.
const WRONG_FIXES: u8 = 4;

/// Disagreement of the fixes with a heading.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judgement {
    wrong_since: Option<Time>,
    wrong_fixes: u8,
    /// Whether the hypotheses agree with the heading, and recent motion was enough to show it.
    pub is_confirmed: bool,
}

impl Judgement {
    pub const NONE: Self = Self { wrong_since: None, wrong_fixes: 0, is_confirmed: false };

    pub fn forget(&mut self) {
        (self.wrong_fixes, self.is_confirmed) = (0, false);
    }

    /// Notes whether a fix disagrees. Returns whether at least [`WRONG_FIXES`] successive fixes have disagreed for
    /// [`WRONG_S`]. If so, the count restarts.
    pub fn lasts(&mut self, time: Time, disagrees: bool) -> bool {
        if !disagrees {
            self.wrong_fixes = 0;
            return false;
        }
        if self.wrong_fixes == 0 {
            self.wrong_since = Some(time);
        }
        self.wrong_fixes = self.wrong_fixes.saturating_add(1);
        let since = self.wrong_since.is_some_and(|since| time - since >= WRONG_S);
        let lasts = since && self.wrong_fixes >= WRONG_FIXES;
        if lasts {
            self.wrong_fixes = 0;
        }
        lasts
    }
}
