//! A rangefinder and a second antenna. They help where no other sensor does, their one-sigmas are right, and their
//! faults do no harm.

use hovernav::earth::Geodetic;
use hovernav::ekf::{
    Aid, AntennaHeadingModel, Channel, EkfConfig, Estimator, EstimatorConfig, FullEkf, Notice,
    Rangefinder, Unusable, Verdict,
};
use hovernav::event::{Event, RangeReading};
use hovernav::frames::{EulerAngles, Rotation, Vector};
use hovernav::gps::{AntennaHeading, Fix};
use hovernav::imu::{ImuSample, Motion};
use hovernav::ins::{HeadingSource, Mounting, NavState, Start};
use hovernav::time::Time;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const PERIOD_S: f64 = 0.02;
const GRAVITY_MPS2: f64 = 9.808;
/// Height of the start above the ground, m.
const HEIGHT_M: f64 = 6.0;

fn place() -> Geodetic {
    Geodetic::from_degrees(48.1, 11.6, 500.0).unwrap()
}

fn normal(noise: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(noise)
}

fn start(heading_rad: f64, heading_sigma_rad: f64) -> Start {
    Start {
        state: NavState {
            time: Time::ZERO,
            position: place(),
            velocity_mps: Vector::ZERO,
            body_to_ned: Rotation::from_euler(EulerAngles {
                yaw_rad: heading_rad,
                ..EulerAngles::default()
            }),
        },
        attitude_sigma_rad: Vector::new(0.005, 0.005, heading_sigma_rad),
        velocity_sigma_mps: Vector::new(0.1, 0.1, 0.1),
        position_sigma_m: Vector::new(0.5, 0.5, 0.5),
        gyro_bias_radps: Vector::ZERO,
        gyro_bias_sigma_radps: Some(5e-4),
    }
}

/// A vehicle that hovers, moves up and down by half a metre, and turns about its vertical axis.
struct Hover {
    noise: ChaCha8Rng,
    accel_bias_mps2: f64,
    gyro_bias_radps: f64,
}

impl Hover {
    fn new(seed: u64) -> Self {
        let mut noise = ChaCha8Rng::seed_from_u64(seed);
        let accel_bias_mps2 = 0.05 * normal(&mut noise);
        let gyro_bias_radps = 5e-4 * normal(&mut noise);
        Self { noise, accel_bias_mps2, gyro_bias_radps }
    }

    /// Height above the start, m, its rate and its second derivative.
    fn bob(seconds: f64) -> [f64; 3] {
        let (size_m, rate) = (0.5, 0.7);
        let (sin, cos) = (rate * seconds).sin_cos();
        [size_m * (1.0 - cos), size_m * rate * sin, size_m * rate * rate * cos]
    }

    fn heading(seconds: f64) -> [f64; 2] {
        [0.4 * (0.2 * seconds).sin(), 0.08 * (0.2 * seconds).cos()]
    }

    fn sample(&mut self, seconds: f64) -> ImuSample {
        let mut white = |size: f64| size * normal(&mut self.noise) / PERIOD_S.sqrt();
        // Includes the rotation of the Earth.
        let earth = 7.292e-5 * [place().latitude_rad.cos(), -place().latitude_rad.sin()][1];
        let rates = Vector::new(white(5e-4), white(5e-4), white(5e-4));
        let forces = Vector::new(white(0.01), white(0.01), white(0.01));
        let turning =
            Vector::new(0.0, 0.0, Self::heading(seconds)[1] + earth + self.gyro_bias_radps);
        let down = -GRAVITY_MPS2 - Self::bob(seconds)[2] + self.accel_bias_mps2;
        ImuSample::new(
            Time::ZERO + seconds,
            Motion::Rates {
                angular_rate_radps: rates + turning,
                specific_force_mps2: forces + Vector::new(0.0, 0.0, down),
            },
        )
    }
}

/// A minute without fixes, with a rangefinder at 20 Hz that reads `range_m(seconds, true height)`. Returns the largest
/// height error, m, the final one-sigma, and the rejected readings.
fn without_fixes(
    seed: u64,
    mut range_m: impl FnMut(f64, f64, f64) -> Option<f64>,
) -> (f64, f64, usize, FullEkf) {
    let mut hover = Hover::new(seed);
    let mut filter = FullEkf::new(EkfConfig::default(), Mounting::default(), start(0.0, 0.02));
    let rangefinder = Rangefinder::default();
    let (mut worst_m, mut refused): (f64, usize) = (0.0, 0);
    for step in 1..=3000u32 {
        let seconds = f64::from(step) * PERIOD_S;
        filter.predict(&hover.sample(seconds)).unwrap();
        let up_m = Hover::bob(seconds)[0];
        let time = filter.state().time;
        if step <= 250 && step % 10 == 0 {
            let fix = Fix {
                horizontal_velocity_mps: Some([0.0, 0.0]),
                down_velocity_mps: Some(-Hover::bob(seconds)[1]),
                ..Fix::at(time, place().displaced(Vector::new(0.0, 0.0, -up_m)))
            };
            filter.update_gps(&fix).unwrap();
        }
        if step % 2 == 0
            && let Some(range_m) = range_m(seconds, HEIGHT_M + up_m, normal(&mut hover.noise))
        {
            let reading = RangeReading::new(time, range_m);
            let report = filter.update_range(&reading, &rangefinder, &mut ());
            refused += usize::from(report.is_err() || report.unwrap().any_rejected());
        }
        let off_m = filter.state().position.height_m - place().height_m - up_m;
        worst_m = worst_m.max(off_m.abs());
    }
    let sigma_m = filter.covariance().variance(8).sqrt();
    (worst_m, sigma_m, refused, filter)
}

/// White noise as in the model.
fn measured(height_m: f64, normal: f64) -> f64 {
    height_m + normal * (0.05f64.powi(2) + (0.01 * height_m).powi(2)).sqrt()
}

#[test]
fn without_fixes_a_rangefinder_holds_the_height() {
    let (mut with, mut without): (f64, f64) = (0.0, 0.0);
    for seed in 0..10 {
        let (worst_m, sigma_m, ..) =
            without_fixes(seed, |_, height_m, n| Some(measured(height_m, n)));
        with = with.max(worst_m);
        assert!(sigma_m < 1.5, "seed {seed}: {sigma_m}");
        without = without.max(without_fixes(seed, |_, _, _| None).0);
    }
    println!("worst height error in 55 s without fixes: {with:.2} m with, {without:.1} m without");
    assert!(with < 3.0, "{with}");
    assert!(without > 4.0 * with, "{without}");
}

#[test]
fn a_roof_and_a_tree_are_ground_and_no_height() {
    // A roof 3 m high from 20 to 35 s, and a tree for half a second.
    let roof = |seconds: f64| (20.0..35.0).contains(&seconds) || (45.0..45.5).contains(&seconds);
    for seed in 0..10 {
        let (plain_m, ..) = without_fixes(seed, |_, height_m, n| Some(measured(height_m, n)));
        let (worst_m, _, refused, filter) = without_fixes(seed, |seconds, height_m, n| {
            Some(measured(height_m - if roof(seconds) { 3.0 } else { 0.0 }, n))
        });
        println!(
            "seed {seed}: {worst_m:.2} m with the roof, {plain_m:.2} m without; {refused} refused"
        );
        assert!(worst_m < plain_m + 0.8, "seed {seed}: {worst_m} m, without {plain_m} m");
        assert!((40..=110).contains(&refused), "{refused}");
        // After the roof the estimate of the ground height is the original one.
        let ground_m = filter.parameter(27);
        assert!(ground_m.abs() < 1.0, "{ground_m}");
    }
}

#[test]
fn outliers_are_refused_and_the_ground_stays_what_it_was() {
    for seed in 0..5 {
        let mut count = 0;
        let (plain_m, ..) = without_fixes(seed, |_, height_m, n| Some(measured(height_m, n)));
        let (worst_m, ..) = without_fixes(seed, |_, height_m, n| {
            count += 1;
            Some(if count % 7 == 0 { 0.3 * height_m } else { measured(height_m, n) })
        });
        assert!(worst_m < plain_m + 0.3, "seed {seed}: {worst_m} m, without {plain_m} m");
    }
}

#[test]
fn readings_that_cannot_be_are_not_used_and_say_why() {
    let mut filter = FullEkf::new(EkfConfig::default(), Mounting::default(), start(0.0, 0.02));
    let mut hover = Hover::new(1);
    filter.predict(&hover.sample(PERIOD_S)).unwrap();
    let rangefinder = Rangefinder::default();
    let time = filter.state().time;
    let mut why = |reading: RangeReading| filter.update_range(&reading, &rangefinder, &mut ());
    let reading = |range_m| RangeReading::new(time, range_m);
    for range_m in [f64::NAN, f64::INFINITY, 1e300, -1.0] {
        assert_eq!(why(reading(range_m)), Err(Unusable::NotFinite));
    }
    assert_eq!(why(reading(0.0)), Err(Unusable::OutOfRange));
    assert_eq!(why(reading(130.0)), Err(Unusable::OutOfRange));
    assert_eq!(why(RangeReading { quality: Some(0.0), ..reading(5.0) }), Err(Unusable::OutOfRange));
    let late = RangeReading::new(time + -3.0, 5.0);
    assert_eq!(why(late), Err(Unusable::TooOld));
    assert!(why(RangeReading { quality: Some(0.9), ..reading(5.0) }).unwrap().any_accepted());
}

#[test]
fn a_stuck_reading_of_a_vehicle_that_moves_is_not_used() {
    let mut hover = Hover::new(3);
    let mut filter = FullEkf::new(EkfConfig::default(), Mounting::default(), start(0.0, 0.02));
    let rangefinder = Rangefinder::default();
    let (mut used_late, mut stuck) = (0, 0);
    for step in 1..=1000u32 {
        let seconds = f64::from(step) * PERIOD_S;
        let mut sample = hover.sample(seconds);
        if let Motion::Rates { specific_force_mps2, .. } = &mut sample.motion {
            // The vehicle accelerates to the north.
            *specific_force_mps2 += Vector::new(0.5, 0.0, 0.0);
        }
        filter.predict(&sample).unwrap();
        let reading = RangeReading::new(filter.state().time, 6.0);
        match filter.update_range(&reading, &rangefinder, &mut ()) {
            Err(Unusable::Stuck) => stuck += 1,
            Ok(_) if seconds > 3.0 => used_late += 1,
            _ => {}
        }
    }
    assert!(stuck > 800, "{stuck}");
    assert_eq!(used_late, 0);
}

#[test]
fn the_innovations_of_a_rangefinder_are_as_large_as_it_expects() {
    let (mut sum, mut count) = (0.0, 0.0);
    for seed in 100..130 {
        let mut hover = Hover::new(seed);
        let mut filter = FullEkf::new(EkfConfig::default(), Mounting::default(), start(0.0, 0.02));
        for step in 1..=1500u32 {
            let seconds = f64::from(step) * PERIOD_S;
            filter.predict(&hover.sample(seconds)).unwrap();
            if step % 5 != 0 {
                continue;
            }
            let height_m = HEIGHT_M + Hover::bob(seconds)[0];
            let range_m = measured(height_m, normal(&mut hover.noise));
            let reading = RangeReading::new(filter.state().time, range_m);
            let report = filter.update_range(&reading, &Rangefinder::default(), &mut ()).unwrap();
            for axis in report.innovations().filter(|_| step > 100) {
                assert_eq!((axis.channel, axis.verdict), (Channel::Range, Verdict::Accepted));
                sum += axis.normalised().powi(2);
                count += 1.0;
            }
        }
    }
    let mean = sum / count;
    println!("normalised innovation squared {mean:.3} over {count} readings");
    assert!((0.75..1.15).contains(&mean), "{mean}");
}

/// Two minutes with a second antenna at 5 Hz whose heading has the error `off_rad(seconds)`. Returns the squared
/// normalised heading errors, the last error, and the rejections.
fn with_antennas(seed: u64, off_rad: impl Fn(f64) -> f64) -> (Vec<f64>, f64, Vec<Unusable>) {
    let mut hover = Hover::new(seed);
    let off = 0.05 * normal(&mut hover.noise);
    let mut filter = FullEkf::new(EkfConfig::default(), Mounting::default(), start(off, 0.05));
    let model = AntennaHeadingModel::default();
    let sigma_rad = model.sigma_rad;
    let baseline = Vector::new(-0.8, 0.3, 0.0);
    let mounted_rad = 0.3f64.atan2(-0.8);
    let step_s = 0.2;
    let share = (-step_s / model.wander_time_s).exp();
    let wander_rad = model.wander_share * sigma_rad;
    let white_rad = (sigma_rad * sigma_rad - wander_rad * wander_rad).sqrt();
    let mut slow_rad = wander_rad * normal(&mut hover.noise);
    let (mut errors, mut last_rad, mut why) = (Vec::new(), 0.0, Vec::new());
    for step in 1..=6000u32 {
        let seconds = f64::from(step) * PERIOD_S;
        filter.predict(&hover.sample(seconds)).unwrap();
        let heading_rad = Hover::heading(seconds)[0];
        if step % 10 == 0 {
            let [a, b] = [normal(&mut hover.noise), normal(&mut hover.noise)];
            slow_rad = share * slow_rad + wander_rad * (1.0 - share * share).sqrt() * a;
            let said = heading_rad + mounted_rad + slow_rad + white_rad * b + off_rad(seconds);
            let reading = AntennaHeading::new(filter.state().time, said, Some(sigma_rad));
            let result = filter.update_antenna_heading(&reading, Some(baseline), &model, &mut ());
            why.extend(result.err());
        }
        last_rad = filter.state().body_to_ned.euler().yaw_rad - heading_rad;
        if step > 500 && step % 50 == 0 {
            errors.push(last_rad * last_rad / filter.covariance().variance(2));
        }
    }
    (errors, last_rad, why)
}

#[test]
fn a_heading_of_two_antennas_is_as_sure_as_it_is_right() {
    let runs = (0..40).map(|seed| with_antennas(seed, |_| 0.0));
    let (mut all, mut worst_rad): (Vec<f64>, f64) = (Vec::new(), 0.0);
    for (errors, last_rad, why) in runs {
        all.extend(errors);
        worst_rad = worst_rad.max(last_rad.abs());
        assert!(why.is_empty());
    }
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    println!("normalised error squared {mean:.3}, worst {:.2}°", worst_rad.to_degrees());
    assert!((0.5..1.3).contains(&mean), "{mean}");
    assert!(worst_rad < 0.02, "{worst_rad}");
}

#[test]
fn a_heading_that_points_backwards_or_jumps_is_refused() {
    // First the antennas are exchanged permanently after a minute; then a wrong ambiguity of 20° lasts 40 s.
    let half = core::f64::consts::PI;
    let (_, last_rad, why) = with_antennas(7, |seconds| if seconds > 60.0 { half } else { 0.0 });
    assert!(why.len() > 290 && why.iter().all(|why| *why == Unusable::BaselineReversed), "{why:?}");
    assert!(last_rad.abs() < 0.05, "{last_rad}");
    let jump = |seconds: f64| if (60.0..100.0).contains(&seconds) { 0.35 } else { 0.0 };
    let (_, last_rad, _) = with_antennas(8, jump);
    assert!(last_rad.abs() < 0.02, "{last_rad}");
}

#[test]
fn antennas_that_are_not_so_far_apart_have_a_wrong_ambiguity() {
    let mut filter = FullEkf::new(EkfConfig::default(), Mounting::default(), start(0.0, 0.05));
    filter.predict(&Hover::new(1).sample(PERIOD_S)).unwrap();
    let (time, baseline) = (filter.state().time, Some(Vector::new(1.2, 0.0, 0.0)));
    let model = AntennaHeadingModel::default();
    let mut update = |length_m, heading_rad| {
        let heading = AntennaHeading::new(time, heading_rad, Some(0.01));
        let reading = AntennaHeading { length_m: Some(length_m), ..heading };
        filter.update_antenna_heading(&reading, baseline, &model, &mut ())
    };
    assert_eq!(update(1.45, 0.0), Err(Unusable::WrongBaseline));
    assert_eq!(update(1.2, f64::NAN), Err(Unusable::NotFinite));
    assert_eq!(update(1e300, 0.0), Err(Unusable::NotFinite));
    assert!(update(1.25, 0.0).unwrap().any_accepted());
    assert_eq!(update(1.25, 0.0), Err(Unusable::TooSoon));
}

/// An estimator at rest whose only heading is from two antennas, from `from_s` on, and its notices.
fn estimator_at_rest(from_s: f64) -> (Estimator, Vec<Notice>) {
    let mut config = EstimatorConfig::default();
    config.alignment.baseline_m = Some(Vector::new(0.0, 1.0, 0.0));
    let mut estimator = Estimator::new(config);
    let (mut hover, mut notices) = (Hover::new(5), Vec::new());
    for step in 1..=1500u32 {
        let seconds = f64::from(step) * PERIOD_S;
        let sample = hover.sample(0.0);
        let still = ImuSample { time: Time::ZERO + seconds, ..sample };
        let mut push = |event| estimator.push(&event, |notice| notices.push(notice));
        push(Event::Imu(still));
        if step % 10 == 0 && seconds >= from_s {
            // The second antenna is on the right: the nose points to 70°.
            let heading_rad = 160f64.to_radians() + Hover::heading(0.0)[1] * seconds;
            push(Event::AntennaHeading(AntennaHeading::new(still.time, heading_rad, None)));
        }
        if step % 50 == 0 {
            push(Event::Gps(Fix::at(still.time, place())));
        }
    }
    (estimator, notices)
}

#[test]
fn two_antennas_give_the_first_heading() {
    let (estimator, notices) = estimator_at_rest(0.0);
    let aligned = notices.iter().find_map(|notice| match notice {
        Notice::Aligned(alignment) => Some(alignment.heading),
        _ => None,
    });
    assert_eq!(aligned, Some(HeadingSource::SecondAntenna));
    let yaw_rad = estimator.solution().unwrap().body_to_ned.euler().yaw_rad;
    let turned_rad = Hover::heading(0.0)[1] * 30.0;
    let off = hovernav::frames::wrap_angle(yaw_rad - turned_rad - 70f64.to_radians());
    assert!(off.abs() < 0.05, "{off}");
}

#[test]
fn two_antennas_end_the_search_for_a_heading() {
    let (estimator, notices) = estimator_at_rest(10.0);
    let at = |wanted: fn(&Notice) -> bool| notices.iter().position(wanted);
    let searching = |notice: &Notice| matches!(notice, Notice::Aligned(by) if by.heading == HeadingSource::Unknown);
    assert!(at(searching) < at(|notice| matches!(notice, Notice::HeadingFound { .. })));
    let refused = notices
        .iter()
        .any(|notice| matches!(notice, Notice::NotUsed { aid: Aid::SecondAntenna, .. }));
    assert!(!refused);
    let solution = estimator.solution().unwrap();
    assert!(solution.attitude_sigma_rad[2] < 0.05);
    let turned_rad = Hover::heading(0.0)[1] * 30.0;
    let yaw_rad = solution.body_to_ned.euler().yaw_rad;
    let off = hovernav::frames::wrap_angle(yaw_rad - turned_rad - 70f64.to_radians());
    assert!(off.abs() < 0.05, "{off}");
}
