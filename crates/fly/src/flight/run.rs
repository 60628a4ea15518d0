//! The loop.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::time::{SystemTime, UNIX_EPOCH};

use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

use super::cabin::Cabin;
use super::report::FlightReport;
use crate::serial::{Clock, Item, Parity, Port, PortConfig, PortEvent, Read, Reader};
use crate::servo::{GpioError, PwmError};
use hovernav::sensors::{Report, Sensors};
use hovernav::servo::ConfigError;
use hovernav::time::Time;
use hovernav_log::LogError;
use hovernav_log::record::{Entry, Level, Line, ShortText};
use hovernav_log::{FlyConfig, FlyConfigError, ReceiverProtocol};

/// How long a command to the inertial unit may take to be handed to the line, s.
const WRITE_S: f64 = 0.005;

/// Pieces of the receiver's stream that may wait: half a minute of them.
const QUEUE: usize = 1024;

/// Something to tell whoever watches.
#[derive(Clone, Copy, Debug)]
pub struct Told {
    /// When, on the flight's clock.
    pub time: Time,
    /// How much it matters.
    pub level: Level,
    /// In words.
    pub text: ShortText,
}

/// What keeps a flight from beginning.
#[derive(Debug, thiserror::Error)]
pub enum FlyError {
    /// A setting cannot be.
    #[error(transparent)]
    Config(#[from] FlyConfigError),
    /// A servo's setting cannot be.
    #[error("[servo] {0}")]
    Servo(#[from] ConfigError),
    /// The pilot's lines cannot be had.
    #[error("[servo.capture] {0}")]
    Gpio(#[from] GpioError),
    /// A servo's output cannot be had.
    #[error("[servo.output] {0}")]
    Pwm(#[from] PwmError),
    /// The record cannot be begun.
    #[error(transparent)]
    Record(#[from] LogError),
    /// The system gives no thread.
    #[error("no thread: {0}")]
    Thread(#[from] io::Error),
}

/// Flies until `stop` is set: reads the sensors, estimates, passes the pilot on to the servos, records
/// and tells the ground. `record` is the file to write. What happens on the way is told to
/// `console`; where that is full, the flight does not wait for it.
///
/// The loop is one thread, paced by the inertial unit's packets. Each other line has a thread of its
/// own with a bounded queue or a single place between, and so has the record, so that none of them
/// can hold the loop up. Without the unit, the loop goes on at 33 Hz with the pilot alone.
///
/// # Errors
/// What keeps a flight from beginning: see [`FlyError`]. Nothing ends it but `stop`.
pub fn fly(
    config: &FlyConfig,
    record: &Path,
    stop: &AtomicBool,
    console: SyncSender<Told>,
) -> Result<FlightReport, FlyError> {
    let clock = Clock::start();
    let unix = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let unix_ns = i64::try_from(unix.as_nanos()).unwrap_or(i64::MAX);
    let (dmu, gps) = config.sensors()?;
    let port = |path: &PathBuf, baud, parity| {
        let path = path.to_string_lossy().into_owned();
        Port::new(PortConfig { path, baud, parity }, clock)
    };
    let start = clock.now();
    let mut flight = Flight {
        clock,
        port: port(&config.dmu.port, config.dmu.baud, Parity::None),
        receiver: Reader::spawn(
            port(&config.receiver.port, config.receiver.baud(), parity(config.receiver.protocol)),
            clock,
            QUEUE,
        )?,
        sensors: Sensors::new(dmu, gps, start),
        cabin: Cabin::new(config, record, clock, start, unix_ns, console)?,
    };
    if let Some(priority) = config.realtime_priority {
        flight.take_priority(priority);
    }
    flight.run(stop);
    Ok(flight.end(start))
}

/// The parity bit of a receiver's line: odd of TSIP, as Trimble sends it.
const fn parity(protocol: ReceiverProtocol) -> Parity {
    match protocol {
        ReceiverProtocol::Tsip => Parity::Odd,
        ReceiverProtocol::Nmea | ReceiverProtocol::Ubx => Parity::None,
    }
}

struct Flight {
    clock: Clock,
    port: Port,
    receiver: Reader,
    sensors: Sensors,
    cabin: Cabin,
}

impl Flight {
    fn run(&mut self, stop: &AtomicBool) {
        let mut buffer = [0; 512];
        let mut until = self.dmu(&[], self.clock.now());
        while !stop.load(Ordering::Relaxed) {
            let wake = until.min(self.cabin.due());
            self.cabin.rests(self.clock.now());
            let read = self.port.read_until(&mut buffer, wake);
            let now = self.clock.now();
            self.cabin.wakes(now, matches!(read, Read::Silent).then_some(wake));
            self.receiver();
            match read {
                Read::Bytes { count, arrival } => until = self.dmu(&buffer[..count], arrival),
                Read::Silent if now >= until => until = self.dmu(&[], now),
                Read::Silent => {}
                Read::Changed(event) => self.cabin.port(now, "dmu_port", "inertial unit", &event),
            }
            self.cabin.cycle_without_sample(now);
        }
    }

    fn take_priority(&mut self, priority: u8) {
        let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        let taken = ThreadPriorityValue::try_from(priority).and_then(|value| {
            let priority = ThreadPriority::Crossplatform(value);
            set_thread_priority_and_policy(thread_native_id(), priority, policy)
                .map_err(|error| error.to_string())
        });
        let now = self.clock.now();
        match taken {
            Ok(()) => {
                let text = format_args!("the loop has real-time priority {priority}");
                self.cabin.event(now, Level::Info, "priority", text);
            }
            Err(error) => {
                let text = format_args!("no real-time priority for the loop: {error}");
                self.cabin.event(now, Level::Warning, "priority", text);
            }
        }
    }

    /// A call of the sensors with bytes of the inertial unit; returns until when to read.
    fn dmu(&mut self, bytes: &[u8], now: Time) -> Time {
        let Self { clock, port, sensors, cabin, .. } = self;
        cabin.recorder.raw(Line::Dmu, bytes, now);
        sensors.dmu(bytes, now, |report| match report {
            Report::WriteDmu(command) => {
                let written = port.write(&[command.byte()], clock.now() + WRITE_S);
                cabin.dmu_written(now, &written);
            }
            report => cabin.take(now, report),
        })
    }

    /// Whatever the receiver has sent meanwhile.
    fn receiver(&mut self) {
        let Self { clock, receiver, sensors, cabin, .. } = self;
        while let Some(item) = receiver.receive(Time::ZERO) {
            match item {
                Item::Bytes { arrival, bytes } => {
                    cabin.recorder.raw(Line::Gps, &bytes, arrival);
                    sensors.gps(&bytes, arrival, |report| match report {
                        Report::WriteGps(command) => {
                            if !receiver.write(command.as_bytes()) {
                                let text = "a command to the receiver found no room";
                                cabin.event(arrival, Level::Warning, "gps_command", text);
                            }
                        }
                        report => cabin.take(arrival, report),
                    });
                }
                Item::Changed(event) => {
                    let now = clock.now();
                    cabin.port(now, "gps_port", "receiver", &event);
                    if event == PortEvent::Opened {
                        sensors.restart_gps();
                        cabin.recorder.push(now, Entry::GpsRestarted);
                    }
                }
                Item::NotWritten(error) => {
                    let text = format_args!("receiver: {error}");
                    cabin.event(clock.now(), Level::Warning, "gps_command", text);
                }
            }
        }
    }

    fn end(self, start: Time) -> FlightReport {
        let now = self.clock.now();
        let tally = *self.sensors.link().tally();
        let mut report = self.cabin.end();
        report.duration_s = now - start;
        report.dmu_packets_missing = tally.packets_missing;
        report.dmu_port = self.port.counts();
        report.gps_port = self.receiver.counts();
        report.gps_messages = self.sensors.gps_counts();
        report.gps_dropped = self.receiver.dropped();
        report
    }
}
