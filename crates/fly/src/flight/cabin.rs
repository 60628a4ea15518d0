//! What one flight keeps in hand between the sensors and everyone who is told of it.

use std::fmt;
use std::path::Path;
use std::sync::mpsc::SyncSender;

use super::downlink::{Downlink, Language};
use super::report::FlightReport;
use super::run::FlyError;
use super::run::Told;
use super::servos::{ServoEvent, Servos};
use crate::Mavlink;
use crate::serial::{Clock, Parity, Port, PortConfig, PortEvent, WriteError};
use hovernav::dmu::Measurement;
use hovernav::ekf::layout::Full;
use hovernav::ekf::{Estimator, Notice, Solution};
use hovernav::event::Event;
use hovernav::sensors::Report;
use hovernav::servo::Signal;
use hovernav::telemetry::{Flow, GpsSummary, Health, Mode, Snapshot};
use hovernav::time::Time;
use hovernav_log::FlyConfig;
use hovernav_log::record::{Entry, Header, Level, Line, Recorder, ShortText};

/// A cycle where the inertial unit does not set its length, s: 33 Hz.
const CYCLE_S: f64 = 1.0 / 33.0;

/// Without a sample for this many cycles the loop goes on by the clock.
const CYCLES_WITHOUT_SAMPLE: f64 = 1.5;

/// A sample older than this is no news, s.
const SAMPLE_FRESH_S: f64 = 0.15;

/// A receiver without a good fix for this long counts as lost, s.
const FIX_FRESH_S: f64 = 3.0;

/// What is good enough to fly by, one-sigma: tilt and heading, rad; velocity, m/s; position, m.
const TILT_GOOD_RAD: f64 = 0.05;
const HEADING_GOOD_RAD: f64 = 0.26;
const VELOCITY_GOOD_MPS: f64 = 1.0;
const POSITION_GOOD_M: f64 = 20.0;

/// The estimator, the servos, the record and the telemetry of a flight.
pub struct Cabin {
    pub recorder: Recorder,
    estimator: Estimator<Full, 28>,
    servos: Servos,
    telemetry: Option<Downlink>,
    mavlink: Option<Downlink>,
    console: SyncSender<Told>,
    cycle_s: f64,
    snapshot: Snapshot,
    report: FlightReport,
    /// Arrival and time of the last sample.
    sample: Option<(Time, Time)>,
    /// Arrival of the last good fix.
    fix: Option<Time>,
    /// When the last cycle was.
    cycle: Time,
    /// When the loop woke and last went to rest, and what it has worked since the last cycle, s.
    woke: Time,
    rested: Time,
    work_s: f64,
    cycle_done: bool,
    woke_late: bool,
    gps_good: bool,
    record_good: bool,
    commands_lost: bool,
}

impl Cabin {
    pub fn new(
        config: &FlyConfig,
        record: &Path,
        clock: Clock,
        start: Time,
        unix_ns: i64,
        console: SyncSender<Told>,
    ) -> Result<Self, FlyError> {
        let line = |path: &Path, baud| {
            let path = path.to_string_lossy().into_owned();
            Port::new(PortConfig { path, baud, parity: Parity::None }, clock)
        };
        let telemetry = config.telemetry.as_ref().map(|section| {
            let port = line(&section.port, section.baud);
            Downlink::spawn(port, clock, Language::Packed(Flow::default()))
        });
        let mavlink = config.mavlink.as_ref().map(|section| {
            let mut speaker = Mavlink::new(section.speaker, start);
            speaker.set_utc(unix_ns, start);
            let port = line(&section.port, section.baud);
            Downlink::spawn(port, clock, Language::Mavlink(Box::new(speaker)))
        });
        let servos = Servos::open(config, clock)?;
        let header = Header::new(config.clone(), start, unix_ns);
        Ok(Self {
            estimator: Estimator::new(config.settings()?),
            servos,
            telemetry: telemetry.transpose()?,
            mavlink: mavlink.transpose()?,
            console,
            cycle_s: config.dmu.rate_hz.map_or(CYCLE_S, |rate_hz| 1.0 / rate_hz),
            snapshot: Snapshot::at(start),
            report: FlightReport::default(),
            sample: None,
            fix: None,
            cycle: start,
            woke: start,
            rested: start,
            work_s: 0.0,
            cycle_done: false,
            woke_late: false,
            gps_good: false,
            record_good: true,
            commands_lost: false,
            recorder: Recorder::create(record, &header)?,
        })
    }

    /// When the loop is to come round though no sample did.
    pub fn due(&self) -> Time {
        self.cycle + CYCLES_WITHOUT_SAMPLE * self.cycle_s
    }

    /// The loop is about to wait.
    pub fn rests(&mut self, now: Time) {
        self.work_s += now - self.woke;
        self.rested = now;
        if !std::mem::take(&mut self.cycle_done) {
            return;
        }
        let late = std::mem::take(&mut self.woke_late);
        let on_time = !late && self.work_s <= self.cycle_s;
        if !on_time {
            self.report.missed_deadlines += 1;
            let late = if late { ", and began late" } else { "" };
            let text = format_args!("a cycle took {:.1} ms of work{late}", 1e3 * self.work_s);
            self.event(now, Level::Warning, "deadline_missed", text);
        }
        let timing = &mut self.snapshot.timing;
        timing.work_s = Some(self.work_s);
        timing.longest_work_s = Some(timing.longest_work_s.unwrap_or(0.0).max(self.work_s));
        timing.overruns = u32::try_from(self.report.missed_deadlines).unwrap_or(u32::MAX);
        self.snapshot.health.on_time = on_time;
        self.report.work.add(self.work_s);
        self.work_s = 0.0;
    }

    /// The loop has been woken, at a time that it had asked for or by bytes.
    pub fn wakes(&mut self, now: Time, asked: Option<Time>) {
        self.woke = now;
        if let Some(asked) = asked {
            // A moment that was past when it was asked for says nothing of the wait.
            let late_s = now - asked.max(self.rested);
            self.report.wake.add(late_s);
            self.woke_late |= late_s > 0.5 * self.cycle_s;
        }
    }

    /// What a line's bytes came to.
    pub fn take(&mut self, now: Time, report: Report) {
        self.recorder.push(now, report);
        match report {
            Report::Measured(_, measurement) => self.measured(&measurement),
            Report::Event(event @ Event::Imu(_)) => self.sample(now, &event),
            Report::Event(event) => {
                self.report.fixes += 1;
                self.fix = Some(now);
                self.estimate(now, &event);
            }
            Report::DmuLost(_, fault) => {
                self.report.dmu_restarts += 1;
                self.tell(now, Level::Warning, format_args!("inertial unit: {fault}"));
            }
            Report::Implausible(_, what) => {
                self.tell(now, Level::Warning, format_args!("inertial unit: {what}"));
            }
            Report::DmuClock(_, fault) => {
                self.tell(now, Level::Warning, format_args!("inertial unit: {fault}"));
            }
            Report::Fix(fix, failures) => {
                self.snapshot.gps = GpsSummary::of(&fix, now);
                for failure in failures.iter() {
                    self.tell(now, Level::Warning, format_args!("fix refused: {failure}"));
                }
            }
            Report::FixWithoutHeight(_) => {
                let text = "a fix without height above the ellipsoid; set geoid_separation_m";
                self.tell(now, Level::Warning, text);
            }
            Report::WriteDmu(_) | Report::WriteGps(_) => {}
        }
    }

    fn measured(&mut self, measurement: &Measurement) {
        self.snapshot.temperature_degc = Some(measurement.temperature_degc);
        self.snapshot.magnetic_field_gauss = Some(measurement.magnetic_field_gauss);
    }

    /// A cycle of the loop.
    fn sample(&mut self, now: Time, event: &Event) {
        let Event::Imu(sample) = event else { return };
        let before = self.sample.replace((now, sample.time));
        let interval_s = before.map_or(self.cycle_s, |(_, time)| sample.time - time);
        if let Some((arrival, time)) = before {
            let period_s = now - arrival;
            self.snapshot.timing.period_s = Some(period_s);
            self.report.jitter.add((period_s - (sample.time - time)).abs());
        }
        self.report.cycles += 1;
        self.estimate(now, event);
        self.snapshot = self.snapshot.with_imu(sample, interval_s);
        if let Some(solution) = self.estimator.solution() {
            self.recorder.push(now, solution);
            self.snapshot = self.snapshot.with_solution(&solution);
            self.judge(&solution);
        }
        self.cycle_done = true;
        self.control(now);
    }

    /// A cycle by the clock, if samples stay away.
    pub fn cycle_without_sample(&mut self, now: Time) {
        if now >= self.due() {
            self.control(now);
        }
    }

    fn estimate(&mut self, now: Time, event: &Event) {
        let Self { estimator, recorder, snapshot, console, .. } = self;
        estimator.push(event, |notice| {
            recorder.push(now, notice);
            let text = match &notice {
                Notice::Updated(report) => {
                    report.innovations().for_each(|one| snapshot.innovations.note(one));
                    return;
                }
                Notice::Aligned(alignment) => ShortText::new(format_args!(
                    "aligned after {:.1} s, heading by {:?}",
                    alignment.duration_s, alignment.heading
                )),
                Notice::HeadingFound { sigma_rad, .. } => ShortText::new(format_args!(
                    "heading found, one-sigma {:.1} deg",
                    sigma_rad.to_degrees()
                )),
                Notice::FixUnusable(_, reason) => {
                    ShortText::new(format_args!("fix not used: {reason}"))
                }
                Notice::ImuFault(_, fault) => {
                    ShortText::new(format_args!("inertial sample: {fault}"))
                }
            };
            let level = match &notice {
                Notice::Aligned(_) | Notice::HeadingFound { .. } => Level::Info,
                _ => Level::Warning,
            };
            let _ = console.try_send(Told { time: now, level, text });
        });
    }

    fn judge(&mut self, solution: &Solution) {
        let sigmas = &self.snapshot.sigmas;
        let below = |sigma: Option<f64>, limit| sigma.is_some_and(|sigma| sigma < limit);
        let health = &mut self.snapshot.health;
        health.attitude = below(sigmas.tilt_rad, TILT_GOOD_RAD);
        health.heading = below(sigmas.heading_rad, HEADING_GOOD_RAD);
        health.velocity = below(sigmas.horizontal_velocity_mps, VELOCITY_GOOD_MPS)
            && below(sigmas.vertical_velocity_mps, VELOCITY_GOOD_MPS);
        health.position =
            below(sigmas.horizontal_m, POSITION_GOOD_M) && solution.position.is_navigable();
    }

    /// The pilot's commands to the servos, and everyone told.
    fn control(&mut self, now: Time) {
        self.cycle = now;
        let Self { servos, recorder, console, .. } = self;
        let widths = servos.pass_through(now, |event| {
            let (level, kind, text) = match event {
                ServoEvent::Raw(bytes, arrival) => {
                    recorder.raw(Line::Servo, bytes, arrival);
                    return;
                }
                ServoEvent::Port(event) => (
                    port_level(&event),
                    "servo_port",
                    ShortText::new(format_args!("pilot: {event}")),
                ),
                ServoEvent::Signal(Signal::Good) => {
                    (Level::Info, "pilot_signal", ShortText::new("the pilot's signal is there"))
                }
                ServoEvent::Signal(Signal::Stale(channel)) => (
                    Level::Error,
                    "pilot_signal",
                    ShortText::new(format_args!("no pulses of the pilot's {channel}")),
                ),
                ServoEvent::Signal(Signal::Failsafe) => {
                    (Level::Error, "pilot_signal", ShortText::new("the pilot's signal is lost"))
                }
                ServoEvent::Failed(why) => (Level::Error, "servos", ShortText::new(why)),
            };
            recorder.push(now, Entry::Event { level, kind, text });
            let _ = console.try_send(Told { time: now, level, text });
        });
        if widths.commanded_ms != self.snapshot.commanded_ms
            || widths.pilot_ms != self.snapshot.pilot_ms
        {
            let ms = |width_ms: Option<f64>| width_ms.unwrap_or(f64::NAN) as f32;
            let entry = Entry::Servo {
                captured_ms: widths.pilot_ms.map(ms).to_array(),
                commanded_ms: widths.commanded_ms.map(ms).to_array(),
            };
            self.recorder.push(now, entry);
        }
        if let Some(sticks) = self.servos.sticks(&widths.pilot_ms) {
            self.recorder.push(now, Entry::Controls(sticks));
        }
        self.snapshot.pilot_ms = widths.pilot_ms;
        self.snapshot.commanded_ms = widths.commanded_ms;
        self.snapshot.drops.pilot_pulses = widths.pulses_lost;
        let health = &mut self.snapshot.health;
        health.pilot_signal = widths.signal_good;
        health.receiver_failsafe = widths.receiver_failsafe;
        health.servos = widths.servos_good;
        self.report_to_ground(now);
    }

    fn report_to_ground(&mut self, now: Time) {
        let imu = self.sample.is_some_and(|(arrival, _)| now - arrival < SAMPLE_FRESH_S);
        let gps = self.fix.is_some_and(|arrival| now - arrival < FIX_FRESH_S);
        if std::mem::replace(&mut self.gps_good, gps) != gps {
            let (level, text) = if gps {
                (Level::Info, "fixes come")
            } else {
                (Level::Warning, "no good fix for 3 s")
            };
            self.event(now, level, "gps_fixes", text);
        }
        let status = self.recorder.status();
        let before = self.report.record;
        // What has been refused waits until it is written; what is lost is lost for good.
        let good = status.bytes_waiting == 0
            && status.lost_raw == before.lost_raw
            && status.lost_decoded == before.lost_decoded;
        self.report.record = status;
        if std::mem::replace(&mut self.record_good, good) != good {
            let (level, text) = match (good, status.os_error) {
                (true, _) => (Level::Info, ShortText::new("the record is written again")),
                (false, Some(number)) => (
                    Level::Error,
                    ShortText::new(format_args!(
                        "the record is not written: {}",
                        std::io::Error::from_raw_os_error(number)
                    )),
                ),
                (false, None) => (Level::Error, ShortText::new("the record loses entries")),
            };
            self.event(now, level, "record", text.as_str());
        }
        let snapshot = &mut self.snapshot;
        snapshot.time = now;
        snapshot.mode = match (self.estimator.solution(), self.estimator.filter()) {
            (None, _) if self.sample.is_none() => Mode::Starting,
            (None, _) => Mode::Aligning,
            (Some(_), None) => Mode::SearchingHeading,
            (Some(_), Some(_)) => Mode::Pilot,
        };
        snapshot.health = Health { imu, gps, recorder: good, ..snapshot.health };
        snapshot.gps.age_s = self.fix.map(|arrival| (now - arrival).max(0.0));
        for downlink in self.telemetry.iter().chain(&self.mavlink) {
            downlink.offer(snapshot);
        }
        snapshot.innovations.clear();
    }

    /// What became of a command to the inertial unit; told when it changes.
    pub fn dmu_written(&mut self, now: Time, written: &Result<(), WriteError>) {
        let lost = matches!(written, Err(WriteError::Stuck { .. } | WriteError::Lost(_)));
        if let Err(error) = written
            && lost
            && !self.commands_lost
        {
            self.event(now, Level::Warning, "dmu_command", format_args!("inertial unit: {error}"));
        }
        self.commands_lost = lost;
    }

    /// A port changed.
    pub fn port(&mut self, now: Time, kind: &'static str, whose: &str, event: &PortEvent) {
        self.event(now, port_level(event), kind, format_args!("{whose}: port {event}"));
    }

    /// Records an event and tells it.
    pub fn event(&mut self, now: Time, level: Level, kind: &'static str, text: impl fmt::Display) {
        let text = ShortText::new(text);
        self.recorder.push(now, Entry::Event { level, kind, text });
        let _ = self.console.try_send(Told { time: now, level, text });
    }

    /// Tells what is recorded otherwise.
    fn tell(&self, now: Time, level: Level, text: impl fmt::Display) {
        let _ = self.console.try_send(Told { time: now, level, text: ShortText::new(text) });
    }

    pub fn end(self) -> FlightReport {
        let mut report = self.report;
        let counts = |downlink: &Option<Downlink>| {
            downlink.as_ref().map(Downlink::counts).unwrap_or_default()
        };
        report.telemetry = counts(&self.telemetry);
        report.mavlink = counts(&self.mavlink);
        report.record = self.recorder.finish();
        report
    }
}

fn port_level(event: &PortEvent) -> Level {
    if *event == PortEvent::Opened { Level::Info } else { Level::Warning }
}
