//! Tests that every detectable error of a caller returns its code and changes nothing.

use std::ffi::CStr;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};

use hovernav_c::settings::*;
use hovernav_c::*;

/// Memory for an object, correctly aligned.
#[repr(align(16))]
struct Memory([MaybeUninit<u8>; HOVERNAV_SIZE + 16]);

impl Memory {
    fn new() -> Box<Self> {
        Box::new(Self([MaybeUninit::new(0xA5); HOVERNAV_SIZE + 16]))
    }

    fn at(&mut self, offset: usize) -> *mut core::ffi::c_void {
        (&raw mut self.0).wrapping_byte_add(offset).cast()
    }
}

fn config() -> Config {
    let mut config = MaybeUninit::uninit();
    // SAFETY: room for a configuration.
    let status = unsafe { hovernav_default_config(config.as_mut_ptr(), HOVERNAV_ABI) };
    assert_eq!(status, Status::Ok);
    // SAFETY: written, because the status is success.
    unsafe { config.assume_init() }
}

fn create(memory: &mut Memory) -> *mut Hovernav {
    let mut nav = null_mut();
    // SAFETY: memory of the given size.
    let status = unsafe {
        hovernav_create(memory.at(0), HOVERNAV_SIZE, &config(), null_mut(), &raw mut nav)
    };
    assert_eq!(status, Status::Ok);
    nav
}

fn text(of: &[core::ffi::c_char]) -> &str {
    // SAFETY: a text of this library ends with a zero byte.
    unsafe { CStr::from_ptr(of.as_ptr()) }.to_str().unwrap()
}

#[test]
fn sizes_are_what_the_header_says() {
    println!("{} bytes, aligned to {}", hovernav_size(), hovernav_alignment());
    assert!(hovernav_size() <= HOVERNAV_SIZE && hovernav_alignment() <= HOVERNAV_ALIGNMENT);
}

#[test]
fn another_version_of_the_header_is_refused_before_anything_is_written() {
    assert_eq!(hovernav_check_abi(HOVERNAV_ABI), Status::Ok);
    assert_eq!(hovernav_check_abi(HOVERNAV_ABI + 1), Status::AbiMismatch);
    // SAFETY: the version is checked first.
    unsafe {
        assert_eq!(hovernav_default_config(null_mut(), 0), Status::AbiMismatch);
        assert_eq!(hovernav_default_lines_config(null_mut(), 0), Status::AbiMismatch);
        let status = hovernav_default_autopilot_config(null_mut(), 0.03, null(), 0);
        assert_eq!(status, Status::AbiMismatch);
    }
}

#[test]
fn creation_finds_null_small_and_misaligned_memory() {
    let (mut memory, config) = (Memory::new(), config());
    let mut nav = null_mut();
    let place = memory.at(0);
    let place_off = memory.at(1);
    let size = hovernav_size();
    // SAFETY: every pointer is null or valid; the errors are detected.
    unsafe {
        let fault = null_mut();
        let created = &raw mut nav;
        let create = |memory, size, config: *const Config, created| {
            hovernav_create(memory, size, config, fault, created)
        };
        assert_eq!(create(null_mut(), size, &config, created), Status::NullPointer);
        assert_eq!(create(place, size, null(), created), Status::NullPointer);
        assert_eq!(create(place, size, &config, null_mut()), Status::NullPointer);
        assert_eq!(create(place_off, size, &config, created), Status::Misaligned);
        assert_eq!(create(place, size - 1, &config, created), Status::MemoryTooSmall);
        assert!(nav.is_null());
        assert_eq!(create(place, size, &config, created), Status::Ok);
        assert_eq!(nav.cast(), place);
    }
}

#[test]
fn an_object_is_made_in_its_memory_and_never_stands_on_the_stack_as_a_whole() {
    let mut memory = Memory::new();
    // A thread that needs more than this stack ends the process.
    let little = std::thread::Builder::new().stack_size(16 << 10);
    std::thread::scope(|scope| {
        let made = little.spawn_scoped(scope, || create(&mut memory).is_null()).unwrap();
        assert!(!made.join().unwrap());
    });
    assert!(hovernav_size() > 16 << 10);
}

#[test]
fn a_wrong_setting_is_named_with_what_was_found_and_expected() {
    let mut wrong = config();
    wrong.imu.gap_s = -1.0;
    let mut fault = MaybeUninit::<Fault>::uninit();
    // SAFETY: valid pointers.
    unsafe {
        assert_eq!(hovernav_check_config(&wrong, null_mut()), Status::OutOfRange);
        assert_eq!(hovernav_check_config(&wrong, fault.as_mut_ptr()), Status::OutOfRange);
    }
    // SAFETY: written.
    let fault = unsafe { fault.assume_init() };
    assert_eq!(text(&fault.what), "imu.gap_s");
    assert_eq!(fault.found, -1.0);
    assert_eq!(text(&fault.expected), "0 to 1e9");

    let mut many = [config(); 6];
    many[0].alignment.heading = 17;
    many[1].use_baro = 2;
    many[2].antenna_lever_arm_m[1] = f64::NAN;
    many[3].alignment.duration_s = f64::INFINITY;
    many[4].health.age_s = 0.0;
    many[5].gate.sigmas = f64::NAN;
    for config in &many {
        // SAFETY: valid pointers.
        assert_eq!(unsafe { hovernav_check_config(config, null_mut()) }, Status::OutOfRange);
    }
}

#[test]
fn what_is_no_object_is_refused_by_every_function() {
    let mut memory = Memory::new();
    let uncreated: *mut Hovernav = memory.at(0).cast();
    let misaligned: *mut Hovernav = memory.at(4).cast();
    let mut ended_memory = Memory::new();
    let ended = create(&mut ended_memory);
    // SAFETY: an object; afterwards none.
    unsafe {
        assert_eq!(hovernav_destroy(ended), Status::Ok);
        assert_eq!(hovernav_destroy(ended), Status::NotCreated);
        assert_eq!(hovernav_destroy(null_mut()), Status::Ok);
    }
    let expected = [
        (null_mut(), Status::NullPointer),
        (misaligned, Status::Misaligned),
        (uncreated, Status::NotCreated),
        (ended, Status::NotCreated),
    ];
    let (sample, fix) = (ImuSample::default(), Fix::default());
    let field = [0.2, 0.0, 0.4];
    let mut covariance = [0.0; HOVERNAV_COVARIANCE];
    let mut solution = MaybeUninit::uninit();
    let mut health = MaybeUninit::uninit();
    let mut notice = MaybeUninit::uninit();
    let mut outputs = MaybeUninit::uninit();
    let mut result = MaybeUninit::uninit();
    let mut lost = 0;
    let inputs = AutopilotInputs { now_ns: 0, has_pilot: 0, engage: 0, pilot: Sticks::default() };
    for (nav, status) in expected {
        // SAFETY: memory without an object is readable, or detected by its address.
        let answers = unsafe {
            [
                hovernav_push_imu(nav, &sample),
                hovernav_push_fix(nav, &fix),
                hovernav_push_baro(nav, 0, 0.0),
                hovernav_push_range(nav, 0, 1.0, f64::NAN, f64::NAN),
                hovernav_push_antenna_heading(nav, 0, 1.0, f64::NAN, f64::NAN),
                hovernav_push_magnetometer(nav, 0, field.as_ptr()),
                hovernav_push_rotor_speed(nav, 20.0),
                hovernav_get_solution(nav, solution.as_mut_ptr()),
                hovernav_get_covariance(nav, covariance.as_mut_ptr()),
                hovernav_get_health(nav, 0, health.as_mut_ptr()),
                hovernav_next_notice(nav, notice.as_mut_ptr()),
                hovernav_lost_notices(nav, &raw mut lost),
                hovernav_step_autopilot(nav, &inputs, outputs.as_mut_ptr()),
                hovernav_set(nav, &SetPoint::default()),
                hovernav_push_dmu_bytes(nav, null(), 0, 0, result.as_mut_ptr()),
                hovernav_push_gps_bytes(nav, null(), 0, 0, result.as_mut_ptr()),
            ]
        };
        assert_eq!(answers, [status; 16]);
    }
}

#[test]
fn null_values_unknown_flags_and_no_place_on_earth_are_refused() {
    let mut memory = Memory::new();
    let nav = create(&mut memory);
    let nowhere = Fix { latitude_deg: 99.0, ..Fix::default() };
    let flags = ImuSample { has: 8, ..ImuSample::default() };
    let fix_flags = Fix { has: 32, ..Fix::default() };
    // SAFETY: an object, and pointers that are null or valid.
    unsafe {
        assert_eq!(hovernav_push_imu(nav, null()), Status::NullPointer);
        assert_eq!(hovernav_push_fix(nav, null()), Status::NullPointer);
        assert_eq!(hovernav_push_magnetometer(nav, 0, null()), Status::NullPointer);
        assert_eq!(hovernav_get_solution(nav, null_mut()), Status::NullPointer);
        assert_eq!(hovernav_push_imu(nav, &flags), Status::UnknownCode);
        assert_eq!(hovernav_push_fix(nav, &fix_flags), Status::UnknownCode);
        assert_eq!(hovernav_push_fix(nav, &nowhere), Status::OutOfRange);
        let off = (&raw const nowhere).wrapping_byte_add(4);
        assert_eq!(hovernav_push_fix(nav, off), Status::Misaligned);
    }
}

#[test]
fn what_is_not_there_yet_is_said_so() {
    let mut memory = Memory::new();
    let nav = create(&mut memory);
    let mut solution = MaybeUninit::uninit();
    let mut notice = MaybeUninit::uninit();
    let mut covariance = [0.0; HOVERNAV_COVARIANCE];
    let mut outputs = MaybeUninit::uninit();
    let mut result = MaybeUninit::uninit();
    let inputs = AutopilotInputs { now_ns: 0, has_pilot: 0, engage: 0, pilot: Sticks::default() };
    // SAFETY: an object and valid pointers.
    unsafe {
        assert_eq!(hovernav_get_solution(nav, solution.as_mut_ptr()), Status::NotYet);
        assert_eq!(hovernav_get_covariance(nav, covariance.as_mut_ptr()), Status::NotYet);
        assert_eq!(hovernav_next_notice(nav, notice.as_mut_ptr()), Status::NotYet);
        let status = hovernav_step_autopilot(nav, &inputs, outputs.as_mut_ptr());
        assert_eq!(status, Status::NoAutopilot);
        assert_eq!(hovernav_set(nav, &SetPoint::default()), Status::NoAutopilot);
        assert_eq!(hovernav_push_rotor_speed(nav, 20.0), Status::NoNotch);
        let status = hovernav_push_gps_bytes(nav, null(), 0, 0, result.as_mut_ptr());
        assert_eq!(status, Status::NoLines);
    }
}

#[test]
fn gains_and_lines_that_cannot_be_are_named() {
    let mut memory = Memory::new();
    let nav = create(&mut memory);
    let core = hovernav::autopilot::HoverConfig::new(0.03, hovernav::autopilot::Gains::default());
    let mut autopilot = AutopilotConfig::of(&core);
    autopilot.gains.heave.tracking_time_s = 1.0;
    let mut fault = MaybeUninit::<Fault>::uninit();
    // SAFETY: an object and valid pointers.
    unsafe {
        assert_eq!(hovernav_start_autopilot(nav, &autopilot, null_mut()), Status::Ok);
        autopilot.gains.roll_pitch.measured[1][3] = f64::NAN;
        let status = hovernav_start_autopilot(nav, &autopilot, fault.as_mut_ptr());
        assert_eq!(status, Status::OutOfRange);
        assert_eq!(text(&fault.assume_init_ref().what), "gains.roll_pitch");
        // The previous autopilot stays active.
        assert_eq!(hovernav_set(nav, &SetPoint::default()), Status::Ok);
        let fast =
            SetPoint { kind: HOVERNAV_SET_POINT_VELOCITY, forward_mps: 1e3, ..SetPoint::default() };
        assert_eq!(hovernav_set(nav, &fast), Status::SetPointRefused);
        assert_eq!(hovernav_set(nav, &SetPoint { kind: 9, ..fast }), Status::UnknownCode);

        let mut lines = MaybeUninit::uninit();
        hovernav_default_lines_config(lines.as_mut_ptr(), HOVERNAV_ABI);
        let lines: LinesConfig = lines.assume_init();
        for (wrong, what) in [
            (LinesConfig { gps_protocol: 4, ..lines }, "gps_protocol"),
            (LinesConfig { dmu_mode: 0, ..lines }, "dmu_mode"),
            (LinesConfig { gps_rate_hz: 11, ..lines }, "gps_rate_hz"),
            (LinesConfig { accel_signs: [1, 0, 1], ..lines }, "accel_signs"),
            (LinesConfig { accel_range_g: f64::NAN, ..lines }, "accel_range_g"),
        ] {
            let status = hovernav_start_lines(nav, &wrong, 0, fault.as_mut_ptr());
            assert_eq!(status, Status::OutOfRange);
            assert_eq!(text(&fault.assume_init_ref().what), what);
        }
        assert_eq!(hovernav_start_lines(nav, &lines, 0, null_mut()), Status::Ok);
    }
}

#[test]
fn every_status_has_a_text_of_its_own() {
    let text = |status: i32| {
        // SAFETY: a text of this library ends with a zero byte.
        unsafe { CStr::from_ptr(hovernav_status_text(status)) }.to_str().unwrap()
    };
    let mut texts: Vec<&str> = (-12..=1).map(text).collect();
    texts.sort_unstable();
    texts.dedup();
    assert_eq!(texts.len(), 14, "{texts:?}");
    assert_eq!(text(77), "an unknown status");
    assert_eq!(text(i32::MIN), "an unknown status");
}

#[test]
fn notices_that_nobody_reads_give_way_and_are_counted() {
    let mut memory = Memory::new();
    let nav = create(&mut memory);
    let fix = Fix { latitude_deg: 48.0, height_m: 500.0, ..Fix::default() };
    let mut lost = 0;
    // SAFETY: an object and valid pointers.
    unsafe {
        for step in 0..500_i64 {
            let sample = ImuSample {
                time_ns: step * 10_000_000,
                has: HOVERNAV_IMU_ATTITUDE,
                accel: [0.001 * (step % 7) as f64, 0.0, -9.8],
                ..ImuSample::default()
            };
            assert_eq!(hovernav_push_imu(nav, &sample), Status::Ok);
            if step % 10 == 0 {
                let time_ns = sample.time_ns;
                assert_eq!(hovernav_push_fix(nav, &Fix { time_ns, ..fix }), Status::Ok);
            }
        }
        assert_eq!(hovernav_lost_notices(nav, &raw mut lost), Status::Ok);
        let mut notice = MaybeUninit::<Notice>::uninit();
        let mut read = 0;
        while hovernav_next_notice(nav, notice.as_mut_ptr()) == Status::Ok {
            read += 1;
        }
        assert_eq!(read, 12);
        // The newest notices are kept.
        assert!(notice.assume_init_ref().time_ns > 4_900_000_000);
    }
    assert!(lost > 20, "{lost}");
}

#[test]
fn accelerations_in_g_are_named() {
    let mut memory = Memory::new();
    let nav = create(&mut memory);
    let mut suspects = Vec::new();
    for step in 0..600_i64 {
        let sample = ImuSample {
            time_ns: step * 20_000_000,
            accel: [0.0, 0.0, -1.0],
            ..ImuSample::default()
        };
        let mut notice = MaybeUninit::<Notice>::uninit();
        // SAFETY: an object, a sample, and room for a notice, which is read where one was written.
        unsafe {
            assert_eq!(hovernav_push_imu(nav, &sample), Status::Ok);
            while hovernav_next_notice(nav, notice.as_mut_ptr()) == Status::Ok {
                suspects.push(notice.assume_init());
            }
        }
    }
    suspects.retain(|notice| notice.kind == NoticeKind::SetupSuspect);
    let [suspect] = suspects[..] else { panic!("{suspects:?}") };
    assert_eq!((suspect.value, suspect.sigma), (f64::from(SetupFault::ForceInG as u32), 1.0));
    let text = |fault: u32| {
        // SAFETY: the text is static and ends with a zero byte.
        unsafe { CStr::from_ptr(hovernav_setup_fault_text(fault)) }.to_str().unwrap()
    };
    assert_eq!(text(suspect.value as u32), "accelerations in g, expected m/s^2");
    assert_eq!(text(99), "a mistake unknown to this version");
    let mut texts: Vec<&str> = (0..14).map(text).collect();
    texts.sort_unstable();
    texts.dedup();
    assert_eq!(texts.len(), 14);
}
