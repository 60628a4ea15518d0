//! The closed loop: vehicle, sensors, estimator and autopilot, as they fly.

use super::baro::{BaroConfig, SimulatedBaro};
use super::check::{ConfigError, positive};
use super::dmu::{DmuConfig, DmuOutput, Felt, SimulatedDmu};
use super::gps::{GpsConfig, SimulatedGps};
use super::vehicle::{Disturbance, Vehicle, VehicleConfig};
use super::wind::{Wind, WindConfig};
use super::{State, Truth};
use crate::autopilot::{
    self, HoverAutopilot, HoverConfig, Inputs, Mode, SetPoint, SetPointError, Sticks, Transition,
};
use crate::dmu::ImuSample;
use crate::earth::Geodetic;
use crate::ekf::layout::Full;
use crate::ekf::{Estimator, EstimatorConfig, Solution};
use crate::event::Event;
use crate::frames::{Body, EulerAngles, Ned, Rotation, Vector, wrap_angle};
use crate::gps::Fix;
use crate::log::{Dataset, LogError, Manifest};
use crate::model::helicopter::{Helicopter, HelicopterError, HelicopterParameters};
use crate::time::Time;

/// What the autopilot flies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feedback {
    /// The estimator, fed by the simulated sensors.
    Estimator,
    /// The truth, without error or delay: what the loops alone can do.
    Truth,
}

/// Something that happens at a moment of the flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// A new set-point.
    Go(SetPoint),
    /// The vehicle is thrown out of its motion.
    Disturb(Disturbance),
    /// The pilot's switch.
    Engage(bool),
    /// The pilot holds the sticks here from now on.
    Pilot(Sticks),
}

/// A flight to be flown. [`FlightConfig::new`] is five minutes of hover of the thesis's helicopter
/// with the thesis's sensors in gusts of 1.5 m/s.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightConfig {
    /// The airframe.
    pub helicopter: HelicopterParameters,
    /// Servos, governor and ground.
    pub vehicle: VehicleConfig,
    /// Wind and gusts.
    pub wind: WindConfig,
    /// The inertial unit, which sets the pace: its rate is the autopilot's.
    pub dmu: DmuConfig,
    /// The GPS receiver, outages and all.
    pub gps: GpsConfig,
    /// The barometer, if there is one.
    pub baro: Option<BaroConfig>,
    /// The estimator; `None` takes what the sensors' own configurations say.
    pub estimator: Option<EstimatorConfig>,
    /// What the autopilot flies on.
    pub feedback: Feedback,
    /// The autopilot.
    pub autopilot: HoverConfig,
    /// Where the hover begins.
    pub start: Geodetic,
    /// Which way the nose points, rad.
    pub heading_rad: f64,
    /// When the autopilot takes over, s. Until then a pilot who sees the truth holds the hover.
    pub engage_s: f64,
    /// What else happens, s from the start, in order.
    pub orders: Vec<(f64, Order)>,
    /// How long it takes, s.
    pub duration_s: f64,
    /// Seed of every error and gust.
    pub seed: u64,
}

/// Why a flight cannot be flown.
#[derive(Debug, thiserror::Error)]
pub enum FlightError {
    /// A sensor, servo or wind that cannot be.
    #[error(transparent)]
    Sensor(#[from] ConfigError),
    /// An airframe that cannot be.
    #[error(transparent)]
    Helicopter(#[from] HelicopterError),
    /// An autopilot that cannot fly.
    #[error(transparent)]
    Autopilot(#[from] autopilot::ConfigError),
    /// An order that the autopilot refuses.
    #[error("order at {time_s} s: {source}")]
    Order {
        /// When.
        time_s: f64,
        /// Why.
        source: SetPointError,
    },
    /// The inertial unit does not sample at the autopilot's rate.
    #[error(
        "the inertial unit samples every {dmu_s} s, the autopilot is designed for {autopilot_s} s"
    )]
    Rate {
        /// The unit's period, s.
        dmu_s: f64,
        /// The autopilot's, s.
        autopilot_s: f64,
    },
    /// The inertial unit gives increments; the closed loop samples rates.
    #[error("the closed loop takes an inertial unit that gives rates, found increments")]
    Increments,
    /// The estimator's settings cannot be made from the sensors'.
    #[error(transparent)]
    Settings(#[from] LogError),
    /// The vehicle is nowhere.
    #[error("the flight starts at {0:?}, where one cannot navigate by north, east and down")]
    Start(Geodetic),
}

/// One sample of a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// The centre of gravity.
    pub truth: Truth,
    /// What the autopilot flew on.
    pub solution: Option<Solution>,
    /// What it was doing.
    pub mode: Mode,
    /// Its command.
    pub sticks: Sticks,
    /// Where the servos stood.
    pub servos: Sticks,
    /// The wind until the next sample, m/s.
    pub wind_mps: Vector<Ned>,
}

/// A flight flown.
#[derive(Clone, Debug)]
pub struct Flight {
    /// What the sensors were.
    pub manifest: Manifest,
    /// Samples of the inertial unit.
    pub imu: Vec<ImuSample>,
    /// Fixes.
    pub fixes: Vec<Fix>,
    /// Barometric heights, m.
    pub baro: Vec<(Time, f64)>,
    /// What happened, one moment per inertial sample.
    pub moments: Vec<Moment>,
    /// Every change of mode.
    pub transitions: Vec<Transition>,
    /// When it crashed, s, if it did: the flight ends there.
    pub crashed_s: Option<f64>,
}

/// How well a hover was held, from a moment on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HoverStatistics {
    /// Root mean square of u, v, w, m/s.
    pub velocity_rms_mps: [f64; 3],
    /// Root mean square of roll and pitch about their means, °.
    pub attitude_rms_deg: [f64; 2],
    /// Farthest the heading was from where it began, °.
    pub heading_worst_deg: f64,
    /// Root mean square of the distance from where it began, north, east, down, m.
    pub position_rms_m: [f64; 3],
    /// Root mean square of what the estimator got wrong of north, east and down velocity, m/s; NaN
    /// where it said nothing.
    pub velocity_error_rms_mps: [f64; 3],
    /// Root mean square of what the estimator got wrong of roll, pitch and heading, °; NaN as above.
    pub attitude_error_rms_deg: [f64; 3],
    /// Root mean square of the commands about their means.
    pub sticks_rms: [f64; 4],
}

impl FlightConfig {
    /// Five minutes of hover under `autopilot`.
    #[must_use]
    pub fn new(autopilot: HoverConfig) -> Self {
        Self {
            helicopter: HelicopterParameters::raptor60(),
            vehicle: VehicleConfig::default(),
            wind: WindConfig::default(),
            dmu: DmuConfig::default(),
            gps: GpsConfig::default(),
            baro: Some(BaroConfig::default()),
            estimator: None,
            feedback: Feedback::Estimator,
            autopilot,
            start: Geodetic {
                latitude_rad: 1.3521f64.to_radians(),
                longitude_rad: 103.8198f64.to_radians(),
                height_m: 30.0,
            },
            heading_rad: 1.0,
            engage_s: 15.0,
            orders: Vec::new(),
            duration_s: 300.0,
            seed: 1,
        }
    }

    /// What the sensors are, as a dataset tells it.
    #[must_use]
    pub fn manifest(&self) -> Manifest {
        let mut manifest = Manifest {
            name: "simulated".into(),
            vehicle: format!("simulated helicopter in closed loop, seed {}", self.seed),
            kind: "simulated".into(),
            time: "seconds, one clock for all files".into(),
            ..Manifest::default()
        };
        let imu = &mut manifest.imu;
        imu.rate_hz = Some(self.dmu.rate_hz);
        imu.lever_arm_m = self.dmu.lever_arm_m;
        imu.angle_random_walk_deg_per_sqrt_h = Some(self.dmu.gyro.angle_random_walk_deg_per_sqrt_h);
        imu.velocity_random_walk_mps_per_sqrt_h =
            Some(self.dmu.accelerometer.velocity_random_walk_mps_per_sqrt_h);
        imu.gyro_bias_sigma_degps = Some(self.dmu.gyro.turn_on_bias_sigma_degps);
        imu.accel_bias_sigma_mps2 = Some(self.dmu.accelerometer.turn_on_bias_sigma_mps2);
        imu.gyro_range_degps = Some(self.dmu.gyro.range_degps);
        imu.accel_range_g = Some(self.dmu.accelerometer.range_mps2 / 9.806_65);
        imu.magnetic_declination_deg = Some(0.0);
        manifest.gps.rate_hz = Some(self.gps.rate_hz);
        manifest.gps.antenna_lever_arm_m = self.gps.lever_arm_m;
        manifest.gps.latency_s = self.gps.assumed_latency_s;
        // The heading that a unit computes for itself wanders by degrees within a minute, the error
        // of its magnetometer stays: a hover is held by the one that stays.
        let unit_attitude = self.dmu.magnetometer.is_none();
        manifest.aiding.insert("attitude".into(), unit_attitude.into());
        manifest
    }

    /// The estimator's settings as the sensors' own configurations tell them.
    ///
    /// # Errors
    /// [`LogError`] for sensors that no dataset can describe.
    pub fn settings(&self) -> Result<EstimatorConfig, LogError> {
        Dataset { manifest: self.manifest(), ..Dataset::default() }.settings()
    }

    /// Flies it.
    ///
    /// # Errors
    /// [`FlightError`].
    pub fn fly(&self) -> Result<Flight, FlightError> {
        let mut run = Run::new(self)?;
        let last = (self.duration_s / run.period_s + 1e-6) as u64;
        for sample in 0..=last {
            run.sample(sample)?;
            if run.vehicle.has_crashed() {
                run.flight.crashed_s = Some(sample as f64 * run.period_s);
                break;
            }
        }
        Ok(run.flight)
    }
}

/// A flight under way.
struct Run<'a> {
    config: &'a FlightConfig,
    period_s: f64,
    vehicle: Vehicle,
    wind: Wind,
    dmu: SimulatedDmu,
    gps: SimulatedGps,
    baro: Option<SimulatedBaro>,
    next_fix: u64,
    next_baro: u64,
    /// Fixes on their way, with the time of their arrival.
    pending_fixes: Vec<(Time, Fix)>,
    estimator: Estimator<Full, 26>,
    pilot: HoverAutopilot,
    pilot_sticks: Sticks,
    autopilot: HoverAutopilot,
    engaged: bool,
    orders: std::slice::Iter<'a, (f64, Order)>,
    /// The command of the sample before, which acts now.
    acting: Sticks,
    flight: Flight,
}

impl<'a> Run<'a> {
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
        let helicopter = Helicopter::new(config.helicopter)?;
        let samples = (config.duration_s / period_s) as usize + 1;
        Ok(Self {
            vehicle: Vehicle::hovering(
                &config.vehicle,
                helicopter,
                config.start,
                config.heading_rad,
            )?,
            wind: Wind::new(&config.wind, period_s, config.seed)?,
            gps: SimulatedGps::new(&config.gps, config.seed)?,
            baro: match &config.baro {
                Some(baro) => Some(SimulatedBaro::new(baro, config.seed)?),
                None => None,
            },
            dmu,
            next_fix: 0,
            next_baro: 0,
            pending_fixes: Vec::new(),
            estimator: Estimator::new(settings),
            pilot: HoverAutopilot::new(config.autopilot)?,
            pilot_sticks: config.autopilot.trim.sticks,
            autopilot: HoverAutopilot::new(config.autopilot)?,
            engaged: true,
            orders: config.orders.iter(),
            acting: config.autopilot.trim.sticks,
            flight: Flight {
                manifest,
                imu: Vec::with_capacity(samples),
                fixes: Vec::new(),
                baro: Vec::new(),
                moments: Vec::with_capacity(samples),
                transitions: Vec::new(),
                crashed_s: None,
            },
            config,
            period_s,
        })
    }

    /// Sensors, estimator, autopilot, and the vehicle on to the next sample.
    fn sample(&mut self, sample: u64) -> Result<(), FlightError> {
        let time_s = sample as f64 * self.period_s;
        let time = Time::ZERO + time_s;
        let mut ordered = Ok(());
        while let Some((_, order)) =
            self.orders.as_slice().first().filter(|(due_s, _)| *due_s <= time_s + 1e-9)
        {
            self.orders.next();
            ordered = ordered.and(self.obey(order, time_s));
        }
        ordered?;

        let state = self.vehicle.state();
        let truth = Truth::of(time, &state);
        self.sense(time, &state);
        let solution = match self.config.feedback {
            Feedback::Estimator => self.estimator.solution(),
            Feedback::Truth => Some(exact(&truth)),
        };
        let pilot_flies = time_s < self.config.engage_s - 1e-9;
        if pilot_flies {
            let seen = exact(&truth);
            let sees = Inputs { now: time, solution: Some(&seen), pilot: None, engage: true };
            self.pilot_sticks = self.pilot.step(&sees).sticks;
        }
        let outputs = self.autopilot.step(&Inputs {
            now: time,
            solution: solution.as_ref(),
            pilot: Some(self.pilot_sticks),
            engage: self.engaged && !pilot_flies,
        });
        self.flight.transitions.extend(outputs.transition);
        let wind_mps = self.wind.next();
        self.flight.moments.push(Moment {
            truth,
            solution,
            mode: outputs.mode,
            sticks: outputs.sticks,
            servos: self.vehicle.servos(),
            wind_mps,
        });
        self.vehicle.step(self.acting, wind_mps, self.period_s);
        self.acting = outputs.sticks;
        Ok(())
    }

    fn obey(&mut self, order: &Order, time_s: f64) -> Result<(), FlightError> {
        match *order {
            Order::Go(set_point) => self
                .autopilot
                .set(set_point)
                .map_err(|source| FlightError::Order { time_s, source })?,
            Order::Disturb(disturbance) => self.vehicle.disturb(&disturbance),
            Order::Engage(engaged) => self.engaged = engaged,
            Order::Pilot(sticks) => self.pilot_sticks = sticks,
        }
        Ok(())
    }

    /// What the sensors say at `time`, to the record and to the estimator.
    fn sense(&mut self, time: Time, state: &State) {
        let config = self.config;
        let sample = self.dmu.measure(
            time,
            &Felt {
                angular_rate_radps: state.inertial_rate_radps,
                specific_force_mps2: state.specific_force_at(config.dmu.lever_arm_m),
                body_to_ned: state.body_to_ned,
            },
        );
        self.flight.imu.push(sample);
        let listens = config.feedback == Feedback::Estimator;
        if listens {
            self.estimator.push(&Event::Imu(sample), |_| {});
        }
        let due = |count: u64, rate_hz: f64| Time::ZERO + count as f64 / rate_hz <= time;
        while due(self.next_fix, config.gps.rate_hz) {
            self.next_fix += 1;
            // A receiver measures at its own moments; the samples are close enough to share one.
            let antenna = state.at_point(config.gps.lever_arm_m);
            if let Some(fix) = self.gps.measure(time, &antenna.position, antenna.velocity_mps) {
                self.pending_fixes.push((time + config.gps.latency_s, fix));
            }
        }
        let arrived = self.pending_fixes.partition_point(|(arrival, _)| *arrival <= time);
        for (_, fix) in self.pending_fixes.drain(..arrived) {
            self.flight.fixes.push(fix);
            if listens {
                self.estimator.push(&Event::Gps(fix), |_| {});
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
                self.estimator.push(&Event::Baro { time, height_m }, |_| {});
            }
        }
    }
}

/// A solution that is the truth.
fn exact(truth: &Truth) -> Solution {
    Solution {
        time: truth.time,
        position: truth.position,
        velocity_mps: truth.velocity_mps,
        body_to_ned: truth.body_to_ned,
        angular_rate_radps: truth.angular_rate_radps,
        position_sigma_m: Vector::ZERO,
        velocity_sigma_mps: Vector::ZERO,
        attitude_sigma_rad: [0.0; 3],
        gyro_bias_radps: Vector::ZERO,
        accel_bias_mps2: Vector::ZERO,
        gyro_bias_sigma_radps: Vector::ZERO,
        accel_bias_sigma_mps2: Vector::ZERO,
    }
}

impl Flight {
    /// Everything that was recorded, as a dataset and the truth about it, for
    /// [`Dataset::write`].
    #[must_use]
    pub fn dataset(&self) -> (Dataset, Vec<Truth>) {
        let dataset = Dataset {
            manifest: self.manifest.clone(),
            imu: self.imu.clone(),
            fixes: self.fixes.clone(),
            baro: self.baro.clone(),
            controls: self
                .moments
                .iter()
                .map(|moment| (moment.truth.time, moment.sticks.to_array()))
                .collect(),
            ..Dataset::default()
        };
        (dataset, self.moments.iter().map(|moment| moment.truth).collect())
    }

    /// How well the hover was held from `from_s` on, against where the vehicle then was; all zero
    /// where the flight did not last so long.
    #[must_use]
    pub fn statistics(&self, from_s: f64) -> HoverStatistics {
        let held = self.moments.partition_point(|moment| moment.truth.time.seconds() < from_s);
        let held = self.moments.get(held..).unwrap_or_default();
        let Some(first) = held.first().map(|moment| moment.truth) else {
            return HoverStatistics::default();
        };
        let [_, _, heading] = angles(&first.body_to_ned);
        let rms = |value: &dyn Fn(&Moment) -> f64| {
            let squares: f64 = held.iter().map(|moment| value(moment).powi(2)).sum();
            (squares / held.len() as f64).sqrt()
        };
        let spread = |value: &dyn Fn(&Moment) -> f64| {
            let mean = held.iter().map(value).sum::<f64>() / held.len() as f64;
            rms(&|moment| value(moment) - mean)
        };
        let axes = [0, 1, 2];
        HoverStatistics {
            velocity_rms_mps: axes.map(|axis| {
                rms(&|moment| {
                    let truth = &moment.truth;
                    (truth.body_to_ned.inverse() * truth.velocity_mps).to_array()[axis]
                })
            }),
            attitude_rms_deg: [
                spread(&|moment| angles(&moment.truth.body_to_ned)[0].to_degrees()),
                spread(&|moment| angles(&moment.truth.body_to_ned)[1].to_degrees()),
            ],
            heading_worst_deg: held
                .iter()
                .map(|moment| {
                    let [_, _, yaw] = angles(&moment.truth.body_to_ned);
                    wrap_angle(yaw - heading).abs().to_degrees()
                })
                .fold(0.0, f64::max),
            position_rms_m: axes.map(|axis| {
                rms(&|moment| {
                    moment.truth.position.displacement_from(&first.position).to_array()[axis]
                })
            }),
            velocity_error_rms_mps: axes.map(|axis| {
                rms(&|moment| {
                    moment.solution.map_or(f64::NAN, |solution| {
                        (solution.velocity_mps - moment.truth.velocity_mps).to_array()[axis]
                    })
                })
            }),
            attitude_error_rms_deg: axes.map(|axis| {
                rms(&|moment| {
                    moment.solution.map_or(f64::NAN, |solution| {
                        let found = angles(&solution.body_to_ned)[axis];
                        wrap_angle(found - angles(&moment.truth.body_to_ned)[axis]).to_degrees()
                    })
                })
            }),
            sticks_rms: [0, 1, 2, 3].map(|stick| spread(&|m| m.sticks.to_array()[stick])),
        }
    }
}

/// Roll, pitch and yaw, rad.
fn angles(body_to_ned: &Rotation<Body, Ned>) -> [f64; 3] {
    let EulerAngles { roll_rad, pitch_rad, yaw_rad } = body_to_ned.euler();
    [roll_rad, pitch_rad, yaw_rad]
}
