//! Configuration of a simulated flight.

use crate::aids::{AntennasConfig, RangefinderConfig};
use crate::baro::BaroConfig;
use crate::check::ConfigError;
use crate::disturbance::Disturbance;
use crate::dmu::{DmuConfig, MagnetometerConfig};
use crate::gps::GpsConfig;
use crate::manifest::sensor_manifest;
use crate::vehicle::{Vehicle, VehicleConfig};
use crate::wind::WindConfig;
use hovernav::autopilot;
use hovernav::autopilot::{Excitation, ExcitationError, HoverConfig, SetPoint, SetPointError};
use hovernav::controls::Sticks;
use hovernav::earth::Geodetic;
use hovernav::ekf::EstimatorConfig;
use hovernav_dataset::{Dataset, LogError, Manifest};
use hovernav_model::helicopter::{Helicopter, HelicopterError, HelicopterParameters};
use hovernav_model::{AirframeError, LinearAirframe, ModelError, StateSpace};

/// Feedback of the autopilot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feedback {
    /// The estimator with the simulated sensors.
    Estimator,
    /// The truth, without error or delay: the performance of the loops alone.
    Truth,
}

/// An event at a given time of the flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlightEvent {
    /// A new set-point of the autopilot.
    SetPoint(SetPoint),
    /// A step in the vehicle's state, which inertial sensors do not measure.
    Disturb(Disturbance),
    /// A change of the vehicle's state that inertial sensors measure: rates immediately, velocity and attitude within
    /// 0.3 s.
    Push(Disturbance),
    /// The pilot's switch: whether the autopilot is engaged.
    Engage(bool),
    /// The pilot holds the sticks at these positions from now on.
    PilotSticks(Sticks),
    /// The autopilot flies a test input.
    Excite(Excitation),
    /// The servo of a stick, 0 lateral to 3 pedal, jams.
    Jam(usize),
    /// The engine stops.
    PowerLoss,
    /// Mass of the vehicle from now on, kg: after burning fuel or dropping a load.
    Mass(f64),
    /// Test input added to the sticks from now on, with or without the autopilot. The recorded sticks include it.
    AddSticks(Sticks),
}

impl FlightEvent {
    /// Test points of chapter 5 of the thesis, the first at `start_s`. Pedal, collective, lateral and longitudinal are
    /// stepped in turn by `size` for 1.5 s, three times each, [`TEST_POINT_S`](Self::TEST_POINT_S) apart.
    #[must_use]
    pub fn test_points(start_s: f64, size: f64) -> Vec<(f64, Self)> {
        let mut events = Vec::new();
        for (point, stick) in [3, 2, 0, 1].into_iter().flat_map(|stick| [stick; 3]).enumerate() {
            let at_s = start_s + point as f64 * Self::TEST_POINT_S;
            let mut sticks = [0.0; 4];
            sticks[stick] = size;
            events.push((at_s, Self::AddSticks(Sticks::from_array(sticks))));
            events.push((at_s + 1.5, Self::AddSticks(Sticks::NEUTRAL)));
        }
        events
    }

    /// Time between test points, s.
    pub const TEST_POINT_S: f64 = 10.0;
}

/// Configuration of a simulated flight. [`FlightConfig::new`] is a hover of five minutes with the thesis's helicopter
/// and sensors, in gusts of 1.5 m/s.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightConfig {
    /// The airframe.
    pub helicopter: HelicopterParameters,
    /// The airframe whose hover needs every stick at zero; `None` for `helicopter` itself. The trim in the autopilot's
    /// configuration does not contain the difference between the two airframes.
    pub rigged_for: Option<HelicopterParameters>,
    /// The linear model that flies instead of `helicopter`, if any. Loss of power and changes of mass are rejected for
    /// it.
    pub model: Option<StateSpace>,
    /// Servos, governor and ground.
    pub vehicle: VehicleConfig,
    /// Wind and gusts.
    pub wind: WindConfig,
    /// The inertial unit, whose rate is also that of the autopilot.
    pub dmu: DmuConfig,
    /// The GPS receiver, with its outages.
    pub gps: GpsConfig,
    /// The barometer, if any.
    pub baro: Option<BaroConfig>,
    /// The rangefinder, if any.
    pub rangefinder: Option<RangefinderConfig>,
    /// Two antennas for the heading, if any.
    pub antennas: Option<AntennasConfig>,
    /// The estimator's settings; `None` for those of the sensors' own configurations.
    pub estimator: Option<EstimatorConfig>,
    /// Feedback of the autopilot.
    pub feedback: Feedback,
    /// The autopilot.
    pub autopilot: HoverConfig,
    /// Start position of the hover.
    pub start: Geodetic,
    /// Initial heading, rad.
    pub heading_rad: f64,
    /// Time at which the autopilot is engaged, s. Until then a pilot with knowledge of the truth holds the hover.
    pub engage_s: f64,
    /// Further events, s from the start, in order.
    pub events: Vec<(f64, FlightEvent)>,
    /// Duration, s.
    pub duration_s: f64,
    /// Seed of all errors and gusts.
    pub seed: u64,
}

/// Reasons why a flight cannot be simulated.
#[derive(Debug, thiserror::Error)]
pub enum FlightError {
    /// An invalid sensor, servo or wind.
    #[error(transparent)]
    Sensor(#[from] ConfigError),
    /// An invalid airframe.
    #[error(transparent)]
    Helicopter(#[from] HelicopterError),
    /// A model that is no airframe.
    #[error("{model}: {source}")]
    Airframe {
        /// Name of the model.
        model: String,
        /// The reason.
        source: AirframeError,
    },
    /// A model with derivatives that are not finite.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// An event that a linear model does not describe.
    #[error(
        "at {time_s} s: found {what}, expected an event that a linear model describes: it has no {lacks}"
    )]
    NotModelled {
        /// Time, s.
        time_s: f64,
        /// The event.
        what: &'static str,
        /// Part of the vehicle that the model lacks.
        lacks: &'static str,
    },
    /// An invalid autopilot.
    #[error(transparent)]
    Autopilot(#[from] autopilot::ConfigError),
    /// A set-point that the autopilot rejects.
    #[error("set-point at {time_s} s: {source}")]
    SetPoint {
        /// Time, s.
        time_s: f64,
        /// The reason.
        source: SetPointError,
    },
    /// A test input that the autopilot rejects.
    #[error("at {time_s} s: {source}")]
    Excitation {
        /// Time, s.
        time_s: f64,
        /// The reason.
        source: ExcitationError,
    },
    /// The inertial unit does not sample at the autopilot's rate.
    #[error(
        "found an inertial unit that samples every {dmu_s} s, expected {autopilot_s} s as in the autopilot's design"
    )]
    Rate {
        /// Period of the inertial unit, s.
        dmu_s: f64,
        /// Period of the autopilot, s.
        autopilot_s: f64,
    },
    /// The inertial unit outputs increments, but the closed loop requires rates.
    #[error("found an inertial unit with increments, expected rates for the closed loop")]
    Increments,
    /// The sensors' settings are invalid for the estimator.
    #[error(transparent)]
    Settings(#[from] LogError),
    /// The start position is invalid.
    #[error("invalid start {0:?}: north, east and down are undefined there")]
    Start(Geodetic),
}

impl FlightConfig {
    /// A hover of five minutes under `autopilot`.
    #[must_use]
    pub fn new(autopilot: HoverConfig) -> Self {
        Self {
            helicopter: HelicopterParameters::raptor60(),
            rigged_for: None,
            model: None,
            vehicle: VehicleConfig::default(),
            wind: WindConfig::default(),
            dmu: DmuConfig::default(),
            gps: GpsConfig::default(),
            baro: Some(BaroConfig::default()),
            rangefinder: None,
            antennas: None,
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
            events: Vec::new(),
            duration_s: 300.0,
            seed: 1,
        }
    }

    /// Moves the start of the hover to the position `place`, with the Earth's magnetic field there. The ground is at
    /// the ellipsoid, or [`ROOM_M`](Self::ROOM_M) below the start where that is lower.
    pub fn start_at(&mut self, place: Geodetic) {
        self.start = place;
        self.vehicle.ground_m = (place.height_m - Self::ROOM_M).min(0.0);
        if let Some(magnetometer) = &mut self.dmu.magnetometer {
            magnetometer.field_gauss = MagnetometerConfig::at(&place).field_gauss;
        }
    }

    /// Clearance below a start, m. The height of a hover drifts with the receiver's height, and the vehicle must not
    /// touch the ground.
    pub const ROOM_M: f64 = 50.0;

    /// The sensors in the form of a dataset's manifest.
    #[must_use]
    pub fn manifest(&self) -> Manifest {
        let vehicle = format!("simulated helicopter in closed loop, seed {}", self.seed);
        let mut manifest = sensor_manifest(vehicle, &self.dmu, &self.gps);
        // The heading of an inertial unit drifts by degrees within a minute, while the error of its magnetometer stays
        // constant. A hover therefore uses the magnetometer.
        let unit_attitude = self.dmu.magnetometer.is_none();
        if let Some(rangefinder) = &self.rangefinder {
            manifest.rangefinder.lever_arm_m = rangefinder.lever_arm_m;
        }
        if let Some(antennas) = &self.antennas {
            let second_m = self.gps.lever_arm_m + antennas.baseline_m;
            manifest.second_antenna.lever_arm_m = Some(second_m);
        }
        manifest.aiding.insert("attitude".into(), unit_attitude.into());
        manifest
    }

    /// The vehicle at the start of the flight, and its stick positions in hover.
    ///
    /// # Errors
    /// [`FlightError`] for an airframe that cannot fly, and for events that the airframe cannot simulate.
    pub fn hovering(&self) -> Result<(Vehicle, Sticks), FlightError> {
        if let Some(model) = &self.model {
            let rejected = |source| FlightError::Airframe { model: model.name().into(), source };
            let airframe = LinearAirframe::new(model).map_err(rejected)?;
            let lacking = self.events.iter().find_map(|(time_s, event)| match event {
                FlightEvent::PowerLoss => Some((*time_s, "a loss of power", "engine")),
                FlightEvent::Mass(_) => Some((*time_s, "a change of mass", "mass")),
                _ => None,
            });
            if let Some((time_s, what, lacks)) = lacking {
                return Err(FlightError::NotModelled { time_s, what, lacks });
            }
            let period_s = self.autopilot.period_s;
            let (start, heading_rad) = (self.start, self.heading_rad);
            let linear = (airframe, model);
            let vehicle = Vehicle::linear(&self.vehicle, linear, start, heading_rad, period_s)?;
            return Ok((vehicle, Sticks::NEUTRAL));
        }
        let helicopter = match self.rigged_for {
            None => Helicopter::new(self.helicopter)?,
            Some(rigged_for) => Helicopter::new(rigged_for)?.with_parameters(self.helicopter)?,
        };
        let sticks = helicopter.hover_sticks();
        let vehicle = Vehicle::hovering(&self.vehicle, helicopter, self.start, self.heading_rad)?;
        Ok((vehicle, sticks))
    }

    /// The estimator's settings from the sensors' own configurations.
    ///
    /// # Errors
    /// [`LogError`] for sensors that a dataset cannot describe.
    pub fn settings(&self) -> Result<EstimatorConfig, LogError> {
        Dataset { manifest: self.manifest(), ..Dataset::default() }.settings()
    }
}
