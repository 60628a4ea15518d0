//! A running flight, sample by sample.

use super::config::{Feedback, FlightConfig, FlightError, FlightEvent};
use super::record::{Flight, FlightSample};
use crate::State;
use crate::aids::{SimulatedAntennas, SimulatedRangefinder};
use crate::baro::SimulatedBaro;
use crate::check::positive;
use crate::dmu::{DmuOutput, ImuTruth, SimulatedDmu};
use crate::gps::SimulatedGps;
use crate::vehicle::Vehicle;
use crate::wind::Wind;
use hovernav::autopilot::{HoverAutopilot, Inputs};
use hovernav::controls::Sticks;
use hovernav::ekf::layout::Full;
use hovernav::ekf::{Estimator, SteplessSolution};
use hovernav::event::{BaroReading, Event};
use hovernav::gps::Fix;
use hovernav::scalar::Scalar;
use hovernav::time::Time;

impl FlightConfig {
    /// Flies the flight.
    ///
    /// # Errors
    /// [`FlightError`].
    pub fn fly(&self) -> Result<Flight, FlightError> {
        self.fly_with(|_| ())
    }

    /// Flies the flight and calls `progress` with the time of each sample, s.
    ///
    /// # Errors
    /// [`FlightError`].
    pub fn fly_with(&self, progress: impl FnMut(f64)) -> Result<Flight, FlightError> {
        self.fly_in::<f64>(progress)
    }

    /// Flies the flight with a flight computer (estimator and autopilot) that computes in `T`.
    ///
    /// # Errors
    /// [`FlightError`].
    pub fn fly_in<T: Scalar>(&self, mut progress: impl FnMut(f64)) -> Result<Flight, FlightError> {
        let mut run = RunningFlight::<T>::new(self)?;
        let last = (self.duration_s / run.period_s + 1e-6) as u64;
        for sample in 0..=last {
            run.sample(sample)?;
            progress(sample as f64 * run.period_s);
            if run.vehicle.has_crashed() {
                run.flight.crashed_s = Some(sample as f64 * run.period_s);
                run.flight.crash = run.vehicle.crash();
                break;
            }
        }
        Ok(run.flight)
    }
}

/// A running flight.
struct RunningFlight<'a, T> {
    config: &'a FlightConfig,
    period_s: f64,
    vehicle: Vehicle,
    wind: Wind,
    dmu: SimulatedDmu,
    gps: SimulatedGps,
    baro: Option<SimulatedBaro>,
    rangefinder: Option<(SimulatedRangefinder, f64)>,
    antennas: Option<(SimulatedAntennas, f64)>,
    next_fix: u64,
    next_baro: u64,
    next_range: u64,
    next_heading: u64,
    /// Fixes in transit, with their arrival times.
    pending_fixes: Vec<(Time, Fix)>,
    estimator: Estimator<Full, 28, T>,
    stepless: SteplessSolution<T>,
    pilot: HoverAutopilot,
    pilot_sticks: Sticks,
    autopilot: HoverAutopilot<T>,
    engaged: bool,
    added: Sticks,
    events: std::slice::Iter<'a, (f64, FlightEvent)>,
    /// Command of the previous sample, which acts now.
    acting: Sticks,
    flight: Flight,
}

impl<'a, T: Scalar> RunningFlight<'a, T> {
    fn new(config: &'a FlightConfig) -> Result<Self, FlightError> {
        if !config.start.is_navigable() {
            return Err(FlightError::Start(config.start));
        }
        if config.dmu.output == DmuOutput::Increments {
            return Err(FlightError::Increments);
        }
        positive("flight", "duration", config.duration_s)?;
        let (period_s, dmu_s) = (config.autopilot.period_s, 1.0 / config.dmu.rate_hz);
        let dmu = SimulatedDmu::new(&config.dmu, config.seed)?;
        if (period_s / dmu_s - 1.0).abs() > 1e-6 {
            return Err(FlightError::Rate { dmu_s, autopilot_s: period_s });
        }
        let manifest = config.manifest();
        let settings = match config.estimator {
            Some(settings) => settings,
            None => config.settings()?,
        };
        let (vehicle, hover) = config.hovering()?;
        // The pilot's trim is the hover of this vehicle. The autopilot engages at the pilot's sticks.
        let mut pilot = config.autopilot;
        let (trim, hover) = (pilot.trim.sticks.to_array(), hover.to_array());
        pilot.trim.sticks = Sticks::from_array(std::array::from_fn(|stick| {
            (trim[stick] + hover[stick]).clamp(-1.0, 1.0)
        }));
        let samples = (config.duration_s / period_s) as usize + 1;
        Ok(Self {
            vehicle,
            wind: Wind::new(&config.wind, period_s, config.seed)?,
            gps: SimulatedGps::new(&config.gps, config.seed)?,
            baro: match &config.baro {
                Some(baro) => Some(SimulatedBaro::new(baro, config.seed)?),
                None => None,
            },
            rangefinder: match &config.rangefinder {
                Some(set) => Some((SimulatedRangefinder::new(set, config.seed)?, set.rate_hz)),
                None => None,
            },
            antennas: match &config.antennas {
                Some(set) => Some((SimulatedAntennas::new(set, config.seed)?, set.rate_hz)),
                None => None,
            },
            dmu,
            next_fix: 0,
            next_baro: 0,
            next_range: 0,
            next_heading: 0,
            pending_fixes: Vec::new(),
            estimator: Estimator::with_layout(settings),
            stepless: SteplessSolution::default(),
            pilot: HoverAutopilot::new(pilot)?,
            pilot_sticks: pilot.trim.sticks,
            autopilot: HoverAutopilot::new(config.autopilot.cast())?,
            engaged: true,
            added: Sticks::NEUTRAL,
            events: config.events.iter(),
            acting: pilot.trim.sticks,
            flight: Flight {
                manifest,
                imu: Vec::with_capacity(samples),
                fixes: Vec::new(),
                baro: Vec::new(),
                ranges: Vec::new(),
                headings: Vec::new(),
                samples: Vec::with_capacity(samples),
                transitions: Vec::new(),
                aborted: Vec::new(),
                crashed_s: None,
                crash: None,
            },
            config,
            period_s,
        })
    }

    /// Runs sensors, estimator and autopilot, and moves the vehicle to the next sample.
    fn sample(&mut self, sample: u64) -> Result<(), FlightError> {
        let time_s = sample as f64 * self.period_s;
        let time = Time::ZERO + time_s;
        let mut applied = Ok(());
        while let Some((_, event)) =
            self.events.as_slice().first().filter(|(due_s, _)| *due_s <= time_s + 1e-9)
        {
            self.events.next();
            applied = applied.and(self.apply(event, time_s));
        }
        applied?;

        let state = self.vehicle.state();
        let truth = state.truth(time);
        self.measure(time, &state);
        let solution = match self.config.feedback {
            Feedback::Estimator => self.estimator.solution(),
            Feedback::Truth => Some(state.solution(time).cast()),
        };
        let pilot_flies = time_s < self.config.engage_s - 1e-9;
        if pilot_flies {
            let seen = state.solution(time);
            let sees = Inputs { now: time, solution: Some(&seen), pilot: None, engage: true };
            self.pilot_sticks = self.pilot.step(&sees).sticks;
        }
        let flown = solution.map(|solution| match self.config.feedback {
            Feedback::Estimator => self.stepless.solution(&solution),
            Feedback::Truth => solution,
        });
        let outputs = self.autopilot.step(&Inputs {
            now: time,
            solution: flown.as_ref(),
            pilot: Some(self.pilot_sticks.cast()),
            engage: self.engaged && !pilot_flies,
        });
        self.flight.transitions.extend(outputs.transition);
        self.flight.aborted.extend(outputs.aborted.map(|abort| (time_s, abort)));
        let [added, injected, flown] =
            [self.added, outputs.injected.cast(), outputs.sticks.cast()].map(Sticks::to_array);
        let sticks = Sticks::from_array(std::array::from_fn(|stick| {
            (flown[stick] + added[stick]).clamp(-1.0, 1.0)
        }));
        let injected =
            Sticks::from_array(std::array::from_fn(|stick| injected[stick] + added[stick]));
        let wind_mps = self.wind.advance();
        self.flight.samples.push(FlightSample {
            truth,
            solution: solution.map(|solution| solution.cast()),
            mode: outputs.mode,
            sticks,
            injected,
            servos: self.vehicle.servos(),
            wind_mps,
        });
        self.vehicle.step(self.acting, wind_mps, self.period_s);
        self.acting = sticks;
        Ok(())
    }

    fn apply(&mut self, event: &FlightEvent, time_s: f64) -> Result<(), FlightError> {
        match *event {
            FlightEvent::SetPoint(set_point) => self
                .autopilot
                .set(set_point)
                .map_err(|source| FlightError::SetPoint { time_s, source })?,
            FlightEvent::Excite(excitation) => self
                .autopilot
                .excite(excitation)
                .map_err(|source| FlightError::Excitation { time_s, source })?,
            FlightEvent::Disturb(disturbance) => self.vehicle.disturb(&disturbance),
            FlightEvent::Push(disturbance) => self.vehicle.push(&disturbance),
            FlightEvent::Jam(stick) => self.vehicle.jam(stick),
            FlightEvent::PowerLoss => self.vehicle.lose_power(),
            FlightEvent::Mass(mass_kg) => self.vehicle.set_mass(mass_kg)?,
            FlightEvent::Engage(engaged) => self.engaged = engaged,
            FlightEvent::PilotSticks(sticks) => self.pilot_sticks = sticks,
            FlightEvent::AddSticks(sticks) => self.added = sticks,
        }
        Ok(())
    }

    /// Passes an event to the estimator, and its result to the autopilot.
    fn estimate(&mut self, event: &Event) {
        let Self { estimator, stepless, autopilot, .. } = self;
        autopilot.observe(event);
        estimator.push_traced(event, stepless, |notice| autopilot.observe_notice(&notice));
    }

    /// Passes the measurements at `time` to the record and to the estimator.
    fn measure(&mut self, time: Time, state: &State) {
        let config = self.config;
        let sample = self.dmu.measure(
            time,
            &ImuTruth {
                angular_rate_radps: state.inertial_rate_radps,
                specific_force_mps2: state.specific_force_at(config.dmu.lever_arm_m),
                body_to_ned: state.body_to_ned,
            },
        );
        self.flight.imu.push(sample);
        let listens = config.feedback == Feedback::Estimator;
        if listens {
            self.estimate(&Event::Imu(sample));
        }
        let due = |count: u64, rate_hz: f64| Time::ZERO + count as f64 / rate_hz <= time;
        while due(self.next_fix, config.gps.rate_hz) {
            self.next_fix += 1;
            // A receiver measures at its own times; the inertial samples are close enough to be used.
            let antenna = state.at_point(config.gps.lever_arm_m);
            if let Some(fix) = self.gps.measure(time, &antenna.position, antenna.velocity_mps) {
                self.pending_fixes.push((time + config.gps.latency_s, fix));
            }
        }
        let arrived = self.pending_fixes.partition_point(|(arrival, _)| *arrival <= time);
        let arrived: Vec<(Time, Fix)> = self.pending_fixes.drain(..arrived).collect();
        for (_, fix) in arrived {
            self.flight.fixes.push(fix);
            if listens {
                self.estimate(&Event::Gps(fix));
            }
        }
        if let (Some(baro), Some(set)) = (&mut self.baro, &config.baro)
            && due(self.next_baro, set.rate_hz)
        {
            while due(self.next_baro, set.rate_hz) {
                self.next_baro += 1;
            }
            let height_m = baro.measure(state.position.height_m);
            self.flight.baro.push((time, height_m));
            if listens {
                self.estimate(&Event::Baro(BaroReading::new(time, height_m)));
            }
        }
        self.measure_aids(time, state, listens);
    }

    /// Measures with the rangefinder and the antennas.
    fn measure_aids(&mut self, time: Time, state: &State, listens: bool) {
        if let Some((rangefinder, rate_hz)) = &mut self.rangefinder
            && is_due(&mut self.next_range, *rate_hz, time)
        {
            let (height_m, velocity_mps) = (state.position.height_m, state.velocity_mps);
            let reading = rangefinder.measure(time, height_m, velocity_mps, state.body_to_ned);
            if let Some(reading) = reading {
                self.flight.ranges.push(reading);
                if listens {
                    self.estimate(&Event::Range(reading));
                }
            }
        }
        if let Some((antennas, rate_hz)) = &mut self.antennas
            && is_due(&mut self.next_heading, *rate_hz, time)
        {
            let heading = antennas.measure(time, state.body_to_ned);
            self.flight.headings.push(heading);
            if listens {
                self.estimate(&Event::AntennaHeading(heading));
            }
        }
    }
}

/// Whether a sensor with `count` measurements is due at `time`; increments the count.
fn is_due(count: &mut u64, rate_hz: f64, time: Time) -> bool {
    let before = *count;
    while Time::ZERO + *count as f64 / rate_hz <= time {
        *count += 1;
    }
    *count > before
}
