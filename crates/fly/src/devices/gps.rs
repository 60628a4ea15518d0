//! An emulated satellite receiver.

use super::Device;
use super::encode::{self, Epoch};
use super::line::Line;
use crate::serial::Clock;
use hovernav::gps::tsip::{Framer, IoOptions};
use hovernav::gps::{Fix, Protocol};
use hovernav::time::Time;

/// Time of the first fix on the receiver's clock: Friday, 20 March 2026.
const FIRST_TIME_OF_WEEK_MS: i64 = 446_988_000;

/// Interval of TSIP's unsolicited time and health packets, s. Source: Trimble, *Lassen-SK8 System Designer
/// Reference Manual*, 34149-01, appendix A.
const STATUS_S: f64 = 5.0;

/// An emulated receiver at the device's end of a serial line. It sends given fixes.
///
/// The receiver has factory settings and must be configured like a real one:
///
/// | protocol | unsolicited messages | accepted commands | line |
/// |---|---|---|---|
/// | NMEA | RMC, GGA, GSA, VTG | nothing | 38 400 baud, 8-N-1 |
/// | TSIP | 0x4A and 0x56, with 0x41, 0x46, 0x6D, 0x82 | 0x1F, 0x21, 0x24, 0x26, 0x35, 0x8E-20 | 9600 baud, 8-O-1 |
/// | UBX | the sentences of NMEA | CFG-RATE, CFG-MSG; CFG-VALSET is rejected | 38 400 baud, 8-N-1 |
///
/// The receiver sends at the rate of the given fixes and ignores the rate in CFG-RATE. The receiver's clock starts in
/// GPS week 2410, unless [`GpsDevice::with_utc_of`] sets it.
#[derive(Clone, Debug)]
pub struct GpsDevice {
    fixes: Vec<(Time, Epoch)>,
    /// Index of the next fix.
    next: usize,
    dialogue: Dialogue,
    line: Line,
    /// Time of the first fix.
    start: Option<Time>,
    /// The clock that sets the receiver's clock at the next transmission.
    utc: Option<Clock>,
    /// Time by which the receiver's clock was set, ms.
    ahead_ms: i64,
}

/// Protocol and configuration.
#[derive(Clone, Debug)]
enum Dialogue {
    Nmea,
    Tsip { framer: Box<Framer>, options: IoOptions, status: Option<Time> },
    Ubx { received: Vec<u8>, pvt: bool, sentences: Vec<u8> },
}

/// Writes one message of an epoch.
type Writer = fn(&Epoch) -> Vec<u8>;

/// The sentences that a u-blox receiver sends by default, with their ids in CFG-MSG.
const SENTENCES: [(u8, Writer); 4] =
    [(4, encode::nmea_rmc), (0, encode::nmea_gga), (2, encode::nmea_gsa), (5, encode::nmea_vtg)];

impl GpsDevice {
    /// A receiver that will send `fixes`, in time order. The transmission of each fix begins `latency_s` after the time
    /// of the fix. Missing values are sent as typical ones: 8 satellites, one-sigmas of 2.5 m, 4 m and 0.3 m/s. Without
    /// a horizontal velocity no velocity is sent; a missing vertical velocity is sent as 0.
    #[must_use]
    pub fn new(protocol: Protocol, fixes: &[Fix], latency_s: f64) -> Self {
        let (dialogue, line) = match protocol {
            Protocol::Nmea => (Dialogue::Nmea, Line::new(38_400, 10)),
            Protocol::Tsip => {
                let options = IoOptions { position: 0x02, velocity: 0x02, timing: 0, auxiliary: 0 };
                let framer = Box::default();
                (Dialogue::Tsip { framer, options, status: None }, Line::new(9600, 11))
            }
            Protocol::Ubx => {
                let sentences = SENTENCES.map(|(id, _)| id).to_vec();
                let dialogue = Dialogue::Ubx { received: Vec::new(), pvt: false, sentences };
                (dialogue, Line::new(38_400, 10))
            }
        };
        let mut receiver = Self {
            fixes: Vec::new(),
            next: 0,
            dialogue,
            line,
            start: None,
            utc: None,
            ahead_ms: 0,
        };
        for fix in fixes {
            receiver.will_have(fix, latency_s);
        }
        receiver
    }

    /// Sets the receiver's clock to the UTC of `clock` at the first transmission, less up to 1 s, because fixes are at
    /// whole seconds.
    #[must_use]
    pub fn with_utc_of(self, clock: &Clock) -> Self {
        Self { utc: Some(clock.clone()), ..self }
    }

    /// Adds a fix that is later than all others. Its transmission begins `latency_s` after the time of the fix.
    pub fn will_have(&mut self, fix: &Fix, latency_s: f64) {
        let start = *self.start.get_or_insert(fix.time);
        let epoch = epoch(fix, fix.time - start).later_by(self.ahead_ms);
        self.fixes.push((fix.time + latency_s, epoch));
    }

    /// Sends the messages of one fix.
    fn send_epoch(&mut self, epoch: &Epoch, now: Time) {
        let line = &mut self.line;
        match &mut self.dialogue {
            Dialogue::Nmea => {
                for (_, sentence) in SENTENCES {
                    line.send(sentence(epoch), now);
                }
            }
            Dialogue::Tsip { options, status, .. } => {
                if options.position & 0x02 != 0 {
                    let double = options.position & 0x10 != 0;
                    let lla = if double { encode::tsip_lla } else { encode::tsip_coarse_lla };
                    line.send(lla(epoch), now);
                }
                if options.velocity & 0x02 != 0 {
                    line.send(encode::tsip_enu(epoch), now);
                }
                if options.position & 0x20 != 0 {
                    line.send(encode::tsip_superpacket(epoch), now);
                }
                if status.is_none_or(|last| now - last >= STATUS_S) {
                    *status = Some(now);
                    line.send(encode::tsip_time(epoch), now);
                    line.send(encode::tsip_packet(0x46, &[0, 0]), now);
                }
                line.send(encode::tsip_satellites(epoch), now);
                line.send(encode::tsip_packet(0x82, &[2]), now);
            }
            Dialogue::Ubx { pvt, sentences, .. } => {
                if *pvt {
                    line.send(encode::ubx_pvt(epoch), now);
                }
                for (_, sentence) in SENTENCES.iter().filter(|(id, _)| sentences.contains(id)) {
                    line.send(sentence(epoch), now);
                }
            }
        }
    }

    fn advance(&mut self, now: Time) {
        while let Some(&(time, epoch)) = self.fixes.get(self.next)
            && time <= now
        {
            if let Some(clock) = self.utc.take() {
                let ahead_ms = clock.unix_ns() / 1_000_000 - epoch.utc().timestamp_millis();
                self.ahead_ms = ahead_ms.div_euclid(1_000) * 1_000;
                for (_, epoch) in &mut self.fixes {
                    *epoch = epoch.later_by(self.ahead_ms);
                }
                continue;
            }
            self.next += 1;
            self.send_epoch(&epoch, time);
        }
    }
}

/// Data that the receiver sends for `fix`, a fix `since_start_s` after the first one.
fn epoch(fix: &Fix, since_start_s: f64) -> Epoch {
    let time_ms = FIRST_TIME_OF_WEEK_MS + (since_start_s * 1e3).round() as i64;
    let [north, east] = fix.horizontal_velocity_mps.unwrap_or_default();
    let horizontal = |sigma: [f64; 3]| (sigma[0].powi(2) / 2.0 + sigma[1].powi(2) / 2.0).sqrt();
    let position = fix.position_sigma_m.map(|sigma| sigma.to_array());
    Epoch {
        week: encode::WEEK,
        time_of_week_ms: 0,
        latitude_deg: fix.position.latitude_deg(),
        longitude_deg: fix.position.longitude_deg(),
        height_m: fix.position.height_m,
        velocity_ned_mps: fix
            .horizontal_velocity_mps
            .map(|_| [north, east, fix.down_velocity_mps.unwrap_or_default()]),
        horizontal_sigma_m: position.map_or(2.5, horizontal),
        vertical_sigma_m: position.map_or(4.0, |sigma| sigma[2]),
        // The receiver sends one value for three axes: the root mean square of the axes.
        speed_sigma_mps: fix.velocity_sigma_mps.map_or(0.3, |sigma| sigma.norm() / f64::sqrt(3.0)),
        satellites: fix.satellites.unwrap_or(8).clamp(1, 12),
    }
    .later_by(time_ms)
}

impl Device for GpsDevice {
    fn receive(&mut self, mut bytes: &[u8], now: Time) {
        self.advance(now);
        let Self { fixes, next, dialogue, line, .. } = self;
        // The latest fix, for polls.
        let last = fixes.get(next.saturating_sub(1)).map(|(_, epoch)| epoch);
        match dialogue {
            Dialogue::Nmea => {}
            Dialogue::Tsip { framer, options, .. } => {
                while let Some(packet) = framer.next(&mut bytes, now) {
                    match (packet.id, packet.payload) {
                        (0x1F, _) => line.send(encode::tsip_packet(0x45, &[0; 10]), now),
                        (0x21, _) => line.send(last.map_or(Vec::new(), encode::tsip_time), now),
                        (0x24, _) => {
                            line.send(last.map_or(Vec::new(), encode::tsip_satellites), now);
                        }
                        (0x26, _) => {
                            line.send(encode::tsip_packet(0x46, &[0, 0]), now);
                            line.send(encode::tsip_packet(0x4B, &[0, 0, 0]), now);
                        }
                        (0x35, &[position, velocity, timing, auxiliary]) => {
                            *options = IoOptions { position, velocity, timing, auxiliary };
                            line.send(encode::tsip_packet(0x55, packet.payload), now);
                        }
                        (0x35, []) => {
                            let IoOptions { position, velocity, timing, auxiliary } = *options;
                            let echo = [position, velocity, timing, auxiliary];
                            line.send(encode::tsip_packet(0x55, &echo), now);
                        }
                        (0x8E, &[0x20, 0]) => options.position &= !0x20,
                        (0x8E, &[0x20, _]) => options.position |= 0x20,
                        _ => {}
                    }
                }
            }
            Dialogue::Ubx { received, pvt, sentences } => {
                received.extend(bytes);
                while let Some((class, id, payload)) = next_ubx(received) {
                    let accepted = match (class, id, payload.as_slice()) {
                        (0x06, 0x08, [_, _, _, _, _, _]) => true,
                        (0x06, 0x01, &[0x01, 0x07, rate]) => {
                            *pvt = rate > 0;
                            true
                        }
                        (0x06, 0x01, &[0xF0, sentence, rate]) => {
                            sentences.retain(|sent| *sent != sentence);
                            if rate > 0 {
                                sentences.push(sentence);
                            }
                            true
                        }
                        _ => false,
                    };
                    if class == 0x06 {
                        let answer = encode::ubx_message(0x05, accepted.into(), &[class, id]);
                        line.send(answer, now);
                    }
                }
            }
        }
    }

    fn next_transmission(&self) -> Option<Time> {
        let fix = self.fixes.get(self.next).map(|(time, _)| *time);
        self.line.next().into_iter().chain(fix).min()
    }

    fn transmit(&mut self, now: Time, wire: &mut Vec<u8>) {
        self.advance(now);
        self.line.take(now, wire);
    }

    fn span(&self) -> Option<(Time, Time)> {
        self.fixes.first().zip(self.fixes.last()).map(|(first, last)| (first.0, last.0))
    }

    fn is_started(&self) -> bool {
        true
    }
}

/// Longest payload that is parsed, bytes.
const LONGEST_UBX: usize = 256;

/// Removes the next complete UBX message, and invalid bytes before it, from `received`; returns its class, id and
/// payload.
fn next_ubx(received: &mut Vec<u8>) -> Option<(u8, u8, Vec<u8>)> {
    loop {
        let start = received.iter().position(|byte| *byte == 0xB5).unwrap_or(received.len());
        received.drain(..start);
        let &[_, sync, class, id, low, high, ..] = received.as_slice() else { return None };
        let length = usize::from(u16::from_le_bytes([low, high]));
        if sync == 0x62 && length <= LONGEST_UBX {
            let (message, checksum) = received.get(..length + 8)?.split_at(length + 6);
            if encode::ubx_checksum(&message[2..]) == checksum {
                let payload = message[6..].to_vec();
                received.drain(..length + 8);
                return Some((class, id, payload));
            }
        }
        received.drain(..1);
    }
}

#[cfg(test)]
mod tests {
    use hovernav::earth::Geodetic;
    use hovernav::gps::Receiver;

    use super::*;

    #[test]
    fn the_receivers_clock_is_the_computers_from_the_first_transmission_on() {
        let clock = Clock::start();
        let place = Geodetic::from_degrees(1.35, 103.82, 40.0).unwrap();
        let fixes = [10.0, 11.0, 12.0].map(|t| Fix::at(Time::from_seconds(t), place));
        let mut device = GpsDevice::new(Protocol::Nmea, &fixes, 0.1).with_utc_of(&clock);
        let (mut receiver, mut seconds) = (Receiver::new(Protocol::Nmea), Vec::new());
        for t in [10.1, 10.9, 11.1, 11.9, 12.1, 12.9] {
            let (now, mut wire) = (Time::from_seconds(t), Vec::new());
            device.transmit(now, &mut wire);
            let mut bytes = &wire[..];
            while let Some(fix) = receiver.read(&mut bytes, now) {
                let utc_ns = fix.time.and_then(|time| time.unix_ns()).unwrap();
                seconds.push((clock.unix_ns() - utc_ns) as f64 * 1e-9);
            }
        }
        // The second fix is a second later than the first one.
        assert!((0.0..1.5).contains(&seconds[0]), "{seconds:?}");
        assert!((seconds[0] - seconds[1] - 1.0).abs() < 0.3, "{seconds:?}");
    }
}
