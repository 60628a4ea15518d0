//! A simulated rangefinder aimed at the ground, and two simulated GPS antennas.

use hovernav::event::RangeReading;
use hovernav::frames::{Body, Ned, Rotation, Vector, wrap_angle};
use hovernav::glam::DVec3;
use hovernav::gps::AntennaHeading;
use hovernav::time::Time;

use super::check::{Checked, ConfigError, frequency, positive, size};
use super::noise::{GaussMarkov, Noise, Stream};

/// Settings of the rangefinder. The default is a small laser rangefinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangefinderConfig {
    /// Samples per second.
    pub rate_hz: f64,
    /// Position of the sensor relative to the centre of gravity, m.
    pub lever_arm_m: Vector<Body>,
    /// Height of the ground above the ellipsoid at the start of the flight, m.
    pub ground_m: f64,
    /// Standard deviation of the change of the ground height per metre of horizontal distance, m.
    pub ground_walk_m: f64,
    /// Standard deviation of the white noise, m.
    pub noise_m: f64,
    /// Additional noise as a fraction of the distance.
    pub noise_share: f64,
    /// Shortest and longest measurable distance, m.
    pub reach_m: [f64; 2],
}

impl RangefinderConfig {
    /// A laser over ground at the height `ground_m` above the ellipsoid, m.
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
        size(SENSOR, "noise relative to the distance", self.noise_share)?;
        size(SENSOR, "change of the ground height", self.ground_walk_m)?;
        size(SENSOR, "shortest distance", self.reach_m[0])?;
        positive(SENSOR, "longest distance", self.reach_m[1])
    }
}

/// A running rangefinder.
#[derive(Clone, Debug)]
pub struct SimulatedRangefinder {
    config: RangefinderConfig,
    noise: Noise,
    ground_m: f64,
    last: Option<(Time, Vector<Ned>)>,
}

impl SimulatedRangefinder {
    /// A rangefinder switched on, with its errors and the ground drawn from `seed`.
    ///
    /// # Errors
    /// [`ConfigError`] with the invalid value of `config`.
    pub fn new(config: &RangefinderConfig, seed: u64) -> Result<Self, ConfigError> {
        config.check()?;
        let noise = Noise::new(seed, Stream::Range);
        Ok(Self { config: *config, noise, ground_m: config.ground_m, last: None })
    }

    /// Measurement at `time` for a vehicle whose centre of gravity is `height_m` above the ellipsoid and moves at
    /// `velocity_mps`. `None` where the ground is out of range or the sensor does not point at it.
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

/// Settings of the two antennas. By default they are a metre apart on an RTK receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AntennasConfig {
    /// Headings per second.
    pub rate_hz: f64,
    /// Position of the second antenna relative to the first, body axes, m.
    pub baseline_m: Vector<Body>,
    /// Standard deviation of the heading, rad, which the receiver also reports.
    pub sigma_rad: f64,
    /// Fraction of `sigma_rad` that is correlated in time, from multipath.
    pub wander_share: f64,
    /// Correlation time of this fraction, s.
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

/// Two running antennas.
#[derive(Clone, Debug)]
pub struct SimulatedAntennas {
    config: AntennasConfig,
    noise: Noise,
    wander: GaussMarkov,
}

impl SimulatedAntennas {
    /// Antennas switched on, with their errors drawn from `seed`.
    ///
    /// # Errors
    /// [`ConfigError`] with the invalid value of `config`.
    pub fn new(config: &AntennasConfig, seed: u64) -> Result<Self, ConfigError> {
        const SENSOR: &str = "second antenna";
        frequency(SENSOR, "rate", config.rate_hz)?;
        positive(SENSOR, "heading error", config.sigma_rad)?;
        size(SENSOR, "correlated part of the error", config.wander_share)?;
        positive(SENSOR, "correlation time", config.wander_time_s)?;
        let mut noise = Noise::new(seed, Stream::Antennas);
        let sigma = DVec3::X * (config.wander_share.min(1.0) * config.sigma_rad);
        let period_s = 1.0 / config.rate_hz;
        let wander = GaussMarkov::new(sigma, config.wander_time_s, period_s, &mut noise);
        Ok(Self { config: *config, noise, wander })
    }

    /// Measurement at `time`.
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
