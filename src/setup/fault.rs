//! Mistakes in the set-up of sensors, with their messages.

use core::fmt;

use crate::earth::STANDARD_GRAVITY_MPS2;

/// A likely mistake in units, signs or axes of a sensor: see [`SetupCheck`](super::SetupCheck).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SetupFault {
    /// The mean specific force is far from gravity.
    ForceSize {
        /// Mean size, in the unit of the samples; m/s² expected.
        mean_mps2: f32,
        /// Likely cause of the wrong size.
        scale: ForceScale,
    },
    /// The mean specific force does not point up, along −z of axes forward, right, down.
    ForceDirection {
        /// Unit vector of the mean specific force in the axes of the samples.
        up: [f32; 3],
    },
    /// The gyros report fast tilts while gravity hardly turns: angular rates in °/s.
    RatesInDegrees {
        /// Tilt in half a second according to the gyros, rms, rad.
        reported_rad: f32,
        /// Turn of gravity in body axes in half a second, rms, rad.
        seen_rad: f32,
    },
    /// The gyros report turns to the wrong side: with the assumed signs the specific force explains the changes of the
    /// fixes' velocity, without them it does not.
    GyroSigns {
        /// Whether a roll or pitch rate has the wrong sign, or roll and pitch rate are swapped.
        tilts: bool,
        /// Whether the yaw rate has the wrong sign.
        yaw: bool,
    },
    /// An axis of the inertial unit is always zero while the others measure.
    DeadAxis {
        /// Whether it is an axis of the gyros; otherwise it is one of the accelerometers.
        is_gyro: bool,
        /// Index of the axis: x, y, z.
        axis: u8,
    },
    /// Heights change faster than the vertical velocity: they are not in metres.
    HeightScale {
        /// Ratio of the changes of height to the changes according to the velocity: 3.28 for heights in feet.
        factor: f32,
    },
    /// The vertical velocity is positive up: the fixes' heights change with the opposite sign of the reported down
    /// velocity.
    VelocityUp,
    /// Positions move north at the east velocity, and east at the north velocity.
    VelocitySwapped,
    /// Positions move against the velocity on one horizontal axis: west for east, or south for north.
    VelocityReversed {
        /// Whether the north velocity is reversed; otherwise the east velocity is.
        north: bool,
    },
    /// Positions move faster or slower than the velocity: the velocity is not in m/s.
    VelocityScale {
        /// Size of the velocity's unit, m/s: 0.514 for knots, 0.278 for km/h, 0.01 for cm/s.
        unit_mps: f32,
    },
    /// All velocities are zero, and the positions move.
    VelocityZero {
        /// Speed of the positions, m/s rms.
        speed_mps: f32,
    },
    /// Latitude and longitude are in radians instead of degrees.
    PositionInRadians,
}

/// Likely cause of a mean specific force far from gravity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ForceScale {
    /// Accelerations in g.
    InG,
    /// Accelerations in thousandths of g.
    InThousandthsOfG,
    /// Accelerations in m/s², multiplied by g.
    TimesG,
    /// Accelerations of a quarter, half, double or four times the right size: another range of the accelerometers.
    OtherRange {
        /// Ratio of the reported size to the right size.
        factor: f32,
    },
    /// Accelerations without gravity, which are not specific force.
    WithoutGravity,
    /// Accelerations in another unit or range.
    Unknown,
}

impl ForceScale {
    /// Likely cause of a mean specific force of the size `mean_mps2`.
    #[must_use]
    pub fn of(mean_mps2: f64) -> Self {
        const G: f64 = STANDARD_GRAVITY_MPS2;
        let near = |expected_mps2: f64| (0.85..1.2).contains(&(mean_mps2 / expected_mps2));
        let is_factor = |factor: &f32| near(f64::from(*factor) * G);
        if near(1.0) {
            Self::InG
        } else if near(1000.0) {
            Self::InThousandthsOfG
        } else if near(G * G) {
            Self::TimesG
        } else if let Some(factor) = [0.25, 0.5, 2.0, 4.0].into_iter().find(is_factor) {
            Self::OtherRange { factor }
        } else if mean_mps2 < 0.2 * G {
            Self::WithoutGravity
        } else {
            Self::Unknown
        }
    }
}

impl fmt::Display for ForceScale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::InG => "accelerations in g",
            Self::InThousandthsOfG => "accelerations in thousandths of g",
            Self::TimesG => "accelerations multiplied by g once too often",
            Self::OtherRange { .. } => "accelerometers with another range than assumed",
            Self::WithoutGravity => "accelerations without gravity, or in another unit",
            Self::Unknown => "accelerations in another unit",
        })
    }
}

impl SetupFault {
    /// Whether the fault concerns the receiver; otherwise it concerns the inertial unit.
    #[must_use]
    pub const fn is_of_receiver(&self) -> bool {
        matches!(
            self,
            Self::HeightScale { .. }
                | Self::VelocityUp
                | Self::VelocitySwapped
                | Self::VelocityReversed { .. }
                | Self::VelocityScale { .. }
                | Self::VelocityZero { .. }
                | Self::PositionInRadians
        )
    }
}

impl fmt::Display for SetupFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ForceSize { mean_mps2, scale } => write!(
                f,
                "mean specific force {mean_mps2:.2} m/s², expected about {STANDARD_GRAVITY_MPS2:.2}: {scale}"
            ),
            Self::ForceDirection { up: [x, y, z] } => write!(
                f,
                "mean specific force along ({x:.2}, {y:.2}, {z:.2}), expected −z: axes other than forward, right, down, \
                 or an inertial unit mounted on its side or back"
            ),
            Self::RatesInDegrees { reported_rad, seen_rad } => write!(
                f,
                "the gyros report tilts of {reported_rad:.1} rad in 0.5 s while gravity turns by {seen_rad:.2} rad: rates in \
                 °/s, expected rad/s"
            ),
            Self::GyroSigns { tilts, yaw } => f.write_str(match (tilts, yaw) {
                (true, true) => {
                    "the gyros turn to the wrong side: axes other than those of the accelerometers"
                }
                (_, false) => {
                    "the gyros tilt to the wrong side: x or y of the wrong sign, or x and y swapped"
                }
                (false, true) => "the gyros turn to the wrong side: z of the wrong sign",
            }),
            Self::DeadAxis { is_gyro, axis } => write!(
                f,
                "{} {} is always zero: not connected, or not logged",
                if *is_gyro { "gyro" } else { "accelerometer" },
                ["x", "y", "z"].get(usize::from(*axis)).unwrap_or(&"z")
            ),
            Self::HeightScale { factor } => write!(
                f,
                "heights change {factor:.2} times as fast as the vertical velocity: in another unit, expected m"
            ),
            Self::VelocityUp => f.write_str(
                "heights fall at the vertical velocity: positive up, expected positive down",
            ),
            Self::VelocitySwapped => {
                f.write_str("positions move north at the east velocity: north and east swapped")
            }
            Self::VelocityReversed { north } => write!(
                f,
                "positions move against the {} velocity: wrong sign",
                if *north { "north" } else { "east" }
            ),
            Self::VelocityScale { unit_mps } => write!(
                f,
                "positions move {unit_mps:.3} times as fast as the velocity: velocity in a unit of {unit_mps:.3} m/s, \
                 expected m/s"
            ),
            Self::VelocityZero { speed_mps } => write!(
                f,
                "velocities of zero while positions move at {speed_mps:.1} m/s: velocity not measured"
            ),
            Self::PositionInRadians => {
                f.write_str("latitude and longitude in radians, expected degrees")
            }
        }
    }
}
