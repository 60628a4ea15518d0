//! Conversion from counts to physical units, with the ranges and signs that packets do not contain.
//!
//! Source: Crossbow, *AHRS Series User's Manual*, 7430-0004-01, pages 5, 14 and 24.

use core::fmt;

use super::packet::{AnglePacket, Packet, ScaledPacket};
use crate::earth::STANDARD_GRAVITY_MPS2;
use crate::frames::{Body, EulerAngles, Vector, wrap_angle};
use crate::imu::{ImuSample, Motion};
use crate::scalar::Readable;
use crate::time::Time;

/// Fraction of the rated range per count of a rate or acceleration word. The 16 bits of the word span ±1.5 times the
/// rated range.
const FULL_SCALE: f64 = 1.5 / 32_768.0;

/// Magnetic field per count, gauss: full scale is 1.5 × 1.25 gauss.
const GAUSS_PER_COUNT: f64 = 1.25 * FULL_SCALE;

const RADIANS_PER_COUNT: f64 = core::f64::consts::PI / 32_768.0;

/// Sign convention of an accelerometer's word in a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// The word is positive for specific force along the axis.
    Positive,
    /// The word is positive for specific force against the axis.
    Negative,
}

/// An invalid range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeError {
    /// Name of the range, with its unit.
    pub range: &'static str,
    /// The value given.
    pub found: f64,
}

impl fmt::Display for RangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: found {}, expected a number above 0", self.range, Readable(self.found))
    }
}

impl core::error::Error for RangeError {}

/// Ranges and signs of one inertial unit, from its label; packets do not contain them.
///
/// ```
/// use hovernav::dmu::{AnglePacket, Calibration, Packet};
/// let calibration = Calibration::new(200.0, 4.0)?;
/// let level = AnglePacket { acceleration: [0, 0, 0x1555], ..Default::default() };
/// let measurement = calibration.measure(&Packet::Angle(level)).unwrap();
/// assert!((measurement.specific_force_mps2.z() + 9.806).abs() < 1e-3);
/// # Ok::<(), hovernav::dmu::RangeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    rate_radps_per_count: f64,
    acceleration_mps2_per_count: [f64; 3],
}

impl Calibration {
    /// Calibration of an inertial unit with the rated ranges ±`rate_range_degps` (deg/s; 100 or 200) and
    /// ±`acceleration_range_g` (standard gravity; 2 or 4). Both are on its label or calibration sheet.
    ///
    /// The default is [`Sign::Negative`] for all accelerometers: level and at rest the inertial unit outputs +1 g down,
    /// where specific force is −1 g. The manual does not define the sign of linear acceleration. To check it, push the
    /// inertial unit along its axes. Set axes with another sign by [`Calibration::with_acceleration_signs`].
    ///
    /// # Errors
    /// [`RangeError`] for a range that is not a positive finite number.
    pub fn new(rate_range_degps: f64, acceleration_range_g: f64) -> Result<Self, RangeError> {
        let positive = |range, found: f64| {
            (found.is_finite() && found > 0.0).then_some(found).ok_or(RangeError { range, found })
        };
        let rate_degps = positive("rate range in deg/s", rate_range_degps)?;
        let acceleration_g = positive("acceleration range in g", acceleration_range_g)?;
        Ok(Self {
            rate_radps_per_count: (rate_degps * FULL_SCALE).to_radians(),
            acceleration_mps2_per_count: [-acceleration_g * FULL_SCALE * STANDARD_GRAVITY_MPS2; 3],
        })
    }

    /// The same calibration with the accelerometer signs `signs` of x, y and z.
    #[must_use]
    pub fn with_acceleration_signs(mut self, signs: [Sign; 3]) -> Self {
        for (scale, sign) in self.acceleration_mps2_per_count.iter_mut().zip(signs) {
            *scale = match sign {
                Sign::Positive => libm::fabs(*scale),
                Sign::Negative => -libm::fabs(*scale),
            };
        }
        self
    }

    /// Converts a packet of angle or scaled mode to physical units. `None` for voltage mode, whose volts have no fixed
    /// scale.
    ///
    /// # Source
    /// Equation (D1) of docs/equations.md.
    #[must_use]
    pub fn measure(&self, packet: &Packet) -> Option<Measurement> {
        match *packet {
            Packet::Voltage(_) => None,
            Packet::Scaled(packet) => Some(self.measure_scaled(packet)),
            Packet::Angle(AnglePacket {
                attitude,
                angular_rate,
                acceleration,
                magnetic_field,
                temperature,
                timer,
            }) => {
                let [roll_rad, pitch_rad, yaw_rad] =
                    attitude.map(|count| wrap_angle(f64::from(count) * RADIANS_PER_COUNT));
                let scaled =
                    ScaledPacket { angular_rate, acceleration, magnetic_field, temperature, timer };
                Some(Measurement {
                    attitude: Some(EulerAngles { roll_rad, pitch_rad, yaw_rad }),
                    ..self.measure_scaled(scaled)
                })
            }
        }
    }

    /// The packet that an inertial unit would send for `measurement`, with timer 0: the inverse of
    /// [`Calibration::measure`] to within half a count. Values beyond full scale saturate. NaN and an unknown attitude
    /// become 0.
    ///
    /// ```
    /// use hovernav::dmu::{Calibration, Packet};
    /// # use hovernav::dmu::AnglePacket;
    /// # let packet = AnglePacket { acceleration: [3, -4, 0x1555], temperature: 1587, ..Default::default() };
    /// let calibration = Calibration::new(200.0, 4.0)?;
    /// let measurement = calibration.measure(&Packet::Angle(packet)).unwrap();
    /// assert_eq!(calibration.counts(&measurement), packet);
    /// # Ok::<(), hovernav::dmu::RangeError>(())
    /// ```
    #[must_use]
    pub fn counts(&self, measurement: &Measurement) -> AnglePacket {
        // A cast saturates, and turns NaN into 0.
        let words = |vector: Vector<Body>, scales: [f64; 3]| {
            let ([x, y, z], [x_scale, y_scale, z_scale]) = (vector.to_array(), scales);
            [x / x_scale, y / y_scale, z / z_scale].map(|count| libm::round(count) as i16)
        };
        let angles = measurement
            .attitude
            .map_or([0.0; 3], |angles| [angles.roll_rad, angles.pitch_rad, angles.yaw_rad]);
        let temperature = (measurement.temperature_degc / 44.44 + 1.375) * 4096.0 / 5.0;
        AnglePacket {
            // 180° equals −180°: words of angles wrap, other words saturate.
            attitude: angles.map(|angle| libm::round(angle / RADIANS_PER_COUNT) as i32 as i16),
            angular_rate: words(measurement.angular_rate_radps, [self.rate_radps_per_count; 3]),
            acceleration: words(measurement.specific_force_mps2, self.acceleration_mps2_per_count),
            magnetic_field: words(measurement.magnetic_field_gauss, [GAUSS_PER_COUNT; 3]),
            temperature: (libm::round(temperature) as u16).min(0x0FFF),
            timer: 0,
        }
    }

    fn measure_scaled(&self, packet: ScaledPacket) -> Measurement {
        let [ax, ay, az] = packet.acceleration.map(f64::from);
        let [scale_x, scale_y, scale_z] = self.acceleration_mps2_per_count;
        let vector = |counts: [i16; 3]| Vector::from(counts.map(f64::from));
        Measurement {
            angular_rate_radps: vector(packet.angular_rate) * self.rate_radps_per_count,
            specific_force_mps2: Vector::new(ax * scale_x, ay * scale_y, az * scale_z),
            magnetic_field_gauss: vector(packet.magnetic_field) * GAUSS_PER_COUNT,
            attitude: None,
            temperature_degc: temperature_degc(packet.temperature),
        }
    }
}

/// One packet in physical units and in the inertial unit's axes: x away from the connector, y from left to right along
/// the connector's face, z down. If the inertial unit is mounted with x forward and z down, these are the body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Angular rate, rad/s.
    pub angular_rate_radps: Vector<Body>,
    /// Specific force, m/s².
    pub specific_force_mps2: Vector<Body>,
    /// Magnetic field, gauss.
    pub magnetic_field_gauss: Vector<Body>,
    /// The inertial unit's own attitude, in angle mode; yaw is relative to magnetic north.
    pub attitude: Option<EulerAngles>,
    /// Sensor temperature, °C.
    pub temperature_degc: f64,
}

impl Measurement {
    /// The measurement as an input of the filter, sampled at `time`.
    #[must_use]
    pub const fn at(&self, time: Time) -> ImuSample {
        ImuSample {
            attitude: self.attitude,
            magnetic_field_gauss: Some(self.magnetic_field_gauss),
            ..ImuSample::new(
                time,
                Motion::Rates {
                    angular_rate_radps: self.angular_rate_radps,
                    specific_force_mps2: self.specific_force_mps2,
                },
            )
        }
    }
}

/// Volts of a voltage-mode word or of a temperature word: a 12-bit converter of 5 V.
#[must_use]
pub fn volts(counts: u16) -> f64 {
    f64::from(counts) * 5.0 / 4096.0
}

/// Sensor temperature, °C, from the temperature word of any mode.
#[must_use]
pub fn temperature_degc(counts: u16) -> f64 {
    (volts(counts) - 1.375) * 44.44
}
