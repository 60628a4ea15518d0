//! Replay of flight control from the raw bytes of sensors and pilot.

use std::collections::VecDeque;

use crate::read::{Call, Record};
use crate::setup::CaptureSection;
use hovernav::controls::Sticks;
use hovernav::ekf::layout::WithoutHeightAids;
use hovernav::ekf::{Estimator, Solution, SteplessSolution};
use hovernav::event::Event;
use hovernav::flight_control::{ControlInputs, FlightControl};
use hovernav::sensors::{SensorOutput, Sensors};
use hovernav::servo::packet::PacketCapture;
use hovernav::time::Time;
use hovernav_dataset::LogError;

/// Comparison of the sticks of a replay with those of the flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StickReproduction {
    /// Number of cycles compared.
    pub compared: usize,
    /// Time at which a stick of the replay first differs in any bit; `None` if none does.
    pub first_difference: Option<Time>,
}

/// The flight computer in a replay, without its serial lines.
struct Replay {
    control: FlightControl,
    estimator: Estimator<WithoutHeightAids, 26>,
    stepless: SteplessSolution,
    flown: Option<Solution>,
    last_fix: Option<Time>,
    pulses: PacketCapture,
    /// Events from the sensors, with the time at which the loop received them.
    events: VecDeque<(Time, Event)>,
}

impl Replay {
    /// Processes the events up to and including the next inertial sample, or all of them.
    fn estimate(&mut self, up_to_sample: bool) {
        while let Some((now, event)) = self.events.pop_front() {
            let is_sample = matches!(event, Event::Imu(_));
            if matches!(event, Event::Gps(_)) {
                self.last_fix = Some(now);
            }
            let Self { control, estimator, stepless, .. } = self;
            control.observe(&event);
            estimator.push_traced(&event, stepless, |notice| control.observe_notice(&notice));
            if is_sample {
                let stepless = &mut self.stepless;
                self.flown = self.estimator.solution().map(|solution| stepless.solution(&solution));
            }
            if is_sample && up_to_sample {
                return;
            }
        }
    }
}

impl Record {
    /// Replays the record's flight control from the raw bytes of sensors and pilot, and compares the sticks bit for
    /// bit. `None` without a comparison: no autopilot, a pilot on GPIO lines, whose edges are not recorded, or a record
    /// of an older version.
    ///
    /// # Errors
    /// [`LogError::Unusable`] for a configuration with which no flight is possible.
    pub fn sticks_reproduced(&self) -> Result<Option<StickReproduction>, LogError> {
        let unusable = |error: &dyn std::fmt::Display| LogError::Unusable {
            path: self.header.config.navigation.name.clone().into(),
            reason: error.to_string(),
        };
        let config = self.header.config.flight_control().map_err(|error| unusable(&error))?;
        let by_stream = matches!(self.header.config.servo.capture, Some(CaptureSection::Serial(_)));
        let Some(config) = config.filter(|_| by_stream && !self.cycles.is_empty()) else {
            return Ok(None);
        };
        let (dmu, gps) = self.header.config.sensors().map_err(|error| unusable(&error))?;
        let mut sensors = Sensors::new(dmu, gps, self.header.start);
        let mut replay = Replay {
            control: FlightControl::new(config).map_err(|error| unusable(&error))?,
            estimator: Estimator::with_layout(self.header.settings()?),
            stepless: SteplessSolution::default(),
            flown: None,
            last_fix: None,
            pulses: PacketCapture::default(),
            events: VecDeque::new(),
        };
        let mut calls = self.calls.iter();
        let mut taken = 0;
        let mut first_difference = None;
        for recorded in &self.cycles {
            for (time, call) in calls.by_ref().take(recorded.calls_before.saturating_sub(taken)) {
                let events = &mut replay.events;
                let take = |report| {
                    if let SensorOutput::Event(event) = report {
                        events.push_back((*time, event));
                    }
                };
                match call {
                    Call::Dmu(bytes) => {
                        sensors.dmu(bytes, *time, take);
                    }
                    Call::Gps(bytes) => sensors.gps(bytes, *time, take),
                    Call::RestartGps => sensors.restart_gps(),
                    Call::Servo(bytes) => {
                        replay.pulses.receive(bytes, *time);
                    }
                }
            }
            taken = taken.max(recorded.calls_before);
            let (now, cycle) = (recorded.time, &recorded.cycle);
            replay.estimate(cycle.has_sample);
            let inputs = ControlInputs {
                now,
                solution: replay.flown.as_ref(),
                fix_age_s: replay.last_fix.map(|arrival| (now - arrival).max(0.0)),
                pulses: replay.pulses.pulses(),
                servos_good: cycle.servos_good,
                late_cycles: cycle.late_cycles,
            };
            let outputs = replay.control.step(&inputs, |_| {});
            if bits(outputs.sticks) != bits(cycle.sticks) {
                first_difference = Some(now);
                break;
            }
        }
        Ok(Some(StickReproduction { compared: self.cycles.len(), first_difference }))
    }
}

fn bits(sticks: Option<Sticks>) -> Option<[u64; 4]> {
    sticks.map(|sticks| sticks.to_array().map(f64::to_bits))
}
