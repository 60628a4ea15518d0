//! Detection of a pilot's test points in a flight.

use hovernav::controls::Sticks;
use hovernav::time::Time;

/// The four sticks, in the order of [`hovernav_dataset::Dataset::controls`].
pub const STICKS: [&str; 4] = Sticks::NAMES;

/// Section of a flight with deliberate steps of the sticks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TestPoint {
    /// The stepped stick, an index into [`STICKS`]; `None` where several moved together.
    pub stick: Option<usize>,
    /// Time of the first step.
    pub first_step: Time,
    /// Time of the last step.
    pub last_step: Time,
    /// Start of the section, with a little steady flight before the first step.
    pub start: Time,
    /// End of the section: the response to the last step has decayed, or the next test point starts.
    pub end: Time,
    /// Number of steps.
    pub steps: usize,
}

/// Time of flight before the first step that belongs to a test point, s.
const LEAD_S: f64 = 2.0;
/// Time of flight after the last step that belongs to a test point, s.
const TAIL_S: f64 = 5.0;
/// Longest time between steps of one test point, s: a step held for 1.5 s, plus a margin.
const TOGETHER_S: f64 = 2.5;
/// Smallest change between adjacent samples that counts as a step, as a fraction of the stick's travel in the flight.
const MIN_STEP: f64 = 0.1;
/// Fraction of the largest travel of all sticks below which a stick contains only noise.
const MIN_TRAVEL: f64 = 0.1;
/// Fraction of the rows at either end of a stick's range that count as outliers.
const OUTLYING: f64 = 1e-3;
/// Ratio of a stick's largest step to the largest step of all sticks above which the stick belongs to the test.
const JOINS_IN: f64 = 0.4;

/// Travel of each stick in the flight, in the unit of its record: its range without outliers. Every threshold on sticks
/// is a fraction of the travel, so that no result depends on the unit.
#[must_use]
pub fn travels(controls: &[(Time, [f64; 4])]) -> [f64; 4] {
    std::array::from_fn(|stick| {
        let mut values: Vec<f64> = controls.iter().map(|row| row.1[stick]).collect();
        values.retain(|value| value.is_finite());
        values.sort_by(f64::total_cmp);
        let outlying = (OUTLYING * values.len() as f64) as usize;
        let ends = values.get(outlying).zip(values.len().checked_sub(outlying + 1));
        ends.map_or(0.0, |(first, last)| values[last] - first)
    })
}

/// Smallest change of each stick from one sample to the next that counts as a step.
fn min_steps(controls: &[(Time, [f64; 4])]) -> [f64; 4] {
    let travels = travels(controls);
    let largest = travels.into_iter().fold(0.0, f64::max);
    std::array::from_fn(|stick| {
        let mut changes: Vec<f64> =
            controls.windows(2).map(|pair| (pair[1].1[stick] - pair[0].1[stick]).abs()).collect();
        changes.sort_by(f64::total_cmp);
        let usual = changes.get(changes.len() / 2).copied().unwrap_or(0.0);
        let travel = travels[stick].max(MIN_TRAVEL * largest);
        (8.0 * usual).max(MIN_STEP * travel)
    })
}

/// Steps of each stick during test points of that stick alone, one row for each of `controls`. A row contains the sum
/// of the steps since the test point began, and 0 outside test points. Other stick movements may respond to gusts;
/// these steps do not.
#[must_use]
pub fn stepped(controls: &[(Time, [f64; 4])]) -> Vec<[f64; 4]> {
    let least = min_steps(controls);
    let mut rows = vec![[0.0; 4]; controls.len()];
    for point in find_test_points(controls) {
        let Some(stick) = point.stick else { continue };
        let mut sum = 0.0;
        for (row, pair) in rows.iter_mut().skip(1).zip(controls.windows(2)) {
            if (point.first_step..=point.end).contains(&pair[1].0) {
                let change = pair[1].1[stick] - pair[0].1[stick];
                sum += if change.abs() >= least[stick] { change } else { 0.0 };
                row[stick] = sum;
            }
        }
    }
    rows
}

/// Finds the test points of a flight from its sticks, in any unit, in time order.
///
/// A step is a change from one sample to the next. It is at least a tenth of the stick's [`travels`] and at least eight
/// times the usual change. Steps within 2.5 s belong to one test point. At least two steps of a single stick are a test
/// of that stick; anything else is a manoeuvre, with [`TestPoint::stick`] `None`.
#[must_use]
pub fn find_test_points(controls: &[(Time, [f64; 4])]) -> Vec<TestPoint> {
    let least = min_steps(controls);
    let mut groups: Vec<(Time, Time, [usize; 4], [f64; 4])> = Vec::new();
    for pair in controls.windows(2) {
        let time = pair[1].0;
        for stick in 0..4 {
            let change = (pair[1].1[stick] - pair[0].1[stick]).abs();
            let is_step = change >= least[stick] && change > 0.0;
            if !is_step {
                continue;
            }
            match groups.last_mut() {
                Some(group) if time - group.1 < TOGETHER_S => group.1 = time,
                _ => groups.push((time, time, [0; 4], [0.0; 4])),
            }
            if let Some((_, _, counts, largest)) = groups.last_mut() {
                counts[stick] += 1;
                largest[stick] = largest[stick].max(change);
            }
        }
    }
    let bounds = controls.first().zip(controls.last());
    let Some((begin, finish)) = bounds.map(|(first, last)| (first.0, last.0)) else {
        return Vec::new();
    };
    let points = groups.iter().enumerate().map(|(index, &(first, last, counts, largest))| {
        let leader = (0..4).max_by(|&one, &other| largest[one].total_cmp(&largest[other]));
        let stick = leader.filter(|&leader| {
            let alone =
                (0..4).all(|other| other == leader || largest[other] < JOINS_IN * largest[leader]);
            alone && counts[leader] >= 2
        });
        let before = index.checked_sub(1).map_or(begin, |before| groups[before].1);
        let after = groups.get(index + 1).map_or(finish, |after| after.0);
        TestPoint {
            stick,
            first_step: first,
            last_step: last,
            start: first.offset_by(-LEAD_S).max(before),
            end: last.offset_by(TAIL_S).min(after.offset_by(-LEAD_S).max(last)).min(finish),
            steps: counts.iter().sum(),
        }
    });
    points.collect()
}
