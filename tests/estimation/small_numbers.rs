//! No number in the loop decays to a denormal, with which a processor computes a hundred times slower.

use hovernav::autopilot::{HoverAutopilot, HoverConfig, Inputs};
use hovernav::controls::Sticks;
use hovernav::earth::Geodetic;
use hovernav::ekf::layout::Full;
use hovernav::ekf::{Estimator, EstimatorConfig, SteplessSolution};
use hovernav::event::{BaroReading, Event};
use hovernav::frames::{EulerAngles, Vector};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::scalar::Scalar;
use hovernav::time::Time;
use hovernav_design::hover::HoverDesign;
use hovernav_model::shipped;

const PERIOD_S: f64 = 0.03;

/// Smallest allowed size in the estimator and in the autopilot; the square of a smaller number is denormal. In single
/// precision the estimator is exempt: after ten minutes without any aid the correlations of the attitude's slow errors
/// are that small. Its target processors (Cortex-M4F, Cortex-M7) compute with denormals at full speed.
fn smallest<T: Scalar>() -> [f64; 2] {
    let is_single = T::of(1e-60) == T::ZERO;
    if is_single { [0.0, 1.1e-19] } else { [1.5e-154; 2] }
}

/// The nonzero numbers smaller than `smallest` in a debug print, with the preceding text.
fn too_small(printed: &str, smallest: f64) -> Vec<String> {
    let mut found = Vec::new();
    let part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '+' | '_');
    for (end, _) in printed.match_indices([',', ' ', ']', ')', '}']) {
        let start = printed[..end].rfind(|c| !part(c)).map_or(0, |at| at + 1);
        let small =
            printed[start..end].parse::<f64>().is_ok_and(|v| v != 0.0 && v.abs() < smallest);
        if small {
            found.push(printed[end.saturating_sub(300)..end].to_owned());
        }
    }
    found
}

/// Hovers for `aided_s` with fixes and aids and for `alone_s` without, with uniform vibration of ±`vibration_mps2`.
fn hover<T: Scalar>(aided_s: f64, alone_s: f64, vibration_mps2: f64) {
    let mut estimator = Box::new(Estimator::<Full, 28, T>::with_layout(EstimatorConfig::default()));
    let mut stepless = SteplessSolution::default();
    let design = HoverDesign { period_s: PERIOD_S, ..HoverDesign::default() };
    let gains = design.synthesise(&shipped::raptor60()).unwrap();
    let mut autopilot = HoverAutopilot::new(HoverConfig::new(PERIOD_S, gains).cast::<T>()).unwrap();
    let home = Geodetic::from_degrees(48.1, 11.6, 520.0).unwrap();
    let mut noise = 0x9E37_79B9_7F4A_7C15u64;
    let mut shake = || {
        noise ^= noise << 13;
        noise ^= noise >> 7;
        noise ^= noise << 17;
        (noise >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let cycles = ((aided_s + alone_s) / PERIOD_S) as u32;
    for cycle in 0..cycles {
        let time = Time::ZERO + f64::from(cycle) * PERIOD_S;
        let aided = time.seconds() < aided_s;
        let [a, b, c, d, e, f] = std::array::from_fn(|_| shake());
        let motion = Motion::Rates {
            angular_rate_radps: Vector::new(a, b, c) * (0.01 * vibration_mps2),
            specific_force_mps2: Vector::new(d, e, f) * vibration_mps2
                + Vector::new(0.0, 0.0, -9.806),
        };
        let mut sample = ImuSample::new(time, motion);
        if aided {
            sample.attitude = Some(EulerAngles::default());
            sample.magnetic_field_gauss = Some(Vector::new(0.2, 0.0, 0.43));
        }
        let mut push = |event: &Event| estimator.push_traced(event, &mut stepless, |_| {});
        push(&Event::Imu(sample));
        if aided && cycle % 33 == 0 {
            push(&Event::Baro(BaroReading::new(time, 520.0 + 0.3 * shake())));
            push(&Event::Gps(Fix {
                horizontal_velocity_mps: Some([0.1 * shake(), 0.1 * shake()]),
                down_velocity_mps: Some(0.1 * shake()),
                ..Fix::at(time, home.displaced(Vector::new(shake(), shake(), shake())))
            }));
        }
        let solution = estimator.solution().map(|own| stepless.solution(&own));
        let pilot = Some(Sticks::default());
        let engage = time.seconds() > 40.0;
        autopilot.step(&Inputs { now: time, solution: solution.as_ref(), pilot, engage });
        if cycle % 2_000 == 1_999 {
            let printed = [format!("{estimator:?}"), format!("{stepless:?} {autopilot:?}")];
            for (printed, smallest) in printed.iter().zip(smallest::<T>()) {
                let found = too_small(printed, smallest);
                assert!(found.is_empty(), "{time}: {} numbers, {}", found.len(), found.join("\n"));
            }
        }
    }
}

#[test]
fn what_is_printed_too_small_is_found() {
    let found = too_small(&format!("{:?} {:?}", [1.0, -3e-310, 0.0], Some(1e-155)), 1.5e-154);
    assert_eq!(found.len(), 2, "{found:?}");
}

#[test]
fn half_an_hour_of_hover_leaves_no_number_too_small() {
    hover::<f64>(1_800.0, 0.0, 0.5);
    hover::<f32>(1_800.0, 0.0, 0.5);
}

#[test]
fn half_an_hour_alone_leaves_no_number_too_small() {
    hover::<f64>(60.0, 1_800.0, 0.5);
    hover::<f32>(60.0, 1_800.0, 0.5);
}

#[test]
fn readings_that_repeat_themselves_leave_no_number_too_small() {
    hover::<f64>(60.0, 1_800.0, 0.0);
    hover::<f32>(60.0, 1_800.0, 0.0);
}
