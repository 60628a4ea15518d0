//! The flight loop: estimate, command the servos, record, send telemetry.

use std::path::Path;
use std::sync::mpsc::SyncSender;

use super::cycle_timer::CycleTimer;
use super::downlink::Downlinks;
use super::error::FlyError;
use super::messages;
use super::notification::{EventLog, Notification};
use super::port_name::PortName;
use super::receiver_monitor::ReceiverMonitor;
use super::report::FlightReport;
use super::sensor_monitor::SensorMonitor;
use super::servos::{PilotState, Servos};
use super::utc::UtcClock;
use crate::serial::{Clock, PortEvent, WriteError};
use hovernav::autopilot::Mode;
use hovernav::controls::{Channels, Sticks};
use hovernav::ekf::layout::WithoutHeightAids;
use hovernav::ekf::{Estimator, Notice, Solution, SteplessSolution};
use hovernav::event::Event;
use hovernav::flight_control::{ControlInputs, ControlNotice, FlightControl};
use hovernav::health::{HealthLimits, HealthMonitor, Trust};
use hovernav::imu::{ImuSample, Notch};
use hovernav::sensors::SensorOutput;
use hovernav::servo::Signal;
use hovernav::telemetry::{GpsSummary, Snapshot, Supplement, SystemMode};
use hovernav::time::Time;
use hovernav_record::{Cycle, Entry, FlyConfig, Happening, Header, Level, Recorder};

/// Duration of a cycle if `[dmu] rate_hz` is not set, s: 33 Hz.
const CYCLE_S: f64 = 1.0 / 33.0;

/// Number of cycles without a sample after which the loop runs by the clock.
const CYCLES_WITHOUT_SAMPLE: f64 = 1.5;

/// Age of the last sample from which on the IMU counts as lost, s.
const SAMPLE_FRESH_S: f64 = 0.15;

/// The estimator, the servos, the record and the telemetry of a flight, with their state.
///
/// It receives sensor data and the time; it neither reads a line nor waits for one.
pub struct FlightLoop {
    pub log: EventLog,
    /// Removes the rotor's vibration from the samples for the estimator and the autopilot.
    notch: Option<Notch>,
    estimator: Estimator<WithoutHeightAids, 26>,
    /// The estimate at the last sample.
    solution: Option<Solution>,
    stepless: SteplessSolution,
    /// The solution at the last sample for the autopilot, without the jumps caused by corrections.
    flown: Option<Solution>,
    monitor: HealthMonitor,
    /// Last reported trust in attitude, velocity and position; `None` before the first solution.
    trusts: Option<[Trust; 3]>,
    /// Whether attitude, velocity and position have each been valid.
    were_good: [bool; 3],
    servos: Servos,
    /// Flight control by pilot and autopilot; `None` without an autopilot.
    control: Option<FlightControl>,
    mode: Mode,
    servos_good: bool,
    /// Time from the last packet of the IMU to the servos, s.
    turnaround_s: Option<f64>,
    /// Number of consecutive late cycles.
    late_cycles: u8,
    timer: CycleTimer,
    cycle_s: f64,
    /// Time of the last cycle.
    last_cycle: Time,
    last_sample: Option<SampleTimes>,
    receiver: ReceiverMonitor,
    sensor_monitor: SensorMonitor,
    utc: UtcClock,
    snapshot: Snapshot,
    supplement: Supplement,
    report: FlightReport,
    dmu_commands_lost: bool,
}

/// Arrival time and measurement time of an inertial sample.
#[derive(Clone, Copy)]
struct SampleTimes {
    arrival: Time,
    sample: Time,
}

impl FlightLoop {
    /// The loop of a flight that starts at `start` on `clock`; `unix_ns` is UTC at the start, ns since 1970.
    ///
    /// # Errors
    /// [`FlyError`] if the flight cannot begin.
    pub fn new(
        config: &FlyConfig,
        record: &Path,
        clock: &Clock,
        start: Time,
        unix_ns: i64,
        notifications: SyncSender<Notification>,
    ) -> Result<Self, FlyError> {
        let cycle_s = config.dmu.rate_hz.map_or(CYCLE_S, |rate_hz| 1.0 / rate_hz);
        let downlinks = Downlinks::open(config, clock, start, unix_ns)?;
        let servos = Servos::open(config, clock)?;
        let control = config.flight_control()?;
        // The limits are the autopilot's, if there is one.
        let limits = control.as_ref().map_or_else(HealthLimits::default, |set| set.hover.health);
        let control = control.map(FlightControl::new).transpose()?;
        let header = Header::new(config.clone(), start, unix_ns);
        let estimator = Estimator::with_layout(config.settings()?);
        let mut snapshot = Snapshot::at(start);
        let (recorder, unrecorded) = match Recorder::create(record, &header) {
            Ok(recorder) => (recorder, None),
            Err(error) if config.record.required => return Err(error.into()),
            Err(error) => (Recorder::absent(&error), Some(error)),
        };
        snapshot.status.recorder = unrecorded.is_none();
        let mut log = EventLog::new(recorder, notifications, downlinks);
        if let Some(error) = unrecorded {
            let text = format_args!("the flight is not recorded, and goes on: {error}");
            log.event(start, Level::Error, "record", text);
        }
        if config.autopilot.as_ref().is_some_and(|section| section.model.is_none()) {
            log.event(start, Level::Warning, "untried_gains", messages::UNTRIED_GAINS);
        }
        Ok(Self {
            log,
            notch: config.navigation.imu.notch.map(Notch::new),
            estimator,
            solution: None,
            stepless: SteplessSolution::default(),
            flown: None,
            monitor: HealthMonitor::new(limits),
            trusts: None,
            were_good: [false; 3],
            servos,
            control,
            mode: Mode::Manual,
            servos_good: true,
            turnaround_s: None,
            late_cycles: 0,
            timer: CycleTimer::new(cycle_s, start),
            cycle_s,
            last_cycle: start,
            last_sample: None,
            receiver: ReceiverMonitor::new(start),
            sensor_monitor: SensorMonitor::new(cycle_s),
            utc: UtcClock::new(start, unix_ns),
            snapshot,
            supplement: Supplement::at(start),
            report: FlightReport::default(),
            dmu_commands_lost: false,
        })
    }

    /// Time at which a cycle without a sample is due.
    pub fn cycle_due(&self) -> Time {
        self.last_cycle + CYCLES_WITHOUT_SAMPLE * self.cycle_s
    }

    /// Reports the start of a wait.
    pub fn begin_wait(&mut self, now: Time) {
        let Some(cycle) = self.timer.begin_wait(now) else { return };
        self.late_cycles = if cycle.on_time { 0 } else { self.late_cycles.saturating_add(1) };
        if !cycle.on_time {
            self.sensor_monitor.is_late |= cycle.late_s > 0.0;
            let text = format_args!("{cycle}");
            self.log.repeated_event(now, Level::Warning, "deadline_missed", text);
        }
        let timing = &mut self.snapshot.timing;
        timing.work_s = Some(cycle.work_s);
        timing.longest_work_s = Some(self.timer.work.longest_s());
        timing.overruns = u32::try_from(self.timer.missed_deadlines).unwrap_or(u32::MAX);
        self.snapshot.status.on_time = cycle.on_time;
    }

    /// Reports the end of a wait, by bytes or at the `requested` time.
    pub fn end_wait(&mut self, now: Time, requested: Option<Time>) {
        self.timer.end_wait(now, requested);
    }

    /// Handles an output of the sensors' decoders.
    pub fn handle(&mut self, now: Time, report: SensorOutput) {
        self.log.recorder.push(now, report);
        if let Some(happening) = Happening::of_sensor(&report) {
            self.log.repeated(happening.part(), now, happening.level, happening.text);
        }
        match report {
            SensorOutput::Measured(_, measurement) => {
                self.snapshot.temperature_degc = Some(measurement.temperature_degc);
                self.snapshot.magnetic_field_gauss = Some(measurement.magnetic_field_gauss);
            }
            SensorOutput::Event(event) => {
                if let Event::Imu(sample) = event {
                    self.sample_cycle(now, &event, &sample);
                } else {
                    if let Event::Gps(_) = event {
                        self.report.fixes += 1;
                        self.receiver.observe_fix(now);
                    }
                    self.estimate(now, &event);
                }
            }
            SensorOutput::DmuLost(..) => self.report.dmu_restarts += 1,
            SensorOutput::Fix(fix, _) => {
                let unix_ns = fix.time.and_then(|time| time.unix_ns());
                let drift = unix_ns.and_then(|utc| self.sensor_monitor.fix(fix.arrival, utc));
                drift.into_iter().for_each(|found| self.log.found(now, found));
                if let Some(offset_ns) = unix_ns.and_then(|utc| self.utc.observe(fix.arrival, utc))
                {
                    self.log.report_utc(offset_ns);
                    let (level, text) = self.utc.in_words(now, offset_ns);
                    self.log.event(now, level, "utc", text.as_str());
                }
                self.snapshot.gps = GpsSummary::of(&fix, now);
            }
            _ => {}
        }
    }

    /// Runs a cycle with a sample that arrived at `now`.
    fn sample_cycle(&mut self, now: Time, event: &Event, sample: &ImuSample) {
        let times = SampleTimes { arrival: now, sample: sample.time };
        let mut interval_s = self.cycle_s;
        if let Some(before) = self.last_sample.replace(times) {
            interval_s = times.sample - before.sample;
            let period_s = times.arrival - before.arrival;
            self.snapshot.timing.period_s = Some(period_s);
            self.report.jitter.add((period_s - interval_s).abs());
            self.timer.packet_behind(period_s - interval_s);
        }
        self.report.cycles += 1;
        let force_mps2 = sample.motion.mean_rates(interval_s).specific_force_mps2;
        let log = &mut self.log;
        self.sensor_monitor.sample(now, interval_s, force_mps2, |found| log.found(now, found));
        self.snapshot.drops.imu_packets = self.sensor_monitor.missing();
        let filtered = self.notch.as_mut().map(|notch| Event::Imu(notch.filter(sample)));
        self.estimate(now, filtered.as_ref().unwrap_or(event));
        self.snapshot = self.snapshot.with_imu(sample, interval_s);
        self.solution = self.estimator.solution();
        self.flown = self.solution.map(|solution| self.stepless.solution(&solution));
        if let Some(solution) = &self.solution {
            self.log.recorder.push(now, *solution);
            self.snapshot = self.snapshot.with_solution(solution);
            self.supplement = self.supplement.with_solution(solution);
        }
        self.timer.complete_cycle();
        self.control(now, true);
    }

    /// Runs a cycle by the clock, if no sample has arrived in time.
    pub fn cycle_without_sample(&mut self, now: Time) {
        if now >= self.cycle_due() {
            self.timer.run_by_clock();
            self.control(now, false);
        }
    }

    fn estimate(&mut self, now: Time, event: &Event) {
        let Self { estimator, stepless, log, snapshot, monitor, control, .. } = self;
        monitor.observe(event);
        if let Some(control) = control.as_mut() {
            control.observe(event);
        }
        estimator.push_traced(event, stepless, |notice| {
            monitor.observe_notice(&notice);
            if let Some(control) = control.as_mut() {
                control.observe_notice(&notice);
            }
            log.recorder.push(now, notice);
            if let Notice::Updated(report) = &notice {
                report.innovations().for_each(|one| snapshot.innovations.note(one));
            }
            if let Some(happening) = Happening::of_notice(&notice) {
                log.repeated(happening.part(), now, happening.level, happening.text);
            }
        });
    }

    /// Sends the command of pilot or autopilot to the servos, and a snapshot to the ground.
    fn control(&mut self, now: Time, has_sample: bool) {
        self.last_cycle = now;
        let Self { servos, log, .. } = self;
        let pilot = servos.poll(now, |event| event.log(log, now));
        let (sticks, command_ms) = self.decide(&pilot, now, has_sample);
        let Self { servos, log, .. } = self;
        let sent = servos.send(&command_ms, &pilot, now, |event| event.log(log, now));
        let (commanded_ms, servos_good) = (sent.widths_ms, sent.good);
        self.servos_good = servos_good;
        self.turnaround_s = sent.at.filter(|_| has_sample).map(|at| at - now);
        self.turnaround_s.iter().for_each(|took_s| self.report.turnaround.add(*took_s));
        if commanded_ms != self.snapshot.commanded_ms || pilot.widths_ms != self.snapshot.pilot_ms {
            let ms = |width_ms: Option<f64>| width_ms.unwrap_or(f64::NAN) as f32;
            let entry = Entry::Servo {
                captured_ms: pilot.widths_ms.map(ms).to_array(),
                commanded_ms: commanded_ms.map(ms).to_array(),
            };
            self.log.recorder.push(now, entry);
        }
        if let Some(sticks) = sticks {
            self.log.recorder.push(now, Entry::Controls(sticks.to_array()));
        }
        self.snapshot.pilot_ms = pilot.widths_ms;
        self.supplement.aux_ms = pilot.aux_ms;
        self.snapshot.commanded_ms = commanded_ms;
        self.snapshot.drops.pilot_pulses = pilot.pulses_lost();
        let status = &mut self.snapshot.status;
        status.pilot_signal = pilot.signal == Some(Signal::Good);
        status.receiver_failsafe = pilot.signal == Some(Signal::Failsafe);
        status.servos = servos_good;
        self.monitor_receiver(now);
        self.monitor_record(now);
        self.send_telemetry(now);
    }

    /// Selects pilot or autopilot; returns the commanded sticks and widths, ms.
    fn decide(
        &mut self,
        pilot: &PilotState,
        now: Time,
        has_sample: bool,
    ) -> (Option<Sticks>, Channels<f64>) {
        let Some(control) = &mut self.control else {
            return (self.servos.sticks(pilot), self.servos.passed_on_ms(pilot));
        };
        let inputs = ControlInputs {
            now,
            solution: self.flown.as_ref(),
            fix_age_s: self.receiver.last_fix().map(|arrival| (now - arrival).max(0.0)),
            pulses: &pilot.pulses,
            servos_good: self.servos_good,
            late_cycles: self.late_cycles,
        };
        let log = &mut self.log;
        let outputs = control.step(&inputs, |notice| {
            let level = messages::control_level(&notice);
            log.event_of(messages::control_part(&notice), now, level, "autopilot", notice);
            if let ControlNotice::Refused(readiness) = &notice {
                for failed in readiness.failed() {
                    log.event(now, level, "not_ready", failed);
                }
            }
        });
        self.mode = outputs.mode;
        let share = self.flown.and_then(|solution| control.geofence_share(&solution.position));
        self.supplement = self.supplement.with_control(control, &outputs);
        self.supplement.geofence_share = share;
        let (asked_velocity_mps, asked_heading_rad) = control.autopilot().reference();
        let cycle = Cycle {
            has_sample,
            servos_good: inputs.servos_good,
            late_cycles: inputs.late_cycles,
            work_s: self.snapshot.timing.work_s,
            turnaround_s: self.turnaround_s,
            mode: outputs.mode,
            switch_on: outputs.switch_on,
            failed_checks: outputs.readiness.failed_bits(),
            pilot: outputs.pilot,
            sticks: outputs.sticks,
            injected: outputs.injected,
            asked_velocity_mps,
            asked_heading_rad,
        };
        self.log.recorder.push(now, Entry::Cycle(cycle));
        (outputs.sticks, outputs.widths_ms)
    }

    /// Reports lost, missing and recovered fixes.
    fn monitor_receiver(&mut self, now: Time) {
        if let Some((level, text)) = self.receiver.look(now) {
            self.log.event(now, level, "gps_fixes", text);
        }
        self.snapshot.status.gps = self.receiver.is_good();
    }

    /// Reports a failure of the record and its recovery.
    fn monitor_record(&mut self, now: Time) {
        let status = self.log.recorder.status();
        let before = std::mem::replace(&mut self.report.record, status);
        // Bytes that could not be written are tried again; lost entries stay lost.
        let good = !status.is_absent
            && status.bytes_waiting == 0
            && status.lost_raw == before.lost_raw
            && status.lost_decoded == before.lost_decoded;
        if std::mem::replace(&mut self.snapshot.status.recorder, good) != good {
            let (level, text) = messages::of_record(good, &status);
            self.log.event(now, level, "record", text.as_str());
        }
    }

    fn send_telemetry(&mut self, now: Time) {
        let snapshot = &mut self.snapshot;
        snapshot.time = now;
        snapshot.mode = match self.solution {
            None if self.last_sample.is_none() => SystemMode::Starting,
            None => SystemMode::Aligning,
            Some(_) if self.estimator.filter().is_none() => SystemMode::SearchingHeading,
            Some(_) if self.mode == Mode::Neutral => SystemMode::Failsafe,
            Some(_) if self.mode != Mode::Manual => SystemMode::Autopilot,
            Some(_) => SystemMode::Pilot,
        };
        let health = self.monitor.assess(self.solution.as_ref(), now);
        snapshot.status = snapshot.status.with_estimate(&health);
        let trusts = [health.attitude_trust(), health.velocity_trust(), health.position_trust()];
        // Before the first solution, and at it, no change is reported.
        let before = if self.solution.is_some() { self.trusts.replace(trusts) } else { None };
        let names = ["attitude", "velocity", "position"];
        let each = names.into_iter().zip(trusts).zip(before.unwrap_or(trusts));
        for (((name, trust), before), was_good) in each.zip(&mut self.were_good) {
            if trust != before {
                let (part, level, text) = messages::of_trust(name, trust, &health, *was_good);
                self.log.event_of(part, now, level, "health", text);
            }
            *was_good |= self.solution.is_some() && trust == Trust::Valid;
        }
        self.log.settle_repeats(now);
        self.log.report_changed_ports(now);
        let since_sample = self.last_sample.map(|times| now - times.arrival);
        snapshot.observe_imu(since_sample.is_some_and(|age_s| age_s < SAMPLE_FRESH_S));
        snapshot.gps.age_s = self.receiver.last_fix().map(|arrival| (now - arrival).max(0.0));
        self.supplement.time = now;
        self.log.downlinks.offer(snapshot, &self.supplement);
        snapshot.innovations.clear();
    }

    /// Handles the result of a command to the IMU; the first failure is an event.
    pub fn dmu_written(&mut self, now: Time, port: &PortName, written: &Result<(), WriteError>) {
        let lost = matches!(written, Err(WriteError::Stuck { .. } | WriteError::Lost(_)));
        if let Err(error) = written
            && lost
            && !self.dmu_commands_lost
        {
            self.log.event(now, Level::Warning, "dmu_command", port.not_written(error));
        }
        self.dmu_commands_lost = lost;
    }

    /// Checks bytes from the IMU's line for messages of a receiver, which show that the ports are swapped.
    pub fn unit_bytes(&mut self, now: Time, bytes: &[u8]) {
        let found = self.sensor_monitor.unit_bytes(bytes);
        found.into_iter().for_each(|found| self.log.found(now, found));
    }

    /// Records a change of a port.
    pub fn port(&mut self, now: Time, kind: &'static str, port: &PortName, event: &PortEvent) {
        self.log.event(now, messages::port_level(event), kind, port.changed(event));
    }

    /// Ends the record and returns the loop's part of the report.
    pub fn end(mut self, now: Time) -> FlightReport {
        self.log.end_repeats(now);
        let mut report = self.report;
        report.work = self.timer.work;
        report.wake_latency = self.timer.wake_latency;
        report.missed_deadlines = self.timer.missed_deadlines;
        (report.telemetry, report.mavlink) = self.log.downlinks.counts();
        report.record = self.log.recorder.finish();
        report
    }
}
