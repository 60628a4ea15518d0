//! A sensor of the caller: its readings give the same bits as in Rust, and invalid readings are reported.

use std::ffi::c_void;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use hovernav::earth::Geodetic;
use hovernav::ekf::{self, Estimator, EstimatorConfig, Measurement, Rows};
use hovernav::event::Event;
use hovernav::frames::{Body, EulerAngles, Vector};
use hovernav::health::HealthLimits;
use hovernav::imu::ImuSample as CoreSample;
use hovernav::time::Time;
use hovernav_c::settings::Config;
use hovernav_c::*;

const ARM_M: [f64; 3] = [0.3, -0.1, 0.2];

/// Sensor of forward speed and pitch rate, in Rust.
struct Speed(f64);

impl Measurement for Speed {
    fn compare(&self, expected: &ekf::Expected, rows: &mut Rows) {
        let forward = Vector::new(1.0, 0.0, 0.0);
        let row = ekf::Row::new(self.0 - expected.velocity_body_mps().x(), 0.05);
        rows.push(row.with_velocity_body(expected, forward));
        let row = ekf::Row::new(-expected.angular_rate_radps.y(), 0.02);
        rows.push(row.with_angular_rate(Vector::new(0.0, 1.0, 0.0)));
    }

    fn lever_arm_m(&self) -> Vector<Body> {
        ARM_M.into()
    }
}

/// The sensor of forward speed and pitch rate, in C; the context is the speed.
unsafe extern "C" fn speed(expected: *const Expected, rows: *mut Row, context: *mut c_void) -> u32 {
    // SAFETY: the context of this test is a number.
    let speed_mps = unsafe { *context.cast::<f64>() };
    // SAFETY: the interface passes a motion.
    let expected = unsafe { *expected };
    // SAFETY: the interface passes room for six rows, all zero.
    let rows = unsafe { std::slice::from_raw_parts_mut(rows, HOVERNAV_ROWS) };
    rows[0].residual = speed_mps - expected.velocity_body_mps[0];
    rows[0].sigma = 0.05;
    rows[0].by_velocity_body[0] = 1.0;
    rows[1].residual = -expected.angular_rate_radps[1];
    rows[1].sigma = 0.02;
    rows[1].by_angular_rate[1] = 1.0;
    2
}

unsafe extern "C" fn too_many(_: *const Expected, _: *mut Row, _: *mut c_void) -> u32 {
    u32::MAX
}

unsafe extern "C" fn none(_: *const Expected, _: *mut Row, _: *mut c_void) -> u32 {
    0
}

/// The status of a reading, and its notice.
fn measure(nav: *mut Hovernav, time: Time, sensor: &OwnSensor) -> (Status, Option<Notice>) {
    let mut notice = MaybeUninit::uninit();
    // SAFETY: an object, a sensor, and room for a notice.
    let status = unsafe {
        hovernav_measure(nav, time.nanoseconds(), &raw const *sensor, notice.as_mut_ptr())
    };
    // SAFETY: written if the status is success.
    (status, (status == Status::Ok).then(|| unsafe { notice.assume_init() }))
}

#[test]
fn a_sensor_of_the_caller_gives_the_bits_of_rust_and_wrong_readings_are_reported() {
    let config = Config::of(&EstimatorConfig::default(), None, &HealthLimits::default());
    let mut memory = vec![0_u128; HOVERNAV_SIZE / 16];
    let (place, mut nav) = (memory.as_mut_ptr().cast(), null_mut());
    // SAFETY: memory of the given size.
    let status = unsafe {
        hovernav_create(place, HOVERNAV_SIZE, &raw const config, null_mut(), &raw mut nav)
    };
    assert_eq!(status, Status::Ok);
    let mut in_rust = Estimator::new(EstimatorConfig::default());
    let home = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
    let mut speed_mps = 0.0_f64;
    let context = (&raw mut speed_mps).cast();
    let sensor = OwnSensor { compare: Some(speed), context, lever_arm_m: ARM_M };

    let (status, notice) = measure(nav, Time::ZERO, &sensor);
    assert_eq!(status, Status::Ok);
    let notice = notice.unwrap();
    assert_eq!((notice.kind, notice.aid), (NoticeKind::NotUsed, Aid::Own));
    assert_eq!(notice.reason, UnusedReason::NotAligned);

    let mut compared = 0;
    for cycle in 0..1000_u32 {
        let time = Time::from_seconds(f64::from(cycle) * 0.01);
        let accel = [0.01 * f64::from(cycle % 7), 0.0, -9.81];
        let sample = ImuSample {
            time_ns: time.nanoseconds(),
            has: HOVERNAV_IMU_ATTITUDE,
            accel,
            ..ImuSample::default()
        };
        let core = CoreSample::from_rates(time, Vector::ZERO, accel.into())
            .with_attitude(EulerAngles::default());
        // SAFETY: an object and a valid pointer.
        assert_eq!(unsafe { hovernav_push_imu(nav, &raw const sample) }, Status::Ok);
        in_rust.push(&Event::Imu(core), |_| {});
        if cycle % 100 == 50 {
            let fix = Fix {
                time_ns: time.nanoseconds(),
                latitude_deg: 48.0,
                longitude_deg: 11.0,
                height_m: 500.0,
                ..Fix::default()
            };
            // SAFETY: an object and a valid pointer.
            assert_eq!(unsafe { hovernav_push_fix(nav, &raw const fix) }, Status::Ok);
            in_rust.push(&Event::Gps(hovernav::gps::Fix::at(time, home)), |_| {});
        }
        if cycle % 20 == 0 {
            // Late by 0.1 s.
            let then = time + -0.1;
            let (status, notice) = measure(nav, then, &sensor);
            assert_eq!(status, Status::Ok);
            let expected = in_rust.update(&Speed(speed_mps), then);
            let notice = notice.unwrap();
            assert_eq!(notice.kind == NoticeKind::Updated, expected.is_ok(), "{notice:?}");
            if let Ok(report) = expected {
                compared += 1;
                assert_eq!((notice.axis_count, notice.axes[0].channel), (2, Channel::Own));
                let innovations = report.innovations().map(|axis| axis.innovation);
                assert!(innovations.zip(notice.axes).all(|(rust, c)| rust == c.innovation));
            }
        }
        let mut solution = MaybeUninit::uninit();
        // SAFETY: an object, and room for a solution.
        let status = unsafe { hovernav_get_solution(nav, solution.as_mut_ptr()) };
        let found = (status == Status::Ok).then(|| {
            // SAFETY: written, because the status is success.
            format!("{:?}", unsafe { solution.assume_init() })
        });
        let expected = in_rust.solution().map(|core| format!("{:?}", Solution::from(&core)));
        assert_eq!(found, expected, "cycle {cycle}");
    }
    assert!(compared > 30, "{compared}");

    let time = in_rust.solution().unwrap().time;
    for (compare, reason) in [
        (too_many as unsafe extern "C" fn(_, _, _) -> _, UnusedReason::NotFinite),
        (none, UnusedReason::OutOfRange),
    ] {
        let (status, notice) = measure(nav, time, &OwnSensor { compare: Some(compare), ..sensor });
        let notice = notice.unwrap();
        assert_eq!((status, notice.aid, notice.reason), (Status::Ok, Aid::Own, reason));
    }
    let (status, _) = measure(nav, time, &OwnSensor { compare: None, ..sensor });
    assert_eq!(status, Status::NullPointer);
    // SAFETY: an object, and pointers that are null or valid.
    unsafe {
        assert_eq!(hovernav_measure(nav, 0, null(), null_mut()), Status::NullPointer);
        assert_eq!(
            hovernav_measure(null_mut(), 0, &raw const sensor, null_mut()),
            Status::NullPointer
        );
        assert_eq!(
            hovernav_measure(nav, time.nanoseconds(), &raw const sensor, null_mut()),
            Status::Ok
        );
    }
}
