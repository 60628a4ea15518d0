//! For any readings, the filter keeps its good estimates, reports rejections, and recovers.

mod bad_input;
mod hostile_events;

use approx::assert_abs_diff_eq;
use hovernav::earth::Geodetic;
use hovernav::ekf::{
    Channel, Ekf, EkfConfig, FullEkf, ImuFault, Innovation, Prediction, Report, ResetCause,
    Verdict, layout,
};
use hovernav::frames::{EulerAngles, Ned, Rotation, Vector};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::ins::{Mounting, NavState, Start};
use hovernav::time::Time;

const PERIOD_S: f64 = 0.02;
const GRAVITY_MPS2: f64 = 9.806;

fn place() -> Geodetic {
    Geodetic::from_degrees(47.0, 8.0, 400.0).unwrap()
}

fn start() -> Start {
    Start {
        state: NavState {
            time: Time::ZERO,
            position: place(),
            velocity_mps: Vector::ZERO,
            body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(0.0, 0.0, 40.0)),
        },
        attitude_sigma_rad: Vector::new(0.01, 0.01, 0.05),
        velocity_sigma_mps: Vector::new(0.1, 0.1, 0.1),
        position_sigma_m: Vector::new(1.0, 1.0, 2.0),
        gyro_bias_radps: Vector::ZERO,
        gyro_bias_sigma_radps: None,
    }
}

fn still(time: Time) -> ImuSample {
    ImuSample::new(
        time,
        Motion::Rates {
            angular_rate_radps: Vector::ZERO,
            specific_force_mps2: Vector::new(0.0, 0.0, -GRAVITY_MPS2),
        },
    )
}

fn fix(time: Time, offset_m: Vector<Ned>) -> Fix {
    Fix {
        position_sigma_m: Some(Vector::new(1.0, 1.0, 2.0)),
        horizontal_velocity_mps: Some([0.0; 2]),
        down_velocity_mps: Some(0.0),
        velocity_sigma_mps: Some(Vector::new(0.1, 0.1, 0.2)),
        ..Fix::at(time, place().displaced(offset_m))
    }
}

/// A filter at rest, driven second by second.
struct Rest<L, const N: usize> {
    filter: Ekf<L, N>,
    second: u32,
}

impl<L: layout::Layout<N>, const N: usize> Rest<L, N> {
    fn new() -> Self {
        Self { filter: Ekf::new(EkfConfig::default(), Mounting::default(), start()), second: 0 }
    }

    /// Passes samples to the filter up to the next whole second.
    fn sit(&mut self) -> Time {
        for step in 1..=50 {
            let time = Time::ZERO + (f64::from(self.second) + f64::from(step) * PERIOD_S);
            self.filter.predict(&still(time)).unwrap();
        }
        self.second += 1;
        self.filter.state().time
    }

    /// Passes another second of samples to the filter, and the fix at its end.
    fn fix(&mut self, offset_m: Vector<Ned>) -> Report {
        let time = self.sit();
        self.filter.update_gps(&fix(time, offset_m)).unwrap()
    }

    fn off_m(&self, offset_m: Vector<Ned>) -> f64 {
        self.filter.state().position.displacement_from(&place().displaced(offset_m)).norm()
    }
}

type RestBase = Rest<layout::Base, 16>;

fn verdict(report: &Report, channel: Channel) -> Verdict {
    let of_channel = |axis: &&Innovation| axis.channel == channel;
    report.innovations().find(of_channel).unwrap().verdict
}

#[test]
fn one_bad_position_is_refused_by_axis_and_the_next_good_one_taken() {
    let mut rest = RestBase::new();
    for _ in 0..20 {
        assert!(!rest.fix(Vector::ZERO).any_rejected());
    }
    let glitch = rest.fix(Vector::new(200.0, 0.0, 0.0));
    assert_eq!(verdict(&glitch, Channel::PositionNorth), Verdict::Rejected);
    assert_eq!(verdict(&glitch, Channel::PositionEast), Verdict::Rejected);
    assert_eq!(verdict(&glitch, Channel::PositionDown), Verdict::Accepted);
    assert_eq!(verdict(&glitch, Channel::VelocityNorth), Verdict::Accepted);
    let innovation =
        glitch.innovations().find(|axis| axis.channel == Channel::PositionNorth).unwrap();
    assert_abs_diff_eq!(innovation.innovation, 200.0, epsilon = 5.0);
    assert!(rest.off_m(Vector::ZERO) < 1.0);
    let height = rest.fix(Vector::new(0.0, 0.0, -300.0));
    assert_eq!(verdict(&height, Channel::PositionDown), Verdict::Rejected);
    assert_eq!(verdict(&height, Channel::PositionNorth), Verdict::Accepted);
    let good = rest.fix(Vector::ZERO);
    assert!(good.innovations().all(|axis| axis.verdict == Verdict::Accepted));
    assert!(rest.off_m(Vector::ZERO) < 1.0);
}

#[test]
fn a_jump_that_stays_is_refused_at_first_and_then_followed_and_said_so() {
    let mut rest = RestBase::new();
    for _ in 0..40 {
        rest.fix(Vector::ZERO);
    }
    let there = Vector::new(60.0, -80.0, 0.0);
    let reopened_after = (0..60).position(|_| rest.fix(there).any_reset()).unwrap();
    assert_eq!(reopened_after, 30, "velocity agreed: the configured 30 s");
    assert!(rest.off_m(there) < 10.0, "{} m off", rest.off_m(there));
    // Neither hypothesis is confirmed: the one-sigma of the solution reaches back to the former position.
    let sigma_m = rest.filter.solution().position_sigma_m.to_array();
    assert!(sigma_m[..2].iter().all(|sigma_m| (99.0..110.0).contains(sigma_m)), "{sigma_m:?}");
    assert!(sigma_m[2] < 3.0, "{sigma_m:?}");
    for _ in 0..10 {
        assert!(!rest.fix(there).any_rejected());
    }
    assert!(rest.off_m(there) < 2.0, "{} m off", rest.off_m(there));
    assert!(rest.filter.is_healthy());
}

#[test]
fn the_position_of_a_start_is_as_uncertain_as_the_fixes_that_contradict_it() {
    let mut rest = RestBase::new();
    let truth = Vector::new(4000.0, -2500.0, 0.0);
    let assert_covered = |rest: &RestBase, truth: Vector<Ned>| {
        let sigma_m = rest.filter.solution().position_sigma_m;
        let off_m = rest.off_m(truth);
        assert!(off_m < 3.0 * sigma_m.x().hypot(sigma_m.y()), "{off_m} m off, {sigma_m:?}");
    };
    // The start is one of the random positions; none of the next thirty confirms it.
    for k in 0..30 {
        let [north_m, east_m] = [2.1, 3.7].map(|step| 5000.0 * (f64::from(k) * step).sin());
        rest.fix(truth + Vector::new(north_m, east_m, 0.0));
        assert_covered(&rest, truth);
    }
    for _ in 0..20 {
        rest.fix(truth);
        assert_covered(&rest, truth);
    }
    assert!(rest.off_m(truth) < 3.0, "{} m off", rest.off_m(truth));
}

#[test]
fn a_jump_away_from_a_place_reported_for_ten_seconds_is_followed_after_as_long() {
    let mut rest = RestBase::new();
    for _ in 0..10 {
        rest.fix(Vector::ZERO);
    }
    let there = Vector::new(60.0, -80.0, 0.0);
    let reopened_after = (0..60).position(|_| rest.fix(there).any_reset());
    assert_eq!(reopened_after, Some(9));
}

/// A fix with a horizontal part only: position and velocity.
fn moving(time: Time, offset_m: Vector<Ned>, velocity_mps: [f64; 2]) -> Fix {
    Fix { horizontal_velocity_mps: Some(velocity_mps), ..fix(time, offset_m) }
}

#[test]
fn a_position_and_velocity_that_both_jump_are_followed_after_eight_seconds() {
    let mut rest = RestBase::new();
    for _ in 0..20 {
        rest.fix(Vector::ZERO);
    }
    let reopened_after = (0..60).position(|second| {
        let time = rest.sit();
        let there = Vector::new(100.0 + 10.0 * f64::from(second), 0.0, 0.0);
        rest.filter.update_gps(&moving(time, there, [10.0, 0.0])).unwrap().any_reset()
    });
    assert_eq!(reopened_after, Some(8), "the configured 8 s after the first rejection");
}

#[test]
fn a_fix_without_a_height_is_taken_for_the_horizontal_alone() {
    let mut rest = RestBase::new();
    for _ in 0..5 {
        let time = rest.sit();
        let flat = Fix { two_dimensional: true, ..fix(time, Vector::new(0.3, 0.0, -500.0)) };
        let report = rest.filter.update_gps(&flat).unwrap();
        assert!(report.innovations().all(|axis| axis.verdict == Verdict::Accepted));
        assert_eq!(report.innovations().count(), 4);
    }
    assert!(rest.filter.state().position.displacement_from(&place()).x() > 0.05);
    assert_abs_diff_eq!(rest.filter.state().position.height_m, place().height_m, epsilon = 0.5);
}

/// A filter at rest with every state, a barometer at 25 Hz and fixes at 5 Hz, for some seconds from its start.
fn with_barometer(
    seconds: u32,
    fix_at: impl Fn(f64, Time) -> Fix,
    baro_m: impl Fn(f64) -> f64,
) -> FullEkf {
    let mut filter = FullEkf::new(EkfConfig::default(), Mounting::default(), start());
    for step in 1..=50 * seconds {
        let seconds = f64::from(step) * PERIOD_S;
        let time = Time::ZERO + seconds;
        filter.predict(&still(time)).unwrap();
        if step % 2 == 0 {
            // No reading equals the previous one to the last digit, because the filter ignores an equal reading.
            let height_m = baro_m(seconds) + 1e-3 * f64::from(step / 2 % 2);
            filter.update_baro(time, height_m, &mut ()).unwrap();
        }
        if step % 10 == 0 {
            filter.update_gps(&fix_at(seconds, time)).unwrap();
        }
    }
    filter
}

#[test]
fn a_height_that_drifts_away_with_its_own_velocity_is_refused_where_a_barometer_denies_it() {
    // From 60 s on the receiver reports an accelerating climb, up to 5 m/s, while the vehicle rests.
    let climbed_m = |seconds: f64| 0.5 * 0.2 * (seconds - 60.0).clamp(0.0, 25.0).powi(2);
    let filter = with_barometer(
        85,
        |seconds, time| Fix {
            down_velocity_mps: Some(-0.2 * (seconds - 60.0).clamp(0.0, 25.0)),
            ..fix(time, Vector::new(0.0, 0.0, -climbed_m(seconds)))
        },
        |_| 17.0,
    );
    let off_m = filter.state().position.height_m - place().height_m;
    // The limit contains 7.5 m: up to there the barometer's own drift explains the difference.
    assert!(off_m.abs() < 9.0, "{off_m} m of {} m", climbed_m(85.0));
}

#[test]
fn a_barometer_that_drifts_alone_is_no_witness_against_the_fixes() {
    let filter = with_barometer(
        120,
        |_, time| fix(time, Vector::ZERO),
        |seconds| 17.0 + 0.2 * (seconds - 60.0).max(0.0),
    );
    let off_m = filter.state().position.height_m - place().height_m;
    // The limit contains 7.5 m: up to there the barometer's own drift explains the difference.
    assert!(off_m.abs() < 9.0, "{off_m} m of 12 m");
}

#[test]
fn a_velocity_that_no_acceleration_explains_is_not_followed_while_it_lasts() {
    let mut filter = FullEkf::new(EkfConfig::default(), Mounting::default(), start());
    let mut fastest_mps: f64 = 0.0;
    for step in 1..=50 * 75 {
        let seconds = f64::from(step) * PERIOD_S;
        let time = Time::ZERO + seconds;
        filter.predict(&still(time)).unwrap();
        if step % 10 == 0 {
            let away = (60.0..70.0).contains(&seconds);
            let speed_mps = if away { 30.0 } else { 0.0 };
            let there_m = if away { 30.0 * (seconds - 60.0) } else { 0.0 };
            let fix = moving(time, Vector::new(there_m, 0.0, 0.0), [speed_mps, 0.0]);
            filter.update_gps(&fix).unwrap();
        }
        fastest_mps = fastest_mps.max(filter.state().velocity_mps.norm());
    }
    assert!(fastest_mps < 1.0, "{fastest_mps} m/s");
}

#[test]
fn a_filter_that_disagrees_after_an_outage_is_reopened_within_three_fixes() {
    let mut rest = RestBase::new();
    for _ in 0..20 {
        rest.fix(Vector::ZERO);
    }
    for _ in 0..20 {
        rest.sit();
    }
    let there = Vector::new(900.0, 0.0, 0.0);
    let reopened_after = (0..20).position(|_| rest.fix(there).any_reset()).unwrap();
    assert_eq!(reopened_after, 2);
    assert!(rest.off_m(there) < 30.0, "{} m off", rest.off_m(there));
}

#[test]
fn a_gap_is_coasted_over_with_velocity_kept_and_fixes_from_inside_taken_for_what_they_tell() {
    let mut start = start();
    start.state.velocity_mps = Vector::new(8.0, -3.0, 0.0);
    let mut filter = FullEkf::new(EkfConfig::default(), Mounting::default(), start);
    let sample = |seconds: f64| still(Time::ZERO + seconds);
    for step in 1..=50 {
        filter.predict(&sample(f64::from(step) * PERIOD_S)).unwrap();
    }
    // The inertial unit turns and accelerates at both ends; neither lasted for the three seconds between.
    let pushed = |seconds: f64| ImuSample {
        motion: Motion::Rates {
            angular_rate_radps: Vector::new(0.5, 0.2, -0.1 * seconds),
            specific_force_mps2: Vector::new(4.0, -3.0, -12.0),
        },
        ..sample(seconds)
    };
    filter.predict(&pushed(1.02)).unwrap();
    let before = *filter.state();
    let ended = filter.predict(&pushed(4.02)).unwrap();
    assert!(matches!(ended, Prediction::BridgedGap { .. }));
    let after = *filter.state();
    assert_eq!(after.velocity_mps, before.velocity_mps);
    let way = after.position.displacement_from(&before.position);
    assert!((way - before.velocity_mps * 3.0).norm() < 0.01);
    let turned = (after.body_to_ned * before.body_to_ned.inverse()).rotation_vector().norm();
    assert!(turned < 0.3, "{turned} rad");
    let sigma = filter.solution().velocity_sigma_mps.x();
    assert!((8.0..12.0).contains(&sigma), "{sigma} m/s after 3 s of 3 m/s²");

    // Half a second before the end of the gap, the vehicle was faster by three metres per second.
    let fix = moving(Time::ZERO + 3.52, way, [11.0, -3.0]);
    filter.update_gps(&fix).unwrap();
    let taken = filter.state().velocity_mps.x();
    let sigma = filter.solution().velocity_sigma_mps.x();
    assert!((10.0..11.2).contains(&taken), "{taken} m/s");
    assert!((1.0..2.5).contains(&sigma), "{sigma} m/s: half a second of 3 m/s² remain");
}

#[test]
fn a_magnetic_heading_moves_the_heading_and_leaves_roll_and_pitch() {
    let mut start = start();
    // The tilt is less accurate than the magnetometer: with the dip of the field, such a tilt error turns the heading
    // by 7°.
    start.attitude_sigma_rad = Vector::new(0.05, 0.05, 0.3);
    let mut filter = FullEkf::new(EkfConfig::default(), Mounting::default(), start);
    for step in 1..=500 {
        let time = Time::ZERO + f64::from(step) * PERIOD_S;
        filter.predict(&still(time)).unwrap();
        // The field has a dip of 69°, and its heading is wrong by 8°.
        let turned = Rotation::from_euler(EulerAngles::from_degrees(0.0, 0.0, 48.0));
        let field: Vector<Ned> = Vector::new(0.2, 0.0, 0.52);
        if step % 10 == 0 {
            filter.update_magnetic_heading(time, turned.inverse() * field, 0.0, &mut ()).unwrap();
        }
    }
    let angles = filter.state().body_to_ned.euler();
    assert!(angles.yaw_rad.to_degrees() > 43.0, "{}", angles.yaw_rad.to_degrees());
    // The first headings, 8° off, change a tilt known to 0.05 rad by a few 1e-4 rad.
    assert!(angles.roll_rad.abs() < 1e-3 && angles.pitch_rad.abs() < 1e-3, "{angles:?}");
}

#[test]
fn glitches_with_good_fixes_between_them_never_open_the_filter() {
    let mut rest = RestBase::new();
    for _ in 0..60 {
        assert!(!rest.fix(Vector::new(500.0, 0.0, 0.0)).any_reset());
        assert!(!rest.fix(Vector::ZERO).any_rejected());
    }
    assert!(rest.off_m(Vector::ZERO) < 1.0);
}

#[test]
fn a_gap_is_reported_and_paid_for_and_the_next_fixes_close_it() {
    for gap_s in [0.5, 5.0, 50.0, 5e6] {
        let mut rest = RestBase::new();
        for _ in 0..20 {
            rest.fix(Vector::ZERO);
        }
        let before = rest.filter.solution();
        let after = rest.filter.state().time + gap_s;
        let mut told = rest.filter.predict(&still(after));
        let mut after = after;
        if told == Err(ImuFault::FarAhead) {
            // The next sample confirms the time.
            after = after + PERIOD_S;
            told = rest.filter.predict(&still(after));
        }
        assert!(
            matches!(told, Ok(
                Prediction::BridgedGap { length_s }
                | Prediction::Reset(ResetCause::LongGap { length_s })
            ) if (length_s - gap_s).abs() < PERIOD_S + 1e-9 * gap_s),
            "{told:?} for {gap_s} s"
        );
        assert!(rest.filter.is_healthy());
        let opened = rest.filter.solution();
        assert!(opened.velocity_sigma_mps.x() > before.velocity_sigma_mps.x() + gap_s.min(10.0));
        for second in 0..40 {
            for step in 1..=50 {
                let time = after + (f64::from(second) + f64::from(step) * PERIOD_S);
                rest.filter.predict(&still(time)).unwrap();
            }
            let time = rest.filter.state().time;
            rest.filter.update_gps(&fix(time, Vector::ZERO)).unwrap();
        }
        assert!(rest.filter.is_healthy());
        assert!(
            rest.off_m(Vector::ZERO) < 5.0,
            "{} m off after {gap_s} s",
            rest.off_m(Vector::ZERO)
        );
        assert!(rest.filter.state().velocity_mps.norm() < 1.0);
    }
}
