//! The end of commands that run until they are stopped.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use anyhow::Context as _;

/// Signals within this time count as one request: terminals, service managers and `timeout` signal both a process and
/// its group.
const ONE_REQUEST: Duration = Duration::from_millis(500);
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// A flag that the first of `signals` sets, so that the command ends in order. A second request ends the process at
/// once, even if a thread hangs.
///
/// # Errors
/// If a handler for one of `signals` cannot be installed.
pub fn when_asked(signals: &[i32]) -> anyhow::Result<Arc<AtomicBool>> {
    let (stop, insisted) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
    for &signal in signals {
        signal_hook::flag::register_conditional_shutdown(signal, 1, Arc::clone(&insisted))
            .and_then(|_| signal_hook::flag::register(signal, Arc::clone(&stop)))
            .context("cannot listen for signals")?;
    }
    let asked = Arc::clone(&stop);
    thread::spawn(move || {
        while !asked.load(Ordering::Relaxed) {
            thread::sleep(LOOK_EVERY);
        }
        thread::sleep(ONE_REQUEST);
        insisted.store(true, Ordering::Relaxed);
    });
    Ok(stop)
}

/// Sets `stop` after `seconds`, if given.
pub fn after(seconds: Option<f64>, stop: &Arc<AtomicBool>) {
    if let Some(seconds) = seconds {
        let stop = Arc::clone(stop);
        thread::spawn(move || {
            thread::sleep(Duration::from_secs_f64(seconds));
            stop.store(true, Ordering::Relaxed);
        });
    }
}
