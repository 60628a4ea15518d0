//! A receiver with random positions, heights and velocities for a while. Inertial unit and barometer carry the filter
//! through this time.

mod flights;
mod measures;

use std::sync::OnceLock;

use flights::{ALL_AIDS, Aids, Case, Flown, Stated, Vehicle, fly_all};
use measures::Measures;

const VEHICLES: [Vehicle; 2] = [Vehicle::HeliHover, Vehicle::Multirotor];

/// A goal of flights, and the test for it. To a rejected log only the first goal applies.
struct Goal {
    words: &'static str,
    needs_barometer: bool,
    is_met: fn(&Measures) -> bool,
}

const REFUSED: Goal = Goal {
    words: "log not refused",
    needs_barometer: false,
    is_met: |measures| !is_refused(measures),
};
const DIVERGED: Goal = Goal {
    words: "no divergence",
    needs_barometer: false,
    is_met: |measures| is_refused(measures) || !measures.diverged,
};
const HEIGHT: Goal = Goal {
    words: "with barometer, height within 5 m and vertical velocity within 1 m/s",
    needs_barometer: true,
    is_met: |measures| {
        is_refused(measures) || measures.height_m <= 5.0 && measures.vertical_mps <= 1.0
    },
};
const INSIDE: Goal = Goal {
    words: "velocity inside 3 sigma for 95 % of the time",
    needs_barometer: false,
    is_met: |measures| is_refused(measures) || measures.inside >= 0.95,
};
const NORMAL: Goal = Goal {
    words: "normal within 5 s of the receiver's recovery",
    needs_barometer: false,
    is_met: |measures| is_refused(measures) || measures.normal_after_s <= 5.0,
};
const BIAS: Goal = Goal {
    words: "no bias beyond a tenth of full scale",
    needs_barometer: false,
    is_met: |measures| is_refused(measures) || measures.bias <= 1.0,
};
const GOALS: [&Goal; 6] = [&REFUSED, &DIVERGED, &HEIGHT, &INSIDE, &NORMAL, &BIAS];

fn is_refused(measures: &Measures) -> bool {
    measures.refused.is_some()
}

impl Goal {
    /// Number of flights to which the goal applies, and the flights that miss it.
    fn missed<'a>(&self, flown: &'a [Flown]) -> (usize, Vec<&'a Flown>) {
        let applies = |flown: &&Flown| !self.needs_barometer || flown.case.aids.barometer;
        let missed = flown.iter().filter(applies).filter(|flown| !(self.is_met)(&flown.measures));
        (flown.iter().filter(applies).count(), missed.collect())
    }
}

/// Every vehicle and every set of aids once, each with different garbage.
fn sample() -> &'static [Flown] {
    static SAMPLE: OnceLock<Vec<Flown>> = OnceLock::new();
    SAMPLE.get_or_init(|| {
        let pairs = VEHICLES.iter().flat_map(|vehicle| ALL_AIDS.map(|aids| (*vehicle, aids)));
        let cases = pairs.zip(1..).map(|((vehicle, aids), seed)| Case::of(vehicle, aids, seed));
        fly_all(&cases.collect::<Vec<_>>())
    })
}

/// Asserts all `goals` of all `flown`.
fn assert_met(flown: &[Flown], goals: &[&Goal]) {
    let mut missed = String::new();
    for goal in goals {
        let (all, missing) = goal.missed(flown);
        if let Some(Flown { case, measures }) = missing.first() {
            let (words, count) = (goal.words, missing.len());
            missed += &format!("{words}: missed by {count} of {all}, as {case:?}: {measures:?}\n");
        }
    }
    assert!(missed.is_empty(), "{missed}");
}

#[test]
fn garbage_does_not_have_the_log_refused() {
    assert_met(sample(), &[&REFUSED]);
}

#[test]
fn garbage_does_not_make_the_filter_diverge() {
    assert_met(sample(), &[&DIVERGED]);
}

#[test]
fn a_barometer_holds_height_and_vertical_velocity_while_the_receiver_gives_garbage() {
    assert_met(sample(), &[&HEIGHT]);
}

#[test]
fn velocity_stays_inside_three_sigma_while_the_receiver_gives_garbage() {
    assert_met(sample(), &[&INSIDE]);
}

#[test]
fn five_seconds_after_garbage_the_filter_is_as_good_as_without() {
    assert_met(sample(), &[&NORMAL]);
}

#[test]
fn garbage_drives_no_bias_beyond_a_tenth_of_full_scale() {
    assert_met(sample(), &[&BIAS]);
}

/// Prints the table of all flights with `seeds`, and asserts every goal.
fn assert_all_met(seeds: u64) {
    let mut cases = Vec::new();
    for vehicle in VEHICLES {
        for aids in ALL_AIDS {
            cases.extend((1..=seeds).map(|seed| Case::of(vehicle, aids, seed)));
        }
    }
    let flown = fly_all(&cases);
    println!("{}", table(&flown));
    assert_met(&flown, &GOALS);
}

#[test]
#[ignore = "minutes: 3200 flights"]
fn garbage_of_200_seeds_meets_every_goal() {
    assert_all_met(200);
}

#[test]
#[ignore = "half a minute: 576 flights"]
fn garbage_of_36_seeds_meets_every_goal() {
    assert_all_met(36);
}

/// Median, 90th percentile and worst of each column, and the number of flights that miss each goal. Rejected logs count
/// in their own column only.
fn table(flown: &[Flown]) -> String {
    type Column = (&'static str, fn(&Measures) -> f64);
    let columns: [Column; 10] = [
        ("height, m", |m| m.height_m),
        ("vertical, m/s", |m| m.vertical_mps),
        ("horizontal, m/s", |m| m.horizontal_mps),
        ("horizontal/σ", |m| m.horizontal_sigmas),
        ("outside 3σ, %", |m| 100.0 * (1.0 - m.inside)),
        ("twin outside, %", |m| 100.0 * (1.0 - m.twin_inside)),
        ("twin height, m", |m| m.twin_height_m),
        ("twin vertical, m/s", |m| m.twin_vertical_mps),
        ("normal after, s", |m| m.normal_after_s),
        ("bias/limit", |m| m.bias),
    ];
    let mut text = "| flights | runs |".to_owned();
    columns.iter().for_each(|(name, _)| text += &format!(" {name} |"));
    text += " diverged | refused | ignored sensors |\n|---|---|";
    text += &"---|".repeat(columns.len() + 3);
    text += "\n";
    let mut row = |name: &str, keep: &dyn Fn(&Case) -> bool| {
        let kept: Vec<&Measures> =
            flown.iter().filter(|flown| keep(&flown.case)).map(|flown| &flown.measures).collect();
        text += &format!("| {name} | {} |", kept.len());
        for (_, pick) in columns {
            let solved = kept.iter().filter(|measures| !is_refused(measures));
            let mut numbers: Vec<f64> = solved.map(|measures| pick(measures)).collect();
            numbers.sort_by(f64::total_cmp);
            let at = |share: f64| numbers[(share * (numbers.len() - 1) as f64).round() as usize];
            text += &format!(" {:.2} / {:.2} / {:.2} |", at(0.5), at(0.9), at(1.0));
        }
        let count = |is: fn(&&Measures) -> bool| kept.iter().copied().filter(is).count();
        let [diverged, refused, ignored] =
            [count(|m| m.diverged), count(|m| is_refused(m)), count(|m| m.ignored > 0)];
        text += &format!(" {diverged} | {refused} | {ignored} |\n");
    };
    for vehicle in VEHICLES {
        for aids in ALL_AIDS {
            let Aids { barometer, attitude } = aids;
            let name = format!("{vehicle:?}, barometer {barometer}, attitude {attitude}");
            row(&name, &|case| case.vehicle == vehicle && case.aids == aids);
        }
    }
    for aids in ALL_AIDS {
        let Aids { barometer, attitude } = aids;
        let name = format!("all, barometer {barometer}, attitude {attitude}");
        row(&name, &|case| case.aids == aids);
    }
    for length_s in [10.0, 20.0, 40.0, 60.0] {
        row(&format!("all, {length_s} s"), &|case| case.length_s == length_s);
    }
    for size_m in [15.0, 40.0, 150.0] {
        row(&format!("all, {size_m} m"), &|case| case.size_m == size_m);
    }
    for stated in [Stated::AsRecorded, Stated::ThreeTimes, Stated::Not] {
        row(&format!("all, one-sigmas {stated:?}"), &|case| case.stated == stated);
    }
    text += "\n| goal | missed |\n|---|---|\n";
    for goal in GOALS {
        let (all, missed) = goal.missed(flown);
        text += &format!("| {} | {} of {all} |\n", goal.words, missed.len());
    }
    text
}
