//! Velocity and displacement of the fixes over successive parts of a log; parts with implausible positions are skipped.

use std::ops::Range;

use hovernav::gps::Fix;

use super::regression::norm;
use hovernav_dataset::statistics::quantile;

/// Acceleration between positions beyond which a part is implausible, m/s² rms.
const JUMPY_MPS2: f64 = 10.0;
/// Ratio of this acceleration to that in the quietest quarter of the parts, above which a part is implausible. The
/// larger limit applies.
const JUMPY_TIMES: f64 = 6.0;

/// Mean velocity and displacement rate, NED, m/s, over parts of about `length_s`, for the axes from `from_axis` on.
/// `velocity` reads the velocity of a fix.
pub(super) fn pairs<const D: usize>(
    fixes: &[Fix],
    length_s: f64,
    from_axis: usize,
    velocity: impl Fn(&Fix) -> Option<[f64; D]>,
) -> Vec<([f64; D], [f64; D])> {
    let mut pairs = Vec::new();
    let mut first = 0;
    let jumps = Jumps::of(fixes, length_s);
    while first < fixes.len() {
        let start = &fixes[first];
        let count =
            fixes[first..].iter().take_while(|fix| fix.time - start.time < length_s).count();
        let last = first + count;
        if let Some(end) = fixes.get(last).filter(|end| end.time - start.time < 2.0 * length_s) {
            let over_s = end.time - start.time;
            let mut mean = [0.0; D];
            let mut is_known = true;
            for pair in fixes[first..=last].windows(2) {
                let (Some(a), Some(b)) = (velocity(&pair[0]), velocity(&pair[1])) else {
                    is_known = false;
                    break;
                };
                let share = 0.5 * (pair[1].time - pair[0].time) / over_s;
                for ((mean, a), b) in mean.iter_mut().zip(a).zip(b) {
                    *mean += share * (a + b);
                }
            }
            if is_known && !jumps.are_in(first..last + 1) {
                let moved = end.position.displacement_from(&start.position).to_array();
                pairs.push((mean, std::array::from_fn(|axis| moved[from_axis + axis] / over_s)));
            }
        }
        first = last.max(first + 1);
    }
    pairs
}

/// Accelerations between successive positions, m/s², squared, at each fix.
struct Jumps {
    squares: Vec<f64>,
    /// Largest plausible mean square within a part.
    largest: f64,
}

impl Jumps {
    /// Accelerations of `fixes`, for parts of about `length_s`.
    fn of(fixes: &[Fix], length_s: f64) -> Self {
        let velocity = |from: &Fix, to: &Fix| {
            let moved = to.position.displacement_from(&from.position).to_array();
            moved.map(|moved| moved / (to.time - from.time))
        };
        let mut squares = vec![0.0; fixes.len()];
        for (index, three) in fixes.windows(3).enumerate() {
            let [before, at, after] = three else { continue };
            let (to, from) = (velocity(before, at), velocity(at, after));
            let change = [0, 1, 2].map(|axis| from[axis] - to[axis]);
            let over_s = 0.5 * (after.time - before.time);
            squares[index + 1] = (norm(change) / over_s).powi(2);
        }
        let mut jumps = Self { squares, largest: f64::INFINITY };
        let part = |fix: &Fix| ((fix.time - fixes[0].time) / length_s) as u64;
        let mut end = 0;
        let parts = fixes.chunk_by(|a, b| part(a) == part(b)).map(|chunk| {
            end += chunk.len();
            jumps.mean_square(end - chunk.len()..end)
        });
        let usual = quantile(&mut parts.collect::<Vec<f64>>(), 0.25).unwrap_or(0.0);
        jumps.largest = (JUMPY_MPS2 * JUMPY_MPS2).max(JUMPY_TIMES * JUMPY_TIMES * usual);
        jumps
    }

    fn mean_square(&self, part: Range<usize>) -> f64 {
        self.squares[part.clone()].iter().sum::<f64>() / part.len() as f64
    }

    /// Whether the positions of this part scatter too much for any motion.
    fn are_in(&self, part: Range<usize>) -> bool {
        self.mean_square(part) > self.largest
    }
}
