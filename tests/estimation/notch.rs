//! Effect of a notch at the rotor frequency on the solution.

use hovernav::earth::Geodetic;
use hovernav::frames::Vector;
use hovernav::imu::{Notch, NotchConfig};
use hovernav_dataset::{Dataset, Outage};
use hovernav_replay::estimate;
use hovernav_sim::{
    AccelerometerConfig, DmuConfig, DmuOutput, FlightPlan, GpsConfig, GyroConfig, Harmonic,
    VibrationSource, fly,
};

const ROTOR_HZ: f64 = 23.0;
const START_S: f64 = 30.0;

/// Two minutes of hover and manoeuvres at 100 Hz. The rotor's vibration at its first two harmonics is `times` the usual
/// one, and fixes are absent for 20 s from 70 s on.
fn flight(times: f64, seed: u64) -> (Dataset, Vec<hovernav_dataset::Truth>) {
    let start = Geodetic::from_degrees(47.0, 8.0, 400.0).unwrap();
    let forward = |speed_mps| Vector::new(speed_mps, 0.0, 0.0);
    let plan = FlightPlan::hover_at(start, 0.7)
        .hold(25.0)
        .accelerate(forward(8.0), 5.0)
        .turn(core::f64::consts::TAU, 25f64.to_radians())
        .roll_doublet(8f64.to_radians(), 1.5)
        .climb(10.0, 2.5)
        .accelerate(forward(-8.0), 5.0);
    let rest_s = 120.0 - plan.duration_s();
    let harmonic = |order: f64, rate: [f64; 3], force: [f64; 3]| Harmonic {
        order,
        angular_rate_degps: Vector::from(rate) * times,
        specific_force_mps2: Vector::from(force) * times,
    };
    let rotor = VibrationSource {
        frequency_hz: ROTOR_HZ,
        wander_sigma_hz: 0.1,
        wander_time_s: 20.0,
        harmonics: vec![
            harmonic(1.0, [2.0, -1.8, 1.2], [0.8, 0.8, -0.5]),
            harmonic(2.0, [1.6, 1.6, -0.8], [0.9, -0.9, 1.7]),
        ],
    };
    let dmu = DmuConfig {
        gyro: GyroConfig::default(),
        accelerometer: AccelerometerConfig::default(),
        vibration: vec![rotor],
        ..DmuConfig::ideal(100.0, DmuOutput::Rates)
    };
    let gps = GpsConfig::default();
    let trajectory = plan.hold(rest_s).build().unwrap();
    let recording = fly(&trajectory, &dmu, &gps, seed).unwrap();
    let mut dataset = Dataset { imu: recording.imu, fixes: recording.fixes, ..Dataset::default() };
    dataset.manifest.gps.antenna_lever_arm_m = gps.lever_arm_m;
    // The heading comes from the truth, because this test does not concern it.
    for (sample, truth) in dataset.imu.iter_mut().zip(&recording.truth) {
        sample.attitude = Some(truth.body_to_ned.euler());
    }
    let outage = Outage { start: hovernav::time::Time::ZERO + 70.0, duration_s: 20.0 };
    dataset.withhold(&[outage], None);
    (dataset, recording.truth)
}

/// RMS velocity error, m/s, RMS of its one-sigma, and RMS angle between the true and the estimated vertical, °, after
/// the start.
fn errors(
    dataset: &mut Dataset,
    truth: &[hovernav_dataset::Truth],
    notch: Option<NotchConfig>,
) -> [f64; 3] {
    dataset.manifest.imu.notch = notch;
    // The inertial unit's own attitude is used for the start only.
    let mut config = dataset.settings().unwrap();
    config.aiding.attitude = false;
    let run = estimate(dataset, &config, |_| {});
    let (mut sums, mut count) = ([0.0; 3], 0.0);
    let interval_s = truth[1].time - truth[0].time;
    for solution in run.solutions.iter().filter(|solution| solution.time.seconds() > START_S) {
        // The notch moves the time stamps of the samples back: the truth is interpolated between two of its samples.
        let place = solution.time.seconds() / interval_s;
        let (before, share) = (place.floor() as usize, place.fract());
        let Some([a, b]) = truth.get(before..before + 2) else { continue };
        let velocity = a.velocity_mps * (1.0 - share) + b.velocity_mps * share;
        let down = |attitude: hovernav::frames::Rotation<_, hovernav::frames::Ned>| {
            attitude.inverse() * Vector::new(0.0, 0.0, 1.0)
        };
        let vertical: Vector<hovernav::frames::Body> =
            down(a.body_to_ned) * (1.0 - share) + down(b.body_to_ned) * share;
        let off = (down(solution.body_to_ned) - vertical).norm();
        let values = [
            (solution.velocity_mps - velocity).norm(),
            solution.velocity_sigma_mps.norm(),
            off.to_degrees(),
        ];
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value * value);
        count += 1.0;
    }
    assert!(count > 8000.0);
    sums.map(|sum| (sum / count).sqrt())
}

#[test]
fn a_notch_helps_a_shaken_unit_and_does_a_still_one_no_harm() {
    println!("rms over 3 flights: velocity error, its one-sigma, m/s, tilt, °");
    let mut table = Vec::new();
    for times in [0.0, 1.0, 4.0] {
        let mut sums = [[0.0; 3]; 2];
        for seed in 1..=3 {
            let (mut dataset, truth) = flight(times, seed);
            let config = NotchConfig::at_hz(ROTOR_HZ).with_harmonics(2);
            for (sum, notch) in sums.iter_mut().zip([None, Some(config)]) {
                let errors = errors(&mut dataset, &truth, notch);
                sum.iter_mut().zip(errors).for_each(|(sum, error)| *sum += error / 3.0);
            }
        }
        println!("vibration x{times}: without {:.3?}, with {:.3?}", sums[0], sums[1]);
        table.push(sums);
    }
    let [still, _, shaken] = [table[0], table[1], table[2]];
    // The time stamps are right: without vibration the notch has no cost.
    assert!(still[1][0] < 1.05 * still[0][0] && still[1][2] < 1.05 * still[0][2], "{still:?}");
    assert!(shaken[1][0] < shaken[0][0], "{shaken:?}");
    // Without a notch the filter treats the tones as noise, and is less accurate than possible.
    assert!(shaken[1][1] < 0.8 * shaken[0][1], "{shaken:?}");
}

#[test]
fn a_notch_next_to_the_rotor_gains_nothing_and_costs_little() {
    let (mut dataset, truth) = flight(4.0, 1);
    let without = errors(&mut dataset, &truth, None);
    let right = errors(&mut dataset, &truth, Some(NotchConfig::at_hz(ROTOR_HZ).with_harmonics(2)));
    let detuned = errors(&mut dataset, &truth, Some(NotchConfig::at_hz(31.0).with_harmonics(2)));
    println!("x4, without {without:.3?}, at the rotor {right:.3?}, 8 Hz off {detuned:.3?}");
    assert!(detuned[1] > 0.9 * without[1] && detuned[0] < 1.2 * without[0], "{detuned:?}");
}

#[test]
fn a_rotor_that_is_followed_is_followed_from_its_own_file() {
    let (mut dataset, _) = flight(4.0, 9);
    dataset.manifest.imu.notch = Some(NotchConfig::default());
    let raw: Vec<_> = dataset.imu.iter().map(|sample| sample.motion).collect();
    let filtered = |dataset: &Dataset| -> Vec<_> {
        let samples = dataset.events().filter_map(|event| match event {
            hovernav::event::Event::Imu(sample) => Some(sample.motion),
            _ => None,
        });
        samples.collect()
    };
    // Without a frequency, nothing is removed.
    assert_eq!(filtered(&dataset), raw);
    dataset.rotor = vec![(hovernav::time::Time::ZERO, ROTOR_HZ)];
    let with_file = filtered(&dataset);
    assert_ne!(with_file, raw);
    dataset.rotor.clear();
    dataset.manifest.imu.notch = Some(NotchConfig::at_hz(ROTOR_HZ));
    assert_eq!(filtered(&dataset).len(), with_file.len());
    let mut notch = Notch::new(NotchConfig::at_hz(ROTOR_HZ));
    let own: Vec<_> = dataset.imu.iter().map(|sample| notch.filter(sample).motion).collect();
    assert_eq!(filtered(&dataset), own);
}
