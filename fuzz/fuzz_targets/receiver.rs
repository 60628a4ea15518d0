//! Properties of any receiver's stream, for any bytes.

use hovernav::gps::quality::{Limits, QualityCheck};
use hovernav::gps::{Protocol, Receiver, ReceiverFix, ReceiverTime};
use hovernav::time::Time;

/// No panic, no fix out of range, no fix without data, and the same fixes for any cuts of the stream.
pub fn check(protocol: Protocol, stream: &[u8]) {
    let whole = read(protocol, &[stream]);
    assert!(whole.len() * 8 <= stream.len(), "more fixes than there is room for");
    let mut quality = QualityCheck::new(Limits::default());
    for fix in &whole {
        assert_possible(fix);
        let _ = quality.check(fix).iter().count();
        let _ = fix.at(fix.arrival);
    }
    let cut = stream.first().map_or(0, |first| usize::from(*first) % (stream.len() + 1));
    let (a, b) = stream.split_at(cut);
    assert_eq!(read(protocol, &[a, b]), whole, "cut at {cut}");
}

fn read(protocol: Protocol, pieces: &[&[u8]]) -> Vec<ReceiverFix> {
    let mut receiver = Receiver::new(protocol);
    let mut fixes = Vec::new();
    for piece in pieces {
        let mut rest = *piece;
        while let Some(fix) = receiver.read(&mut rest, Time::ZERO) {
            fixes.push(fix);
        }
        assert!(rest.is_empty());
    }
    fixes.extend(receiver.flush());
    fixes
}

fn assert_possible(fix: &ReceiverFix) {
    let within = |value: Option<f64>, limit: f64| value.is_none_or(|value| value.abs() <= limit);
    assert!(fix.latitude_rad.abs() <= std::f64::consts::FRAC_PI_2);
    assert!(fix.longitude_rad.abs() <= std::f64::consts::PI);
    assert!(within(fix.height_m, 1e5) && within(fix.altitude_msl_m, 1e5));
    let [north, east] = fix.horizontal_velocity_mps.map_or([None; 2], |v| v.map(Some));
    // Earth-fixed components are limited one by one before their rotation.
    for speed in [north, east, fix.down_velocity_mps, fix.ground_speed_mps] {
        assert!(within(speed, 1_040.0));
    }
    for sigma in [fix.position_sigma_m, fix.velocity_sigma_mps].into_iter().flatten() {
        assert!(sigma.to_array().iter().all(|sigma| *sigma > 0.0));
    }
    match fix.time {
        Some(ReceiverTime::Gps { time_of_week_ns, .. }) => {
            assert!(time_of_week_ns < 604_800_000_000_000);
        }
        Some(ReceiverTime::Utc { time_of_day_ns, .. }) => {
            assert!(time_of_day_ns < 86_400_000_000_000);
        }
        None => {}
    }
}
