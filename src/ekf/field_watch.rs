//! Whether the magnetic field is still what it was, by the two of its three parts that no heading changes.
//!
//! A current or iron nearby adds to the field. What it adds across the level field turns the heading, and cannot be
//! told from a turn; what it adds along it and downwards can be told, and is as large, for all that is known.

use super::square;
use crate::scalar::Scalar;

/// What is usual of a field, and what it was when the heading was last opened for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct FieldWatch {
    usual: Option<Parts>,
    opened_at: Parts,
    /// Variance of a part about what is usual, gauss².
    scatter: f32,
    /// One-sigma of what the field's distance from the usual makes of the heading, rad.
    pub doubt_rad: f32,
}

/// The parts of a field that do not change with the heading, gauss.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parts {
    pub level: f32,
    pub down: f32,
}

/// What a field has changed by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FieldChange {
    /// One-sigma of what the change since the heading was last opened for one makes of it, rad.
    pub sigma_rad: f32,
    /// Share of its strength by which the field is off what is usual.
    pub share: f32,
    /// Whether it came away from what is usual, or is back there; `None` while neither.
    pub disturbed: Option<bool>,
}

/// The field is not what it was beyond this share of its strength, and beyond so many one-sigmas of its scatter.
const CHANGED_SHARE: f32 = 0.1;
const CHANGED_SIGMAS: f32 = 4.0;
/// It is what it was again within this share of that.
const BACK_SHARE: f32 = 0.5;
/// What is usual is learned over this time, s, and over this where it is disturbed.
const USUAL_S: f32 = 60.0;
const DISTURBED_S: f32 = 600.0;
/// A heading is not in doubt by more, rad.
const MOST_RAD: f32 = 1.0;

impl FieldWatch {
    /// Has seen nothing.
    pub const NONE: Self = Self {
        usual: None,
        opened_at: Parts { level: 0.0, down: 0.0 },
        scatter: 0.0,
        doubt_rad: 0.0,
    };

    /// Takes in a field, levelled by an attitude whose tilt has this variance, rad², `elapsed_s` after the one before.
    /// Gives what it has changed by since the heading was last opened for a change, where that is more than its scatter
    /// and the tilt make of it, or where it came away from what is usual or back.
    ///
    /// # Source
    /// Equation (M15) of docs/equations.md.
    pub fn push(
        &mut self,
        field: Parts,
        tilt_variance: f32,
        elapsed_s: f32,
    ) -> Option<FieldChange> {
        let Some(usual) = self.usual.as_mut() else {
            (self.usual, self.opened_at) = (Some(field), field);
            return None;
        };
        // Squares, for roots take long and are needed only where something has changed.
        let strength = square(usual.level) + square(usual.down);
        let chance = self.scatter + strength * tilt_variance;
        let change = (square(CHANGED_SHARE) * strength).max(square(CHANGED_SIGMAS) * chance);
        let off = field.squared_distance(*usual);
        let was_usual = self.doubt_rad == 0.0;
        let is_usual = off <= if was_usual { change } else { change * square(BACK_SHARE) };
        let least_level = field.level.min(usual.level);
        let turn_rad = |change: f32| {
            // Two parts of three are seen.
            let across = Scalar::sqrt(0.5 * change);
            if least_level > 0.0 { (across / least_level).min(MOST_RAD) } else { MOST_RAD }
        };
        let learned_s = if is_usual { USUAL_S } else { DISTURBED_S };
        // Written so that a NaN teaches nothing.
        let newest = if elapsed_s > 0.0 { (elapsed_s / learned_s).min(1.0) } else { 0.0 };
        if is_usual {
            self.scatter += newest * (0.5 * off - self.scatter);
        }
        usual.level += newest * (field.level - usual.level);
        usual.down += newest * (field.down - usual.down);
        self.doubt_rad = if is_usual { 0.0 } else { turn_rad(off) };
        let moved = field.squared_distance(self.opened_at);
        let disturbed = (is_usual != was_usual).then_some(!is_usual);
        (moved > change || disturbed.is_some()).then(|| {
            self.opened_at = field;
            let share = Scalar::sqrt(off / strength);
            FieldChange { sigma_rad: turn_rad(moved), share, disturbed }
        })
    }
}

impl Parts {
    fn squared_distance(self, other: Self) -> f32 {
        square(self.level - other.level) + square(self.down - other.down)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EARTH: Parts = Parts { level: 0.3, down: 0.35 };

    /// A watch over readings 0.1 s apart, from the first on.
    fn watched(readings: &[Parts]) -> (FieldWatch, Vec<FieldChange>) {
        let mut watch = FieldWatch::NONE;
        let changes = readings.iter().filter_map(|&field| watch.push(field, 1e-4, 0.1)).collect();
        (watch, changes)
    }

    #[test]
    fn a_magnet_opens_the_heading_when_it_comes_and_when_it_goes_and_leaves_it_in_doubt_between() {
        let near = Parts { level: 0.4, down: 0.35 };
        let mut readings = [EARTH; 900];
        readings[300..600].fill(near);
        let (watch, changes) = watched(&readings);
        let [came, went] = changes[..] else { panic!("{changes:?}") };
        // 0.1 gauss of two parts leave 0.07 for the third, across 0.3 and more of level field.
        assert!((came.sigma_rad - 0.1 * 0.5_f32.sqrt() / 0.3).abs() < 1e-4, "{came:?}");
        assert_eq!((came.disturbed, went.disturbed), (Some(true), Some(false)));
        assert!((came.share - 0.1 / 0.3_f32.hypot(0.35)).abs() < 1e-4, "{came:?}");
        assert!((went.sigma_rad - came.sigma_rad).abs() < 0.02, "{went:?}");
        assert!(watch.doubt_rad == 0.0);
        assert!(watched(&readings[..500]).0.doubt_rad > 0.2);
    }

    #[test]
    fn a_field_that_scatters_about_what_it_was_changes_nothing() {
        let readings: Vec<Parts> = (0..3000)
            .map(|step| {
                let phase = 0.37 * step as f32;
                Parts { level: 0.3 + 0.02 * phase.sin(), down: 0.35 + 0.02 * phase.cos() }
            })
            .collect();
        assert!(watched(&readings).1.is_empty());
    }

    #[test]
    fn a_field_that_stays_changed_becomes_the_usual_one() {
        let mut readings = vec![EARTH; 12_000];
        readings[100..].fill(Parts { level: 0.36, down: 0.35 });
        let (watch, changes) = watched(&readings);
        assert_eq!(changes.len(), 2, "{changes:?}");
        assert!(watch.doubt_rad == 0.0);
    }

    #[test]
    fn readings_that_go_back_in_time_teach_nothing() {
        let mut watch = FieldWatch::NONE;
        let other = Parts { level: 0.31, down: 0.35 };
        for elapsed_s in [-1.0, 0.0, f32::NAN] {
            watch.push(EARTH, 1e-4, 0.1);
            assert!(watch.push(other, 1e-4, elapsed_s).is_none());
            assert!(watch.usual.is_some_and(|usual| usual.level == EARTH.level));
        }
    }
}
