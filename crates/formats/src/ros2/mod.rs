//! Reads MCAP files with ROS 2 messages.

mod cdr;
mod container;
mod message;
mod topic;
mod topics;
mod velocity;

use std::path::Path;

use mcap::records::Record;

use crate::assembly::Assembly;
use crate::axes;
use crate::format::Format;
use crate::log::{Log, Options};
use crate::onboard::OnboardMoment;
use crate::window::Input;
use cdr::Cdr;
use container::{for_each_record, unpacked_message};
use hovernav::event::RangeReading;
use hovernav::frames::{Body, Vector};
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;
use hovernav_dataset::utc::moment;
use hovernav_dataset::{LogError, Manifest, StatedFix, pressure_altitude_m};
use message::{Header, Kind};
use topics::Topics;

const GAUSS_PER_TESLA: f64 = 1e4;
/// Largest time between a fix and its velocity, s.
const SAME_EPOCH_S: f64 = 0.1;

/// Whether the MCAP files have a topic with this name.
///
/// # Errors
/// As [`for_each_record`].
#[cfg(feature = "record")]
pub(crate) fn has_topic(inputs: &[Input<'_>], name: &str) -> Result<bool, LogError> {
    let mut is_found = false;
    for_each_record(inputs, |_, record, _| {
        is_found |= matches!(record, Record::Channel(channel) if channel.topic == name);
    })?;
    Ok(is_found)
}

/// Reads the MCAP files of a ROS 2 log, whose name in messages is `path`, as one recording.
///
/// # Errors
/// [`LogError`] if the file cannot be read or contains no usable topic.
pub(crate) fn read(path: &Path, inputs: &[Input<'_>], options: &Options) -> Result<Log, LogError> {
    let mut assembly = Assembly::new(true);
    let topics = Topics::of(path, inputs, options, &mut assembly)?;
    let mut gathered = Gathered { assembly, ..Gathered::new() };
    // Limits memory: even compressed, each message takes at least one byte of the file.
    let mut room = 0_u64;
    for input in inputs {
        room = room.saturating_add(input.length()?);
    }
    for_each_record(inputs, |file, record, offset| {
        if let Record::Message { header, data } = record
            && let Some(kind) = topics.kind((file, header.channel_id))
        {
            let Some(left) = room.checked_sub(1) else {
                gathered.skipped += 1;
                return;
            };
            room = left;
            let logged_ns = i64::try_from(header.log_time).unwrap_or(i64::MAX);
            let is_read = Cdr::new(&unpacked_message(&data))
                .and_then(|cdr| gathered.take(kind, cdr, logged_ns, topics.by_stamp, offset));
            gathered.unreadable += usize::from(is_read.is_none());
        }
    })?;
    gathered.finish(path)
}

/// The values that have been read.
struct Gathered {
    assembly: Assembly,
    origin_ns: Option<i64>,
    /// Fixes, each with its byte offset and the number of velocities before it in the file.
    fixes: Vec<(u64, usize, Time, StatedFix)>,
    /// Velocities in the order of the file.
    velocities: Vec<Velocity>,
    unreadable: usize,
    /// Number of messages in excess of the number of bytes in the file.
    skipped: usize,
    are_down: bool,
    has_imu: bool,
    /// Whether any orientation differs from the identity. Drivers without an orientation send the identity.
    has_turned: bool,
}

impl Gathered {
    fn new() -> Self {
        Self {
            assembly: Assembly::new(true),
            origin_ns: None,
            fixes: Vec::new(),
            velocities: Vec::new(),
            unreadable: 0,
            skipped: 0,
            are_down: false,
            has_imu: false,
            has_turned: false,
        }
    }

    /// Reads a message; `None` if it is too short.
    fn take(
        &mut self,
        kind: Kind,
        mut cdr: Cdr<'_>,
        logged_ns: i64,
        by_stamp: bool,
        place: u64,
    ) -> Option<()> {
        let cdr = &mut cdr;
        let header = message::header(cdr)?;
        let at_ns = if by_stamp { header.stamp_ns } else { logged_ns };
        let origin_ns = *self.origin_ns.get_or_insert(at_ns);
        let time = Time::from_nanoseconds(at_ns.saturating_sub(origin_ns));
        match kind {
            Kind::Imu => self.imu(&header, message::imu(cdr)?, time, place),
            Kind::Fix | Kind::GpsFix => self.fix(&message::fix_of(kind, cdr)?, time, place),
            Kind::Velocity | Kind::VelocityCovariance => {
                let (velocity, sigma) = message::velocity(cdr, kind == Kind::VelocityCovariance)?;
                self.velocities.push((time, velocity, sigma));
            }
            Kind::Field => {
                let field: [f64; 3] = cdr.f64s()?;
                let field = body(&header, field) * GAUSS_PER_TESLA;
                self.assembly.magnetometer(place, time, field.to_array());
            }
            Kind::Pressure => {
                let height_m = pressure_altitude_m(cdr.f64()?);
                self.assembly.baro(place, time, height_m.unwrap_or(f64::NAN));
            }
            Kind::Range => {
                let (range_m, quality) = message::range(cdr)?;
                let quality = Some(quality);
                let reading = RangeReading { quality, ..RangeReading::new(time, range_m) };
                self.assembly.range(place, reading);
            }
            Kind::Odometry => {
                let odometry = message::odometry(cdr)?;
                let body_to_ned = axes::attitude_flu_enu(odometry.orientation);
                let velocity = axes::body_from_flu(odometry.velocity_mps);
                let velocity_mps = body_to_ned.map(|attitude| attitude * velocity);
                self.assembly.moment(OnboardMoment {
                    time,
                    body_to_ned,
                    velocity_mps,
                    position: None,
                });
            }
        }
        Some(())
    }

    fn imu(&mut self, header: &Header<'_>, imu: message::Imu, time: Time, place: u64) {
        self.has_imu = true;
        self.are_down |= header.is_down();
        self.has_turned |= imu.orientation.is_some_and(|found| found != [1.0, 0.0, 0.0, 0.0]);
        let attitude = imu.orientation.and_then(|quaternion| match header.is_down() {
            true => axes::attitude_frd_ned(quaternion),
            false => axes::attitude_flu_enu(quaternion),
        });
        let motion = Motion::Rates {
            angular_rate_radps: body(header, imu.rate_radps),
            specific_force_mps2: body(header, imu.force_mps2),
        };
        let attitude = attitude.map(|attitude| attitude.euler());
        let sample = ImuSample { attitude, ..ImuSample::new(time, motion) };
        self.assembly.imu(place, sample);
    }

    fn fix(&mut self, fix: &message::NavSatFix, time: Time, place: u64) {
        let position = [fix.latitude_deg, fix.longitude_deg, fix.height_m];
        let dimensions = fix.dimensions();
        let position_sigma_m = fix.sigma_m.unwrap_or([f64::NAN; 3]);
        let mut stated = StatedFix::at(Some(time), position);
        if let Some([speed_mps, course_deg, climb_mps]) = fix.motion {
            stated.velocity_mps[2] = -climb_mps;
            stated = stated.moving(speed_mps, course_deg.to_radians());
        }
        self.fixes.push((
            place,
            self.velocities.len(),
            time,
            StatedFix { dimensions, position_sigma_m, ..stated },
        ));
    }

    /// The log, after the velocities have been assigned to their fixes.
    fn finish(mut self, path: &Path) -> Result<Log, LogError> {
        let by_time = in_time_order(&self.velocities);
        for (place, before, time, mut fix) in std::mem::take(&mut self.fixes) {
            if let Some((_, velocity, sigma)) = of_epoch(&self.velocities, &by_time, time, before) {
                fix.velocity_mps = *velocity;
                fix.velocity_sigma_mps = sigma.unwrap_or([f64::NAN; 3]);
            }
            self.assembly.fix(place, fix);
        }
        if self.unreadable > 0 {
            let count = self.unreadable;
            self.assembly.say(format!("{count} messages skipped: shorter than their type"));
        }
        if self.skipped > 0 {
            let count = self.skipped;
            self.assembly.say(format!(
                "{count} messages skipped: the file contains more messages \
                                       than bytes"
            ));
        }
        if self.has_imu {
            self.assembly.note(match self.are_down {
                true => {
                    "axes read as forward-right-down and north-east-down, from the name of the \
                     frame"
                }
                false => "axes converted from forward-left-up and east-north-up (REP 103)",
            });
        }
        let utc_s = self.origin_ns.unwrap_or_default() as f64 * 1e-9;
        let date = self.origin_ns.and_then(moment);
        let time = format!("s since {utc_s:.6} s on the log's clock");
        let manifest = Manifest { date, time, ..Manifest::default() };
        let mut log = self.assembly.finish(path, Format::Ros2, manifest, "odometry")?;
        if !self.has_turned {
            log.dataset.imu.iter_mut().for_each(|sample| sample.attitude = None);
        }
        Ok(log)
    }
}

/// Velocity with its time and one-sigma.
type Velocity = (Time, [f64; 3], Option<[f64; 3]>);

/// Indices of the velocities in order of time.
fn in_time_order(velocities: &[Velocity]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..velocities.len()).collect();
    order.sort_by_key(|&index| velocities[index].0);
    order
}

/// The velocity nearest to `time`, the time of a fix with `before` velocities before it in the file. A clock that steps
/// back gives the same times twice. Only velocities from the same pass of the clock, which are together in the file,
/// may belong to the fix.
fn of_epoch<'a>(
    velocities: &'a [Velocity],
    by_time: &[usize],
    time: Time,
    before: usize,
) -> Option<&'a Velocity> {
    let away_s = |index: usize| (velocities[index].0 - time).abs();
    let from = by_time.partition_point(|&index| time - velocities[index].0 > SAME_EPOCH_S);
    let near = by_time[from..].iter().copied().take_while(|&index| away_s(index) <= SAME_EPOCH_S);
    let in_file = |index: usize| index.abs_diff(before);
    let nearest = near.clone().min_by_key(|&index| in_file(index))?;
    let most = in_file(nearest) + near.clone().count();
    let of_pass = near.filter(|&index| in_file(index) < most);
    of_pass.min_by(|a, b| away_s(*a).total_cmp(&away_s(*b))).map(|index| &velocities[index])
}

/// Converts a vector to body axes.
fn body(header: &Header<'_>, vector: [f64; 3]) -> Vector<Body> {
    if header.is_down() { Vector::from(vector) } else { axes::body_from_flu(vector) }
}
