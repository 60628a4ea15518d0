//! Output: standard output, standard error, result files and progress.

use std::borrow::Cow;
use std::fmt::Display;
use std::io::{self, IsTerminal as _, Write as _};
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::Context as _;
use hovernav_dataset::spelt_out;
use hovernav_toml::{read_bytes, write_whole};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

/// Whether `--quiet` was given.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Sets `--quiet`: from now on only the requested output and errors are written.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Whether `--quiet` was given.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// The first error of standard output, except a closed pipe.
static UNWRITTEN: OnceLock<io::Error> = OnceLock::new();

/// Writes requested output to standard output. A closed pipe, as from `head`, is ignored. [`unwritten`] reports any
/// other failure.
pub fn print(text: impl Display) {
    let text = text.to_string();
    let mut out = io::stdout().lock();
    match write!(out, "{}", escaped(&text)).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            // Only the first failure is kept.
            let _ = UNWRITTEN.set(error);
        }
        _ => {}
    }
}

/// Writes an error or a warning to standard error. A failure to write is ignored; the exit status still reports the
/// error.
pub fn complain(line: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{}", escaped(&line.to_string()));
}

/// `text` with its control characters spelt out, except line ends and tabs. Names in a log must not command the
/// terminal.
pub fn escaped(text: &str) -> Cow<'_, str> {
    spelt_out(text, |letter| letter.is_control() && !matches!(letter, '\n' | '\t'))
}

/// The error, such as a full disk, if some text could not be written to standard output.
pub fn unwritten() -> Option<&'static io::Error> {
    UNWRITTEN.get()
}

/// Writes progress or results to standard output, unless `--quiet`.
pub fn say_text(text: impl Display) {
    if !is_quiet() {
        print(text);
    }
}

/// Writes one warning to standard error, unless `--quiet`.
pub fn warn(warning: impl Display) {
    if !is_quiet() {
        complain(format_args!("warning: {warning}"));
    }
}

/// Writes one line of progress or results, unless `--quiet`.
pub fn say(line: impl Display) {
    say_text(format_args!("{line}\n"));
}

/// Prints `value` as one JSON object.
pub fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    print(serde_json::to_string_pretty(value)? + "\n");
    Ok(())
}

/// The name for the results of a log: its file name without the extension.
pub fn name_of(log: &Path) -> String {
    let full = log.canonicalize().unwrap_or_else(|_| log.to_path_buf());
    full.file_stem().map_or_else(|| "log".into(), |name| name.to_string_lossy().into_owned())
}

/// Creates the directory for results.
pub fn create(directory: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(directory)
        .with_context(|| format!("cannot create {}", directory.display()))
}

/// Writes a file completely or not at all.
pub fn write(path: &Path, bytes: impl AsRef<[u8]>) -> anyhow::Result<()> {
    write_whole(path, bytes).with_context(|| cannot_write(path))
}

/// The files that `hovernav estimate --export` writes next to `solution.csv`.
pub const EXPORTED: [&str; 8] = [
    "solution.parquet",
    "solution.kml",
    "solution.gpx",
    "solution.pos",
    "solution.tum",
    "solution.euroc.csv",
    "solution.mcap",
    "solution.foxglove-layout.json",
];

/// The file name of the page of a run.
pub const REPORT: &str = "report.html";

/// Whether `out` contains the `summary.json` of an earlier run of this program.
fn holds_earlier_run(out: &Path) -> bool {
    /// Largest summary that is read, bytes.
    const LARGEST: u64 = 1 << 24;
    let text = read_bytes(&out.join("summary.json"), LARGEST).unwrap_or_default();
    let summary: serde_json::Value = serde_json::from_slice(&text).unwrap_or_default();
    summary["tool"] == "hovernav"
}

/// Removes those of the files `names` in `out` that an earlier run wrote; they are not part of the present results and
/// could be mistaken for them. Without the summary of an earlier run, a file may be the user's own: the function then
/// only warns.
pub fn remove_stale(out: &Path, names: impl IntoIterator<Item = impl AsRef<Path>>) {
    let is_ours = holds_earlier_run(out);
    let paths = names.into_iter().map(|name| out.join(name));
    for path in paths.filter(|path| path.is_file()) {
        match is_ours.then(|| std::fs::remove_file(&path)) {
            Some(Ok(())) if is_quiet() => {}
            Some(Ok(())) => {
                complain(format_args!("removed {}, a file of an earlier run", path.display()));
            }
            Some(Err(error)) => complain(format_args!(
                "warning: cannot remove {}, a file of an earlier run: {error}",
                path.display()
            )),
            None => {
                complain(format_args!("warning: {} was not written by this run", path.display()));
            }
        }
    }
}

/// The error message for a file that cannot be written; the cause follows it.
pub fn cannot_write(path: &Path) -> String {
    format!("cannot write {}", path.display())
}

/// Writes a summary as indented JSON.
pub fn write_json(summary: &impl Serialize, path: &Path) -> anyhow::Result<()> {
    write(path, serde_json::to_string_pretty(summary)? + "\n")
}

/// Whether progress is shown: standard error is a terminal and `--quiet` is absent.
fn is_watched() -> bool {
    io::stderr().is_terminal() && !is_quiet()
}

/// A progress bar of `count` steps on the terminal; hidden if progress is not shown.
pub fn bar(count: usize) -> ProgressBar {
    if !is_watched() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{wide_bar} {percent}% {eta} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(count as u64).with_style(style)
}

/// A progress line with the current task and the elapsed time, on the terminal until dropped.
pub struct Working(ProgressBar);

impl Working {
    /// Shows the task `what`, if progress is shown.
    pub fn on(what: &'static str) -> Self {
        if !is_watched() {
            return Self(ProgressBar::hidden());
        }
        let style = ProgressStyle::with_template("{spinner} {msg} {elapsed}")
            .unwrap_or_else(|_| ProgressStyle::default_spinner());
        let bar = ProgressBar::new_spinner().with_style(style).with_message(what);
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }
}

impl Drop for Working {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::escaped;

    #[test]
    fn names_in_a_log_do_not_command_the_terminal() {
        assert_eq!(escaped("a\x1b[2Jb\u{9b}c\td\n"), "a\\u{1b}[2Jb\\u{9b}c\td\n");
        assert_eq!(escaped("54° µT\n"), "54° µT\n");
    }
}
