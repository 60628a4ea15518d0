//! Settings of the estimator.

use hovernav::autopilot::HealthLimits as CoreHealthLimits;
use hovernav::ekf as core_ekf;
use hovernav::ekf::EstimatorConfig;
use hovernav::imu::NotchConfig;
use hovernav::ins::{AlignmentConfig, HeadingSource, Mounting};

use super::aids::{Rangefinder, SecondAntenna};
use super::{HealthLimits, Notch, flag, mirror, within};
use crate::access::{input, optional, output};
use crate::object::HOVERNAV_ABI;
use crate::status::{Fault, Status};

/// In HovernavAlignment.heading: the first there is of two antennas', the unit's own, the magnetometer's, none.
pub const HOVERNAV_HEADING_ANY: u32 = 0;
/// The unit's own attitude.
pub const HOVERNAV_HEADING_ATTITUDE: u32 = 1;
/// The magnetometer, levelled, and the declination.
pub const HOVERNAV_HEADING_MAGNETOMETER: u32 = 2;
/// The course over ground; only for vehicles that point where they go.
pub const HOVERNAV_HEADING_COURSE: u32 = 3;
/// None: found in motion.
pub const HOVERNAV_HEADING_UNKNOWN: u32 = 4;
/// Two GPS antennas.
pub const HOVERNAV_HEADING_SECOND_ANTENNA: u32 = 5;

/// How the estimator starts.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Alignment {
    /// Where the first heading comes from: one of HOVERNAV_HEADING_.
    pub heading: u32,
    /// Length of inertial data needed, 0.1 to 120 s.
    pub duration_s: f64,
    /// What to add to the unit's yaw for true heading: the declination where it is magnetic, rad.
    pub attitude_declination_rad: f64,
    /// Magnetic declination, east positive, rad, for the magnetometer.
    pub declination_rad: f64,
    /// One-sigma of the unit's own roll and pitch, rad.
    pub attitude_tilt_sigma_rad: f64,
    /// One-sigma of the unit's own or the magnetic heading, rad.
    pub heading_sigma_rad: f64,
    /// One-sigma of levelling at rest, rad.
    pub level_sigma_rad: f64,
    /// One-sigma of levelling in motion, rad.
    pub moving_level_sigma_rad: f64,
    /// One-sigma of position where the fix does not say, m.
    pub position_sigma_m: f64,
    /// One-sigma of velocity where the fix does not say, m/s.
    pub velocity_sigma_mps: f64,
    /// Speed at which the course gives the heading, m/s.
    pub course_speed_mps: f64,
}

/// Errors of the inertial sensors.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct ImuModel {
    /// Angle random walk, rad/sqrt(s).
    pub angle_random_walk_rad: f64,
    /// Velocity random walk, m/s/sqrt(s).
    pub velocity_random_walk_mps: f64,
    /// Share of the measured vibration of the gyros that counts as noise without memory.
    pub gyro_vibration_share: f64,
    /// The same of the accelerometers.
    pub accel_vibration_share: f64,
    /// Accelerometer samples closer than this, s, share one error by vibration.
    pub accel_vibration_time_s: f64,
    /// One-sigma of the gyro bias, rad/s.
    pub gyro_bias_sigma_radps: f64,
    /// Correlation time of the gyro bias, s.
    pub gyro_bias_time_s: f64,
    /// One-sigma of the accelerometer bias, m/s^2.
    pub accel_bias_sigma_mps2: f64,
    /// Correlation time of the accelerometer bias, s.
    pub accel_bias_time_s: f64,
    /// One-sigma of each gyro's scale factor error.
    pub gyro_scale_sigma: f64,
    /// One-sigma of each accelerometer's scale factor error.
    pub accel_scale_sigma: f64,
    /// Share of a turn by which gyros err about its axis, where there are no states for it; those across it by two and
    /// a half times as much.
    pub turn_error_share: f64,
    /// A turn errs to one side for about this long, s.
    pub turn_error_time_s: f64,
    /// One-sigma of each gyro's scale factor error as a share of the net turn about its axis, where there are no states
    /// for it.
    pub net_turn_error_share: f64,
    /// A net turn is forgotten with this time constant, s.
    pub net_turn_memory_s: f64,
    /// Full scale of the gyros, rad/s; 0 where it is not known.
    pub gyro_range_radps: f64,
    /// Full scale of the accelerometers, m/s^2; 0 where it is not known.
    pub accel_range_mps2: f64,
    /// Intervals longer than this, s, are gaps.
    pub gap_s: f64,
    /// Acceleration that a gap may have hidden, one-sigma, m/s^2.
    pub gap_acceleration_mps2: f64,
    /// Angular rate that a gap may have hidden, one-sigma, rad/s.
    pub gap_rate_radps: f64,
    /// The covariance is propagated once so much time has come together, s, and before each measurement; 0 at
    /// every sample, as the state is.
    pub covariance_interval_s: f64,
}

/// Errors of the GPS.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GpsModel {
    /// One-sigma of horizontal position, each axis, where a fix does not say, m.
    pub horizontal_sigma_m: f64,
    /// One-sigma of height where a fix does not say, m.
    pub vertical_sigma_m: f64,
    /// One-sigma of horizontal velocity, each axis, where a fix does not say, m/s.
    pub horizontal_velocity_sigma_mps: f64,
    /// One-sigma of vertical velocity where a fix does not say, m/s.
    pub vertical_velocity_sigma_mps: f64,
    /// Least one-sigma of the white part of position, m.
    pub position_floor_m: f64,
    /// Least one-sigma of the white part of velocity, m/s.
    pub velocity_floor_mps: f64,
    /// Share of the position's one-sigma that wanders slowly, 0 to 1.
    pub position_wander_share: f64,
    /// Correlation time of the position's slow error, s.
    pub position_wander_time_s: f64,
    /// Share of the velocity's one-sigma that wanders slowly, 0 to 1.
    pub velocity_wander_share: f64,
    /// Correlation time of the velocity's slow error, s.
    pub velocity_wander_time_s: f64,
    /// Time over which a receiver may have taken its velocity, one-sigma, s.
    pub velocity_smoothing_s: f64,
    /// Share by which one innovation moves a one-sigma that no fix states, 0 to 1.
    pub learning_rate: f64,
    /// One-sigma of the time between a fix's position and its velocity, s.
    pub position_latency_sigma_s: f64,
    /// One-sigma of the time by which a fix holds earlier than declared, s.
    pub delay_sigma_s: f64,
}

/// Errors of an attitude reference.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct AttitudeModel {
    /// Shortest time between two uses, s.
    pub interval_s: f64,
    /// One-sigma of its slow error in roll and pitch, rad.
    pub tilt_wander_rad: f64,
    /// One-sigma of its slow error in heading, rad.
    pub heading_wander_rad: f64,
    /// Correlation time of its slow error, s.
    pub wander_time_s: f64,
    /// One-sigma of its white error, rad.
    pub noise_rad: f64,
}

/// Errors of a heading from a magnetometer.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct MagnetometerModel {
    /// Shortest time between two uses, s.
    pub interval_s: f64,
    /// One-sigma of its slow error, rad.
    pub heading_wander_rad: f64,
    /// Correlation time of its slow error, s.
    pub wander_time_s: f64,
    /// One-sigma of its white error, rad.
    pub noise_rad: f64,
}

/// Errors of a barometric height.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct BaroModel {
    /// One-sigma of its white error, m.
    pub noise_m: f64,
    /// One-sigma of its slow error, m.
    pub wander_m: f64,
    /// Correlation time of its slow error, s.
    pub wander_time_s: f64,
}

/// When a measurement is refused, and when a filter that refuses everything is reopened.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GateModel {
    /// Innovations beyond this many one-sigma are refused.
    pub sigmas: f64,
    /// Refused after an absence or after trouble with the inertial samples, s.
    pub recovery_s: f64,
    /// Positions refused that jumped while velocity goes on agreeing, s.
    pub fault_s: f64,
    /// Anything else refused without a break, s.
    pub lockout_s: f64,
}

/// Everything about the estimator. hovernav_default_config() fills it in; change what is known better.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Config {
    /// The inertial unit from the point of the solution (such as the centre of gravity), body axes, m.
    pub imu_lever_arm_m: [f64; 3],
    /// The GPS antenna from the same point, body axes, m.
    pub antenna_lever_arm_m: [f64; 3],
    /// 1 if the unit's own attitude is used once aligned, else 0.
    pub use_attitude: u32,
    /// 1 if the magnetometer is used where the unit's own attitude is not, else 0.
    pub use_magnetometer: u32,
    /// 1 if the barometer is used, else 0.
    pub use_baro: u32,
    /// 1 if the rangefinder is used, else 0.
    pub use_rangefinder: u32,
    /// 1 if the heading of two antennas is used, else 0.
    pub use_second_antenna: u32,
    /// How it starts.
    pub alignment: Alignment,
    /// Inertial sensors.
    pub imu: ImuModel,
    /// GPS.
    pub gps: GpsModel,
    /// The unit's own attitude.
    pub attitude: AttitudeModel,
    /// Magnetometer.
    pub magnetometer: MagnetometerModel,
    /// Barometer.
    pub baro: BaroModel,
    /// Gates and recovery.
    pub gate: GateModel,
    /// The rangefinder.
    pub rangefinder: Rangefinder,
    /// The second antenna.
    pub second_antenna: SecondAntenna,
    /// The notch before the estimator.
    pub notch: Notch,
    /// What hovernav_get_health() finds good enough.
    pub health: HealthLimits,
}

mirror!(ImuModel, core_ekf::ImuModel {
    angle_random_walk_rad velocity_random_walk_mps gyro_vibration_share accel_vibration_share
    accel_vibration_time_s gyro_bias_sigma_radps gyro_bias_time_s accel_bias_sigma_mps2
    accel_bias_time_s gyro_scale_sigma accel_scale_sigma turn_error_share turn_error_time_s
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

/// A configuration that was checked.
#[derive(Clone, Copy, Debug)]
pub struct Checked {
    /// Of the estimator.
    pub estimator: EstimatorConfig,
    /// Of the notch before it, where there is one.
    pub notch: Option<NotchConfig>,
    /// What is good enough to fly by.
    pub health: CoreHealthLimits,
}

impl Config {
    /// The structure of a configuration of the core.
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
            alignment: Alignment::of(&estimator.alignment),
            imu: (&ekf.imu).into(),
            gps: (&ekf.gps).into(),
            attitude: (&ekf.attitude).into(),
            magnetometer: (&ekf.magnetometer).into(),
            baro: (&ekf.baro).into(),
            gate: (&ekf.gate).into(),
            rangefinder: Rangefinder::of(estimator),
            second_antenna: SecondAntenna::of(estimator),
            notch: Notch::of(notch),
            health: health.into(),
        }
    }

    /// The core's configuration.
    ///
    /// # Errors
    /// [`Fault`] names the first value that cannot be.
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
        let wrong = [
            ("imu.", ekf.imu.out_of_range()),
            ("gps.", ekf.gps.out_of_range()),
            ("attitude.", ekf.attitude.out_of_range()),
            ("magnetometer.", ekf.magnetometer.out_of_range()),
            ("baro.", ekf.baro.out_of_range()),
            ("gate.", ekf.gate.out_of_range()),
            ("rangefinder.model.", estimator.rangefinder.model.out_of_range()),
            ("second_antenna.model.", estimator.antenna_heading.out_of_range()),
        ];
        for (group, wrong) in wrong {
            if let Some((key, found, expected)) = wrong {
                return Err(Fault::new(&[group, key], found, expected));
            }
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

/// Fills `config` with the defaults: a consumer or tactical-grade MEMS unit on a vibrating vehicle, a
/// stand-alone GPS, no lever arms. `abi` is HOVERNAV_ABI; where the library's is another, nothing is
/// written and HOVERNAV_STATUS_ABI_MISMATCH comes back.
///
/// # Safety
/// Pointers as the crate's rules say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_default_config(config: *mut Config, abi: u32) -> Status {
    if abi != HOVERNAV_ABI {
        return Status::AbiMismatch;
    }
    // SAFETY: the caller's promise.
    let place = unsafe { output(config) };
    Status::of(place.map(|place| {
        place.write(Config::of(&EstimatorConfig::default(), None, &CoreHealthLimits::default()));
    }))
}

/// Whether one can navigate with `config`; `fault`, unless null, receives the first value that is out of
/// its range.
///
/// # Safety
/// Pointers as the crate's rules say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_check_config(config: *const Config, fault: *mut Fault) -> Status {
    // SAFETY: the caller's promise.
    let config = unsafe { input(config) };
    // SAFETY: the caller's promise.
    let fault = unsafe { optional(fault) };
    Status::of(config.and_then(|config| {
        let fault = fault?;
        config.checked().map(|_| ()).map_err(|wrong| Status::refuse(wrong, fault))
    }))
}
