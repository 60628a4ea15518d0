//! Innovations of the onboard estimator are read with hovernav's signs and units.

use std::path::Path;

use hovernav::ekf::{Channel, Innovation};
use hovernav_formats::{Log, Onboard, OnboardInnovation, Options, open, open_bytes};
use hovernav_replay::estimate;
use hovernav_testing::shared;

fn read(name: &str) -> Option<Log> {
    shared(format!("logs/{name}")).map(|path| open(&path, &Options::default()).unwrap())
}

fn of(onboard: &Onboard, channel: Channel) -> Vec<OnboardInnovation> {
    onboard.innovations.iter().filter(|one| one.channel == channel).copied().collect()
}

/// Correlation of the onboard innovations of a channel with hovernav's, over pairs within 0.15 s.
fn correlation(ours: &[Innovation], theirs: &[OnboardInnovation]) -> f64 {
    let (mut both, mut own, mut other) = (0.0, 0.0, 0.0);
    for their in theirs {
        let near = ours.iter().min_by(|a, b| {
            let distance = |one: &Innovation| (one.time - their.time).abs();
            distance(a).total_cmp(&distance(b))
        });
        let Some(our) = near.filter(|our| (our.time - their.time).abs() < 0.15) else { continue };
        both += our.innovation * their.innovation;
        own += our.innovation * our.innovation;
        other += their.innovation * their.innovation;
    }
    both / (own * other).sqrt()
}

#[test]
fn innovations_of_px4_have_our_sign_and_unit() {
    let Some(mut log) = read("px4-quad-vibration-2025.ulg") else { return };
    let config = log.dataset.settings().unwrap();
    let run = estimate(&log.dataset, &config, |_| {});
    let ours = hovernav_score::innovations(&run);
    let onboard = log.onboard.unwrap();
    // Only innovations before the roll failure count; after it the two estimators differ.
    let ours: Vec<Innovation> = ours.into_iter().filter(|one| one.time.seconds() < 60.0).collect();
    for channel in [
        Channel::PositionNorth,
        Channel::PositionEast,
        Channel::PositionDown,
        Channel::VelocityNorth,
        Channel::VelocityEast,
        Channel::VelocityDown,
        Channel::BaroHeight,
    ] {
        let theirs = of(&onboard, channel);
        let ours: Vec<Innovation> =
            ours.iter().filter(|one| one.channel == channel).copied().collect();
        let alike = correlation(&ours, &theirs);
        println!("{}: {} of theirs, correlation {alike:.2}", channel.name(), theirs.len());
        assert!(theirs.len() > 50, "{}", channel.name());
        // Hovernav's slow-error states of the fix absorb position errors. So its innovations are a tenth of the others,
        // but correlated.
        let least = match channel {
            Channel::PositionNorth | Channel::PositionEast => 2.5 / (theirs.len() as f64).sqrt(),
            _ => 0.25,
        };
        assert!(alike > least, "{}: {alike}", channel.name());
        assert!(theirs.iter().filter(|one| one.sigma.is_some()).count() * 10 > 9 * theirs.len());
    }
    let sizes = onboard.innovation_sizes(&ours);
    let north = sizes["position_north_m"];
    assert!((0.1..3.0).contains(&north.onboard.rms), "{north:?}");
    assert!(north.ours.is_some_and(|ours| ours.count > 50));
}

#[test]
fn innovations_of_older_logs_are_read() {
    let Some(log) = read("sample_appended_multiple.ulg") else { return };
    let onboard = log.onboard.unwrap();
    let yaw = of(&onboard, Channel::Yaw);
    assert!(yaw.len() > 50 && yaw.iter().all(|one| one.sigma.is_some()));
    assert!(of(&onboard, Channel::BaroHeight).is_empty());
}

#[test]
fn ardupilot_innovations_are_read_from_the_first_core_in_metres() {
    // FMT has names and format characters; c means hundredths.
    let text = "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n\
                FMT, 1, 9, IMU, Qffffff, TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ\n\
                FMT, 2, 9, XKF3, QBcccccccccc, TimeUS,C,IVN,IVE,IVD,IPN,IPE,IPD,IMX,IMY,IMZ,IYAW\n\
                IMU, 1000000, 0, 0, 0.01, 0, 0, -9.8\n\
                XKF3, 1000000, 0, 0.5, 0, 0, 1.5, 0, 0, 0, 0, 0, 90\n\
                XKF3, 1000000, 1, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7\n\
                XKF3, 1100000, 0, 0.5, 0, 0, 1.6, 0, 0, 0, 0, 0, 90\n\
                IMU, 1100000, 0, 0, 0.01, 0.1, 0, -9.8\n";
    let log = open_bytes(text.as_bytes(), Path::new("a.log"), &Options::default()).unwrap();
    let onboard = log.onboard.unwrap();
    let sizes =
        |channel| -> Vec<f64> { of(&onboard, channel).iter().map(|one| one.innovation).collect() };
    assert_eq!(sizes(Channel::PositionNorth), [-1.5, -1.6]);
    // A repeated value is not a new measurement.
    assert_eq!(sizes(Channel::VelocityNorth), [-0.5]);
    assert_eq!(sizes(Channel::Yaw), [-std::f64::consts::FRAC_PI_2]);
    assert!(sizes(Channel::PositionEast).is_empty());
}
