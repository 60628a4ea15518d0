//! A flight to be flown.

use crate::aids::{AntennasConfig, RangefinderConfig};
use crate::baro::BaroConfig;
use crate::check::ConfigError;
use crate::dmu::{DmuConfig, MagnetometerConfig};
use crate::gps::GpsConfig;
use crate::manifest::sensor_manifest;
use crate::vehicle::{Disturbance, VehicleConfig};
use crate::wind::WindConfig;
use hovernav::autopilot;
use hovernav::autopilot::{Excitation, ExcitationError, HoverConfig, SetPoint, SetPointError};
use hovernav::controls::Sticks;
use hovernav::earth::Geodetic;
use hovernav::ekf::EstimatorConfig;
use hovernav_log::{Dataset, LogError, Manifest};
use hovernav_model::helicopter::{HelicopterError, HelicopterParameters};

/// What the autopilot flies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feedback {
    /// The estimator, fed by the simulated sensors.
    Estimator,
    /// The truth, without error or delay: what the loops alone can do.
    Truth,
}

/// Something that happens at a given time of the flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlightEvent {
    /// A new set-point for the autopilot.
    SetPoint(SetPoint),
    /// A step in the vehicle's state, which no inertial sensor measures.
    Disturb(Disturbance),
    /// The same so that inertial sensors measure it: rates at once, velocity and attitude within
    /// 0.3 s.
    Push(Disturbance),
    /// The pilot's switch: whether the autopilot flies.
    Engage(bool),
    /// The pilot holds the sticks here from now on.
    PilotSticks(Sticks),
    /// The autopilot flies a test input.
    Excite(Excitation),
    /// The servo of a stick, 0 lateral to 3 pedal, stays where it is.
    Jam(usize),
    /// The engine stops.
    PowerLoss,
    /// The vehicle weighs this from now on, kg: fuel burnt, a load dropped.
    Mass(f64),
    /// This is added to the sticks from now on, whoever flies: a test input. The sticks that are
    /// recorded hold it.
    AddSticks(Sticks),
}

impl FlightEvent {
    /// Chapter 5's test points, the first at `start_s`: each stick stepped by `size` for 1.5 s, three
    /// times, [`TEST_POINT_S`](Self::TEST_POINT_S) apart; pedal, collective, lateral, longitudinal.
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

    /// From one test point to the next, s.
    pub const TEST_POINT_S: f64 = 10.0;
}

/// A flight to be flown. [`FlightConfig::new`] is five minutes of hover of the thesis's helicopter
/// with the thesis's sensors in gusts of 1.5 m/s.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightConfig {
    /// The airframe.
    pub helicopter: HelicopterParameters,
    /// The airframe whose hover leaves every stick at zero; `None` for `helicopter` itself. The autopilot
    /// starts from sticks at trim, so what differs has to be found in flight.
    pub rigged_for: Option<HelicopterParameters>,
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
    /// The rangefinder, if there is one.
    pub rangefinder: Option<RangefinderConfig>,
    /// Two antennas that give a heading, if there are.
    pub antennas: Option<AntennasConfig>,
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
    pub events: Vec<(f64, FlightEvent)>,
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
    /// A set-point that the autopilot refuses.
    #[error("set-point at {time_s} s: {source}")]
    SetPoint {
        /// When.
        time_s: f64,
        /// Why.
        source: SetPointError,
    },
    /// A test input that the autopilot refuses.
    #[error("at {time_s} s: {source}")]
    Excitation {
        /// When.
        time_s: f64,
        /// Why.
        source: ExcitationError,
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

impl FlightConfig {
    /// Five minutes of hover under `autopilot`.
    #[must_use]
    pub fn new(autopilot: HoverConfig) -> Self {
        Self {
            helicopter: HelicopterParameters::raptor60(),
            rigged_for: None,
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

    /// Moves the start of the hover to `place`, into the Earth's magnetic field there. Where it is less than
    /// [`ROOM_M`](Self::ROOM_M) above the ellipsoid, the ground is so much below it, otherwise at the ellipsoid.
    pub fn start_at(&mut self, place: Geodetic) {
        self.start = place;
        self.vehicle.ground_m = (place.height_m - Self::ROOM_M).min(0.0);
        if let Some(magnetometer) = &mut self.dmu.magnetometer {
            magnetometer.field_gauss = MagnetometerConfig::at(&place).field_gauss;
        }
    }

    /// Room below a start, m: a hover wanders in height as the receiver does, and is not to touch the ground.
    pub const ROOM_M: f64 = 50.0;

    /// What the sensors are, as a dataset tells it.
    #[must_use]
    pub fn manifest(&self) -> Manifest {
        let vehicle = format!("simulated helicopter in closed loop, seed {}", self.seed);
        let mut manifest = sensor_manifest(vehicle, &self.dmu, &self.gps);
        // The heading that a unit computes for itself wanders by degrees within a minute, the error
        // of its magnetometer stays: a hover is held by the one that stays.
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

    /// The estimator's settings as the sensors' own configurations tell them.
    ///
    /// # Errors
    /// [`LogError`] for sensors that no dataset can describe.
    pub fn settings(&self) -> Result<EstimatorConfig, LogError> {
        Dataset { manifest: self.manifest(), ..Dataset::default() }.settings()
    }
}
