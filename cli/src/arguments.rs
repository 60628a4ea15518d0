//! Arguments that are common to several subcommands.

use std::str::FromStr;

use hovernav::time::Time;
use hovernav_dataset::{LocalAxes, Outage};
use hovernav_formats::Options;

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

/// Selects one sensor of a kind, in a log with several.
#[derive(clap::Args)]
pub struct Sensors {
    /// Index of the IMU to read, counted from 0
    #[arg(long, value_name = "N")]
    imu: Option<usize>,
    /// Index of the GPS receiver to read, counted from 0
    #[arg(long, value_name = "N")]
    gps: Option<usize>,
    /// Index of the magnetometer to read, counted from 0
    #[arg(long, value_name = "N")]
    mag: Option<usize>,
    /// Index of the barometer to read, counted from 0
    #[arg(long, value_name = "N")]
    baro: Option<usize>,
    /// Topic with the receiver's velocity, in a ROS 2 log, or "none"
    #[arg(long, value_name = "TOPIC")]
    velocity: Option<String>,
}

impl Sensors {
    /// The selection, as options of the log readers.
    pub fn options(&self) -> Options {
        let mut options = Options::default();
        (options.imu, options.gps) = (self.imu, self.gps);
        (options.magnetometer, options.baro) = (self.mag, self.baro);
        options.velocity.clone_from(&self.velocity);
        options
    }
}

/// Time window in the form `START:DURATION`, both in seconds.
#[derive(Clone, Copy)]
pub struct OutageWindow(Outage);

impl OutageWindow {
    /// The window as an outage.
    pub fn outage(self) -> Outage {
        self.0
    }
}

impl FromStr for OutageWindow {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("found \"{text}\", expected START:DURATION in seconds");
        let (start, duration) = text.split_once(':').ok_or_else(expected)?;
        let start = finite(start).and_then(Time::try_from_seconds).ok_or_else(expected)?;
        let duration_s =
            finite(duration).filter(|&duration| duration > 0.0).ok_or_else(expected)?;
        Ok(Self(Outage { start, duration_s }))
    }
}

/// A finite number; `None` for any other text.
pub fn finite(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|value: &f64| value.is_finite())
}

/// Parses numbers from `low` to `high`. The error message names the `unit`, unless it is empty.
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

/// The duration, s, after which a command ends by itself.
#[cfg(any(feature = "fly", feature = "ground"))]
pub fn duration(text: &str) -> Result<f64, String> {
    let found = finite(text).filter(|seconds| (0.1..=1e6).contains(seconds));
    found.ok_or_else(|| format!("found \"{text}\", expected seconds, 0.1 to 1000000"))
}

/// A time of a flight of up to one day, s from its start; `None` for any other text.
#[cfg(feature = "lab")]
pub fn second(text: &str) -> Option<f64> {
    finite(text).filter(|at_s| (0.0..86_400.0).contains(at_s))
}

/// Advice to a user whose autopilot is designed during the run.
#[cfg(feature = "lab")]
pub const FORCED: &str =
    "design an autopilot for it with `hovernav design --force` and pass that with --autopilot";

/// Rejects a `model` that must not be flown on. `name` is the name the user gave; `remedy` is a way to proceed.
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

/// Name of the nonlinear helicopter, and of its linear model.
#[cfg(feature = "lab")]
pub const HELICOPTER: &str = "raptor60";

/// The linear model that flies: that of `vehicle`, otherwise the `model` of the autopilot; `None` for the nonlinear
/// 60-class helicopter.
#[cfg(feature = "lab")]
pub fn flown(
    vehicle: Option<&str>,
    model: Option<&str>,
) -> anyhow::Result<Option<hovernav_model::StateSpace>> {
    match vehicle.or(model) {
        None | Some(HELICOPTER) => Ok(None),
        Some(name) => {
            use anyhow::Context as _;
            let flown = hovernav_model::shipped::open(name)?;
            hovernav_model::LinearAirframe::new(&flown).with_context(|| name.to_owned())?;
            Ok(Some(flown))
        }
    }
}

/// The warning for an autopilot that is designed for a `model` other than the `flown` vehicle.
#[cfg(feature = "lab")]
pub fn designed_for_another(
    model: &hovernav_model::StateSpace,
    flown: Option<&hovernav_model::StateSpace>,
) -> Option<String> {
    let name = model.name();
    match flown {
        None => (name != "raptor60-hover").then(|| {
            format!(
                "the autopilot is designed for {name}, but the simulated aircraft is the nonlinear 60-class helicopter"
            )
        }),
        Some(flown) => (flown != model).then(|| {
            format!(
                "the autopilot is designed for {name}, but the simulated vehicle is the linear model {}",
                flown.name()
            )
        }),
    }
}

/// The configuration of a flight computer. An error names the file.
#[cfg(any(feature = "fly", feature = "ground"))]
pub fn read_fly_config(path: &std::path::Path) -> anyhow::Result<hovernav_record::FlyConfig> {
    use hovernav_record::{FlyConfig, FlyConfigError};
    FlyConfig::read(path).map_err(|error| match error {
        FlyConfigError::Value { .. } => {
            anyhow::Error::new(error).context(path.display().to_string())
        }
        // These errors already name the file.
        other => other.into(),
    })
}
