//! Arguments of `hovernav simulate`.

use std::path::PathBuf;
use std::str::FromStr;

use hovernav::earth::Geodetic;
use hovernav_dataset::HIGHEST_LATITUDE_DEG;
use hovernav_sim::campaign::SensorGrade;
use hovernav_sim::{Disturbance, WindConfig};

use super::excitation::TestInput;
use super::failure::Failure;
use super::velocity::TimedVelocity;
use crate::arguments::{OutageWindow, finite, second};

/// The default output directory.
pub const OUT: &str = "out/simulated";

#[derive(clap::Args)]
pub struct Arguments {
    /// Directory to write the dataset and its report [default: out/simulated]
    #[arg(long, visible_alias = "record", value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Follow this path exactly, without the autopilot, instead of simulating the closed loop
    #[arg(long, value_enum, conflicts_with_all = [
        "model", "vehicle", "autopilot", "disturbance", "test_points", "duration", "wind", "sensors", "outage",
        "truth"
    ])]
    pub flight: Option<FlightPath>,
    /// Seed of all gusts and sensor errors: the same seed gives the same dataset
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Start position: latitude and longitude in degrees, height above the ellipsoid in metres. The ground is at height
    /// 0, or 50 m below the start if the start is lower
    #[arg(long, value_name = "LAT,LON,HEIGHT", default_value = "1.3521,103.8198,50", value_parser = place, allow_hyphen_values = true)]
    pub place: Geodetic,
    /// Heading at the start, degrees from true north
    #[arg(long, value_name = "DEG", default_value_t = 60.0, value_parser = heading, allow_hyphen_values = true)]
    pub heading: f64,
    /// Model to design the autopilot for: a model.toml, raptor60, thesis or r50 [default: raptor60]
    #[arg(long, conflicts_with = "autopilot")]
    pub model: Option<String>,
    /// Vehicle to fly: raptor60, the nonlinear 60-class helicopter, or a linear model of any vehicle, a model.toml, r50
    /// or thesis [default: --model]
    #[arg(long, value_name = "VEHICLE")]
    pub vehicle: Option<String>,
    /// The autopilot.toml to fly with, written by `hovernav design`
    #[arg(long, value_name = "FILE")]
    pub autopilot: Option<PathBuf>,
    /// Disturb the vehicle in hover: p, q, r in rad/s, phi, theta, psi in rad, u, v, w in m/s. Without SECOND, the
    /// first disturbance starts at 30 s and each further one 20 s later. It takes 0.3 s, so that the sensors measure
    /// it; with --truth it is instantaneous
    #[arg(long, value_name = "NAME=VALUE[@SECOND]", allow_hyphen_values = true)]
    pub disturbance: Vec<TimedDisturbance>,
    /// Fly test points for `hovernav identify`, by a pilot who knows the true state. From 30 s on, each stick is
    /// stepped three times by SIZE of its full travel [default: 0.12], for 1.5 s each
    #[arg(
        long,
        value_name = "SIZE",
        num_args = 0..=1,
        default_missing_value = "0.12",
        value_parser = step,
        conflicts_with = "disturbance"
    )]
    pub test_points: Option<f64>,
    /// Inject a test input on a stick during the autopilot flight. STICK: lateral, longitudinal, collective, pedal, or
    /// `all` for one after another. KIND: step, doublet, 3211 or sweep. SIZE: fraction of full travel [default: 0.1].
    /// S: duration of a step, of one side of a doublet, of one unit of 3-2-1-1, or of the sweep. Without SECOND, the
    /// first input starts at 30 s and each further one 8 s after the end of the previous one. controls.csv contains the
    /// injected input
    #[arg(
        long,
        value_name = "STICK=KIND[:SIZE[:S]][@SECOND]",
        conflicts_with_all = ["disturbance", "test_points", "flight"]
    )]
    pub excite: Vec<TestInput>,
    /// Fly at this velocity over the ground instead of holding the position: forward, to the right and down in m/s, TURN in
    /// °/s to the right; may be repeated. `hold` stops. Without SECOND, the first starts at 30 s and each further one 30 s
    /// after the previous one. The autopilot's [guidance] limits the speed
    #[arg(
        long,
        value_name = "FORWARD[,RIGHT[,DOWN[,TURN]]][@SECOND]",
        conflicts_with = "flight",
        allow_hyphen_values = true
    )]
    pub velocity: Vec<TimedVelocity>,
    /// Simulate a failure; may be repeated. With power-loss the engine stops, and only the air drives the rotors. With
    /// jam-lateral, jam-longitudinal, jam-collective or jam-pedal the servo of that stick stays at its position
    #[arg(long, value_name = "NAME@SECOND", conflicts_with = "flight")]
    pub fault: Vec<Failure>,
    /// Duration of the flight, s [default: 120, or until 30 s after the last event; 300
    /// with --lines]. With --lines, a given value also limits the wait for the flight computer
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub duration: Option<f64>,
    /// Wind: `calm`, or SPEED in m/s, FROM (the direction it comes from) in degrees, GUST (one sigma) in m/s [default:
    /// 3,135,1.5]. Without FROM it is 0, without GUST half the speed
    #[arg(long, value_name = "SPEED[,FROM[,GUST]]")]
    pub wind: Option<WindArgument>,
    /// Sensor grade: thesis, modern or poor
    #[arg(long, value_name = "GRADE", default_value = "thesis", value_parser = grade)]
    pub sensors: SensorGrade,
    /// Lose GPS for DURATION seconds from START on; may be repeated
    #[arg(long, value_name = "START:DURATION")]
    pub outage: Vec<OutageWindow>,
    /// Feed the autopilot with the true state instead of the estimate, to test the loops alone
    #[arg(long)]
    pub truth: bool,
    /// Do not write report.html
    #[arg(long)]
    pub no_report: bool,
    /// Connect the simulated helicopter, sensors and pilot to the serial lines that --config names, in real time;
    /// `hovernav fly --config` with the same file then flies it
    #[cfg(feature = "lines")]
    #[arg(long, requires = "config", conflicts_with_all = [
        "flight", "disturbance", "test_points", "excite", "outage", "truth", "fault", "velocity"
    ])]
    pub lines: bool,
    /// The flight computer's fly.toml
    #[cfg(feature = "lines")]
    #[arg(long, value_name = "FILE", requires = "lines")]
    pub config: Option<PathBuf>,
    /// With --lines: an action of the pilot or a failure of the sensors, ACT@START[:DURATION] in seconds, such as
    /// `engage@30:60` or `stick-pedal=0.3@50:2`; may be repeated. ACT is one of engage, stick-CHANNEL=VALUE, still,
    /// pilot-lost, failsafe, aux-lost, dmu-cut, dmu-pulled, gps-cut, gps-pulled, no-fix, frozen-fix, wild-fix,
    /// frozen-imu, wild-packet, dmu-noise, gps-noise, servos-cut. Without DURATION it lasts to the end
    #[cfg(feature = "lines")]
    #[arg(long = "do", value_name = "ACT", requires = "lines")]
    pub act: Vec<hovernav_hil::TimedAct>,
}

fn place(text: &str) -> Result<Geodetic, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(finite).collect();
    match numbers.as_deref() {
        Some(&[lat, _, _]) if (HIGHEST_LATITUDE_DEG..=90.0).contains(&lat.abs()) => {
            return Err(format!("found latitude {lat}°, expected at most {HIGHEST_LATITUDE_DEG}°"));
        }
        Some(&[lat, lon, height]) => {
            Geodetic::from_degrees(lat, lon, height).filter(Geodetic::is_navigable)
        }
        _ => None,
    }
    .ok_or_else(|| format!("found \"{text}\", expected LAT,LON,HEIGHT of a position on Earth"))
}

fn heading(text: &str) -> Result<f64, String> {
    finite(text).ok_or_else(|| format!("found \"{text}\", expected degrees"))
}

fn step(text: &str) -> Result<f64, String> {
    let size = text.parse().ok().filter(|size| (0.03..=0.5).contains(size));
    size.ok_or_else(|| format!("found \"{text}\", expected a fraction of full travel, 0.03 to 0.5"))
}

fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|seconds| (1.0..=86_400.0).contains(seconds));
    number.ok_or_else(|| format!("found \"{text}\", expected seconds, from 1 to a day"))
}

fn grade(text: &str) -> Result<SensorGrade, String> {
    let found = SensorGrade::ALL.into_iter().find(|grade| grade.name() == text);
    found.ok_or_else(|| format!("found \"{text}\", expected thesis, modern or poor"))
}

/// A prescribed path.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum FlightPath {
    /// Five minutes of hover
    Hover,
    /// Roll, pitch, heave and yaw doublets from hover, as for identification
    TestPoints,
    /// Five minutes of hover, turns, test points, climbs and forward flight
    Tour,
}

/// Disturbance, with its start time if given, in the form `NAME=VALUE[@SECOND]`.
#[derive(Clone, Copy)]
pub struct TimedDisturbance {
    pub disturbance: Disturbance,
    pub at_s: Option<f64>,
}

impl FromStr for TimedDisturbance {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "found \"{text}\", expected NAME=VALUE or NAME=VALUE@SECOND with NAME one of p, q, r, \
                 phi, theta, psi, u, v, w and SECOND from 0 to a day"
            )
        };
        let (name, value) = text.split_once('=').ok_or_else(expected)?;
        let (value, at_s) = match value.split_once('@') {
            None => (value, None),
            Some((value, at)) => (value, Some(second(at).ok_or_else(expected)?)),
        };
        let value = finite(value).ok_or_else(expected)?;
        // A larger angle was probably meant in degrees.
        let (most, unit) = match name.trim() {
            "phi" | "theta" => (1.5, "rad"),
            "psi" => (3.15, "rad"),
            "p" | "q" | "r" => (10.0, "rad/s"),
            _ => (50.0, "m/s"),
        };
        if value.abs() > most {
            return Err(format!("found \"{text}\", expected {unit}, at most {most} either way"));
        }
        let disturbance = Disturbance::of_state(name.trim(), value).ok_or_else(expected)?;
        Ok(Self { disturbance, at_s })
    }
}

/// Wind in the form `calm`, or `SPEED[,FROM[,GUST]]`.
#[derive(Clone, Copy)]
pub struct WindArgument(pub WindConfig);

impl FromStr for WindArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "calm" {
            return Ok(Self(WindConfig::calm()));
        }
        let parts: Option<Vec<f64>> = text.split(',').map(finite).collect();
        let (speed, from_deg, gust) = match parts.as_deref() {
            Some(&[speed]) => (speed, 0.0, 0.5 * speed),
            Some(&[speed, from_deg]) => (speed, from_deg, 0.5 * speed),
            Some(&[speed, from_deg, gust]) => (speed, from_deg, gust),
            _ => (-1.0, 0.0, 0.0),
        };
        if !(0.0..=50.0).contains(&speed) || !(0.0..=20.0).contains(&gust) {
            return Err(format!(
                "found \"{text}\", expected calm, or SPEED[,FROM[,GUST]] with 0 to 50 m/s, degrees, 0 \
                 to 20 m/s"
            ));
        }
        Ok(Self(WindConfig::from_direction(speed, from_deg.to_radians(), gust)))
    }
}
