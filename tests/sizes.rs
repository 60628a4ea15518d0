//! Memory of an estimator on a flight computer: its own size, and the stack of its calls.

use std::hint::black_box;
use std::process::Command;

use hovernav::earth::Geodetic;
use hovernav::ekf::layout::{Base, Full, WithoutHeightAids};
use hovernav::ekf::{
    Estimator, EstimatorConfig, Expected, HeadingSearch, Measurement, NoHeadingSearch, Notice, Row,
    Rows,
};
use hovernav::event::{BaroReading, Event, MagneticReading, RangeReading};
use hovernav::frames::{EulerAngles, Rotation, Vector};
use hovernav::gps::{AntennaHeading, Fix};
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;

#[test]
fn an_estimator_takes_16_kb_and_with_the_search_for_a_heading_21_kb() {
    // The set-up check needs 600 bytes of each size.
    let sizes = [
        ("f64", size_of::<Estimator<Full, 28, f64, NoHeadingSearch>>(), 16_200),
        (
            "f64, no height aids",
            size_of::<Estimator<WithoutHeightAids, 26, f64, NoHeadingSearch>>(),
            15_300,
        ),
        ("f32", size_of::<Estimator<Full, 28, f32, NoHeadingSearch>>(), 10_200),
        ("base f32", size_of::<Estimator<Base, 16, f32, NoHeadingSearch>>(), 8_020),
        ("f64 and search", size_of::<Estimator<Full, 28, f64, HeadingSearch>>(), 21_100),
        ("f32 and search", size_of::<Estimator<Full, 28, f32, HeadingSearch<f32>>>(), 15_000),
    ];
    for (name, size, most) in sizes {
        println!("{name}: {size} bytes");
        assert!(size <= most, "{name}: {size} bytes");
    }
}

const PERIOD_S: f64 = 0.02;

/// A user's own sensor with the largest number of rows.
struct Own;

impl Measurement for Own {
    fn compare(&self, expected: &Expected, rows: &mut Rows) {
        for axis in [Vector::new(1.0, 0.0, 0.0), Vector::new(0.0, 1.0, 0.0)] {
            let velocity = Row::new(0.01, 0.5).with_velocity_body(expected, axis);
            rows.push(velocity);
            rows.push(Row::new(0.001, 0.1).with_angular_rate(axis));
            rows.push(Row::new(0.1, 5.0).with_position(expected.body_to_ned * axis));
        }
    }
}

/// A flight that uses all functions of an estimator. It aligns without a heading, circles at 10 m/s until the heading
/// is found, and continues with every aid, 3 000 samples in all. Returns whether the heading was found.
#[inline(never)]
fn fly(estimator: &mut Estimator, samples: u32) -> bool {
    let home = Geodetic::from_degrees(48.1, 11.6, 500.0).unwrap();
    let (speed_mps, turn_radps) = (10.0, 0.5);
    let mut found = false;
    for step in 0..samples {
        let seconds = f64::from(step) * PERIOD_S;
        let time = Time::ZERO + seconds;
        let (sin, cos) = (turn_radps * seconds).sin_cos();
        let angles = EulerAngles { yaw_rad: turn_radps * seconds, ..EulerAngles::default() };
        let body_to_ned = Rotation::from_euler(angles);
        let sample = ImuSample {
            attitude: found.then_some(angles),
            ..ImuSample::new(
                time,
                Motion::Rates {
                    angular_rate_radps: Vector::new(0.0, 0.0, turn_radps),
                    specific_force_mps2: Vector::new(0.0, speed_mps * turn_radps, -9.808),
                },
            )
        };
        let had_found = found;
        let notify = &mut |notice| found |= matches!(notice, Notice::HeadingFound { .. });
        estimator.push(&Event::Imu(sample), &mut *notify);
        if step % 10 == 0 {
            let radius_m = speed_mps / turn_radps;
            let off_m = Vector::new(radius_m * sin, radius_m * (1.0 - cos), 0.0);
            let fix = Fix {
                horizontal_velocity_mps: Some([speed_mps * cos, speed_mps * sin]),
                down_velocity_mps: Some(0.0),
                position_sigma_m: Some(Vector::new(0.5, 0.5, 1.0)),
                velocity_sigma_mps: Some(Vector::new(0.1, 0.1, 0.2)),
                ..Fix::at(time, home.displaced(off_m))
            };
            estimator.push(&Event::Gps(fix), &mut *notify);
            estimator.push(&Event::Baro(BaroReading::new(time, 520.0)), &mut *notify);
            let field_gauss = body_to_ned.inverse() * Vector::new(0.2, 0.0, 0.43);
            estimator
                .push(&Event::Magnetometer(MagneticReading::new(time, field_gauss)), &mut *notify);
            estimator.push(&Event::Range(RangeReading::new(time, 20.0)), &mut *notify);
            if had_found {
                black_box(estimator.update(&Own, time + -0.3).ok());
                let heading = AntennaHeading::new(time, turn_radps * seconds, None);
                estimator.push(&Event::AntennaHeading(heading), &mut *notify);
            }
        }
        black_box(estimator.solution());
    }
    found
}

/// An estimator with a search for its heading, on the heap.
fn estimator() -> Box<Estimator> {
    let mut config = EstimatorConfig::default();
    config.alignment.heading = Some(hovernav::ins::HeadingSource::Unknown);
    Box::new(Estimator::new(config))
}

#[test]
fn the_flight_finds_its_heading() {
    assert!(fly(&mut estimator(), 3_000));
}

/// Runs `run` below `ballast` stack frames; returns the stack used, bytes.
#[inline(never)]
fn beneath(ballast: usize, top: usize, run: &mut dyn FnMut()) -> usize {
    let block = black_box([0_u8; 64]);
    let here = (&raw const block).addr();
    let taken = if ballast == 0 {
        run();
        top.saturating_sub(here)
    } else {
        beneath(ballast - 1, top.max(here), run)
    };
    black_box(&block);
    taken
}

const STACK: usize = 64 * 1024;
const CASE: &str = "HOVERNAV_STACK_CASE";

/// The measurement runs in a child process: an overflow of its stack ends the child, not the test.
#[test]
fn child() {
    let Ok(case) = std::env::var(CASE) else { return };
    let (samples, ballast) = case.split_once(' ').unwrap();
    let (samples, ballast) = (samples.parse().unwrap(), ballast.parse().unwrap());
    let mut estimator = estimator();
    let thread = std::thread::Builder::new().stack_size(STACK).spawn(move || {
        beneath(ballast, 0, &mut || {
            black_box(fly(&mut estimator, samples));
        })
    });
    println!("took {}", thread.unwrap().join().unwrap());
}

/// Largest ballast, bytes, below which a child survives a flight of `samples`.
fn max_ballast(samples: u32) -> usize {
    let survives = |ballast: usize| {
        let output = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "child", "--nocapture"])
            .env(CASE, format!("{samples} {ballast}"))
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let (_, after) = text.split_once("took ")?;
        after.split_whitespace().next()?.parse::<usize>().ok().filter(|_| output.status.success())
    };
    let (mut below, mut above) = (0, STACK / 64);
    let mut most = survives(0).expect("without ballast there is room");
    while above - below > 1 {
        let middle = usize::midpoint(below, above);
        match survives(middle) {
            Some(taken) => (below, most) = (middle, taken),
            None => above = middle,
        }
    }
    most
}

#[test]
fn the_calls_of_an_estimator_take_8_kb_of_stack() {
    let stack = max_ballast(0) - max_ballast(3_000);
    println!("{stack} bytes of stack");
    assert!(stack <= 8 * 1024, "{stack} bytes of stack");
}
