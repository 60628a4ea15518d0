//! Delay of the collective from a pilot's steps, in records without the injected signal.
//!
//! The flights of seeds 1510 to 1525 were each evaluated once.

use hovernav_model::helicopter::HelicopterParameters;
use hovernav_model::shipped;
use hovernav_sysid::methods::prediction_error::{Settings, delay_from_injected, identify};
use hovernav_sysid::methods::structure::{Parameter, Structure};
use hovernav_sysid::record::Experiment;
use nalgebra::DMatrix;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::{Distribution as _, StandardNormal};

use crate::chain;
use crate::data;

/// Sampling period of the simulated heave, s.
const PERIOD_S: f64 = 0.03;
/// Delay of the simulated heave, s: between two samples.
const DELAY_S: f64 = 0.045;
/// Expected lag of the servo and its sigma, s, as in the built-in structures.
const LAG_S: f64 = 0.016;
const LAG_SIGMA_S: f64 = 0.012;

/// Heave of a pilot who steps the collective and counters each gust before the velocity shows it, with a servo of the
/// lag `lag_s`.
fn heave(seed: u64, lag_s: f64) -> Experiment {
    const SAMPLES: usize = 1500;
    const PARTS: usize = 30;
    let (zw, zcol, part_s) = (-0.8, -12.0, PERIOD_S / PARTS as f64);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let gusts: Vec<f64> = (0..=SAMPLES).map(|_| 0.5 * normal()).collect();
    let late = (DELAY_S / part_s).round() as usize;
    let mut inputs = DMatrix::zeros(SAMPLES, 2);
    let mut outputs = DMatrix::zeros(SAMPLES, 1);
    let (mut w, mut servo) = (0.0, 0.0);
    for sample in 0..SAMPLES {
        let step = if (sample / 50) % 4 == 1 { 0.12 } else { 0.0 };
        outputs[(sample, 0)] = w + 0.01 * normal();
        inputs[(sample, 0)] = step + 0.1 * w + 0.01 * gusts[sample + 1];
        inputs[(sample, 1)] = step;
        for part in 0..PARTS {
            let sent = (sample * PARTS + part).checked_sub(late);
            let command = sent.map_or(0.0, |sent| inputs[(sent / PARTS, 0)]);
            servo += (1.0 - (-part_s / lag_s).exp()) * (command - servo);
            w += part_s * (zw * w + zcol * servo + gusts[sample]);
        }
    }
    let names = ["collective", "stepped"].map(str::to_owned).to_vec();
    Experiment::new("heave", PERIOD_S, names, vec!["w".to_owned()], inputs, outputs).unwrap()
}

fn structure() -> Structure {
    let parameters = vec![
        Parameter::new("Zw", "1/s", -0.7),
        Parameter::new("Zcol", "m/s²", -10.0),
        Parameter::new("tau", "s", 0.03).within(-0.03, 0.2),
        Parameter::new("lag", "s", LAG_S).within(0.0, 0.1).expected(LAG_S, LAG_SIGMA_S),
    ];
    let text = "inputs collective\nnoise n\noutputs w\noffsets w\ndelay collective tau
                lag collective lag\nw' = Zw*w + Zcol*collective + n";
    Structure::new("heave", parameters, text).unwrap()
}

/// Mean square of normalised errors, asserted to be within the central 99 % of χ²/N. The quantiles are by Wilson and
/// Hilferty (1931), 2 % accurate from N = 8.
fn assert_as_large_as_bounds(what: &str, normalised: &[f64]) {
    let count = normalised.len() as f64;
    let mean_square = normalised.iter().map(|error| error * error).sum::<f64>() / count;
    let spread = 2.0 / (9.0 * count);
    let [least, most] = [-2.576, 2.576].map(|z: f64| (1.0 - spread + z * spread.sqrt()).powi(3));
    println!("{what}: mean square {mean_square:.2} of squared bounds, {least:.2} to {most:.2}");
    assert!((least..most).contains(&mean_square), "{what}: {mean_square}");
}

/// The expected lag of the servo has a sigma of 12 ms, and the steps determine the sum of lag and delay. Without the
/// covariance of the delay with the other parameters, the mean square is 2.5. The likelihood has 4.4, because the pilot
/// foresees gusts.
#[test]
fn a_delay_errs_as_far_as_its_bound_with_the_errors_of_the_other_parameters() {
    let settings = Settings { residual_correlation_s: 0.3, ..Settings::innovations(vec![0.5]) };
    let mut lags = ChaCha8Rng::seed_from_u64(99);
    let (mut errors, mut sizes) = (Vec::new(), Vec::new());
    for seed in 0..40 {
        let normal: f64 = StandardNormal.sample(&mut lags);
        let flight = [heave(seed, (LAG_S + LAG_SIGMA_S * normal).max(0.001))];
        let found = identify(&structure(), &flight, &settings).unwrap();
        let signals = ("collective", "stepped");
        let solved = delay_from_injected(&found, signals, &flight, &settings).unwrap().unwrap();
        let [likely, delay] = [&found, &solved].map(|own| own.estimates.get("tau").unwrap());
        errors.push((delay.value - DELAY_S) / delay.bound);
        sizes.push(delay.bound / likely.white_bound);
    }
    assert_as_large_as_bounds("delay", &errors);
    // No estimate is more accurate than the likelihood, which uses all information of the flight.
    let size = sizes.iter().sum::<f64>() / sizes.len() as f64;
    println!("{size:.2} of the bound that the information permits");
    assert!((1.0..2.0).contains(&size), "{size}");
}

/// The flight determines the sum of delay and lag, not each of them. Without the covariance with the lag, the bound of the
/// delay is 0.5 ms.
#[test]
fn a_recorded_delay_is_known_no_better_than_the_lag_that_replaces_it() {
    let (dataset, solutions) = data::flown();
    assert!(dataset.injected.iter().flatten().all(|own| *own == 0.0));
    let found = data::identified(&dataset, &solutions, "heave").identified;
    let (delay, lag) = (found.delay("collective").unwrap(), found.lag("collective").unwrap());
    println!("delay {} ± {} s, lag {} ± {} s", delay.value, delay.bound, lag.value, lag.bound);
    assert!(delay.bound > 0.5 * lag.bound && lag.bound > 0.005);
}

/// The test points are flown by an autopilot with the true state, as by a pilot. Vibration leaves the delay ambiguous by
/// whole samples. Bounds from one minimum are 2 to 4 ms, for errors up to 36 ms.
fn assert_flights_keep_their_bounds(seeds: std::ops::RangeInclusive<u64>) {
    let late = |seed| {
        let (mut dataset, solutions) =
            chain::flown(HelicopterParameters::raptor60(), &shipped::raptor60(), seed);
        dataset.injected.clear();
        let found = data::identified(&dataset, &solutions, "heave").identified;
        let (off_s, bound_s) = chain::lateness(&found, "collective");
        let delay = found.delay("collective").unwrap();
        println!(
            "{seed}: {:.1} ± {:.1} ms late, delay {:.1} ± {:.1} ms",
            1e3 * off_s,
            1e3 * bound_s,
            1e3 * delay.value,
            1e3 * delay.bound
        );
        (off_s, off_s / bound_s, (delay.value - chain::WAIT_S) / delay.bound)
    };
    let late: Vec<(f64, f64, f64)> = seeds.map(late).collect();
    let mean_ms = 1e3 * late.iter().map(|late| late.0).sum::<f64>() / late.len() as f64;
    println!("mean {mean_ms:.1} ms late");
    assert!(mean_ms.abs() < 10.0 && late.iter().all(|late| late.1.abs() < 4.0));
    let (sums, delays): (Vec<f64>, Vec<f64>) = late.iter().map(|late| (late.1, late.2)).unzip();
    assert_as_large_as_bounds("sum of delay and lag", &sums);
    assert_as_large_as_bounds("delay", &delays);
}

#[test]
fn the_collectives_own_steps_tell_its_delay_where_nothing_was_injected() {
    assert_flights_keep_their_bounds(1510..=1517);
}

#[test]
#[ignore = "ten seconds: eight flights and identifications"]
fn the_collectives_own_steps_tell_its_delay_in_eight_more_flights() {
    assert_flights_keep_their_bounds(1518..=1525);
}
