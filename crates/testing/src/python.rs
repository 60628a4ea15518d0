//! A Python interpreter with packages, for tests that compare with Python programs.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use crate::skip;

/// The interpreter of an environment with `packages`; `None`, after [`skip`], where pip cannot install them.
///
/// The test programs of the workspace share one environment in the target directory, `tmp/python`. Each test installs
/// its own packages there, so a package that cannot be installed affects no other test.
///
/// # Panics
/// As [`skip`].
#[must_use]
#[track_caller]
pub fn python(packages: &[&str]) -> Option<PathBuf> {
    /// Lock that is held while the environment is created or changed.
    static TURN: Mutex<()> = Mutex::new(());
    let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let python = environment().and_then(|environment| install(packages, &environment));
    drop(turn);
    if python.is_none() {
        skip(format_args!("no Python environment with {} can be made", packages.join(", ")));
    }
    python
}

/// The folder of the environment: cargo puts a test program into `deps` of a profile of the target directory.
fn environment() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    Some(program.ancestors().nth(3)?.join("tmp/python"))
}

/// The interpreter of `environment`, created where it is missing, after `packages` are installed into it.
fn install(packages: &[&str], environment: &Path) -> Option<PathBuf> {
    let python = environment.join("bin/python");
    let works = |program: &Path, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).output();
        output.is_ok_and(|output| output.status.success())
    };
    // Tests import few of the installed modules: Python compiles these on import.
    let install =
        ["-m", "pip", "install", "--quiet", "--no-compile", "--disable-pip-version-check"];
    // A new environment gets `pip` last.
    let is_made = environment.join("bin/pip").exists()
        || works(Path::new("python3"), &["-m", "venv", environment.to_str()?]);
    (is_made && works(&python, &[&install[..], packages].concat())).then_some(python)
}
