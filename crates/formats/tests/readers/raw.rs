//! Captures of serial lines, opened like any log.

use std::fs;

use approx::assert_abs_diff_eq;
use hovernav_formats::{Format, Options, open, open_bytes};
use hovernav_testing::shared;
use serde_json::Value;

/// Number of fixes and date of each receiver's capture; `None` without fixes.
const FIXES: &[(&str, Option<(usize, &str)>)] = &[
    ("gpsd/GPSmap-76S.log", None),
    // The receiver's ten-bit week rolls over that day, and its calendar gives 1999.
    ("gpsd/april6_2019.log", Some((2, "1999-08-22"))),
    // The last 4 positions are extrapolated, with 0 satellites.
    ("gpsd/foretrex-201.log", Some((3, "2010-08-26"))),
    ("gpsd/garmin48.log", Some((7, "2001-06-06"))),
    ("gpsd/gp-320fw-2019-04-07-coldboot.log", Some((2, "2019-04-07"))),
    ("gpsd/hab-gpspi.log", Some((3, "2015-06-21"))),
    ("gpsd/magellan315.log", Some((3, "2005-03-13"))),
    ("gpsd/motorola-t805.log", Some((16, "2007-12-18"))),
    ("gpsd/neo-m8n.log", Some((23, "2015-03-18"))),
    ("gpsd/nmea-fuzzy-cases.log", Some((14, "2020-03-18"))),
    ("gpsd/nmea-rtk.log", Some((122, "2020-03-18"))),
    ("gpsd/tcp-test.log", Some((1, "2007-12-23"))),
    ("gpsd/tcp-torture.log", Some((1, "2007-12-23"))),
    ("gpsd/tn200.log", None),
    ("gpsd/trimble-lassen_iq-playacar.log", Some((40, "2006-12-22"))),
    ("gpsd/trimble-lassen_iq.log", Some((30, "2006-11-26"))),
    ("gpsd/trimble-res720-dr.log", None),
    ("gpsd/trimble-res720.log", None),
    ("gpsd/trimble-ressmt360-dr.log", None),
    ("gpsd/trimble-smtx-dr.log", None),
    ("gpsd/trimble-smtx.log", None),
    ("gpsd/ublox-8.log", Some((72, "2017-01-10"))),
    ("gpsd/ublox-aek-4t.log", Some((4, "2007-12-23"))),
    ("gpsd/ublox-lea-4h.log", Some((9, "2006-08-10"))),
    ("gpsd/ublox-lea-4t.log", Some((2, "2009-01-28"))),
    ("gpsd/ublox-lea-5h.log", Some((20, "2010-08-21"))),
    ("gpsd/ublox-neo-m8n.log", Some((24, "2017-07-19"))),
    ("gpsd/ublox-neo-m8t.log", Some((39, "2018-10-25"))),
    ("gpsd/udp-test.log", Some((1, "2007-12-23"))),
    ("nmea/nmea1.log", Some((991, "2017-03-31"))),
    ("nmea/nmea2.log", None),
    ("nmea/nmea_with_sat_info.log", Some((35, "2022-04-13"))),
    ("trimble/thunderbolt.tsip", None),
];

#[test]
fn every_capture_of_a_receiver_gives_its_fixes_and_its_day() {
    let Some(captures) = shared("captures") else { return };
    for (name, expected) in FIXES {
        let opened = open(&captures.join(name), &Options::default());
        let Some((fixes, day)) = expected else {
            let refusal = opened.unwrap_err().to_string();
            assert!(refusal.contains("without fixes; receiver with"), "{name}: {refusal}");
            continue;
        };
        let log = opened.unwrap();
        assert_eq!(log.format, Format::Raw, "{name}");
        assert!(log.dataset.imu.is_empty());
        assert_eq!(log.dataset.fixes.len(), *fixes, "{name}: {:?}", log.dataset.warnings);
        let date = log.dataset.manifest.date.and_then(|date| Some(date.date?.to_string()));
        // The week must not roll over into another decade.
        assert_eq!(date.as_deref().unwrap_or_default(), *day, "{name}");
    }
}

#[test]
fn a_stream_of_an_unsupported_protocol_is_rejected() {
    let Some(folder) = shared("captures/gpsd") else { return };
    for name in ["bu303-moving", "bu303-nofix", "ublox-sirf1", "skytraq-err", "passthrough"] {
        let path = folder.join(format!("{name}.log"));
        let refusal = open(&path, &Options::default()).unwrap_err().to_string();
        assert!(refusal.contains("at byte 0: found"), "{refusal}");
    }
}

#[test]
fn every_complete_packet_of_a_dmu_stream_gets_its_time() {
    let Some(folder) = shared("captures/dmu_synthetic") else { return };
    let log = open(&folder.join("clean_330.bin"), &Options::default()).unwrap();
    assert_eq!(log.format, Format::Raw);
    let expected: Vec<Value> =
        serde_json::from_str(&fs::read_to_string(folder.join("clean_330.json")).unwrap()).unwrap();
    let imu = &log.dataset.imu;
    assert_eq!(imu.len(), expected.len());
    let span_s = imu[imu.len() - 1].time - imu[0].time;
    assert_abs_diff_eq!(span_s, 329.0 * 0.0303, epsilon = 0.02);
    for (sample, packet) in imu.iter().zip(&expected) {
        let [roll, pitch, yaw] = sample.attitude.unwrap().to_degrees();
        for (ours, key) in [(roll, "roll"), (pitch, "pitch"), (yaw, "yaw")] {
            assert!((ours - packet[key].as_f64().unwrap()).abs() < 1e-9, "{key}");
        }
        let force = sample.motion.mean_rates(0.03).specific_force_mps2.z();
        assert_abs_diff_eq!(force, -9.80665 * packet["az"].as_f64().unwrap(), epsilon = 1e-9);
    }

    let damaged = open(&folder.join("damaged.bin"), &Options::default()).unwrap().dataset;
    let intact: Value =
        serde_json::from_str(&fs::read_to_string(folder.join("damaged.json")).unwrap()).unwrap();
    let intact = intact["intact"].as_array().unwrap().len();
    println!("{} of {intact} intact packets, {:?}", damaged.imu.len(), damaged.warnings);
    assert!(damaged.imu.len() <= intact && damaged.imu.len() + 5 > intact);
    let span_s = damaged.imu[damaged.imu.len() - 1].time - damaged.imu[0].time;
    assert_abs_diff_eq!(span_s, 9.97, epsilon = 0.2);
}

/// A NMEA 0183 sentence with its checksum.
fn sentence(body: &str) -> String {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n")
}

#[test]
fn a_capture_passes_the_gate_of_every_format() {
    // Of 20 epochs, three at zero, one without a height, one with a value for unknown heights.
    let epoch = |k: u32| {
        let (lat, lon) =
            if k < 3 { ("0000.0000", "00000.0000") } else { ("4700.0000", "00830.0000") };
        let height = match k {
            5 => "",
            7 => "-9999.0",
            _ => "400.0",
        };
        let time = format!("1200{k:02}.00");
        sentence(&format!("GPGGA,{time},{lat},N,{lon},E,1,12,0.8,{height},M,47.0,M,,"))
            + &sentence(&format!("GPRMC,{time},A,{lat},N,{lon},E,0.30,,080725,,,A"))
    };
    let text: String = (0..20).map(epoch).collect();
    let log = open_bytes(text.as_bytes(), "flight.nmea".as_ref(), &Options::default()).unwrap();
    let (fixes, warnings) = (&log.dataset.fixes, &log.dataset.warnings);
    assert_eq!(fixes.len(), 17, "{warnings:?}");
    let flat: Vec<usize> = (0..17).filter(|&index| fixes[index].two_dimensional).collect();
    assert_eq!(flat, [2, 4], "{warnings:?}");
    for fix in fixes {
        assert_abs_diff_eq!(fix.position.height_m, 447.0, epsilon = 1e-6);
        // The speed of a receiver at rest, without a course.
        assert_eq!(fix.horizontal_velocity_mps, Some([0.0; 2]));
        assert!(fix.velocity_sigma_mps.is_some_and(|sigma| sigma.x() > 0.15), "{fix:?}");
    }
    let told = |words: &str| warnings.iter().any(|warning| warning.contains(words));
    assert!(told("3 rows") && told("latitude and longitude are 0"), "{warnings:?}");
    assert!(!told("jumped 5"), "{warnings:?}");
}

#[test]
fn a_leap_second_is_a_second_of_a_capture() {
    let epoch = |k: u32| {
        let (second, hundredths) = (k / 5, k % 5 * 20);
        let (time, date) = match second {
            0..=9 => (format!("2359{:02}", 50 + second), "311216"),
            10 => ("235960".to_owned(), "311216"),
            _ => (format!("0000{:02}", second - 11), "010117"),
        };
        let place = format!("47{:02}.{:04},N,00830.0000,E", k / 60, k % 60);
        let time = format!("{time}.{hundredths:02}");
        sentence(&format!("GPGGA,{time},{place},1,12,0.8,400.0,M,47.0,M,,"))
            + &sentence(&format!("GPRMC,{time},A,{place},0.30,10.0,{date},,,A"))
    };
    let text: String = (0..100).map(epoch).collect();
    let log = open_bytes(text.as_bytes(), "flight.nmea".as_ref(), &Options::default()).unwrap();
    assert_eq!(log.dataset.fixes.len(), 100, "{:?}", log.dataset.warnings);
    for (k, fix) in log.dataset.fixes.iter().enumerate() {
        let after_s = fix.time - log.dataset.fixes[0].time;
        assert_abs_diff_eq!(after_s, 0.2 * k as f64, epsilon = 1e-6);
    }
}
