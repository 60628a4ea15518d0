//! `hovernav fly`: the real-time loop, until a signal or `--duration` ends it.

use std::io::{Write as _, stderr};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::Context as _;
#[cfg(feature = "lab")]
use hovernav_design::hover::{Cut, FlightMode, HoverDesign};
use hovernav_fly::serial::Clock;
use hovernav_fly::{Notification, fly};
use hovernav_record::{FlyConfig, Level};
use signal_hook::consts::{
    SIGALRM, SIGHUP, SIGINT, SIGIO, SIGPROF, SIGQUIT, SIGTERM, SIGTSTP, SIGTTIN, SIGTTOU, SIGUSR1,
    SIGUSR2, SIGVTALRM, SIGXCPU, SIGXFSZ,
};

use crate::arguments::read_fly_config;
use crate::output::escaped;

#[derive(clap::Args)]
pub struct Arguments {
    /// The flight configuration: ports, mounting, servos, telemetry
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// The record to write [default: a file named after the time, in the configured directory]
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// End after this many seconds; otherwise SIGTERM ends the flight, or Ctrl-C, with servos only twice within 2 s
    #[arg(long, value_name = "SECONDS", value_parser = crate::arguments::duration)]
    duration: Option<f64>,
}

/// Signals whose default action ends or stops a program.
const SURVIVED: [i32; 12] = [
    SIGHUP, SIGUSR1, SIGUSR2, SIGXFSZ, SIGXCPU, SIGTSTP, SIGTTIN, SIGTTOU, SIGALRM, SIGVTALRM,
    SIGPROF, SIGIO,
];
/// Number of lines that are queued while a terminal is stuck.
const LINES: usize = 256;

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let mut config = read_fly_config(&arguments.config)?;
    let unix_s = SystemTime::now().duration_since(UNIX_EPOCH)?.as_secs().cast_signed();
    let remark = config.settle(unix_s).with_context(|| arguments.config.display().to_string())?;
    let beside = arguments.config.parent().unwrap_or(Path::new(""));
    config.load_autopilot(beside).with_context(|| arguments.config.display().to_string())?;
    try_gains(&config, beside).with_context(|| arguments.config.display().to_string())?;
    let record = arguments.record.clone().unwrap_or_else(|| config.record_path(unix_s));
    if let Some(directory) = record.parent() {
        // If the directory cannot be created, the record cannot be created either, and that is reported.
        let _ = std::fs::create_dir_all(directory);
    }

    // A closed or stopped terminal, a stray signal, or a limit of file size or processor time must not end a flight.
    for signal in SURVIVED {
        signal_hook::flag::register(signal, Arc::new(AtomicBool::new(false)))?;
    }
    let is_armed = config.servo.stream.is_some()
        || config.servo.output.iter().any(|(_, output)| output.is_some());
    let stop = if is_armed {
        crate::stop::when_asked_twice(&[SIGTERM, SIGQUIT], ask_again)?
    } else {
        crate::stop::when_asked(&[SIGINT, SIGTERM, SIGQUIT])?
    };
    crate::stop::after(arguments.duration, &stop);
    let (sender, notifications) = sync_channel(LINES);
    // Only this thread writes to the terminal during the flight: a stuck terminal must not block the flight.
    let recording = format!("record: {}", record.display());
    let opening: Vec<String> = remark.into_iter().chain([recording]).collect();
    let printer = thread::spawn(move || print(&opening, &notifications));
    let report = fly(&config, &record, &Clock::start(), &stop, sender)
        .with_context(|| arguments.config.display().to_string())?;
    // The report follows the last lines. Neither of them may block the end of the program.
    await_at_most_1_s(&printer);
    let place = if report.record.is_absent {
        "no file: the flight was not recorded".into()
    } else {
        record.display().to_string()
    };
    let text = format!("{report}\n  in                {place}");
    await_at_most_1_s(&thread::spawn(move || crate::output::say(text)));
    Ok(())
}

fn await_at_most_1_s(thread: &JoinHandle<()>) {
    for _ in 0..100 {
        if thread.is_finished() {
            break;
        }
        thread::sleep(Duration::from_millis(10));
    }
}

/// Asks for a second Ctrl-C, in a separate thread because the terminal may be stuck.
fn ask_again() {
    thread::spawn(|| {
        crate::output::complain(
            "the vehicle is armed: press Ctrl-C again within 2 s to end the flight; SIGTERM ends it at once",
        );
    });
}

fn print(opening: &[String], notifications: &Receiver<Notification>) {
    let quiet = crate::output::is_quiet();
    // A write error is ignored: the terminal may be gone.
    for line in opening.iter().filter(|_| !quiet) {
        let _ = writeln!(stderr(), "{}", escaped(line));
    }
    for Notification { time, level, part, text, .. } in notifications {
        if quiet && level < Level::Error {
            continue;
        }
        let level = match level {
            Level::Info => "",
            Level::Warning => "warning: ",
            Level::Error => "error: ",
            Level::Critical => "CRITICAL: ",
        };
        // The sensor or function that caused the message; it is omitted at the level of information.
        let whose = if level.is_empty() { String::new() } else { format!(" [{}]", part.name()) };
        // A write error is ignored: the terminal may be gone.
        let line = format!("{:9.3}  {level}{text}{whose}", time.seconds());
        let _ = writeln!(stderr(), "{}", escaped(&line));
    }
}

/// Checks that the gains are stable in every mode with the model that the configuration names. Rejects unstable gains.
#[cfg(feature = "lab")]
fn try_gains(config: &FlyConfig, beside: &Path) -> anyhow::Result<()> {
    let section = config.autopilot.as_ref();
    let Some((name, flown)) = section.and_then(|own| Some((own.model.as_ref()?, own.flown?)))
    else {
        return Ok(());
    };
    let shipped = name.to_str().and_then(hovernav_model::shipped::by_name);
    let model = match shipped {
        Some(model) => model,
        None => {
            hovernav_model::StateSpace::read(&beside.join(name)).context("[autopilot] model")?
        }
    };
    crate::arguments::refuse_unflyable(
        &model,
        &format!("[autopilot] model: {}", name.display()),
        "to fly gains of `hovernav design --force` without this check, remove `model`",
    )?;
    let design = HoverDesign {
        period_s: flown.period_s,
        guidance: flown.guidance,
        ..HoverDesign::for_model(&model)
    };
    for mode in FlightMode::ALL {
        let closed = design.close_in(&model, &flown.gains, mode, Cut::Actuators)?;
        anyhow::ensure!(
            closed.is_stable()?,
            "[autopilot] file: found gains that are unstable with {} in the mode {}, expected a stable loop",
            name.display(),
            mode.name()
        );
    }
    Ok(())
}

/// Checking gains needs the design crate, which this build lacks.
#[cfg(not(feature = "lab"))]
fn try_gains(config: &FlyConfig, _beside: &Path) -> anyhow::Result<()> {
    anyhow::ensure!(
        config.autopilot.as_ref().is_none_or(|section| section.model.is_none()),
        "[autopilot] model: found a model, but this build lacks the feature `lab`, which checks gains on a model"
    );
    Ok(())
}
