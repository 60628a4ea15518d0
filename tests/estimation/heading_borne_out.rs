//! A heading consistent with the fixes is kept against a contradicting sensor, for any time.

use core::f64::consts::PI;

use hovernav::ekf::Notice;
use hovernav::ekf::layout::Full;
use hovernav::event::Event;
use hovernav::frames::{EulerAngles, wrap_angle};
use hovernav::gps::AntennaHeading;
use hovernav_sim::{FlightPlan, GpsConfig};

use crate::{blocks, unaided};

/// Source of the heading.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Source {
    Attitude,
    Antennas,
}

/// Largest heading error, °, from 60 s on. `source` measures heading and tilt; from 60 s on its heading is wrong by
/// half a turn or a quarter turn. The second result is the time when the filter adopted the wrong heading, s, if it
/// did.
fn worst_deg(plan: &FlightPlan, source: Source) -> (f64, Option<f64>) {
    let gps = GpsConfig { rate_hz: 5.0, ..GpsConfig::default() };
    let (recording, mut estimator) = unaided::flown_unaided::<Full, 28>(plan, &gps, 1);
    let mut fixes = recording.fixes.iter().peekable();
    let (mut worst, mut reopened) = (0.0f64, None);
    let jump_rad = if source == Source::Attitude { PI } else { 0.5 * PI };
    for (index, (sample, truth)) in recording.imu.iter().zip(&recording.truth).enumerate() {
        let right = truth.body_to_ned.euler();
        let wrong = if sample.time.seconds() < 60.0 { 0.0 } else { jump_rad };
        let told_rad = wrap_angle(right.yaw_rad + wrong);
        let mut sample = *sample;
        if source == Source::Attitude {
            sample.attitude = Some(EulerAngles { yaw_rad: told_rad, ..right });
        }
        let mut notify = |notice| {
            if let Notice::Updated(report) = notice
                && report.any_reset()
                && report.innovations().any(|axis| axis.innovation.abs() > 1.0)
            {
                reopened.get_or_insert(sample.time.seconds());
            }
        };
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            estimator.push(&Event::Gps(*fix), &mut notify);
        }
        estimator.push(&Event::Imu(sample), &mut notify);
        if source == Source::Antennas && index % 10 == 0 {
            let reading = AntennaHeading {
                time: sample.time,
                heading_rad: told_rad,
                sigma_rad: Some(0.02),
                length_m: None,
            };
            estimator.push(&Event::AntennaHeading(reading), &mut notify);
        }
        if sample.time.seconds() > 60.0
            && let Some(now) = estimator.solution()
        {
            let off_rad = wrap_angle(now.body_to_ned.heading_rad() - right.yaw_rad);
            worst = worst.max(off_rad.abs().to_degrees());
        }
    }
    (worst, reopened)
}

#[test]
fn a_sensor_that_jumps_is_refused_for_as_long_as_the_fixes_bear_the_heading_out() {
    for source in [Source::Attitude, Source::Antennas] {
        let (worst_deg, reopened) = worst_deg(&blocks::around_blocks(24), source);
        println!("{source:?}: at most {worst_deg:.1}° off");
        assert!(worst_deg < 6.0 && reopened.is_none(), "{source:?}: {worst_deg}°, {reopened:?}");
    }
}

/// Without motion to confirm either heading, the filter adopts the sensor's heading after two minutes, and reports it.
#[test]
fn in_hover_a_sensor_that_jumps_is_accepted_after_two_minutes() {
    let place = hovernav::earth::Geodetic::from_degrees(49.0, 8.4, 110.0).unwrap();
    let plan = FlightPlan::hover_at(place, 0.4).hold(200.0);
    let (_, reopened) = worst_deg(&plan, Source::Attitude);
    let after_s = reopened.unwrap() - 60.0;
    assert!((115.0..130.0).contains(&after_s), "{after_s}");
}
