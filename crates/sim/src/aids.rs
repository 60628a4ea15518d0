//! A simulated rangefinder that looks at the ground, and two simulated GPS antennas.

use hovernav::event::RangeReading;
use hovernav::frames::{Body, Ned, Rotation, Vector, wrap_angle};
use hovernav::glam::DVec3;
use hovernav::gps::AntennaHeading;
use hovernav::time::Time;

use super::check::{Checked, ConfigError, frequency, positive, size};
use super::noise::{GaussMarkov, Noise, Stream};

/// The rangefinder. The default is a small laser one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangefinderConfig {
    /// Samples per second.
    pub rate_hz: f64,
    /// The sensor from the centre of gravity, m.
    pub lever_arm_m: Vector<Body>,
    /// Height of the ground above the ellipsoid where the flight starts, m.
    pub ground_m: f64,
    /// One-sigma by which the ground rises or falls over a metre of way, m.
    pub ground_walk_m: f64,
    /// One-sigma of the white noise, m.
    pub noise_m: f64,
    /// Share of the distance that adds to it.
    pub noise_share: f64,
    /// Shortest and longest distance that it measures, m.
    pub reach_m: [f64; 2],
}

impl RangefinderConfig {
    /// A laser over ground of this height above the ellipsoid, m.
    #[must_use]
    pub const fn over(ground_m: f64) -> Self {
        Self {
            rate_hz: 20.0,
            lever_arm_m: Vector::new(0.1, 0.0, 0.2),
            ground_m,
            ground_walk_m: 0.05,
            noise_m: 0.03,
            noise_share: 0.005,
            reach_m: [0.1, 50.0],
        }
    }

    fn check(&self) -> Checked {
        const SENSOR: &str = "rangefinder";
        frequency(SENSOR, "rate", self.rate_hz)?;
        size(SENSOR, "noise", self.noise_m)?;
        size(SENSOR, "share of the distance in the noise", self.noise_share)?;
        size(SENSOR, "walk of the ground", self.ground_walk_m)?;
        size(SENSOR, "shortest distance", self.reach_m[0])?;
        positive(SENSOR, "longest distance", self.reach_m[1])
    }
}

/// A rangefinder at work.
#[derive(Clone, Debug)]
pub struct SimulatedRangefinder {
    config: RangefinderConfig,
    noise: Noise,
    ground_m: f64,
    last: Option<(Time, Vector<Ned>)>,
}

impl SimulatedRangefinder {
    /// A rangefinder switched on, its errors and the ground drawn from `seed`.
    ///
    /// # Errors
    /// [`ConfigError`] names the value of `config` that no rangefinder can have.
    pub fn new(config: &RangefinderConfig, seed: u64) -> Result<Self, ConfigError> {
        config.check()?;
        let noise = Noise::new(seed, Stream::Range);
        Ok(Self { config: *config, noise, ground_m: config.ground_m, last: None })
    }

    /// What it says at `time` of a vehicle whose centre of gravity is `height_m` above the ellipsoid and moves at
    /// `velocity_mps`; `None` where it is out of reach or looks away from the ground.
    pub fn measure(
        &mut self,
        time: Time,
        height_m: f64,
        velocity_mps: Vector<Ned>,
        body_to_ned: Rotation<Body, Ned>,
    ) -> Option<RangeReading> {
        if let Some((last, before)) = self.last {
            let way = (before + velocity_mps) * (0.5 * (time - last));
            let way_m = way.x().hypot(way.y());
            self.ground_m += self.config.ground_walk_m * way_m.sqrt() * self.noise.normal();
        }
        self.last = Some((time, velocity_mps));
        let noise = self.noise.normal();
        let down = (body_to_ned * Vector::<Body>::new(0.0, 0.0, 1.0)).z();
        let sensor_m = height_m - (body_to_ned * self.config.lever_arm_m).z();
        let range_m = (sensor_m - self.ground_m) / down.max(0.1);
        let range_m =
            range_m + noise * self.config.noise_m.hypot(self.config.noise_share * range_m);
        let [least_m, most_m] = self.config.reach_m;
        let seen = down > 0.5 && (least_m..=most_m).contains(&range_m);
        seen.then(|| RangeReading::new(time, range_m))
    }
}

/// Two antennas. The default are a metre apart on an RTK receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AntennasConfig {
    /// Headings per second.
    pub rate_hz: f64,
    /// The second antenna from the first, body axes, m.
    pub baseline_m: Vector<Body>,
    /// One-sigma of the heading, rad, which the receiver also tells.
    pub sigma_rad: f64,
    /// Share of it that wanders, by reflections.
    pub wander_share: f64,
    /// Correlation time of what wanders, s.
    pub wander_time_s: f64,
}

impl Default for AntennasConfig {
    fn default() -> Self {
        Self {
            rate_hz: 5.0,
            baseline_m: Vector::new(0.0, 1.0, 0.0),
            sigma_rad: 0.008,
            wander_share: 0.7,
            wander_time_s: 10.0,
        }
    }
}

/// Two antennas at work.
#[derive(Clone, Debug)]
pub struct SimulatedAntennas {
    config: AntennasConfig,
    noise: Noise,
    wander: GaussMarkov,
}

impl SimulatedAntennas {
    /// Antennas switched on, their errors drawn from `seed`.
    ///
    /// # Errors
    /// [`ConfigError`] names the value of `config` that no receiver can have.
    pub fn new(config: &AntennasConfig, seed: u64) -> Result<Self, ConfigError> {
        const SENSOR: &str = "second antenna";
        frequency(SENSOR, "rate", config.rate_hz)?;
        positive(SENSOR, "heading error", config.sigma_rad)?;
        size(SENSOR, "share that wanders", config.wander_share)?;
        positive(SENSOR, "time of the wander", config.wander_time_s)?;
        let mut noise = Noise::new(seed, Stream::Antennas);
        let sigma = DVec3::X * (config.wander_share.min(1.0) * config.sigma_rad);
        let period_s = 1.0 / config.rate_hz;
        let wander = GaussMarkov::new(sigma, config.wander_time_s, period_s, &mut noise);
        Ok(Self { config: *config, noise, wander })
    }

    /// What they say at `time`.
    pub fn measure(&mut self, time: Time, body_to_ned: Rotation<Body, Ned>) -> AntennaHeading {
        let AntennasConfig { baseline_m, sigma_rad, wander_share, .. } = self.config;
        let share = wander_share.min(1.0);
        let white_rad = sigma_rad * (1.0 - share * share).sqrt() * self.noise.normal();
        let off_rad = self.wander.next(&mut self.noise).x + white_rad;
        let heading_rad = wrap_angle((body_to_ned * baseline_m).azimuth_rad() + off_rad);
        let heading = AntennaHeading::new(time, heading_rad, Some(sigma_rad));
        AntennaHeading { length_m: Some(baseline_m.norm()), ..heading }
    }
}
