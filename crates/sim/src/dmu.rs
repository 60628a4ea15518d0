//! A simulated inertial unit.

use hovernav::glam::DVec3;

use hovernav::earth::Geodetic;
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector, wrap_angle};
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;
use hovernav_dataset::magnetic_field::MagneticField;

use super::check::{Checked, ConfigError, finite, finite_vector, frequency, positive, size};
use super::noise::{GaussMarkov, Noise, Stream};
use super::triad::{AccelerometerConfig, GyroConfig, Triad};
use super::vibration::{RunningSource, VibrationSource};

/// The quantities that the inertial unit outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DmuOutput {
    /// Instantaneous rates and specific forces.
    Rates,
    /// Integrals since the previous sample.
    Increments,
}

/// Settings of the inertial unit. The default is that of the thesis: a Crossbow DMU-HDX-AHRS polled at 33 Hz, with the
/// vibration of a 60-class helicopter.
///
/// # Source
/// Resolution and ranges: Crossbow document 7430-0004-01, AHRS400 series. Noise, turn-on biases, lever arm and
/// amplitude of the vibration: from the `heli-hover` data set. Bandwidths, drifting biases and scale factors: typical
/// of this class.
#[derive(Clone, Debug, PartialEq)]
pub struct DmuConfig {
    /// Samples per second.
    pub rate_hz: f64,
    /// Position of the inertial unit relative to the centre of gravity, m.
    pub lever_arm_m: Vector<Body>,
    /// Rates or increments.
    pub output: DmuOutput,
    /// The gyros.
    pub gyro: GyroConfig,
    /// The accelerometers.
    pub accelerometer: AccelerometerConfig,
    /// Sources of vibration.
    pub vibration: Vec<VibrationSource>,
    /// Attitude computed by the inertial unit itself, if any.
    pub attitude: Option<AttitudeConfig>,
    /// Magnetometer of the inertial unit, if any.
    pub magnetometer: Option<MagnetometerConfig>,
}

/// Errors of the attitude computed by the inertial unit itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttitudeConfig {
    /// Standard deviation of the slow error (Gauss-Markov) of roll, pitch and yaw, °.
    pub wander_sigma_deg: [f64; 3],
    /// Correlation time of the slow error, s.
    pub wander_time_s: f64,
    /// Standard deviation of the white noise, °.
    pub noise_sigma_deg: f64,
    /// Resolution of the output, °; 0 for unlimited.
    pub resolution_deg: f64,
    /// East declination of the north reference of yaw, °; 0 for true north.
    pub declination_deg: f64,
}

/// The magnetic field and the errors of the magnetometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MagnetometerConfig {
    /// The Earth's field at the site, gauss.
    pub field_gauss: Vector<Ned>,
    /// Standard deviation of the vehicle's own magnetic field (hard iron), drawn at turn-on, gauss.
    pub hard_iron_sigma_gauss: f64,
    /// Standard deviation of the white noise, gauss.
    pub noise_sigma_gauss: f64,
    /// Resolution of the output, gauss; 0 for unlimited.
    pub resolution_gauss: f64,
}

impl Default for DmuConfig {
    fn default() -> Self {
        Self {
            rate_hz: 33.0,
            lever_arm_m: Vector::new(0.03, -0.02, 0.28),
            output: DmuOutput::Rates,
            gyro: GyroConfig::default(),
            accelerometer: AccelerometerConfig::default(),
            vibration: vec![VibrationSource::helicopter()],
            attitude: Some(AttitudeConfig::default()),
            magnetometer: Some(MagnetometerConfig::default()),
        }
    }
}

impl DmuConfig {
    /// An inertial unit without errors at the centre of gravity, without attitude and magnetometer.
    #[must_use]
    pub fn ideal(rate_hz: f64, output: DmuOutput) -> Self {
        Self {
            rate_hz,
            lever_arm_m: Vector::ZERO,
            output,
            gyro: GyroConfig::IDEAL,
            accelerometer: AccelerometerConfig::IDEAL,
            vibration: Vec::new(),
            attitude: None,
            magnetometer: None,
        }
    }

    fn check(&self) -> Checked {
        frequency("DMU", "rate", self.rate_hz)?;
        finite_vector("DMU", "lever arm", self.lever_arm_m)?;
        self.gyro.errors().check("gyro")?;
        self.accelerometer.errors().check("accelerometer")?;
        self.vibration.iter().try_for_each(VibrationSource::check)?;
        self.attitude.iter().try_for_each(AttitudeConfig::check)?;
        self.magnetometer.iter().try_for_each(MagnetometerConfig::check)
    }
}

impl Default for AttitudeConfig {
    fn default() -> Self {
        Self {
            wander_sigma_deg: [1.0, 1.0, 2.0],
            wander_time_s: 40.0,
            noise_sigma_deg: 0.15,
            resolution_deg: 180.0 / 32_768.0,
            declination_deg: 0.0,
        }
    }
}

impl AttitudeConfig {
    fn check(&self) -> Checked {
        const SENSOR: &str = "attitude";
        self.wander_sigma_deg.iter().try_for_each(|sigma| size(SENSOR, "wander", *sigma))?;
        positive(SENSOR, "correlation time", self.wander_time_s)?;
        size(SENSOR, "noise", self.noise_sigma_deg)?;
        size(SENSOR, "resolution", self.resolution_deg)?;
        finite(SENSOR, "declination", self.declination_deg)
    }
}

impl Default for MagnetometerConfig {
    /// The field of Singapore in 2025, by the World Magnetic Model.
    fn default() -> Self {
        Self {
            field_gauss: Vector::new(0.410, 0.001, -0.094),
            hard_iron_sigma_gauss: 0.01,
            noise_sigma_gauss: 0.003,
            resolution_gauss: 1.25 * 1.5 / 32_768.0,
        }
    }
}

impl MagnetometerConfig {
    /// The default settings, with the Earth's field at the position `place` in 2025 according to the World Magnetic
    /// Model, to 0.001 gauss.
    #[must_use]
    pub fn at(place: &Geodetic) -> Self {
        let default = Self::default();
        // The model ends 1 km below the ellipsoid. Every position below the ellipsoid uses the field at the ellipsoid.
        let place = Geodetic { height_m: place.height_m.max(0.0), ..*place };
        match MagneticField::at(&place, 2025.0) {
            Ok(MagneticField { field_gauss }) => {
                let rounded = field_gauss.to_array().map(|part| (1000.0 * part).round() / 1000.0);
                Self { field_gauss: rounded.into(), ..default }
            }
            Err(_) => default,
        }
    }

    /// Declination, ° east of true north.
    #[must_use]
    pub fn declination_deg(&self) -> f64 {
        let [north, east, _] = self.field_gauss.to_array();
        east.atan2(north).to_degrees()
    }

    fn check(&self) -> Checked {
        const SENSOR: &str = "magnetometer";
        finite_vector(SENSOR, "field", self.field_gauss)?;
        size(SENSOR, "hard iron", self.hard_iron_sigma_gauss)?;
        size(SENSOR, "noise", self.noise_sigma_gauss)?;
        size(SENSOR, "resolution", self.resolution_gauss)
    }
}

/// Error-free measurements of an inertial unit at its mounting position.
#[derive(Clone, Copy, Debug)]
pub struct ImuTruth {
    /// Angular rate with respect to inertial space, rad/s: at the time of the sample, or for [`DmuOutput::Increments`]
    /// the mean since the previous sample.
    pub angular_rate_radps: Vector<Body>,
    /// Specific force, m/s²: at the time of the sample, or the mean as above.
    pub specific_force_mps2: Vector<Body>,
    /// Attitude at the time of the sample.
    pub body_to_ned: Rotation<Body, Ned>,
}

/// A running inertial unit: it receives the true motion at its own rate and returns its samples.
///
/// The errors are applied in the order low-pass, scale factor, biases and white noise, range, resolution. The
/// first-order low-pass is exact for motion that is linear between samples, and for vibration at any frequency.
#[derive(Clone, Debug)]
pub struct SimulatedDmu {
    output: DmuOutput,
    period_s: f64,
    last: Option<Time>,
    gyros: Triad,
    accelerometers: Triad,
    lags_s: [f64; 2],
    vibration: Vec<RunningSource>,
    vibration_noise: Noise,
    attitude: Option<RunningAttitude>,
    magnetometer: Option<RunningMagnetometer>,
}

impl SimulatedDmu {
    /// An inertial unit switched on, with its biases drawn from `seed`.
    ///
    /// # Errors
    /// [`ConfigError`] with the invalid value of `config`.
    pub fn new(config: &DmuConfig, seed: u64) -> Result<Self, ConfigError> {
        config.check()?;
        let period_s = 1.0 / config.rate_hz;
        let (gyro, accelerometer) = (config.gyro.errors(), config.accelerometer.errors());
        let mut noise = Noise::new(seed, Stream::Vibration);
        let running = |source| RunningSource::new(source, period_s, &mut noise);
        Ok(Self {
            output: config.output,
            period_s,
            last: None,
            gyros: Triad::new(&gyro, period_s, Noise::new(seed, Stream::Gyro)),
            accelerometers: Triad::new(
                &accelerometer,
                period_s,
                Noise::new(seed, Stream::Accelerometer),
            ),
            lags_s: [gyro.lag_s(), accelerometer.lag_s()],
            vibration: config.vibration.iter().map(running).collect(),
            vibration_noise: noise,
            attitude: config.attitude.map(|config| RunningAttitude::new(config, period_s, seed)),
            magnetometer: config.magnetometer.map(|config| RunningMagnetometer::new(config, seed)),
        })
    }

    /// The sample at `time`. Samples are one period apart. Increments are scaled by the time since the previous sample;
    /// all other errors assume the nominal period.
    pub fn measure(&mut self, time: Time, truth: &ImuTruth) -> ImuSample {
        let increments = self.output == DmuOutput::Increments;
        let step_s = self.last.map_or(self.period_s, |last| time - last);
        self.last = Some(time);
        let mut shaking = [DVec3::ZERO; 2];
        for source in &mut self.vibration {
            let more = source.next(step_s, increments, self.lags_s, &mut self.vibration_noise);
            shaking = [shaking[0] + more[0], shaking[1] + more[1]];
        }
        let rate = truth.angular_rate_radps.components();
        let force = truth.specific_force_mps2.components();
        let rate = Vector::claim(self.gyros.measure(rate, shaking[0], increments));
        let force = Vector::claim(self.accelerometers.measure(force, shaking[1], increments));
        let motion = match self.output {
            DmuOutput::Rates => {
                Motion::Rates { angular_rate_radps: rate, specific_force_mps2: force }
            }
            DmuOutput::Increments => {
                Motion::Increments { angle_rad: rate * step_s, velocity_mps: force * step_s }
            }
        };
        ImuSample {
            attitude: self.attitude.as_mut().map(|attitude| attitude.measure(truth.body_to_ned)),
            magnetic_field_gauss: self.magnetometer.as_mut().map(|m| m.measure(truth.body_to_ned)),
            ..ImuSample::new(time, motion)
        }
    }
}

/// The running attitude computation of the inertial unit.
#[derive(Clone, Debug)]
struct RunningAttitude {
    config: AttitudeConfig,
    noise: Noise,
    wander: GaussMarkov,
}

impl RunningAttitude {
    fn new(config: AttitudeConfig, period_s: f64, seed: u64) -> Self {
        let mut noise = Noise::new(seed, Stream::Attitude);
        let sigma = DVec3::from_array(config.wander_sigma_deg);
        let wander = GaussMarkov::new(sigma, config.wander_time_s, period_s, &mut noise);
        Self { config, noise, wander }
    }

    fn measure(&mut self, body_to_ned: Rotation<Body, Ned>) -> EulerAngles {
        let truth = DVec3::from_array(body_to_ned.euler().to_degrees());
        let declination = DVec3::Z * self.config.declination_deg;
        let error =
            self.wander.next(&mut self.noise) + self.config.noise_sigma_deg * self.noise.normal3();
        let shown = to_steps_of(self.config.resolution_deg, truth - declination + error);
        EulerAngles {
            roll_rad: wrap_angle(shown.x.to_radians()),
            pitch_rad: shown.y.clamp(-90.0, 90.0).to_radians(),
            yaw_rad: wrap_angle(shown.z.to_radians()),
        }
    }
}

/// The running magnetometer.
#[derive(Clone, Debug)]
struct RunningMagnetometer {
    config: MagnetometerConfig,
    noise: Noise,
    hard_iron_gauss: DVec3,
}

impl RunningMagnetometer {
    fn new(config: MagnetometerConfig, seed: u64) -> Self {
        let mut noise = Noise::new(seed, Stream::Magnetometer);
        let hard_iron_gauss = config.hard_iron_sigma_gauss * noise.normal3();
        Self { config, noise, hard_iron_gauss }
    }

    fn measure(&mut self, body_to_ned: Rotation<Body, Ned>) -> Vector<Body> {
        let field = (body_to_ned.inverse() * self.config.field_gauss).components();
        let noise = self.config.noise_sigma_gauss * self.noise.normal3();
        let shown = field + self.hard_iron_gauss + noise;
        Vector::claim(to_steps_of(self.config.resolution_gauss, shown))
    }
}

fn to_steps_of(resolution: f64, value: DVec3) -> DVec3 {
    if resolution == 0.0 { value } else { (value / resolution).round() * resolution }
}
