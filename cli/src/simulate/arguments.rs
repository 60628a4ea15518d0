//! What `hovernav simulate` can be asked for.

use std::path::PathBuf;
use std::str::FromStr;

use hovernav::earth::Geodetic;
use hovernav_sim::campaign::SensorGrade;
use hovernav_sim::{Disturbance, WindConfig};

use super::excitation::TestInput;
use super::failure::Failure;
use crate::arguments::{OutageWindow, finite, second};

/// Where to write unless given.
pub const OUT: &str = "out/simulated";

#[derive(clap::Args)]
pub struct Arguments {
    /// Where to write the dataset and its report; out/simulated unless given. With --flight and --lines
    /// there is no report: `hovernav estimate` on the dataset makes one
    #[arg(long, visible_alias = "record", value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Follow this path exactly, without autopilot, instead of flying the closed loop
    #[arg(long, value_enum, conflicts_with_all = [
        "model", "autopilot", "disturbance", "test_points", "duration", "wind", "sensors", "outage",
        "truth"
    ])]
    pub flight: Option<FlightPath>,
    /// Seed of every gust and sensor error: the same seed gives the same dataset
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Where to start: latitude and longitude in degrees, height above the ellipsoid in metres. The ground is at
    /// height 0, or 50 m below a start that is lower
    #[arg(long, value_name = "LAT,LON,HEIGHT", default_value = "1.3521,103.8198,50", value_parser = place, allow_hyphen_values = true)]
    pub place: Geodetic,
    /// Heading to start with, degrees from true north
    #[arg(long, value_name = "DEG", default_value_t = 60.0, value_parser = heading, allow_hyphen_values = true)]
    pub heading: f64,
    /// Model to design the autopilot for, a model.toml or raptor60, thesis, r50: raptor60 unless
    /// given. What flies is the nonlinear 60-class helicopter
    #[arg(long, conflicts_with = "autopilot")]
    pub model: Option<String>,
    /// The autopilot.toml to fly with, as `hovernav design` writes it
    #[arg(long, value_name = "FILE")]
    pub autopilot: Option<PathBuf>,
    /// Throw the vehicle out of its hover: p, q, r in rad/s, phi, theta, psi in rad, u, v, w in m/s.
    /// The first comes at 30 s, each further one 20 s later, or at the second given. It takes
    /// 0.3 s, so that the sensors feel it; with --truth it comes at once
    #[arg(long, value_name = "NAME=VALUE[@SECOND]", allow_hyphen_values = true)]
    pub disturbance: Vec<TimedDisturbance>,
    /// Fly test points for `hovernav identify`: from 30 s on each stick is stepped by SIZE of its full
    /// travel for 1.5 s, three times, by a pilot who sees the truth
    #[arg(
        long,
        value_name = "SIZE",
        num_args = 0..=1,
        default_missing_value = "0.12",
        value_parser = step,
        conflicts_with = "disturbance"
    )]
    pub test_points: Option<f64>,
    /// Let the autopilot fly a test input on a stick: lateral, longitudinal, collective, pedal, or `all`
    /// for one after another; step, doublet, 3211 or sweep; its size in full travel, 0.1 unless given;
    /// how long a step, a side of the doublet, a unit of 3-2-1-1 or the sweep lasts. The first comes at
    /// 30 s, each further one 8 s after the end of the one before, or at the second given. What is
    /// injected is in controls.csv
    #[arg(
        long,
        value_name = "STICK=KIND[:SIZE[:S]][@SECOND]",
        conflicts_with_all = ["disturbance", "test_points", "flight"]
    )]
    pub excite: Vec<TestInput>,
    /// Let something on the vehicle fail: the engine (power-loss), after which the air alone turns the
    /// rotors, or the servo of a stick, which stays where it is (jam-lateral, jam-longitudinal,
    /// jam-collective, jam-pedal); may be repeated
    #[arg(long, value_name = "NAME@SECOND", conflicts_with = "flight")]
    pub fault: Vec<Failure>,
    /// How long to fly, s. Unless given, 120 s, or longer: until 30 s after the last disturbance, test point or
    /// test input. With --lines it is also how long to wait for the flight computer; unless given, the
    /// flight then has no limit and the wait 300 s
    #[arg(long, value_name = "S", value_parser = seconds)]
    pub duration: Option<f64>,
    /// Wind: `calm`, or speed in m/s, where it comes from in degrees, gusts in m/s (one sigma);
    /// 3,135,1.5 unless given
    #[arg(long, value_name = "SPEED[,FROM[,GUST]]")]
    pub wind: Option<WindArgument>,
    /// The sensors: thesis, modern or poor
    #[arg(long, value_name = "GRADE", default_value = "thesis", value_parser = grade)]
    pub sensors: SensorGrade,
    /// Lose GPS from START for DURATION seconds; may be repeated
    #[arg(long, value_name = "START:DURATION")]
    pub outage: Vec<OutageWindow>,
    /// Let the autopilot fly on the truth instead of the estimate: what the loops alone can do
    #[arg(long)]
    pub truth: bool,
    /// Write no report.html
    #[arg(long)]
    pub no_report: bool,
    /// Put the helicopter, its sensors and a pilot behind the serial lines that --config names, in real
    /// time, for `hovernav fly --config` of the same file to fly
    #[cfg(feature = "lines")]
    #[arg(long, requires = "config", conflicts_with_all = [
        "flight", "disturbance", "test_points", "excite", "outage", "truth", "fault"
    ])]
    pub lines: bool,
    /// The flight computer's fly.toml
    #[cfg(feature = "lines")]
    #[arg(long, value_name = "FILE", requires = "lines")]
    pub config: Option<PathBuf>,
    /// With --lines: what the pilot does and what is lost, ACT@START[:DURATION] in seconds, `engage@30:60`
    /// or `stick-pedal=0.3@50:2` say; may be repeated
    #[cfg(feature = "lines")]
    #[arg(long = "do", value_name = "ACT", requires = "lines")]
    pub act: Vec<hovernav_hil::TimedAct>,
}

fn place(text: &str) -> Result<Geodetic, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(finite).collect();
    match numbers.as_deref() {
        Some(&[lat, lon, height]) => {
            Geodetic::from_degrees(lat, lon, height).filter(Geodetic::is_navigable)
        }
        _ => None,
    }
    .ok_or_else(|| format!("found \"{text}\", expected LAT,LON,HEIGHT of a place on Earth"))
}

fn heading(text: &str) -> Result<f64, String> {
    finite(text).ok_or_else(|| format!("found \"{text}\", expected degrees"))
}

fn step(text: &str) -> Result<f64, String> {
    let size = text.parse().ok().filter(|size| (0.03..=0.5).contains(size));
    size.ok_or_else(|| format!("found \"{text}\", expected a part of full travel, 0.03 to 0.5"))
}

fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|seconds| (1.0..=86_400.0).contains(seconds));
    number.ok_or_else(|| format!("found \"{text}\", expected seconds, from 1 to a day"))
}

fn grade(text: &str) -> Result<SensorGrade, String> {
    let found = SensorGrade::ALL.into_iter().find(|grade| grade.name() == text);
    found.ok_or_else(|| format!("found \"{text}\", expected thesis, modern or poor"))
}

/// A path to follow exactly.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum FlightPath {
    /// Five minutes of hover
    Hover,
    /// Roll, pitch, heave and yaw doublets from hover, as for identification
    TestPoints,
    /// Five minutes of hover, turns, test points, climbs and forward flight
    Tour,
}

/// `NAME=VALUE[@SECOND]`: a disturbance, and when it comes if that is given.
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
        // What is further off is degrees.
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

/// `calm`, or `SPEED[,FROM[,GUST]]`.
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
