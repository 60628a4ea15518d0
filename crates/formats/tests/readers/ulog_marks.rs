//! Values that a ULog marks as unknown are not read.

use hovernav_formats::{Options, open};

/// A message of a ULog: size, type and body.
fn message(kind: u8, content: &[u8]) -> Vec<u8> {
    let size = u16::try_from(content.len()).unwrap().to_le_bytes();
    [&size[..], &[kind], content].concat()
}

/// One second of `sensor_combined` at 50 Hz; the time of the barometer is `relative_us` after the sample's.
fn log(relative_us: i32) -> Vec<u8> {
    let format = "sensor_combined:uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;\
                  int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;\
                  int32_t baro_timestamp_relative;float baro_alt_meter;";
    let mut bytes = b"ULog\x01\x12\x35\x01".to_vec();
    bytes.extend(1_000_000_u64.to_le_bytes());
    bytes.extend(message(b'F', format.as_bytes()));
    bytes.extend(message(b'A', b"\x00\x00\x00sensor_combined"));
    for sample in 0..50_u64 {
        let mut row = vec![0, 0];
        row.extend((1_000_000 + 20_000 * sample).to_le_bytes());
        row.extend([0.01_f32, 0.0, 0.0].map(f32::to_le_bytes).concat());
        row.extend(20_000_u32.to_le_bytes());
        row.extend(0_i32.to_le_bytes());
        row.extend([0.1_f32, 0.0, -9.8].map(f32::to_le_bytes).concat());
        row.extend(relative_us.to_le_bytes());
        row.extend(123.0_f32.to_le_bytes());
        bytes.extend(message(b'D', &row));
    }
    bytes
}

#[test]
fn a_barometer_with_unknown_times_is_ignored() {
    let folder = tempfile::tempdir().unwrap();
    for (relative_us, expected) in [(-5_000, 50), (i32::MAX, 0), (i32::MIN, 0)] {
        let path = folder.path().join("log.ulg");
        std::fs::write(&path, log(relative_us)).unwrap();
        let read = open(&path, &Options::default()).unwrap();
        assert_eq!(read.dataset.imu.len(), 50);
        assert_eq!(read.dataset.baro.len(), expected, "{relative_us}");
    }
}
