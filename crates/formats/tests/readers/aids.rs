//! Rangefinders and second antennas in logs of other autopilots.

use std::fs;

use approx::assert_abs_diff_eq;
use hovernav_formats::{Log, Options, open};
use hovernav_testing::shared;

use crate::mavlink::frame;

fn log(name: &str, bytes: &[u8]) -> Log {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(name);
    fs::write(&path, bytes).unwrap();
    open(&path, &Options::default()).unwrap()
}

#[test]
fn dataflash_gives_distances_downwards_and_yaws_of_the_receiver() {
    let mut text = String::from(
        "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n\
         FMT, 129, 40, IMU, Qffffff, TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ\n\
         FMT, 130, 50, GPS, QBIHBcLLeffff, TimeUS,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw\n\
         FMT, 131, 30, GPA, QffffBf, TimeUS,VDop,HAcc,VAcc,SAcc,VV,YAcc\n\
         FMT, 132, 20, RFND, QBfBBb, TimeUS,Instance,Dist,Stat,Orient,Quality\n",
    );
    for k in 0..100u32 {
        let us = 1_000_000 + k * 20_000;
        text += &format!("IMU, {us}, 0, 0, 0, 0, 0, -9.8\n");
        if k % 10 == 0 {
            let yaw = if k < 50 { 0.0 } else { 350.0 };
            text += &format!("GPS, {us}, 6, 100, 2300, 12, 0.8, 47.0, 8.0, 400, 0, 0, 0, {yaw}\n");
            text += &format!("GPA, {us}, 1, 0.5, 0.8, 0.1, 1, 0.6\n");
        }
        if k % 5 == 0 {
            let (state, quality) = if k < 10 { (3, 0) } else { (4, 80) };
            text +=
                &format!("RFND, {us}, 0, {}, {state}, 25, {quality}\n", 2.5 + 0.01 * f64::from(k));
        }
    }
    let dataset = log("a.log", text.as_bytes()).dataset;
    assert_eq!((dataset.imu.len(), dataset.ranges.len(), dataset.headings.len()), (100, 20, 5));
    assert_eq!(dataset.ranges[0].quality, Some(0.0));
    let last = dataset.ranges[19];
    assert_eq!((last.range_m, last.quality), (2.5 + 0.95, Some(0.8)));
    let heading = dataset.headings[0];
    assert_abs_diff_eq!(heading.heading_rad, -10f64.to_radians(), epsilon = 1e-9);
    assert_abs_diff_eq!(heading.sigma_rad.unwrap(), 0.6f64.to_radians(), epsilon = 1e-6);
    assert_eq!(heading.time, dataset.fixes[5].time);
}

fn scaled_imu(ms: u32) -> Vec<u8> {
    let mut payload = ms.to_le_bytes().to_vec();
    for value in [0i16, 0, -1000, 0, 0, 0, 0, 0, 0] {
        payload.extend(value.to_le_bytes());
    }
    payload
}

fn gps_raw(ms: u32, yaw: u16) -> Vec<u8> {
    let mut payload = vec![0; 52];
    payload[..8].copy_from_slice(&(u64::from(ms) * 1000).to_le_bytes());
    payload[8..12].copy_from_slice(&470_000_000i32.to_le_bytes());
    payload[12..16].copy_from_slice(&80_000_000i32.to_le_bytes());
    payload[16..20].copy_from_slice(&400_000i32.to_le_bytes());
    payload[28..30].copy_from_slice(&[6, 12]);
    payload[50..].copy_from_slice(&yaw.to_le_bytes());
    payload
}

/// Message of a rangefinder that looks down: range 20 cm to 40 m, one-sigma 5 cm.
fn distance(ms: u32, centimetres: u16, quality: u8) -> Vec<u8> {
    let mut payload = vec![0; 39];
    payload[..4].copy_from_slice(&ms.to_le_bytes());
    payload[4..6].copy_from_slice(&20u16.to_le_bytes());
    payload[6..8].copy_from_slice(&4000u16.to_le_bytes());
    payload[8..10].copy_from_slice(&centimetres.to_le_bytes());
    (payload[12], payload[13], payload[38]) = (25, 25, quality);
    payload
}

#[test]
fn telemetry_logs_give_distances_and_the_yaw_of_the_receiver() {
    let mut bytes = Vec::new();
    let start_us = 1_700_000_000_000_000u64;
    for k in 0..100u32 {
        let ms = 5_000 + 20 * k;
        let us = start_us + u64::from(ms) * 1000;
        bytes.extend(frame(us, k as u8, 26, 170, &scaled_imu(ms)));
        if k % 10 == 0 {
            let yaw = if k == 0 { 0 } else { 36_000 };
            bytes.extend(frame(us, 0, 24, 24, &gps_raw(ms, yaw)));
            let (centimetres, quality) =
                [(600, 90), (15, 90), (601, 1), (602, 0)][k as usize / 10 % 4];
            bytes.extend(frame(us, 0, 132, 85, &distance(ms, centimetres, quality)));
        }
    }
    let dataset = log("a.tlog", &bytes).dataset;
    assert_eq!((dataset.imu.len(), dataset.ranges.len(), dataset.headings.len()), (100, 10, 9));
    let said: Vec<_> =
        dataset.ranges.iter().take(4).map(|r| ((100.0 * r.range_m).round(), r.quality)).collect();
    assert_eq!(said, [(600.0, Some(0.9)), (15.0, Some(0.0)), (601.0, Some(0.0)), (602.0, None)]);
    assert_abs_diff_eq!(dataset.ranges[0].sigma_m.unwrap(), 0.05, epsilon = 1e-12);
    assert!(dataset.headings[0].heading_rad.abs() < 1e-12);
}

#[test]
fn the_rangefinder_of_a_telemetry_log_without_distance_sensor_is_read() {
    let mut bytes = Vec::new();
    for k in 0..50u32 {
        let ms = 5_000 + 20 * k;
        let us = 1_700_000_000_000_000 + u64::from(ms) * 1000;
        bytes.extend(frame(us, k as u8, 26, 170, &scaled_imu(ms)));
        let mut payload = (3.5f32 + k as f32).to_le_bytes().to_vec();
        payload.extend(1f32.to_le_bytes());
        bytes.extend(frame(us, 0, 173, 83, &payload));
    }
    let dataset = log("a.tlog", &bytes).dataset;
    assert_eq!(dataset.ranges.len(), 50);
    assert_eq!(dataset.ranges[1].range_m, 4.5);
    assert_abs_diff_eq!(dataset.ranges[1].time - dataset.imu[1].time, 0.0, epsilon = 1e-6);
}

#[test]
fn distances_of_real_logs_are_read() {
    for name in
        ["px4-quad-vibration-2025.ulg", "sample_log_small.ulg", "px4-quad-motor-failure.ulg"]
    {
        let Some(path) = shared(format!("logs/{name}")) else { continue };
        let dataset = open(&path, &Options::default()).unwrap().dataset;
        println!("{name}: {} distances, {} headings", dataset.ranges.len(), dataset.headings.len());
        let sound = dataset.ranges.iter().all(|reading| (0.0..=1e4).contains(&reading.range_m));
        assert!(sound && dataset.ranges.windows(2).all(|pair| pair[0].time < pair[1].time));
    }
}
