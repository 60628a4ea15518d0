//! A Python with packages from its index, for tests that compare with what is written in it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

/// The interpreter of an environment with `packages`; `None`, and said, where it cannot be had.
///
/// All tests share one environment under `target/`, into which each installs what it needs: a package that cannot be
/// had is missed by no other test.
pub fn python(packages: &[&str]) -> Option<PathBuf> {
    /// One at a time makes the environment and installs into it.
    static TURN: Mutex<()> = Mutex::new(());
    let environment = Path::new(env!("CARGO_TARGET_TMPDIR")).join("python");
    let python = environment.join("bin/python");
    let works = |program: &Path, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).output();
        output.is_ok_and(|output| output.status.success())
    };
    // Of what is installed a test imports little: that little is compiled when it is.
    let install =
        ["-m", "pip", "install", "--quiet", "--no-compile", "--disable-pip-version-check"];
    let _turn = TURN.lock().unwrap();
    // What a new environment gets last.
    let is_made = environment.join("bin/pip").exists()
        || works(Path::new("python3"), &["-m", "venv", environment.to_str()?]);
    let has_packages = is_made && works(&python, &[&install[..], packages].concat());
    if !has_packages {
        println!("skipped: no Python environment with {} can be made", packages.join(", "));
    }
    has_packages.then_some(python)
}
