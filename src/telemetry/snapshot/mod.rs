//! The state of a flight at one moment, as sent to the ground.

mod gps;
mod innovations;
mod status;

pub use gps::{FixKind, GpsSummary};
pub use innovations::Innovations;
pub use status::{StatusFlags, SystemMode};

use crate::controls::Channels;
use crate::earth::Geodetic;
use crate::ekf::Solution;
use crate::frames::{Body, EulerAngles, Ned, Vector};
use crate::imu::ImuSample;
use crate::scalar::Scalar;
use crate::time::Time;

/// One-sigmas of the estimator; `None` before it runs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sigmas {
    /// One-sigma of horizontal position, north and east combined, m.
    pub horizontal_m: Option<f64>,
    /// One-sigma of height, m.
    pub vertical_m: Option<f64>,
    /// One-sigma of horizontal velocity, north and east combined, m/s.
    pub horizontal_velocity_mps: Option<f64>,
    /// One-sigma of vertical velocity, m/s.
    pub vertical_velocity_mps: Option<f64>,
    /// Greater one-sigma of roll and pitch, rad.
    pub tilt_rad: Option<f64>,
    /// One-sigma of heading, rad.
    pub heading_rad: Option<f64>,
}

/// Timing of the control loop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoopTiming {
    /// Time from the start of the previous cycle to the start of this one, s.
    pub period_s: Option<f64>,
    /// Work time of the last cycle, s.
    pub work_s: Option<f64>,
    /// Longest work time of a cycle since the start, s.
    pub longest_work_s: Option<f64>,
    /// Number of cycles since the start that did not end in time.
    pub overruns: u32,
}

/// Numbers of lost items since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drops {
    /// Number of lost packets of the inertial unit.
    pub imu_packets: u32,
    /// Number of lost messages of the receiver.
    pub gps_messages: u32,
    /// Number of lost pulses of the pilot; the largest number of any channel.
    pub pilot_pulses: u32,
    /// Number of telemetry frames dropped because the serial line was full.
    pub telemetry_frames: u32,
}

/// The state of a flight at one moment; unknown values are `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapshot {
    /// Time of the snapshot, on the flight's clock.
    pub time: Time,
    /// Mode of the system.
    pub mode: SystemMode,
    /// Flags of the functions that work.
    pub status: StatusFlags,
    /// Angular rate, rad/s: corrected for bias while the estimator runs, else as measured.
    pub angular_rate_radps: Option<Vector<Body>>,
    /// Specific force as measured, m/s²; level and at rest its z is −9.81.
    pub specific_force_mps2: Option<Vector<Body>>,
    /// Magnetic field as measured, gauss.
    pub magnetic_field_gauss: Option<Vector<Body>>,
    /// Temperature of the inertial unit, °C.
    pub temperature_degc: Option<f64>,
    /// Attitude from the estimator.
    pub attitude: Option<EulerAngles>,
    /// Position from the estimator.
    pub position: Option<Geodetic>,
    /// Velocity from the estimator, m/s.
    pub velocity_mps: Option<Vector<Ned>>,
    /// One-sigmas of the estimator's solution.
    pub sigmas: Sigmas,
    /// Widths commanded to the servos, ms.
    pub commanded_ms: Channels<Option<f64>>,
    /// Widths from the pilot's receiver, ms.
    pub pilot_ms: Channels<Option<f64>>,
    /// The receiver's last fix.
    pub gps: GpsSummary,
    /// Consistency of sensors and estimator.
    pub innovations: Innovations,
    /// Timing of the control loop.
    pub timing: LoopTiming,
    /// Numbers of lost items.
    pub drops: Drops,
}

impl Snapshot {
    /// A snapshot with only the time.
    #[must_use]
    pub fn at(time: Time) -> Self {
        Self {
            time,
            mode: SystemMode::default(),
            status: StatusFlags::default(),
            angular_rate_radps: None,
            specific_force_mps2: None,
            magnetic_field_gauss: None,
            temperature_degc: None,
            attitude: None,
            position: None,
            velocity_mps: None,
            sigmas: Sigmas::default(),
            commanded_ms: Channels::default(),
            pilot_ms: Channels::default(),
            gps: GpsSummary::default(),
            innovations: Innovations::default(),
            timing: LoopTiming::default(),
            drops: Drops::default(),
        }
    }

    /// Adds a measurement of the inertial unit. `interval_s`, the time since the previous sample, converts increments
    /// into rates; it is ignored for rates. Call it before [`Snapshot::with_solution`], whose rates are more
    /// accurate.
    #[must_use]
    pub fn with_imu(mut self, sample: &ImuSample, interval_s: f64) -> Self {
        let mean = sample.motion.mean_rates(interval_s);
        self.angular_rate_radps = Some(mean.angular_rate_radps).filter(|vector| vector.is_finite());
        self.specific_force_mps2 =
            Some(mean.specific_force_mps2).filter(|vector| vector.is_finite());
        self.magnetic_field_gauss = sample.magnetic_field_gauss;
        self
    }

    /// Notes whether samples of the inertial unit arrive. Without them its measurements and the solution are those of
    /// the past, and are removed.
    pub fn observe_imu(&mut self, is_present: bool) {
        self.status.imu = is_present;
        if !is_present {
            self.angular_rate_radps = None;
            self.specific_force_mps2 = None;
            self.magnetic_field_gauss = None;
            self.temperature_degc = None;
            self.attitude = None;
            self.position = None;
            self.velocity_mps = None;
            self.sigmas = Sigmas::default();
        }
    }

    /// Adds the solution of the estimator.
    #[must_use]
    pub fn with_solution(mut self, solution: &Solution) -> Self {
        let horizontal = |sigma: Vector<Ned>| Some(Scalar::hypot(sigma.x(), sigma.y()));
        let (position, velocity) = (solution.position_sigma_m, solution.velocity_sigma_mps);
        let [roll, pitch, yaw] = solution.attitude_sigma_rad;
        self.angular_rate_radps = Some(solution.angular_rate_radps);
        self.attitude = Some(solution.body_to_ned.euler());
        self.position = Some(solution.position);
        self.velocity_mps = Some(solution.velocity_mps);
        self.sigmas = Sigmas {
            horizontal_m: horizontal(position),
            vertical_m: Some(position.z()),
            horizontal_velocity_mps: horizontal(velocity),
            vertical_velocity_mps: Some(velocity.z()),
            tilt_rad: Some(roll.max(pitch)),
            heading_rad: Some(yaw),
        };
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imu::Motion;
    use approx::assert_abs_diff_eq;

    #[test]
    fn increments_are_reported_as_rates() {
        let motion = Motion::Increments {
            angle_rad: Vector::new(0.01, 0.0, 0.0),
            velocity_mps: Vector::new(0.0, 0.0, -0.098_1),
        };
        let sample = ImuSample::new(Time::ZERO, motion);
        let told = Snapshot::at(Time::ZERO).with_imu(&sample, 0.01);
        assert_abs_diff_eq!(told.angular_rate_radps.unwrap().x(), 1.0, epsilon = 1e-12);
        assert_abs_diff_eq!(told.specific_force_mps2.unwrap().z(), -9.81, epsilon = 1e-12);
        assert_eq!(Snapshot::at(Time::ZERO).with_imu(&sample, 0.0).specific_force_mps2, None);
    }
}
