//! The solution stays finite for any readings, in any order.

use hovernav::earth::Geodetic;
use hovernav::ekf::{Estimator, EstimatorConfig, Notice, Solution, layout};
use hovernav::event::{BaroReading, Event, MagneticReading, RangeReading};
use hovernav::frames::{EulerAngles, Ned, Vector};
use hovernav::gps::{AntennaHeading, Fix};
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;
use proptest::prelude::*;

use super::start;

fn is_finite(solution: &Solution) -> bool {
    solution.position.latitude_rad.is_finite()
        && solution.position.longitude_rad.is_finite()
        && solution.position.height_m.is_finite()
        && solution.velocity_mps.is_finite()
        && solution.body_to_ned.quaternion().is_finite()
        && solution.angular_rate_radps.is_finite()
        && solution.position_sigma_m.is_finite()
        && solution.velocity_sigma_mps.is_finite()
        && solution.attitude_sigma_rad.iter().all(|sigma| sigma.is_finite())
        && solution.gyro_bias_radps.is_finite()
        && solution.accel_bias_mps2.is_finite()
        && solution.gyro_bias_sigma_radps.is_finite()
        && solution.accel_bias_sigma_mps2.is_finite()
}

/// A value around `usual`, or an impossible one.
fn value(usual: f64, spread: f64) -> impl Strategy<Value = f64> + Clone {
    prop_oneof![
        24 => (usual - spread)..(usual + spread),
        1 => prop::sample::select(vec![
            f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 1e-300, 5e-324, 0.0, -0.0,
            1e4, -1e4, 1e5, 1e8, -1e8, 1e18,
        ]),
        1 => any::<f64>(),
    ]
}

fn vector<F: std::fmt::Debug>(usual: [f64; 3], spread: f64) -> impl Strategy<Value = Vector<F>> {
    usual.map(|usual| value(usual, spread)).prop_map(|[x, y, z]| Vector::new(x, y, z))
}

/// The next event, with the time since the previous one.
fn event() -> impl Strategy<Value = (f64, Event)> {
    let step = prop_oneof![
        40 => 0.0..0.05,
        1 => prop::sample::select(vec![0.0, -0.02, -1e6, 0.3, 20.0, 1e3, 1e6, 1e9, 1e300, 1e-9]),
    ];
    let attitude = vector::<Ned>([0.0; 3], 3.0).prop_map(|angles| {
        let [roll_rad, pitch_rad, yaw_rad] = angles.to_array();
        EulerAngles { roll_rad, pitch_rad, yaw_rad }
    });
    let motion = prop_oneof![
        8 => (vector([0.0; 3], 1.0), vector([0.0, 0.0, -9.8], 5.0)).prop_map(|(w, f)| {
            Motion::Rates { angular_rate_radps: w, specific_force_mps2: f }
        }),
        1 => (vector([0.0; 3], 0.05), vector([0.0, 0.0, -0.3], 0.3)).prop_map(|(w, f)| {
            Motion::Increments { angle_rad: w, velocity_mps: f }
        }),
    ];
    let imu = (
        motion,
        prop::option::weighted(0.2, attitude),
        prop::option::weighted(0.2, vector([0.2, 0.0, 0.4], 0.1)),
    )
        .prop_map(|(motion, attitude, magnetic_field_gauss)| {
            Event::Imu(ImuSample {
                attitude,
                magnetic_field_gauss,
                ..ImuSample::new(Time::ZERO, motion)
            })
        });
    let position = [value(0.82, 1e-6), value(0.14, 1e-6), value(400.0, 5.0)].prop_map(|place| {
        let [latitude_rad, longitude_rad, height_m] = place;
        Geodetic { latitude_rad, longitude_rad, height_m }
    });
    let gps = (
        position,
        prop::option::of(vector([1.0; 3], 0.9)),
        prop::option::of([value(0.0, 2.0), value(0.0, 2.0)]),
        prop::option::of(value(0.0, 1.0)),
        prop::option::of(vector([0.2; 3], 0.15)),
    )
        .prop_map(|(position, position_sigma, horizontal, down, velocity_sigma)| {
            Event::Gps(Fix {
                position_sigma_m: position_sigma,
                horizontal_velocity_mps: horizontal,
                down_velocity_mps: down,
                velocity_sigma_mps: velocity_sigma,
                ..Fix::at(Time::ZERO, position)
            })
        });
    let other = prop_oneof![
        value(400.0, 3.0).prop_map(|height_m| Event::Baro(BaroReading::new(Time::ZERO, height_m))),
        vector([0.2, 0.0, 0.4], 0.1).prop_map(|field_gauss| Event::Magnetometer(
            MagneticReading::new(Time::ZERO, field_gauss)
        )),
        (value(5.0, 3.0), prop::option::of(value(0.05, 0.04)))
            .prop_map(|(range_m, sigma_m)| RangeReading {
                sigma_m,
                ..RangeReading::new(Time::ZERO, range_m)
            })
            .prop_map(Event::Range),
        (value(1.0, 3.0), prop::option::of(value(0.01, 0.01)))
            .prop_map(|(heading, sigma)| AntennaHeading::new(Time::ZERO, heading, sigma))
            .prop_map(Event::AntennaHeading),
    ];
    (step, prop_oneof![12 => imu, 4 => gps, 2 => other])
}

fn at(event: Event, time: Time) -> Event {
    match event {
        Event::Imu(sample) => Event::Imu(ImuSample { time, ..sample }),
        Event::Gps(fix) => Event::Gps(Fix { time, ..fix }),
        Event::Baro(BaroReading { height_m, .. }) => Event::Baro(BaroReading::new(time, height_m)),
        Event::Magnetometer(MagneticReading { field_gauss, .. }) => {
            Event::Magnetometer(MagneticReading::new(time, field_gauss))
        }
        Event::Range(reading) => Event::Range(RangeReading { time, ..reading }),
        Event::AntennaHeading(heading) => Event::AntennaHeading(AntennaHeading { time, ..heading }),
    }
}

fn is_sound(notice: &Notice) -> bool {
    match notice {
        Notice::Updated(report) => report
            .innovations()
            .all(|axis| axis.innovation.is_finite() && axis.sigma.is_finite() && axis.sigma >= 0.0),
        Notice::HeadingFound { sigma_rad, .. } => sigma_rad.is_finite(),
        _ => true,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn no_stream_of_events_makes_a_solution_that_is_not_a_number(
        heading_known: bool,
        events in prop::collection::vec(event(), 1..600),
    ) {
        let mut config = EstimatorConfig::default();
        config.alignment.duration_s = 0.1;
        let mut estimator = Estimator::<layout::Full, 28>::new(config);
        if heading_known {
            estimator.begin_at(&start());
        }
        let mut time = Time::ZERO;
        for (step_s, event) in events {
            // Times that jump back do not recover by themselves: the next event continues from the present time.
            let then = time + step_s;
            time = if step_s.abs() > 1e6 { time } else { then };
            let mut unsound = None;
            estimator.push(&at(event, then), |notice| {
                if !is_sound(&notice) {
                    unsound = Some(notice);
                }
            });
            prop_assert!(unsound.is_none(), "{unsound:?}");
            if let Some(solution) = estimator.solution() {
                prop_assert!(is_finite(&solution), "{solution:?}");
            }
            if let Some(filter) = estimator.filter() {
                let variances: Vec<f64> = (0..28).map(|k| filter.covariance().variance(k)).collect();
                prop_assert!(filter.is_healthy(), "{:?} {variances:?}", filter.state());
            }
        }
    }
}
