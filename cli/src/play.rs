//! `hovernav play`: replays a log over pseudo-terminals, as its sensors sent it.

use std::path::PathBuf;
use std::str::FromStr;

use hovernav::gps::Protocol;
use hovernav::time::Time;

use crate::arguments::{finite, within};

#[derive(clap::Args)]
pub struct Arguments {
    /// A dataset directory, a flight record or a log of any other format
    log: PathBuf,
    /// Path of the port to create for the inertial unit
    #[arg(long, value_name = "PATH", required_unless_present = "gps")]
    dmu: Option<PathBuf>,
    /// Path of the port to create for the GPS receiver
    #[arg(long, value_name = "PATH")]
    gps: Option<PathBuf>,
    /// Protocol of the GPS receiver
    #[arg(long, value_enum, default_value_t = ProtocolArgument::Ubx)]
    gps_protocol: ProtocolArgument,
    /// Speed of the replay, as a factor of real time
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = within(0.001, 1000.0, ""))]
    speed: f64,
    /// Cut the wire of `dmu` or `gps` at START for DURATION, in seconds of the log's clock; may be repeated
    #[arg(long, value_name = "WHAT=START:DURATION")]
    cut: Vec<SensorWindow>,
    /// Unplug the port of `dmu` or `gps` at START and plug it in again after DURATION, in seconds of the log's clock;
    /// may be repeated
    #[arg(long, value_name = "WHAT=START:DURATION")]
    pull: Vec<SensorWindow>,
    /// Start this many seconds after the ports exist [default: start when the ports are open and packets are requested
    /// from the inertial unit]
    #[arg(long, value_name = "SECONDS", value_parser = delay)]
    start_delay: Option<f64>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum ProtocolArgument {
    Nmea,
    Tsip,
    Ubx,
}

impl From<ProtocolArgument> for Protocol {
    fn from(language: ProtocolArgument) -> Self {
        match language {
            ProtocolArgument::Nmea => Self::Nmea,
            ProtocolArgument::Tsip => Self::Tsip,
            ProtocolArgument::Ubx => Self::Ubx,
        }
    }
}

/// Time window of one sensor in the form `WHAT=START:DURATION`.
#[derive(Clone, Copy)]
#[cfg_attr(not(unix), expect(dead_code, reason = "only Unix systems can replay a log"))]
struct SensorWindow {
    sensor: Sensor,
    start: Time,
    duration_s: f64,
}

#[derive(Clone, Copy, PartialEq)]
enum Sensor {
    Dmu,
    Gps,
}

impl FromStr for SensorWindow {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected =
            || format!("found \"{text}\", expected dmu=START:DURATION or gps=… in seconds");
        let (what, window) = text.split_once('=').ok_or_else(expected)?;
        let (start, duration) = window.split_once(':').ok_or_else(expected)?;
        let sensor = match what.trim() {
            "dmu" => Sensor::Dmu,
            "gps" => Sensor::Gps,
            _ => return Err(expected()),
        };
        let start = finite(start).and_then(Time::try_from_seconds).ok_or_else(expected)?;
        let duration_s =
            finite(duration).filter(|&duration| duration > 0.0).ok_or_else(expected)?;
        Ok(Self { sensor, start, duration_s })
    }
}

fn delay(text: &str) -> Result<f64, String> {
    let delay = text.parse().ok().filter(|delay: &f64| (0.0..=86_400.0).contains(delay));
    delay.ok_or_else(|| format!("found \"{text}\", expected 0 to 86400 seconds"))
}

#[cfg(not(unix))]
pub fn run(_arguments: &Arguments) -> anyhow::Result<()> {
    anyhow::bail!("play needs pseudo-terminals, which only Unix systems have")
}

#[cfg(unix)]
pub use unix::run;

#[cfg(unix)]
mod unix {
    use std::sync::atomic::Ordering;
    use std::thread;
    use std::time::Duration;

    use anyhow::Context as _;
    use hovernav_fly::play;
    use hovernav_fly::play::{Begin, Cut, CutKind, EmulatedPort, Player};
    use hovernav_fly::serial::Clock;
    use hovernav_formats::Options;
    use signal_hook::consts::{SIGINT, SIGTERM};

    use super::{Arguments, Sensor};
    use crate::memory;

    pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
        let dataset = memory::open(&arguments.log, &Options::default(), 1)?.dataset;
        for warning in &dataset.warnings {
            crate::output::complain(format_args!("warning: {warning}"));
        }
        let interrupted = crate::stop::when_asked(&[SIGINT, SIGTERM])?;

        let mut ports = Vec::new();
        let mut names = Vec::new();
        if let Some(path) = &arguments.dmu {
            print_ranges(&dataset);
            let port = EmulatedPort::new(path, play::dmu(&dataset)?);
            ports.push(EmulatedPort { cuts: cuts(arguments, Sensor::Dmu), ..port });
            names.push(("dmu", path));
        }
        if let Some(path) = &arguments.gps {
            let port = EmulatedPort::new(path, play::gps(&dataset, arguments.gps_protocol.into()));
            ports.push(EmulatedPort { cuts: cuts(arguments, Sensor::Gps), ..port });
            names.push(("gps", path));
        }
        let begin = match arguments.start_delay {
            Some(seconds) => Begin::After(Duration::from_secs_f64(seconds)),
            None => Begin::WhenAsked,
        };
        let clock = Clock::at_speed(arguments.speed).context("--speed: expected 0.001 to 1000")?;
        let player = Player::start(ports, &clock, begin)?;
        let ports: Vec<String> =
            names.iter().map(|(name, path)| format!("{name} at {}", path.display())).collect();
        crate::output::say(format_args!("ready: {}", ports.join(", ")));

        while !player.is_finished() && !interrupted.load(Ordering::Relaxed) {
            thread::sleep(Duration::from_millis(20));
        }
        let elapsed_s = player.elapsed_s().unwrap_or_default();
        let counts = player.stop()?;
        crate::output::say(format_args!("played {elapsed_s:.1} s"));
        for ((name, _), counts) in names.iter().zip(counts) {
            crate::output::say(format_args!(
                "{name}: {} bytes sent, {} lost, {} received",
                counts.sent, counts.lost, counts.received
            ));
        }
        Ok(())
    }

    /// Prints the ranges of the inertial unit. The flight computer needs them, and the packets do not contain them.
    fn print_ranges(dataset: &hovernav_dataset::Dataset) {
        let imu = &dataset.manifest.imu;
        let (rate_degps, acceleration_g) = play::DEFAULT_RANGES;
        crate::output::say(format_args!(
            "dmu: ranges {} deg/s and {} g",
            imu.gyro_range_degps.unwrap_or(rate_degps),
            imu.accel_range_g.unwrap_or(acceleration_g)
        ));
        if dataset.imu.iter().all(|sample| sample.attitude.is_none()) {
            crate::output::complain(
                "warning: the log has no attitude: packets of angle mode carry zeros for it",
            );
        }
        if dataset.imu.iter().all(|sample| sample.magnetic_field_gauss.is_none()) {
            crate::output::complain(
                "warning: the log has no magnetic field: packets carry zeros for it",
            );
        }
    }

    fn cuts(arguments: &Arguments, sensor: Sensor) -> Vec<Cut> {
        let wires = arguments.cut.iter().map(|window| (window, CutKind::Wire));
        let adapters = arguments.pull.iter().map(|window| (window, CutKind::Adapter));
        wires
            .chain(adapters)
            .filter(|(window, _)| window.sensor == sensor)
            .map(|(window, kind)| Cut { start: window.start, duration_s: window.duration_s, kind })
            .collect()
    }
}
