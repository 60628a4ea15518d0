//! One fix an epoch from the messages.

use ublox::nav_pos_llh::NavPosLlhRef;
use ublox::nav_pvt::common::NavPvtFlags;
use ublox::nav_pvt::proto23::{NavPvt, NavPvtRef};
use ublox::nav_sol::{NavSolFlags, NavSolRef};
use ublox::nav_status::{NavStatusFlags, NavStatusRef};
use ublox::nav_time_gps::{NavTimeGpsFlags, NavTimeGpsRef};
use ublox::nav_vel_ned::NavVelNedRef;
use ublox::proto23::{PacketRef, Proto23};
use ublox::{GnssFixType, UbxPacketMeta, UbxProtocol};

use super::framer::Framer;
use super::values::{
    Impossible, dilution, dilutions, dimension, gps_time, height, horizontal, is_usable,
    on_all_axes, whole,
};
use crate::earth::Geodetic;
use crate::frames::{Ecef, Vector};
use crate::gps::cycle::{Cycle, Kinds};
use crate::gps::receiver_fix::{Horizontal, known_sigma, plausible_velocity};
use crate::gps::{Correction, Counts, ReceiverFix};
use crate::time::Time;

const POSITION: Kinds = 1;
const STATUS: Kinds = 2;
const DILUTION: Kinds = 4;
const SOLUTION: Kinds = 8;
const VELOCITY: Kinds = 16;
const CLOCK: Kinds = 32;
const WHOLE: Kinds = 64;

/// The receiver's answer to a configuration message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Acknowledgement {
    /// Class of the message answered.
    pub class: u8,
    /// Id of the message answered.
    pub id: u8,
    /// Whether it was obeyed.
    pub accepted: bool,
}

/// Turns UBX messages into fixes.
///
/// NAV-PVT is a fix by itself and is handed on at once. Receivers older than 2012 do not have it:
/// their NAV-SOL, NAV-POSLLH, NAV-VELNED, NAV-STATUS, NAV-DOP and NAV-TIMEGPS of one time of week
/// are one epoch, handed on when the messages are in that the last epochs had, or when the next
/// epoch starts.
///
/// * It is a fix if at least one of NAV-PVT, NAV-SOL and NAV-STATUS came, and all that came say that
///   it is good (`gnssFixOK`) and measured with satellites: 2-D, 3-D, or combined with dead
///   reckoning; not dead reckoning alone, not time alone.
/// * Position is NAV-PVT's, else NAV-POSLLH's, else NAV-SOL's (Earth-fixed, in cm); velocity
///   NAV-PVT's, else NAV-VELNED's, else NAV-SOL's.
/// * Sigmas are the receiver's accuracy estimates. It gives one figure for the horizontal error,
///   which stands for north and for east each, and one for speed, which stands for all three axes;
///   NAV-SOL has but one for position in space, which stands for all three. Each is thus no smaller
///   than the axis's own.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    framer: Framer,
    epoch: Option<Epoch>,
    cycle: Cycle,
    over_ms: Option<u32>,
    /// Told by NAV-TIMEGPS; changes once in years.
    leap_seconds: Option<i8>,
    answer: Option<Acknowledgement>,
    ready: Option<ReceiverFix>,
    counts: Counts,
}

/// What has come of one epoch of an older receiver.
#[derive(Clone, Copy, Debug)]
struct Epoch {
    time_of_week_ms: u32,
    fix: ReceiverFix,
    /// The kind of message that gave the position, and the velocity: the finer one stays.
    position: Kinds,
    velocity: Kinds,
    judged: bool,
    usable: bool,
}

impl Decoder {
    /// Consumes `bytes`, which arrived at `arrival`, up to the end of the next epoch; `None` when
    /// they are used up. Call again until then.
    pub fn read(&mut self, bytes: &mut &[u8], arrival: Time) -> Option<ReceiverFix> {
        if let Some(fix) = self.ready.take() {
            return Some(fix);
        }
        loop {
            let message = self.framer.next(bytes, arrival)?;
            let (class, id, started) = (message.class, message.id, message.arrival);
            let mut payload = [0; 92];
            let length = message.payload.len();
            let room = payload.get_mut(..length)?;
            room.copy_from_slice(message.payload);
            // Receivers of protocol 14 end NAV-PVT before its last fields, which are not used here.
            let length = if (class, id) == (NavPvt::CLASS, NavPvt::ID) { 92 } else { length };
            let Ok(packet) = Proto23::match_packet(class, id, payload.get(..length)?) else {
                self.counts.damaged = self.counts.damaged.saturating_add(1);
                continue;
            };
            self.counts.read = self.counts.read.saturating_add(1);
            let before = self.accept(&packet, started);
            if before.is_some() {
                return before;
            }
            if let Some(fix) = self.ready.take() {
                return Some(fix);
            }
        }
    }

    /// The epoch still being put together, if it is a fix so far: for when the line has fallen
    /// silent until the next, or a log is at its end.
    pub fn flush(&mut self) -> Option<ReceiverFix> {
        self.ready.take().or_else(|| self.finish())
    }

    /// The last answer to a configuration message, once.
    pub fn take_acknowledgement(&mut self) -> Option<Acknowledgement> {
        self.answer.take()
    }

    /// What became of all messages so far. Messages that are not read are passed over unseen.
    #[must_use]
    pub fn counts(&self) -> Counts {
        Counts { damaged: self.counts.damaged.saturating_add(self.framer.broken()), ..self.counts }
    }

    /// Takes in a message. A fix it returns is of the epoch before the message's; one that the
    /// message completes is left in `ready`.
    fn accept(&mut self, packet: &PacketRef<'_>, arrival: Time) -> Option<ReceiverFix> {
        let (kind, time_of_week_ms) = match packet {
            PacketRef::NavPvt(pvt) => return self.accept_whole(pvt, arrival),
            PacketRef::AckAck(ack) => {
                self.answer =
                    Some(Acknowledgement { class: ack.class(), id: ack.msg_id(), accepted: true });
                return None;
            }
            PacketRef::AckNak(nak) => {
                self.answer =
                    Some(Acknowledgement { class: nak.class(), id: nak.msg_id(), accepted: false });
                return None;
            }
            PacketRef::NavPosLlh(position) => (POSITION, position.itow()),
            PacketRef::NavStatus(status) => (STATUS, status.itow()),
            PacketRef::NavDop(dilution) => (DILUTION, dilution.itow()),
            PacketRef::NavSol(solution) => (SOLUTION, solution.itow()),
            PacketRef::NavVelNed(velocity) => (VELOCITY, velocity.itow()),
            PacketRef::NavTimeGps(clock) => (CLOCK, clock.itow()),
            _ => return None,
        };
        let before = self.open(time_of_week_ms, arrival);
        self.cycle.note(kind);
        if let Some(epoch) = &mut self.epoch {
            let added = match packet {
                PacketRef::NavPosLlh(position) => epoch.add_position(position),
                PacketRef::NavVelNed(velocity) => epoch.add_velocity(velocity),
                PacketRef::NavSol(solution) => epoch.add_solution(solution, self.leap_seconds),
                PacketRef::NavStatus(status) => {
                    epoch.add_status(status, self.leap_seconds);
                    Ok(())
                }
                PacketRef::NavDop(dilution) => {
                    epoch.fix.dilution = dilutions(dilution);
                    Ok(())
                }
                PacketRef::NavTimeGps(clock) => {
                    let valid = clock.valid().contains(NavTimeGpsFlags::VALID_LEAP_S);
                    self.leap_seconds = valid.then_some(clock.leap_s()).or(self.leap_seconds);
                    epoch.add_clock(clock, self.leap_seconds);
                    Ok(())
                }
                _ => Ok(()),
            };
            if added.is_err() {
                epoch.judged = true;
                epoch.usable = false;
                self.counts.impossible = self.counts.impossible.saturating_add(1);
            }
        }
        if self.cycle.is_complete() {
            self.ready = self.finish();
        }
        before
    }

    fn accept_whole(&mut self, pvt: &NavPvtRef<'_>, arrival: Time) -> Option<ReceiverFix> {
        let before = self.open(pvt.itow(), arrival);
        self.cycle.note(WHOLE);
        let Some(epoch) = self.epoch.take() else {
            return before;
        };
        self.over_ms = Some(epoch.time_of_week_ms);
        if !is_usable(pvt.fix_type(), pvt.flags().contains(NavPvtFlags::GPS_FIX_OK))
            || pvt.flags3().invalid_llh()
        {
            self.counts.no_fix = self.counts.no_fix.saturating_add(1);
            return before;
        }
        match whole(pvt, epoch.fix.arrival) {
            Ok(fix) => self.ready = Some(fix),
            Err(Impossible) => self.counts.impossible = self.counts.impossible.saturating_add(1),
        }
        before
    }

    /// Makes the epoch of `time_of_week_ms` the present one, unless it is over already; the fix of
    /// the epoch before, if that had not been handed on.
    fn open(&mut self, time_of_week_ms: u32, arrival: Time) -> Option<ReceiverFix> {
        if self.epoch.is_some_and(|epoch| epoch.time_of_week_ms == time_of_week_ms) {
            return None;
        }
        let before = self.finish();
        if self.over_ms != Some(time_of_week_ms) {
            self.cycle.close();
            let nowhere = Horizontal { latitude_rad: 0.0, longitude_rad: 0.0 };
            self.epoch = Some(Epoch {
                time_of_week_ms,
                fix: ReceiverFix::new(arrival, nowhere),
                position: 0,
                velocity: 0,
                judged: false,
                usable: true,
            });
        }
        before
    }

    /// Ends the present epoch; its fix, if it is one.
    fn finish(&mut self) -> Option<ReceiverFix> {
        let epoch = self.epoch.take()?;
        self.over_ms = Some(epoch.time_of_week_ms);
        if !epoch.usable {
            self.counts.no_fix = self.counts.no_fix.saturating_add(1);
        }
        (epoch.usable && epoch.judged && epoch.position != 0).then_some(epoch.fix)
    }
}

impl Epoch {
    fn judge(&mut self, fix_type: GnssFixType, good: bool, corrected: bool) {
        self.judged = true;
        self.usable &= is_usable(fix_type, good);
        self.fix.dimension = dimension(fix_type);
        self.fix.correction =
            Some(if corrected { Correction::Differential } else { Correction::None });
    }

    fn add_status(&mut self, status: &NavStatusRef<'_>, leap_seconds: Option<i8>) {
        let flags = status.flags();
        let good = flags.contains(NavStatusFlags::GPS_FIX_OK);
        self.judge(status.fix_type(), good, flags.contains(NavStatusFlags::DIFF_SOLN));
        if self.fix.time.is_none() && flags.contains(NavStatusFlags::TOW_SET) {
            self.fix.time = gps_time(None, self.time_of_week_ms, 0, leap_seconds);
        }
    }

    fn add_clock(&mut self, clock: &NavTimeGpsRef<'_>, leap_seconds: Option<i8>) {
        let valid = clock.valid();
        if valid.contains(NavTimeGpsFlags::VALID_TOW) {
            let week = Some(clock.week()).filter(|_| valid.contains(NavTimeGpsFlags::VALID_WKN));
            self.fix.time = gps_time(week, self.time_of_week_ms, clock.ftow(), leap_seconds);
        }
    }

    fn add_position(&mut self, position: &NavPosLlhRef<'_>) -> Result<(), Impossible> {
        let place = horizontal(position.lat_degrees(), position.lon_degrees())?;
        self.position = POSITION;
        self.fix.latitude_rad = place.latitude_rad;
        self.fix.longitude_rad = place.longitude_rad;
        self.fix.height_m = Some(height(position.height_meters())?);
        self.fix.altitude_msl_m = Some(height(position.height_msl())?);
        self.fix.position_sigma_m =
            known_sigma(Vector::new(position.h_ack(), position.h_ack(), position.v_acc()));
        Ok(())
    }

    fn add_velocity(&mut self, velocity: &NavVelNedRef<'_>) -> Result<(), Impossible> {
        let ned = [velocity.vel_north(), velocity.vel_east(), velocity.vel_down()];
        let [north, east, down] = plausible_velocity(ned).ok_or(Impossible)?;
        self.velocity = VELOCITY;
        self.fix.set_horizontal_velocity(north, east);
        self.fix.down_velocity_mps = Some(down);
        self.fix.velocity_sigma_mps = on_all_axes(velocity.speed_accuracy_estimate());
        Ok(())
    }

    fn add_solution(
        &mut self,
        solution: &NavSolRef<'_>,
        leap_seconds: Option<i8>,
    ) -> Result<(), Impossible> {
        let flags = solution.flags();
        let good = flags.contains(NavSolFlags::GPS_FIX_OK);
        self.judge(solution.fix_type(), good, flags.contains(NavSolFlags::DIFF_SOLN));
        self.fix.satellites = Some(solution.num_sv());
        self.fix.dilution.position =
            self.fix.dilution.position.or_else(|| dilution(solution.pdop()));
        if flags.contains(NavSolFlags::TOW_SET) {
            let week = Some(solution.week()).filter(|_| flags.contains(NavSolFlags::WKN_SET));
            self.fix.time = gps_time(week, self.time_of_week_ms, solution.ftow_ns(), leap_seconds);
        }
        if !self.usable {
            return Ok(());
        }
        let position: Vector<Ecef> =
            Vector::new(solution.ecef_x(), solution.ecef_y(), solution.ecef_z());
        let place = Geodetic::from_ecef(position).ok_or(Impossible)?;
        if self.position != POSITION {
            let horizontal =
                Horizontal::new(place.latitude_rad, place.longitude_rad).ok_or(Impossible)?;
            self.position = SOLUTION;
            self.fix.latitude_rad = horizontal.latitude_rad;
            self.fix.longitude_rad = horizontal.longitude_rad;
            self.fix.height_m = Some(height(place.height_m)?);
            self.fix.position_sigma_m = on_all_axes(solution.position_accuracy_estimate());
        }
        if self.velocity != VELOCITY {
            let ecef = [solution.ecef_vx(), solution.ecef_vy(), solution.ecef_vz()];
            let ecef: Vector<Ecef> = plausible_velocity(ecef).ok_or(Impossible)?.into();
            let [north, east, down] = (place.ecef_to_ned() * ecef).to_array();
            self.velocity = SOLUTION;
            self.fix.set_horizontal_velocity(north, east);
            self.fix.down_velocity_mps = Some(down);
            self.fix.velocity_sigma_mps = on_all_axes(solution.speed_accuracy_estimate());
        }
        Ok(())
    }
}
