//! Solutions are written in the expected format, and scored at the reference's point and time.

use std::path::Path;

use approx::assert_abs_diff_eq;
use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector};
use hovernav::time::Time;
use hovernav_dataset::{Dataset, LogError, Manifest, Reference, SolutionWriter, Truth};
use hovernav_score::{Axis, Score, Statistics, outage_drift, score};
use proptest::prelude::*;

fn seconds(seconds: f64) -> Time {
    Time::from_seconds(seconds)
}

fn solution(time_s: f64) -> Solution {
    Solution {
        body_to_ned: Rotation::IDENTITY,
        position_sigma_m: Vector::new(1.0, 1.0, 2.0),
        velocity_sigma_mps: Vector::new(0.1, 0.1, 0.2),
        attitude_sigma_rad: [0.01, 0.01, 0.02],
        ..Solution::at_rest(seconds(time_s), Geodetic::from_degrees(45.0, -93.0, 250.0).unwrap())
    }
}

fn attitude(roll_deg: f64, pitch_deg: f64, yaw_deg: f64) -> Rotation<Body, Ned> {
    Rotation::from_euler(EulerAngles::from_degrees(roll_deg, pitch_deg, yaw_deg))
}

fn written(solutions: &[Solution]) -> Result<String, LogError> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("solution.csv");
    let mut file = SolutionWriter::new(&path, &[]);
    solutions.iter().try_for_each(|solution| file.push(solution))?;
    file.finish()?;
    Ok(std::fs::read_to_string(path).unwrap())
}

/// The reference from a `reference.csv` of this text, scored from the first sample on.
fn reference(text: &str, manifest: &str) -> Reference {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("reference.csv"), text).unwrap();
    let (mut manifest, _) = Manifest::parse(manifest, "dataset.toml".as_ref()).unwrap();
    manifest.reference.skip_s = 0.0;
    Reference::open(dir.path(), &manifest).unwrap().unwrap()
}

fn largest(score: &Score, axis: Axis) -> f64 {
    score.axis(axis).unwrap().statistics.max
}

#[test]
fn the_columns_are_those_other_programs_read() {
    let mut first = solution(12.5);
    first.velocity_mps = Vector::new(1.0, -2.0, 0.123_456_78);
    first.body_to_ned = attitude(0.0, 0.0, 180.0);
    first.position_sigma_m = Vector::new(1.25, 0.000_04, 1e4);
    first.gyro_bias_radps = Vector::new(1.5e-7, -1e-10, 0.0);
    let mut second = solution(-0.25);
    second.position = Geodetic { longitude_rad: -std::f64::consts::PI, ..second.position };
    assert_eq!(
        written(&[first, second]).unwrap(),
        "t_s,lat_deg,lon_deg,height_m,vn_mps,ve_mps,vd_mps,roll_deg,pitch_deg,yaw_deg,\
         u_mps,v_mps,w_mps,p_radps,q_radps,r_radps,sigma_n_m,sigma_e_m,sigma_d_m,\
         sigma_vn_mps,sigma_ve_mps,sigma_vd_mps,sigma_roll_deg,sigma_pitch_deg,sigma_yaw_deg,\
         gyro_bias_x_radps,gyro_bias_y_radps,gyro_bias_z_radps,\
         accel_bias_x_mps2,accel_bias_y_mps2,accel_bias_z_mps2\n\
         12.5,45.0000000000,-93.0000000000,250.0000,1.00000,-2.00000,0.12346,\
         0.00000,0.00000,180.00000,-1.00000,2.00000,0.12346,0.0000000,0.0000000,0.0000000,\
         1.2500,0.0000,10000.0000,0.10000,0.10000,0.20000,0.57296,0.57296,1.14592,\
         0.00000015,0.00000000,0.00000000,0.00000000,0.00000000,0.00000000\n\
         -0.25,45.0000000000,180.0000000000,250.0000,0.00000,0.00000,0.00000,\
         0.00000,0.00000,0.00000,0.00000,0.00000,0.00000,0.0000000,0.0000000,0.0000000,\
         1.0000,1.0000,2.0000,0.10000,0.10000,0.20000,0.57296,0.57296,1.14592,\
         0.00000000,0.00000000,0.00000000,0.00000000,0.00000000,0.00000000\n"
    );
}

#[test]
fn what_is_no_number_is_never_written() {
    for value in [f64::NAN, f64::INFINITY, 1e300] {
        let mut bad = solution(2.0);
        bad.velocity_sigma_mps = Vector::new(0.1, value, 0.1);
        let error = written(&[solution(1.0), bad]).unwrap_err();
        assert!(
            matches!(error, LogError::Unwritable { row: 2, column: "sigma_ve_mps", .. }),
            "{error}"
        );
    }
}

proptest! {
    #[test]
    fn written_numbers_are_within_half_of_their_last_digit(
        height in -1e5..1e5, rate in -10.0..10.0, north in -300.0..300.0, nanoseconds in any::<i64>(),
    ) {
        let mut written_solution = solution(0.0);
        written_solution.time = Time::from_nanoseconds(nanoseconds);
        written_solution.position.height_m = height;
        written_solution.angular_rate_radps = Vector::new(rate, 0.0, 0.0);
        written_solution.velocity_mps = Vector::new(north, 0.0, 0.0);
        let text = written(&[written_solution]).unwrap();
        let fields: Vec<&str> = text.lines().nth(1).unwrap().split(',').collect();
        let number = |column: usize| fields[column].parse::<f64>().unwrap();
        prop_assert!((number(3) - height).abs() <= 0.500_001e-4);
        prop_assert!((number(4) - north).abs() <= 0.500_001e-5);
        prop_assert!((number(13) - rate).abs() <= 0.500_001e-7);
        let (whole, fraction) = fields[0].split_once('.').unwrap_or((fields[0], ""));
        prop_assert_eq!(format!("{whole}{fraction:0<9}").parse::<i64>().unwrap(), nanoseconds);
    }
}

#[test]
fn the_truth_scores_zero_against_itself() {
    let heli = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/heli-hover"));
    let dataset = Dataset::open(heli).unwrap();
    let reference = Reference::open(heli, &dataset.manifest).unwrap().unwrap();
    assert_eq!(reference.warnings, [""; 0]);
    let solutions: Vec<Solution> = dataset
        .imu
        .iter()
        .map(|sample| {
            let truth = reference.at(sample.time);
            let [latitude_rad, longitude_rad, height_m] = truth.position;
            let [roll_rad, pitch_rad, yaw_rad] = truth.attitude_rad;
            Solution {
                time: sample.time,
                position: Geodetic { latitude_rad, longitude_rad, height_m },
                velocity_mps: truth.velocity_mps.into(),
                body_to_ned: Rotation::from_euler(EulerAngles { roll_rad, pitch_rad, yaw_rad }),
                ..solution(0.0)
            }
        })
        .collect();
    let score = score(&solutions, &reference, dataset.imu[0].time);
    assert_eq!(score.from, seconds(30.05));
    assert_eq!(score.axes.len(), Axis::ALL.len());
    for axis in &score.axes {
        // u, v, w and the angles are rounded to their last digit.
        let rounding = if axis.axis.name().ends_with("_mps") { 1e-4 } else { 1e-9 };
        assert!(axis.statistics.max < rounding, "{}: {:?}", axis.axis.name(), axis.statistics);
        assert!(axis.within_3_sigma.is_none_or(|fraction| fraction == 1.0));
        assert!(axis.samples < 9899 - 30 * 32 && axis.series.len() <= 2000);
    }
}

#[test]
fn a_turning_vehicle_is_scored_at_the_references_own_point() {
    // A vehicle turning at 1 rad/s about a fixed centre of gravity. The reference is that of an antenna 2 m ahead,
    // the solution that of an inertial unit 1 m behind.
    let rate = Vector::new(0.0, 0.0, 1.0);
    let centre = Geodetic::from_degrees(45.0, -93.0, 250.0).unwrap();
    let moving = |arm_m: Vector<Body>, time_s: f64| {
        let body_to_ned = attitude(0.0, 0.0, time_s.to_degrees());
        let position = centre.displaced(body_to_ned * arm_m);
        (position, body_to_ned * rate.cross(arm_m), body_to_ned)
    };
    let times = (0..300).map(|index| f64::from(index) * 0.01);
    let antenna: Vec<Truth> = times
        .clone()
        .map(|time_s| {
            let (position, velocity_mps, body_to_ned) = moving(Vector::new(2.0, 0.0, 0.0), time_s);
            let time = seconds(time_s);
            Truth { time, position, velocity_mps, body_to_ned, angular_rate_radps: rate }
        })
        .collect();
    let solutions: Vec<Solution> = times
        .map(|time_s| {
            let (position, velocity_mps, body_to_ned) = moving(Vector::new(-1.0, 0.0, 0.0), time_s);
            Solution {
                position,
                velocity_mps,
                body_to_ned,
                angular_rate_radps: rate,
                ..solution(time_s)
            }
        })
        .collect();
    let manifest = "[imu]\nlever_arm_m = [-1, 0, 0]\n[gps]\nantenna_lever_arm_m = [2, 0, 0]\n\
                    [reference]\npoint = 'antenna'\nskip_s = 0\n[solution]\npoint = 'imu'\n";
    let (manifest, _) = Manifest::parse(manifest, "dataset.toml".as_ref()).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let dataset = Dataset { manifest, ..Dataset::default() };
    dataset.write(dir.path(), &antenna).unwrap();
    let reference = Reference::open(dir.path(), &dataset.manifest).unwrap().unwrap();
    let score = score(&solutions, &reference, Time::ZERO);
    assert_eq!(score.axes.len(), 13);
    for axis in &score.axes {
        assert!(axis.statistics.max < 1e-6, "{}: {:?}", axis.axis.name(), axis.statistics);
    }
}

#[test]
fn the_reference_is_read_between_its_rows_but_not_beyond_them_nor_across_a_gap() {
    let reference = reference(
        "t_s,lat_deg,lon_deg,height_m,vn_mps,ve_mps,vd_mps,roll_deg,pitch_deg,yaw_deg\n\
         1.0,45,179.9999,100,1,0,0,0,0,170\n\
         1.2,45,-179.9999,101,3,0,0,0,0,-170\n\
         1.4,45,-179.9999,101,3,0,0,0,0,-170\n\
         2.4,45,-179.9999,101,3,0,0,0,0,-170\n",
        "",
    );
    let between = reference.at(seconds(1.1));
    assert_abs_diff_eq!(between.position[1].to_degrees().abs(), 180.0, epsilon = 1e-9);
    assert_abs_diff_eq!(between.position[2], 100.5, epsilon = 1e-12);
    assert_abs_diff_eq!(between.velocity_mps[0], 2.0, epsilon = 1e-12);
    assert_abs_diff_eq!(between.attitude_rad[2].to_degrees().abs(), 180.0, epsilon = 1e-9);
    // Moving south at 2 m/s while facing south is forward motion.
    assert_abs_diff_eq!(between.body_velocity_mps[0], -2.0, epsilon = 1e-9);
    for outside in [0.99, 1.41, 2.0, 2.39, 2.41] {
        let moment = reference.at(seconds(outside));
        assert!(moment.position[0].is_nan() && moment.velocity_mps[0].is_nan(), "{outside}");
        assert!(moment.attitude_rad[2].is_nan() && moment.body_velocity_mps[0].is_nan());
    }
    assert_eq!(reference.at(seconds(2.4)).velocity_mps[0], 3.0);
}

#[test]
fn a_slow_reference_is_read_across_its_own_intervals() {
    let rows = (0..9).map(|t| format!("{t},45,-93,{t}\n")).collect::<String>();
    let reference = reference(&format!("t_s,lat_deg,lon_deg,height_m\n{rows}"), "");
    assert_abs_diff_eq!(reference.at(seconds(3.25)).position[2], 3.25, epsilon = 1e-12);
}

#[test]
fn axes_the_reference_does_not_speak_of_are_absent() {
    let reference = reference(
        "t_s,lat_deg,lon_deg,height_m,vn_mps,ve_mps,vd_mps,roll_deg,pitch_deg,yaw_deg\n\
         1.0,,,250,0.5,,,,,-179\n\
         1.2,,,250,0.5,,nan,,,-179\n",
        "",
    );
    let solutions = [1.0, 1.1, 1.2]
        .map(|time_s| Solution { body_to_ned: attitude(0.0, 0.0, 179.0), ..solution(time_s) });
    let score = score(&solutions, &reference, seconds(1.0));
    let axes: Vec<Axis> = score.axes.iter().map(|axis| axis.axis).collect();
    assert_eq!(axes, [Axis::Down, Axis::VelocityNorth, Axis::Yaw]);
    assert_eq!(largest(&score, Axis::VelocityNorth), 0.5);
    assert_eq!(score.axis(Axis::VelocityNorth).unwrap().within_3_sigma, Some(0.0));
    assert_abs_diff_eq!(largest(&score, Axis::Yaw), 2.0, epsilon = 1e-9);
    assert_eq!(score.axis(Axis::Yaw).unwrap().within_3_sigma, Some(1.0));
}

#[test]
fn what_the_reference_errs_by_itself_is_not_held_against_the_sigmas() {
    let text = "t_s,vn_mps,ve_mps,vd_mps\n1.0,0.5,0.5,0.5\n1.2,0.5,0.5,0.5\n";
    let solutions = [1.0, 1.1, 1.2].map(solution);
    let ratios = |manifest: &str| {
        let score = score(&solutions, &reference(text, manifest), seconds(1.0));
        let axis = score.axis(Axis::VelocityNorth).unwrap();
        (axis.within_3_sigma.unwrap(), axis.error_over_sigma.unwrap())
    };
    // An error of 0.5 m/s at a sigma of 0.1 m/s; then with a sigma of the reference of 0.24 m/s in addition.
    let (within, ratio) = ratios("");
    assert_eq!(within, 0.0);
    assert_abs_diff_eq!(ratio, 5.0, epsilon = 1e-12);
    let (within, ratio) = ratios("[reference]\nvelocity_sigma_mps = 0.24");
    assert_eq!(within, 1.0);
    assert_abs_diff_eq!(ratio, 0.5 / 0.26, epsilon = 1e-12);
}

/// A reference at rest for 100 s, and solutions at 10 Hz with an error of `drift_m(t)` to the north.
fn drifting(drift_m: impl Fn(f64) -> f64) -> (Vec<Solution>, Reference) {
    let rows =
        (0..=1000).map(|i| format!("{}.{},45,-93,250\n", i / 10, i % 10)).collect::<String>();
    let reference = reference(&format!("t_s,lat_deg,lon_deg,height_m\n{rows}"), "");
    let solutions = (0..=1000).map(|index| {
        let at = solution(f64::from(index) / 10.0);
        let drift = Vector::new(drift_m(at.time.seconds()), 0.0, 0.0);
        Solution { position: at.position.displaced(drift), ..at }
    });
    (solutions.collect(), reference)
}

#[test]
fn an_outage_drifts_as_far_as_its_worst_moment() {
    let (solutions, reference) = drifting(|time_s| if time_s > 20.0 { time_s - 20.0 } else { 0.0 });
    let drift =
        |start_s, duration_s| outage_drift(&solutions, &reference, seconds(start_s), duration_s);
    assert_abs_diff_eq!(drift(20.0, 30.0).unwrap(), 30.0, epsilon = 1e-6);
    assert!(drift(0.0, 20.0).unwrap() < 1e-6);
    assert_eq!(drift(90.0, 30.0), None);
    assert_eq!(drift(200.0, 30.0), None);
    assert_eq!(drift(-30.0, 10.0), None);
}

#[test]
fn the_start_is_seen_but_not_scored() {
    let (solutions, mut reference) = drifting(|time_s| if time_s < 30.0 { 5.0 } else { 1.0 });
    reference.skip_s = 30.0;
    let score = score(&solutions, &reference, Time::ZERO);
    let north = score.axis(Axis::North).unwrap();
    assert_abs_diff_eq!(north.statistics.max, 1.0, epsilon = 1e-6);
    assert_eq!(north.samples, 701);
    assert_abs_diff_eq!(north.series[0].error, 5.0, epsilon = 1e-6);
}

#[test]
fn a_thinned_series_keeps_the_peaks() {
    let peak = 61.7;
    let (solutions, reference) = drifting(|time_s| if time_s == peak { 7.0 } else { 0.0 });
    let mut many: Vec<Solution> = (0..20)
        .flat_map(|copy| {
            solutions.iter().map(move |at| {
                let time = at.time.offset_by(f64::from(copy) * 0.005);
                Solution { time, ..*at }
            })
        })
        .collect();
    many.sort_by_key(|at| at.time);
    let score = score(&many, &reference, Time::ZERO);
    let series = &score.axis(Axis::North).unwrap().series;
    assert!(series.len() <= 2000 && series.windows(2).all(|pair| pair[0].time < pair[1].time));
    assert!(series.iter().any(|point| (point.error - 7.0).abs() < 1e-6));
}

#[test]
fn quantiles_are_interpolated_between_the_sizes() {
    let statistics = Statistics::of(&[-4.0, 1.0, 3.0, -2.0]).unwrap();
    assert_eq!((statistics.median, statistics.max), (2.5, 4.0));
    assert_abs_diff_eq!(statistics.rmse, 7.5f64.sqrt(), epsilon = 1e-15);
    assert_abs_diff_eq!(statistics.p95, 3.85, epsilon = 1e-12);
    assert_eq!(Statistics::of(&[]), None);
    assert_eq!(Statistics::of(&[1.0, f64::NAN]), None);
}
