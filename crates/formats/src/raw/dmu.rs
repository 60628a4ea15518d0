//! Reads the packets of a DMU and times them with the DMU's own timer.

use super::pieces::for_each_piece;
use crate::assembly::Assembly;
use crate::window::Input;
use hovernav::dmu::{Calibration, Decoder, Mode, Packet, Plausibility, Received, SampleClock};
use hovernav::time::Time;
use hovernav_dataset::{LogError, Manifest};

/// Period of the DMU's timer, s. Source: Crossbow, *AHRS Series User's Manual*, 7430-0004-01, page 16.
const TICK_S: f64 = 0.79e-6;
/// Packet interval if the timer does not run, s: that of the rate which the flight computer requests.
const USUAL_INTERVAL_S: f64 = 1.0 / 33.0;
/// Ranges of the two types of DMU: acceleration, g, and rate, °/s.
const RANGES: [(f64, f64); 2] = [(4.0, 200.0), (2.0, 100.0)];

pub(super) fn read(input: Input<'_>, mode: Mode) -> Result<(Assembly, Manifest), LogError> {
    let mut decoder = Decoder::new(mode);
    let mut plausibility = Plausibility::default();
    let mut packets: Vec<Received> = Vec::new();
    let mut impossible = 0usize;
    for_each_piece(input, |mut bytes, _| {
        while let Some(received) = decoder.next_packet(&mut bytes) {
            if plausibility.check(&received.packet).any(|reason| reason.invalidates_packet()) {
                impossible += 1;
            } else {
                packets.push(received);
            }
        }
    })?;
    let mut assembly = Assembly::new(true);
    let counts = *decoder.counts();
    assembly.note(format!(
        "raw bytes of a DMU in {} mode: {} packets; {} of {} bytes are in no packet",
        if mode == Mode::Angle { "angle" } else { "scaled" },
        counts.packets,
        counts.bytes_lost(),
        counts.bytes_lost() + counts.packets * mode.packet_length() as u64,
    ));
    if impossible > 0 {
        assembly.say(format!("{impossible} packets rejected: their values are impossible"));
    }
    let interval_s = interval_s(&packets).unwrap_or_else(|| {
        assembly.say("the timer of the DMU does not run: 33 packets per second are assumed");
        USUAL_INTERVAL_S
    });
    let (range_g, range_degps) = ranges(&packets);
    assembly.note(format!(
        "ranges of {range_degps} deg/s and {range_g} g, derived from the size of gravity: the \
         packets do not state them"
    ));
    assembly.note("yaw is from magnetic north: [imu] heading_reference = \"magnetic\"");
    let calibration = Calibration::new(range_degps, range_g).map_err(|error| {
        LogError::Unusable { path: input.path.to_path_buf(), reason: error.to_string() }
    })?;
    let mut clock = SampleClock::new(0.0);
    let length = mode.packet_length() as f64;
    let first = packets.first().map_or(0, |received| received.offset);
    for received in &packets {
        // A capture has no arrival times. They follow from the byte offsets, because packets are consecutive.
        let arrival_s = (received.offset - first) as f64 / length * interval_s;
        let arrival = Time::try_from_seconds(arrival_s).unwrap_or_default();
        let place = received.offset;
        match clock.stamp(received.packet.timer(), received.sequence, arrival) {
            Ok(stamp) => {
                if let Some(measurement) = calibration.measure(&received.packet) {
                    assembly.imu(place, measurement.at(stamp.time));
                }
            }
            Err(_) => assembly.skip_imu(place, "skipped: its timer did not advance"),
        }
    }
    let mut manifest = Manifest::default();
    manifest.imu.heading_reference = hovernav_dataset::HeadingReference::Magnetic;
    manifest.imu.gyro_range_degps = Some(range_degps);
    manifest.imu.accel_range_g = Some(range_g);
    Ok((assembly, manifest))
}

/// The median interval of consecutive packets, s; `None` if the timer does not run.
fn interval_s(packets: &[Received]) -> Option<f64> {
    let mut ticks: Vec<u16> = packets
        .windows(2)
        .filter(|pair| pair[1].sequence == pair[0].sequence + 1)
        // The timer counts down.
        .map(|pair| pair[0].packet.timer().wrapping_sub(pair[1].packet.timer()))
        .collect();
    ticks.sort_unstable();
    let median = *ticks.get(ticks.len() / 2)?;
    (median > 1_000).then(|| f64::from(median) * TICK_S)
}

/// The ranges with which the median specific force is nearest to gravity.
fn ranges(packets: &[Received]) -> (f64, f64) {
    let norm = |packet: &Packet| {
        let acceleration = match packet {
            Packet::Angle(packet) => packet.acceleration,
            Packet::Scaled(packet) => packet.acceleration,
            Packet::Voltage(_) => return None,
        };
        Some(acceleration.map(|count| f64::from(count).powi(2)).iter().sum::<f64>().sqrt())
    };
    let mut norms: Vec<f64> =
        packets.iter().filter_map(|received| norm(&received.packet)).collect();
    norms.sort_unstable_by(f64::total_cmp);
    let median = norms.get(norms.len() / 2).copied().unwrap_or_default();
    let off = |range_g: f64| (median * range_g * 1.5 / 32_768.0 - 1.0).abs();
    RANGES.into_iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0))).unwrap_or(RANGES[0])
}
