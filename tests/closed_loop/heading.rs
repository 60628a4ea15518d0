//! Heading in gusts, and its causes. The filter continuously revises its estimate of the magnetometer's error, and the
//! vehicle must not turn because of it.

use hovernav_sim::{Feedback, Flight, FlightConfig};

use crate::autopilot;
use crate::campaign::fly_all;

/// Heading and pedal of a flight, ° and full sticks, from 30 s on.
struct Heading {
    /// Largest turn of the vehicle from its first heading.
    farthest_deg: f64,
    /// Largest deviation of the commanded heading from its mean.
    told_deg: f64,
    /// Largest change of the estimate's error from its first value.
    error_deg: f64,
    /// Slope of the heading over the estimate's error.
    slope: f64,
    /// Largest deflection of the pedal.
    pedal: f64,
}

fn heading(flight: &Flight) -> Heading {
    assert_eq!(flight.crashed_s, None);
    let held = || flight.samples.iter().filter(|sample| sample.truth.time.seconds() >= 30.0);
    let degrees = |from: f64, to: f64| hovernav::frames::wrap_angle(to - from).to_degrees();
    let truths: Vec<f64> = held().map(|sample| sample.truth.body_to_ned.euler().yaw_rad).collect();
    let told: Vec<f64> =
        held().filter_map(|sample| Some(sample.solution?.body_to_ned.euler().yaw_rad)).collect();
    let farthest =
        |of: &[f64], from: f64| of.iter().map(|&yaw| degrees(from, yaw).abs()).fold(0.0, f64::max);
    let middle = told.first().map_or(0.0, |&first| {
        let sum: f64 = told.iter().map(|&yaw| degrees(first, yaw)).sum();
        first + (sum / told.len() as f64).to_radians()
    });
    let errors: Vec<f64> = truths.iter().zip(&told).map(|(&yaw, &told)| told - yaw).collect();
    let about_mean = |of: &[f64]| -> Vec<f64> {
        let from_first: Vec<f64> = of.iter().map(|&yaw| degrees(of[0], yaw)).collect();
        let mean = from_first.iter().sum::<f64>() / from_first.len() as f64;
        from_first.into_iter().map(|own| own - mean).collect()
    };
    let (turned, led) = (about_mean(&truths), about_mean(&errors));
    let product =
        |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
    Heading {
        farthest_deg: farthest(&truths, truths[0]),
        told_deg: farthest(&told, middle),
        error_deg: errors.first().map_or(0.0, |&first| farthest(&errors, first)),
        slope: product(&turned, &led) / product(&led, &led),
        pedal: held().map(|sample| sample.sticks.pedal.abs()).fold(0.0, f64::max),
    }
}

/// Mean and worst value of `of`.
fn mean_and_worst(flights: &[Heading], of: impl Fn(&Heading) -> f64) -> [f64; 2] {
    let sum: f64 = flights.iter().map(&of).sum();
    [sum / flights.len() as f64, flights.iter().map(of).fold(0.0, f64::max)]
}

fn tell_apart(seeds: u64) {
    let by_estimate = FlightConfig::new(autopilot());
    let by_truth = FlightConfig { feedback: Feedback::Truth, ..by_estimate.clone() };
    let flown = fly_all(&by_estimate, seeds, heading);
    let truth = fly_all(&by_truth, seeds, heading);
    let farthest = mean_and_worst(&flown, |own| own.farthest_deg);
    let told = mean_and_worst(&flown, |own| own.told_deg);
    let error = mean_and_worst(&flown, |own| own.error_deg);
    let pedal = mean_and_worst(&flown, |own| own.pedal);
    let by_truth = mean_and_worst(&truth, |own| own.farthest_deg);
    println!(
        "by the estimate: farthest {farthest:.2?}°, from the commanded heading {told:.2?}°, error {error:.2?}°"
    );
    println!("pedal {pedal:.2?} of its travel; flown by the truth, farthest {by_truth:.2?}°");
    let slopes = || flown.iter().map(|own| own.slope);
    let slopes = [slopes().fold(0.0, f64::min), slopes().fold(f64::NEG_INFINITY, f64::max)];
    println!("heading over its estimate's error: slopes {slopes:.3?}");
    assert!(farthest[1] < 2.0, "a heading that is not held: {farthest:?}");
    assert!(slopes[0] > -0.2 && slopes[1] < 0.2, "it goes after its estimate: {slopes:?}");
    assert!(error[1] > 2.0 * farthest[1], "no error to go after: {error:?}");
    assert!(by_truth[1] < 1.0, "{by_truth:?}");
    assert!(pedal[1] < 0.9, "{pedal:?}");
}

#[test]
fn in_gusts_the_heading_stays_where_its_estimate_goes() {
    tell_apart(6);
}

#[test]
#[ignore = "400 flights of 300 s"]
fn in_two_hundred_gusty_hovers_the_heading_stays_where_its_estimate_goes() {
    tell_apart(200);
}
