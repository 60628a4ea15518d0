//! Counts in physical units, and impossible packets.

use approx::assert_abs_diff_eq;
use hovernav::dmu::{
    AnglePacket, Calibration, Measurement, Packet, Plausibility, PlausibilityFault, ScaledPacket,
    Sensor, Sign, VoltagePacket, temperature_degc, volts,
};
use hovernav::frames::Vector;
use hovernav::imu::Motion;
use hovernav::time::Time;
use proptest::prelude::*;

use crate::generator::flight;

fn reasons(packet: AnglePacket) -> Vec<PlausibilityFault> {
    Plausibility::default().check(&Packet::Angle(packet)).collect()
}

#[test]
fn level_and_still_the_specific_force_is_one_g_upwards() {
    let level = AnglePacket { acceleration: [0, 0, 0x1555], ..Default::default() };
    let calibration = Calibration::new(200.0, 4.0).unwrap();
    let sample = calibration.measure(&Packet::Angle(level)).unwrap().at(Time::ZERO);
    let Motion::Rates { specific_force_mps2, .. } = sample.motion else { panic!("{sample:?}") };
    assert_abs_diff_eq!(specific_force_mps2.z(), -0.999_938_964_843_75 * 9.806_65, epsilon = 1e-12);
}

#[test]
fn signs_are_set_axis_by_axis() {
    let packet = Packet::Scaled(ScaledPacket { acceleration: [100; 3], ..Default::default() });
    let calibration = Calibration::new(100.0, 2.0).unwrap().with_acceleration_signs([
        Sign::Positive,
        Sign::Negative,
        Sign::Positive,
    ]);
    let force = calibration.measure(&packet).unwrap().specific_force_mps2;
    assert!(force.x() > 0.0 && force.y() < 0.0 && force.z() > 0.0);
    assert_eq!((force.x(), force.y()), (force.z(), -force.x()));
}

#[test]
fn a_range_that_no_unit_has_is_refused() {
    for range in [0.0, -100.0, f64::NAN, f64::INFINITY] {
        assert!(Calibration::new(range, 4.0).unwrap_err().to_string().contains("rate range"));
        assert!(Calibration::new(200.0, range).unwrap_err().to_string().contains("acceleration"));
    }
}

#[test]
fn voltage_mode_gives_volts_and_no_measurement() {
    let calibration = Calibration::new(200.0, 4.0).unwrap();
    assert_eq!(calibration.measure(&Packet::Voltage(VoltagePacket::default())), None);
    assert_eq!(volts(2048), 2.5);
    assert_abs_diff_eq!(temperature_degc(1587), 24.986_650_390_625, epsilon = 1e-12);
}

#[test]
fn a_flight_is_plausible_throughout() {
    let mut plausibility = Plausibility::default();
    for packet in flight(2000, 1) {
        assert_eq!(plausibility.check(&Packet::Angle(packet)).next(), None);
    }
}

#[test]
fn each_implausible_thing_is_named() {
    let (gyros, accelerometers) = (Sensor::Gyros, Sensor::Accelerometers);
    let still = AnglePacket::default();
    for (packet, expected) in [
        (
            AnglePacket { temperature: 0x1000, ..still },
            PlausibilityFault::TemperatureWord { counts: 0x1000 },
        ),
        (
            AnglePacket { attitude: [0, -0x4001, 0], ..still },
            PlausibilityFault::Pitch { counts: -0x4001 },
        ),
        (
            AnglePacket { angular_rate: [0, i16::MIN, 0], ..still },
            PlausibilityFault::Saturated { sensor: gyros, axis: 1 },
        ),
        (
            AnglePacket { magnetic_field: [0, 0, i16::MAX], ..still },
            PlausibilityFault::Saturated { sensor: Sensor::Magnetometers, axis: 2 },
        ),
        (
            AnglePacket { acceleration: [-21_846, 0, 0], ..still },
            PlausibilityFault::BeyondRating { sensor: accelerometers, axis: 0, counts: -21_846 },
        ),
    ] {
        assert_eq!(reasons(packet), [expected]);
        assert!(!expected.to_string().is_empty());
    }
    let at_the_limits = AnglePacket {
        attitude: [i16::MIN, 0x4000, i16::MIN],
        angular_rate: [21_845, -21_845, 0],
        magnetic_field: [30_000; 3],
        temperature: 0x0FFF,
        ..still
    };
    assert_eq!(reasons(at_the_limits), []);
}

/// Damage with a valid checksum: one packet with random words costs only this packet, and a real change of motion also
/// costs one packet.
#[test]
fn a_single_jump_is_rejected_and_a_lasting_one_is_motion() {
    let jumps = |words: &[i16]| -> Vec<bool> {
        let mut plausibility = Plausibility::default();
        words
            .iter()
            .map(|word| {
                let packet = AnglePacket { angular_rate: [0, *word, 0], ..Default::default() };
                plausibility
                    .check(&Packet::Angle(packet))
                    .any(|fault| matches!(fault, PlausibilityFault::Jump { sensor, axis: 1, .. } if sensor == Sensor::Gyros))
            })
            .collect()
    };
    assert_eq!(jumps(&[100, -50, i16::MAX, 80, 20]), [false, false, true, false, false]);
    assert_eq!(jumps(&[100, -50, i16::MIN, 80, 20]), [false, false, true, false, false]);
    // Damaged packets shortly after each other.
    let damaged = [0, i16::MAX, 30, i16::MIN, 20, -10, i16::MAX, 0];
    assert_eq!(jumps(&damaged), [false, true, false, true, false, false, true, false]);
    assert_eq!(jumps(&[0, i16::MAX, i16::MIN, 20]), [false, true, true, false]);
    // A fast manoeuvre: its first packet is lost, the others are used, also at full scale.
    let fast = [0, 15_000, 16_000, 17_000, 26_000, i16::MAX];
    assert_eq!(jumps(&fast), [false, true, false, false, false, false]);
    // Motion of 15 Hz at full scale: one packet a second is lost.
    let violent: Vec<i16> =
        (0..330).map(|k| if k % 2 == 0 { i16::MAX } else { i16::MIN }).collect();
    assert!((10..=13).contains(&jumps(&violent).iter().filter(|jump| **jump).count()));
    // A manoeuvre that grows over several packets: all its packets are used.
    assert!(jumps(&[0, 9_000, 18_000, 24_000, 18_000, 9_000, 0]).iter().all(|jump| !jump));
    // Vibration makes accelerations jump. Within the rated range, the packets stay valid.
    let shaken = |acceleration| AnglePacket { acceleration, ..Default::default() };
    let mut plausibility = Plausibility::default();
    for k in 0..200 {
        let packet = shaken([0, 0, if k % 2 == 0 { 20_000 } else { -20_000 }]);
        let found: Vec<_> = plausibility.check(&Packet::Angle(packet)).collect();
        assert!(found.iter().all(|fault| !fault.invalidates_packet()), "{found:?}");
    }
    let wild = Packet::Angle(shaken([i16::MAX, 0, 0]));
    assert!(plausibility.check(&wild).any(|fault| fault.invalidates_packet()));
}

#[test]
fn words_of_voltage_mode_fit_their_converter() {
    let middle = VoltagePacket {
        angular_rate: [2048; 3],
        acceleration: [2048; 3],
        magnetic_field: [2048; 3],
        ..Default::default()
    };
    let reasons = |packet| Plausibility::default().check(&Packet::Voltage(packet)).collect();
    let reasons: &dyn Fn(VoltagePacket) -> Vec<PlausibilityFault> = &reasons;
    assert_eq!(reasons(middle), []);
    let (sensor, axis) = (Sensor::Accelerometers, 1);
    assert_eq!(
        reasons(VoltagePacket { acceleration: [2048, 0x8000, 2048], ..middle }),
        [PlausibilityFault::VoltageWord { sensor, axis, counts: 0x8000 }]
    );
    assert_eq!(
        reasons(VoltagePacket { acceleration: [2048, 0x0FFF, 2048], ..middle }),
        [PlausibilityFault::Saturated { sensor, axis }]
    );
}

#[test]
fn a_sensor_that_freezes_is_found_and_let_go_when_it_moves() {
    let mut plausibility = Plausibility::default();
    let mut packets = flight(60, 2);
    let frozen = packets[20].angular_rate;
    packets[20..50].iter_mut().for_each(|packet| packet.angular_rate = frozen);
    let found: Vec<bool> = packets
        .iter()
        .map(|packet| {
            let reasons: Vec<PlausibilityFault> =
                plausibility.check(&Packet::Angle(*packet)).collect();
            assert!(reasons.iter().all(|reason| !reason.invalidates_packet()
                && matches!(reason, PlausibilityFault::Stuck { sensor: Sensor::Gyros, .. })));
            !reasons.is_empty()
        })
        .collect();
    let expected: Vec<bool> = (0..60).map(|index| (35..50).contains(&index)).collect();
    assert_eq!(found, expected);
}

proptest! {
    #[test]
    fn a_measurement_survives_the_wire_within_half_a_count(
        rate_radps in prop::array::uniform3(-5.2..5.2f64),
        force_mps2 in prop::array::uniform3(-58.0..58.0f64),
        field_gauss in prop::array::uniform3(-1.87..1.87f64),
        attitude_rad in prop::array::uniform3(-3.1..3.1f64),
        range in prop::sample::select(vec![(200.0, 4.0), (300.0, 10.0)]),
    ) {
        let (rate_range_degps, acceleration_range_g) = range;
        let rate_lsb = f64::to_radians(rate_range_degps) * 1.5 / 32_768.0;
        let force_lsb = acceleration_range_g * 1.5 * 9.806_65 / 32_768.0;
        let (field_lsb, angle_lsb) = (1.875 / 32_768.0, std::f64::consts::PI / 32_768.0);
        let count = |lsb: f64| move |value: f64| (value / lsb).round() as i16;
        let packet = AnglePacket {
            attitude: attitude_rad.map(count(angle_lsb)),
            angular_rate: rate_radps.map(count(rate_lsb)),
            acceleration: force_mps2.map(count(-force_lsb)),
            magnetic_field: field_gauss.map(count(field_lsb)),
            ..Default::default()
        };
        let measured = Calibration::new(rate_range_degps, acceleration_range_g)
            .unwrap()
            .measure(&Packet::Angle(AnglePacket::decode(&packet.encode()).unwrap()))
            .unwrap();
        let attitude = measured.attitude.unwrap();
        let attitude = [attitude.roll_rad, attitude.pitch_rad, attitude.yaw_rad];
        for (found, sent, lsb) in [
            (measured.angular_rate_radps.to_array(), rate_radps, rate_lsb),
            (measured.specific_force_mps2.to_array(), force_mps2, force_lsb),
            (measured.magnetic_field_gauss.to_array(), field_gauss, field_lsb),
            (attitude, attitude_rad, angle_lsb),
        ] {
            for (found, sent) in found.into_iter().zip(sent) {
                prop_assert!((found - sent).abs() <= 0.500_001 * lsb, "{} for {}", found, sent);
            }
        }
    }
}

#[test]
fn what_cannot_be_sent_stands_at_the_end_of_its_scale_or_at_zero() {
    let calibration = Calibration::new(200.0, 4.0).unwrap();
    let still = calibration.measure(&Packet::Angle(AnglePacket::default())).unwrap();
    let packet = calibration.counts(&Measurement {
        angular_rate_radps: Vector::new(1e9, -1e9, f64::NAN),
        specific_force_mps2: Vector::new(1e9, -1e9, f64::INFINITY),
        attitude: None,
        temperature_degc: 1e9,
        ..still
    });
    assert_eq!(packet.angular_rate, [i16::MAX, i16::MIN, 0]);
    assert_eq!(packet.acceleration, [i16::MIN, i16::MAX, i16::MIN]);
    assert_eq!((packet.attitude, packet.temperature), ([0; 3], 0x0FFF));
}

proptest! {
    #[test]
    fn counts_of_a_measurement_are_those_that_were_measured(
        words: [[i16; 3]; 4],
        temperature in 0u16..=0x0FFF,
        rate_range in 1.0f64..1e3,
        acceleration_range in 0.1f64..1e2,
    ) {
        let [attitude, angular_rate, acceleration, magnetic_field] = words;
        let packet =
            AnglePacket { attitude, angular_rate, acceleration, magnetic_field, temperature, timer: 0 };
        let calibration = Calibration::new(rate_range, acceleration_range).unwrap();
        let measurement = calibration.measure(&Packet::Angle(packet)).unwrap();
        prop_assert_eq!(calibration.counts(&measurement), packet);
    }
}
