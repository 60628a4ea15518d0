//! Bytes dropped, inserted and flipped.
//!
//! A fix is false if it differs from the receiver's data. NMEA and UBX have checksums, which detect any single
//! damaged byte. TSIP has none, so a changed byte with valid parity may change its own fix, but no other.

use std::ops::Range;

use hovernav::gps::quality::{Limits, QualityCheck};
use hovernav::gps::{Protocol, Receiver, ReceiverFix, ReceiverTime};
use hovernav::time::Time;

use hovernav_fly::devices::encode;
use hovernav_fly::devices::encode::Epoch;

const EPOCHS: u32 = 5;
const BUT_THE_LAST: Range<usize> = 0..EPOCHS as usize - 1;
/// The epochs for tests with every value of every byte, only one because the epochs differ in few bytes.
const THE_SECOND: Range<usize> = 1..2;

/// A protocol with the messages of one epoch.
struct Stream {
    name: &'static str,
    protocol: Protocol,
    epoch: fn(&Epoch) -> Vec<u8>,
}

const STREAMS: [Stream; 5] = [
    Stream { name: "NMEA", protocol: Protocol::Nmea, epoch: encode::nmea_epoch },
    Stream { name: "NAV-PVT", protocol: Protocol::Ubx, epoch: encode::ubx_pvt },
    Stream { name: "older UBX", protocol: Protocol::Ubx, epoch: encode::ubx_older },
    Stream { name: "TSIP", protocol: Protocol::Tsip, epoch: encode::tsip_epoch },
    Stream { name: "superpackets", protocol: Protocol::Tsip, epoch: encode::tsip_superpacket },
];

impl Stream {
    fn epochs(&self) -> Vec<Vec<u8>> {
        (0..EPOCHS).map(|index| (self.epoch)(&Epoch::flying(index))).collect()
    }

    /// The fixes of epochs that arrive a second apart.
    fn read(&self, epochs: &[Vec<u8>]) -> Vec<ReceiverFix> {
        let mut receiver = Receiver::new(self.protocol);
        let mut fixes = Vec::new();
        for (second, epoch) in epochs.iter().enumerate() {
            let mut bytes = epoch.as_slice();
            while let Some(fix) = receiver.read(&mut bytes, Time::ZERO + second as f64) {
                fixes.push(fix);
            }
            fixes.extend(receiver.flush());
        }
        fixes
    }
}

/// Whether every value of `fix` is one that the receiver sent for that epoch.
fn is_true(fix: &ReceiverFix) -> bool {
    (0..EPOCHS).map(Epoch::flying).any(|epoch| {
        let near = |a: f64, b: f64, limit: f64| (a - b).abs() <= limit;
        let or_unknown = |a: Option<f64>, b: f64| a.is_none_or(|a| near(a, b, 0.02));
        let [north, east, down] = epoch.velocity_ned_mps.unwrap();
        let utc = (u64::from(epoch.time_of_week_ms) / 1_000 - 18) % 86_400;
        let same_time = match fix.time {
            None => true,
            Some(ReceiverTime::Gps { time_of_week_ns, week, leap_seconds }) => {
                time_of_week_ns == u64::from(epoch.time_of_week_ms) * 1_000_000
                    && week.is_none_or(|week| week == encode::WEEK)
                    && leap_seconds.is_none_or(|leap| leap == encode::LEAP_SECONDS)
            }
            Some(ReceiverTime::Utc { day, time_of_day_ns }) => {
                time_of_day_ns == utc * 1_000_000_000 && day.is_none_or(|day| day == 20_532)
            }
        };
        same_time
            && near(fix.latitude_rad.to_degrees(), epoch.latitude_deg, 1e-7)
            && near(fix.longitude_rad.to_degrees(), epoch.longitude_deg, 1e-7)
            && or_unknown(fix.height_m, epoch.height_m)
            && or_unknown(fix.altitude_msl_m, epoch.height_m - encode::GEOID_SEPARATION_M)
            && or_unknown(fix.horizontal_velocity_mps.map(|v| v[0]), north)
            && or_unknown(fix.horizontal_velocity_mps.map(|v| v[1]), east)
            && or_unknown(fix.ground_speed_mps, north.hypot(east))
            && or_unknown(fix.down_velocity_mps, down)
    })
}

/// Applies `damage` at every byte of the epochs `seconds`, one at a time, and passes the fixes to `check` with the
/// damaged epoch and byte.
fn at_every_byte(
    stream: &Stream,
    seconds: Range<usize>,
    damage: impl Fn(&mut Vec<u8>, usize),
    mut check: impl FnMut(usize, usize, &[ReceiverFix]),
) {
    let intact = stream.epochs();
    for second in seconds {
        for position in 0..intact[second].len() {
            let mut damaged = intact.clone();
            damage(&mut damaged[second], position);
            check(second, position, &stream.read(&damaged));
        }
    }
}

/// The fixes of epochs from the second one after the damaged epoch on.
fn undisturbed(fixes: &[ReceiverFix], damaged: usize) -> Vec<ReceiverFix> {
    let later = |fix: &&ReceiverFix| fix.arrival >= Time::ZERO + (damaged + 2) as f64;
    fixes.iter().filter(later).copied().collect()
}

fn position_and_velocity(fix: &ReceiverFix) -> (f64, f64, Option<f64>, Option<[f64; 2]>) {
    (fix.latitude_rad, fix.longitude_rad, fix.height_m, fix.horizontal_velocity_mps)
}

fn assert_recovers(stream: &Stream, second: usize, intact: &[ReceiverFix], fixes: &[ReceiverFix]) {
    let expected: Vec<_> = undisturbed(intact, second).iter().map(position_and_velocity).collect();
    let found: Vec<_> = undisturbed(fixes, second).iter().map(position_and_velocity).collect();
    assert_eq!(found, expected, "{} after damage in second {second}", stream.name);
}

#[test]
fn an_intact_stream_gives_one_true_fix_an_epoch() {
    for stream in &STREAMS {
        let fixes = stream.read(&stream.epochs());
        assert_eq!(fixes.len(), EPOCHS as usize, "{}", stream.name);
        for fix in &fixes {
            assert!(is_true(fix), "{}: {fix:?}", stream.name);
            assert!(fix.horizontal_velocity_mps.is_some() && fix.height_m.is_some());
        }
    }
}

#[test]
fn a_dropped_byte_never_gives_a_false_fix() {
    for stream in &STREAMS {
        let intact = stream.read(&stream.epochs());
        let shorten = |bytes: &mut Vec<u8>, position: usize| {
            bytes.remove(position);
        };
        at_every_byte(stream, BUT_THE_LAST, shorten, |second, position, fixes| {
            for fix in fixes {
                assert!(is_true(fix), "{} without byte {position}: {fix:?}", stream.name);
            }
            assert_recovers(stream, second, &intact, fixes);
        });
    }
}

/// An inserted byte shifts the rest of a message, and the message's last byte becomes the first of its checksum. In 1
/// of 65 536 cases a UBX checksum is valid by chance. Such a fix has a large error and does not pass the quality
/// checks.
#[test]
fn an_inserted_byte_gives_no_false_fix_but_by_a_checksum_that_holds_by_chance() {
    for stream in &STREAMS {
        let intact = stream.read(&stream.epochs());
        let mut tried = 0;
        let mut by_chance = 0;
        for byte in 0..=255 {
            let insert = |bytes: &mut Vec<u8>, position: usize| bytes.insert(position, byte);
            at_every_byte(stream, THE_SECOND, insert, |second, position, fixes| {
                let mut quality = QualityCheck::new(Limits::default());
                tried += 1;
                for fix in fixes {
                    let good = quality.check(fix).is_empty();
                    if !is_true(fix) {
                        by_chance += 1;
                        assert!(
                            stream.protocol == Protocol::Ubx && !good,
                            "{} with {byte:#04x} at byte {position}: {fix:?}",
                            stream.name
                        );
                    }
                }
                assert_recovers(stream, second, &intact, fixes);
            });
        }
        println!("{}: {by_chance} false fixes of {tried}", stream.name);
        assert!(by_chance <= 3 * tried / 65_536 + 3, "{}: {by_chance} of {tried}", stream.name);
    }
}

#[test]
fn a_changed_byte_never_gets_past_a_checksum_and_spoils_one_tsip_fix_at_most() {
    for stream in &STREAMS {
        let intact = stream.read(&stream.epochs());
        let may_spoil = usize::from(stream.protocol == Protocol::Tsip);
        for mask in 1..=255 {
            let flip = |bytes: &mut Vec<u8>, position: usize| bytes[position] ^= mask;
            at_every_byte(stream, THE_SECOND, flip, |second, position, fixes| {
                let spoilt = fixes.iter().filter(|fix| !is_true(fix));
                assert!(
                    spoilt.clone().count() <= may_spoil,
                    "{} with byte {position} xor {mask:#04x}: {:?}",
                    stream.name,
                    spoilt.collect::<Vec<_>>()
                );
                assert_recovers(stream, second, &intact, fixes);
            });
        }
    }
}

#[test]
fn a_stream_cut_at_any_length_gives_true_fixes_and_goes_on_with_the_next_epoch() {
    for stream in &STREAMS {
        let intact = stream.read(&stream.epochs());
        let cut = |bytes: &mut Vec<u8>, position: usize| bytes.truncate(position);
        at_every_byte(stream, BUT_THE_LAST, cut, |second, position, fixes| {
            for fix in fixes {
                assert!(is_true(fix), "{} cut at byte {position}: {fix:?}", stream.name);
            }
            assert_recovers(stream, second, &intact, fixes);
        });
    }
}

#[test]
fn started_in_the_middle_of_an_epoch_a_decoder_gives_the_next_ones() {
    for stream in &STREAMS {
        let intact = stream.read(&stream.epochs());
        let epochs = stream.epochs();
        for position in 1..epochs[0].len() {
            let mut late = epochs.clone();
            late[0].drain(..position);
            let fixes = stream.read(&late);
            assert!(fixes.iter().all(is_true), "{} from byte {position}", stream.name);
            assert_recovers(stream, 0, &intact, &fixes);
        }
    }
}

#[test]
fn bursts_of_noise_give_no_false_fix_and_cost_two_epochs_at_most() {
    // A linear congruential generator gives the same noise in every run.
    let mut state = 1u64;
    let mut random = move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as u32
    };
    for stream in &STREAMS {
        let intact = stream.read(&stream.epochs());
        for _ in 0..2_000 {
            let mut epochs = stream.epochs();
            let second = random() as usize % (epochs.len() - 1);
            let position = random() as usize % epochs[second].len();
            let length = random() as usize % 400;
            let noise: Vec<u8> = (0..length).map(|_| random() as u8).collect();
            epochs[second].splice(position..position, noise);
            let fixes = stream.read(&epochs);
            let spoilt = fixes.iter().filter(|fix| !is_true(fix)).count();
            assert_eq!(spoilt, 0, "{} with {length} bytes of noise at {position}", stream.name);
            assert_recovers(stream, second, &intact, &fixes);
        }
    }
}
