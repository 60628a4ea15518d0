//! Temporary garbage fixes are not reported as a wrong set-up, and a wrong set-up is still reported if garbage occurs.

use std::path::Path;

use hovernav::earth::Geodetic;
use hovernav::frames::{Ned, Vector};
use hovernav::gps::Fix;
use hovernav_dataset::Dataset;
use hovernav_findings::{Sensor, SetupFinding, check_setup};
use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig, fly};
use hovernav_testing::shared;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Garbage with a start, s, a duration, s, and a one-sigma, m, north and east.
#[derive(Clone, Copy, Debug)]
struct Garbage {
    start_s: f64,
    length_s: f64,
    size_m: f64,
    seed: u64,
}

/// The garbage of all sizes, lengths and seeds.
fn all(seeds: u64) -> impl Iterator<Item = Garbage> {
    (0..seeds).flat_map(|seed| {
        [15.0, 40.0, 150.0].into_iter().flat_map(move |size_m| {
            [10.0, 20.0, 40.0, 60.0].map(|length_s| {
                let start_s = 60.0 + (37 * seed % 90) as f64;
                Garbage { start_s, length_s, size_m, seed }
            })
        })
    })
}

impl Garbage {
    /// The fixes with Gauss-Markov errors: 2.5 s of correlation time in position and 0.7 s in velocity.
    fn applied(&self, fixes: &[Fix]) -> Vec<Fix> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let (mut last_s, mut value) = (f64::NEG_INFINITY, [0.0; 6]);
        let mut fixes = fixes.to_vec();
        for fix in &mut fixes {
            let time_s = fix.time.seconds();
            if !(self.start_s..self.start_s + self.length_s).contains(&time_s) {
                continue;
            }
            for (channel, value) in value.iter_mut().enumerate() {
                let correlation_s = if channel < 3 { 2.5 } else { 0.7 };
                let decay = f64::exp((last_s - time_s) / correlation_s);
                let unit: f64 = StandardNormal.sample(&mut random);
                *value = *value * decay + (1.0 - decay * decay).sqrt() * unit;
            }
            last_s = time_s;
            let [north, east, up, vn, ve, vd] = value.map(|value| value * self.size_m);
            let off = Vector::<Ned>::new(north, east, -2.5 * up);
            fix.position = fix.position.displaced(off);
            fix.horizontal_velocity_mps =
                fix.horizontal_velocity_mps.map(|[n, e]| [n + 0.2 * vn, e + 0.2 * ve]);
            fix.down_velocity_mps = fix.down_velocity_mps.map(|down| down + 0.75 * vd);
        }
        fixes
    }
}

/// A hover of 200 s with a minute of flight, and fixes at 1 Hz.
fn hover() -> Vec<Fix> {
    Dataset::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/heli-hover")).unwrap().fixes
}

/// A multirotor that flies to and fro, turns and climbs, and fixes at 5 Hz.
fn multirotor() -> Vec<Fix> {
    let start = Geodetic::from_degrees(47.4, 8.5, 450.0).unwrap();
    let mut plan = FlightPlan::hover_at(start, 0.4).hold(20.0);
    for sense in [1.0, -1.0, 1.0, -1.0] {
        plan = (plan.accelerate(Vector::new(8.0, 0.0, 0.0), 5.0))
            .hold(4.0)
            .turn(sense * 4.0, 25f64.to_radians())
            .climb(sense * 24.0, 2.0)
            .turn(sense * -2.0, 40f64.to_radians())
            .accelerate(Vector::new(-8.0, 0.0, 0.0), 5.0)
            .hold(6.0);
    }
    let dmu = DmuConfig { rate_hz: 50.0, vibration: Vec::new(), ..DmuConfig::default() };
    let gps = GpsConfig { rate_hz: 5.0, ..GpsConfig::default() };
    fly(&plan.build().unwrap(), &dmu, &gps, 1).unwrap().fixes
}

fn found(fixes: Vec<Fix>) -> Vec<SetupFinding> {
    check_setup(&Dataset { fixes, ..Dataset::default() })
}

#[test]
fn garbage_is_no_wrong_set_up() {
    let real = shared("datasets/quad-hover-aided").map(|dir| Dataset::open(&dir).unwrap().fixes);
    let flights = [Some(("hover", hover())), Some(("multirotor", multirotor()))];
    let real = real.map(|fixes| ("quad-hover-aided", fixes));
    for (name, fixes) in flights.into_iter().chain([real]).flatten() {
        let mut level = fixes.clone();
        level.iter_mut().for_each(|fix| fix.down_velocity_mps = None);
        let mut without = level.clone();
        without.iter_mut().for_each(|fix| fix.horizontal_velocity_mps = None);
        for (what, fixes) in [("", fixes), ("level", level), ("without velocity", without)] {
            let told: Vec<_> = all(30)
                .filter_map(|garbage| {
                    let found = found(garbage.applied(&fixes));
                    (!found.is_empty()).then_some((garbage, found))
                })
                .collect();
            let certain = told.iter().filter(|(_, found)| found[0].is_certain).count();
            assert!(
                told.is_empty(),
                "{name} {what}: {certain} refused of {}: {told:#?}",
                told.len()
            );
        }
    }
}

#[test]
fn a_wrong_set_up_is_found_through_garbage() {
    let flown = multirotor();
    for (north_by, down_by, expected) in [
        (1.0, -1.0, "vertical velocity positive up"),
        (-1.0, 1.0, "wrong sign"),
        (3.6, 3.6, "velocity in km/h"),
        (1.944, 1.944, "velocity in knots"),
    ] {
        let mut fixes = flown.clone();
        for fix in &mut fixes {
            let east_by: f64 = north_by;
            let told = fix.horizontal_velocity_mps.map(|[n, e]| [north_by * n, east_by.abs() * e]);
            fix.horizontal_velocity_mps = told;
            fix.down_velocity_mps = fix.down_velocity_mps.map(|down| down_by * down);
        }
        let is_found = |fixes| {
            let found = found(fixes);
            found.iter().any(|one| {
                one.is_certain && one.sensor == Sensor::Gps && one.to_string().contains(expected)
            })
        };
        assert!(!is_found(flown.clone()) && is_found(fixes.clone()), "{expected}");
        let missed: Vec<_> = all(30).filter(|one| !is_found(one.applied(&fixes))).collect();
        println!("{expected}: missed {} of 360", missed.len());
        // A minute of garbage may cover most of the climbs.
        assert!(missed.len() <= 18, "{expected}: {missed:#?}");
    }
}
