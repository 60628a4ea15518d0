//! Fields of the messages that are read.
//!
//! # Source
//! The definitions in `sensor_msgs`, `geometry_msgs`, `nav_msgs` and `std_msgs` of ROS 2; axes by REP
//! 103 and REP 145.

use super::cdr::Cdr;
use crate::choice::{is_alive, is_fix};
use hovernav_dataset::Dimensions;

/// The type of a topic's messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    Imu,
    Fix,
    /// A fix with its velocity, of `gps_msgs`.
    GpsFix,
    Velocity,
    /// Velocity with its covariance.
    VelocityCovariance,
    Field,
    Pressure,
    Odometry,
    Range,
}

impl Kind {
    /// The kind for the name of a schema.
    pub fn of(schema: &str) -> Option<Self> {
        Some(match schema {
            "sensor_msgs/msg/Imu" | "sensor_msgs/Imu" => Self::Imu,
            "sensor_msgs/msg/NavSatFix" | "sensor_msgs/NavSatFix" => Self::Fix,
            "gps_msgs/msg/GPSFix" | "gps_msgs/GPSFix" | "gps_common/GPSFix" => Self::GpsFix,
            "geometry_msgs/msg/TwistStamped" | "geometry_msgs/TwistStamped" => Self::Velocity,
            "geometry_msgs/msg/TwistWithCovarianceStamped"
            | "geometry_msgs/TwistWithCovarianceStamped" => Self::VelocityCovariance,
            "sensor_msgs/msg/MagneticField" | "sensor_msgs/MagneticField" => Self::Field,
            "sensor_msgs/msg/FluidPressure" | "sensor_msgs/FluidPressure" => Self::Pressure,
            "sensor_msgs/msg/Range" | "sensor_msgs/Range" => Self::Range,
            "nav_msgs/msg/Odometry" | "nav_msgs/Odometry" => Self::Odometry,
            _ => return None,
        })
    }
}

/// `std_msgs/Header`: time stamp, ns, and frame of a message.
#[derive(Clone, Copy, Debug)]
pub(super) struct Header<'a> {
    pub stamp_ns: i64,
    pub frame: &'a [u8],
}

impl Header<'_> {
    /// Whether the name of the frame denotes forward-right-down or north-east-down axes.
    pub fn is_down(&self) -> bool {
        let frame = self.frame.to_ascii_lowercase();
        frame.ends_with(b"ned") || frame.ends_with(b"frd")
    }
}

pub(super) fn header<'a>(cdr: &mut Cdr<'a>) -> Option<Header<'a>> {
    let (seconds, nanoseconds) = (cdr.i32()?, cdr.u32()?);
    let stamp_ns = i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds);
    Some(Header { stamp_ns, frame: cdr.text()? })
}

/// `sensor_msgs/Imu`.
pub(super) struct Imu {
    /// Quaternion, scalar first; `None` if the IMU has no orientation.
    pub orientation: Option<[f64; 4]>,
    pub rate_radps: [f64; 3],
    pub force_mps2: [f64; 3],
}

pub(super) fn imu(cdr: &mut Cdr<'_>) -> Option<Imu> {
    let [x, y, z, w] = cdr.f64s()?;
    let covariance: [f64; 9] = cdr.f64s()?;
    let rate_radps = cdr.f64s()?;
    let _: [f64; 9] = cdr.f64s()?;
    let force_mps2 = cdr.f64s()?;
    // A first element of −1 means that there is no orientation.
    let is_given = covariance[0] != -1.0 && [x, y, z, w] != [0.0; 4];
    Some(Imu { orientation: is_given.then_some([w, x, y, z]), rate_radps, force_mps2 })
}

/// `sensor_msgs/NavSatFix`.
pub(super) struct NavSatFix {
    pub has_fix: bool,
    pub latitude_deg: f64,
    pub longitude_deg: f64,
    /// Height above the ellipsoid, m.
    pub height_m: f64,
    /// One-sigma north, east, down, m.
    pub sigma_m: Option<[f64; 3]>,
    /// Speed over ground, m/s, course, °, and climb, m/s, if the message has them.
    pub motion: Option<[f64; 3]>,
}

impl NavSatFix {
    /// Dimensions of the position.
    pub fn dimensions(&self) -> Dimensions {
        if self.has_fix { Dimensions::Three } else { Dimensions::None }
    }
}

/// Status of a receiver without a fix. A driver that does not set the status sends -2 since ROS 2 Jazzy.
const NO_FIX: i16 = -1;

/// `gps_msgs/GPSFix`.
fn gps_fix(cdr: &mut Cdr<'_>) -> Option<NavSatFix> {
    header(cdr)?;
    let _used = cdr.u16()?;
    cdr.skip_numbers()?;
    let _visible = cdr.u16()?;
    (0..4).try_for_each(|_| cdr.skip_numbers())?;
    let status = cdr.i16()?;
    let _sources = [cdr.u16()?, cdr.u16()?, cdr.u16()?];
    let [latitude_deg, longitude_deg, height_m] = cdr.f64s()?;
    let [track_deg, speed_mps, climb_mps] = cdr.f64s()?;
    // Attitude, time and dilutions of precision are skipped; then come errors, and the covariance of the position.
    let _: [f64; 9] = cdr.f64s()?;
    let _: [f64; 10] = cdr.f64s()?;
    let covariance: [f64; 9] = cdr.f64s()?;
    let sigma_m = [covariance[4], covariance[0], covariance[8]].map(f64::sqrt);
    let is_known = cdr.u8()? != 0 && sigma_m.iter().all(|sigma| *sigma > 0.0);
    Some(NavSatFix {
        has_fix: status != NO_FIX,
        latitude_deg,
        longitude_deg,
        height_m,
        sigma_m: is_known.then_some(sigma_m),
        motion: Some([speed_mps, track_deg, climb_mps]),
    })
}

fn fix(cdr: &mut Cdr<'_>) -> Option<NavSatFix> {
    let status = cdr.i8()?;
    cdr.u16()?;
    let [latitude_deg, longitude_deg, height_m] = cdr.f64s()?;
    // The velocity is east, north, up.
    let covariance: [f64; 9] = cdr.f64s()?;
    let is_known = cdr.u8()? != 0;
    let sigma_m = [covariance[4], covariance[0], covariance[8]].map(f64::sqrt);
    let is_positive = sigma_m.iter().all(|sigma| *sigma > 0.0);
    Some(NavSatFix {
        has_fix: i16::from(status) != NO_FIX,
        latitude_deg,
        longitude_deg,
        height_m,
        sigma_m: (is_known && is_positive).then_some(sigma_m),
        motion: None,
    })
}

/// `geometry_msgs/TwistStamped` of a receiver: velocity and its one-sigma, north, east, down, m/s.
pub(super) fn velocity(
    cdr: &mut Cdr<'_>,
    with_covariance: bool,
) -> Option<([f64; 3], Option<[f64; 3]>)> {
    let [east, north, up] = cdr.f64s()?;
    let _angular: [f64; 3] = cdr.f64s()?;
    let mut sigma_mps = None;
    if with_covariance {
        let covariance: [f64; 36] = cdr.f64s()?;
        let sigma = [covariance[7], covariance[0], covariance[14]].map(f64::sqrt);
        sigma_mps = Some(sigma).filter(|sigma| sigma.iter().all(|sigma| *sigma > 0.0));
    }
    Some(([north, east, -up], sigma_mps))
}

/// `nav_msgs/Odometry`: attitude, scalar first, and velocity in the vehicle's axes, m/s.
pub(super) struct Odometry {
    pub orientation: [f64; 4],
    pub velocity_mps: [f64; 3],
}

pub(super) fn odometry(cdr: &mut Cdr<'_>) -> Option<Odometry> {
    cdr.text()?;
    let _position: [f64; 3] = cdr.f64s()?;
    let [x, y, z, w] = cdr.f64s()?;
    let _covariance: [f64; 36] = cdr.f64s()?;
    Some(Odometry { orientation: [w, x, y, z], velocity_mps: cdr.f64s()? })
}

/// `sensor_msgs/Range`: the distance, m, and its quality: 1 within the sensor's own limits, otherwise 0.
pub(super) fn range(cdr: &mut Cdr<'_>) -> Option<(f64, f64)> {
    let _radiation = cdr.u8()?;
    let _field_of_view = cdr.f32()?;
    let (least_m, most_m, range_m) = (cdr.f32()?, cdr.f32()?, cdr.f32()?);
    let valid = range_m >= least_m && range_m <= most_m;
    Some((f64::from(range_m), f64::from(u8::from(valid))))
}

/// Whether a message of `kind`, after its header, has a measurement that may be used.
pub(super) fn is_good(kind: Kind, cdr: &mut Cdr<'_>) -> bool {
    match kind {
        Kind::Imu => imu(cdr).is_some_and(|imu| is_alive(imu.force_mps2)),
        Kind::Fix | Kind::GpsFix => fix_of(kind, cdr)
            .is_some_and(|fix| is_fix(fix.dimensions(), [fix.latitude_deg, fix.longitude_deg])),
        Kind::Field => cdr.f64s().is_some_and(is_alive),
        _ => true,
    }
}

/// The fix in a message of either type.
pub(super) fn fix_of(kind: Kind, cdr: &mut Cdr<'_>) -> Option<NavSatFix> {
    if kind == Kind::GpsFix { gps_fix(cdr) } else { fix(cdr) }
}
