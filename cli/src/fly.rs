//! `hovernav fly`: the real-time loop, until it is told to end.

use std::io::{Write as _, stderr};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::Context as _;
#[cfg(feature = "lab")]
use hovernav_design::hover::{Cut, FlightMode, HoverDesign};
use hovernav_fly::serial::Clock;
use hovernav_fly::{Notification, fly};
use hovernav_log::FlyConfig;
use hovernav_log::record::Level;
use signal_hook::consts::{
    SIGALRM, SIGHUP, SIGINT, SIGIO, SIGPROF, SIGQUIT, SIGTERM, SIGTSTP, SIGTTIN, SIGTTOU, SIGUSR1,
    SIGUSR2, SIGVTALRM, SIGXCPU, SIGXFSZ,
};

use crate::arguments::read_fly_config;

#[derive(clap::Args)]
pub struct Arguments {
    /// The flight's configuration: ports, mounting, servos, telemetry
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// Where to write the record; a file named after the time in the configured directory unless
    /// given
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// End after this many seconds; otherwise Ctrl-C or SIGTERM ends the flight
    #[arg(long, value_name = "SECONDS", value_parser = crate::arguments::duration)]
    duration: Option<f64>,
}

/// Signals that end or stop a program unless it says otherwise.
const SURVIVED: [i32; 12] = [
    SIGHUP, SIGUSR1, SIGUSR2, SIGXFSZ, SIGXCPU, SIGTSTP, SIGTTIN, SIGTTOU, SIGALRM, SIGVTALRM,
    SIGPROF, SIGIO,
];
/// Lines that may wait for a terminal that is stuck.
const LINES: usize = 256;

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let mut config = read_fly_config(&arguments.config)?;
    let unix_s = SystemTime::now().duration_since(UNIX_EPOCH)?.as_secs().cast_signed();
    let remark = config.settle(unix_s).with_context(|| arguments.config.display().to_string())?;
    // Nobody may be there to read it.
    if let Some(remark) = remark {
        let _ = writeln!(stderr(), "{remark}");
    }
    let beside = arguments.config.parent().unwrap_or(Path::new(""));
    config.load_autopilot(beside).with_context(|| arguments.config.display().to_string())?;
    try_gains(&config, beside).with_context(|| arguments.config.display().to_string())?;
    let record = arguments.record.clone().unwrap_or_else(|| config.record_path(unix_s));
    if let Some(directory) = record.parent() {
        std::fs::create_dir_all(directory)
            .with_context(|| format!("cannot create {}", directory.display()))?;
    }

    // A terminal that is gone or says stop, a stray signal, a limit of file or processor do not end a flight.
    for signal in SURVIVED {
        signal_hook::flag::register(signal, Arc::new(AtomicBool::new(false)))?;
    }
    let stop = crate::stop::when_asked(&[SIGINT, SIGTERM, SIGQUIT])?;
    crate::stop::after(arguments.duration, &stop);
    let (sender, notifications) = sync_channel(LINES);
    let printer = thread::spawn(move || print(&notifications));
    let _ = writeln!(stderr(), "recording to {}", record.display());
    let report = fly(&config, &record, &Clock::start(), &stop, sender)
        .with_context(|| arguments.config.display().to_string())?;
    // The last lines before the report; a terminal that is stuck keeps neither.
    for _ in 0..100 {
        if printer.is_finished() {
            break;
        }
        thread::sleep(Duration::from_millis(10));
    }
    crate::output::say(format_args!("{report}\n  in                {}", record.display()));
    Ok(())
}

fn print(notifications: &Receiver<Notification>) {
    for Notification { time, level, part, text, .. } in notifications {
        let level = match level {
            Level::Info => "",
            Level::Warning => "warning: ",
            Level::Error => "error: ",
            Level::Critical => "CRITICAL: ",
        };
        // Whose fault it is; what is as it should be is nobody's.
        let whose = if level.is_empty() { String::new() } else { format!(" [{}]", part.name()) };
        // Nobody may be there to read it.
        let _ = writeln!(stderr(), "{:9.3}  {level}{text}{whose}", time.seconds());
    }
}

/// Closes the loops of the autopilot around the model that the configuration names, and refuses those that are
/// unstable in a mode.
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
        "without `model` gains that `hovernav design --force` made of it are flown untried",
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
            "[autopilot] file: found gains that are unstable on {} holding {}, expected a stable loop",
            name.display(),
            mode.name()
        );
    }
    Ok(())
}

/// Gains cannot be tried without the part that designs them.
#[cfg(not(feature = "lab"))]
fn try_gains(config: &FlyConfig, _beside: &Path) -> anyhow::Result<()> {
    anyhow::ensure!(
        config.autopilot.as_ref().is_none_or(|section| section.model.is_none()),
        "[autopilot] model: found one, but this build lacks the feature `lab`, which tries gains on it"
    );
    Ok(())
}
