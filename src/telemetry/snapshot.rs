//! Everything that one moment of a flight tells the ground.

use crate::controls::Channels;
use crate::earth::Geodetic;
use crate::ekf::{Channel as Compared, Innovation, Solution, Verdict};
use crate::frames::{Body, EulerAngles, Ned, Vector};
use crate::gps::{Correction, Dimension, ReceiverFix};
use crate::imu::{ImuSample, Motion};
use crate::time::Time;

/// Who flies, and how far the navigation has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Waiting for sensors.
    #[default]
    Starting,
    /// Sensors are there; attitude, position and biases are being found.
    Aligning,
    /// Navigating with the heading still to be found.
    SearchingHeading,
    /// Navigating; the pilot flies.
    Pilot,
    /// Navigating; the autopilot flies.
    Autopilot,
    /// Something that flying needs is gone; the safe state holds.
    Failsafe,
}

impl Mode {
    /// All of them, each at the place of its code.
    const ALL: [Self; 6] = [
        Self::Starting,
        Self::Aligning,
        Self::SearchingHeading,
        Self::Pilot,
        Self::Autopilot,
        Self::Failsafe,
    ];

    /// Its number on the wire.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The mode of a number on the wire.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }
}

/// What works and what does not, each a yes or no of this moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Health {
    /// Inertial samples come and are believed.
    pub imu: bool,
    /// Fixes come and are believed.
    pub gps: bool,
    /// Roll and pitch are good to fly by.
    pub attitude: bool,
    /// The heading is known.
    pub heading: bool,
    /// The velocity is good to fly by.
    pub velocity: bool,
    /// The position is good to fly by.
    pub position: bool,
    /// The pilot's pulses are fresh on every channel.
    pub pilot_signal: bool,
    /// The receiver says that it has lost the transmitter.
    pub receiver_failsafe: bool,
    /// The servos take what they are sent.
    pub servos: bool,
    /// The flight is being recorded.
    pub recorder: bool,
    /// The loop kept its time since the last snapshot.
    pub on_time: bool,
}

impl Health {
    /// One bit each, in the order of the fields, the first lowest.
    #[must_use]
    pub fn bits(self) -> u16 {
        [
            self.imu,
            self.gps,
            self.attitude,
            self.heading,
            self.velocity,
            self.position,
            self.pilot_signal,
            self.receiver_failsafe,
            self.servos,
            self.recorder,
            self.on_time,
        ]
        .into_iter()
        .rev()
        .fold(0, |bits, flag| bits << 1 | u16::from(flag))
    }

    /// The inverse of [`Health::bits`]; bits beyond the fields are ignored.
    #[must_use]
    pub const fn from_bits(bits: u16) -> Self {
        Self {
            imu: bits & 1 != 0,
            gps: bits & 1 << 1 != 0,
            attitude: bits & 1 << 2 != 0,
            heading: bits & 1 << 3 != 0,
            velocity: bits & 1 << 4 != 0,
            position: bits & 1 << 5 != 0,
            pilot_signal: bits & 1 << 6 != 0,
            receiver_failsafe: bits & 1 << 7 != 0,
            servos: bits & 1 << 8 != 0,
            recorder: bits & 1 << 9 != 0,
            on_time: bits & 1 << 10 != 0,
        }
    }
}

/// How sure the estimator is, one-sigma; `None` before it runs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sigmas {
    /// Horizontal position, north and east together, m.
    pub horizontal_m: Option<f64>,
    /// Height, m.
    pub vertical_m: Option<f64>,
    /// Horizontal velocity, north and east together, m/s.
    pub horizontal_velocity_mps: Option<f64>,
    /// Vertical velocity, m/s.
    pub vertical_velocity_mps: Option<f64>,
    /// The greater of roll and pitch, rad.
    pub tilt_rad: Option<f64>,
    /// Heading, rad.
    pub heading_rad: Option<f64>,
}

/// What kind of fix the receiver has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FixKind {
    /// Nothing has been heard of the receiver.
    #[default]
    NoReceiver,
    /// The receiver is there and has no fix.
    NoFix,
    /// Latitude and longitude only.
    TwoD,
    /// Latitude, longitude and height.
    ThreeD,
    /// The same with code corrections.
    Differential,
    /// Carrier phase, ambiguities not settled.
    RtkFloat,
    /// Carrier phase, ambiguities settled.
    RtkFixed,
}

impl FixKind {
    /// All of them, each at the place of its code.
    const ALL: [Self; 7] = [
        Self::NoReceiver,
        Self::NoFix,
        Self::TwoD,
        Self::ThreeD,
        Self::Differential,
        Self::RtkFloat,
        Self::RtkFixed,
    ];

    /// Its number on the wire, which is also MAVLink's.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The kind of a number on the wire.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }
}

/// The receiver's last fix, as it came.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GpsSummary {
    /// What kind of fix it is.
    pub fix: FixKind,
    /// Satellites used.
    pub satellites: Option<u8>,
    /// Time since the fix arrived, s.
    pub age_s: Option<f64>,
    /// Latitude and longitude, °, WGS-84.
    pub latitude_longitude_deg: Option<[f64; 2]>,
    /// Height above the ellipsoid, m.
    pub height_m: Option<f64>,
    /// Height above mean sea level by the receiver's geoid, m.
    pub altitude_msl_m: Option<f64>,
    /// Velocity north and east, m/s.
    pub horizontal_velocity_mps: Option<[f64; 2]>,
    /// Velocity downwards, m/s.
    pub down_velocity_mps: Option<f64>,
    /// Horizontal dilution of precision.
    pub hdop: Option<f64>,
    /// Vertical dilution of precision.
    pub vdop: Option<f64>,
}

impl GpsSummary {
    /// What the receiver said in `fix`, seen at `now` on the clock of its arrival.
    #[must_use]
    pub fn of(fix: &ReceiverFix, now: Time) -> Self {
        let kind = match (fix.correction, fix.dimension) {
            (Some(Correction::RtkFixed), _) => FixKind::RtkFixed,
            (Some(Correction::RtkFloat), _) => FixKind::RtkFloat,
            (_, Some(Dimension::TwoD)) => FixKind::TwoD,
            (Some(Correction::Differential), _) => FixKind::Differential,
            _ => FixKind::ThreeD,
        };
        let latitude_deg = fix.latitude_rad.to_degrees();
        Self {
            fix: kind,
            satellites: fix.satellites,
            age_s: Some((now - fix.arrival).max(0.0)),
            latitude_longitude_deg: Some([latitude_deg, fix.longitude_rad.to_degrees()]),
            height_m: fix.height_m,
            altitude_msl_m: fix.altitude_msl_m,
            horizontal_velocity_mps: fix.horizontal_velocity_mps,
            down_velocity_mps: fix.down_velocity_mps,
            hdop: fix.dilution.horizontal,
            vdop: fix.dilution.vertical,
        }
    }
}

/// The largest innovation of each kind since the last snapshot, in units of its own predicted
/// one-sigma; `None` where there was none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Innovations {
    /// GPS position.
    pub position: Option<f64>,
    /// GPS velocity.
    pub velocity: Option<f64>,
    /// Roll and pitch of the unit's own attitude.
    pub attitude: Option<f64>,
    /// Heading.
    pub heading: Option<f64>,
    /// Barometric height.
    pub baro: Option<f64>,
    /// Updates refused since the start.
    pub rejected: u32,
}

impl Innovations {
    /// Takes one more into account; one that is no number is passed over.
    pub fn note(&mut self, innovation: &Innovation) {
        let size = libm::fabs(innovation.normalised());
        let largest = match innovation.channel {
            Compared::PositionNorth | Compared::PositionEast | Compared::PositionDown => {
                &mut self.position
            }
            Compared::VelocityNorth | Compared::VelocityEast | Compared::VelocityDown => {
                &mut self.velocity
            }
            Compared::Roll | Compared::Pitch => &mut self.attitude,
            Compared::Yaw => &mut self.heading,
            Compared::BaroHeight => &mut self.baro,
        };
        if !size.is_nan() {
            *largest = Some(largest.map_or(size, |before| before.max(size)));
        }
        self.rejected =
            self.rejected.saturating_add(u32::from(innovation.verdict == Verdict::Rejected));
    }

    /// Starts over for the next snapshot; what is counted from the start stays.
    pub fn clear(&mut self) {
        *self = Self { rejected: self.rejected, ..Self::default() };
    }
}

/// How the loop keeps its time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoopTiming {
    /// From the start of the last cycle to the start of this, s.
    pub period_s: Option<f64>,
    /// What the last cycle's work took, s.
    pub work_s: Option<f64>,
    /// What the longest cycle's work took since the start, s.
    pub longest_work_s: Option<f64>,
    /// Cycles since the start that did not end in time.
    pub overruns: u32,
}

/// What was lost since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drops {
    /// Packets of the inertial unit.
    pub imu_packets: u32,
    /// Messages of the receiver.
    pub gps_messages: u32,
    /// Pulses of the pilot, the most of any channel.
    pub pilot_pulses: u32,
    /// Telemetry frames that the line had no room for.
    pub telemetry_frames: u32,
}

/// Everything that one moment tells; what is not known is `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapshot {
    /// The moment, on the flight's clock.
    pub time: Time,
    /// Who flies.
    pub mode: Mode,
    /// What works.
    pub health: Health,
    /// Angular rate, rad/s: less bias where the estimator runs, else as measured.
    pub angular_rate_radps: Option<Vector<Body>>,
    /// Specific force as measured, m/s²; level and at rest its z is −9.81.
    pub specific_force_mps2: Option<Vector<Body>>,
    /// Magnetic field as measured, gauss.
    pub magnetic_field_gauss: Option<Vector<Body>>,
    /// Temperature of the inertial unit, °C.
    pub temperature_degc: Option<f64>,
    /// Attitude by the estimator.
    pub attitude: Option<EulerAngles>,
    /// Position by the estimator.
    pub position: Option<Geodetic>,
    /// Velocity by the estimator, m/s.
    pub velocity_mps: Option<Vector<Ned>>,
    /// How sure the estimator is.
    pub sigmas: Sigmas,
    /// Widths that the servos are sent, ms.
    pub commanded_ms: Channels<Option<f64>>,
    /// Widths that the pilot's receiver sends, ms.
    pub pilot_ms: Channels<Option<f64>>,
    /// The receiver's last fix.
    pub gps: GpsSummary,
    /// How well sensors and estimator agree.
    pub innovations: Innovations,
    /// How the loop keeps its time.
    pub timing: LoopTiming,
    /// What was lost.
    pub drops: Drops,
}

impl Snapshot {
    /// A moment of which nothing else is known.
    #[must_use]
    pub fn at(time: Time) -> Self {
        Self {
            time,
            mode: Mode::default(),
            health: Health::default(),
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

    /// Tells what the inertial unit measured; `interval_s`, from the sample before, turns increments
    /// into rates, and is not looked at for rates. Where a solution is told too, it comes after: its
    /// rates are the better ones.
    #[must_use]
    pub fn with_imu(mut self, sample: &ImuSample, interval_s: f64) -> Self {
        let (rate, force) = match sample.motion {
            Motion::Rates { angular_rate_radps, specific_force_mps2 } => {
                (angular_rate_radps, specific_force_mps2)
            }
            Motion::Increments { angle_rad, velocity_mps } => {
                (angle_rad * (1.0 / interval_s), velocity_mps * (1.0 / interval_s))
            }
        };
        self.angular_rate_radps = Some(rate).filter(|vector| vector.is_finite());
        self.specific_force_mps2 = Some(force).filter(|vector| vector.is_finite());
        self.magnetic_field_gauss = sample.magnetic_field_gauss;
        self
    }

    /// Tells what the estimator knows.
    #[must_use]
    pub fn with_solution(mut self, solution: &Solution) -> Self {
        let horizontal = |sigma: Vector<Ned>| Some(libm::hypot(sigma.x(), sigma.y()));
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

    #[test]
    fn every_code_names_one_mode_and_one_kind_of_fix() {
        for code in 0..=u8::MAX {
            assert!(Mode::from_code(code).is_none_or(|mode| mode.code() == code));
            assert!(FixKind::from_code(code).is_none_or(|kind| kind.code() == code));
        }
        assert!(Mode::ALL.iter().all(|mode| Mode::from_code(mode.code()) == Some(*mode)));
        assert!(FixKind::ALL.iter().all(|kind| FixKind::from_code(kind.code()) == Some(*kind)));
    }

    #[test]
    fn each_health_flag_has_a_bit_of_its_own() {
        for bit in 0..11 {
            assert_eq!(Health::from_bits(1 << bit).bits(), 1 << bit);
        }
        assert_eq!(Health { imu: true, ..Health::default() }.bits(), 1);
        assert_eq!(Health { on_time: true, ..Health::default() }.bits(), 1 << 10);
        assert_eq!(Health::from_bits(0xF800), Health::default());
    }

    #[test]
    fn the_largest_innovation_of_each_kind_is_told_and_refusals_add_up() {
        let mut summary = Innovations::default();
        let mut note = |channel, innovation, verdict| {
            let time = Time::ZERO;
            summary.note(&Innovation { time, channel, innovation, sigma: 2.0, verdict });
        };
        note(Compared::PositionNorth, -3.0, Verdict::Accepted);
        note(Compared::PositionDown, 1.0, Verdict::Accepted);
        note(Compared::Yaw, f64::NAN, Verdict::Rejected);
        note(Compared::VelocityEast, 20.0, Verdict::Rejected);
        assert_eq!((summary.position, summary.velocity), (Some(1.5), Some(10.0)));
        assert_eq!((summary.heading, summary.baro, summary.rejected), (None, None, 2));
        summary.clear();
        assert_eq!(summary, Innovations { rejected: 2, ..Innovations::default() });
    }

    #[test]
    fn increments_are_told_as_rates() {
        let motion = Motion::Increments {
            angle_rad: Vector::new(0.01, 0.0, 0.0),
            velocity_mps: Vector::new(0.0, 0.0, -0.098_1),
        };
        let sample =
            ImuSample { time: Time::ZERO, motion, attitude: None, magnetic_field_gauss: None };
        let told = Snapshot::at(Time::ZERO).with_imu(&sample, 0.01);
        assert!((told.angular_rate_radps.unwrap().x() - 1.0).abs() < 1e-12);
        assert!((told.specific_force_mps2.unwrap().z() + 9.81).abs() < 1e-12);
        assert_eq!(Snapshot::at(Time::ZERO).with_imu(&sample, 0.0).specific_force_mps2, None);
    }
}
