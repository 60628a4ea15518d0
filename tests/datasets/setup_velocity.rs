//! Velocities of exactly zero are rejected while the positions move, and used for a vehicle at rest.

use std::path::Path;

use hovernav::earth::Geodetic;
use hovernav::frames::{Ned, Vector};
use hovernav::gps::Fix;
use hovernav_dataset::{Dataset, Reference};
use hovernav_findings::{SetupFinding, check_fitness, check_setup, ensure_possible, ignore};
use hovernav_replay::estimate;
use hovernav_score::axis_errors;
use hovernav_sim::faults::{Fault, Log};
use hovernav_testing::shared;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Motion of a vehicle: north, east and down, m, at a time, s.
type Path3 = fn(f64) -> [f64; 3];

const STANDING: Path3 = |_| [0.0; 3];
/// A path at 3 m/s away from the start, from 100 to 140 s.
const AWAY: Path3 = |time_s| {
    let along_m = 3.0 * (time_s - 100.0).clamp(0.0, 40.0);
    [0.8 * along_m, 0.6 * along_m, 0.0]
};
/// A path upwards at 3 m/s, from 100 to 140 s.
const UP: Path3 = |time_s| [0.0, 0.0, -3.0 * (time_s - 100.0).clamp(0.0, 40.0)];

/// Fixes of 240 s at 5 Hz. Positions have slow errors of 2 m and noise of 0.5 m, twice this in height; velocities
/// have errors of 0.1 m/s.
fn fixes(path: Path3, seed: u64) -> Vec<Fix> {
    let start = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = |sigma: f64| -> f64 {
        let unit: f64 = StandardNormal.sample(&mut random);
        sigma * unit
    };
    let (interval_s, correlation_s) = (0.2, 60.0);
    let decay = f64::exp(-interval_s / correlation_s);
    let mut slow = [0.0; 3].map(|_: f64| noise(2.0));
    let mut fixes = Vec::new();
    for step in 0..1200 {
        let time_s = interval_s * f64::from(step);
        slow = slow.map(|slow| decay * slow + (1.0 - decay * decay).sqrt() * noise(2.0));
        let (at, after) = (path(time_s), path(time_s + interval_s));
        let place = [0, 1, 2].map(|axis| {
            let by = if axis == 2 { 2.0 } else { 1.0 };
            at[axis] + by * (slow[axis] + noise(0.5))
        });
        let velocity = [0, 1, 2].map(|axis| (after[axis] - at[axis]) / interval_s + noise(0.1));
        fixes.push(Fix {
            horizontal_velocity_mps: Some([velocity[0], velocity[1]]),
            down_velocity_mps: Some(velocity[2]),
            position_sigma_m: Some(Vector::<Ned>::new(2.0, 2.0, 4.0)),
            ..Fix::at(hovernav::time::Time::ZERO + time_s, start.displaced(Vector::from(place)))
        });
    }
    fixes
}

/// The fixes with velocities set to zero within the span `span_s`, s. `level` selects horizontal velocities, `down`
/// vertical ones. Missing velocities within the span become zero, too.
fn zeroed(mut fixes: Vec<Fix>, [level, down]: [bool; 2], span_s: std::ops::Range<f64>) -> Vec<Fix> {
    for fix in fixes.iter_mut().filter(|fix| span_s.contains(&fix.time.seconds())) {
        fix.horizontal_velocity_mps = fix.horizontal_velocity_mps.filter(|_| !level);
        fix.down_velocity_mps = fix.down_velocity_mps.filter(|_| !down);
        fix.horizontal_velocity_mps.get_or_insert([0.0; 2]);
        fix.down_velocity_mps.get_or_insert(0.0);
    }
    fixes
}

/// Findings of a log with these fixes, and the numbers of horizontal and vertical velocities that are used.
fn ignored(fixes: Vec<Fix>) -> (Vec<SetupFinding>, [usize; 2]) {
    let mut dataset = Dataset { fixes, ..Dataset::default() };
    let denied = ensure_possible(&dataset, Path::new("log")).unwrap();
    let told = ignore(&mut dataset, denied);
    assert_eq!(check_setup(&dataset), [], "after it nothing is left to say");
    let count = |has: fn(&Fix) -> bool| dataset.fixes.iter().filter(|fix| has(fix)).count();
    let stay = [
        count(|fix| fix.horizontal_velocity_mps.is_some()),
        count(|fix| fix.down_velocity_mps.is_some()),
    ];
    (told, stay)
}

const THROUGHOUT: std::ops::Range<f64> = 0.0..1e3;

#[test]
fn zeros_of_a_vehicle_that_moves_are_not_used_level_and_vertical_each() {
    for seed in 0..20 {
        for (path, zero, span_s, stay) in [
            (AWAY, [true, true], THROUGHOUT, [0, 0]),
            (AWAY, [true, false], THROUGHOUT, [0, 1200]),
            (AWAY, [false, true], THROUGHOUT, [1200, 1200]),
            (UP, [true, true], THROUGHOUT, [0, 0]),
            (UP, [false, true], THROUGHOUT, [1200, 0]),
            (AWAY, [true, true], 95.0..145.0, [950, 950]),
            (UP, [false, true], 95.0..145.0, [1200, 950]),
        ] {
            let (told, left) = ignored(zeroed(fixes(path, seed), zero, span_s.clone()));
            assert_eq!(left, stay, "seed {seed}, {zero:?} in {span_s:?}: {told:?}");
            assert_eq!(told.is_empty(), stay == [1200, 1200]);
            for finding in told {
                let words = finding.to_string();
                assert!(words.starts_with("gps velocity: not used: exactly 0"), "{words}");
                let mend = if span_s == THROUGHOUT { "remove v" } else { "empty in these fixes" };
                assert!(words.contains(mend), "{words}");
            }
        }
    }
}

#[test]
fn a_vehicle_that_stands_keeps_its_zeros() {
    for seed in 0..50 {
        let standing = zeroed(fixes(STANDING, seed), [true, true], THROUGHOUT);
        let mut jumping = standing.clone();
        for fix in jumping.iter_mut().filter(|fix| (83.0..113.0).contains(&fix.time.seconds())) {
            fix.position = fix.position.displaced(Vector::<Ned>::new(60.0, -40.0, 30.0));
        }
        // The vehicle is at rest for 90 s before it moves, and the velocities are zero for the same time.
        let starting = zeroed(fixes(AWAY, seed), [true, true], 0.0..100.0);
        for fixes in [standing, jumping, starting] {
            let (told, stay) = ignored(fixes);
            assert_eq!((told, stay), (vec![], [1200, 1200]), "seed {seed}");
        }
    }
}

/// Largest errors of position, m, and velocity, m/s.
fn errors(mut dataset: Dataset, reference: &Reference) -> ([f64; 2], Vec<SetupFinding>) {
    let denied = check_fitness(&dataset, Path::new("log")).unwrap();
    let told = ignore(&mut dataset, denied);
    let config = dataset.settings().unwrap();
    let run = estimate(&dataset, &config, |_| {});
    let largest = run.solutions.iter().fold([0.0; 2], |[place, velocity]: [f64; 2], solution| {
        let off = axis_errors(solution, reference);
        let size = |axes: [hovernav_score::Axis; 3]| {
            axes.into_iter().map(|axis| off[axis as usize].powi(2)).sum::<f64>().sqrt()
        };
        use hovernav_score::Axis::{Down, East, North, VelocityDown, VelocityEast, VelocityNorth};
        [
            place.max(size([North, East, Down])),
            velocity.max(size([VelocityNorth, VelocityEast, VelocityDown])),
        ]
    });
    (largest, told)
}

#[test]
fn a_flight_with_zeros_is_estimated_as_one_without_velocities() {
    let heli = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/heli-hover");
    let none: [Fault; 1] = ["no-velocity".parse().unwrap()];
    let dir = tempfile::tempdir().unwrap();
    Log::open(&heli).unwrap().with_faults(&none, 1).unwrap().write(dir.path()).unwrap();
    let open = |dir: &Path| {
        let dataset = Dataset::open(dir).unwrap();
        let reference = Reference::open(dir, &dataset.manifest).unwrap().unwrap();
        (dataset, reference)
    };
    let (without, reference) = open(dir.path());
    let (expected, _) = errors(without, &reference);
    let (mut zeros, reference) = open(&heli);
    zeros.fixes = zeroed(zeros.fixes, [true, true], THROUGHOUT);
    let (found, told) = errors(zeros, &reference);
    println!("largest errors: {found:?} with zeros, {expected:?} without velocities");
    assert_eq!(told.len(), 1, "{told:?}");
    assert_eq!(found, expected);
    if let Some(case) = shared("cases/velocity-all-zero") {
        let (zeros, reference) = open(&case);
        let (found, told) = errors(zeros, &reference);
        println!("largest errors of the case: {found:?}");
        assert_eq!(told.len(), 1, "{told:?}");
        assert!(found[0] < 1.5 * expected[0] && found[1] < 1.5 * expected[1], "{found:?}");
    }
}
