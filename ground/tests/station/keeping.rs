//! The core without a page: damage, an outage, and a sudden end.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{cycle, newest, snapshot};
use approx::assert_abs_diff_eq;
use hovernav_ground::channel::Id;
use hovernav_ground::decode::Protocol;
use hovernav_ground::frames::Rigging;
use hovernav_ground::record;
use hovernav_ground::station::Station;
use hovernav_record::MavlinkConfig;

fn station() -> Station {
    Station::new(Rigging::default(), None, "test")
}

/// Damages each byte with a probability of 10 %, reproducibly.
fn damaged(bytes: &mut [u8], seed: &mut u32) {
    for byte in bytes {
        *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        if *seed >> 8 < (1 << 24) / 10 {
            *byte ^= 1 << (*seed >> 5 & 7);
        }
    }
}

/// Number of complete MAVLink 2 messages in `bytes`.
fn messages(mut bytes: &[u8]) -> usize {
    let mut count = 0;
    while let Some(length) = bytes.get(1) {
        bytes = &bytes[12 + usize::from(*length)..];
        count += 1;
    }
    count
}

#[test]
fn ten_percent_of_damaged_bytes_show_no_wrong_value() {
    let mut seed = 7;
    for protocol in [Protocol::Frames, Protocol::Mavlink] {
        let mut station = Station::new(Rigging::default(), Some(protocol), "test");
        let mut mavlink =
            hovernav_fly::Mavlink::new(MavlinkConfig::default(), hovernav::time::Time::ZERO);
        let mut sent = 0;
        for number in 0..20_000 {
            let time_s = f64::from(number) / 33.0;
            let mut bytes = match protocol {
                Protocol::Frames => cycle(number),
                Protocol::Mavlink => {
                    let mut bytes = Vec::new();
                    mavlink.encode(&snapshot(time_s), &mut bytes);
                    bytes
                }
            };
            sent += match protocol {
                Protocol::Frames => 2,
                Protocol::Mavlink => messages(&bytes),
            };
            damaged(&mut bytes, &mut seed);
            station.receive(&bytes, 1e9 + time_s);
        }
        let link = station.link(1e9 + 700.0);
        println!(
            "{protocol:?}: {} of {sent} frames, {} damaged, {} lost",
            link.frames, link.damaged, link.lost
        );
        assert!(link.damaged > 500);
        let true_at = |id: Id, time_s: f64| {
            let (sin, cos) = (0.5 * time_s).sin_cos();
            match id {
                Id::Roll => 10.0 * sin,
                Id::Pitch => 10.0 * cos,
                Id::VelN => 2.0 * sin,
                Id::Temperature => 31.5,
                _ => 9.0,
            }
        };
        let mut seen = 0;
        for id in [Id::Roll, Id::Pitch, Id::VelN, Id::Temperature, Id::Satellites] {
            for (time_s, value) in station.store.series(id).between(0.0, f64::INFINITY) {
                let expected = true_at(id, time_s - 1e9);
                // Only some MAVLink messages have a time; all others get the time of the last message before.
                let room = if protocol == Protocol::Mavlink { 12.0 } else { 0.2 };
                assert!(
                    value.is_nan() || (value - expected).abs() < room,
                    "{id:?} {value} for {expected}"
                );
                seen += usize::from(!value.is_nan());
            }
        }
        assert!(seen > 0 || protocol == Protocol::Frames, "{seen}");
    }
}

#[test]
fn a_link_that_is_cut_and_comes_back_leaves_a_gap_and_a_note() {
    let mut station = station();
    for number in (0..330).chain(660..990) {
        let arrival_s = 1e9 + f64::from(number) / 33.0;
        station.receive(&cycle(number), arrival_s);
        if number == 329 {
            station.tick(arrival_s + 2.0);
        }
    }
    let points: Vec<_> = station.store.series(Id::Roll).between(0.0, f64::INFINITY).collect();
    assert_eq!(points.iter().filter(|point| point.1.is_nan()).count(), 1);
    assert!(station.store.series(Id::Roll).at(1e9 + 17.0).is_none());
    assert_eq!(station.link(1e9 + 30.0).outages, 1);
    let texts: Vec<_> = station.store.texts_from(0).0.map(|line| line.text.clone()).collect();
    assert_eq!(texts, ["link: frames arrive", "link: no frame for 2 s", "link: frames arrive"]);
}

/// Not a test by itself: the test below runs it in a process and kills that process.
#[test]
#[ignore = "run by the test that ends it"]
fn records_until_killed() {
    let Ok(file) = std::env::var("HOVERNAV_RECORD") else { return };
    let mut station = station();
    station.record(file.as_ref(), "killed").unwrap();
    let start = Instant::now();
    for number in 0.. {
        let time_s = f64::from(number) / 33.0;
        station.receive(&cycle(number), 1e9 + time_s);
        println!("{time_s}");
        let due = Duration::from_secs_f64(time_s);
        std::thread::sleep(due.saturating_sub(start.elapsed()));
    }
}

#[test]
fn a_record_that_is_ended_by_kill_opens_up_to_the_last_200_ms() {
    use std::io::BufRead as _;
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("killed.mcap");
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["keeping::records_until_killed", "--exact", "--ignored", "--nocapture"])
        .env("HOVERNAV_RECORD", &file)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let (mut last_s, mut stall_s): (f64, f64) = (0.0, 0.0);
    let mut before = Instant::now();
    for line in std::io::BufReader::new(child.stdout.take().unwrap()).lines() {
        let flown_s = line.unwrap().parse().unwrap_or(last_s);
        // A busy machine delays the recorder like the flight.
        let elapsed_s = before.elapsed().as_secs_f64();
        if last_s > 0.0 {
            stall_s = stall_s.max(elapsed_s - (flown_s - last_s));
        }
        (before, last_s) = (Instant::now(), flown_s);
        if last_s > 3.0 {
            break;
        }
    }
    // SIGKILL, on Unix.
    child.kill().unwrap();
    child.wait().unwrap();
    let (store, is_cut) = record::read(&file).unwrap();
    let (from_s, to_s) = store.span().unwrap();
    println!("flown {last_s:.3} s, read {:.3} s, stalled for {stall_s:.3} s", to_s - from_s);
    assert!(is_cut);
    assert!(
        last_s - (to_s - from_s) <= 0.2 + stall_s,
        "{last_s} s flown, {} s read",
        to_s - from_s
    );
}

#[test]
fn a_record_cut_at_any_byte_opens_or_says_what_it_is() {
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("whole.mcap");
    let mut station = station();
    station.record(&file, "whole").unwrap();
    for number in 0..20 {
        station.receive(&cycle(number), 1e9 + f64::from(number) / 33.0);
    }
    station.mark(1e9 + 1.0, "here");
    assert_eq!(station.stop_recording().unwrap().fault, None);
    let whole = std::fs::read(&file).unwrap();
    let (store, is_cut) = record::read(&file).unwrap();
    assert!(!is_cut && store.markers_from(0).0.count() == 1);
    assert_abs_diff_eq!(
        store.at(Id::Roll, 1e9 + 0.5),
        station.store.at(Id::Roll, 1e9 + 0.5),
        epsilon = 1e-9
    );
    let cut = place.path().join("cut.mcap");
    for length in (0..whole.len()).step_by(997) {
        std::fs::write(&cut, &whole[..length]).unwrap();
        if let Ok((_, is_cut)) = record::read(&cut) {
            assert!(is_cut, "{length}");
        }
    }
    let mut broken = whole.clone();
    let mut seed = 3;
    damaged(&mut broken, &mut seed);
    std::fs::write(&cut, &broken).unwrap();
    let _ = record::read(&cut);
    // With less damage the reader advances further: to lengths, kinds, names.
    for start in 0..400 {
        let mut broken = whole.clone();
        let mut place = start * 17;
        for step in 1..4 {
            let length = broken.len();
            broken[place % length] ^= 0xff_u8 >> (start % 8);
            place += 7_919 * step;
        }
        std::fs::write(&cut, &broken).unwrap();
        let _ = record::read(&cut);
    }
    // An attachment truncated within its header must not hide the messages after it.
    let attachment: Vec<u8> = [&[9_u8][..], &32_u64.to_le_bytes(), &[0; 32]].concat();
    let mut odd = whole.clone();
    odd.splice(8..8, attachment);
    std::fs::write(&cut, &odd).unwrap();
    assert_eq!(record::read(&cut).unwrap().0.span(), store.span());
    // A file is never overwritten.
    assert!(station.record(&file, "whole").unwrap_err().to_string().contains("whole.mcap"));
}

proptest::proptest! {
    #[test]
    fn any_bytes_are_survived_and_a_frame_after_them_is_received(
        noise in proptest::collection::vec(proptest::prelude::any::<u8>(), 0..4000),
        pieces in 1usize..300,
    ) {
        for protocol in [None, Some(Protocol::Frames), Some(Protocol::Mavlink)] {
            let mut station = Station::new(Rigging::default(), protocol, "test");
            for piece in noise.chunks(pieces) {
                station.receive(piece, 1e9);
            }
            if protocol == Some(Protocol::Frames) {
                station.receive(&[0], 1e9);
                station.receive(&cycle(5), 1e9);
                proptest::prop_assert_eq!(newest(&station, Id::Satellites), 9.0);
            }
        }
    }
}
