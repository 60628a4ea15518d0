//! Flights over the lines have the same percentiles as the flights of a campaign, which has neither lines nor a clock.

use hovernav::frames::{Body, Vector, wrap_angle};
use hovernav_dataset::Truth;
use hovernav_sim::FlightConfig;
use hovernav_sim::campaign::{Campaign, SensorGrade, percentile};
use hovernav_testing::sample;

use crate::common::{Flown, Setup, all_flown, autopilot};

/// Largest number of flights of the campaign; their seeds are 1 to 200.
const CAMPAIGN: u64 = 200;
/// Largest number of flights over the lines; their seeds are 201 to 260.
const OVER_LINES: u64 = 60;
/// The daily sample is the first quarter of both.
const SAMPLED: u64 = 4;
/// Smallest probability, for each quantity, that a difference is due to chance: 1 % over all five quantities.
const MIN_PROBABILITY: f64 = 0.01 / MEASURES.len() as f64;

const MEASURES: [&str; 5] =
    ["u, m/s RMS", "v, m/s RMS", "w, m/s RMS", "heading, worst, deg", "heading error, deg RMS"];

/// Wind of up to 5 m/s from any direction, with gusts of a quarter of it, at least 0.3 m/s. The sensors of the
/// thesis, without a barometer. Flights of 60 s, evaluated from 25 s on.
fn campaign() -> Campaign {
    let mut campaign = Campaign::new(autopilot());
    campaign.grades = vec![SensorGrade::Thesis];
    campaign.outage_share = 0.0;
    campaign.nominal.baro = None;
    campaign.nominal.start.height_m = 60.0;
    campaign
}

/// Flight `seed`, with the airframe of the autopilot's design.
fn flight(campaign: &Campaign, seed: u64) -> FlightConfig {
    let mut draw = campaign.draw(seed);
    draw.drawn.fill(1.0);
    campaign.flight(&draw).unwrap()
}

fn of_campaign(flight: &FlightConfig, from_s: f64) -> [f64; 5] {
    let hover = flight.fly().unwrap().statistics(from_s);
    let [u, v, w] = hover.velocity_rms_mps;
    [u, v, w, hover.heading_worst_deg, hover.attitude_error_rms_deg[2]]
}

fn of_lines(flown: &Flown, from_s: f64) -> [f64; 5] {
    let judged: Vec<_> =
        flown.samples.iter().map(|s| s.truth).filter(|t| t.time.seconds() >= from_s).collect();
    let yaw = |truth: &Truth| truth.body_to_ned.euler().yaw_rad;
    let rms = |values: &[f64]| {
        (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
    };
    let body = |axis: usize| {
        let velocity =
            |truth: &Truth| -> Vector<Body> { truth.body_to_ned.inverse() * truth.velocity_mps };
        rms(&judged.iter().map(|truth| velocity(truth).to_array()[axis]).collect::<Vec<_>>())
    };
    let first = yaw(&judged[0]);
    let worst = judged.iter().map(|truth| wrap_angle(yaw(truth) - first).abs());
    // The estimate at each time, compared with the nearest truth.
    let errors: Vec<f64> = flown
        .record
        .solutions
        .iter()
        .filter_map(|solution| {
            let second = flown.second(solution.time);
            let after = judged.partition_point(|truth| truth.time.seconds() < second);
            let truth = judged.get(after).filter(|_| after > 0)?;
            let found = solution.body_to_ned.euler().yaw_rad;
            Some(wrap_angle(found - yaw(truth)).to_degrees())
        })
        .collect();
    [body(0), body(1), body(2), worst.fold(0.0, f64::max).to_degrees(), rms(&errors)]
}

/// The largest distance between the distributions of two samples, and the probability that chance gives a larger
/// distance.
///
/// # Source
/// W. Press et al., *Numerical Recipes*, section 14.3: Kolmogorov and Smirnov, two samples.
fn kolmogorov_smirnov(one: &[f64], other: &[f64]) -> (f64, f64) {
    let below = |values: &[f64], limit: f64| {
        values.iter().filter(|value| **value <= limit).count() as f64 / values.len() as f64
    };
    let distance = one
        .iter()
        .chain(other)
        .map(|limit| (below(one, *limit) - below(other, *limit)).abs())
        .fold(0.0, f64::max);
    let (n, m) = (one.len() as f64, other.len() as f64);
    let root = (n * m / (n + m)).sqrt();
    let lambda = (root + 0.12 + 0.11 / root) * distance;
    let term = |j: i32| {
        let sign = if j % 2 == 1 { 2.0 } else { -2.0 };
        sign * (-2.0 * (f64::from(j) * lambda).powi(2)).exp()
    };
    (distance, (1..=100).map(term).sum::<f64>().clamp(0.0, 1.0))
}

#[test]
fn equal_and_different_distributions_are_distinguished() {
    let uniform = |count: i32| (0..count).map(move |k| f64::from(k) / f64::from(count));
    let (one, same): (Vec<f64>, Vec<f64>) = (uniform(200).collect(), uniform(60).collect());
    let apart: Vec<f64> = uniform(60).map(|value| value + 0.3).collect();
    assert!(kolmogorov_smirnov(&one, &same).1 > 0.99);
    let (distance, probability) = kolmogorov_smirnov(&one, &apart);
    assert!((distance - 0.3).abs() < 0.02 && probability < 1e-3, "{distance} {probability}");
}

#[test]
fn flights_over_the_lines_have_the_percentiles_of_a_campaign() {
    let campaign = campaign();
    let judged_from_s = campaign.judged_from_s;
    let simulated: Vec<[f64; 5]> = (1..=sample(CAMPAIGN / SAMPLED, CAMPAIGN))
        .map(|seed| of_campaign(&flight(&campaign, seed), judged_from_s))
        .collect();
    let over_lines = sample(OVER_LINES / SAMPLED, OVER_LINES);
    let seeds: Vec<u64> = (CAMPAIGN + 1..=CAMPAIGN + over_lines).collect();
    let flights = all_flown(&seeds, |seed| {
        let flight = flight(&campaign, *seed);
        let engage = format!("engage@{}", flight.engage_s);
        let navigation = Some(flight.manifest());
        Setup { flight, navigation, ..Setup::new(campaign.duration_s, &[&engage]) }
    });
    assert!(flights.iter().all(|flown| flown.crashed_s.is_none()));
    let over_lines: Vec<[f64; 5]> =
        flights.iter().map(|flown| of_lines(flown, judged_from_s)).collect();
    let mut apart = Vec::new();
    for (measure, name) in MEASURES.into_iter().enumerate() {
        let [one, other] = [&simulated, &over_lines]
            .map(|flights| flights.iter().map(|flight| flight[measure]).collect::<Vec<_>>());
        let (distance, probability) = kolmogorov_smirnov(&one, &other);
        let at = |values: &[f64]| {
            [0.1, 0.5, 0.9].map(|share| format!("{:.3}", percentile(values, share))).join(", ")
        };
        println!(
            "{name:<24} campaign {}  lines {}  D {distance:.3}  probability {probability:.3}",
            at(&one),
            at(&other)
        );
        if probability < MIN_PROBABILITY {
            apart.push(name);
        }
    }
    assert!(apart.is_empty(), "{apart:?}");
}
