use proptest::prelude::*;
use proptest::sample::Index;

use super::*;
use crate::autopilot::Mode;
use crate::controls::Channels;
use crate::frames::Vector;
use crate::telemetry::{ControlFlags, Drops, LoopTiming, Severity};
use approx::assert_abs_diff_eq;

/// A snapshot in which every number is a whole number of steps and unique.
fn full() -> Snapshot {
    Snapshot {
        time: Time::from_nanoseconds(1_234_567_891_000),
        mode: SystemMode::Autopilot,
        status: StatusFlags::from_bits(0b101_0111_1111),
        angular_rate_radps: Some(Vector::new(0.1, -0.2, 0.3005)),
        specific_force_mps2: Some(Vector::new(0.5, -0.25, -9.805)),
        magnetic_field_gauss: Some(Vector::new(0.2012, -0.0311, 0.4523)),
        temperature_degc: Some(31.5),
        attitude: Some(EulerAngles { roll_rad: 0.0312, pitch_rad: -0.0127, yaw_rad: -2.9671 }),
        position: Geodetic::from_degrees(1.345_678_9, 103.680_123_4, 38.125),
        velocity_mps: Some(Vector::new(1.25, -0.5, 0.03)),
        sigmas: Sigmas {
            horizontal_m: Some(0.85),
            vertical_m: Some(1.27),
            horizontal_velocity_mps: Some(0.071),
            vertical_velocity_mps: Some(0.093),
            tilt_rad: Some(0.0042),
            heading_rad: Some(0.0131),
        },
        commanded_ms: Channels::from([1.2, 1.45, 1.5005, 1.5995, 1.71]).map(Some),
        pilot_ms: Channels::from([1.21, 1.46, 1.51, 1.61, 1.72]).map(Some),
        gps: GpsSummary {
            fix: FixKind::Differential,
            satellites: Some(9),
            age_s: Some(0.4),
            latitude_longitude_deg: Some([1.345_679, 103.680_123]),
            height_m: Some(39.5),
            altitude_msl_m: Some(31.25),
            horizontal_velocity_mps: Some([1.2, -0.45]),
            down_velocity_mps: Some(0.1),
            hdop: Some(1.1),
            vdop: Some(1.8),
            ..GpsSummary::default()
        },
        innovations: Innovations {
            position: Some(1.25),
            velocity: Some(0.75),
            attitude: Some(0.5),
            heading: Some(2.0),
            baro: Some(3.05),
            rejected: 12,
        },
        timing: LoopTiming {
            period_s: Some(0.0303),
            work_s: Some(0.0012),
            longest_work_s: Some(0.00431),
            overruns: 3,
        },
        drops: Drops { imu_packets: 4, gps_messages: 5, pilot_pulses: 6, telemetry_frames: 7 },
    }
}

fn decode(stream: &[u8]) -> Vec<Result<Frame, FrameError>> {
    let mut decoder = Decoder::default();
    let frames: Vec<_> = stream.iter().filter_map(|byte| decoder.push(*byte)).collect();
    let good = frames.iter().filter(|frame| frame.is_ok()).count() as u64;
    assert_eq!(decoder.counts().frames, good);
    assert_eq!(decoder.counts().damaged, frames.len() as u64 - good);
    frames
}

fn sent(sequence: u8, snapshot: Snapshot) -> Result<Frame, FrameError> {
    Ok(Frame { sequence, snapshot })
}

#[test]
fn every_field_comes_back_as_it_was_sent() {
    assert_eq!(decode(&pack(&full(), 200)), [sent(200, full())]);
    let nothing = Snapshot::at(Time::from_nanoseconds(-5_000));
    assert_eq!(decode(&pack(&nothing, 0)), [sent(0, nothing)]);
}

#[test]
fn the_layout_does_not_change_without_its_version() {
    let hex: String = pack(&full(), 200).iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(hex, include_str!("golden.hex").replace('\n', ""));
}

#[test]
fn a_33_hz_loop_leaves_the_modem_15_percent_to_spare() {
    // One start bit, eight data bits, one stop bit; every frame has this length.
    let bits_per_s = LENGTH as f64 * 10.0 * 33.0;
    assert!(bits_per_s <= 0.85 * 57_600.0, "{bits_per_s} of 57 600 bit/s");
}

#[test]
fn no_frame_is_longer_than_another_whatever_the_values() {
    for byte in 0..=u8::MAX {
        let plain = [byte; BODY + CHECKSUM];
        assert_eq!(cobs::encode_vec(&plain).len(), STUFFED);
    }
}

#[test]
fn what_a_field_cannot_hold_becomes_the_nearest_it_can_and_nan_becomes_unknown() {
    let extreme = Snapshot {
        angular_rate_radps: Some(Vector::new(1e9, -1e9, f64::INFINITY)),
        temperature_degc: Some(f64::NAN),
        velocity_mps: Some(Vector::new(0.0, f64::NAN, 0.0)),
        commanded_ms: Channels::from_fn(|_| Some(-1.0)),
        drops: Drops { imu_packets: 70_000, ..Drops::default() },
        ..Snapshot::at(Time::from_nanoseconds(i64::MAX))
    };
    let frames = decode(&pack(&extreme, 0));
    let told = frames[0].unwrap().snapshot;
    assert_eq!(told.angular_rate_radps, Some(Vector::new(16.3835, -16.3835, 16.3835)));
    assert_eq!((told.temperature_degc, told.velocity_mps), (None, None));
    assert_eq!(told.commanded_ms.pedal, Some(0.0));
    assert_eq!(told.drops.imu_packets, 65_535);
    assert_abs_diff_eq!(extreme.time - told.time, 0.0, epsilon = 1e-6);
}

#[test]
fn what_is_no_place_on_earth_is_reported_as_unknown_and_not_as_the_nearest() {
    let pole = f64::to_radians(90.0);
    for (latitude_rad, longitude_rad, height_m) in
        [(pole + 0.01, 0.0, 0.0), (0.0, 1e300, 0.0), (f64::NAN, 0.0, 0.0), (0.0, 0.0, 1e6)]
    {
        let position = Some(Geodetic { latitude_rad, longitude_rad, height_m });
        let mut nowhere = Snapshot { position, ..full() };
        nowhere.gps.latitude_longitude_deg = Some([0.0, 200.0]);
        let told = decode(&pack(&nowhere, 0))[0].unwrap().snapshot;
        assert_eq!((told.position, told.gps.latitude_longitude_deg), (None, None));
    }
    let date_line = Geodetic { latitude_rad: -pole, longitude_rad: -2.0 * pole, height_m: 0.0 };
    let there = Snapshot { position: Some(date_line), ..full() };
    let told = decode(&pack(&there, 0))[0].unwrap().snapshot.position.unwrap();
    assert_eq!((told.latitude_deg(), told.longitude_deg()), (-90.0, 180.0));
}

#[test]
fn frames_of_another_version_or_with_unknown_codes_say_so() {
    let repacked = |place: usize, value: u8| {
        let mut bytes = pack(&full(), 0);
        let length = cobs::decode_in_place(&mut bytes).unwrap();
        let mut plain = bytes[..length].to_vec();
        plain[place] = value;
        let checksum = CRC.checksum(&plain[..BODY]).to_le_bytes();
        plain[BODY..].copy_from_slice(&checksum);
        let mut stuffed = cobs::encode_vec(&plain);
        stuffed.push(0);
        decode(&stuffed)
    };
    assert_eq!(repacked(0, 2), [Err(FrameError::Version { found: 2 })]);
    assert_eq!(repacked(2, 99), [Err(FrameError::Code { found: 99 })]);
    assert_eq!(repacked(3, 77), [Err(FrameError::Code { found: 77 })]);
}

#[test]
fn frames_that_did_not_come_are_counted_and_a_stretch_without_end_costs_one() {
    let mut decoder = Decoder::default();
    let mut stream = Vec::new();
    for sequence in [254, 255, 2] {
        stream.extend(pack(&full(), sequence));
    }
    stream.extend([7; 5_000]);
    stream.push(0);
    stream.extend(pack(&full(), 3));
    let errors: Vec<_> =
        stream.iter().filter_map(|byte| decoder.push(*byte)).filter_map(Result::err).collect();
    assert_eq!(errors, [FrameError::Length { found: 5_000 }]);
    let counts = FrameCounts { bytes: stream.len() as u64, frames: 4, damaged: 1, missing: 2 };
    assert_eq!(*decoder.counts(), counts);
}

/// Whether the two values differ by at most half a step, plus rounding.
fn near(a: Option<f64>, b: Option<f64>, step: f64) -> bool {
    a.zip(b).is_some_and(|(a, b)| (a - b).abs() <= 0.5 * step + 1e-9)
}

proptest! {
    #[test]
    fn values_survive_to_half_a_step_of_the_documented_table(
        rate in -16.0f64..16.0,
        force in -160.0f64..160.0,
        field in -3.2f64..3.2,
        temperature in -60.0f64..100.0,
        yaw in -3.1f64..3.1,
        latitude in -90.0f64..90.0,
        longitude in -179.999f64..180.0,
        height in -500.0f64..20_000.0,
        speed in -300.0f64..300.0,
        sigma in 0.0f64..6.0,
        width in 0.0f64..3.0,
        period in 0.0f64..0.6,
        microseconds in any::<i32>(),
    ) {
        let mut snapshot = full();
        snapshot.time = Time::from_nanoseconds(i64::from(microseconds) * 1_000 + 999);
        snapshot.angular_rate_radps = Some(Vector::new(rate, -rate, 0.0));
        snapshot.specific_force_mps2 = Some(Vector::new(0.0, force, -force));
        snapshot.magnetic_field_gauss = Some(Vector::new(field, 0.0, field));
        snapshot.temperature_degc = Some(temperature);
        snapshot.attitude = Some(EulerAngles { roll_rad: 0.0, pitch_rad: 0.0, yaw_rad: yaw });
        snapshot.position = Geodetic::from_degrees(latitude, longitude, height);
        snapshot.velocity_mps = Some(Vector::new(speed, speed, speed));
        snapshot.sigmas.horizontal_m = Some(sigma);
        snapshot.sigmas.vertical_velocity_mps = Some(sigma);
        snapshot.sigmas.tilt_rad = Some(sigma);
        snapshot.commanded_ms.lateral = Some(width);
        snapshot.gps.hdop = Some(sigma);
        snapshot.innovations.baro = Some(sigma);
        snapshot.timing.period_s = Some(period);
        let told = decode(&pack(&snapshot, 1))[0].unwrap().snapshot;

        let late_s = snapshot.time - told.time;
        prop_assert!((0.0..1e-6).contains(&late_s));
        prop_assert!(near(told.angular_rate_radps.map(Vector::x), Some(rate), 5e-4));
        prop_assert!(near(told.specific_force_mps2.map(Vector::y), Some(force), 5e-3));
        prop_assert!(near(told.magnetic_field_gauss.map(Vector::z), Some(field), 1e-4));
        prop_assert!(near(told.temperature_degc, Some(temperature), 0.01));
        prop_assert!(near(told.attitude.map(|angles| angles.yaw_rad), Some(yaw), 1e-4));
        prop_assert!(near(told.position.map(|p| p.latitude_deg()), Some(latitude), 1e-7));
        prop_assert!(near(told.position.map(|p| p.longitude_deg()), Some(longitude), 1e-7));
        prop_assert!(near(told.position.map(|p| p.height_m), Some(height), 1e-3));
        prop_assert!(near(told.velocity_mps.map(Vector::z), Some(speed), 0.01));
        prop_assert!(near(told.sigmas.horizontal_m, Some(sigma), 0.01));
        prop_assert!(near(told.sigmas.vertical_velocity_mps, Some(sigma), 1e-3));
        prop_assert!(near(told.sigmas.tilt_rad, Some(sigma), 1e-4));
        prop_assert!(near(told.commanded_ms.lateral, Some(width), 5e-4));
        prop_assert!(near(told.gps.hdop, Some(sigma), 0.1));
        prop_assert!(near(told.innovations.baro, Some(sigma), 0.05));
        prop_assert!(near(told.timing.period_s, Some(period), 1e-5));
    }

    #[test]
    fn a_byte_lost_gained_or_changed_costs_its_frame_and_makes_none(
        kind in 0..3,
        value in 1..=u8::MAX,
        place in any::<Index>(),
    ) {
        let mut stream: Vec<u8> = (0..4).flat_map(|number| pack(&full(), number)).collect();
        let place = LENGTH + place.index(LENGTH);
        match kind {
            0 => stream[place] ^= value,
            1 => stream.insert(place, value),
            _ => drop(stream.remove(place)),
        }
        let good: Vec<_> = decode(&stream).into_iter().flatten().collect();
        prop_assert!(good.iter().all(|frame| frame.snapshot == full()));
        let numbers: Vec<_> = good.iter().map(|frame| frame.sequence).collect();
        // The zero between two frames belongs to both frames: without it both are lost.
        let rest: &[u8] = if place == 2 * LENGTH - 1 && kind != 1 { &[0, 3] } else { &[0, 2, 3] };
        prop_assert_eq!(&numbers[..], rest);
    }

    #[test]
    fn any_bytes_make_no_frame_and_hide_none_behind_a_zero(
        noise in prop::collection::vec(any::<u8>(), 0..400),
    ) {
        let stream = [&noise[..], &[0], &pack(&full(), 5)].concat();
        let good: Vec<_> = decode(&stream).into_iter().flatten().collect();
        prop_assert_eq!(good, vec![Frame { sequence: 5, snapshot: full() }]);
    }
}

fn full_supplement() -> Supplement {
    Supplement {
        time: Time::from_nanoseconds(987_654_000),
        mode: Some(Mode::Velocity),
        flags: ControlFlags::from_bits(0b101_0110),
        failed_checks: 0b10_0000_0000_0101,
        aux_ms: Some(1.8505),
        asked_velocity_mps: Some(Vector::new(0.25, -1.5, 0.1)),
        asked_heading_rad: Some(-2.1003),
        gyro_bias_radps: Some(Vector::new(0.00123, -0.00456, 0.1)),
        accel_bias_mps2: Some(Vector::new(0.123, -0.456, 1.5)),
        gyro_bias_sigma_radps: Some(Vector::new(0.0001, 0.0002, 0.0003)),
        accel_bias_sigma_mps2: Some(Vector::new(0.01, 0.02, 0.03)),
        geofence_share: Some(0.731),
    }
}

#[test]
fn snapshots_supplements_and_texts_come_back_from_one_stream_and_are_numbered_together() {
    let line = "one-sigma of horizontal velocity, m/s: 0.812, at most 0.4; sät at the änd of 64";
    let (text, rest) = Text::first_of(Time::from_nanoseconds(5_000), Severity::Warning, line);
    let nothing = Supplement::at(Time::ZERO);
    let stream = [
        &pack(&full(), 254)[..],
        &pack_supplement(&full_supplement(), 255),
        &pack_text(&text, 0),
        &pack_supplement(&nothing, 1),
    ]
    .concat();
    let mut decoder = Decoder::default();
    let messages: Vec<_> = stream.iter().filter_map(|byte| decoder.push_message(*byte)).collect();
    let expected = [
        Message::Snapshot(Frame { sequence: 254, snapshot: full() }),
        Message::Supplement(full_supplement()),
        Message::Text(text),
        Message::Supplement(nothing),
    ];
    assert_eq!(messages, expected.map(Ok));
    assert_eq!(format!("{}{rest}", text.as_str()), line);
    assert_eq!(*decoder.counts(), FrameCounts { bytes: 339, frames: 4, damaged: 0, missing: 0 });
    // A reader of snapshots alone does not receive frames with other content.
    assert_eq!(decode_snapshots(&stream), [full()]);
}

fn decode_snapshots(stream: &[u8]) -> Vec<Snapshot> {
    let mut decoder = Decoder::default();
    stream
        .iter()
        .filter_map(|byte| decoder.push(*byte))
        .map(|frame| frame.unwrap().snapshot)
        .collect()
}

proptest! {
    #[test]
    fn a_damaged_supplement_or_text_is_none(value in 1..=u8::MAX, place in any::<Index>()) {
        let (text, _) = Text::first_of(Time::ZERO, Severity::Error, "the record is not written");
        for mut bytes in
            [pack_supplement(&full_supplement(), 1).to_vec(), pack_text(&text, 1).to_vec()]
        {
            let place = place.index(bytes.len() - 1);
            bytes[place] ^= value;
            let mut decoder = Decoder::default();
            let found = bytes.iter().filter_map(|byte| decoder.push_message(*byte));
            prop_assert!(found.filter_map(Result::ok).count() == 0);
        }
    }
}
