//! The end of commands that run until they are stopped.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use anyhow::Context as _;
#[cfg(all(feature = "fly", target_os = "linux"))]
use signal_hook::{consts::SIGINT, iterator::Signals};

/// Signals within this time count as one request: terminals, service managers and `timeout` signal both a process and
/// its group.
const ONE_REQUEST: Duration = Duration::from_millis(500);
/// Time within which the second Ctrl-C of an armed vehicle ends its flight.
#[cfg(all(feature = "fly", target_os = "linux"))]
const CONFIRM_WITHIN: Duration = Duration::from_secs(2);
/// A second Ctrl-C within this time counts as the same Ctrl-C, sent to a process and its group.
#[cfg(all(feature = "fly", target_os = "linux"))]
const ONE_PRESS: Duration = Duration::from_millis(50);
/// Interval at which a thread checks whether to stop.
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
    insist_later(&stop, insisted);
    Ok(stop)
}

/// As [`when_asked`], except that one [`SIGINT`] calls `ask`, and only a second one within 2 s sets the flag.
///
/// # Errors
/// As [`when_asked`].
#[cfg(all(feature = "fly", target_os = "linux"))]
pub fn when_asked_twice(
    signals: &[i32],
    ask: impl Fn() + Send + 'static,
) -> anyhow::Result<Arc<AtomicBool>> {
    let stop = when_asked(signals)?;
    let insisted = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register_conditional_shutdown(SIGINT, 1, Arc::clone(&insisted))
        .context("cannot listen for signals")?;
    insist_later(&stop, insisted);
    let mut pressed = Signals::new([SIGINT]).context("cannot listen for signals")?;
    let asked = Arc::clone(&stop);
    thread::spawn(move || {
        let mut first: Option<std::time::Instant> = None;
        for _ in pressed.forever() {
            match first.map(|first| first.elapsed()) {
                Some(since) if since < ONE_PRESS => {}
                Some(since) if since < CONFIRM_WITHIN => asked.store(true, Ordering::Relaxed),
                _ => {
                    first = Some(std::time::Instant::now());
                    ask();
                }
            }
        }
    });
    Ok(stop)
}

/// Sets `insisted` some time after `stop`, so that a further request ends the process at once.
fn insist_later(stop: &Arc<AtomicBool>, insisted: Arc<AtomicBool>) {
    let asked = Arc::clone(stop);
    thread::spawn(move || {
        while !asked.load(Ordering::Relaxed) {
            thread::sleep(LOOK_EVERY);
        }
        thread::sleep(ONE_REQUEST);
        insisted.store(true, Ordering::Relaxed);
    });
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
