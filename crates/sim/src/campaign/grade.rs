//! Quality grades of sensors.

use crate::axes::HorizontalVertical;
use crate::dmu::DmuConfig;
use crate::gps::GpsConfig;

/// Quality of the sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorGrade {
    /// Sensors of Paw (2005): an AHRS of its time and a 1 Hz receiver.
    Thesis,
    /// A current MEMS IMU and a 5 Hz receiver.
    Modern,
    /// Sensors with twice the errors of the first grade.
    Poor,
}

impl SensorGrade {
    /// All grades.
    pub const ALL: [Self; 3] = [Self::Thesis, Self::Modern, Self::Poor];

    /// Name: `thesis`, `modern` or `poor`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Thesis => "thesis",
            Self::Modern => "modern",
            Self::Poor => "poor",
        }
    }

    /// Sensors of this grade. The receiver reports one velocity accuracy for all axes, like the u-blox receiver of the
    /// flight hardware. The estimator performs better with one per axis.
    #[must_use]
    pub fn sensors(self) -> (DmuConfig, GpsConfig) {
        let (errors, rate_hz) = match self {
            Self::Thesis => (1.0, 1.0),
            Self::Modern => (0.4, 5.0),
            Self::Poor => (2.0, 1.0),
        };
        let mut dmu = DmuConfig::default();
        let mut gps =
            GpsConfig { rate_hz, states_one_velocity_sigma: true, ..GpsConfig::default() };
        let gyro = &mut dmu.gyro;
        for error in [
            &mut gyro.turn_on_bias_sigma_degps,
            &mut gyro.wandering_bias_sigma_degps,
            &mut gyro.angle_random_walk_deg_per_sqrt_h,
            &mut gyro.scale_factor_sigma,
        ] {
            *error *= errors;
        }
        let accelerometer = &mut dmu.accelerometer;
        for error in [
            &mut accelerometer.turn_on_bias_sigma_mps2,
            &mut accelerometer.wandering_bias_sigma_mps2,
            &mut accelerometer.velocity_random_walk_mps_per_sqrt_h,
            &mut accelerometer.scale_factor_sigma,
        ] {
            *error *= errors;
        }
        if let Some(magnetometer) = &mut dmu.magnetometer {
            magnetometer.hard_iron_sigma_gauss *= errors;
            magnetometer.noise_sigma_gauss *= errors;
        }
        for HorizontalVertical { horizontal, vertical } in [
            &mut gps.position_noise_m,
            &mut gps.position_wander_m,
            &mut gps.velocity_noise_mps,
            &mut gps.velocity_wander_mps,
        ] {
            *horizontal *= errors;
            *vertical *= errors;
        }
        (dmu, gps)
    }
}
