//! The messages that are read, and the fields of each with their units.

use crate::choice::{is_alive, is_fix};
use hovernav_dataset::Dimensions;

/// A message of ArduPilot, or of PX4 logs in the same format from before 2017.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Message {
    /// Angular rates and specific forces, mostly instantaneous values.
    Imu,
    /// Increments of angle and velocity.
    Imt,
    Gps,
    GpsAccuracy,
    Baro,
    Rangefinder,
    Magnetometer,
    RcIn,
    /// Outputs of the rate controller to the mixer.
    Rate,
    /// Pulses to the motors.
    RcOut,
    /// Start of a system identification, with its axis.
    SidSettings,
    /// Signal that a system identification injects.
    SidData,
    Attitude,
    Quaternion,
    Velocity,
    Position,
    Innovations,
    /// State of a core of the EKF, with the number of the primary core.
    Core,
    /// Sensors that a core of the EKF uses.
    Selection,
    /// PX4: the time of the messages that follow.
    Time,
}

/// Factor for a field in thousandths of hovernav's unit.
const MILLI: f64 = 1e-3;
/// Factor for a field in millionths of hovernav's unit.
const MICRO: f64 = 1e-6;
/// Factor for a field in hovernav's unit.
const ONE: f64 = 1.0;
/// Times: that of [`Message::Time`], and the alternatives of all others.
static TIMES: [(&str, f64); 3] = [("StartTime", MICRO), ("TimeUS", MICRO), ("TimeMS", MILLI)];

impl Message {
    /// Number of columns, at least those of the widest message.
    pub const WIDTH: usize = 22;

    const ALL: [Self; 20] = [
        Self::Imu,
        Self::Imt,
        Self::Gps,
        Self::GpsAccuracy,
        Self::Baro,
        Self::Rangefinder,
        Self::Magnetometer,
        Self::RcIn,
        Self::Rate,
        Self::RcOut,
        Self::SidSettings,
        Self::SidData,
        Self::Attitude,
        Self::Quaternion,
        Self::Velocity,
        Self::Position,
        Self::Innovations,
        Self::Core,
        Self::Selection,
        Self::Time,
    ];

    /// The names of the message. Numbered instances have the name without the number.
    const fn names(self) -> &'static [&'static str] {
        match self {
            Self::Imu => &["IMU"],
            Self::Imt => &["IMT"],
            Self::Gps => &["GPS"],
            Self::GpsAccuracy => &["GPA"],
            Self::Baro => &["BARO", "BAR"],
            Self::Rangefinder => &["RFND"],
            Self::Magnetometer => &["MAG"],
            Self::RcIn => &["RCIN"],
            Self::Rate => &["RATE"],
            Self::RcOut => &["RCOU"],
            Self::SidSettings => &["SIDS"],
            Self::SidData => &["SIDD"],
            Self::Attitude => &["ATT"],
            Self::Quaternion => &["XKQ", "NKQ"],
            Self::Velocity => &["XKF1", "NKF1", "EKF1"],
            Self::Position => &["POS"],
            Self::Innovations => &["XKF3", "NKF3", "EKF3"],
            Self::Core => &["XKF4", "NKF4"],
            Self::Selection => &["XKFS"],
            Self::Time => &["TIME"],
        }
    }

    /// The first name of the message.
    pub const fn name(self) -> &'static str {
        self.names()[0]
    }

    /// The message with this `name`, and the instance in the name: `IMU2` is instance 1.
    pub fn named(name: &str) -> Option<(Self, usize)> {
        Self::ALL.into_iter().find_map(|message| {
            if message.names().contains(&name) {
                return Some((message, 0));
            }
            let counts = matches!(
                message,
                Self::Imu
                    | Self::Imt
                    | Self::Gps
                    | Self::GpsAccuracy
                    | Self::Baro
                    | Self::Magnetometer
                    | Self::Quaternion
            );
            let number = message.names().iter().find_map(|known| name.strip_prefix(known));
            let number: usize = number.filter(|_| counts)?.parse().ok()?;
            (1..=9).contains(&number).then(|| (message, number - 1))
        })
    }

    /// Whether `row` has a measurement that may be used, by the autopilot's own health flags and by its values.
    pub fn is_good(self, row: &[f64]) -> bool {
        // The flags are NaN in logs without them.
        let is_healthy = |flags: &[f64]| !flags.contains(&0.0);
        match self {
            Self::Imu => is_healthy(&row[14..16]) && is_alive([row[5], row[6], row[7]]),
            Self::Imt => is_alive([row[5], row[6], row[7]]),
            Self::Gps => {
                let fix_type = if row[3].is_nan() { row[4] } else { row[3] };
                is_fix(Dimensions::of_type(fix_type), Self::place_and_velocity(row).0)
            }
            Self::Baro => is_healthy(&row[3..5]) && row[2].is_finite(),
            Self::Magnetometer => is_healthy(&row[5..6]) && is_alive([row[2], row[3], row[4]]),
            _ => true,
        }
    }

    /// Number of errors of the gyros and accelerometers since the start, of a message with counters.
    pub fn errors(self, row: &[f64]) -> Option<f64> {
        let counters = (self == Self::Imu).then(|| &row[16..18])?;
        Some(counters.iter().filter(|count| count.is_finite()).sum())
    }

    /// The values that change from each measurement to the next.
    pub fn reading(self, row: &[f64]) -> &[f64] {
        match self {
            Self::Imu => &row[2..11],
            Self::Imt => &row[2..8],
            _ => &[],
        }
    }

    /// Latitude and longitude in a row of `GPS`, degrees, and the velocity north and east, or the speed and NaN, m/s.
    pub fn place_and_velocity(row: &[f64]) -> ([f64; 2], [f64; 2]) {
        let or = |one: f64, other: f64| if one.is_nan() { other } else { one };
        let velocity = if row[12].is_nan() { [row[9], f64::NAN] } else { [row[12], row[13]] };
        ([row[5], or(row[6], row[7])], velocity)
    }

    /// The fields that are read, in the order that [`super::rows`] expects: the alternative times first. Each has a
    /// factor to seconds, metres or gauss, for logs that do not state one.
    pub fn columns(self) -> impl Iterator<Item = &'static (&'static str, f64)> {
        let times = if self == Self::Time { &TIMES[..1] } else { &TIMES[1..] };
        times.iter().chain(self.readings())
    }

    const fn readings(self) -> &'static [(&'static str, f64)] {
        match self {
            Self::Imu => &[
                ("GyrX", ONE),
                ("GyrY", ONE),
                ("GyrZ", ONE),
                ("AccX", ONE),
                ("AccY", ONE),
                ("AccZ", ONE),
                ("GyroX", ONE),
                ("GyroY", ONE),
                ("GyroZ", ONE),
                ("MagX", ONE),
                ("MagY", ONE),
                ("MagZ", ONE),
                ("GH", ONE),
                ("AH", ONE),
                ("EG", ONE),
                ("EA", ONE),
            ],
            Self::Imt => &[
                ("DelAX", ONE),
                ("DelAY", ONE),
                ("DelAZ", ONE),
                ("DelVX", ONE),
                ("DelVY", ONE),
                ("DelVZ", ONE),
                ("DelaT", ONE),
                ("DelvT", ONE),
            ],
            Self::Gps => &[
                ("T", MILLI),
                ("Status", ONE),
                ("FixType", ONE),
                ("Lat", ONE),
                ("Lng", ONE),
                ("Lon", ONE),
                ("Alt", ONE),
                ("Spd", ONE),
                ("GCrs", ONE),
                ("VZ", ONE),
                ("VelN", ONE),
                ("VelE", ONE),
                ("VelD", ONE),
                ("NSats", ONE),
                ("GWk", ONE),
                ("GMS", MILLI),
                ("EPH", ONE),
                ("EPV", ONE),
                ("Yaw", ONE),
                ("U", ONE),
            ],
            Self::GpsAccuracy => {
                &[("HAcc", ONE), ("VAcc", ONE), ("SAcc", ONE), ("VV", ONE), ("YAcc", ONE)]
            }
            Self::Baro => &[("Alt", ONE), ("Health", ONE), ("H", ONE)],
            Self::Rangefinder => {
                &[("Dist", ONE), ("Dist1", ONE), ("Stat", ONE), ("Orient", ONE), ("Quality", ONE)]
            }
            Self::Magnetometer => {
                &[("MagX", MILLI), ("MagY", MILLI), ("MagZ", MILLI), ("Health", ONE)]
            }
            Self::Rate => &[("ROut", ONE), ("POut", ONE), ("AOut", ONE), ("YOut", ONE)],
            Self::SidSettings => &[("Ax", ONE)],
            Self::SidData => &[("Targ", ONE)],
            Self::RcIn | Self::RcOut => &[("C1", ONE), ("C2", ONE), ("C3", ONE), ("C4", ONE)],
            Self::Attitude => &[("Roll", ONE), ("Pitch", ONE), ("Yaw", ONE), ("RollRate", ONE)],
            Self::Quaternion => &[("Q1", ONE), ("Q2", ONE), ("Q3", ONE), ("Q4", ONE)],
            Self::Velocity => &[("VN", ONE), ("VE", ONE), ("VD", ONE)],
            Self::Position => &[("Lat", ONE), ("Lng", ONE), ("Alt", ONE)],
            Self::Innovations => &[
                ("IPN", ONE),
                ("IPE", ONE),
                ("IPD", ONE),
                ("IVN", ONE),
                ("IVE", ONE),
                ("IVD", ONE),
                ("IYAW", ONE),
            ],
            Self::Core => &[("PI", ONE)],
            Self::Selection => &[("MI", ONE), ("BI", ONE), ("GI", ONE)],
            Self::Time => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Message;

    #[test]
    fn instances_are_counted_by_name() {
        assert_eq!(Message::named("IMU"), Some((Message::Imu, 0)));
        assert_eq!(Message::named("IMU3"), Some((Message::Imu, 2)));
        assert_eq!(Message::named("BAR2"), Some((Message::Baro, 1)));
        assert_eq!(Message::named("NKQ1"), Some((Message::Quaternion, 0)));
        assert_eq!(Message::named("NKF1"), Some((Message::Velocity, 0)));
        for other in ["NKF2", "IMUX", "IMU0", "ATT2", "GPSB", ""] {
            assert_eq!(Message::named(other), None, "{other}");
        }
        assert!(Message::ALL.iter().all(|message| message.columns().count() <= Message::WIDTH));
    }
}
