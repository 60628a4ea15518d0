//! A car without fixes. The wheel constraint holds it to its road and releases it when it leaves the road, and its
//! one-sigmas are right.

use core::f64::consts::{FRAC_PI_2, PI};

use hovernav::earth::Geodetic;
use hovernav::ekf::layout::{Full, Layout, WithoutHeightAids};
use hovernav::ekf::{Channel, Notice, VehicleKind};
use hovernav::event::Event;
use hovernav::frames::Vector;
use hovernav_sim::{FlightPlan, GpsConfig, Leg};

use crate::unaided::driven_unaided;

/// Time of the last fix, s.
const LOST_S: f64 = 240.0;
/// Length of the outage, s.
const OUTAGE_S: f64 = 30.0;

/// A leg of a vehicle without bank and climb.
fn flat(duration_s: f64, forward_mps2: f64, yaw_rate_radps: f64) -> Leg {
    Leg {
        duration_s,
        acceleration_mps2: Vector::new(forward_mps2, 0.0, 0.0),
        yaw_rate_radps,
        roll_rad: 0.0,
        pitch_rad: 0.0,
    }
}

/// A flat turn by about `angle_rad`.
fn corner(plan: FlightPlan, angle_rad: f64) -> FlightPlan {
    let rate_radps = 0.3 * angle_rad.signum();
    plan.then(flat(1.0, 0.0, rate_radps))
        .then(flat(angle_rad.abs() / 0.3 - 1.0, 0.0, rate_radps))
        .then(flat(1.0, 0.0, 0.0))
}

/// Rests, sets off, and drives around town blocks for at least the given time, s.
fn drive(seconds: f64) -> FlightPlan {
    let place = Geodetic::from_degrees(40.1, -105.1, 1600.0).unwrap();
    let mut plan = FlightPlan::hover_at(place, 0.7)
        .hold(20.0)
        .then(flat(2.0, 2.0, 0.0))
        .then(flat(4.0, 2.0, 0.0))
        .then(flat(2.0, 0.0, 0.0));
    for block in 0.. {
        if plan.duration_s() > seconds {
            break;
        }
        let angle_rad = [FRAC_PI_2, FRAC_PI_2, -FRAC_PI_2, PI, -FRAC_PI_2][block % 5];
        plan = corner(plan.then(flat(6.0, 0.0, 0.0)), angle_rad);
    }
    plan
}

struct Outcome {
    /// Time at which the filter found that the vehicle is on wheels, s.
    on_s: Option<f64>,
    /// Time at which the filter found that it is no longer on wheels, s.
    off_s: Option<f64>,
    /// Horizontal error at the end of the outage, m.
    drift_m: f64,
    /// Horizontal one-sigma at the end of the outage, m.
    sigma_m: f64,
    /// Error of the velocity downwards at the end of the outage, m/s.
    down_mps: f64,
    /// One-sigma of the velocity downwards at the end of the outage, m/s.
    down_sigma_mps: f64,
    /// Number of wheel constraints applied.
    held: usize,
}

fn driven<L: Layout<N>, const N: usize>(plan: &FlightPlan, seed: u64) -> Outcome {
    lost_at::<L, N>(LOST_S, plan, seed, None)
}

fn lost_at<L: Layout<N>, const N: usize>(
    lost_s: f64,
    plan: &FlightPlan,
    seed: u64,
    kind: Option<VehicleKind>,
) -> Outcome {
    let gps = GpsConfig { rate_hz: 4.0, ..GpsConfig::default() };
    let (recording, mut estimator) = driven_unaided::<L, N>(plan, &gps, seed, kind);
    let (mut on_s, mut off_s, mut held) = (None, None, 0);
    let mut fixes = recording.fixes.iter().peekable();
    let mut outcome = None;
    for (sample, truth) in recording.imu.iter().zip(&recording.truth) {
        let mut notify = |notice| match notice {
            Notice::WheelConstraintOn { time, .. } => {
                on_s.get_or_insert(time.seconds());
            }
            Notice::WheelConstraintOff { time } => off_s = Some(time.seconds()),
            Notice::Updated(report) => {
                held += usize::from(
                    report.innovations().any(|one| one.channel == Channel::WheelsRight),
                );
            }
            _ => {}
        };
        let seconds = sample.time.seconds();
        while let Some(fix) = fixes.next_if(|fix| fix.time <= sample.time) {
            if seconds < lost_s {
                estimator.push(&Event::Gps(*fix), &mut notify);
            }
        }
        estimator.push(&Event::Imu(*sample), &mut notify);
        if seconds >= lost_s + OUTAGE_S {
            let solution = estimator.solution().unwrap();
            let off = solution.position.displacement_from(&truth.position);
            let sigma = solution.position_sigma_m;
            outcome = Some(Outcome {
                on_s,
                off_s,
                drift_m: off.x().hypot(off.y()),
                sigma_m: sigma.x().hypot(sigma.y()),
                down_mps: solution.velocity_mps.z() - truth.velocity_mps.z(),
                down_sigma_mps: solution.velocity_sigma_mps.z(),
                held,
            });
            break;
        }
    }
    outcome.unwrap()
}

#[test]
fn a_car_without_fixes_drifts_by_a_third_of_what_it_would_and_knows_by_how_much() {
    let plan = drive(LOST_S + 60.0);
    let (mut held_m, mut free_m) = (0.0, 0.0);
    for seed in 0..4 {
        let held = driven::<Full, 28>(&plan, seed);
        let free = driven::<WithoutHeightAids, 26>(&plan, seed);
        println!(
            "seed {seed}: on wheels at {:?} s, drift {:.1} m ± {:.1}, held {} times; not held {:.1} m ± {:.1}",
            held.on_s, held.drift_m, held.sigma_m, held.held, free.drift_m, free.sigma_m
        );
        assert!(held.on_s.is_some() && held.off_s.is_none() && free.on_s.is_none());
        assert!(held.held > 100 && free.held == 0);
        assert!(held.drift_m < 3.0 * held.sigma_m && held.sigma_m < free.sigma_m / 2.0);
        (held_m, free_m) = (held_m + held.drift_m, free_m + free.drift_m);
    }
    assert!(held_m < free_m / 3.0, "{held_m} {free_m}");
}

#[test]
fn a_declared_car_is_held_to_its_road_from_the_first_minute() {
    let lost_s = 70.0;
    let plan = drive(lost_s + 60.0);
    let (mut declared_m, mut unstated_m) = (0.0, 0.0);
    for seed in 0..6 {
        let of = |kind| lost_at::<Full, 28>(lost_s, &plan, seed, kind);
        let (declared, unstated) = (of(Some(VehicleKind::Wheeled)), of(None));
        let flies = of(Some(VehicleKind::Helicopter));
        println!(
            "seed {seed}: drift {:.1} m ± {:.1}, unstated {:.1} m ± {:.1}",
            declared.drift_m, declared.sigma_m, unstated.drift_m, unstated.sigma_m
        );
        assert!(declared.held > 100 && unstated.held == 0 && flies.held == 0);
        assert!(declared.drift_m < 3.0 * declared.sigma_m);
        (declared_m, unstated_m) = (declared_m + declared.drift_m, unstated_m + unstated.drift_m);
    }
    assert!(declared_m < unstated_m / 2.0, "{declared_m} {unstated_m}");
}

#[test]
fn what_takes_off_from_its_road_without_fixes_is_let_go_and_its_one_sigma_opens() {
    let plan = drive(LOST_S).climb(50.0, 3.0).hold(60.0);
    for seed in 0..4 {
        let off = driven::<Full, 28>(&plan, seed);
        println!(
            "seed {seed}: off its wheels at {:?} s, velocity down off by {:.2} m/s, sigma {:.2}",
            off.off_s, off.down_mps, off.down_sigma_mps
        );
        assert!(off.off_s.is_some_and(|off_s| off_s > LOST_S && off_s < LOST_S + 20.0));
        assert!(off.down_mps.abs() < 3.0 * off.down_sigma_mps);
    }
}
