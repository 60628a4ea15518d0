//! The machine, and its configuration for low jitter.

use std::fs;

use serde::Serialize;

/// The machine of a measurement.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// Name of the processor.
    pub processor: String,
    /// Kernel of the operating system.
    pub system: String,
    /// Number of processors.
    pub processors: usize,
    /// Optimisation of the build.
    pub build: &'static str,
    /// Real-time priority of the thread, or the reason for its absence.
    pub priority: String,
    /// Whether memory was locked, or the reason why not.
    pub memory: String,
}

/// Priority of the flight loop.
#[cfg(target_os = "linux")]
const PRIORITY: u8 = 80;

impl Machine {
    /// Requests real-time priority and locked memory, and records the result.
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
    ("not real-time: supported on Linux only".into(), "not locked: supported on Linux only".into())
}
