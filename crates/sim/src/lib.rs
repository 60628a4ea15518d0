//! Simulation: error-free flights, and sensors with all their errors. Needs `std`.
//!
//! ```
//! use hovernav::earth::Geodetic;
//! use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig, fly};
//!
//! let start = Geodetic::from_degrees(1.3521, 103.8198, 50.0).unwrap();
//! let trajectory = FlightPlan::hover_at(start, 0.0).hold(10.0).test_points().build()?;
//! let recording = fly(&trajectory, &DmuConfig::default(), &GpsConfig::default(), 7)?;
//! assert_eq!(recording.imu.len(), recording.truth.len());
//! assert_eq!(recording.fixes.len(), 113);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod aids;
mod airframe;
mod axes;
mod baro;
pub mod campaign;
mod check;
mod crash;
mod disturbance;
mod dmu;
mod engine;
pub mod faults;
mod flight;
mod gps;
mod ground;
mod leg;
mod manifest;
mod noise;
mod plan;
mod servo;
mod skids;
mod state;
mod trajectory;
mod transport;
mod triad;
mod vehicle;
mod vibration;
mod wind;

pub use aids::{AntennasConfig, RangefinderConfig, SimulatedAntennas, SimulatedRangefinder};
pub use axes::HorizontalVertical;
pub use baro::{BaroConfig, SimulatedBaro};
pub use check::ConfigError;
pub use crash::Crash;
pub use disturbance::Disturbance;
pub use dmu::{AttitudeConfig, DmuConfig, DmuOutput, ImuTruth, MagnetometerConfig, SimulatedDmu};
pub use engine::EngineConfig;
pub use flight::{
    Excursion, Feedback, Flight, FlightConfig, FlightError, FlightEvent, FlightSample,
    HoverStatistics, velocity_deviation_mps,
};
pub use gps::{GpsConfig, SimulatedGps};
pub use leg::{Leg, Level};
pub use manifest::sensor_manifest;
pub use plan::FlightPlan;
pub use servo::{ServoConfig, SimulatedServo};
pub use state::State;
pub use trajectory::{Trajectory, TrajectoryError};
pub use triad::{AccelerometerConfig, GyroConfig};
pub use vehicle::{Vehicle, VehicleConfig};
pub use vibration::{Harmonic, VibrationSource};
pub use wind::{Wind, WindConfig};

use hovernav::gps::Fix;
use hovernav::imu::ImuSample;
use hovernav::time::Time;
use hovernav_dataset::Truth;

/// A simulated flight: the measurements and the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Samples of the inertial unit; the first at [`Time::ZERO`], the start of the trajectory.
    pub imu: Vec<ImuSample>,
    /// Fixes, the first at the start.
    pub fixes: Vec<Fix>,
    /// The centre of gravity at the time of every sample of the inertial unit.
    pub truth: Vec<Truth>,
}

/// Simulates the sensors along `trajectory`. The same `seed` gives the same recording, bit for bit on one platform.
///
/// # Errors
/// [`ConfigError`] with the invalid value of a configuration.
pub fn fly(
    trajectory: &Trajectory,
    dmu_config: &DmuConfig,
    gps_config: &GpsConfig,
    seed: u64,
) -> Result<Recording, ConfigError> {
    let mut dmu = SimulatedDmu::new(dmu_config, seed)?;
    let mut gps = SimulatedGps::new(gps_config, seed)?;

    let lever_arm = dmu_config.lever_arm_m;
    let mut before_time = Time::ZERO + -1.0 / dmu_config.rate_hz;
    let mut before = trajectory.at(before_time.seconds());
    let mut imu = Vec::new();
    let mut truth = Vec::new();
    for time in sample_times(dmu_config.rate_hz, trajectory.duration_s()) {
        let now = trajectory.at(time.seconds());
        let (angular_rate_radps, specific_force_mps2) = match dmu_config.output {
            DmuOutput::Rates => (now.inertial_rate_radps, now.specific_force_at(lever_arm)),
            DmuOutput::Increments => {
                let (angle, velocity) = trajectory.increments_between(
                    (before_time.seconds(), &before),
                    (time.seconds(), &now),
                    lever_arm,
                );
                let per_second = 1.0 / (time - before_time);
                (angle * per_second, velocity * per_second)
            }
        };
        let body_to_ned = now.body_to_ned;
        imu.push(
            dmu.measure(time, &ImuTruth { angular_rate_radps, specific_force_mps2, body_to_ned }),
        );
        truth.push(now.truth(time));
        (before_time, before) = (time, now);
    }

    let fixes = sample_times(gps_config.rate_hz, trajectory.duration_s())
        .filter_map(|time| {
            let antenna = trajectory.at(time.seconds()).at_point(gps_config.lever_arm_m);
            gps.measure(time, &antenna.position, antenna.velocity_mps)
        })
        .collect();
    Ok(Recording { imu, fixes, truth })
}

/// Times at `rate_hz` from 0 to `duration_s`, to the nanosecond.
fn sample_times(rate_hz: f64, duration_s: f64) -> impl Iterator<Item = Time> {
    let last = (duration_s * rate_hz + 1e-6) as u64;
    (0..=last).map(move |k| Time::ZERO + k as f64 / rate_hz)
}
