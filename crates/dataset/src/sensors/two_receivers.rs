//! Two receivers in one log, whose fixes alternate.

use hovernav::gps::Fix;

use crate::statistics::quantile;

/// Number of fixes whose offsets from their neighbours are compared.
const WINDOW: usize = 20;
/// Smallest number of windows for a judgement.
const MIN_WINDOWS: usize = 3;
/// Smallest fraction of the windows that show two receivers.
const MANY: f64 = 0.5;
/// Smallest distance between two receivers, m.
const MIN_APART_M: f64 = 0.5;
/// Travel time, s, within this distance: fixes of one receiver with uneven time stamps alternate too.
const UNEVEN_S: f64 = 0.05;
/// Smallest distance between two receivers, in scatters of the offsets. Fixes halfway between those of one receiver
/// reach 1.
const STEADY: f64 = 1.2;
/// Largest difference of an interval from a multiple of a receiver's own one, relative to the shorter interval between
/// the two receivers.
const NEAR: f64 = 0.3;
/// Largest ratio of the one-sigmas at which the first receiver is used.
const ALIKE: f64 = 0.67;

/// Offset of a fix from the line between its neighbours, m, and its speed, m/s.
type Offset = ([f64; 3], f64);

/// Fixes of two receivers.
pub(super) struct TwoReceivers {
    /// Median distance between the receivers, m.
    pub apart_m: f64,
    /// For each fix, whether it is from the receiver that is not used.
    pub is_other: Vec<bool>,
}

impl TwoReceivers {
    /// The receivers of `fixes`, if every other fix is apart from those before and after it, in alternating directions.
    pub fn of(fixes: &[Fix]) -> Option<Self> {
        let second = second(fixes)?;
        let apart_m = [[true, true, false], [false, false, true]]
            .into_iter()
            .find_map(|axes| apart_m(fixes, &second, axes))?;
        let sigma_m = |of_second: bool| {
            let of_one = fixes.iter().zip(&second).filter(|(_, second)| **second == of_second);
            let sigmas = of_one.filter_map(|(fix, _)| Some(fix.position_sigma_m?.x()));
            quantile(&mut sigmas.collect::<Vec<_>>(), 0.5)
        };
        let is_second_better = sigma_m(true)
            .zip(sigma_m(false))
            .is_some_and(|(second_m, first_m)| second_m < ALIKE * first_m);
        let is_other = second.into_iter().map(|second| second != is_second_better).collect();
        Some(Self { apart_m, is_other })
    }
}

/// For each fix, whether it is from the second receiver, by the intervals: two receivers of one rate alternate, except
/// where fixes are missing.
fn second(fixes: &[Fix]) -> Option<Vec<bool>> {
    let intervals = || fixes.windows(2).map(|pair| pair[1].time - pair[0].time);
    let mut sorted: Vec<f64> = intervals().collect();
    let (short_s, long_s) = (quantile(&mut sorted, 0.25)?, quantile(&mut sorted, 0.75)?);
    let own_s = short_s + long_s;
    let mut second = vec![false];
    for interval_s in intervals() {
        let off_s = interval_s - own_s * (interval_s / own_s).round();
        let last = *second.last()?;
        second.push(last != (off_s.abs() > NEAR * short_s));
    }
    Some(second)
}

/// Median distance between two receivers along `axes`, m; `None` if there is one receiver.
fn apart_m(fixes: &[Fix], second: &[bool], axes: [bool; 3]) -> Option<f64> {
    let along = |fix: &Fix, from: &Fix| {
        let moved = fix.position.displacement_from(&from.position).to_array();
        std::array::from_fn::<f64, 3, _>(|axis| if axes[axis] { moved[axis] } else { 0.0 })
    };
    let norm = |vector: [f64; 3]| vector.into_iter().fold(0.0, f64::hypot);
    // Offset of each fix from the line between its neighbours, positive for the second receiver, and speed.
    let offsets: Vec<Offset> = fixes
        .windows(3)
        .zip(second.windows(3))
        .filter_map(|(fixes, second)| {
            let ([before, here, after], [was, is, will]) = (fixes, second) else { return None };
            let (over_s, sign) = (after.time - before.time, if *is { 1.0 } else { -1.0 });
            let (offset, moved) = (along(here, before), along(after, before));
            let share = (here.time - before.time) / over_s;
            let offset = [0, 1, 2].map(|axis| sign * (offset[axis] - share * moved[axis]));
            (was != is && is != will).then_some((offset, norm(moved) / over_s))
        })
        .collect();
    let windows: Vec<f64> = offsets
        .chunks_exact(WINDOW)
        .map(|window| {
            let mean =
                |of: &dyn Fn(&Offset) -> f64| window.iter().map(of).sum::<f64>() / WINDOW as f64;
            let apart = [0, 1, 2].map(|axis| mean(&|(offset, _)| offset[axis]));
            let scatter_m =
                mean(&|(offset, _)| norm([0, 1, 2].map(|axis| offset[axis] - apart[axis])).powi(2));
            let (apart_m, scatter_m) = (norm(apart), scatter_m.sqrt());
            let travel_m = UNEVEN_S * mean(&|(_, speed_mps)| *speed_mps);
            let is_apart = apart_m > (STEADY * scatter_m).max(MIN_APART_M).max(travel_m);
            if is_apart { apart_m } else { 0.0 }
        })
        .collect();
    let mut found: Vec<f64> = windows.iter().copied().filter(|apart_m| *apart_m > 0.0).collect();
    let is_two = windows.len() >= MIN_WINDOWS && found.len() as f64 > MANY * windows.len() as f64;
    is_two.then(|| quantile(&mut found, 0.5)).flatten()
}

#[cfg(test)]
mod tests {
    use hovernav::earth::Geodetic;
    use hovernav::frames::Vector;
    use hovernav::time::Time;

    use super::*;

    /// Fixes every 0.2 s on a winding path at 15 m/s, with those of a second receiver `later_s` after them, `offset_m`
    /// apart, and every 50th of the first receiver missing.
    fn fixes(later_s: f64, offset_m: [f64; 3]) -> Vec<Fix> {
        let origin = Geodetic { latitude_rad: 0.8, longitude_rad: 0.1, height_m: 400.0 };
        let at = |time_s: f64, [north_m, east_m, down_m]: [f64; 3]| {
            let path = [15.0 * time_s + north_m, 40.0 * (0.3 * time_s).sin() + east_m, down_m];
            Fix::at(Time::from_seconds(time_s), origin.displaced(Vector::from(path)))
        };
        let both = (0..500).flat_map(|k| {
            let time_s = 0.2 * f64::from(k);
            let first = (k % 50 != 49).then(|| at(time_s, [0.0; 3]));
            let second = (later_s > 0.0).then(|| at(time_s + later_s, offset_m));
            [first, second].into_iter().flatten()
        });
        both.collect()
    }

    #[test]
    fn fixes_that_alternate_between_two_places_are_of_two_receivers() {
        for (later_s, offset_m) in
            [(0.1, [0.0, 3.0, 0.0]), (0.02, [4.0, 0.0, 0.5]), (0.15, [0.0, 0.0, 40.0])]
        {
            let fixes = fixes(later_s, offset_m);
            let two = TwoReceivers::of(&fixes).unwrap();
            let expected_m = offset_m.into_iter().fold(0.0, f64::hypot);
            assert!((two.apart_m / expected_m - 1.0).abs() < 0.1, "{}", two.apart_m);
            for (fix, is_other) in fixes.iter().zip(two.is_other) {
                let cycle = fix.time.seconds() / 0.2;
                assert_eq!(
                    is_other,
                    (cycle - cycle.round()).abs() > 0.01,
                    "{}",
                    fix.time.seconds()
                );
            }
        }
    }

    #[test]
    fn one_receiver_stays_whole_even_if_uneven() {
        let one = fixes(0.0, [0.0; 3]);
        // One path, sampled twice, and with time stamps 30 ms off.
        let twice = fixes(0.1, [0.0; 3]);
        let uneven = fixes(0.1, [0.03 * 15.0, 0.0, 0.0]);
        for fixes in [one, twice, uneven] {
            assert!(TwoReceivers::of(&fixes).is_none());
        }
    }
}
