//! Where results go, and how they are written.

use std::fmt::Display;
use std::io::{self, IsTerminal as _, Write as _};
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::Context as _;
use hovernav_log::write_whole;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

/// Whether `--quiet` was given.
static QUIET: AtomicBool = AtomicBool::new(false);

/// From now on only what was asked for and errors are written.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Why standard output did not take all that was written to it.
static UNWRITTEN: OnceLock<io::Error> = OnceLock::new();

/// Writes what was asked for to standard output. A reader that has gone, as `head` does, misses it; any other
/// failure is told by [`unwritten`].
pub fn print(text: impl Display) {
    let mut out = io::stdout().lock();
    match write!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            // The first failure tells the cause.
            let _ = UNWRITTEN.set(error);
        }
        _ => {}
    }
}

/// Writes an error or a warning to standard error. Where nobody reads it any more there is nobody to tell; the exit
/// status still does.
pub fn complain(line: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}

/// Why something of what was written to standard output is lost, if it is: a full disk, say.
pub fn unwritten() -> Option<&'static io::Error> {
    UNWRITTEN.get()
}

/// Writes what was done to standard output, unless `--quiet`.
pub fn say_text(text: impl Display) {
    if !is_quiet() {
        print(text);
    }
}

/// A line of what was done, unless `--quiet`.
pub fn say(line: impl Display) {
    say_text(format_args!("{line}\n"));
}

/// Prints `value` as one JSON object.
pub fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    print(serde_json::to_string_pretty(value)? + "\n");
    Ok(())
}

/// What a log's results are called after.
pub fn name_of(log: &Path) -> String {
    let full = log.canonicalize().unwrap_or_else(|_| log.to_path_buf());
    full.file_stem().map_or_else(|| "log".into(), |name| name.to_string_lossy().into_owned())
}

/// Makes the directory that results go to.
pub fn create(directory: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(directory)
        .with_context(|| format!("cannot create {}", directory.display()))
}

/// Writes a file, whole or not at all.
pub fn write(path: &Path, bytes: impl AsRef<[u8]>) -> anyhow::Result<()> {
    write_whole(path, bytes).with_context(|| cannot_write(path))
}

/// The page of a run.
pub const REPORT: &str = "report.html";

/// Whether an earlier run of this program left its `summary.json` in `out`.
fn holds_earlier_run(out: &Path) -> bool {
    let text = std::fs::read_to_string(out.join("summary.json")).unwrap_or_default();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    summary["tool"] == "hovernav"
}

/// Removes from `out` those of the files `names` that an earlier run left there and this one, which calls for them no
/// more, would have written over: they would pass for its own. What stands there without the summary of an earlier
/// run may be anybody's, and is only named.
pub fn remove_stale(out: &Path, names: impl IntoIterator<Item = impl AsRef<Path>>) {
    let is_ours = holds_earlier_run(out);
    let paths = names.into_iter().map(|name| out.join(name));
    for path in paths.filter(|path| path.is_file()) {
        match is_ours.then(|| std::fs::remove_file(&path)) {
            Some(Ok(())) if is_quiet() => {}
            Some(Ok(())) => complain(format_args!("removed {}: of an earlier run", path.display())),
            Some(Err(error)) => complain(format_args!(
                "warning: {}: of an earlier run, cannot be removed: {error}",
                path.display()
            )),
            None => complain(format_args!("warning: {}: not of this run", path.display())),
        }
    }
}

/// What could not be done, before the cause.
pub fn cannot_write(path: &Path) -> String {
    format!("cannot write {}", path.display())
}

/// Writes a summary as JSON that people can read, too.
pub fn write_json(summary: &impl Serialize, path: &Path) -> anyhow::Result<()> {
    write(path, serde_json::to_string_pretty(summary)? + "\n")
}

/// Whether somebody is there to see progress.
fn is_watched() -> bool {
    io::stderr().is_terminal() && !is_quiet()
}

/// A bar of `count` steps on the terminal; hidden where none is watching.
pub fn bar(count: usize) -> ProgressBar {
    if !is_watched() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{wide_bar} {percent}% {eta} left")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(count as u64).with_style(style)
}

/// What is being done, and for how long, on the terminal until it is dropped.
pub struct Working(ProgressBar);

impl Working {
    /// Says `what`; nothing where none is watching.
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
