//! Settings of the two serial lines: inertial unit and GPS receiver.

use hovernav::dmu::{Calibration, Flow, Mode, Sign};
use hovernav::gps::Protocol;
use hovernav::gps::quality::Limits as CoreLimits;
use hovernav::sensors::{DmuConfig, GpsConfig};

use super::{flag, within};
use crate::access::output;
use crate::object::HOVERNAV_ABI;
use crate::status::{Fault, Status};

/// In HovernavLinesConfig.dmu_mode: rates, accelerations and magnetic field.
pub const HOVERNAV_DMU_SCALED: u32 = 1;
/// In HovernavLinesConfig.dmu_mode: rates, accelerations, magnetic field and the inertial unit's own attitude.
pub const HOVERNAV_DMU_ANGLE: u32 = 2;

/// In HovernavLinesConfig.gps_protocol: Trimble Standard Interface Protocol.
pub const HOVERNAV_GPS_TSIP: u32 = 1;
/// In HovernavLinesConfig.gps_protocol: NMEA 0183 sentences.
pub const HOVERNAV_GPS_NMEA: u32 = 2;
/// In HovernavLinesConfig.gps_protocol: u-blox binary.
pub const HOVERNAV_GPS_UBX: u32 = 3;

/// Limits of a receiver's fix.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct FixLimits {
    /// 1 if a fix whose height is held or assumed is rejected, else 0.
    pub need_three_dimensions: u32,
    /// Smallest number of satellites used, 0 to 255.
    pub min_satellites: u32,
    /// Largest dilution of precision of position.
    pub max_position_dilution: f64,
    /// Largest horizontal dilution of precision.
    pub max_horizontal_dilution: f64,
    /// Largest one-sigma of horizontal position, m.
    pub max_horizontal_sigma_m: f64,
    /// Largest one-sigma of height, m.
    pub max_vertical_sigma_m: f64,
    /// Largest one-sigma of velocity on any axis, m/s.
    pub max_velocity_sigma_mps: f64,
    /// Largest ground speed of the vehicle, m/s.
    pub max_ground_speed_mps: f64,
    /// Largest climb or sink rate of the vehicle, m/s.
    pub max_vertical_speed_mps: f64,
    /// Largest jump of a position, m: distance from the last good fix minus the distance that the vehicle can travel.
    pub max_jump_m: f64,
    /// Largest delay of a fix, s, relative to the most prompt recent fix.
    pub max_delay_s: f64,
}

/// Settings of the two serial lines: a Crossbow DMU-HDX-AHRS, and a receiver. With only one of the two sensors, leave
/// the settings of the other sensor at their defaults and never call its function.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct LinesConfig {
    /// Packet type that the inertial unit sends: one of HOVERNAV_DMU_.
    pub dmu_mode: u32,
    /// Time between requests for a packet, s; with 0 the inertial unit sends as fast as it can.
    pub dmu_cycle_s: f64,
    /// Latency from the moment of a sample to the arrival of its packet's last byte, s.
    pub dmu_latency_s: f64,
    /// Rated range of the gyros, deg/s.
    pub rate_range_degps: f64,
    /// Rated range of the accelerometers, standard gravity.
    pub accel_range_g: f64,
    /// Signs of the accelerometers x, y, z: 1 if the output counts along the axis, -1 if it counts against the axis.
    pub accel_signs: [i32; 3],
    /// Protocol of the receiver: one of HOVERNAV_GPS_.
    pub gps_protocol: u32,
    /// Fix rate for the receiver, Hz, 1 to 10; 0 leaves the receiver as it is.
    pub gps_rate_hz: u32,
    /// Latency from the validity of a fix to its arrival, s.
    pub gps_latency_s: f64,
    /// 1 if geoid_separation_m is used, for a receiver that does not send it, else 0.
    pub has_geoid_separation: u32,
    /// The geoid's height above the ellipsoid at the site, m.
    pub geoid_separation_m: f64,
    /// Limits that a fix must meet.
    pub fix_limits: FixLimits,
}

impl FixLimits {
    fn of(core: &CoreLimits) -> Self {
        Self {
            need_three_dimensions: u32::from(core.need_three_dimensions),
            min_satellites: u32::from(core.min_satellites),
            max_position_dilution: core.max_position_dilution,
            max_horizontal_dilution: core.max_horizontal_dilution,
            max_horizontal_sigma_m: core.max_horizontal_sigma_m,
            max_vertical_sigma_m: core.max_vertical_sigma_m,
            max_velocity_sigma_mps: core.max_velocity_sigma_mps,
            max_ground_speed_mps: core.max_ground_speed_mps,
            max_vertical_speed_mps: core.max_vertical_speed_mps,
            max_jump_m: core.max_jump_m,
            max_delay_s: core.max_delay_s,
        }
    }

    fn core(&self) -> Result<CoreLimits, Fault> {
        within!("fix_limits.", self, 0.0, 1e9, "0 to 1e9";
            max_position_dilution max_horizontal_dilution max_horizontal_sigma_m
            max_vertical_sigma_m max_velocity_sigma_mps max_ground_speed_mps
            max_vertical_speed_mps max_jump_m max_delay_s);
        Ok(CoreLimits {
            need_three_dimensions: flag(
                "fix_limits.need_three_dimensions",
                self.need_three_dimensions,
            )?,
            min_satellites: small("fix_limits.min_satellites", self.min_satellites, "0 to 255")?,
            max_position_dilution: self.max_position_dilution,
            max_horizontal_dilution: self.max_horizontal_dilution,
            max_horizontal_sigma_m: self.max_horizontal_sigma_m,
            max_vertical_sigma_m: self.max_vertical_sigma_m,
            max_velocity_sigma_mps: self.max_velocity_sigma_mps,
            max_ground_speed_mps: self.max_ground_speed_mps,
            max_vertical_speed_mps: self.max_vertical_speed_mps,
            max_jump_m: self.max_jump_m,
            max_delay_s: self.max_delay_s,
        })
    }
}

fn small(what: &str, found: u32, expected: &str) -> Result<u8, Fault> {
    u8::try_from(found).map_err(|_| Fault::new(&[what], f64::from(found), expected))
}

/// Reason why the serial lines cannot be started: a value out of range, or a protocol that was not built in.
pub(crate) enum LinesFault {
    Value(Fault),
    NotBuilt,
}

impl From<Fault> for LinesFault {
    fn from(fault: Fault) -> Self {
        Self::Value(fault)
    }
}

impl LinesConfig {
    fn default_values() -> Self {
        Self {
            dmu_mode: HOVERNAV_DMU_ANGLE,
            dmu_cycle_s: 0.0303,
            dmu_latency_s: Mode::Angle.transfer_time_s(),
            rate_range_degps: 200.0,
            accel_range_g: 4.0,
            accel_signs: [-1; 3],
            gps_protocol: HOVERNAV_GPS_NMEA,
            gps_rate_hz: 0,
            gps_latency_s: 0.12,
            has_geoid_separation: 0,
            geoid_separation_m: 0.0,
            fix_limits: FixLimits::of(&CoreLimits::default()),
        }
    }

    fn protocol(&self) -> Result<Protocol, LinesFault> {
        /// The protocol; `None` if its feature was not built in.
        macro_rules! built {
            ($feature:literal, $protocol:ident) => {{
                #[cfg(feature = $feature)]
                let built = Some(Protocol::$protocol);
                #[cfg(not(feature = $feature))]
                let built = None;
                built
            }};
        }
        let built = match self.gps_protocol {
            HOVERNAV_GPS_TSIP => built!("tsip", Tsip),
            HOVERNAV_GPS_NMEA => built!("nmea", Nmea),
            HOVERNAV_GPS_UBX => built!("ubx", Ubx),
            other => {
                let found = f64::from(other);
                return Err(Fault::new(&["gps_protocol"], found, "one of HOVERNAV_GPS_").into());
            }
        };
        built.ok_or(LinesFault::NotBuilt)
    }

    fn calibration(&self) -> Result<Calibration, Fault> {
        within!("", self, 1e-3, 1e6, "0.001 to 1e6"; rate_range_degps accel_range_g);
        let calibration = Calibration::new(self.rate_range_degps, self.accel_range_g)
            .map_err(|error| Fault::new(&[error.range], error.found, "a positive number"))?;
        let mut signs = [Sign::Negative; 3];
        for (sign, &given) in signs.iter_mut().zip(&self.accel_signs) {
            *sign = match given {
                1 => Sign::Positive,
                -1 => Sign::Negative,
                other => return Err(Fault::new(&["accel_signs"], f64::from(other), "1 or -1")),
            };
        }
        Ok(calibration.with_acceleration_signs(signs))
    }

    pub(crate) fn core(&self) -> Result<(DmuConfig, GpsConfig), LinesFault> {
        within!("", self, 0.0, 10.0, "0 to 10 s"; dmu_cycle_s dmu_latency_s gps_latency_s);
        within!("", self, -1e3, 1e3, "-1000 to 1000 m"; geoid_separation_m);
        let mode = match self.dmu_mode {
            HOVERNAV_DMU_SCALED => Mode::Scaled,
            HOVERNAV_DMU_ANGLE => Mode::Angle,
            other => {
                let found = f64::from(other);
                return Err(Fault::new(&["dmu_mode"], found, "one of HOVERNAV_DMU_").into());
            }
        };
        let cycle_s = self.dmu_cycle_s;
        let dmu = DmuConfig {
            mode,
            flow: if cycle_s > 0.0 { Flow::Polled { cycle_s } } else { Flow::Continuous },
            calibration: self.calibration()?,
            latency_s: self.dmu_latency_s,
        };
        let rate_hz = small("gps_rate_hz", self.gps_rate_hz, "0 to 10")?;
        if rate_hz > 10 {
            return Err(Fault::new(&["gps_rate_hz"], f64::from(rate_hz), "0 to 10").into());
        }
        let gps = GpsConfig {
            protocol: self.protocol()?,
            rate_hz: (rate_hz > 0).then_some(rate_hz),
            latency_s: self.gps_latency_s,
            geoid_separation_m: flag("has_geoid_separation", self.has_geoid_separation)?
                .then_some(self.geoid_separation_m),
            limits: self.fix_limits.core()?,
        };
        Ok((dmu, gps))
    }
}

/// Sets `config` to the defaults. The inertial unit has ranges of 200 deg/s and 4 g, and is polled in angle mode every
/// 30.3 ms. The receiver sends NMEA with a latency of 0.12 s. `abi` is HOVERNAV_ABI.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_default_lines_config(
    config: *mut LinesConfig,
    abi: u32,
) -> Status {
    if abi != HOVERNAV_ABI {
        return Status::AbiMismatch;
    }
    // SAFETY: guaranteed by the caller.
    Status::of(unsafe { output(config) }.map(|slot| slot.write(LinesConfig::default_values())))
}
