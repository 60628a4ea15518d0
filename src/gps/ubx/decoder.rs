//! One fix per epoch from UBX messages.

use super::framer::Framer;
use super::message::{
    Acknowledgement, Content, FixStatus, GpsTime, Position, Pvt, Report, Solution, Velocity,
    known_dilution,
};
use super::relative::{self, NAV_RELPOSNED};
use super::values::{Impossible, gps_time, height, horizontal, on_all_axes, pvt_fix, set_heights};
use crate::earth::Geodetic;
use crate::frames::{Ecef, Vector};
use crate::gps::cycle::{Cycle, Kinds};
use crate::gps::receiver_fix::{Horizontal, plausible_velocity};
use crate::gps::{Correction, MessageCounts, ReceiverFix, ReceiverHeading};
use crate::time::Time;

const POSITION: Kinds = 1;
const STATUS: Kinds = 2;
const DILUTION: Kinds = 4;
const SOLUTION: Kinds = 8;
const VELOCITY: Kinds = 16;
const CLOCK: Kinds = 32;
const PVT: Kinds = 64;

/// Turns UBX messages into fixes.
///
/// NAV-PVT is a complete fix and is delivered at once. Receivers older than 2012 do not have it: their NAV-SOL,
/// NAV-POSLLH, NAV-VELNED, NAV-STATUS, NAV-DOP and NAV-TIMEGPS of one time of week form an epoch. It is delivered
/// once all kinds of message of the last epochs have arrived, or when the next epoch starts.
///
/// * The epoch is a fix if at least one of NAV-PVT, NAV-SOL and NAV-STATUS arrived. All of these that arrived must
///   report the fix as good (`gnssFixOK`) and as 2-D, 3-D, or combined with dead reckoning. Dead reckoning alone and
///   time alone are not a fix.
/// * Position comes from NAV-PVT, else NAV-POSLLH, else NAV-SOL (Earth-fixed, in cm). Velocity comes from NAV-PVT,
///   else NAV-VELNED, else NAV-SOL.
/// * One-sigmas are the receiver's accuracy estimates. The figure for the horizontal error is used for both north and
///   east, and the figure for speed for all three axes. NAV-SOL has one figure for the position in space, which is used
///   for all three axes. Each one-sigma is thus no smaller than the true one-sigma of its axis.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    framer: Framer,
    epoch: Option<Epoch>,
    cycle: Cycle,
    finished_ms: Option<u32>,
    /// Leap seconds from NAV-TIMEGPS; they change once in several years.
    leap_seconds: Option<i8>,
    answer: Option<Acknowledgement>,
    ready: Option<ReceiverFix>,
    heading: Option<ReceiverHeading>,
    counts: MessageCounts,
}

/// Data of an incomplete epoch of an older receiver.
#[derive(Clone, Copy, Debug)]
struct Epoch {
    time_of_week_ms: u32,
    fix: ReceiverFix,
    /// Kind of the message that gave the position; the more accurate kind is kept.
    position: Kinds,
    /// Kind of the message that gave the velocity; the more accurate kind is kept.
    velocity: Kinds,
    has_status: bool,
    usable: bool,
}

impl Decoder {
    /// Consumes `bytes`, which arrived at `arrival`, up to the end of the next epoch. `None` when all bytes are
    /// consumed; call again until then.
    pub fn read(&mut self, bytes: &mut &[u8], arrival: Time) -> Option<ReceiverFix> {
        if let Some(fix) = self.ready.take() {
            return Some(fix);
        }
        // Iterations: at most one for each buffered or new byte, because each iteration takes a message.
        loop {
            let message = self.framer.next(bytes, arrival)?;
            let started = message.arrival;
            if (message.class, message.id) == NAV_RELPOSNED
                && let Some(heading) = relative::read(message.payload, started)
            {
                self.counts.read = self.counts.read.saturating_add(1);
                self.heading = heading.or(self.heading);
                continue;
            }
            let Some(report) = Report::read(message.class, message.id, message.payload) else {
                self.counts.damaged = self.counts.damaged.saturating_add(1);
                continue;
            };
            self.counts.read = self.counts.read.saturating_add(1);
            let before = self.accept(&report, started);
            if before.is_some() {
                return before;
            }
            if let Some(fix) = self.ready.take() {
                return Some(fix);
            }
        }
    }

    /// The fix of the incomplete epoch, if its messages already make a fix. Use it when the line is silent until the
    /// next epoch, or at the end of a log.
    pub fn flush(&mut self) -> Option<ReceiverFix> {
        self.ready.take().or_else(|| self.finish())
    }

    /// Takes the last heading of two antennas, once: that of a NAV-RELPOSNED with a valid heading and resolved
    /// (integer) ambiguities.
    pub fn take_antenna_heading(&mut self) -> Option<ReceiverHeading> {
        self.heading.take()
    }

    /// Takes the last answer to a configuration message, once.
    pub fn take_acknowledgement(&mut self) -> Option<Acknowledgement> {
        self.answer.take()
    }

    /// Counts of all messages since the start. Messages of other kinds are skipped without a count.
    #[must_use]
    pub fn counts(&self) -> MessageCounts {
        MessageCounts {
            damaged: self.counts.damaged.saturating_add(self.framer.broken()),
            ..self.counts
        }
    }

    /// Processes a message. If the message ends the previous epoch, returns the fix of that epoch, if any. A fix that
    /// the message completes is stored in `ready`.
    fn accept(&mut self, report: &Report, arrival: Time) -> Option<ReceiverFix> {
        let (time_of_week_ms, content) = match report {
            Report::Pvt(pvt) => return self.accept_pvt(pvt, arrival),
            Report::Answer(answer) => {
                self.answer = Some(*answer);
                return None;
            }
            Report::Epoch { time_of_week_ms, content } => (*time_of_week_ms, content),
        };
        let before = self.open(time_of_week_ms, arrival);
        self.cycle.note(match content {
            Content::Position(_) => POSITION,
            Content::Status(_) => STATUS,
            Content::Dilution(_) => DILUTION,
            Content::Solution(_) => SOLUTION,
            Content::Velocity(_) => VELOCITY,
            Content::Time(_) => CLOCK,
        });
        if let Some(epoch) = &mut self.epoch {
            if let Content::Time(clock) = content {
                self.leap_seconds = clock.leap_seconds.or(self.leap_seconds);
            }
            if epoch.add(content, self.leap_seconds).is_err() {
                epoch.has_status = true;
                epoch.usable = false;
                self.counts.impossible = self.counts.impossible.saturating_add(1);
            }
        }
        if self.cycle.is_complete() {
            self.ready = self.finish();
        }
        before
    }

    fn accept_pvt(&mut self, pvt: &Pvt, arrival: Time) -> Option<ReceiverFix> {
        let before = self.open(pvt.time_of_week_ms, arrival);
        self.cycle.note(PVT);
        let Some(epoch) = self.epoch.take() else {
            return before;
        };
        self.finished_ms = Some(epoch.time_of_week_ms);
        if !pvt.status.is_usable() || pvt.position_is_invalid {
            self.counts.no_fix = self.counts.no_fix.saturating_add(1);
            return before;
        }
        match pvt_fix(pvt, epoch.fix.arrival) {
            Ok(fix) => self.ready = Some(fix),
            Err(Impossible) => self.counts.impossible = self.counts.impossible.saturating_add(1),
        }
        before
    }

    /// Opens the epoch of `time_of_week_ms`, unless it has already ended. Returns the fix of the previous epoch if that
    /// fix was not delivered.
    fn open(&mut self, time_of_week_ms: u32, arrival: Time) -> Option<ReceiverFix> {
        if self.epoch.is_some_and(|epoch| epoch.time_of_week_ms == time_of_week_ms) {
            return None;
        }
        let before = self.finish();
        if self.finished_ms != Some(time_of_week_ms) {
            self.cycle.close();
            let nowhere = Horizontal { latitude_rad: 0.0, longitude_rad: 0.0 };
            self.epoch = Some(Epoch {
                time_of_week_ms,
                fix: ReceiverFix::new(arrival, nowhere),
                position: 0,
                velocity: 0,
                has_status: false,
                usable: true,
            });
        }
        before
    }

    /// Ends the current epoch. Returns its fix, if its messages make a fix.
    fn finish(&mut self) -> Option<ReceiverFix> {
        let epoch = self.epoch.take()?;
        self.finished_ms = Some(epoch.time_of_week_ms);
        if !epoch.usable {
            self.counts.no_fix = self.counts.no_fix.saturating_add(1);
        }
        (epoch.usable && epoch.has_status && epoch.position != 0).then_some(epoch.fix)
    }
}

impl Epoch {
    fn add(&mut self, content: &Content, leap_seconds: Option<i8>) -> Result<(), Impossible> {
        match content {
            Content::Position(position) => self.add_position(position),
            Content::Velocity(velocity) => self.add_velocity(velocity),
            Content::Solution(solution) => self.add_solution(solution, leap_seconds),
            Content::Status(status) => {
                self.add_status(*status, leap_seconds);
                Ok(())
            }
            Content::Dilution(dilution) => {
                self.fix.dilution = *dilution;
                Ok(())
            }
            Content::Time(clock) => {
                self.add_clock(clock, leap_seconds);
                Ok(())
            }
        }
    }

    fn set_status(&mut self, status: FixStatus) {
        self.has_status = true;
        self.usable &= status.is_usable();
        self.fix.dimension = status.dimension();
        let corrected = status.is_differential();
        self.fix.correction =
            Some(if corrected { Correction::Differential } else { Correction::None });
    }

    fn add_status(&mut self, status: FixStatus, leap_seconds: Option<i8>) {
        self.set_status(status);
        if self.fix.time.is_none() && status.time_of_week_is_known() {
            self.fix.time = gps_time(None, self.time_of_week_ms, 0, leap_seconds);
        }
    }

    fn add_clock(&mut self, clock: &GpsTime, leap_seconds: Option<i8>) {
        if let Some(fraction_ns) = clock.fraction_ns {
            self.fix.time = gps_time(clock.week, self.time_of_week_ms, fraction_ns, leap_seconds);
        }
    }

    fn add_position(&mut self, position: &Position) -> Result<(), Impossible> {
        let place = horizontal(position.latitude_deg, position.longitude_deg)?;
        self.position = POSITION;
        self.fix.latitude_rad = place.latitude_rad;
        self.fix.longitude_rad = place.longitude_rad;
        set_heights(&mut self.fix, position)
    }

    fn add_velocity(&mut self, velocity: &Velocity) -> Result<(), Impossible> {
        let [north, east, down] = plausible_velocity(velocity.ned_mps).ok_or(Impossible)?;
        self.velocity = VELOCITY;
        self.fix.set_horizontal_velocity(north, east);
        self.fix.down_velocity_mps = Some(down);
        self.fix.velocity_sigma_mps = on_all_axes(velocity.sigma_mps);
        Ok(())
    }

    fn add_solution(
        &mut self,
        solution: &Solution,
        leap_seconds: Option<i8>,
    ) -> Result<(), Impossible> {
        let status = solution.status;
        self.set_status(status);
        self.fix.satellites = Some(solution.satellites);
        self.fix.dilution.position =
            self.fix.dilution.position.or_else(|| known_dilution(solution.position_dilution));
        if status.time_of_week_is_known() {
            let week = Some(solution.week).filter(|_| status.week_is_known());
            self.fix.time =
                gps_time(week, self.time_of_week_ms, solution.fraction_ns, leap_seconds);
        }
        if !self.usable {
            return Ok(());
        }
        let place = Geodetic::from_ecef(solution.position_m).ok_or(Impossible)?;
        if self.position != POSITION {
            let horizontal =
                Horizontal::new(place.latitude_rad, place.longitude_rad).ok_or(Impossible)?;
            self.position = SOLUTION;
            self.fix.latitude_rad = horizontal.latitude_rad;
            self.fix.longitude_rad = horizontal.longitude_rad;
            self.fix.height_m = Some(height(place.height_m)?);
            self.fix.position_sigma_m = on_all_axes(solution.position_sigma_m);
        }
        if self.velocity != VELOCITY {
            let ecef: Vector<Ecef> =
                plausible_velocity(solution.velocity_mps).ok_or(Impossible)?.into();
            let [north, east, down] = (place.ecef_to_ned() * ecef).to_array();
            self.velocity = SOLUTION;
            self.fix.set_horizontal_velocity(north, east);
            self.fix.down_velocity_mps = Some(down);
            self.fix.velocity_sigma_mps = on_all_axes(solution.velocity_sigma_mps);
        }
        Ok(())
    }
}
