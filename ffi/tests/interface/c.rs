//! Tests of the examples in C and C++. The machine's compilers build them; they run directly, under valgrind and with
//! sanitizers.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use hovernav::ekf::Estimator;
use hovernav::event::Event;
use hovernav::imu::NotchConfig;
use hovernav_c::{HOVERNAV_ABI, Solution};
use hovernav_dataset::Dataset;
use hovernav_testing::installed;

/// System libraries that Rust's standard library needs in the static library.
const SYSTEM: [&str; 3] = ["-lpthread", "-ldl", "-lm"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

/// Directory in which cargo put the library of this test.
fn libraries() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().to_path_buf()
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
    if !installed(compiler) {
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

/// First output line of the replay, computed by the Rust core with or without a `notch`: samples, solutions, rejected
/// axes, and a hash of every solution's bytes.
fn flown(most: usize, notch: Option<NotchConfig>) -> String {
    let mut dataset = Dataset::open(&root().join("datasets/heli-hover")).unwrap();
    dataset.manifest.imu.notch = notch;
    let config = dataset.settings().unwrap();
    let mut estimator = Estimator::new(config);
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

/// The memory of a solution, eight bytes at a time.
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

fn replay(program: &Path, wrapper: &[&str], arguments: &[&str]) -> String {
    let mut command = match wrapper {
        [] => Command::new(program),
        [first, rest @ ..] => {
            let mut command = Command::new(first);
            command.args(rest).arg(program);
            command
        }
    };
    let output = command.arg(root().join("datasets/heli-hover")).args(arguments).output();
    text(&output.unwrap())
}

#[test]
fn a_flight_replayed_in_c_gives_the_bits_of_rust() {
    let place = tempfile::tempdir().unwrap();
    let Some(program) = build(REPLAY, &[], place.path()) else { return };
    let printed = replay(&program, &[], &[]);
    println!("{printed}");
    assert_eq!(printed.lines().next().unwrap(), flown(usize::MAX, None));
}

#[test]
fn and_so_it_does_without_the_vibration_of_a_rotor() {
    let place = tempfile::tempdir().unwrap();
    let Some(program) = build(REPLAY, &[], place.path()) else { return };
    let notch = NotchConfig::at_hz(12.5).with_harmonics(2);
    let printed = replay(&program, &[], &["2000", "12.5"]);
    let first = printed.lines().next().unwrap();
    assert_eq!(first, flown(2_000, Some(notch)));
    assert_ne!(first, flown(2_000, None));
}

#[test]
fn the_shared_library_gives_them_too() {
    if !installed("gcc") {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    install(place.path());
    let shared = place.path().join("lib");
    let program = place.path().join("program");
    let built = Command::new("gcc")
        .args(["-std=c11", "-O2"])
        .arg(format!("-I{}", root().join("ffi/include").display()))
        .arg(root().join(REPLAY))
        .arg(format!("-L{}", shared.display()))
        .args(["-lhovernav_c", "-lm", &format!("-Wl,-rpath,{}", shared.display()), "-o"])
        .arg(&program)
        .output()
        .unwrap();
    text(&built);
    assert_eq!(replay(&program, &[], &["2000"]).lines().next().unwrap(), flown(2_000, None));
}

/// The entries of one kind, `SONAME` or `NEEDED`, in the dynamic section of `file`.
fn dynamic(file: &Path, kind: &str) -> Vec<String> {
    let output = Command::new("readelf").arg("-d").arg(file).output().unwrap();
    let lines = text(&output);
    let entries = lines.lines().filter(|line| line.contains(&format!("({kind})")));
    entries.map(|line| line.split(['[', ']']).nth(1).unwrap().to_owned()).collect()
}

/// A program built against one binary interface never starts with a library of another.
#[cfg(target_os = "linux")]
#[test]
fn the_name_that_programs_load_the_library_by_ends_with_the_version_of_the_binary_interface() {
    if !installed("readelf") {
        return;
    }
    let name = format!("libhovernav_c.so.{HOVERNAV_ABI}");
    let place = tempfile::tempdir().unwrap();
    install(place.path());
    let shared = place.path().join("lib");
    assert_eq!(dynamic(&shared.join("libhovernav_c.so"), "SONAME"), [name.as_str()]);

    let version = env!("CARGO_PKG_VERSION");
    let leads_to = |link: &str| std::fs::read_link(shared.join(link)).unwrap();
    assert_eq!(leads_to("libhovernav_c.so"), Path::new(&name));
    assert_eq!(leads_to(&name), PathBuf::from(format!("{name}.{version}")));

    // Installing over the same version, or over an old library without a version in its file name, gives the same
    // result.
    std::fs::remove_file(shared.join("libhovernav_c.so")).unwrap();
    std::fs::write(shared.join("libhovernav_c.so"), "old").unwrap();
    install(place.path());
    assert_eq!(leads_to("libhovernav_c.so"), Path::new(&name));
}

#[test]
fn valgrind_finds_nothing_in_the_replay() {
    let place = tempfile::tempdir().unwrap();
    if !installed("valgrind") {
        return;
    }
    let Some(program) = build(REPLAY, &[], place.path()) else { return };
    let valgrind = ["valgrind", "--quiet", "--error-exitcode=9", "--leak-check=full"];
    assert_eq!(replay(&program, &valgrind, &["600"]).lines().next().unwrap(), flown(600, None));
}

#[test]
fn sanitizers_find_nothing_in_the_replay() {
    let place = tempfile::tempdir().unwrap();
    let sanitize = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
    let Some(program) = build(REPLAY, &sanitize, place.path()) else { return };
    assert_eq!(replay(&program, &[], &["2000"]).lines().next().unwrap(), flown(2_000, None));
}

const LINES: &str = "ffi/examples/lines.cpp";

fn reach(command: &mut Command) {
    let printed = text(&command.output().unwrap());
    println!("{printed}");
    assert!(printed.starts_with("30 fixes, height 520.0 m"), "{printed}");
}

#[test]
fn bytes_of_a_receiver_reach_the_sticks_in_cpp() {
    let place = tempfile::tempdir().unwrap();
    let Some(program) = build(LINES, &[], place.path()) else { return };
    reach(&mut Command::new(&program));
    if installed("valgrind") {
        let valgrind = ["--quiet", "--error-exitcode=9", "--leak-check=full"];
        reach(Command::new("valgrind").args(valgrind).arg(&program));
    }
    let sanitize = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
    let Some(program) = build(LINES, &sanitize, place.path()) else { return };
    reach(&mut Command::new(program));
}

/// Installs header, libraries, pkg-config file and CMake package below `prefix`.
fn install(prefix: &Path) {
    let mut command = Command::new(root().join("ffi/install"));
    text(&command.arg(prefix).arg(libraries()).output().unwrap());
}

/// Checks that `program` loads the library of this binary interface.
fn needs_the_interface(program: &Path) {
    if cfg!(target_os = "linux") && installed("readelf") {
        let needed = dynamic(program, "NEEDED");
        assert!(needed.contains(&format!("libhovernav_c.so.{HOVERNAV_ABI}")), "{needed:?}");
    }
}

#[test]
fn pkg_config_finds_what_was_installed() {
    if !installed("gcc") || !installed("pkg-config") {
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
    needs_the_interface(&program);
    let run = Command::new(&program)
        .arg(root().join("datasets/heli-hover"))
        .arg("300")
        .env("LD_LIBRARY_PATH", place.path().join("lib"))
        .output();
    assert_eq!(text(&run.unwrap()).lines().next().unwrap(), flown(300, None));
}

/// Configures the CMake project `text` of `languages` against the installation at `prefix`. Returns its output and
/// its build directory.
fn configure(prefix: &Path, languages: &str, text: &str) -> (Output, PathBuf) {
    let build = prefix.join("build");
    let project =
        format!("cmake_minimum_required(VERSION 3.16)\nproject(consumer {languages})\n{text}");
    std::fs::write(prefix.join("CMakeLists.txt"), project).unwrap();
    let mut command = Command::new("cmake");
    command.arg("-S").arg(prefix).arg("-B").arg(&build);
    command.arg(format!("-DCMAKE_PREFIX_PATH={}", prefix.display()));
    (command.output().unwrap(), build)
}

#[test]
fn cmake_finds_what_was_installed() {
    if !installed("cmake") || !installed("gcc") || !installed("g++") {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    install(place.path());
    let project = format!(
        "find_package(hovernav 0.1 REQUIRED)\n\
         add_executable(shared {replay})\n\
         target_link_libraries(shared PRIVATE hovernav::hovernav m)\n\
         add_executable(static {replay})\n\
         target_link_libraries(static PRIVATE hovernav::static)\n\
         add_executable(cpp_shared {lines})\n\
         add_executable(cpp_static {lines})\n\
         target_compile_features(cpp_shared PRIVATE cxx_std_17)\n\
         target_compile_features(cpp_static PRIVATE cxx_std_17)\n\
         target_link_libraries(cpp_shared PRIVATE hovernav::hovernav)\n\
         target_link_libraries(cpp_static PRIVATE hovernav::static)\n",
        replay = root().join(REPLAY).display(),
        lines = root().join(LINES).display()
    );
    let (configured, build) = configure(place.path(), "C CXX", &project);
    text(&configured);
    text(&Command::new("cmake").arg("--build").arg(&build).output().unwrap());
    for program in ["shared", "static"] {
        let run = Command::new(build.join(program))
            .arg(root().join("datasets/heli-hover"))
            .arg("300")
            .output();
        assert_eq!(text(&run.unwrap()).lines().next().unwrap(), flown(300, None), "{program}");
    }
    needs_the_interface(&build.join("shared"));
    reach(&mut Command::new(build.join("cpp_shared")));
    reach(&mut Command::new(build.join("cpp_static")));
}

/// Before version 1 each minor version may change what the header declares.
#[test]
fn cmake_is_refused_another_minor_version() {
    if !installed("cmake") || !installed("gcc") {
        return;
    }
    for (version, fits) in
        [("0.1", true), ("0.1.0 EXACT", true), ("0.2", false), ("0.1.9", false), ("0.0.1", false)]
    {
        let place = tempfile::tempdir().unwrap();
        install(place.path());
        let project = format!("find_package(hovernav {version} REQUIRED)\n");
        let (configured, _) = configure(place.path(), "C", &project);
        let errors = String::from_utf8_lossy(&configured.stderr);
        assert_eq!(configured.status.success(), fits, "{version}: {errors}");
    }
}
