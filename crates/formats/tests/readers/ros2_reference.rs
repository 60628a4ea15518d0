//! The reader returns the same numbers of ROS 2 messages as the reference library.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use approx::assert_abs_diff_eq;
use hovernav::imu::Motion;
use hovernav_dataset::pressure_altitude_m;
use hovernav_formats::{Options, open};
use hovernav_testing::python;

const HERE: &str = env!("CARGO_MANIFEST_DIR");

#[test]
fn the_reference_library_reads_the_same_numbers_for_every_compression() {
    let Some(python) = python(&["mcap-ros2-support", "mcap"]) else { return };
    let place = tempfile::tempdir().unwrap();
    for packing in ["none", "lz4", "zstd"] {
        let path = place.path().join(format!("{packing}.mcap"));
        let script = Path::new(HERE).join("tests/oracles/ros2.py");
        let output = Command::new(&python).arg(script).arg(&path).arg(packing).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let mut expected: BTreeMap<String, Vec<Vec<f64>>> = BTreeMap::new();
        for line in String::from_utf8(output.stdout).unwrap().lines() {
            let (kind, numbers) = line.split_once(' ').unwrap();
            let numbers = numbers.split(' ').map(|number| number.parse().unwrap()).collect();
            expected.entry(kind.to_owned()).or_default().push(numbers);
        }
        let dataset = open(&path, &Options::default()).unwrap().dataset;
        println!("{packing}: {:?}", expected.iter().map(|(k, v)| (k, v.len())).collect::<Vec<_>>());

        assert_eq!(dataset.imu.len(), expected["imu"].len());
        for (sample, e) in dataset.imu.iter().zip(&expected["imu"]) {
            assert_eq!(sample.time.nanoseconds() as f64, e[0]);
            let Motion::Rates { angular_rate_radps, specific_force_mps2 } = sample.motion else {
                panic!("rates")
            };
            assert_eq!(angular_rate_radps.to_array(), [e[1], -e[2], -e[3]]);
            assert_eq!(specific_force_mps2.to_array(), [e[4], -e[5], -e[6]]);
            // Rotation about the vertical only: yaw is anticlockwise from east.
            let yaw = 90.0 - (2.0 * e[10].atan2(e[7])).to_degrees();
            let off = (sample.attitude.unwrap().to_degrees()[2] - yaw).rem_euclid(360.0);
            assert!(off.min(360.0 - off) < 1e-9, "{off}");
        }
        assert_eq!(dataset.magnetometer.len(), expected["mag"].len());
        for ((_, field), e) in dataset.magnetometer.iter().zip(&expected["mag"]) {
            let [x, y, z] = field.to_array();
            let off = (x - 1e4 * e[1]).abs() + (y + 1e4 * e[2]).abs() + (z + 1e4 * e[3]).abs();
            assert!(off < 1e-12, "{off}");
        }
        assert_eq!(dataset.baro.len(), expected["baro"].len());
        for ((_, height_m), e) in dataset.baro.iter().zip(&expected["baro"]) {
            assert_eq!(Some(*height_m), pressure_altitude_m(e[1]));
        }
        assert_eq!(dataset.fixes.len(), expected["fix"].len());
        let velocities = expected["velocity"].iter().skip(1);
        for ((fix, e), v) in dataset.fixes.iter().zip(&expected["fix"]).zip(velocities) {
            assert_eq!(fix.time.nanoseconds() as f64, e[0]);
            let place = fix.position;
            assert_abs_diff_eq!(place.latitude_deg(), e[1], epsilon = 1e-12);
            assert_abs_diff_eq!(place.longitude_deg(), e[2], epsilon = 1e-12);
            assert_eq!(place.height_m, e[3]);
            let sigma = fix.position_sigma_m.unwrap().to_array();
            assert_eq!(sigma, [e[4].sqrt(), e[5].sqrt(), e[6].sqrt()]);
            assert_eq!(fix.horizontal_velocity_mps, Some([v[2], v[1]]));
            assert_eq!(fix.down_velocity_mps, Some(-v[3]));
        }
    }
}
