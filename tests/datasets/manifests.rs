//! Reading of `dataset.toml`: valid keys have the intended effect, invalid keys are rejected with their line.

use hovernav_dataset::{Dataset, Manifest, SolutionPoint};
use tempfile::TempDir;

const IMU: &str = "t_s,gyro_x_radps,gyro_y_radps,gyro_z_radps,accel_x_mps2,accel_y_mps2,accel_z_mps2\n\
                   1,0.01,0,0,0,0,-9.81\n";

fn directory(files: &[(&str, &str)]) -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    for (file, text) in files {
        std::fs::write(dir.path().join(file), text).unwrap();
    }
    dir
}

#[test]
fn a_configuration_overrides_key_by_key() {
    let dir = directory(&[(
        "dataset.toml",
        "name = 'a'\ndate = 2025-07-08\n[imu]\nlever_arm_m = [1, 2, 3]\nrate_hz = 50\n\
         [filter.gate]\nsigmas = 5\nfault_s = 9\n",
    )]);
    let config = "[imu]\nrate_hz = 60\ncolour = 'red'\n[filter.gate]\nsigmas = 6\n[solution]\npoint = 'imu'\n";
    let (manifest, _) = Manifest::read(&dir.path().join("dataset.toml")).unwrap();
    let (merged, warnings) = manifest.merged_with(config, "config.toml".as_ref()).unwrap();
    assert_eq!(warnings, ["config.toml: key imu.colour is not known and has no effect"]);
    assert_eq!(merged.name, "a");
    assert_eq!(merged.date.unwrap().to_string(), "2025-07-08");
    assert_eq!(
        (merged.imu.rate_hz, merged.imu.lever_arm_m.to_array()),
        (Some(60.0), [1.0, 2.0, 3.0])
    );
    assert_eq!(merged.filter.to_string(), "[gate]\nfault_s = 9\nsigmas = 6\n");
    assert_eq!(merged.solution.point, SolutionPoint::Imu);
    assert_eq!(merged.reference, manifest.reference);
}

#[test]
fn a_manifest_that_cannot_be_true_is_refused_with_its_line() {
    for (text, expected) in [
        (
            "name = 'a'\n[imu]\nlever_arm_m = [nan, 0, 0]\n",
            "dataset.toml:3: [imu] lever_arm_m: found [NaN, 0.0, 0.0], expected metres within ±100",
        ),
        (
            "[imu]\nlever_arm_m = [1, 2]\n",
            "dataset.toml:2: [imu] lever_arm_m: found 2 elements, expected a list of 3",
        ),
        (
            "[gps]\n\nlatency_s = 'late'\n",
            "dataset.toml:3: [gps] latency_s: found \"late\", expected a number",
        ),
        (
            "[gps]\nlatency_s = 99\n",
            "dataset.toml:2: [gps] latency_s: found 99, expected -30 to 30",
        ),
        (
            "[imu]\ngyro_bias_sigma_degps = -1\n",
            "dataset.toml:2: [imu] gyro_bias_sigma_degps: found -1, expected a number above 0",
        ),
        (
            "[imu]\nheading_reference = 'grid'\n",
            "dataset.toml:2: [imu] heading_reference: found \"grid\", expected \"true\" or \"magnetic\"",
        ),
        (
            "[solution]\npoint = 'antenna'\n",
            "dataset.toml:2: [solution] point: found \"antenna\", expected \"cg\" or \"imu\"",
        ),
        (
            "name = 'a'\n\n[filter]\ngate = 5\n",
            "dataset.toml:4: [filter] gate: found 5, expected a section",
        ),
        (
            "[filter.imu]\ngap_s = 1\n[filter.colour]\nred = 1\n",
            "dataset.toml:3: [filter] colour: no such key, expected \"imu\", \"gps\", \"attitude\"",
        ),
        (
            "[filter.gate]\n# Wide.\nsigma = 5\n",
            "dataset.toml:3: [filter.gate] sigma: no such key, expected \"sigmas\"",
        ),
        (
            "[gps]\nrate_hz = 1\n[filter.gate]\nsigmas = -5\n",
            "dataset.toml:4: [filter.gate] sigmas: found -5, expected 0 ",
        ),
        (
            "\n[alignment]\nduration_s = 1000\n",
            "dataset.toml:3: [alignment] duration_s: found 1000, expected 0 to 600",
        ),
        ("\n[aiding]\ncolour = true\n", "dataset.toml:3: [aiding] colour: no such key, expected "),
        ("date = 'yesterday'\n", "dataset.toml:1: date: expected a date such as 2025-07-08"),
        ("name = \n", "dataset.toml:1: "),
        ("[imu\n", "dataset.toml:1: "),
    ] {
        let dir = directory(&[("imu.csv", IMU), ("dataset.toml", text)]);
        let error = Dataset::open(dir.path()).unwrap_err().to_string();
        assert!(error.contains(expected) && !error.contains('\n'), "{error}");
    }
}
