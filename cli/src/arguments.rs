//! Values of arguments that several verbs take.

use std::path::Path;
use std::str::FromStr;

use anyhow::ensure;
use hovernav::time::Time;
use hovernav_formats::Options;
use hovernav_log::{LocalAxes, Outage, Trajectory};

/// The axes of a trajectory in local metres.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum AxesArgument {
    Enu,
    Ned,
}

impl From<AxesArgument> for LocalAxes {
    fn from(axes: AxesArgument) -> Self {
        match axes {
            AxesArgument::Enu => Self::EnuFlu,
            AxesArgument::Ned => Self::NedFrd,
        }
    }
}

/// The trajectory in a file, in the `solution.csv` of a directory, or in the files that a mapping names.
pub fn open_trajectory(path: &Path, axes: LocalAxes) -> anyhow::Result<Trajectory> {
    ensure!(
        path.exists(),
        "{}: no such file or directory, expected a trajectory: solution.csv, TUM, EuRoC, or a directory with a \
         solution.csv",
        path.display()
    );
    if !path.is_dir() {
        return Ok(Trajectory::open(path, axes)?);
    }
    let file = path.join("solution.csv");
    if !file.exists() && path.join("mapping.toml").exists() {
        return mapped_trajectory(path);
    }
    ensure!(
        file.exists(),
        "{}: found neither a solution.csv nor a mapping.toml in it, expected an output directory of estimate or \
         one that init made",
        path.display()
    );
    Ok(Trajectory::open(&file, axes)?)
}

/// The trajectory in the files that the mapping in the directory `path` names.
#[cfg(feature = "formats")]
fn mapped_trajectory(path: &Path) -> anyhow::Result<Trajectory> {
    Ok(hovernav_formats::trajectory(path)?)
}

#[cfg(not(feature = "formats"))]
fn mapped_trajectory(path: &Path) -> anyhow::Result<Trajectory> {
    Err(crate::memory::left_out(path, "text in columns"))
}

/// Which of several sensors to read, where a log has more than one.
#[derive(clap::Args)]
pub struct Sensors {
    /// Which inertial unit of the log to read, counted from 0
    #[arg(long, value_name = "N")]
    imu: Option<usize>,
    /// Which GPS receiver of the log to read, counted from 0
    #[arg(long, value_name = "N")]
    gps: Option<usize>,
    /// Which magnetometer of the log to read, counted from 0
    #[arg(long, value_name = "N")]
    mag: Option<usize>,
    /// Which barometer of the log to read, counted from 0
    #[arg(long, value_name = "N")]
    baro: Option<usize>,
    /// Which topic of a ROS 2 log has the receiver's velocity, or "none"
    #[arg(long, value_name = "TOPIC")]
    velocity: Option<String>,
}

impl Sensors {
    /// The same as options of the readers.
    pub fn options(&self) -> Options {
        let mut options = Options::default();
        (options.imu, options.gps) = (self.imu, self.gps);
        (options.magnetometer, options.baro) = (self.mag, self.baro);
        options.velocity.clone_from(&self.velocity);
        options
    }
}

/// `START:DURATION`, both in seconds.
#[derive(Clone, Copy)]
pub struct OutageWindow(Outage);

impl OutageWindow {
    /// The same as an outage.
    pub fn outage(self) -> Outage {
        self.0
    }
}

impl FromStr for OutageWindow {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("found \"{text}\", expected START:DURATION in seconds");
        let (start, duration) = text.split_once(':').ok_or_else(expected)?;
        let start = finite(start).and_then(Time::from_seconds).ok_or_else(expected)?;
        let duration_s =
            finite(duration).filter(|&duration| duration > 0.0).ok_or_else(expected)?;
        Ok(Self(Outage { start, duration_s }))
    }
}

/// A finite number; `None` of anything else.
pub fn finite(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|value: &f64| value.is_finite())
}

/// Takes numbers from `low` to `high`, of which `unit` is said to be if they have one.
#[cfg(any(feature = "fly", feature = "lab"))]
pub fn within(
    low: f64,
    high: f64,
    unit: &'static str,
) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let found = finite(text).filter(|value| (low..=high).contains(value));
        let space = if unit.is_empty() { "" } else { " " };
        found.ok_or_else(|| format!("found \"{text}\", expected {low} to {high}{space}{unit}"))
    }
}

/// How long a command goes on by itself, s.
#[cfg(any(feature = "fly", feature = "ground"))]
pub fn duration(text: &str) -> Result<f64, String> {
    let found = finite(text).filter(|seconds| (0.1..=1e6).contains(seconds));
    found.ok_or_else(|| format!("found \"{text}\", expected seconds, 0.1 to 1000000"))
}

/// A moment of a flight of up to a day, s from its start; `None` of anything else.
#[cfg(feature = "lab")]
pub fn second(text: &str) -> Option<f64> {
    finite(text).filter(|at_s| (0.0..86_400.0).contains(at_s))
}

/// What helps those who fly an autopilot that is designed on the way.
#[cfg(feature = "lab")]
pub const FORCED: &str =
    "an autopilot that `hovernav design --force` makes of it is flown by --autopilot";

/// Refuses a `model` that is not to be flown by. `name` is how it was given, `remedy` what helps all the same.
#[cfg(feature = "lab")]
pub fn refuse_unflyable(
    model: &hovernav_model::StateSpace,
    name: &str,
    remedy: &str,
) -> anyhow::Result<()> {
    match model.unflyable() {
        Some(why) => anyhow::bail!("{name}: {why}; {remedy}"),
        None => Ok(()),
    }
}

/// What to warn of where the `model` that the autopilot is designed for is not that of the simulated helicopter.
#[cfg(feature = "lab")]
pub fn designed_for_another(model: &hovernav_model::StateSpace) -> Option<String> {
    let name = model.name();
    (name != "raptor60-hover").then(|| {
        format!(
            "the autopilot is designed for {name}, what flies is the nonlinear 60-class helicopter"
        )
    })
}

/// The configuration of a flight computer; an error names the file.
#[cfg(any(feature = "fly", feature = "ground"))]
pub fn read_fly_config(path: &Path) -> anyhow::Result<hovernav_log::FlyConfig> {
    use hovernav_log::{FlyConfig, FlyConfigError};
    FlyConfig::read(path).map_err(|error| match error {
        FlyConfigError::Value { .. } => {
            anyhow::Error::new(error).context(path.display().to_string())
        }
        // These name it.
        other => other.into(),
    })
}
