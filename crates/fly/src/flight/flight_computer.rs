//! The flight computer: the sensors' lines and the flight loop.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;

use super::error::FlyError;
use super::flight_loop::FlightLoop;
use super::notification::Notification;
use super::port_name::PortName;
use super::realtime::take_priority;
use super::report::FlightReport;
use crate::serial::{Clock, Item, Parity, Port, PortConfig, PortEvent, Read, Reader};
use hovernav::sensors::{SensorOutput, Sensors};
use hovernav::time::Time;
use hovernav_record::{Entry, FlyConfig, Level, Line, ReceiverProtocol};

/// Timeout for writing a command to the IMU, s.
const WRITE_S: f64 = 0.005;

/// Length of the queue of the receiver's stream: half a minute.
const QUEUE: usize = 1024;

/// Flies by `clock` until `stop` is set: reads the sensors, estimates, commands the servos, records and sends
/// telemetry. `record` is the file to write. Events are sent to `notifications`; if that queue is full, they are
/// dropped and the flight does not wait.
///
/// The loop is one thread, paced by the packets of the IMU. Each other line, and the record, has its own thread behind
/// a bounded queue or a single slot, so it cannot block the loop. Without the IMU, the loop continues at 33 Hz with the
/// pilot only.
///
/// # Errors
/// [`FlyError`] if the flight cannot begin. A record that cannot be created is an error only with `[record] required`.
/// Otherwise it is reported, and the flight continues without a record. Once the flight has begun, only `stop` ends it.
pub fn fly(
    config: &FlyConfig,
    record: &Path,
    clock: &Clock,
    stop: &AtomicBool,
    notifications: SyncSender<Notification>,
) -> Result<FlightReport, FlyError> {
    let (dmu, gps) = config.sensors()?;
    let (start, unix_ns) = (clock.now(), clock.unix_ns());
    let receiver = PortConfig::new(&config.receiver.port, config.receiver.baud())
        .with_parity(parity(config.receiver.protocol));
    let mut computer = FlightComputer {
        clock: clock.clone(),
        dmu_port: Port::new(PortConfig::new(&config.dmu.port, config.dmu.baud), clock),
        dmu_name: PortName::new("inertial unit", "[dmu] port", &config.dmu.port),
        receiver: Reader::spawn(Port::new(receiver, clock), clock, QUEUE)?,
        gps_name: PortName::new("receiver", "[receiver] port", &config.receiver.port),
        sensors: Sensors::new(dmu, gps, start),
        flight: FlightLoop::new(config, record, clock, start, unix_ns, notifications)?,
    };
    if let Some(priority) = config.realtime_priority {
        computer.take_priority(priority);
    }
    computer.run(stop);
    Ok(computer.end(start))
}

/// The parity bit of a receiver's line: odd for TSIP, as on Trimble receivers.
const fn parity(protocol: ReceiverProtocol) -> Parity {
    match protocol {
        ReceiverProtocol::Tsip => Parity::Odd,
        ReceiverProtocol::Nmea | ReceiverProtocol::Ubx => Parity::None,
    }
}

/// The sensors' lines, their decoders, and the flight loop.
struct FlightComputer {
    clock: Clock,
    dmu_port: Port,
    dmu_name: PortName,
    receiver: Reader,
    gps_name: PortName,
    sensors: Sensors,
    flight: FlightLoop,
}

impl FlightComputer {
    fn run(&mut self, stop: &AtomicBool) {
        let mut buffer = [0; 512];
        let mut until = self.dmu(&[], self.clock.now());
        while !stop.load(Ordering::Relaxed) {
            let wake = until.min(self.flight.cycle_due());
            self.flight.begin_wait(self.clock.now());
            let read = self.dmu_port.read_until(&mut buffer, wake);
            let now = self.clock.now();
            self.flight.end_wait(now, matches!(read, Read::Silent).then_some(wake));
            self.receiver();
            match read {
                Read::Bytes { count, arrival } => until = self.dmu(&buffer[..count], arrival),
                Read::Silent if now >= until => until = self.dmu(&[], now),
                Read::Silent => {}
                Read::Changed(event) => {
                    self.flight.port(now, "dmu_port", &self.dmu_name, &event);
                }
            }
            self.flight.cycle_without_sample(now);
            if self.clock.is_emulated() {
                self.flight.log.recorder.catch_up();
            }
        }
    }

    fn take_priority(&mut self, priority: u8) {
        let now = self.clock.now();
        let (level, text) = match take_priority(priority) {
            Ok(()) => (Level::Info, format!("the loop has real-time priority {priority}")),
            Err(error) => (Level::Warning, format!("no real-time priority for the loop: {error}")),
        };
        self.flight.log.event(now, level, "priority", text);
    }

    /// Passes bytes of the IMU to the sensors; returns the deadline of the next read.
    fn dmu(&mut self, bytes: &[u8], now: Time) -> Time {
        let Self { clock, dmu_port, dmu_name, sensors, flight, .. } = self;
        flight.log.recorder.raw(Line::Dmu, bytes, now);
        flight.unit_bytes(now, bytes);
        sensors.dmu(bytes, now, |report| match report {
            SensorOutput::WriteDmu(command) => {
                let written = dmu_port.write(&[command.byte()], clock.now() + WRITE_S);
                flight.dmu_written(now, dmu_name, &written);
            }
            report => flight.handle(now, report),
        })
    }

    /// Handles all data that the receiver has sent.
    fn receiver(&mut self) {
        let Self { clock, receiver, gps_name, sensors, flight, .. } = self;
        while let Some(item) = receiver.receive(Time::ZERO) {
            match item {
                Item::Bytes { arrival, bytes } => {
                    flight.log.recorder.raw(Line::Gps, &bytes, arrival);
                    sensors.gps(&bytes, arrival, |report| match report {
                        SensorOutput::WriteGps(command) => {
                            if !receiver.write(command.as_bytes()) {
                                let text = "a command to the receiver was dropped: the queue is \
                                            full";
                                flight.log.event(arrival, Level::Warning, "gps_command", text);
                            }
                        }
                        report => flight.handle(arrival, report),
                    });
                }
                Item::Changed(event) => {
                    let now = clock.now();
                    flight.port(now, "gps_port", gps_name, &event);
                    if event == PortEvent::Opened {
                        sensors.restart_gps();
                        flight.log.recorder.push(now, Entry::GpsRestarted);
                    }
                }
                Item::NotWritten(error) => {
                    let text = gps_name.not_written(&error);
                    flight.log.event(clock.now(), Level::Warning, "gps_command", text);
                }
            }
        }
    }

    fn end(self, start: Time) -> FlightReport {
        let now = self.clock.now();
        let counts = *self.sensors.link().counts();
        let mut report = self.flight.end(now);
        report.duration_s = now - start;
        report.dmu_packets_missing = counts.packets_missing;
        report.dmu_port = self.dmu_port.counts();
        report.gps_port = self.receiver.counts();
        report.gps_messages = self.sensors.gps_counts();
        report.gps_dropped = self.receiver.dropped();
        report
    }
}
