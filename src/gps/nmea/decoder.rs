//! One fix per epoch from NMEA sentences.

use super::framer::Framer;
use super::sentence::{
    Content, Geometry, GroundVelocity, Kind, Position, RecommendedMinimum, Rejection, Sentence,
};
use crate::frames::{Ned, Vector};
use crate::gps::cycle::{Cycle, Kinds};
use crate::gps::receiver_fix::plausible_height;
use crate::gps::{DilutionOfPrecision, MessageCounts, ReceiverFix, ReceiverTime};
use crate::scalar::Scalar;
use crate::time::Time;

/// Silence of the serial line that separates two epochs, s. At 10 Hz, an epoch and the silence after it last 100 ms. A
/// loop at 33 Hz reads every 30 ms.
const SILENCE_S: f64 = 0.05;

const GGA: Kinds = 1;
const GNS: Kinds = 2;
const RMC: Kinds = 4;
const VTG: Kinds = 8;
const GSA: Kinds = 16;
const GST: Kinds = 32;

/// Turns NMEA sentences into fixes.
///
/// An epoch is all sentences with one time of day (GGA, GNS, RMC, GST), and the sentences without a time that arrive
/// with them (VTG, GSA). Its fix is delivered once all kinds of sentence of the last epochs have arrived, or when the
/// next epoch starts. The first two fixes are therefore late by an epoch; [`flush`](Self::flush) on a silent line
/// delivers any fix at once.
///
/// * Position comes from GGA, else GNS, else RMC (which has no height). The epoch has no fix if *any* of its sentences
///   reports that there is no fix. GGA reports this by quality 0 or 6 to 8, RMC by status V or mode N, E, M, S or U,
///   and GSA by mode 1. GNS reports it by the lack of a valid mode. RMC and GNS also report it by the navigational
///   status U.
/// * Velocity comes from RMC, or from VTG if the receiver sends no RMC. Down velocity is unknown. At rest many
///   receivers leave the course empty; then only the ground speed is known.
/// * One-sigmas come from GST; without GST they are unknown.
/// * The date comes from RMC, unchecked: a receiver past its week rollover sends a wrong date.
///
/// VTG and GSA belong to the burst in which they arrive. After a silence they begin a burst, before its position;
/// otherwise they belong to the position before them. This requires reading the line at least every 50 ms. A log
/// without arrival times is read correctly if VTG and GSA follow the position.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    framer: Framer,
    epoch: Epoch,
    /// Data of sentences without time at the beginning of a burst.
    leading: Option<Epoch>,
    cycle: Cycle,
    last_arrival: Option<Time>,
    ready: Option<ReceiverFix>,
    counts: MessageCounts,
}

/// Data of an incomplete epoch.
#[derive(Clone, Copy, Debug, Default)]
struct Epoch {
    time_of_day_ns: Option<u64>,
    arrival: Time,
    kinds: Kinds,
    position: Option<Position>,
    minimum: Option<RecommendedMinimum>,
    ground_velocity: Option<GroundVelocity>,
    geometry: Option<Geometry>,
    sigma_m: Option<Vector<Ned>>,
    no_fix: bool,
    over: bool,
}

impl Decoder {
    /// Consumes `bytes`, which arrived at `arrival`, up to the end of the next epoch. `None` when all bytes are
    /// consumed; call again until then.
    pub fn read(&mut self, bytes: &mut &[u8], arrival: Time) -> Option<ReceiverFix> {
        if let Some(fix) = self.ready.take() {
            return Some(fix);
        }
        // Iterations: at most one per byte, because each iteration takes a sentence from `bytes`.
        loop {
            let line = self.framer.next(bytes, arrival)?;
            let started = line.arrival;
            let sentence = Sentence::read(line.body);
            let counter = match sentence {
                Ok(_) => &mut self.counts.read,
                Err(Rejection::Unknown) => &mut self.counts.unknown,
                Err(Rejection::Malformed) => &mut self.counts.damaged,
                Err(Rejection::Impossible) => &mut self.counts.impossible,
            };
            *counter = counter.saturating_add(1);
            let after_silence = self.last_arrival.is_none_or(|last| started - last > SILENCE_S);
            self.last_arrival = Some(arrival);
            let Ok(sentence) = sentence else {
                continue;
            };
            let before = self.accept(&sentence, started, after_silence);
            let completed = self.complete();
            if let Some(before) = before {
                self.ready = completed;
                return Some(before);
            }
            if completed.is_some() {
                return completed;
            }
        }
    }

    /// The fix of the incomplete epoch, if it has a position. Use it when the line is silent until the next epoch, or
    /// at the end of a log.
    pub fn flush(&mut self) -> Option<ReceiverFix> {
        self.ready.take().or_else(|| self.finish())
    }

    /// Counts of all sentences since the start.
    #[must_use]
    pub fn counts(&self) -> MessageCounts {
        MessageCounts {
            damaged: self.counts.damaged.saturating_add(self.framer.broken()),
            ..self.counts
        }
    }

    /// Adds a sentence to its epoch. Returns the fix of the previous epoch if that fix was not delivered.
    fn accept(
        &mut self,
        sentence: &Sentence,
        arrival: Time,
        after_silence: bool,
    ) -> Option<ReceiverFix> {
        let mut before = None;
        if sentence.time_of_day_ns.is_none() {
            if !matches!(sentence.kind, Kind::Vtg | Kind::Gsa) {
                // A receiver that does not know the time has no fix, and its sentence belongs to no epoch.
                self.counts.no_fix = self.counts.no_fix.saturating_add(1);
                return None;
            }
            if after_silence {
                self.leading = Some(Epoch { arrival, ..Epoch::default() });
            }
            if let Some(leading) = &mut self.leading {
                leading.add(sentence);
                return None;
            }
        } else if sentence.time_of_day_ns != self.epoch.time_of_day_ns {
            before = self.finish();
            self.cycle.close();
            let leading = self.leading.filter(|_| !after_silence);
            self.epoch = Epoch {
                time_of_day_ns: sentence.time_of_day_ns,
                ..leading.unwrap_or(Epoch { arrival, ..Epoch::default() })
            };
            self.leading = None;
        } else if let Some(leading) = self.leading.take() {
            // These sentences are not the start of the next burst, but the rest of this burst.
            self.epoch.join(&leading);
        }
        self.epoch.add(sentence);
        self.cycle.note(self.epoch.kinds);
        before
    }

    /// The fix of the current epoch, once all its sentences have arrived.
    fn complete(&mut self) -> Option<ReceiverFix> {
        if self.cycle.is_complete() { self.finish() } else { None }
    }

    /// Ends the current epoch. Returns its fix, if there is one that is not delivered yet.
    fn finish(&mut self) -> Option<ReceiverFix> {
        let time_of_day_ns = self.epoch.time_of_day_ns?;
        if core::mem::replace(&mut self.epoch.over, true) {
            return None;
        }
        let epoch = &self.epoch;
        if epoch.no_fix {
            self.counts.no_fix = self.counts.no_fix.saturating_add(1);
            return None;
        }
        let place = epoch
            .position
            .map(|position| position.place)
            .or_else(|| epoch.minimum.map(|minimum| minimum.place))?;
        let mut fix = ReceiverFix::new(epoch.arrival, place);
        let day = epoch.minimum.and_then(|minimum| minimum.day);
        fix.time = Some(ReceiverTime::Utc { day, time_of_day_ns });
        if let Some(position) = epoch.position {
            fix.altitude_msl_m = position.altitude_msl_m;
            fix.height_m = position
                .altitude_msl_m
                .zip(position.geoid_separation_m)
                .and_then(|(altitude_m, separation_m)| plausible_height(altitude_m + separation_m));
            fix.satellites = position.satellites;
            fix.correction = position.correction;
            fix.dilution.horizontal = position.horizontal_dilution;
        }
        if let Some(Geometry { dimension, dilution }) = epoch.geometry {
            let horizontal = fix.dilution.horizontal.or(dilution.horizontal);
            fix.dilution = DilutionOfPrecision { horizontal, ..dilution };
            fix.dimension = Some(dimension);
        }
        fix.position_sigma_m = epoch.sigma_m;
        // VTG does not replace a lost RMC, because the epoch of a VTG is less certain.
        let ground_velocity = epoch
            .minimum
            .map(|minimum| minimum.ground_velocity)
            .or_else(|| epoch.ground_velocity.filter(|_| self.cycle.expected() & RMC == 0));
        if let Some(GroundVelocity { speed_mps: Some(speed_mps), direction_rad }) = ground_velocity
        {
            fix.ground_speed_mps = Some(speed_mps);
            if let Some(direction_rad) = direction_rad {
                let (sine, cosine) = direction_rad.sincos();
                fix.horizontal_velocity_mps = Some([speed_mps * cosine, speed_mps * sine]);
            } else if speed_mps == 0.0 {
                fix.horizontal_velocity_mps = Some([0.0, 0.0]);
            }
        }
        Some(fix)
    }
}

impl Epoch {
    /// Adds the data of sentences without time.
    fn join(&mut self, leading: &Self) {
        self.kinds |= leading.kinds;
        self.ground_velocity = self.ground_velocity.or(leading.ground_velocity);
        self.geometry = leading.geometry.or(self.geometry);
        self.no_fix |= leading.no_fix;
    }

    fn add(&mut self, sentence: &Sentence) {
        self.kinds |= match sentence.kind {
            Kind::Gga => GGA,
            Kind::Gns => GNS,
            Kind::Rmc => RMC,
            Kind::Vtg => VTG,
            Kind::Gsa => GSA,
            Kind::Gst => GST,
        };
        match sentence.content {
            Content::Gga(position) => self.position = Some(position),
            Content::Gns(position) => {
                self.position.get_or_insert(position);
            }
            Content::Rmc(minimum) => self.minimum = Some(minimum),
            Content::Vtg(ground_velocity) => {
                // A second VTG belongs to an epoch whose position was lost.
                self.ground_velocity.get_or_insert(ground_velocity);
            }
            Content::Gsa(geometry) => self.geometry = Some(geometry),
            Content::Gst(sigma_m) => self.sigma_m = sigma_m,
            Content::NoFix => self.no_fix = true,
        }
    }
}
