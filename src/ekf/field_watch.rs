//! Whether the magnetic field is still what it was, by the two of its three parts that no heading changes.
//!
//! A current or iron nearby adds to the field. What it adds across the level field turns the heading, and cannot be
//! told from a turn; what it adds along it and downwards can be told, and is as large, for all that is known.

use super::{root, square};
use crate::time::Time;

/// What is usual of a field, and what it was when the heading was last opened for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct FieldWatch {
    /// When a reading was last looked at.
    seen: Time,
    /// Zero before the first reading, which no field is.
    usual: Parts,
    opened_at: Parts,
    /// Variance of a part about what is usual, gauss².
    scatter: f32,
    /// For how long the field has been what is usual, s, and how long it has stood still elsewhere.
    usual_s: f32,
    elsewhere_s: f32,
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
    pub begins_or_ends: Option<Turn>,
}

/// Where a disturbance begins or ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turn {
    /// The field came away from what is usual.
    Away,
    /// It is back.
    Back,
    /// It has stood elsewhere for so long that this is the usual now.
    Settled,
}

/// The field is not what it was beyond this share of its strength, and beyond so many one-sigmas of its scatter.
const CHANGED_SHARE: f32 = 0.1;
const CHANGED_SIGMAS: f32 = 4.0;
/// It is what it was again within this share of that.
const BACK_SHARE: f32 = 0.5;
/// What is usual is learned over this time, s, less as long as it is not known for as long.
const USUAL_S: f32 = 60.0;
/// A field that stands still elsewhere for twice as long as the usual one was there is the usual one, after no less
/// than the first and no more than the second of these times, s.
const SETTLED_S: [f32; 2] = [5.0, 180.0];
/// Readings further apart, s, count as so far apart.
const LONGEST_S: f32 = 1.0;
/// A heading is not in doubt by more, rad.
const MOST_RAD: f32 = 1.0;

impl FieldWatch {
    /// Has seen nothing.
    pub const NONE: Self = Self {
        seen: Time::ZERO,
        usual: Parts { level: 0.0, down: 0.0 },
        opened_at: Parts { level: 0.0, down: 0.0 },
        scatter: 0.0,
        usual_s: 0.0,
        elsewhere_s: 0.0,
        doubt_rad: 0.0,
    };

    /// Whether a reading at `time` comes at least `interval_s` after the last one that was looked at.
    pub fn is_due(&self, time: Time, interval_s: f64) -> bool {
        !self.has_seen() || time - self.seen >= interval_s
    }

    fn has_seen(&self) -> bool {
        self.usual.level + self.usual.down.abs() > 0.0
    }

    /// Takes in a field, levelled by an attitude whose tilt has this variance, rad². Gives what it has changed by since
    /// the heading was last opened for a change, where that is more than its scatter and the tilt make of it, or where
    /// it came away from what is usual or is usual again.
    ///
    /// # Source
    /// Equation (M15) of docs/equations.md.
    pub fn push(&mut self, time: Time, field: Parts, tilt_variance: f32) -> Option<FieldChange> {
        let is_first = !self.has_seen();
        let before = core::mem::replace(&mut self.seen, time);
        if is_first {
            (self.usual, self.opened_at) = (field, field);
            return None;
        }
        let elapsed_s = ((time - before) as f32).clamp(0.0, LONGEST_S);
        // Squares, for roots take long and are needed only where something has changed.
        let strength = square(self.usual.level) + square(self.usual.down);
        let chance = self.scatter + strength * tilt_variance;
        let change = (square(CHANGED_SHARE) * strength).max(square(CHANGED_SIGMAS) * chance);
        let off = field.squared_distance(self.usual);
        let moved = field.squared_distance(self.opened_at);
        let was_usual = self.doubt_rad == 0.0;
        let is_back = off <= if was_usual { change } else { change * square(BACK_SHARE) };
        let is_still = moved <= change;
        self.elsewhere_s = if is_back || !is_still { 0.0 } else { self.elsewhere_s + elapsed_s };
        let [least_s, most_s] = SETTLED_S;
        let is_settled = self.elsewhere_s > (2.0 * self.usual_s).clamp(least_s, most_s);
        let least_level = field.level.min(self.usual.level);
        let turn_rad = |change: f32| {
            // Two parts of three are seen.
            let across = root(0.5 * change);
            if least_level > 0.0 { (across / least_level).min(MOST_RAD) } else { MOST_RAD }
        };
        if is_settled {
            self.usual = field;
            (self.usual_s, self.elsewhere_s) = (self.elsewhere_s, 0.0);
        } else if is_back {
            self.usual_s = (self.usual_s + elapsed_s).min(most_s);
            let newest = if elapsed_s > 0.0 { elapsed_s / self.usual_s.min(USUAL_S) } else { 0.0 };
            self.scatter += newest * (0.5 * off - self.scatter);
            self.usual.level += newest * (field.level - self.usual.level);
            self.usual.down += newest * (field.down - self.usual.down);
        }
        self.doubt_rad = if is_back || is_settled { 0.0 } else { turn_rad(off) };
        let begins_or_ends = match (was_usual, is_back) {
            (true, false) if !is_settled => Some(Turn::Away),
            (false, true) => Some(Turn::Back),
            (false, false) if is_settled => Some(Turn::Settled),
            _ => None,
        };
        (!is_still || begins_or_ends.is_some()).then(|| {
            self.opened_at = field;
            let share = root(off / strength);
            FieldChange { sigma_rad: turn_rad(moved), share, begins_or_ends }
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

    fn at(step: i64) -> Time {
        Time::from_nanoseconds(step * 100_000_000)
    }

    /// A watch over readings 0.1 s apart, from the first on.
    fn watched(readings: &[Parts]) -> (FieldWatch, Vec<FieldChange>) {
        let mut watch = FieldWatch::NONE;
        let changes = (0_i64..)
            .zip(readings)
            .filter_map(|(step, &field)| watch.push(at(step), field, 1e-4))
            .collect();
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
        assert_eq!(
            [came, went].map(|change| change.begins_or_ends),
            [Some(Turn::Away), Some(Turn::Back)]
        );
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
        let turns: Vec<_> = changes.iter().map(|change| change.begins_or_ends).collect();
        assert_eq!(turns, [Some(Turn::Away), Some(Turn::Settled)]);
        assert!(watch.doubt_rad == 0.0);
    }

    /// A magnet at the start, for 0.3 and for 30 s, costs no more than twice that afterwards.
    #[test]
    fn what_the_field_was_at_the_start_is_soon_forgotten() {
        for (wrong, doubted) in [(3, 60), (300, 700)] {
            let mut readings = vec![EARTH; wrong + doubted];
            readings[..wrong].fill(Parts { level: 0.9, down: 1.05 });
            assert!(watched(&readings).0.doubt_rad == 0.0, "{wrong}");
            assert!(watched(&readings[..wrong + 20]).0.doubt_rad > 0.2, "{wrong}");
        }
    }

    #[test]
    fn readings_that_go_back_in_time_teach_nothing() {
        let (mut watch, _) = watched(&[EARTH; 100]);
        let usual = watch.usual.level;
        assert!(watch.push(at(-10), Parts { level: 0.31, down: 0.35 }, 1e-4).is_none());
        assert!(watch.usual.level == usual);
    }
}
