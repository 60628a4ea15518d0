//! One fix per second from TSIP reports.

use super::values::{CompleteFix, Position, Velocity, correction, in_week, leap_seconds};
use super::{Framer, Health, IoOptions, Report, ReportError, SatelliteSelection};
use crate::gps::receiver_time::time_of_week_ns;
use crate::gps::{
    DilutionOfPrecision, Dimension, MessageCounts, ReceiverFix, ReceiverTime, WEEK_FLOOR,
    unroll_week,
};
use crate::time::Time;

/// Largest difference between times of fix in one epoch, s. The receiver computes one fix per second. The time in
/// single precision has steps of up to 62.5 ms.
const SAME_EPOCH_S: f64 = 0.1;
/// Largest age of the geometry report, s, at which it still describes a fix; it arrives every 1 to 5 s.
const SATELLITES_LAST_S: f64 = 10.0;

/// Turns a TSIP stream into fixes.
///
/// A fix needs position (0x84, 0x83 or 0x42) and velocity (0x56 or 0x43) of one time of fix, or a superpacket (0x8F-20,
/// 0x8F-23) alone. The fix is delivered as soon as these reports have arrived. A position without velocity is delivered
/// when the second ends (0x82) or the next begins. The packet 0x4A has steps of 2 m and gives no fix. Satellites and
/// dilutions are those of the last 0x6D, which follows the fix that it describes.
///
/// Heights are interpreted as above the ellipsoid unless the last 0x55 reported otherwise; [`Startup`] configures
/// this. The week comes from the last 0x41; a floor resolves its rollover.
///
/// TSIP reports no accuracy: the fix has no one-sigmas.
///
/// [`Startup`]: super::Startup
#[derive(Clone, Debug)]
pub struct Decoder {
    framer: Framer,
    week_floor: u16,
    clock: Option<Clock>,
    options: Option<IoOptions>,
    health: Option<Health>,
    satellites: Option<(Time, SatelliteSelection)>,
    corrected: Option<bool>,
    epoch: Option<Epoch>,
    finished_s: Option<f64>,
    ready: Option<ReceiverFix>,
    counts: MessageCounts,
}

/// The receiver's week, and the time of week at which the receiver sent it.
#[derive(Clone, Copy, Debug)]
struct Clock {
    week: u16,
    time_of_week_s: f64,
    leap_seconds: Option<u8>,
}

/// Position and velocity already received for the current time of fix.
#[derive(Clone, Copy, Debug)]
struct Epoch {
    time_of_fix_s: f64,
    arrival: Time,
    position: Option<Position>,
    velocity: Option<Velocity>,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::with_week_floor(WEEK_FLOOR)
    }
}

impl Decoder {
    /// A decoder for a stream recorded no earlier than GPS week `floor`: for old logs. For a live receiver use
    /// [`Decoder::default`].
    #[must_use]
    pub fn with_week_floor(floor: u16) -> Self {
        Self {
            framer: Framer::default(),
            week_floor: floor,
            clock: None,
            options: None,
            health: None,
            satellites: None,
            corrected: None,
            epoch: None,
            finished_s: None,
            ready: None,
            counts: MessageCounts::default(),
        }
    }

    /// Consumes `bytes`, which arrived at `arrival`, up to the end of the next epoch. `None` when all bytes are
    /// consumed; call again until then.
    pub fn read(&mut self, bytes: &mut &[u8], arrival: Time) -> Option<ReceiverFix> {
        if let Some(fix) = self.ready.take() {
            return Some(fix);
        }
        // Iterations: at most one per byte, because each iteration takes the end of a packet from `bytes`.
        loop {
            let packet = self.framer.next(bytes, arrival)?;
            let packet_arrival = packet.arrival;
            let fix = match Report::read(packet.id, packet.payload) {
                Ok(report) => {
                    self.counts.read = self.counts.read.saturating_add(1);
                    self.accept(&report, packet_arrival)
                }
                Err(ReportError::Unknown { .. }) => {
                    self.counts.unknown = self.counts.unknown.saturating_add(1);
                    None
                }
                Err(ReportError::Length { .. }) => {
                    self.counts.damaged = self.counts.damaged.saturating_add(1);
                    None
                }
            };
            if fix.is_some() {
                return fix;
            }
            if let Some(fix) = self.ready.take() {
                return Some(fix);
            }
        }
    }

    /// The fix of the incomplete epoch, if it has a position. Use it when the line is silent until the next epoch, or
    /// at the end of a log.
    pub fn flush(&mut self) -> Option<ReceiverFix> {
        self.ready.take().or_else(|| self.finish())
    }

    /// Settings of the reports that the receiver last confirmed (0x55); `None` before the first 0x55, and after a
    /// restart.
    #[must_use]
    pub fn io_options(&self) -> Option<IoOptions> {
        self.options
    }

    /// The receiver's last reported health (0x46, every few seconds): the reason for missing fixes.
    #[must_use]
    pub fn health(&self) -> Option<Health> {
        self.health
    }

    /// Counts of all packets since the start.
    #[must_use]
    pub fn counts(&self) -> MessageCounts {
        MessageCounts {
            damaged: self.counts.damaged.saturating_add(self.framer.broken()),
            ..self.counts
        }
    }

    /// Processes a report. If the report ends the previous epoch, returns the fix of that epoch, if any. A fix that the
    /// report completes is stored in `ready`.
    fn accept(&mut self, report: &Report, arrival: Time) -> Option<ReceiverFix> {
        match report {
            Report::GpsTime(time) => {
                let week = u16::try_from(time.week).ok();
                let time_of_week_s = f64::from(time.time_of_week_s);
                let leap_seconds = leap_seconds(f64::from(time.utc_offset_s));
                if let Some((week, time_of_week_s)) = week.zip(in_week(time_of_week_s)) {
                    let week = unroll_week(week, self.week_floor);
                    self.clock = Some(Clock { week, time_of_week_s, leap_seconds });
                }
                None
            }
            Report::IoOptions(options) => {
                self.options = Some(*options);
                None
            }
            Report::Version(_) => {
                // The receiver sends this report after a restart, or on a request that Startup never makes. After a
                // restart its settings are lost.
                self.options = None;
                None
            }
            Report::SatelliteSelection(satellites) => {
                self.satellites = Some((arrival, *satellites));
                None
            }
            Report::Differential(differential) => {
                self.corrected = Some(differential.mode & 0x01 != 0);
                self.finish()
            }
            Report::PositionLla(lla) => {
                let above_sea = self.options.is_some_and(IoOptions::heights_are_above_sea);
                let position = Position::from_lla(lla, !above_sea);
                self.accept_position(position, lla.time_of_fix_s, arrival)
            }
            Report::PositionXyz(xyz) => {
                self.accept_position(Position::from_xyz(xyz), xyz.time_of_fix_s, arrival)
            }
            Report::VelocityEnu(enu) => {
                self.accept_velocity(Velocity::from_enu(enu), enu.time_of_fix_s, arrival)
            }
            Report::VelocityXyz(xyz) => {
                self.accept_velocity(Velocity::from_xyz(xyz), xyz.time_of_fix_s, arrival)
            }
            Report::Superpacket(superpacket) => {
                self.accept_complete(CompleteFix::from_superpacket(superpacket), arrival)
            }
            Report::Compact(compact) => {
                self.accept_complete(CompleteFix::from_compact(compact), arrival)
            }
            Report::Health(health) => {
                self.health = Some(*health);
                None
            }
            Report::CoarsePositionLla(_)
            | Report::ReferenceHeight { .. }
            | Report::MachineStatus(_)
            | Report::LastFix(_)
            | Report::Tracking(_) => None,
        }
    }

    fn accept_position(
        &mut self,
        position: Option<Position>,
        time_of_fix_s: f32,
        arrival: Time,
    ) -> Option<ReceiverFix> {
        if time_of_fix_s < 0.0 {
            // The position that the receiver stored in its last flight.
            self.counts.no_fix = self.counts.no_fix.saturating_add(1);
            return None;
        }
        let Some((position, time_of_fix_s)) = position.zip(in_week(f64::from(time_of_fix_s)))
        else {
            return self.refuse();
        };
        let before = self.open(time_of_fix_s, arrival);
        if let Some(epoch) = &mut self.epoch {
            epoch.position.get_or_insert(position);
        }
        self.complete();
        before
    }

    fn accept_velocity(
        &mut self,
        velocity: Option<Velocity>,
        time_of_fix_s: f32,
        arrival: Time,
    ) -> Option<ReceiverFix> {
        let Some((velocity, time_of_fix_s)) = velocity.zip(in_week(f64::from(time_of_fix_s)))
        else {
            return self.refuse();
        };
        let before = self.open(time_of_fix_s, arrival);
        if let Some(epoch) = &mut self.epoch {
            epoch.velocity.get_or_insert(velocity);
        }
        self.complete();
        before
    }

    fn accept_complete(
        &mut self,
        complete: Option<CompleteFix>,
        arrival: Time,
    ) -> Option<ReceiverFix> {
        let Some(complete) = complete else {
            return self.refuse();
        };
        if complete.fix_flags & 0x01 != 0 {
            self.counts.no_fix = self.counts.no_fix.saturating_add(1);
            return None;
        }
        let before = self.open(complete.time_of_week_s, arrival);
        // A superpacket replaces a position of the same epoch that arrived earlier in another report.
        let Some(epoch) = self.epoch.take() else {
            return before;
        };
        self.finished_s = Some(complete.time_of_week_s);
        let week = unroll_week(complete.week, self.week_floor);
        let leap_seconds = leap_seconds(f64::from(complete.leap_seconds));
        self.clock = Some(Clock { week, time_of_week_s: complete.time_of_week_s, leap_seconds });
        let mut fix = self.fix(epoch.arrival, &complete.position, complete.velocity);
        fix.time = time_of_week_ns(complete.time_of_week_s).map(|time_of_week_ns| {
            ReceiverTime::Gps { week: Some(week), time_of_week_ns, leap_seconds }
        });
        fix.satellites = complete.satellites.or(fix.satellites);
        fix.dimension =
            Some(if complete.fix_flags & 0x04 != 0 { Dimension::TwoD } else { Dimension::ThreeD });
        fix.correction = Some(correction(complete.fix_flags & 0x02 != 0));
        self.ready = Some(fix);
        before
    }

    fn refuse(&mut self) -> Option<ReceiverFix> {
        self.counts.impossible = self.counts.impossible.saturating_add(1);
        None
    }

    /// Opens the epoch of `time_of_fix_s`, unless it is already open or has ended. Returns the fix of the previous
    /// epoch if that has a position and was not delivered.
    fn open(&mut self, time_of_fix_s: f64, arrival: Time) -> Option<ReceiverFix> {
        let is_this = |other_s: f64| libm::fabs(other_s - time_of_fix_s) < SAME_EPOCH_S;
        if self.epoch.is_some_and(|epoch| is_this(epoch.time_of_fix_s)) {
            return None;
        }
        let before = self.finish();
        if !self.finished_s.is_some_and(is_this) {
            self.epoch = Some(Epoch { time_of_fix_s, arrival, position: None, velocity: None });
        }
        before
    }

    /// Delivers the current epoch if it has both position and velocity.
    fn complete(&mut self) {
        if self.epoch.is_some_and(|epoch| epoch.position.is_some() && epoch.velocity.is_some()) {
            self.ready = self.finish();
        }
    }

    /// Ends the current epoch. Returns its fix, if it has a position.
    fn finish(&mut self) -> Option<ReceiverFix> {
        let epoch = self.epoch.take()?;
        let position = epoch.position?;
        self.finished_s = Some(epoch.time_of_fix_s);
        let mut fix = self.fix(epoch.arrival, &position, epoch.velocity);
        fix.time = self.receiver_time(epoch.time_of_fix_s);
        Some(fix)
    }

    fn fix(&self, arrival: Time, position: &Position, velocity: Option<Velocity>) -> ReceiverFix {
        let mut fix = ReceiverFix::new(arrival, position.place);
        self.describe(&mut fix, arrival);
        if position.above_ellipsoid {
            fix.height_m = Some(position.height_m);
        } else {
            fix.altitude_msl_m = Some(position.height_m);
        }
        if let Some(velocity) = velocity {
            let [north, east, down] = velocity.at(position).to_array();
            fix.set_horizontal_velocity(north, east);
            fix.down_velocity_mps = Some(down);
        }
        fix
    }

    /// Satellites, dilutions, dimension and correction, from the reports that describe fixes.
    fn describe(&self, fix: &mut ReceiverFix, arrival: Time) {
        fix.correction = self.corrected.map(correction);
        let fresh =
            self.satellites.filter(|(received, _)| arrival - *received <= SATELLITES_LAST_S);
        let Some((_, selection)) = fresh else {
            return;
        };
        fix.satellites = u8::try_from(selection.prn().len()).ok();
        fix.dimension = match selection.dimension {
            3 => Some(Dimension::TwoD),
            4 => Some(Dimension::ThreeD),
            _ => None,
        };
        let [position, horizontal, vertical, _] = selection.dilution.map(|dilution| {
            Some(f64::from(dilution)).filter(|dilution| (1e-3..1e3).contains(dilution))
        });
        fix.dilution = DilutionOfPrecision { position, horizontal, vertical };
    }

    fn receiver_time(&self, time_of_fix_s: f64) -> Option<ReceiverTime> {
        let time_of_week_ns = time_of_week_ns(time_of_fix_s)?;
        if self.options.is_some_and(IoOptions::times_are_utc) {
            let time_of_day_ns = time_of_week_ns % 86_400_000_000_000;
            return Some(ReceiverTime::Utc { day: None, time_of_day_ns });
        }
        let week = self.clock.map(|clock| {
            // The week was sent at another moment, possibly in a neighbouring week.
            match time_of_fix_s - clock.time_of_week_s {
                ahead if ahead < -302_400.0 => clock.week.saturating_add(1),
                ahead if ahead > 302_400.0 => clock.week.saturating_sub(1),
                _ => clock.week,
            }
        });
        let leap_seconds = self.clock.and_then(|clock| clock.leap_seconds);
        Some(ReceiverTime::Gps { week, time_of_week_ns, leap_seconds })
    }
}
