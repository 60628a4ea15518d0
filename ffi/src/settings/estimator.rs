//! Settings of the estimator.

use hovernav::ekf as core_ekf;
use hovernav::ekf::EstimatorConfig;
use hovernav::health::HealthLimits as CoreHealthLimits;
use hovernav::imu::NotchConfig;
use hovernav::ins::{AlignmentConfig, HeadingSource, Mounting};

use super::aids::{Rangefinder, SecondAntenna};
use super::mechanisms::Mechanisms;
use super::vehicle::{kind_of, number_of};
use super::{HealthLimits, Notch, flag, mirror, within};
use crate::access::{input, optional, output};
use crate::object::HOVERNAV_ABI;
use crate::status::{Fault, Status};

/// In HovernavAlignment.heading: the first available source in the order two antennas, inertial unit's own attitude,
/// magnetometer; else unknown.
pub const HOVERNAV_HEADING_ANY: u32 = 0;
/// In HovernavAlignment.heading: the inertial unit's own attitude.
pub const HOVERNAV_HEADING_ATTITUDE: u32 = 1;
/// In HovernavAlignment.heading: the levelled magnetometer, corrected by the declination.
pub const HOVERNAV_HEADING_MAGNETOMETER: u32 = 2;
/// In HovernavAlignment.heading: the course over ground; only for vehicles that travel in the direction of their nose.
pub const HOVERNAV_HEADING_COURSE: u32 = 3;
/// In HovernavAlignment.heading: unknown; the estimator finds the heading in motion.
pub const HOVERNAV_HEADING_UNKNOWN: u32 = 4;
/// In HovernavAlignment.heading: two GPS antennas.
pub const HOVERNAV_HEADING_SECOND_ANTENNA: u32 = 5;

/// Alignment of the estimator at its start.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Alignment {
    /// Source of the first heading: one of HOVERNAV_HEADING_.
    pub heading: u32,
    /// Duration of inertial data needed for alignment, 0.1 to 120 s.
    pub duration_s: f64,
    /// Offset, rad, added to the inertial unit's yaw to give true heading: the declination, if the yaw is magnetic.
    pub attitude_declination_rad: f64,
    /// Magnetic declination, east positive, rad, for the magnetometer.
    pub declination_rad: f64,
    /// One-sigma of the inertial unit's own roll and pitch, rad.
    pub attitude_tilt_sigma_rad: f64,
    /// One-sigma of the first heading, from the inertial unit's own attitude or the magnetometer, rad.
    pub heading_sigma_rad: f64,
    /// One-sigma of roll and pitch from levelling at rest, rad.
    pub level_sigma_rad: f64,
    /// One-sigma of roll and pitch from levelling in motion, rad.
    pub moving_level_sigma_rad: f64,
    /// One-sigma of position, m, for a fix without an accuracy of its own.
    pub position_sigma_m: f64,
    /// One-sigma of velocity, m/s, for a fix without an accuracy of its own.
    pub velocity_sigma_mps: f64,
    /// Smallest speed at which the course gives the heading, m/s.
    pub course_speed_mps: f64,
}

/// Error model of the inertial sensors.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ImuModel {
    /// Angle random walk, rad/sqrt(s).
    pub angle_random_walk_rad: f64,
    /// Velocity random walk, m/s/sqrt(s).
    pub velocity_random_walk_mps: f64,
    /// Fraction of the gyros' measured vibration that counts as white noise.
    pub gyro_vibration_share: f64,
    /// Fraction of the accelerometers' measured vibration that counts as white noise.
    pub accel_vibration_share: f64,
    /// Time, s, within which accelerometer samples have the same vibration error.
    pub accel_vibration_time_s: f64,
    /// One-sigma of the gyro bias, rad/s.
    pub gyro_bias_sigma_radps: f64,
    /// Correlation time of the gyro bias, s.
    pub gyro_bias_time_s: f64,
    /// One-sigma of the accelerometer bias, m/s^2.
    pub accel_bias_sigma_mps2: f64,
    /// Correlation time of the accelerometer bias, s.
    pub accel_bias_time_s: f64,
    /// Gyro error about the axis of a turn, as a fraction of the turn, if the filter has no states for it. The error
    /// across the axis is 2.5 times as large.
    pub turn_error_share: f64,
    /// Time, s, for which the gyro error of a turn keeps its sign.
    pub turn_error_time_s: f64,
    /// One-sigma of each gyro's scale factor error, as a fraction of the net turn about its axis, if the filter has no
    /// states for it.
    pub net_turn_error_share: f64,
    /// Time constant, s, with which the memory of a net turn decays.
    pub net_turn_memory_s: f64,
    /// Full scale of the gyros, rad/s; 0 if unknown.
    pub gyro_range_radps: f64,
    /// Full scale of the accelerometers, m/s^2; 0 if unknown.
    pub accel_range_mps2: f64,
    /// Longest interval between samples that is not a gap, s.
    pub gap_s: f64,
    /// One-sigma of the unmeasured acceleration during a gap, m/s^2.
    pub gap_acceleration_mps2: f64,
    /// One-sigma of the unmeasured angular rate during a gap, rad/s.
    pub gap_rate_radps: f64,
    /// Interval of covariance propagation, s; 0 for propagation at every sample, like the state. The covariance is also
    /// propagated before each measurement.
    pub covariance_interval_s: f64,
}

/// Error model of the GPS.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GpsModel {
    /// One-sigma of horizontal position, each axis, m, for a fix without an accuracy of its own.
    pub horizontal_sigma_m: f64,
    /// One-sigma of height, m, for a fix without an accuracy of its own.
    pub vertical_sigma_m: f64,
    /// One-sigma of horizontal velocity, each axis, m/s, for a fix without an accuracy of its own.
    pub horizontal_velocity_sigma_mps: f64,
    /// One-sigma of vertical velocity, m/s, for a fix without an accuracy of its own.
    pub vertical_velocity_sigma_mps: f64,
    /// Lower limit of the one-sigma of the white position error, m.
    pub position_floor_m: f64,
    /// Lower limit of the one-sigma of the white velocity error, m/s.
    pub velocity_floor_mps: f64,
    /// Fraction of the position's one-sigma that varies slowly, 0 to 1.
    pub position_wander_share: f64,
    /// Correlation time of the position's slow error, s.
    pub position_wander_time_s: f64,
    /// Fraction of the velocity's one-sigma that varies slowly, 0 to 1.
    pub velocity_wander_share: f64,
    /// Correlation time of the velocity's slow error, s.
    pub velocity_wander_time_s: f64,
    /// One-sigma of the time over which a receiver averages its velocity, s.
    pub velocity_smoothing_s: f64,
    /// Learning rate, 0 to 1: weight of one innovation in a learned GPS variance. The filter learns one-sigmas that the
    /// fixes do not contain, or that are too small.
    pub learning_rate: f64,
    /// One-sigma of the time between the validity of a fix's position and of its velocity, s.
    pub position_latency_sigma_s: f64,
    /// One-sigma of the time, s, by which a fix is valid earlier than its declared time.
    pub delay_sigma_s: f64,
}

/// Error model of the inertial unit's own attitude.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct AttitudeModel {
    /// Shortest time between two updates, s.
    pub interval_s: f64,
    /// One-sigma of the slow error in roll and pitch, rad.
    pub tilt_wander_rad: f64,
    /// One-sigma of the slow error in heading, rad.
    pub heading_wander_rad: f64,
    /// Correlation time of the slow error, s.
    pub wander_time_s: f64,
    /// One-sigma of the white error, rad.
    pub noise_rad: f64,
}

/// Error model of a heading from a magnetometer.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct MagnetometerModel {
    /// Shortest time between two updates, s.
    pub interval_s: f64,
    /// One-sigma of the slow error of the heading, rad.
    pub heading_wander_rad: f64,
    /// Correlation time of the slow error, s.
    pub wander_time_s: f64,
    /// One-sigma of the white error, rad.
    pub noise_rad: f64,
}

/// Error model of a barometric height.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct BaroModel {
    /// One-sigma of the white error of the height, m.
    pub noise_m: f64,
    /// One-sigma of the slow error of the height, m.
    pub wander_m: f64,
    /// Correlation time of the slow error, s.
    pub wander_time_s: f64,
}

/// Gates, and the times after which the filter is reset to rejected measurements.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GateModel {
    /// Gate, in one-sigmas: larger innovations are rejected.
    pub sigmas: f64,
    /// Lockout time after an absence of measurements or a fault of the inertial samples, s.
    pub recovery_s: f64,
    /// Lockout time of positions that jumped while velocity still agrees, s.
    pub fault_s: f64,
    /// Lockout time of any other measurement rejected without interruption, s.
    pub lockout_s: f64,
}

/// The complete configuration of the estimator. hovernav_default_config() sets it to defaults; then replace the values
/// that you know.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Config {
    /// Position of the inertial unit relative to the reference point of the solution (such as the centre of gravity),
    /// body axes, m.
    pub imu_lever_arm_m: [f64; 3],
    /// Position of the GPS antenna relative to the same point, body axes, m.
    pub antenna_lever_arm_m: [f64; 3],
    /// 1 if the inertial unit's own attitude is used after alignment, else 0.
    pub use_attitude: u32,
    /// 1 if the magnetometer is used, else 0. While use_attitude is 1, a sample's own attitude is used in place of its
    /// magnetic field.
    pub use_magnetometer: u32,
    /// 1 if the barometer is used, else 0.
    pub use_baro: u32,
    /// 1 if the rangefinder is used, else 0.
    pub use_rangefinder: u32,
    /// 1 if the heading of two antennas is used, else 0.
    pub use_second_antenna: u32,
    /// Kind of the vehicle, one of `HOVERNAV_VEHICLE_`. With `HOVERNAV_VEHICLE_UNSTATED` the fixes show whether the
    /// vehicle rolls on wheels.
    pub vehicle_kind: u32,
    /// Alignment of the estimator at its start.
    pub alignment: Alignment,
    /// Error model of the inertial sensors.
    pub imu: ImuModel,
    /// Error model of the GPS.
    pub gps: GpsModel,
    /// Error model of the inertial unit's own attitude.
    pub attitude: AttitudeModel,
    /// Error model of the magnetometer.
    pub magnetometer: MagnetometerModel,
    /// Error model of the barometer.
    pub baro: BaroModel,
    /// Gates, and lockout times after which the filter is reset.
    pub gate: GateModel,
    /// Switches of the filter's mechanisms.
    pub mechanisms: Mechanisms,
    /// Settings of the rangefinder.
    pub rangefinder: Rangefinder,
    /// Settings of the second antenna.
    pub second_antenna: SecondAntenna,
    /// Settings of the notch filter before the estimator.
    pub notch: Notch,
    /// Limits that hovernav_get_health() uses.
    pub health: HealthLimits,
}

mirror!(ImuModel, core_ekf::ImuModel {
    angle_random_walk_rad velocity_random_walk_mps gyro_vibration_share accel_vibration_share
    accel_vibration_time_s gyro_bias_sigma_radps gyro_bias_time_s accel_bias_sigma_mps2
    accel_bias_time_s turn_error_share turn_error_time_s
    net_turn_error_share net_turn_memory_s gyro_range_radps accel_range_mps2 gap_s
    gap_acceleration_mps2 gap_rate_radps covariance_interval_s
});
mirror!(GpsModel, core_ekf::GpsModel {
    horizontal_sigma_m vertical_sigma_m horizontal_velocity_sigma_mps vertical_velocity_sigma_mps
    position_floor_m velocity_floor_mps position_wander_share position_wander_time_s
    velocity_wander_share velocity_wander_time_s velocity_smoothing_s learning_rate
    position_latency_sigma_s delay_sigma_s
});
mirror!(AttitudeModel, core_ekf::AttitudeModel {
    interval_s tilt_wander_rad heading_wander_rad wander_time_s noise_rad
});
mirror!(MagnetometerModel, core_ekf::MagnetometerModel {
    interval_s heading_wander_rad wander_time_s noise_rad
});
mirror!(BaroModel, core_ekf::BaroModel { noise_m wander_m wander_time_s });
mirror!(GateModel, core_ekf::GateConfig { sigmas recovery_s fault_s lockout_s });

impl Alignment {
    fn put(&self, into: &mut AlignmentConfig) -> Result<(), Fault> {
        into.heading = match self.heading {
            HOVERNAV_HEADING_ANY => None,
            HOVERNAV_HEADING_ATTITUDE => Some(HeadingSource::Attitude),
            HOVERNAV_HEADING_MAGNETOMETER => Some(HeadingSource::Magnetometer),
            HOVERNAV_HEADING_COURSE => Some(HeadingSource::Course),
            HOVERNAV_HEADING_UNKNOWN => Some(HeadingSource::Unknown),
            HOVERNAV_HEADING_SECOND_ANTENNA => Some(HeadingSource::SecondAntenna),
            other => {
                let what = ["alignment.heading"];
                return Err(Fault::new(&what, f64::from(other), "one of HOVERNAV_HEADING_"));
            }
        };
        within!("alignment.", self, 0.1, 120.0, "0.1 to 120"; duration_s);
        within!("alignment.", self, 0.0, 1e6, "0 to 1e6";
            attitude_tilt_sigma_rad heading_sigma_rad level_sigma_rad
            moving_level_sigma_rad position_sigma_m velocity_sigma_mps course_speed_mps);
        within!("alignment.", self, -7.0, 7.0, "-2 pi to 2 pi";
            attitude_declination_rad declination_rad);
        into.duration_s = self.duration_s;
        into.attitude_declination_rad = self.attitude_declination_rad;
        into.declination_rad = self.declination_rad;
        into.attitude_tilt_sigma_rad = self.attitude_tilt_sigma_rad;
        into.heading_sigma_rad = self.heading_sigma_rad;
        into.level_sigma_rad = self.level_sigma_rad;
        into.moving_level_sigma_rad = self.moving_level_sigma_rad;
        into.position_sigma_m = self.position_sigma_m;
        into.velocity_sigma_mps = self.velocity_sigma_mps;
        into.course_speed_mps = self.course_speed_mps;
        Ok(())
    }

    fn of(core: &AlignmentConfig) -> Self {
        Self {
            heading: match core.heading {
                None => HOVERNAV_HEADING_ANY,
                Some(HeadingSource::Attitude) => HOVERNAV_HEADING_ATTITUDE,
                Some(HeadingSource::Magnetometer) => HOVERNAV_HEADING_MAGNETOMETER,
                Some(HeadingSource::Course) => HOVERNAV_HEADING_COURSE,
                Some(HeadingSource::Unknown) => HOVERNAV_HEADING_UNKNOWN,
                Some(HeadingSource::SecondAntenna) => HOVERNAV_HEADING_SECOND_ANTENNA,
            },
            duration_s: core.duration_s,
            attitude_declination_rad: core.attitude_declination_rad,
            declination_rad: core.declination_rad,
            attitude_tilt_sigma_rad: core.attitude_tilt_sigma_rad,
            heading_sigma_rad: core.heading_sigma_rad,
            level_sigma_rad: core.level_sigma_rad,
            moving_level_sigma_rad: core.moving_level_sigma_rad,
            position_sigma_m: core.position_sigma_m,
            velocity_sigma_mps: core.velocity_sigma_mps,
            course_speed_mps: core.course_speed_mps,
        }
    }
}

/// A checked configuration.
#[derive(Clone, Copy, Debug)]
pub struct Checked {
    /// Configuration of the estimator.
    pub estimator: EstimatorConfig,
    /// Configuration of the notch; `None` without a notch.
    pub notch: Option<NotchConfig>,
    /// Accuracy of the estimate required to fly.
    pub health: CoreHealthLimits,
}

impl Config {
    /// Converts a configuration of the core to this structure.
    #[must_use]
    pub fn of(
        estimator: &EstimatorConfig,
        notch: Option<NotchConfig>,
        health: &CoreHealthLimits,
    ) -> Self {
        let ekf = &estimator.ekf;
        Self {
            imu_lever_arm_m: estimator.mounting.imu_lever_arm_m.to_array(),
            antenna_lever_arm_m: estimator.mounting.antenna_lever_arm_m.to_array(),
            use_attitude: u32::from(estimator.aiding.attitude),
            use_magnetometer: u32::from(estimator.aiding.magnetometer),
            use_baro: u32::from(estimator.aiding.baro),
            use_rangefinder: u32::from(estimator.aiding.rangefinder),
            use_second_antenna: u32::from(estimator.aiding.second_antenna),
            vehicle_kind: number_of(estimator.vehicle_kind),
            alignment: Alignment::of(&estimator.alignment),
            imu: (&ekf.imu).into(),
            gps: (&ekf.gps).into(),
            attitude: (&ekf.attitude).into(),
            magnetometer: (&ekf.magnetometer).into(),
            baro: (&ekf.baro).into(),
            gate: (&ekf.gate).into(),
            mechanisms: (&ekf.mechanisms).into(),
            rangefinder: Rangefinder::of(estimator),
            second_antenna: SecondAntenna::of(estimator),
            notch: Notch::of(notch),
            health: health.into(),
        }
    }

    /// Checks the values and converts them to configurations of the core.
    ///
    /// # Errors
    /// [`Fault`] names the first invalid value.
    pub fn checked(&self) -> Result<Checked, Fault> {
        for (what, arm) in [
            ("imu_lever_arm_m", self.imu_lever_arm_m),
            ("antenna_lever_arm_m", self.antenna_lever_arm_m),
            ("rangefinder.lever_arm_m", self.rangefinder.lever_arm_m),
            ("second_antenna.baseline_m", self.second_antenna.baseline_m),
        ] {
            if let Some(found) = arm.into_iter().find(|value| !(-1e3..=1e3).contains(value)) {
                return Err(Fault::new(&[what], found, "-1000 to 1000 m"));
            }
        }
        let mut estimator = EstimatorConfig::default();
        estimator.mounting = Mounting::default()
            .with_imu_lever_arm_m(self.imu_lever_arm_m.into())
            .with_antenna_lever_arm_m(self.antenna_lever_arm_m.into());
        estimator.aiding.attitude = flag("use_attitude", self.use_attitude)?;
        estimator.aiding.magnetometer = flag("use_magnetometer", self.use_magnetometer)?;
        estimator.aiding.baro = flag("use_baro", self.use_baro)?;
        estimator.aiding.rangefinder = flag("use_rangefinder", self.use_rangefinder)?;
        estimator.aiding.second_antenna = flag("use_second_antenna", self.use_second_antenna)?;
        estimator.vehicle_kind = kind_of(self.vehicle_kind)?;
        self.alignment.put(&mut estimator.alignment)?;
        self.rangefinder.put(&mut estimator)?;
        self.second_antenna.put(&mut estimator);
        let ekf = &mut estimator.ekf;
        self.imu.put(&mut ekf.imu);
        self.gps.put(&mut ekf.gps);
        self.attitude.put(&mut ekf.attitude);
        self.magnetometer.put(&mut ekf.magnetometer);
        self.baro.put(&mut ekf.baro);
        self.gate.put(&mut ekf.gate);
        ekf.mechanisms = self.mechanisms.core()?;
        if let Some(wrong) = estimator.out_of_range() {
            let what = [wrong.group, ".", wrong.name];
            return Err(Fault::new(&what, wrong.found, wrong.expected));
        }
        let notch = self.notch.core()?;
        let mut health = CoreHealthLimits::default();
        self.health.put(&mut health);
        within!("health.", self.health, 1e-6, 1e3, "1e-6 to 1000";
            tilt_sigma_rad heading_sigma_rad velocity_sigma_mps vertical_velocity_sigma_mps
            position_sigma_m age_s dead_reckoning_s disagreement_s);
        within!("health.", self.health, 0.0, 1e3, "0 to 1000"; recovery_s);
        Ok(Checked { estimator, notch, health })
    }
}

/// Sets `config` to the defaults: a consumer or tactical-grade MEMS inertial unit on a vibrating vehicle, a stand-alone
/// GPS, no lever arms. `abi` is HOVERNAV_ABI. If the library has another version, nothing is written and the result is
/// HOVERNAV_STATUS_ABI_MISMATCH.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_default_config(config: *mut Config, abi: u32) -> Status {
    if abi != HOVERNAV_ABI {
        return Status::AbiMismatch;
    }
    // SAFETY: guaranteed by the caller.
    let slot = unsafe { output(config) };
    Status::of(slot.map(|slot| {
        slot.write(Config::of(&EstimatorConfig::default(), None, &CoreHealthLimits::default()));
    }))
}

/// Checks `config`. `fault`, unless null, receives the first value that is out of range.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_check_config(config: *const Config, fault: *mut Fault) -> Status {
    // SAFETY: guaranteed by the caller.
    let config = unsafe { input(config) };
    // SAFETY: guaranteed by the caller.
    let fault = unsafe { optional(fault) };
    Status::of(config.and_then(|config| {
        let fault = fault?;
        config.checked().map(|_| ()).map_err(|wrong| Status::reject(wrong, fault))
    }))
}
