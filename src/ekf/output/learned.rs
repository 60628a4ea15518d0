//! Learned sensor errors of a filter: the numbers that its equations take as input.
//!
//! The textbook filter in `tests/oracle` reads these numbers and computes everything else itself.

use crate::ekf::filter::Ekf;
use crate::ekf::kernel::layout::Layout;
use crate::frames::Vector;
use crate::imu::Suspicion;
use crate::scalar::Scalar;
use crate::time::Time;

/// Learned and monitored quantities of a filter, as of its last sample or measurement.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Learned {
    /// Variance of the vibration of each gyro, (rad/s)², and of each accelerometer, (m/s²)² (S12).
    pub vibration: [[f64; 3]; 2],
    /// Faults of the last sample (S13, S16).
    pub suspicion: Suspicion,
    /// Factor on the variances of the inertial noise (K18).
    pub excess: f64,
    /// Growth of the variance of each accelerometer bias per second while vibration changes, (m/s²)²/s (K24).
    pub rectification: [f64; 3],
    /// Fraction of the horizontal specific force that counts as motion (K23).
    pub level_share: f64,
    /// Ratio of the observed variance of the GPS errors to the stated or configured one: position, horizontal velocity,
    /// vertical velocity (M7).
    pub gps_size: [f32; 3],
    /// White share of the variance of the positions of fixes without velocity (M21).
    pub position_scatter: f64,
    /// One-sigmas of the slow GPS errors: position horizontal and vertical, m, then velocity horizontal and vertical,
    /// m/s (M5).
    pub gps_wander: Option<[f32; 4]>,
    /// Slow error of the source of heading: one-sigma, rad, and correlation time, s.
    pub heading_wander: [f64; 2],
    /// Offset of the antenna from its declared position, body axes, m; and variance of the horizontal velocity that this
    /// offset leaves unexplained, per (rad/s)² of turn rate, m² (M16).
    pub antenna: ([f64; 3], f32),
    /// Mean square swing of the difference between attitude reference and filter, in tilt and heading, rad² (M8).
    pub attitude_swing: [f64; 2],
    /// Time of the last fused attitude or magnetic heading.
    pub attitude_used: Option<Time>,
    /// Time at which the attitude was lost; `None` after the next attitude measurement or a found heading (K20).
    pub attitude_lost: Option<Time>,
    /// Level of the barometer, m, and the variance of its white error, m² (M18).
    pub baro: (f64, f64),
    /// Height of the ground beneath the rangefinder at its first reading, m (M12).
    pub ground_height_m: Option<f64>,
    /// Time of the last fused two-antenna heading.
    pub antenna_heading_used: Option<Time>,
    /// Mean angular rate over a second of rest that ended with the last sample, rad/s (M11).
    pub resting_rate_radps: Option<[f64; 3]>,
    /// Mean velocity of the last fixes of a vehicle at rest, m/s (M11).
    pub resting_fixes_mps: [f32; 3],
}

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// The learned quantities, for a second implementation of the filter's equations.
    #[doc(hidden)]
    #[must_use]
    pub fn learned(&self) -> Learned {
        let integrity = &self.samples.integrity;
        let vibration = [integrity.gyro_vibration(), integrity.accel_vibration()];
        let ones = Vector::new(T::ONE, T::ONE, T::ONE);
        let baro_variance = self.memory.barometer.noise_variance(self.config.baro.noise_m);
        Learned {
            vibration: vibration.map(|axes| axes.map(Scalar::wide)),
            suspicion: self.samples.suspicion.cast(),
            excess: self.memory.excess.factor(),
            rectification: self.samples.rectification.variance([1.0; 3], 1.0),
            level_share: self.memory.level_force.of_motion(ones).x().wide(),
            gps_size: self.memory.gps_learned,
            position_scatter: self.memory.position_scatter.share(),
            gps_wander: self.memory.gps_wander,
            heading_wander: self.memory.heading_wander,
            antenna: (
                self.memory.antenna.offset_m().cast().to_array(),
                self.memory.antenna.velocity_variance(1.0),
            ),
            // With zero noise and an interval of two seconds, the excess equals the swing.
            attitude_swing: self.memory.attitude_watch.excess(0.0, 2.0),
            attitude_used: self.memory.heading.used,
            attitude_lost: self.memory.attitude_lost,
            baro: (self.memory.barometer.level_m(), baro_variance),
            ground_height_m: self.memory.ground.height_m,
            antenna_heading_used: self.memory.antenna_heading.used,
            resting_rate_radps: self
                .samples
                .resting_rate_radps
                .map(|rate| rate.to_array().map(Scalar::wide)),
            resting_fixes_mps: self.samples.rest.fixes_mean_mps(),
        }
    }
}
