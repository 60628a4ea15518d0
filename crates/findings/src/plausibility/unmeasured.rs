//! Velocity columns that are not filled: velocities of exactly zero while the positions move.

use std::borrow::Cow;
use std::ops::Range;

use hovernav::gps::Fix;

use super::regression::norm;
use crate::finding::{Sensor, SetupFinding};
use hovernav_dataset::statistics::quantile;

/// Length of the parts, s, within which positions are compared: the first third with the last.
const PART_S: f64 = 10.0;
/// Smallest number of moving parts that proves zeros false; the jumps of a standing receiver reach fewer.
const MIN_MOVING: usize = 3;
/// Smallest distance within a part, m, horizontal and vertical.
const MIN_M: [f64; 2] = [4.0, 6.0];
/// Smallest distance within a part, in stated one-sigmas; the larger limit applies.
const SIGMAS: f64 = 3.0;
/// Largest distance of the fixes from a motion at constant velocity, relative to the distance moved.
const UNSTEADY: f64 = 1.0 / 3.0;

/// Velocities of exactly zero that no sensor measured.
#[derive(Debug)]
pub(crate) struct Unmeasured {
    /// For each fix, whether its horizontal and its vertical velocity are unmeasured zeros.
    zeros: Vec<[bool; 2]>,
    /// Largest distance of such fixes from the first one, m, horizontal and vertical.
    moved_m: [f64; 2],
}

impl Unmeasured {
    /// The zero velocities of `fixes` that no sensor measured; `None` if all velocities are plausible.
    pub fn of(fixes: &[Fix]) -> Option<Self> {
        let level = |fix: &Fix| fix.horizontal_velocity_mps == Some([0.0; 2]);
        let down = |fix: &Fix| fix.down_velocity_mps == Some(0.0);
        let mut zeros = vec![[false; 2]; fixes.len()];
        let mut moved_m = [0.0_f64; 2];
        for run in runs(fixes, level) {
            if let Some(far_m) = moved(&fixes[run.clone()], [0, 1], MIN_M[0]) {
                moved_m[0] = moved_m[0].max(far_m);
                // A measured velocity has noise, so a vertical velocity of exactly zero is unmeasured too.
                run.for_each(|index| zeros[index] = [true, down(&fixes[index])]);
            }
        }
        for run in runs(fixes, |fix| down(fix) && !fix.two_dimensional) {
            if let Some(far_m) = moved(&fixes[run.clone()], [2], MIN_M[1]) {
                moved_m[1] = moved_m[1].max(far_m);
                run.for_each(|index| zeros[index] = [level(&fixes[index]), true]);
            }
        }
        (moved_m != [0.0; 2]).then_some(Self { zeros, moved_m })
    }

    /// Removes the unmeasured velocities from `fixes`.
    pub fn take_out(&self, fixes: &mut [Fix]) {
        for (fix, [level, down]) in fixes.iter_mut().zip(&self.zeros) {
            fix.horizontal_velocity_mps = fix.horizontal_velocity_mps.filter(|_| !level);
            fix.down_velocity_mps = fix.down_velocity_mps.filter(|_| !down);
        }
    }

    /// The `fixes` without the unmeasured velocities.
    pub fn without<'a>(found: Option<&Self>, fixes: &'a [Fix]) -> Cow<'a, [Fix]> {
        let mut fixes = Cow::Borrowed(fixes);
        if let Some(found) = found {
            found.take_out(fixes.to_mut());
        }
        fixes
    }

    /// Finding for the unmeasured velocities among `fixes`.
    pub fn finding(&self, fixes: &[Fix]) -> SetupFinding {
        let count =
            |is_one: fn(&[bool; 2]) -> bool| self.zeros.iter().filter(|zero| is_one(zero)).count();
        let (level, down) = (count(|zero| zero[0]), count(|zero| zero[1]));
        let (which, columns) = match (level, down) {
            (_, 0) => ("horizontal", "vn_mps and ve_mps"),
            (0, _) => ("vertical", "vd_mps"),
            _ => ("horizontal and vertical", "vn_mps, ve_mps and vd_mps"),
        };
        let is_one: fn(&[bool; 2]) -> bool = |zero| zero[0] || zero[1];
        let time_s = |index: Option<usize>| index.map_or(0.0, |at| fixes[at].time.seconds());
        let first_s = time_s(self.zeros.iter().position(is_one));
        let last_s = time_s(self.zeros.iter().rposition(is_one));
        let moved = match self.moved_m {
            [level_m, 0.0] => format!("{level_m:.0} m"),
            [0.0, down_m] => format!("{down_m:.0} m in height"),
            [level_m, down_m] => format!("{level_m:.0} m, and {down_m:.0} m in height"),
        };
        let count = count(is_one);
        let mend = match count == fixes.len() {
            true => format!("remove {columns} from gps.csv"),
            false => format!("leave {columns} empty in these fixes"),
        };
        SetupFinding {
            sensor: Sensor::GpsVelocity,
            is_certain: true,
            found: format!(
                "exactly 0, {which}, in {count} of {} fixes from {first_s:.1} to {last_s:.1} s, while the positions moved \
                 {moved}",
                fixes.len()
            ),
            cause: "the receiver or the logger does not fill these columns".into(),
            mend: format!("log the receiver's velocity, or {mend}"),
        }
    }
}

/// Runs of successive fixes for which `zero` holds.
fn runs(fixes: &[Fix], zero: impl Fn(&Fix) -> bool) -> Vec<Range<usize>> {
    let mut start = 0;
    let chunks = fixes.chunk_by(|a, b| zero(a) == zero(b)).map(|run| {
        start += run.len();
        start - run.len()..start
    });
    chunks.filter(|run| zero(&fixes[run.start])).collect()
}

/// Largest distance of `run` from its first fix along `axes`, m; `None` if fewer than `MIN_MOVING` parts of `PART_S`
/// move.
fn moved<const D: usize>(run: &[Fix], axes: [usize; D], least_m: f64) -> Option<f64> {
    let first = run.first()?;
    let mut sigmas_m: Vec<f64> = (run.iter())
        .filter_map(|fix| fix.position_sigma_m)
        .map(|sigma| axes.map(|axis| sigma.to_array()[axis]).into_iter().fold(0.0, f64::max))
        .collect();
    let least_m = least_m.max(SIGMAS * quantile(&mut sigmas_m, 0.5).unwrap_or(0.0));
    let (mut moving, mut far_m, mut rest) = (0, 0.0_f64, run);
    while let Some(start) = rest.first() {
        let within = |from: &[Fix], length_s: f64| {
            from.iter().take_while(|fix| fix.time - start.time < length_s).count()
        };
        let (part, after) = rest.split_at(within(rest, PART_S));
        let ends = [within(part, PART_S / 3.0), within(part, 2.0 * PART_S / 3.0)];
        rest = after;
        let Some(ends) = Ends::of(first, part, ends, axes) else { continue };
        far_m = far_m.max(norm(ends.last));
        let moved_m =
            norm(std::array::from_fn::<f64, D, _>(|axis| ends.last[axis] - ends.first[axis]));
        if moved_m > least_m && ends.unsteady_m < UNSTEADY * moved_m {
            moving += 1;
        }
    }
    (moving >= MIN_MOVING).then_some(far_m)
}

/// Median positions in the first and the last third of a part, m. Also the median distance, m, of the part's fixes from
/// a motion at constant velocity between these positions.
struct Ends<const D: usize> {
    first: [f64; D],
    last: [f64; D],
    unsteady_m: f64,
}

impl<const D: usize> Ends<D> {
    /// Positions of a `part` relative to `from`; its thirds end before the fixes at `ends`. `None` if a third is empty.
    fn of(from: &Fix, part: &[Fix], ends: [usize; 2], axes: [usize; D]) -> Option<Self> {
        let position = |fix: &Fix| {
            let moved = fix.position.displacement_from(&from.position).to_array();
            axes.map(|axis| moved[axis])
        };
        let median = |of: &[Fix], value: &dyn Fn(&Fix) -> f64| {
            quantile(&mut of.iter().map(value).collect::<Vec<f64>>(), 0.5)
        };
        let middle = |of: &[Fix]| {
            let time_s = median(of, &|fix| fix.time - from.time)?;
            let mut place = [0.0; D];
            for (axis, place) in place.iter_mut().enumerate() {
                *place = median(of, &|fix| position(fix)[axis])?;
            }
            Some((time_s, place))
        };
        let ((first_s, first), (last_s, last)) =
            (middle(&part[..ends[0]])?, middle(&part[ends[1]..])?);
        let off = |fix: &Fix| {
            let share = (fix.time - from.time - first_s) / (last_s - first_s);
            let place = position(fix);
            norm(std::array::from_fn::<f64, D, _>(|axis| {
                place[axis] - first[axis] - share * (last[axis] - first[axis])
            }))
        };
        Some(Self { first, last, unsteady_m: median(part, &off)? })
    }
}
