//! A simulated GPS receiver.

use std::ops::Range;

use hovernav::glam::DVec3;

use hovernav::earth::Geodetic;
use hovernav::frames::{Body, Ned, Vector};
use hovernav::gps::Fix;
use hovernav::time::Time;

use super::axes::HorizontalVertical;
use super::check::{Checked, ConfigError, finite, finite_vector, frequency, positive, size};
use super::noise::{GaussMarkov, Noise, Stream};

/// Settings of the GPS receiver. The default is the thesis's Trimble SK II: 1 Hz, velocity accurate to 0.2 m/s
/// horizontally and 0.5 m/s vertically.
#[derive(Clone, Debug, PartialEq)]
pub struct GpsConfig {
    /// Fixes per second.
    pub rate_hz: f64,
    /// Position of the antenna relative to the centre of gravity, m.
    pub lever_arm_m: Vector<Body>,
    /// Delay from the time of validity of a fix to its arrival, s.
    pub latency_s: f64,
    /// Latency that is subtracted from the time of arrival to give [`Fix::time`](hovernav::gps::Fix), s. If it differs
    /// from the true latency, the time of every fix is wrong by the difference. A fix arrives at its `time` plus this
    /// latency.
    pub assumed_latency_s: f64,
    /// Standard deviation of the white noise of the position, m.
    pub position_noise_m: HorizontalVertical,
    /// Standard deviation of the slow error (Gauss-Markov) of the position, m.
    pub position_wander_m: HorizontalVertical,
    /// Correlation time of the slow error of the position, s.
    pub position_wander_time_s: f64,
    /// Standard deviation of the white noise of the velocity, m/s.
    pub velocity_noise_mps: HorizontalVertical,
    /// Standard deviation of the slow error (Gauss-Markov) of the velocity, m/s.
    pub velocity_wander_mps: HorizontalVertical,
    /// Correlation time of the slow error of the velocity, s.
    pub velocity_wander_time_s: f64,
    /// Whether the receiver reports one velocity accuracy for all axes instead of one for each, as u-blox receivers do.
    /// The reported accuracy is the root mean square over the axes.
    pub states_one_velocity_sigma: bool,
    /// Resolution of latitude and longitude, °; 0 for unlimited.
    pub angle_resolution_deg: f64,
    /// Resolution of the height, m, and of the velocity, m/s; 0 for unlimited.
    pub resolution_m: f64,
    /// Periods without fixes, s from the start.
    pub outages_s: Vec<Range<f64>>,
    /// Periods in which the receiver repeats the last fix with the current time, s from the start.
    pub frozen_s: Vec<Range<f64>>,
}

impl Default for GpsConfig {
    fn default() -> Self {
        Self {
            rate_hz: 1.0,
            lever_arm_m: Vector::new(-0.35, 0.0, 0.2),
            latency_s: 0.0,
            assumed_latency_s: 0.0,
            position_noise_m: HorizontalVertical::new(0.3, 0.6),
            position_wander_m: HorizontalVertical::new(1.6, 3.0),
            position_wander_time_s: 60.0,
            velocity_noise_mps: HorizontalVertical::new(0.16, 0.4),
            velocity_wander_mps: HorizontalVertical::new(0.12, 0.3),
            velocity_wander_time_s: 5.0,
            states_one_velocity_sigma: false,
            angle_resolution_deg: 1e-9,
            resolution_m: 1e-3,
            outages_s: Vec::new(),
            frozen_s: Vec::new(),
        }
    }
}

impl GpsConfig {
    /// A receiver without errors, with its antenna at the centre of gravity.
    #[must_use]
    pub fn ideal(rate_hz: f64) -> Self {
        Self {
            rate_hz,
            lever_arm_m: Vector::ZERO,
            latency_s: 0.0,
            assumed_latency_s: 0.0,
            position_noise_m: HorizontalVertical::default(),
            position_wander_m: HorizontalVertical::default(),
            position_wander_time_s: 1.0,
            velocity_noise_mps: HorizontalVertical::default(),
            velocity_wander_mps: HorizontalVertical::default(),
            velocity_wander_time_s: 1.0,
            states_one_velocity_sigma: false,
            angle_resolution_deg: 0.0,
            resolution_m: 0.0,
            outages_s: Vec::new(),
            frozen_s: Vec::new(),
        }
    }

    fn check(&self) -> Checked {
        const SENSOR: &str = "GPS";
        frequency(SENSOR, "rate", self.rate_hz)?;
        finite_vector(SENSOR, "lever arm", self.lever_arm_m)?;
        finite(SENSOR, "latency", self.latency_s)?;
        finite(SENSOR, "assumed latency", self.assumed_latency_s)?;
        positive(SENSOR, "correlation time of the position", self.position_wander_time_s)?;
        positive(SENSOR, "correlation time of the velocity", self.velocity_wander_time_s)?;
        size(SENSOR, "angle resolution", self.angle_resolution_deg)?;
        size(SENSOR, "resolution", self.resolution_m)?;
        for (what, spread) in [
            ("position noise", self.position_noise_m),
            ("position wander", self.position_wander_m),
            ("velocity noise", self.velocity_noise_mps),
            ("velocity wander", self.velocity_wander_mps),
        ] {
            size(SENSOR, what, spread.horizontal)?;
            size(SENSOR, what, spread.vertical)?;
        }
        Ok(())
    }
}

/// A running receiver: it receives the antenna's motion at its own rate and returns fixes.
#[derive(Clone, Debug)]
pub struct SimulatedGps {
    config: GpsConfig,
    position: Channel,
    velocity: Channel,
    last: Option<Fix>,
}

impl SimulatedGps {
    /// A receiver switched on, with its errors drawn from `seed`.
    ///
    /// # Errors
    /// [`ConfigError`] with the invalid value of `config`.
    pub fn new(config: &GpsConfig, seed: u64) -> Result<Self, ConfigError> {
        config.check()?;
        let period_s = 1.0 / config.rate_hz;
        let mut velocity = Channel::new(
            [config.velocity_noise_mps, config.velocity_wander_mps],
            config.velocity_wander_time_s,
            period_s,
            Noise::new(seed, Stream::GpsVelocity),
        );
        if config.states_one_velocity_sigma {
            velocity.sigma = DVec3::splat(velocity.sigma.length() / f64::sqrt(3.0));
        }
        Ok(Self {
            position: Channel::new(
                [config.position_noise_m, config.position_wander_m],
                config.position_wander_time_s,
                period_s,
                Noise::new(seed, Stream::GpsPosition),
            ),
            velocity,
            config: config.clone(),
            last: None,
        })
    }

    /// The fix of the antenna's true position and velocity at `time`; `None` during an outage.
    pub fn measure(
        &mut self,
        time: Time,
        position: &Geodetic,
        velocity_mps: Vector<Ned>,
    ) -> Option<Fix> {
        let position_error_m = self.position.next();
        let velocity_error_mps = self.velocity.next();
        let seconds = time.seconds();
        if self.config.outages_s.iter().any(|outage| outage.contains(&seconds)) {
            return None;
        }
        if self.config.frozen_s.iter().any(|frozen| frozen.contains(&seconds))
            && let Some(last) = self.last
        {
            let delay_s = self.config.latency_s - self.config.assumed_latency_s;
            return Some(Fix { time: time + delay_s, ..last });
        }
        let angle_step_rad = self.config.angle_resolution_deg.to_radians();
        let measured = position.displaced(Vector::claim(position_error_m));
        let velocity = velocity_mps.components() + velocity_error_mps;
        let [north, east, down] =
            velocity.to_array().map(|v| to_step_of(self.config.resolution_m, v));
        let fix = Fix {
            time: time + (self.config.latency_s - self.config.assumed_latency_s),
            position: Geodetic {
                latitude_rad: to_step_of(angle_step_rad, measured.latitude_rad),
                longitude_rad: to_step_of(angle_step_rad, measured.longitude_rad),
                height_m: to_step_of(self.config.resolution_m, measured.height_m),
            },
            two_dimensional: false,
            position_sigma_m: Some(Vector::claim(self.position.sigma)),
            horizontal_velocity_mps: Some([north, east]),
            down_velocity_mps: Some(down),
            velocity_sigma_mps: Some(Vector::claim(self.velocity.sigma)),
            satellites: Some(8),
        };
        self.last = Some(fix);
        Some(fix)
    }
}

/// Error of position or velocity, north, east and down.
#[derive(Clone, Debug)]
struct Channel {
    noise: Noise,
    white: DVec3,
    wander: GaussMarkov,
    sigma: DVec3,
}

impl Channel {
    fn new(
        spreads: [HorizontalVertical; 2],
        wander_time_s: f64,
        period_s: f64,
        mut noise: Noise,
    ) -> Self {
        let [white, slow] = spreads.map(|s| DVec3::new(s.horizontal, s.horizontal, s.vertical));
        let wander = GaussMarkov::new(slow, wander_time_s, period_s, &mut noise);
        let sigma = (white * white + slow * slow).map(f64::sqrt);
        Self { noise, white, wander, sigma }
    }

    fn next(&mut self) -> DVec3 {
        self.wander.next(&mut self.noise) + self.white * self.noise.normal3()
    }
}

fn to_step_of(resolution: f64, value: f64) -> f64 {
    if resolution == 0.0 { value } else { (value / resolution).round() * resolution }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_receiver_that_states_one_number_errs_as_one_that_states_three() {
        let place = Geodetic::from_degrees(1.35, 103.82, 30.0).unwrap();
        let fix = |states_one_velocity_sigma| {
            let config = GpsConfig { states_one_velocity_sigma, ..GpsConfig::default() };
            let mut gps = SimulatedGps::new(&config, 1).unwrap();
            gps.measure(Time::ZERO, &place, Vector::ZERO).unwrap()
        };
        let (three, one) = (fix(false), fix(true));
        assert_eq!(three.horizontal_velocity_mps, one.horizontal_velocity_mps);
        let sigma = |fix: Fix| fix.velocity_sigma_mps.unwrap();
        assert_abs_diff_eq!(sigma(three).norm(), sigma(one).norm(), epsilon = 1e-12);
        assert_eq!(sigma(one).x(), sigma(one).z());
    }
}
