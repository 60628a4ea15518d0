//! The synthetic flight: a slow circle with vibration.

use hovernav::earth::Geodetic;
use hovernav::ekf::EstimatorConfig;
use hovernav::frames::{Body, EulerAngles, Rotation, Vector};
use hovernav::gps::{AntennaHeading, Fix};
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;

use crate::PERIOD_S;

/// Cycles between two fixes.
pub const FIX_EVERY: u64 = 33;
/// Speed of the vehicle, m/s.
const SPEED_MPS: f64 = 3.0;
/// Turn rate of the vehicle, rad/s.
const TURN_RADPS: f64 = 0.2;
/// Gravity, m/s².
const GRAVITY_MPS2: f64 = 9.806;

/// The flight, evaluated cycle by cycle.
pub struct Flight {
    home: Geodetic,
    /// State of the random generator of the vibration.
    noise: u64,
}

impl Flight {
    pub fn new() -> Result<Self, String> {
        let home =
            Geodetic::from_degrees(48.1, 11.6, 520.0).ok_or("the home position is invalid")?;
        Ok(Self { home, noise: 0x9E37_79B9_7F4A_7C15 })
    }

    /// The estimator's settings: the defaults.
    pub fn config() -> EstimatorConfig {
        EstimatorConfig::default()
    }

    pub fn time(cycle: u64) -> Time {
        Time::ZERO + cycle as f64 * PERIOD_S
    }

    /// Vibration from −1 to 1, identical in every run (xorshift, Marsaglia 2003).
    fn shake(&mut self) -> f64 {
        self.noise ^= self.noise << 13;
        self.noise ^= self.noise >> 7;
        self.noise ^= self.noise << 17;
        (self.noise >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub fn angles(cycle: u64) -> EulerAngles {
        let yaw_rad = (TURN_RADPS * cycle as f64 * PERIOD_S) % std::f64::consts::TAU;
        EulerAngles { yaw_rad: hovernav::frames::wrap_angle(yaw_rad), ..EulerAngles::default() }
    }

    pub fn field_gauss(cycle: u64) -> Vector<Body> {
        let angles = Self::angles(cycle);
        Rotation::from_euler(angles).inverse() * Vector::new(0.2, 0.0, 0.43)
    }

    pub fn sample(&mut self, cycle: u64) -> ImuSample {
        let [a, b, c, d, e, f] = std::array::from_fn(|_| self.shake());
        let outward_mps2 = SPEED_MPS * TURN_RADPS;
        let motion = Motion::Rates {
            angular_rate_radps: Vector::new(0.02 * a, 0.02 * b, TURN_RADPS + 0.02 * c),
            specific_force_mps2: Vector::new(0.5 * d, outward_mps2 + 0.5 * e, -GRAVITY_MPS2 + f),
        };
        ImuSample {
            attitude: Some(Self::angles(cycle)),
            magnetic_field_gauss: Some(Self::field_gauss(cycle)),
            ..ImuSample::new(Self::time(cycle), motion)
        }
    }

    pub fn height_m(&mut self) -> f64 {
        300.0 + 0.3 * self.shake()
    }

    /// Distance to the ground, m.
    pub fn range_m(&mut self) -> f64 {
        7.0 + 0.02 * self.shake()
    }

    /// Heading from two antennas.
    pub fn heading(cycle: u64) -> AntennaHeading {
        AntennaHeading::new(Self::time(cycle), Self::angles(cycle).yaw_rad, None)
    }

    /// The fix at a cycle.
    pub fn fix(&mut self, cycle: u64) -> Fix {
        let angle = TURN_RADPS * cycle as f64 * PERIOD_S;
        let radius_m = SPEED_MPS / TURN_RADPS;
        let (sin, cos) = angle.sin_cos();
        let [n, e, d, vn, ve, vd] = std::array::from_fn(|_| self.shake());
        let off_m =
            Vector::new(radius_m * sin + 0.5 * n, radius_m * (1.0 - cos) + 0.5 * e, 0.8 * d);
        Fix {
            position_sigma_m: Some(Vector::new(0.8, 0.8, 1.5)),
            horizontal_velocity_mps: Some([
                SPEED_MPS * cos + 0.05 * vn,
                SPEED_MPS * sin + 0.05 * ve,
            ]),
            down_velocity_mps: Some(0.1 * vd),
            velocity_sigma_mps: Some(Vector::new(0.1, 0.1, 0.2)),
            ..Fix::at(Self::time(cycle), self.home.displaced(off_m))
        }
    }
}
