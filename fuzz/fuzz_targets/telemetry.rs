//! Any bytes through the ground's decoder, and any values through the vehicle's packing.
//!
//! A delivered frame, packed again, gives the bytes from which it was decoded. A complete frame after a zero is found,
//! regardless of earlier bytes.
#![no_main]

use hovernav::controls::Channels;
use hovernav::earth::Geodetic;
use hovernav::frames::{EulerAngles, Vector};
use hovernav::telemetry::{Flow, Snapshot, frame};
use hovernav::time::Time;
use libfuzzer_sys::fuzz_target;

/// A snapshot of any numbers of the input, including NaN and infinities.
fn any_snapshot(input: &[u8]) -> Snapshot {
    let mut numbers = input.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes));
    let mut next = || numbers.next();
    let mut snapshot =
        Snapshot::at(Time::try_from_seconds(next().unwrap_or(0.0)).unwrap_or_default());
    let mut three = || Some([next()?, next()?, next()?]);
    snapshot.angular_rate_radps = three().map(Vector::from);
    snapshot.specific_force_mps2 = three().map(Vector::from);
    snapshot.velocity_mps = three().map(Vector::from);
    snapshot.attitude =
        three().map(|[roll_rad, pitch_rad, yaw_rad]| EulerAngles { roll_rad, pitch_rad, yaw_rad });
    snapshot.position = three().map(|[latitude_rad, longitude_rad, height_m]| Geodetic {
        latitude_rad,
        longitude_rad,
        height_m,
    });
    snapshot.gps.latitude_longitude_deg =
        three().map(|[latitude, longitude, _]| [latitude, longitude]);
    snapshot.commanded_ms = Channels::from_fn(|_| next());
    snapshot.temperature_degc = next();
    snapshot.gps.age_s = next();
    snapshot.innovations.velocity = next();
    snapshot.timing.period_s = next();
    snapshot
}

fuzz_target!(|input: &[u8]| {
    Flow::default().receive(input);

    let mut decoder = frame::Decoder::default();
    for byte in input {
        let _ = decoder.push_message(*byte);
    }
    let counts = *decoder.counts();
    assert_eq!(counts.bytes, input.len() as u64);
    assert!(counts.frames * frame::SUPPLEMENT_LENGTH as u64 <= counts.bytes);

    let packed = frame::pack(&any_snapshot(input), 7);
    assert!(packed[..frame::LENGTH - 1].iter().all(|byte| *byte != 0));
    let _ = decoder.push(0);
    let found: Vec<_> = packed.iter().filter_map(|byte| decoder.push(*byte)).collect();
    let [Ok(told)] = found[..] else { panic!("{found:?}") };
    // Values that were packed once do not change when they are packed again.
    let again = frame::pack(&told.snapshot, 7);
    let found: Vec<_> = again.iter().filter_map(|byte| decoder.push(*byte)).collect();
    assert_eq!(found, [Ok(told)]);
});
