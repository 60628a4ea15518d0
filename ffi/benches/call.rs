//! Cost of the C interface per call: the same work through it and without it, in one run.
//!
//! `cargo bench -p hovernav-ffi`. Each pair runs alternately, a thousand calls at a time. The least of many rounds is
//! the time of the code without disturbance by other processes.

use std::hint::black_box;
use std::mem::MaybeUninit;
use std::ptr::{null_mut, read};
use std::time::Instant;

use hovernav::ekf::{Estimator, EstimatorConfig, SteplessSolution};
use hovernav::event::Event;
use hovernav::frames::{EulerAngles, Vector};
use hovernav::health::{HealthLimits, HealthMonitor};
use hovernav::imu::{ImuSample as CoreSample, Motion};
use hovernav::time::Time;
use hovernav_c::settings::{Config, hovernav_default_config};
use hovernav_c::*;

const CALLS: u32 = 1_000;
const ROUNDS: u32 = 400;

/// Nanoseconds a call, the least of all rounds.
fn least(best: &mut f64, work: impl FnOnce()) {
    let start = Instant::now();
    work();
    *best = best.min(start.elapsed().as_secs_f64() * 1e9 / f64::from(CALLS));
}

fn main() {
    let mut memory = vec![0_u128; HOVERNAV_SIZE / 16];
    let mut config = MaybeUninit::<Config>::uninit();
    let mut nav = null_mut();
    // SAFETY: valid pointers, and memory of this size and alignment.
    unsafe {
        hovernav_default_config(config.as_mut_ptr(), HOVERNAV_ABI);
        let memory = memory.as_mut_ptr().cast();
        hovernav_create(memory, HOVERNAV_SIZE, config.as_ptr(), null_mut(), &raw mut nav);
    }
    let estimator = Estimator::new(EstimatorConfig::default());
    let mut without =
        (estimator, HealthMonitor::new(HealthLimits::default()), SteplessSolution::default());

    let fix = Fix { latitude_deg: 48.0, height_m: 500.0, ..Fix::default() };
    let accel = |step: i64| [0.001 * (step % 7) as f64, 0.0, -9.81];
    // No attitude after the start: only the inertial step.
    let sample = |step: i64| ImuSample {
        time_ns: step * 10_000_000,
        has: if step < 300 { HOVERNAV_IMU_ATTITUDE } else { 0 },
        accel: accel(step),
        ..ImuSample::default()
    };
    let event = |step: i64| {
        Event::Imu(CoreSample {
            time: Time::from_nanoseconds(step * 10_000_000),
            motion: Motion::Rates {
                angular_rate_radps: Vector::ZERO,
                specific_force_mps2: accel(step).into(),
            },
            attitude: (step < 300).then_some(EulerAngles::default()),
            magnetic_field_gauss: None,
            clipped: hovernav::imu::ImuAxes::NONE,
        })
    };
    let home = hovernav::earth::Geodetic::from_degrees(48.0, 0.0, 500.0).expect("a place");
    for step in 0..300 {
        let time_ns = step * 10_000_000;
        // SAFETY: an object and valid pointers.
        unsafe { hovernav_push_imu(nav, &sample(step)) };
        without.0.push(&event(step), |_| {});
        if step % 10 == 0 {
            // SAFETY: an object and valid pointers.
            unsafe { hovernav_push_fix(nav, &Fix { time_ns, ..fix }) };
            let core = hovernav::gps::Fix::at(Time::from_nanoseconds(time_ns), home);
            without.0.push(&Event::Gps(core), |_| {});
        }
    }

    // Not inlined into the loop, as for a call from another program; the same for Rust.
    let push_imu: unsafe extern "C" fn(_, _) -> _ = black_box(hovernav_push_imu);
    let get_solution: unsafe extern "C" fn(_, _) -> _ = black_box(hovernav_get_solution);
    let solve_without: fn(&Estimator) -> Option<Solution> =
        black_box(|estimator| estimator.solution().as_ref().map(Solution::from));
    // All processing of a sample by the object.
    let push_without: fn(&mut (Estimator, HealthMonitor, SteplessSolution), &Event) =
        black_box(|(estimator, monitor, stepless), event| {
            monitor.observe(event);
            estimator.push_traced(event, stepless, |notice| {
                monitor.observe_notice(&notice);
                black_box(notice);
            });
        });
    let (mut push, mut solve) = ([f64::INFINITY; 2], [f64::INFINITY; 2]);
    let (mut covariance, mut version) = (f64::INFINITY, f64::INFINITY);
    let mut place = MaybeUninit::<Solution>::uninit();
    let mut matrix = [0.0; HOVERNAV_COVARIANCE];
    for round in 0..ROUNDS {
        let first = 300 + i64::from(round * CALLS);
        let steps = first..first + i64::from(CALLS);
        // One fix per round keeps both near the ground.
        let time_ns = (first - 1) * 10_000_000;
        // SAFETY: an object and valid pointers.
        unsafe { hovernav_push_fix(nav, &Fix { time_ns, ..fix }) };
        let core = hovernav::gps::Fix::at(Time::from_nanoseconds(time_ns), home);
        without.0.push(&Event::Gps(core), |_| {});
        least(&mut push[0], || {
            // SAFETY: an object and valid pointers.
            steps.clone().for_each(|step| unsafe {
                black_box(push_imu(black_box(nav), &sample(step)));
            });
        });
        least(&mut push[1], || {
            steps.for_each(|step| {
                push_without(black_box(&mut without), &event(step));
            });
        });
        least(&mut solve[0], || {
            // SAFETY: an object and valid pointers.
            (0..CALLS).for_each(|_| unsafe {
                get_solution(black_box(nav), place.as_mut_ptr());
                black_box(&place);
            });
        });
        least(&mut solve[1], || {
            (0..CALLS).for_each(|_| {
                black_box(solve_without(black_box(&without.0)));
            });
        });
        least(&mut covariance, || {
            // SAFETY: an object and valid pointers.
            (0..CALLS).for_each(|_| unsafe {
                hovernav_get_covariance(black_box(nav), matrix.as_mut_ptr());
                black_box(&matrix);
            });
        });
        least(&mut version, || {
            (0..CALLS).for_each(|_| {
                black_box(hovernav_check_abi(black_box(HOVERNAV_ABI)));
            });
        });
    }
    // SAFETY: written by the first call that returned a solution.
    let height_m = unsafe { read(place.as_ptr()) }.height_m;
    println!("at a height of {height_m:.1} m, least of {ROUNDS} rounds of {CALLS} calls:");
    for (name, [c, rust]) in [("push_imu", push), ("get_solution", solve)] {
        println!("{name}: {c:.1} ns through C, {rust:.1} ns without, {:+.1} ns", c - rust);
    }
    println!("get_covariance: {covariance:.1} ns, check_abi (an empty call): {version:.1} ns");
}
