//! The synthetic captures: reference packets with their values, a clean and a damaged stream.

use hovernav::dmu::{AnglePacket, Calibration, Decoder, Mode, Packet};
use hovernav_testing::shared;
use serde_json::Value;

use crate::generator::decode;

fn read(name: &str) -> Option<Vec<u8>> {
    shared(format!("captures/dmu_synthetic/{name}")).map(|path| std::fs::read(path).unwrap())
}

fn json(name: &str) -> Option<Value> {
    read(name).map(|bytes| serde_json::from_slice(&bytes).unwrap())
}

fn packets(stream: &[u8]) -> Vec<Packet> {
    stream.chunks(30).map(|chunk| Packet::decode(Mode::Angle, chunk).unwrap()).collect()
}

/// The counts of the values in a file, in deg, deg/s, g, gauss and °C.
fn counts(value: &Value) -> AnglePacket {
    let number = |key: &str| value[key].as_f64().unwrap();
    let rate_range = value["RR"].as_f64().unwrap_or(200.0);
    let acceleration_range = value["GR"].as_f64().unwrap_or(4.0);
    let words = |keys: [&str; 3], full_scale: f64| {
        keys.map(|key| {
            let count = number(key) * 32_768.0 / full_scale;
            assert!((count - count.round()).abs() < 1e-9, "{key} of {value}");
            count.round() as i16
        })
    };
    AnglePacket {
        attitude: words(["roll", "pitch", "yaw"], 180.0),
        angular_rate: words(["p", "q", "r"], 1.5 * rate_range),
        acceleration: words(["ax", "ay", "az"], 1.5 * acceleration_range),
        magnetic_field: words(["mx", "my", "mz"], 1.5 * 1.25),
        temperature: ((number("temp") / 44.44 + 1.375) * 4096.0 / 5.0).round() as u16,
        timer: number("timer") as u16,
    }
}

fn assert_measures(packet: &AnglePacket, value: &Value) {
    let number = |key: &str| value[key].as_f64().unwrap();
    let rate_range = value["RR"].as_f64().unwrap_or(200.0);
    let acceleration_range = value["GR"].as_f64().unwrap_or(4.0);
    let measurement = Calibration::new(rate_range, acceleration_range)
        .unwrap()
        .measure(&Packet::Angle(*packet))
        .unwrap();
    let close = |found: f64, expected: f64, key: &str| {
        let tolerance = 4.0 * f64::EPSILON * expected.abs().max(1e-3);
        assert!((found - expected).abs() <= tolerance, "{key}: {found} for {expected} of {value}");
    };
    let attitude = measurement.attitude.unwrap().to_degrees();
    for (found, key) in attitude.into_iter().zip(["roll", "pitch", "yaw"]) {
        // −180° is +180° in the half-open circle.
        let expected = if number(key) == -180.0 { 180.0 } else { number(key) };
        close(found, expected, key);
    }
    for (found, key) in measurement.angular_rate_radps.to_array().into_iter().zip(["p", "q", "r"]) {
        close(found.to_degrees(), number(key), key);
    }
    let specific_force = measurement.specific_force_mps2.to_array();
    for (found, key) in specific_force.into_iter().zip(["ax", "ay", "az"]) {
        close(-found / 9.806_65, number(key), key);
    }
    let magnetic_field = measurement.magnetic_field_gauss.to_array();
    for (found, key) in magnetic_field.into_iter().zip(["mx", "my", "mz"]) {
        close(found, number(key), key);
    }
    close(measurement.temperature_degc, number("temp"), "temp");
}

#[test]
fn golden_packets_decode_to_the_last_count() {
    let Some(golden) = json("golden_angle.json") else { return };
    let golden = golden.as_array().unwrap();
    assert_eq!(golden.len(), 9);
    for value in golden {
        let hex = value["hex"].as_str().unwrap();
        let bytes: Vec<u8> = (0..hex.len())
            .step_by(2)
            .map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap())
            .collect();
        let packet = AnglePacket::decode(&bytes).unwrap();
        assert_eq!(packet, counts(value));
        assert_eq!(packet.encode().as_slice(), bytes);
        assert_measures(&packet, value);
    }
}

#[test]
fn the_clean_stream_decodes_whole() {
    let (Some(stream), Some(values)) = (read("clean_330.bin"), json("clean_330.json")) else {
        return;
    };
    let mut decoder = Decoder::new(Mode::Angle);
    let decoded = decode(&mut decoder, &stream);
    let values = values.as_array().unwrap();
    assert_eq!(decoded.len(), values.len());
    for (packet, value) in decoded.iter().zip(values) {
        let Packet::Angle(packet) = packet else { panic!("{packet:?}") };
        assert_eq!(*packet, counts(value));
        assert_measures(packet, value);
    }
    assert_eq!(decoder.counts().bytes_lost(), 0);
    assert_eq!(decoder.counts().packets_held_back, 0);
}

#[test]
fn the_damaged_stream_gives_no_false_packet_and_misses_three() {
    let (Some(clean), Some(damaged), Some(answer)) =
        (read("clean_330.bin"), read("damaged.bin"), json("damaged.json"))
    else {
        return;
    };
    let truth = packets(&clean);
    let intact: Vec<Packet> = answer["intact"]
        .as_array()
        .unwrap()
        .iter()
        .map(|index| truth[index.as_u64().unwrap() as usize])
        .collect();
    let decoded = decode(&mut Decoder::new(Mode::Angle), &damaged);
    assert!(decoded.iter().all(|packet| intact.contains(packet)), "a false packet");
    assert_eq!((intact.len(), decoded.len()), (309, 306));
}
