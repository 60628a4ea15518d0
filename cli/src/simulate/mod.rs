//! `hovernav simulate`: a flight whose truth is known, recorded as a dataset.

mod hover;
mod page;
mod path;

pub use hover::Flown;

use std::path::PathBuf;

use anyhow::ensure;
use hovernav::earth::Geodetic;
use hovernav_sim::campaign::SensorGrade;

use crate::estimate::Window;

/// Where to write unless told.
const OUT: &str = "out/simulated";

#[derive(clap::Args)]
pub struct Arguments {
    /// Where to write the dataset and its report; out/simulated unless given
    #[arg(long, visible_alias = "record", value_name = "DIR")]
    out: Option<PathBuf>,
    /// Follow this path exactly, without autopilot, instead of flying the closed loop
    #[arg(long, value_enum, conflicts_with_all = [
        "model", "autopilot", "disturbance", "test_points", "duration", "wind", "sensors", "outage",
        "truth"
    ])]
    flight: Option<path::Flight>,
    /// Seed of every gust and sensor error: the same seed gives the same dataset
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Where to start: latitude and longitude in degrees, height above the ellipsoid in metres
    #[arg(long, value_name = "LAT,LON,HEIGHT", default_value = "1.3521,103.8198,50", value_parser = place, allow_hyphen_values = true)]
    place: Geodetic,
    /// Heading to start with, degrees from true north
    #[arg(long, value_name = "DEG", default_value_t = 60.0, allow_hyphen_values = true)]
    heading: f64,
    /// Model to design the autopilot for, a model.toml or raptor60, thesis, r50: raptor60 unless
    /// given. What flies is the nonlinear 60-class helicopter
    #[arg(long, conflicts_with = "autopilot")]
    model: Option<String>,
    /// The autopilot.toml to fly with, as `hovernav design` writes it
    #[arg(long, value_name = "FILE")]
    autopilot: Option<PathBuf>,
    /// Throw the vehicle out of its hover: p, q, r in rad/s, phi, theta, psi in rad, u, v, w in m/s.
    /// The first comes at 30 s, each further one 20 s later, or at the second given. It takes
    /// 0.3 s, so that the sensors feel it; with --truth it comes at once
    #[arg(long, value_name = "NAME=VALUE[@SECOND]", allow_hyphen_values = true)]
    disturbance: Vec<hover::Thrown>,
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
    test_points: Option<f64>,
    /// How long to fly, s; 120, or until 30 s after the last disturbance or test point
    #[arg(long, value_name = "S", value_parser = seconds)]
    duration: Option<f64>,
    /// Wind: `calm`, or speed in m/s, where it comes from in degrees, gusts in m/s (one sigma);
    /// 3,135,1.5 unless given
    #[arg(long, value_name = "SPEED[,FROM[,GUST]]")]
    wind: Option<hover::Blowing>,
    /// The sensors
    #[arg(long, default_value = "thesis", value_parser = grade)]
    sensors: SensorGrade,
    /// Lose GPS from START for DURATION seconds; may be repeated
    #[arg(long, value_name = "START:DURATION")]
    outage: Vec<Window>,
    /// Let the autopilot fly on the truth instead of the estimate: what the loops alone can do
    #[arg(long)]
    truth: bool,
    /// Write no report.html
    #[arg(long)]
    no_report: bool,
}

fn place(text: &str) -> Result<Geodetic, String> {
    let numbers: Vec<f64> = text.split(',').map_while(|part| part.trim().parse().ok()).collect();
    match numbers[..] {
        [lat, lon, height] => {
            Geodetic::from_degrees(lat, lon, height).filter(Geodetic::is_navigable)
        }
        _ => None,
    }
    .ok_or_else(|| format!("found \"{text}\", expected LAT,LON,HEIGHT of a place on Earth"))
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

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    ensure!(
        arguments.heading.is_finite(),
        "heading: found {}, expected degrees",
        arguments.heading
    );
    match arguments.flight {
        Some(flight) => path::run(arguments, flight),
        None => hover::run(arguments),
    }
}
