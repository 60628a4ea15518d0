//! A computer that starts in the air during any manoeuvre. The first attitude accounts for the acceleration, and later
//! errors stay within the stated one-sigmas.

use hovernav::ekf::layout::Full;
use hovernav::ekf::{Estimator, EstimatorConfig, Notice};
use hovernav::event::Event;
use hovernav::frames::{Vector, wrap_angle};
use hovernav::ins::{Alignment, HeadingSource};
use hovernav_sim::{DmuConfig, GpsConfig, MagnetometerConfig, Recording, fly};

use crate::steep_circles::steep_circles;

struct Start {
    alignment: Alignment,
    /// Angle between the attitude at alignment and the true one, about a horizontal axis, rad.
    tilt_error_rad: f64,
    reopened: usize,
    /// Fraction of the solutions from 10 s after the start with yaw inside 3 sigma.
    yaw_inside: f64,
    /// Fraction of the same solutions with velocity inside 3 sigma.
    velocity_inside: f64,
    /// Fraction of the solutions in the first 10 s with roll and pitch inside 3 sigma.
    tilt_inside: f64,
}

/// Starts at `start_s` of a flight.
fn started(recording: &Recording, dmu: &DmuConfig, gps: &GpsConfig, start_s: f64) -> Start {
    let mut config = EstimatorConfig::default();
    config.mounting.imu_lever_arm_m = dmu.lever_arm_m;
    config.mounting.antenna_lever_arm_m = gps.lever_arm_m;
    config.aiding.magnetometer = dmu.magnetometer.is_some();
    let mut estimator = Box::new(Estimator::<Full, 28>::new(config));
    let (mut alignment, mut reopened) = (None, 0);
    let (mut tilt_error_rad, mut count, mut inside) = (0.0, 0.0, [0.0; 2]);
    let (mut tilts, mut tilts_inside) = (0.0, 0.0);
    let mut fixes = recording.fixes.iter().filter(|fix| fix.time.seconds() >= start_s).peekable();
    let samples = recording.imu.iter().zip(&recording.truth);
    for (sample, truth) in samples.filter(|(sample, _)| sample.time.seconds() >= start_s) {
        let mut notify = |notice| match notice {
            Notice::Aligned(found) => {
                let off = found.start.state.body_to_ned * truth.body_to_ned.inverse();
                // Remaining error of the direction of gravity.
                let down = Vector::new(0.0, 0.0, 1.0);
                let axis = found.axis;
                let open = (off * axis).dot(axis).clamp(-1.0, 1.0).acos();
                tilt_error_rad = if found.heading == HeadingSource::Unknown {
                    open
                } else {
                    (off * down).dot(down).clamp(-1.0, 1.0).acos()
                };
                alignment = Some(found);
            }
            Notice::Updated(report) => reopened += usize::from(report.any_reset()),
            _ => {}
        };
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            estimator.push(&Event::Gps(*fix), &mut notify);
        }
        estimator.push(&Event::Imu(*sample), &mut notify);
        let Some(solution) = estimator.solution() else { continue };
        let (found, true_to) = (solution.body_to_ned.euler(), truth.body_to_ned.euler());
        let [roll_sigma, pitch_sigma, _] = solution.attitude_sigma_rad;
        let roll_off = wrap_angle(found.roll_rad - true_to.roll_rad).abs();
        let pitch_off = (found.pitch_rad - true_to.pitch_rad).abs();
        if sample.time.seconds() - start_s <= 10.0 {
            let is_inside = roll_off <= 3.0 * roll_sigma && pitch_off <= 3.0 * pitch_sigma;
            tilts += 1.0;
            tilts_inside += f64::from(is_inside);
            continue;
        }
        count += 1.0;
        let yaw = found.yaw_rad - true_to.yaw_rad;
        inside[0] += f64::from(wrap_angle(yaw).abs() <= 3.0 * solution.attitude_sigma_rad[2]);
        let off = (solution.velocity_mps - truth.velocity_mps).to_array();
        let sigmas = solution.velocity_sigma_mps.to_array();
        let is_inside = off.iter().zip(sigmas).all(|(off, sigma)| off.abs() <= 3.0 * sigma);
        inside[1] += f64::from(is_inside);
    }
    let [yaw_inside, velocity_inside] = inside.map(|inside| inside / count);
    let alignment = alignment.expect("it aligns");
    let tilt_inside = tilts_inside / tilts;
    Start { alignment, tilt_error_rad, reopened, yaw_inside, velocity_inside, tilt_inside }
}

fn judge(magnetometer: Option<MagnetometerConfig>, expected: HeadingSource) {
    let dmu = DmuConfig { rate_hz: 50.0, attitude: None, magnetometer, ..DmuConfig::default() };
    let gps = GpsConfig::default();
    let recording = fly(&steep_circles(2.0, 6).build().unwrap(), &dmu, &gps, 3).unwrap();
    let (mut least, mut reopened, mut worst_deg) = ([1.0f64; 3], 0, 0.0f64);
    for step in 0..20 {
        let start_s = 8.0 + 1.3 * f64::from(step);
        let start = started(&recording, &dmu, &gps, start_s);
        assert_eq!(start.alignment.heading, expected);
        let tilt_deg = start.tilt_error_rad.to_degrees();
        println!(
            "{expected:?} from {start_s:.1} s: force {tilt_deg:.1} deg off, stated {:.1}; reopened {}; inside \
             3 sigma: yaw {:.3}, velocity {:.3}, tilt {:.3}",
            start.alignment.start.attitude_sigma_rad.x().to_degrees(),
            start.reopened,
            start.yaw_inside,
            start.velocity_inside,
            start.tilt_inside
        );
        let inside = [start.yaw_inside, start.velocity_inside, start.tilt_inside];
        least = core::array::from_fn(|which| least[which].min(inside[which]));
        reopened += start.reopened;
        worst_deg = worst_deg.max(tilt_deg);
    }
    assert!(worst_deg < 10.0, "{worst_deg}");
    // In nine of the twenty starts the filter is reset to a measured position once, soon after the heading is found. In
    // four of them the cause is the vertical velocity of the heading hypotheses. These do not estimate an accelerometer
    // bias and lose the height of a hover.
    assert!(reopened <= 9, "{reopened}");
    // In one of the twenty starts the tilt is outside for the first second after the heading is found.
    assert!(least.iter().all(|least| *least > 0.88), "{least:?}");
}

#[test]
fn a_start_in_a_steep_turn_finds_its_heading() {
    judge(None, HeadingSource::Unknown);
}

#[test]
fn a_start_in_a_steep_turn_goes_by_its_magnetometer() {
    judge(Some(MagnetometerConfig::default()), HeadingSource::Magnetometer);
}
