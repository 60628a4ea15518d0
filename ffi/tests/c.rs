//! The examples in C and C++, built by the compilers of the machine, run by themselves, under valgrind
//! and with sanitizers.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use hovernav::ekf::Estimator;
use hovernav::event::Event;
use hovernav_c::Solution;
use hovernav_log::Dataset;

/// What Rust's standard library needs of the system, in the static library.
const SYSTEM: [&str; 3] = ["-lpthread", "-ldl", "-lm"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

/// Where cargo put the library that this test is linked with.
fn libraries() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().to_path_buf()
}

fn found(program: &str) -> bool {
    let there = Command::new(program).arg("--version").output().is_ok();
    if !there {
        println!("skipped: {program} is not installed");
    }
    there
}

fn text(output: &Output) -> String {
    assert!(
        output.status.success(),
        "{}: {}{}",
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Builds `source` with every warning an error; `None` where the compiler is missing.
fn build(source: &str, more: &[&str], place: &Path) -> Option<PathBuf> {
    let (compiler, standard) =
        if source.ends_with(".c") { ("gcc", "-std=c11") } else { ("g++", "-std=c++17") };
    if !found(compiler) {
        return None;
    }
    let program = place.join("program");
    let built = Command::new(compiler)
        .args([standard, "-O2", "-g", "-Wall", "-Wextra", "-Wpedantic", "-Werror"])
        .arg(format!("-I{}", root().join("ffi/include").display()))
        .arg(root().join(source))
        .arg(libraries().join("libhovernav_c.a"))
        .args(more)
        .args(SYSTEM)
        .arg("-o")
        .arg(&program)
        .output()
        .unwrap();
    text(&built);
    Some(program)
}

const REPLAY: &str = "examples/04_c_flight_computer.c";

/// What the replay prints first: samples, solutions, refused axes, and a hash of every solution's bytes;
/// computed by the Rust core.
fn flown(most: usize) -> String {
    let mut dataset = Dataset::open(&root().join("datasets/heli-hover")).unwrap();
    let config = dataset.settings().unwrap();
    let mut estimator: Estimator = Estimator::new(config);
    let (mut samples, mut solutions, mut refused) = (0, 0, 0);
    let mut hash = 14_695_981_039_346_656_037_u64;
    for event in dataset.events() {
        if samples == most {
            break;
        }
        estimator.push(&event, |notice| {
            if let hovernav::ekf::Notice::Updated(report) = notice {
                let rejected = |axis: &&hovernav::ekf::Innovation| {
                    axis.verdict == hovernav::ekf::Verdict::Rejected
                };
                refused += report.innovations().filter(rejected).count();
            }
        });
        if let Event::Imu(_) = event {
            samples += 1;
            if let Some(solution) = estimator.solution() {
                for word in words(&Solution::from(&solution)) {
                    for byte in word.to_le_bytes() {
                        hash = (hash ^ u64::from(byte)).wrapping_mul(1_099_511_628_211);
                    }
                }
                solutions += 1;
            }
        }
    }
    format!("{samples} samples, {solutions} solutions, {refused} axes refused, {hash:016x}")
}

/// A solution as it lies in memory, eight bytes at a time.
fn words(solution: &Solution) -> Vec<u64> {
    let mut words = vec![solution.time_ns as u64];
    let place = [solution.latitude_deg, solution.longitude_deg, solution.height_m];
    let angles = [solution.roll_rad, solution.pitch_rad, solution.yaw_rad];
    let numbers = place
        .into_iter()
        .chain(solution.velocity_ned_mps)
        .chain(solution.velocity_body_mps)
        .chain(solution.body_to_ned)
        .chain(angles)
        .chain(solution.angular_rate_radps)
        .chain(solution.position_sigma_m)
        .chain(solution.velocity_sigma_mps)
        .chain(solution.attitude_sigma_rad)
        .chain(solution.gyro_bias_radps)
        .chain(solution.accel_bias_mps2)
        .chain(solution.gyro_bias_sigma_radps)
        .chain(solution.accel_bias_sigma_mps2);
    words.extend(numbers.map(f64::to_bits));
    assert_eq!(8 * words.len(), size_of::<Solution>());
    words
}

fn replay(program: &Path, wrapper: &[&str], most: usize) -> String {
    let mut command = match wrapper {
        [] => Command::new(program),
        [first, rest @ ..] => {
            let mut command = Command::new(first);
            command.args(rest).arg(program);
            command
        }
    };
    let output = command.arg(root().join("datasets/heli-hover")).arg(most.to_string()).output();
    text(&output.unwrap())
}

#[test]
fn a_flight_replayed_in_c_gives_the_bits_of_rust() {
    let place = tempfile::tempdir().unwrap();
    let Some(program) = build(REPLAY, &[], place.path()) else { return };
    let printed = replay(&program, &[], usize::MAX >> 1);
    println!("{printed}");
    assert_eq!(printed.lines().next().unwrap(), flown(usize::MAX));
}

#[test]
fn the_shared_library_gives_them_too() {
    let place = tempfile::tempdir().unwrap();
    if !found("gcc") {
        return;
    }
    let program = place.path().join("program");
    let built = Command::new("gcc")
        .args(["-std=c11", "-O2"])
        .arg(format!("-I{}", root().join("ffi/include").display()))
        .arg(root().join(REPLAY))
        .arg(format!("-L{}", libraries().display()))
        .args(["-lhovernav_c", "-lm", &format!("-Wl,-rpath,{}", libraries().display()), "-o"])
        .arg(&program)
        .output()
        .unwrap();
    text(&built);
    assert_eq!(replay(&program, &[], 2_000).lines().next().unwrap(), flown(2_000));
}

#[test]
fn valgrind_finds_nothing_in_the_replay() {
    let place = tempfile::tempdir().unwrap();
    if !found("valgrind") {
        return;
    }
    let Some(program) = build(REPLAY, &[], place.path()) else { return };
    let valgrind = ["valgrind", "--quiet", "--error-exitcode=9", "--leak-check=full"];
    assert_eq!(replay(&program, &valgrind, 600).lines().next().unwrap(), flown(600));
}

#[test]
fn sanitizers_find_nothing_in_the_replay() {
    let place = tempfile::tempdir().unwrap();
    let sanitize = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
    let Some(program) = build(REPLAY, &sanitize, place.path()) else { return };
    assert_eq!(replay(&program, &[], 2_000).lines().next().unwrap(), flown(2_000));
}

#[test]
fn bytes_of_a_receiver_reach_the_sticks_in_cpp() {
    let place = tempfile::tempdir().unwrap();
    let source = "ffi/examples/lines.cpp";
    let reach = |command: &mut Command| {
        let printed = text(&command.output().unwrap());
        println!("{printed}");
        assert!(printed.starts_with("30 fixes, height 520.0 m"), "{printed}");
    };
    let Some(program) = build(source, &[], place.path()) else { return };
    reach(&mut Command::new(&program));
    if found("valgrind") {
        let valgrind = ["--quiet", "--error-exitcode=9", "--leak-check=full"];
        reach(Command::new("valgrind").args(valgrind).arg(&program));
    }
    let sanitize = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
    let Some(program) = build(source, &sanitize, place.path()) else { return };
    reach(&mut Command::new(program));
}

/// Header, libraries, pkg-config file and CMake package, installed below `prefix`.
fn install(prefix: &Path) {
    let mut command = Command::new(root().join("ffi/install"));
    text(&command.arg(prefix).arg(libraries()).output().unwrap());
}

#[test]
fn pkg_config_finds_what_was_installed() {
    if !found("gcc") || !found("pkg-config") {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    install(place.path());
    let flags = Command::new("pkg-config")
        .args(["--cflags", "--libs", "hovernav"])
        .env("PKG_CONFIG_PATH", place.path().join("lib/pkgconfig"))
        .output();
    let program = place.path().join("program");
    let built = Command::new("gcc")
        .arg(root().join(REPLAY))
        .args(text(&flags.unwrap()).split_whitespace())
        .args(["-lm", "-o"])
        .arg(&program)
        .output();
    text(&built.unwrap());
    let run = Command::new(&program)
        .arg(root().join("datasets/heli-hover"))
        .arg("300")
        .env("LD_LIBRARY_PATH", place.path().join("lib"))
        .output();
    assert_eq!(text(&run.unwrap()).lines().next().unwrap(), flown(300));
}

#[test]
fn cmake_finds_what_was_installed() {
    if !found("cmake") || !found("gcc") {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    install(place.path());
    let project = format!(
        "cmake_minimum_required(VERSION 3.16)\n\
         project(replay C)\n\
         find_package(hovernav 0.1 REQUIRED)\n\
         add_executable(shared {source})\n\
         target_link_libraries(shared PRIVATE hovernav::hovernav m)\n\
         add_executable(static {source})\n\
         target_link_libraries(static PRIVATE hovernav::static)\n",
        source = root().join(REPLAY).display()
    );
    std::fs::write(place.path().join("CMakeLists.txt"), project).unwrap();
    let build = place.path().join("build");
    let configure = Command::new("cmake")
        .arg("-S")
        .arg(place.path())
        .arg("-B")
        .arg(&build)
        .arg(format!("-DCMAKE_PREFIX_PATH={}", place.path().display()))
        .output();
    text(&configure.unwrap());
    text(&Command::new("cmake").arg("--build").arg(&build).output().unwrap());
    for program in ["shared", "static"] {
        let run = Command::new(build.join(program))
            .arg(root().join("datasets/heli-hover"))
            .arg("300")
            .output();
        assert_eq!(text(&run.unwrap()).lines().next().unwrap(), flown(300), "{program}");
    }
}
