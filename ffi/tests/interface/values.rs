//! Impossible values are rejected with a code or reported by a notice. After an impossible value the next valid value
//! is used.

use std::ffi::CStr;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use hovernav_c::settings::*;
use hovernav_c::*;

/// An object and its memory.
struct Navigator {
    _memory: Vec<u128>,
    nav: *mut Hovernav,
    now_ns: i64,
    samples: i64,
}

const PERIOD_NS: i64 = 30_000_000;

fn config() -> Config {
    let mut config = MaybeUninit::uninit();
    // SAFETY: room for a configuration.
    let status = unsafe { hovernav_default_config(config.as_mut_ptr(), HOVERNAV_ABI) };
    assert_eq!(status, Status::Ok);
    // SAFETY: written, because the status is success.
    unsafe { config.assume_init() }
}

impl Navigator {
    fn new(config: &Config) -> Self {
        let mut memory = vec![0_u128; HOVERNAV_SIZE / 16];
        let (mut nav, fault) = (null_mut(), null_mut());
        let place = memory.as_mut_ptr().cast();
        // SAFETY: memory of the given size.
        let status = unsafe { hovernav_create(place, HOVERNAV_SIZE, config, fault, &raw mut nav) };
        assert_eq!(status, Status::Ok);
        Self { _memory: memory, nav, now_ns: 0, samples: 0 }
    }

    /// An inertial sample of a vehicle at rest, at `time_ns`.
    fn push_imu(&mut self, time_ns: i64, has: u32) -> Status {
        self.samples += 1;
        let shake = 0.01 * (self.samples % 7) as f64;
        let accel = [shake, 0.0, -9.81];
        let sample = ImuSample { time_ns, has, accel, ..ImuSample::default() };
        // SAFETY: an object and a valid pointer.
        unsafe { hovernav_push_imu(self.nav, &sample) }
    }

    fn fix(&self) -> Fix {
        Fix {
            time_ns: self.now_ns,
            has: HOVERNAV_FIX_HORIZONTAL_VELOCITY | HOVERNAV_FIX_DOWN_VELOCITY,
            latitude_deg: 48.0,
            height_m: 500.0,
            ..Fix::default()
        }
    }

    fn push_fix(&mut self, fix: &Fix) -> Status {
        // SAFETY: an object and a valid pointer.
        unsafe { hovernav_push_fix(self.nav, fix) }
    }

    /// Feeds samples with their flags and a fix every 33 samples, for a number of cycles.
    fn stand(&mut self, cycles: u32, has: u32) {
        for cycle in 0..cycles {
            self.now_ns += PERIOD_NS;
            assert_eq!(self.push_imu(self.now_ns, has), Status::Ok);
            if cycle % 33 == 32 {
                assert_eq!(self.push_fix(&self.fix()), Status::Ok);
            }
            self.notices(|_| {});
        }
    }

    fn notices(&mut self, mut observe: impl FnMut(&Notice)) {
        let mut notice = MaybeUninit::uninit();
        // SAFETY: an object, and room for a notice.
        while unsafe { hovernav_next_notice(self.nav, notice.as_mut_ptr()) } == Status::Ok {
            // SAFETY: written, because the status is success.
            observe(unsafe { notice.assume_init_ref() });
        }
    }

    /// Reason why the last measurement or sample was not used, if any.
    fn reason(&mut self) -> UnusedReason {
        let mut reason = UnusedReason::None;
        self.notices(|notice| reason = notice.reason);
        reason
    }

    fn solution(&self) -> Option<Solution> {
        let mut solution = MaybeUninit::uninit();
        // SAFETY: an object, and room for a solution.
        let status = unsafe { hovernav_get_solution(self.nav, solution.as_mut_ptr()) };
        // SAFETY: written if the status is success.
        (status == Status::Ok).then(|| unsafe { solution.assume_init() })
    }
}

fn fault_of(config: &Config) -> (String, String) {
    let mut fault = MaybeUninit::<Fault>::uninit();
    // SAFETY: valid pointers.
    let status = unsafe { hovernav_check_config(config, fault.as_mut_ptr()) };
    assert_eq!(status, Status::OutOfRange);
    // SAFETY: written, because the status is success.
    let fault = unsafe { fault.assume_init() };
    let text = |of: &[core::ffi::c_char]| {
        // SAFETY: a text of this library ends with a zero byte.
        unsafe { CStr::from_ptr(of.as_ptr()) }.to_str().unwrap().to_owned()
    };
    (text(&fault.what), text(&fault.expected))
}

#[test]
fn a_place_for_the_fault_that_is_misaligned_is_found_by_every_function() {
    let mut room = [0_u64; 64];
    let fault = room.as_mut_ptr().wrapping_byte_add(1).cast::<Fault>();
    let config = config();
    let navigator = Navigator::new(&config);
    let core = hovernav::autopilot::HoverConfig::new(0.03, hovernav::autopilot::Gains::default());
    let autopilot = AutopilotConfig::of(&core);
    let mut lines = MaybeUninit::uninit();
    let mut memory = vec![0_u128; HOVERNAV_SIZE / 16];
    let mut nav = null_mut();
    let place = memory.as_mut_ptr().cast();
    // SAFETY: valid pointers except that of the fault, which is detected.
    unsafe {
        let _ = hovernav_default_lines_config(lines.as_mut_ptr(), HOVERNAV_ABI);
        let answers = [
            hovernav_create(place, HOVERNAV_SIZE, &config, fault, &raw mut nav),
            hovernav_check_config(&config, fault),
            hovernav_start_autopilot(navigator.nav, &autopilot, fault),
            hovernav_start_lines(navigator.nav, lines.as_ptr(), 0, fault),
        ];
        assert_eq!(answers, [Status::Misaligned; 4]);
    }
    assert_eq!(room, [0; 64]);
    assert!(nav.is_null());
}

const NO_NOTCH: &str = "1 to 4, or 0 and no frequency for no notch";

#[test]
fn a_setting_beyond_its_range_is_refused_with_the_range() {
    for (wrong, what, expected) in [
        (|config: &mut Config| config.gps.learning_rate = 1.5, "gps.learning_rate", "0 to 1"),
        // An alignment that never ends.
        (|config| config.alignment.duration_s = 1e6, "alignment.duration_s", "0.1 to 120"),
        (|config| config.gps.position_wander_share = 2.0, "gps.position_wander_share", "0 to 1"),
        (|config| config.gps.velocity_wander_share = 2.0, "gps.velocity_wander_share", "0 to 1"),
        (
            |config| config.second_antenna.model.wander_share = 2.0,
            "second_antenna.model.wander_share",
            "0 to 1",
        ),
        (
            |config| config.rangefinder.model.least_quality = 50.0,
            "rangefinder.model.least_quality",
            "0 to 1",
        ),
        (|config| config.notch.frequency_hz = 25.0, "notch.harmonics", NO_NOTCH),
        (|config| config.notch.harmonics = 5, "notch.harmonics", NO_NOTCH),
        (
            |config| (config.notch.harmonics, config.notch.frequency_hz) = (1, f64::NAN),
            "notch.frequency_hz",
            "0 to less than 10000 Hz",
        ),
        (
            |config| (config.notch.harmonics, config.notch.width_hz) = (1, 0.0),
            "notch.width_hz",
            "more than 0, less than 10000 Hz",
        ),
        // A one-sigma whose square is not finite.
        (
            |config| config.imu.gyro_bias_sigma_radps = 1e300,
            "imu.gyro_bias_sigma_radps",
            "0 to 1e9",
        ),
    ] as [(fn(&mut Config), _, _); 11]
    {
        let mut config = config();
        wrong(&mut config);
        assert_eq!(fault_of(&config), (what.to_owned(), expected.to_owned()));
    }
}

#[test]
fn what_alignment_cannot_use_is_reported() {
    let mut navigator = Navigator::new(&config());
    navigator.stand(32, 0);
    let now_ns = navigator.now_ns;
    let bad = ImuSample { time_ns: now_ns + 1, gyro: [f64::NAN, 0.0, 0.0], ..ImuSample::default() };
    // SAFETY: an object and a valid pointer.
    assert_eq!(unsafe { hovernav_push_imu(navigator.nav, &bad) }, Status::Ok);
    assert_eq!(navigator.reason(), UnusedReason::NotFinite);
    assert_eq!(navigator.push_imu(now_ns, 0), Status::Ok);
    assert_eq!(navigator.reason(), UnusedReason::NotLater);
    // The typical error of two clocks.
    for (late_ns, reason) in
        [(5_000_000_000, UnusedReason::TooOld), (-5_000_000_000, UnusedReason::AheadOfImu)]
    {
        let fix = Fix { time_ns: now_ns - late_ns, ..navigator.fix() };
        assert_eq!(navigator.push_fix(&fix), Status::Ok);
        assert_eq!(navigator.reason(), reason);
    }
    // Impossible readings of every other sensor. Possible readings cause no notice yet.
    let nav = navigator.nav;
    for value in [f64::NAN, f64::INFINITY, 1.0] {
        let reason = if value.is_finite() { UnusedReason::None } else { UnusedReason::NotFinite };
        let field = [value, 0.0, 0.4];
        let unknown = f64::NAN;
        // SAFETY: an object and valid pointers.
        unsafe {
            assert_eq!(hovernav_push_baro(nav, now_ns, value), Status::Ok);
            assert_eq!(navigator.reason(), reason);
            assert_eq!(hovernav_push_magnetometer(nav, now_ns, field.as_ptr()), Status::Ok);
            assert_eq!(navigator.reason(), reason);
            assert_eq!(hovernav_push_range(nav, now_ns, value, unknown, unknown), Status::Ok);
            assert_eq!(navigator.reason(), reason);
            let status = hovernav_push_antenna_heading(nav, now_ns, value, unknown, unknown);
            assert_eq!(status, Status::Ok);
            assert_eq!(navigator.reason(), reason);
        }
    }
    assert!(navigator.solution().is_none());
}

#[test]
fn a_clock_that_is_set_back_before_alignment_only_delays_it() {
    for wrong_ns in [i64::MAX, 3_600_000_000_000] {
        let mut navigator = Navigator::new(&config());
        assert_eq!(navigator.push_imu(wrong_ns, 0), Status::Ok);
        navigator.stand(100, HOVERNAV_IMU_ATTITUDE);
        assert!(navigator.solution().is_some());
    }
}

#[test]
fn alignment_ends_however_long_a_time_it_is_to_take() {
    let mut config = config();
    config.alignment.duration_s = 8.0;
    let mut navigator = Navigator::new(&config);
    navigator.stand(12 * 33, HOVERNAV_IMU_ATTITUDE);
    assert!(navigator.solution().is_some());
}

#[test]
fn a_reading_of_another_clock_is_reported_and_shuts_out_no_later_one() {
    let mut config = config();
    (config.use_attitude, config.use_magnetometer) = (0, 1);
    let mut navigator = Navigator::new(&config);
    navigator.stand(200, HOVERNAV_IMU_ATTITUDE);
    let field = [0.2, 0.0, 0.4];
    let nav = navigator.nav;
    for (time_ns, reason) in
        [(i64::MAX, UnusedReason::AheadOfImu), (i64::MIN, UnusedReason::TooOld)]
    {
        // SAFETY: an object and a valid pointer.
        unsafe {
            assert_eq!(hovernav_push_magnetometer(nav, time_ns, field.as_ptr()), Status::Ok);
            assert_eq!(navigator.reason(), reason);
            assert_eq!(hovernav_push_baro(nav, time_ns, 500.0), Status::Ok);
            assert_eq!(navigator.reason(), reason);
        }
    }
    navigator.stand(10, HOVERNAV_IMU_ATTITUDE);
    // SAFETY: an object and a valid pointer.
    unsafe {
        let time_ns = navigator.now_ns;
        assert_eq!(hovernav_push_magnetometer(nav, time_ns, field.as_ptr()), Status::Ok);
        assert_eq!(navigator.reason(), UnusedReason::None);
        assert_eq!(hovernav_push_baro(nav, time_ns, 500.0), Status::Ok);
        assert_eq!(navigator.reason(), UnusedReason::None);
    }
}

#[test]
fn a_quality_in_percent_is_no_quality() {
    let mut navigator = Navigator::new(&config());
    navigator.stand(200, HOVERNAV_IMU_ATTITUDE);
    for (quality, reason) in [(3.5, UnusedReason::NotFinite), (1.0, UnusedReason::None)] {
        let (nav, time_ns) = (navigator.nav, navigator.now_ns);
        // SAFETY: an object.
        let status = unsafe { hovernav_push_range(nav, time_ns, 2.0, f64::NAN, quality) };
        assert_eq!(status, Status::Ok);
        assert_eq!(navigator.reason(), reason);
    }
}

#[test]
fn bytes_that_cannot_be_are_refused_and_none_may_come_from_nowhere() {
    let navigator = Navigator::new(&config());
    let nav = navigator.nav;
    let mut lines = MaybeUninit::uninit();
    let mut result = MaybeUninit::uninit();
    let byte = 0_u8;
    // SAFETY: valid pointers, or detectable ones.
    unsafe {
        let _ = hovernav_default_lines_config(lines.as_mut_ptr(), HOVERNAV_ABI);
        let _ = hovernav_start_lines(nav, lines.as_ptr(), 0, null_mut());
        for (bytes, length, status) in [
            (null(), 0, Status::Ok),
            (null(), 1, Status::NullPointer),
            (&raw const byte, usize::MAX, Status::OutOfRange),
        ] {
            let result = result.as_mut_ptr();
            assert_eq!(hovernav_push_dmu_bytes(nav, bytes, length, 0, result), status);
            assert_eq!(hovernav_push_gps_bytes(nav, bytes, length, 0, result), status);
        }
    }
}

#[test]
fn a_time_of_minus_zero_is_one_of_zero() {
    let flown = |zero: f64| {
        let mut config = config();
        config.imu.gyro_bias_time_s = zero;
        config.imu.accel_bias_time_s = zero;
        config.gps.position_wander_time_s = zero;
        config.gps.velocity_wander_time_s = zero;
        config.attitude.wander_time_s = zero;
        config.magnetometer.wander_time_s = zero;
        let mut navigator = Navigator::new(&config);
        navigator.stand(200, HOVERNAV_IMU_ATTITUDE);
        navigator.solution().unwrap()
    };
    let (minus, plus) = (flown(-0.0), flown(0.0));
    assert!(minus.attitude_sigma_rad.iter().all(|sigma| sigma.is_finite()), "{minus:?}");
    assert_eq!(format!("{minus:?}"), format!("{plus:?}"));
}
