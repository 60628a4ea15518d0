//! Monitor of the magnetic field for changes.
//!
//! A current or iron nearby adds a disturbance to the field. Its components along the horizontal field and downwards do
//! not depend on the heading, so they are observable. Its component across the horizontal field turns the measured
//! heading. The gyros show a turn of the field that is faster than their drift. A slower turn is unobservable; the
//! component across is then assumed to be as large as the others.

use super::{OUTLIER_SIGMAS, READING_S};
use crate::frames::wrap_angle;
use crate::matrix::square;
use crate::scalar::root;
use crate::time::Time;

/// Monitor of the field: the usual field, and the field at the last change that raised the heading variance.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct FieldWatch {
    /// Time of the last evaluated magnetic reading.
    seen: Time,
    /// Usual field. Zero before the first reading; a real field is never zero.
    usual: Parts,
    /// Field at the last change that raised the heading variance.
    opened_at: Parts,
    /// Variance of a component about the usual field, gauss².
    scatter: f32,
    /// Time for which the field was usual, s.
    usual_s: f32,
    /// Time for which a changed field has been constant, s.
    elsewhere_s: f32,
    /// One-sigma of the heading error due to the field's difference from the usual field, rad.
    pub heading_sigma_rad: f32,
    /// Change by the last reading if it is the first unusual one, as a fraction of the field strength; zero otherwise.
    suspect: f32,
}

/// Magnetic field resolved with the filter's attitude: components and azimuth.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct Parts {
    /// Horizontal and vertical components, which do not change with the heading, gauss.
    pub level: f32,
    pub down: f32,
    /// Azimuth from the filter's north, rad.
    pub azimuth_rad: f32,
}

/// Uncertainty of the filter's attitude.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct AttitudeUncertainty {
    pub tilt_variance: f32,
    pub heading_variance: f32,
    /// Whether the gyros may have missed a recent turn.
    pub turned: bool,
}

/// Change of the field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::ekf) struct FieldChange {
    /// One-sigma of the heading error due to the change since the heading variance was last raised, rad.
    pub sigma_rad: f32,
    /// Difference from the usual field, as a fraction of the field strength.
    pub share: f32,
    pub turn: Option<Turn>,
}

/// Event at the start, during or at the end of a disturbance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::ekf) enum Turn {
    /// One reading is unusual. It may be a spike; a second one makes it [`Away`](Self::Away).
    Suspect,
    /// The field departed from the usual one.
    Away,
    /// The field returned to the usual one.
    Back,
    /// The changed field has lasted longer than the initial field. The initial field was therefore disturbed, and the
    /// present field becomes the usual one.
    Settled,
    /// A changed field has been constant for long enough that either field may be the Earth's.
    Lasting,
}

/// Smallest change of the field that counts, as a fraction of its strength.
const CHANGED_SHARE: f32 = 0.1;
/// Smallest change of the field that counts, in one-sigmas of its scatter.
const CHANGED_SIGMAS: f32 = 4.0;
/// Smallest turn of the field that counts, rad.
const TURNED_RAD: f32 = 0.17;
/// Time constant of the usual azimuth, s. Only a faster turn of the field counts.
const AZIMUTH_S: f32 = 15.0;
/// Fraction of the limits within which the field counts as returned.
const BACK_SHARE: f32 = 0.5;
/// Time constant of the usual field, s. It is shorter while the field has been observed for less time.
const USUAL_S: f32 = 60.0;
/// Shortest and longest time, s, after which a changed field may be the Earth's. Between them it is twice the time for
/// which the usual field was observed.
const LASTING_S: [f32; 2] = [5.0, 180.0];
/// Minimum time, s, for which a usual field must have been observed. A field observed for less may be a disturbance at
/// the start.
const WRONG_START_S: f32 = 30.0;
/// Largest heading one-sigma assumed for the unobserved component, rad.
const MAX_RAD: f32 = 1.0;

impl FieldWatch {
    /// State before the first reading.
    pub const NONE: Self = Self {
        seen: Time::ZERO,
        usual: Parts::NONE,
        opened_at: Parts::NONE,
        scatter: 0.0,
        usual_s: 0.0,
        elsewhere_s: 0.0,
        heading_sigma_rad: 0.0,
        suspect: 0.0,
    };

    /// Whether a reading at `time` comes at least `interval_s` after the last evaluated one.
    pub fn is_due(&self, time: Time, interval_s: f64) -> bool {
        !self.has_reading() || time - self.seen >= interval_s
    }

    /// Whether the last reading was the first unusual one.
    pub fn is_suspect(&self) -> bool {
        self.suspect > 0.0
    }

    fn has_reading(&self) -> bool {
        self.usual.level + self.usual.down.abs() > 0.0
    }

    /// Feeds a field that was resolved with an attitude of this `uncertainty`. The reference is the field at the last
    /// increase of the heading variance. Returns the change from the reference if it exceeds the scatter and the
    /// attitude error. Also returns the start and the end of a disturbance: see [`Turn`].
    ///
    /// # Source
    /// Equation (M15) of docs/equations.md.
    pub fn push(
        &mut self,
        time: Time,
        field: Parts,
        uncertainty: &AttitudeUncertainty,
    ) -> Option<FieldChange> {
        let is_first = !self.has_reading();
        let before = core::mem::replace(&mut self.seen, time);
        if is_first {
            (self.usual, self.opened_at) = (field, field);
            return None;
        }
        if uncertainty.turned {
            (self.usual.azimuth_rad, self.opened_at.azimuth_rad) =
                (field.azimuth_rad, field.azimuth_rad);
        }
        let elapsed_s = (time - before).clamp(0.0, READING_S) as f32;
        let min_level = field.level.min(self.usual.level);
        // Squares are compared: roots are slow, and needed only after a change.
        let strength = square(self.usual.level) + square(self.usual.down);
        let [min_s, max_s] = LASTING_S;
        let lasting_s = (2.0 * self.usual_s).clamp(min_s, max_s);
        let lasted = self.elsewhere_s > lasting_s;
        let chance = square(CHANGED_SIGMAS) * (self.scatter + strength * uncertainty.tilt_variance);
        // A heading variance that was raised because of the field must not make the field count as returned.
        let heading_variance = uncertainty.heading_variance.min(square(TURNED_RAD));
        let limit = Change {
            parts: (square(CHANGED_SHARE) * strength).max(chance),
            turn: square(TURNED_RAD)
                .max(square(OUTLIER_SIGMAS as f32) * heading_variance)
                .max(chance / square(min_level).max(f32::MIN_POSITIVE)),
        };
        let was_usual = self.heading_sigma_rad == 0.0;
        if was_usual {
            // The azimuth may drift slowly with the gyros.
            self.opened_at.azimuth_rad = self.usual.azimuth_rad;
        }
        let off = field.change_from(self.usual);
        let moved = field.change_from(self.opened_at);
        let is_back = off.is_within(&limit, if was_usual { 1.0 } else { square(BACK_SHARE) });
        let suspect = core::mem::take(&mut self.suspect);
        if was_usual && !is_back && suspect == 0.0 {
            let share = off.share(&field, strength);
            self.suspect = share;
            return Some(FieldChange { sigma_rad: 0.0, share, turn: Some(Turn::Suspect) });
        }
        let is_still = moved.is_within(&limit, 1.0);
        self.elsewhere_s = if is_back || !is_still { 0.0 } else { self.elsewhere_s + elapsed_s };
        let lasts = self.elsewhere_s > lasting_s;
        let is_settled = lasts && self.usual_s < WRONG_START_S;
        let turn_rad = |change: &Change| {
            // Two of the three components are observed directly.
            let across = root(0.5 * change.parts);
            let unseen_rad = if min_level > 0.0 { across / min_level } else { MAX_RAD };
            unseen_rad.min(MAX_RAD).max(root(change.turn))
        };
        if is_settled {
            self.usual = field;
            (self.usual_s, self.elsewhere_s) = (self.elsewhere_s, 0.0);
        } else if is_back {
            self.usual_s = (self.usual_s + elapsed_s).min(max_s);
            let newest = if elapsed_s > 0.0 { elapsed_s / self.usual_s.min(USUAL_S) } else { 0.0 };
            self.scatter += newest * (0.5 * off.parts - self.scatter);
            self.usual.level += newest * (field.level - self.usual.level);
            self.usual.down += newest * (field.down - self.usual.down);
            let newest = (elapsed_s / AZIMUTH_S).min(1.0);
            self.usual.azimuth_rad += newest * field.turn_from(self.usual);
        }
        self.heading_sigma_rad = if is_back || is_settled { 0.0 } else { turn_rad(&off) };
        let turn = match (was_usual, is_back) {
            (true, false) => Some(Turn::Away),
            (false, true) => Some(Turn::Back),
            (false, false) if is_settled => Some(Turn::Settled),
            (false, false) if lasts && !lasted => Some(Turn::Lasting),
            _ => None,
        };
        (!is_still || turn.is_some()).then(|| {
            self.opened_at = field;
            let share = off.share(&field, strength);
            // For a departure, the smaller fraction of both readings.
            let share = if turn == Some(Turn::Away) { share.min(suspect) } else { share };
            FieldChange { sigma_rad: turn_rad(&moved), share, turn }
        })
    }
}

/// Squared differences of two fields: of the components independent of the heading, gauss², and of the azimuth, rad².
#[derive(Clone, Copy, Debug)]
struct Change {
    parts: f32,
    turn: f32,
}

impl Change {
    /// Magnitude of the change as a fraction of the field strength. `strength` is the square of the field strength,
    /// gauss². The horizontal component of `field` converts the azimuth change to gauss.
    fn share(&self, field: &Parts, strength: f32) -> f32 {
        root((self.parts + self.turn * square(field.level)) / strength)
    }

    fn is_within(&self, limit: &Self, share: f32) -> bool {
        self.parts <= share * limit.parts && self.turn <= share * limit.turn
    }
}

impl Parts {
    const NONE: Self = Self { level: 0.0, down: 0.0, azimuth_rad: 0.0 };

    fn change_from(self, other: Self) -> Change {
        Change {
            parts: square(self.level - other.level) + square(self.down - other.down),
            turn: square(self.turn_from(other)),
        }
    }

    fn turn_from(self, other: Self) -> f32 {
        wrap_angle(self.azimuth_rad - other.azimuth_rad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SURE: AttitudeUncertainty =
        AttitudeUncertainty { tilt_variance: 1e-4, heading_variance: 1e-3, turned: false };
    const EARTH: Parts = Parts { level: 0.3, down: 0.35, azimuth_rad: 0.0 };

    fn at(step: i64) -> Time {
        Time::from_nanoseconds(step * 100_000_000)
    }

    /// Result of readings 0.1 s apart.
    fn watched(readings: &[Parts]) -> (FieldWatch, Vec<FieldChange>) {
        let mut watch = FieldWatch::NONE;
        let changes = (0_i64..)
            .zip(readings)
            .filter_map(|(step, &field)| watch.push(at(step), field, &SURE))
            .filter(|change| change.turn != Some(Turn::Suspect))
            .collect();
        (watch, changes)
    }

    #[test]
    fn a_magnet_opens_the_heading_when_it_comes_and_when_it_goes_and_leaves_it_in_doubt_between() {
        let near = Parts { level: 0.4, down: 0.35, ..EARTH };
        let mut readings = [EARTH; 900];
        readings[300..600].fill(near);
        let (watch, changes) = watched(&readings);
        let [came, went] = changes[..] else { panic!("{changes:?}") };
        // A change of 0.1 gauss over two components suggests 0.07 for the third, relative to a horizontal field of at
        // least 0.3.
        assert!((came.sigma_rad - 0.1 * 0.5_f32.sqrt() / 0.3).abs() < 1e-4, "{came:?}");
        assert_eq!([came, went].map(|change| change.turn), [Some(Turn::Away), Some(Turn::Back)]);
        assert!((came.share - 0.1 / 0.3_f32.hypot(0.35)).abs() < 1e-4, "{came:?}");
        assert!((went.sigma_rad - came.sigma_rad).abs() < 0.02, "{went:?}");
        assert!(watch.heading_sigma_rad == 0.0);
        assert!(watched(&readings[..500]).0.heading_sigma_rad > 0.2);
    }

    #[test]
    fn a_field_that_turns_at_a_stroke_is_elsewhere_and_one_that_turns_as_gyros_drift_is_not() {
        let mut readings = [EARTH; 900];
        readings[300..600].fill(Parts { azimuth_rad: 0.5, ..EARTH });
        let (watch, changes) = watched(&readings);
        let turns: Vec<_> = changes.iter().map(|change| change.turn).collect();
        assert_eq!(turns, [Some(Turn::Away), Some(Turn::Back)]);
        assert!(changes.iter().all(|change| (change.sigma_rad - 0.5).abs() < 0.01), "{changes:?}");
        assert!(watch.heading_sigma_rad == 0.0);
        // A full turn at 0.3 °/s.
        let drifting: Vec<Parts> = (0..12_000)
            .map(|step| {
                let azimuth_rad = wrap_angle((0.03 * step as f32).to_radians());
                Parts { azimuth_rad, ..EARTH }
            })
            .collect();
        assert!(watched(&drifting).1.is_empty());
    }

    /// After a gap or a saturated gyro, the turn of the vehicle is unknown.
    #[test]
    fn a_turn_that_gyros_may_have_missed_is_none_of_the_field() {
        let (mut watch, _) = watched(&[EARTH; 100]);
        let turned = Parts { azimuth_rad: 2.0, ..EARTH };
        let missed = AttitudeUncertainty { turned: true, ..SURE };
        assert!(watch.push(at(100), turned, &missed).is_none());
        assert!(watch.push(at(101), turned, &SURE).is_none());
    }

    #[test]
    fn a_field_that_scatters_about_what_it_was_changes_nothing() {
        let readings: Vec<Parts> = (0..3000)
            .map(|step| {
                let phase = 0.37 * step as f32;
                Parts { level: 0.3 + 0.02 * phase.sin(), down: 0.35 + 0.02 * phase.cos(), ..EARTH }
            })
            .collect();
        assert!(watched(&readings).1.is_empty());
    }

    /// A field changes after 10 s and stays changed.
    #[test]
    fn a_field_that_stays_changed_is_the_usual_one_where_that_was_of_the_start_alone() {
        let mut readings = vec![EARTH; 12_000];
        readings[100..].fill(Parts { level: 0.36, down: 0.35, ..EARTH });
        let (watch, changes) = watched(&readings);
        let turns: Vec<_> = changes.iter().map(|change| change.turn).collect();
        assert_eq!(turns, [Some(Turn::Away), Some(Turn::Settled)]);
        assert!(watch.heading_sigma_rad == 0.0);
    }

    /// A load switched on in flight turns the field permanently.
    #[test]
    fn a_field_that_was_right_for_long_and_stays_changed_is_told_once_and_doubted_for_good() {
        let mut readings = vec![EARTH; 12_000];
        readings[1000..].fill(Parts { level: 0.36, down: 0.35, azimuth_rad: 0.4 });
        let (watch, changes) = watched(&readings);
        let turns: Vec<_> = changes.iter().map(|change| change.turn).collect();
        assert_eq!(turns, [Some(Turn::Away), Some(Turn::Lasting)]);
        assert!(watch.heading_sigma_rad > 0.3);
        readings[5000..].fill(EARTH);
        assert!(watched(&readings).0.heading_sigma_rad == 0.0);
    }

    /// A magnet at the start, for 0.3 or 30 s, spoils the field for at most twice that time afterwards.
    #[test]
    fn what_the_field_was_at_the_start_is_soon_forgotten() {
        for (wrong, doubted) in [(3, 60), (300, 700)] {
            let mut readings = vec![EARTH; wrong + doubted];
            readings[..wrong].fill(Parts { level: 0.9, down: 1.05, ..EARTH });
            assert!(watched(&readings).0.heading_sigma_rad == 0.0, "{wrong}");
            assert!(watched(&readings[..wrong + 20]).0.heading_sigma_rad > 0.2, "{wrong}");
        }
    }

    #[test]
    fn readings_that_go_back_in_time_teach_nothing() {
        let (mut watch, _) = watched(&[EARTH; 100]);
        let usual = watch.usual.level;
        assert!(watch.push(at(-10), Parts { level: 0.31, down: 0.35, ..EARTH }, &SURE).is_none());
        assert!(watch.usual.level == usual);
    }

    #[test]
    fn a_spike_is_told_as_one_and_changes_nothing() {
        let mut watch = FieldWatch::NONE;
        for step in 0..600 {
            let is_spike = step > 50 && step % 20 == 0;
            let field =
                if is_spike { Parts { level: 0.1, down: 1.0, azimuth_rad: 2.0 } } else { EARTH };
            let change = watch.push(at(step), field, &SURE);
            assert_eq!(change.map(|change| change.turn), is_spike.then_some(Some(Turn::Suspect)));
            assert_eq!((watch.is_suspect(), watch.heading_sigma_rad), (is_spike, 0.0));
        }
    }
}
