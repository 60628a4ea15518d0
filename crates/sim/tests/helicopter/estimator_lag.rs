//! Lag of the estimator's solution behind the true motion, measured for the default of the design.

use approx::assert_abs_diff_eq;
use hovernav::autopilot::{Excitation, ExcitationLimits, HoverConfig, Maneuver};
use hovernav::controls::Sticks;
use hovernav::ekf::{Estimator, Solution, SteplessSolution};
use hovernav::event::Event;
use hovernav_dataset::Truth;
use hovernav_design::hover::{EstimatorLag, HoverDesign};
use hovernav_model::shipped;
use hovernav_sim::{Feedback, Flight, FlightConfig, FlightEvent};

/// Measurements of the loops, in the order p, q, r, phi, theta, psi, u, v, w.
const NAMES: [&str; 9] = ["p", "q", "r", "phi", "theta", "psi", "u", "v", "w"];

/// A gusty hover in which the autopilot flies 3-2-1-1 inputs on every stick, with the truth as feedback. With the
/// estimate as feedback the vehicle would follow the estimate's errors, which would look like a lag.
fn flight(seed: u64) -> (Flight, FlightConfig) {
    let (design, model) = (HoverDesign::default(), shipped::raptor60());
    let autopilot = HoverConfig::new(design.period_s, design.synthesise(&model).unwrap());
    let mut config = FlightConfig { seed, duration_s: 150.0, ..FlightConfig::new(autopilot) };
    config.feedback = Feedback::Truth;
    for (stick, at_s) in (0..4).zip([40.0, 65.0, 90.0, 115.0]) {
        let mut direction = [0.0; 4];
        direction[stick] = 1.0;
        let excitation = Excitation {
            direction: Sticks::from_array(direction),
            maneuver: Maneuver::ThreeTwoOneOne { amplitude: 0.1, unit_s: 0.5 },
            limits: ExcitationLimits::default(),
        };
        config.events.push((at_s, FlightEvent::Excite(excitation)));
    }
    let flight = config.fly().unwrap();
    assert_eq!(flight.crashed_s, None);
    (flight, config)
}

/// Solution for the controller at each sample: the estimate without the jumps by corrections.
fn flown(flight: &Flight, config: &FlightConfig) -> Vec<Option<Solution>> {
    let mut estimator = Estimator::new(config.settings().unwrap());
    let mut stepless = SteplessSolution::default();
    let mut fixes = flight.fixes.iter().peekable();
    let heard = flight.samples.iter().zip(&flight.imu).map(|(sample, imu)| {
        estimator.push_traced(&Event::Imu(*imu), &mut stepless, |_| {});
        let now = sample.truth.time;
        while let Some(fix) = fixes.next_if(|fix| fix.time + config.gps.latency_s <= now) {
            estimator.push_traced(&Event::Gps(*fix), &mut stepless, |_| {});
        }
        estimator.solution().map(|solution| stepless.solution(&solution))
    });
    heard.collect()
}

fn quantities(of: &Truth) -> [f64; 9] {
    let angles = of.body_to_ned.euler();
    let [p, q, r] = of.angular_rate_radps.to_array();
    let [u, v, w] = (of.body_to_ned.inverse() * of.velocity_mps).to_array();
    [p, q, r, angles.roll_rad, angles.pitch_rad, angles.yaw_rad, u, v, w]
}

fn estimated(of: &Solution) -> [f64; 9] {
    let angles = of.body_to_ned.euler();
    let [p, q, r] = of.angular_rate_radps.to_array();
    let [u, v, w] = of.velocity_body_mps().to_array();
    [p, q, r, angles.roll_rad, angles.pitch_rad, angles.yaw_rad, u, v, w]
}

/// Lag of each quantity of the solution, s: the τ for which s − τ ds/dt of the truth s(t) is nearest to the estimate.
/// Errors uncorrelated with the motion, such as GPS drift or a bias, average out.
fn lags_s(seeds: std::ops::RangeInclusive<u64>) -> [f64; 9] {
    /// Number of samples, about 3 s, over which the means of truth and of error are removed: slower differences are not
    /// lag.
    const WINDOW: usize = 99;
    let (mut product, mut square) = ([0.0; 9], [0.0; 9]);
    for seed in seeds {
        let (flight, config) = flight(seed);
        let flown = flown(&flight, &config);
        let period_s = config.autopilot.period_s;
        let truth: Vec<[f64; 9]> = flight.samples.iter().map(|s| quantities(&s.truth)).collect();
        let first = (35.0 / period_s) as usize;
        for quantity in 0..9 {
            let turn = |angle: f64| match quantity {
                3..6 => hovernav::frames::wrap_angle(angle),
                _ => angle,
            };
            let slope = |at: usize| {
                turn(truth[at + 1][quantity] - truth[at - 1][quantity]) / (2.0 * period_s)
            };
            let error = |at: usize| {
                let solution = flown[at].as_ref().expect("aligned by now");
                turn(estimated(solution)[quantity] - truth[at][quantity])
            };
            let last = truth.len() - 1;
            for start in (first..last - WINDOW).step_by(WINDOW) {
                let window = start..start + WINDOW;
                let mean_of =
                    |of: &dyn Fn(usize) -> f64| window.clone().map(of).sum::<f64>() / WINDOW as f64;
                let (mean_slope, mean_error) = (mean_of(&slope), mean_of(&error));
                for at in window {
                    let own = slope(at) - mean_slope;
                    product[quantity] -= own * (error(at) - mean_error);
                    square[quantity] += own * own;
                }
            }
        }
    }
    std::array::from_fn(|quantity| product[quantity] / square[quantity])
}

#[test]
fn the_design_counts_for_the_estimator_what_it_is_late_by() {
    let lags_s = lags_s(1..=12);
    for (name, lag_s) in NAMES.iter().zip(lags_s) {
        println!("{name}: {:.1} ms late", 1e3 * lag_s);
    }
    let EstimatorLag { rate_s, attitude_s, velocity_s } = EstimatorLag::default();
    let [p, q, r, phi, theta, psi, u, v, w] = lags_s;
    for found in [p, q, r] {
        assert_abs_diff_eq!(found, rate_s, epsilon = 1e-3);
    }
    for found in [phi, theta, psi] {
        assert_abs_diff_eq!(found, attitude_s, epsilon = 2e-3);
    }
    assert_abs_diff_eq!(w, velocity_s, epsilon = 3e-3);
    // Attitude errors change horizontal velocities as slowly as manoeuvres do, so their lags are accurate to about 15
    // ms only.
    assert!([u, v].iter().all(|found| found.abs() < 40e-3), "{u} {v}");
}
