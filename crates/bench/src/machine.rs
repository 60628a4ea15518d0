//! What the times were taken on, and how quiet it was made.

use std::fs;

use serde::Serialize;

/// What the times were taken on.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// The processor, as the system names it.
    pub processor: String,
    /// The system's kernel.
    pub system: String,
    /// Processors there are.
    pub processors: usize,
    /// How the code was built.
    pub build: &'static str,
    /// Whether the thread ran at real-time priority, or why not.
    pub priority: String,
    /// Whether memory was locked, or why not.
    pub memory: String,
}

/// The loop's priority in flight.
#[cfg(target_os = "linux")]
const PRIORITY: u8 = 80;

impl Machine {
    /// Asks for real-time priority and locked memory, and says what came of it.
    pub fn prepare() -> Self {
        let line = |path: &str, key: &str| {
            let text = fs::read_to_string(path).ok()?;
            let line = text.lines().find(|line| line.starts_with(key))?;
            Some(line.rsplit(": ").next()?.trim().to_owned())
        };
        let processor = ["model name", "Model", "Hardware"]
            .into_iter()
            .find_map(|key| line("/proc/cpuinfo", key))
            .unwrap_or_else(|| std::env::consts::ARCH.to_owned());
        let (priority, memory) = quiet();
        Self {
            processor,
            system: line("/proc/version", "Linux").unwrap_or_else(|| std::env::consts::OS.into()),
            processors: std::thread::available_parallelism().map_or(1, usize::from),
            build: if cfg!(debug_assertions) { "not optimised" } else { "optimised" },
            priority,
            memory,
        }
    }
}

#[cfg(target_os = "linux")]
fn quiet() -> (String, String) {
    use rustix::mm::{MlockAllFlags, mlockall};
    use thread_priority::{
        RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
        set_thread_priority_and_policy, thread_native_id,
    };
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let priority = ThreadPriorityValue::try_from(PRIORITY)
        .and_then(|value| {
            let priority = ThreadPriority::Crossplatform(value);
            set_thread_priority_and_policy(thread_native_id(), priority, policy)
                .map_err(|error| format!("{error}"))
        })
        .map_or_else(|why| format!("not real-time: {why}"), |()| format!("SCHED_FIFO, {PRIORITY}"));
    let memory = mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE)
        .map_or_else(|why| format!("not locked: {why}"), |()| "locked".to_owned());
    (priority, memory)
}

#[cfg(not(target_os = "linux"))]
fn quiet() -> (String, String) {
    ("not real-time: only asked for on Linux".into(), "not locked: only asked for on Linux".into())
}
