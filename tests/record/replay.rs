//! The recorded data equals the flown data.

use std::fs;
use std::path::PathBuf;

use approx::assert_abs_diff_eq;
use hovernav::event::Event;
use hovernav::time::Time;
use hovernav_dataset::{Dataset, Outage};
use hovernav_record::{Call, Entry, Level, Line, Part, Piece, Record, Recorder, ShortText, pieces};
use hovernav_replay::estimate;

use crate::flight::{START, fly, header};

#[test]
fn the_flown_solution_comes_back_bit_for_bit() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("flight.mcap");
    let header = header();
    let mut recorder = Recorder::create(&path, &header).unwrap();
    let flown = fly(&header, &mut recorder, 60.0);
    let status = recorder.finish();
    assert_eq!((status.lost_raw, status.lost_decoded, status.bytes_waiting), (0, 0, 0));
    assert!(flown.len() > 1500, "{}", flown.len());

    let record = Record::open(&path).unwrap();
    assert!(record.is_ended);
    assert_eq!(record.warnings, Vec::<String>::new());
    assert_eq!(record.header, header);

    let mut dataset = Record::open(&path).unwrap().dataset().unwrap();
    assert!(dataset.fixes.len() > 55, "{}", dataset.fixes.len());
    let settings = dataset.settings().unwrap();
    assert_eq!(settings, header.settings().unwrap());
    let replayed = estimate(&dataset, &settings, |_| {}).solutions;
    assert_eq!(replayed, flown);
    let reproduction = record.reproduced_by(&replayed);
    assert_eq!(reproduction.first_difference, None);
    assert_eq!(reproduction.compared, flown.len());

    let kinds: Vec<&str> = record.events.iter().map(|event| event.kind.as_str()).collect();
    for kind in ["dmu_lost", "aligned"] {
        assert!(kinds.contains(&kind), "{kind} in {kinds:?}");
    }
    assert!(record.calls.iter().any(|(_, call)| *call == Call::RestartGps));
    assert!(record.calls.iter().any(|(_, call)| *call == Call::Dmu(Vec::new())));
}

#[test]
fn a_replay_with_other_bytes_is_found_to_differ_and_where() {
    let (path, _dir) = recorded(20.0);
    let mut record = Record::open(&path).unwrap();
    let settings = header().settings().unwrap();
    let solutions =
        |record: &Record| estimate(&record.dataset().unwrap(), &settings, |_| {}).solutions;
    assert_eq!(record.reproduced_by(&solutions(&record)).first_difference, None);
    let from = record.solutions[record.solutions.len() / 2].time;
    record.calls.retain(|(time, call)| !(*time > from && matches!(call, Call::Gps(_))));
    let difference = record.reproduced_by(&solutions(&record)).first_difference.unwrap();
    assert!(difference.time > from && difference.time - from < 1.3, "{difference:?}");
    assert!(difference.distance.unwrap().iter().any(|far| *far > 0.0), "{difference:?}");
}

/// With a frozen inertial unit, each cycle of the flight records the last solution again.
#[test]
fn a_solution_that_the_flight_repeats_is_reproduced() {
    let (path, _dir) = recorded(20.0);
    let mut record = Record::open(&path).unwrap();
    let replayed = record.solutions.clone();
    let repeated = replayed[300];
    record.solutions.splice(300..300, [repeated; 30]);
    assert_eq!(record.reproduced_by(&replayed).first_difference, None);
    record.solutions[310].velocity_mps = record.solutions[310].velocity_mps * 2.0;
    assert_eq!(record.reproduced_by(&replayed).first_difference.unwrap().time, repeated.time);
}

/// Other programs write MCAP files without chunks, and with attachments, here one that is cut within its header.
#[test]
fn a_record_rewritten_without_chunks_has_the_same_entries() {
    let (path, _dir) = recorded(20.0);
    let chunked = fs::read(&path).unwrap();
    let (first, _) = pieces(&chunked).find(|(_, piece)| matches!(piece, Piece::Chunk(_))).unwrap();
    let mut flat = chunked[..first].to_vec();
    flat.extend([&[9_u8][..], &32_u64.to_le_bytes(), &[0; 32]].concat());
    for (_, piece) in pieces(&chunked) {
        if let Piece::Chunk(records) = piece {
            flat.extend_from_slice(&records);
        }
    }
    let (flat, whole) = (Record::read(&flat, &path).unwrap(), Record::open(&path).unwrap());
    assert_eq!(flat.solutions, whole.solutions);
    assert_eq!(flat.calls, whole.calls);
}

#[test]
fn withheld_fixes_leave_the_order_of_all_others() {
    let (path, _dir) = recorded(20.0);
    let whole = Record::open(&path).unwrap().dataset().unwrap();
    let mut thinned = whole.clone();
    let start = whole.fixes[5].time;
    thinned.withhold(&[Outage { start, duration_s: 4.5 }], None);
    let without: Vec<_> = whole
        .events()
        .filter(|event| {
            let since_start = event.time() - start;
            !(whole.fixes.iter().any(|fix| Event::Gps(*fix) == *event)
                && (0.0..4.5).contains(&since_start))
        })
        .collect();
    assert_eq!(whole.fixes.len() - thinned.fixes.len(), 5);
    assert_eq!(thinned.events().collect::<Vec<_>>(), without);
}

#[test]
fn calls_longer_than_an_entry_and_other_entries_come_back() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("short.mcap");
    let mut recorder = Recorder::create(&path, &header()).unwrap();
    let long: Vec<u8> = (0..1000).map(|index| (index % 251) as u8).collect();
    let at = |milliseconds: i64| {
        Time::from_nanoseconds(START.nanoseconds() + milliseconds * 1_000_000 + 1)
    };
    recorder.raw(Line::Gps, &long, at(1));
    recorder.raw(Line::Servo, &[1, 2, 3], at(2));
    recorder.push(at(3), Entry::Controls([0.25, -0.5, 0.0, 1.0]));
    recorder.push(at(4), Entry::event(Level::Warning, "port_lost", "/dev/ttyS1 does not answer"));
    let (level, kind, text) = (Level::Critical, "autopilot", ShortText::new("it descends"));
    recorder.push(at(4), Entry::Event { level, kind, part: Part::Pilot, text });
    recorder.push(at(5), Entry::Servo { captured_ms: [1.5; 5], commanded_ms: [1.25; 5] });
    assert_eq!(recorder.finish().lost_raw, 0);
    let record = Record::open(&path).unwrap();
    assert_eq!(record.calls, [(at(1), Call::Gps(long)), (at(2), Call::Servo(vec![1, 2, 3]))]);
    assert_eq!(record.controls, [(at(3), [0.25, -0.5, 0.0, 1.0])]);
    let [event, grave] = &record.events[..] else { panic!("{:?}", record.events) };
    assert_eq!(
        (event.time, event.level, event.kind.as_str()),
        (at(4), Level::Warning, "port_lost")
    );
    assert_eq!(event.text, "/dev/ttyS1 does not answer");
    assert_eq!((grave.level, grave.part.as_str()), (Level::Critical, "pilot's signal"));
    assert_eq!(record.end, at(5));
}

#[test]
fn another_latency_moves_fixes_and_keeps_the_loops_order() {
    let (path, dir) = recorded(5.0);
    let mut dataset = Record::open(&path).unwrap().dataset().unwrap();
    let kinds = |dataset: &Dataset| {
        let is_imu = |event| matches!(event, Event::Imu(_));
        dataset.events().map(is_imu).collect::<Vec<_>>()
    };
    let (before, order) = (dataset.fixes.clone(), kinds(&dataset));
    let config = dir.path().join("later.toml");
    std::fs::write(&config, "[gps]\nlatency_s = 0.42\n").unwrap();
    dataset.configure(&config).unwrap();
    assert_abs_diff_eq!(before[0].time - dataset.fixes[0].time, 0.3, epsilon = 1e-9);
    assert_eq!(kinds(&dataset), order);
}

#[test]
fn every_message_is_what_its_schema_says() {
    let (path, _dir) = recorded(5.0);
    let bytes = std::fs::read(path).unwrap();
    let mut topics = std::collections::BTreeSet::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        let schema: serde_json::Value = serde_json::from_slice(&schema.data).unwrap();
        let told: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
        for key in told.as_object().unwrap().keys() {
            assert!(schema["properties"].get(key).is_some(), "{key} of {}", message.channel.topic);
        }
        topics.insert(message.channel.topic.clone());
    }
    assert!(topics.len() > 9, "{topics:?}");
}

#[test]
fn no_record_is_written_over() {
    let (path, _dir) = recorded(1.0);
    let before = std::fs::read(&path).unwrap();
    let error = Recorder::create(&path, &header()).unwrap_err().to_string();
    assert!(error.contains("flight.mcap: exists already"), "{error}");
    assert_eq!(std::fs::read(&path).unwrap(), before);
}

/// A recorded flight of this length.
pub fn recorded(duration_s: f64) -> (PathBuf, tempfile::TempDir) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("flight.mcap");
    let mut recorder = Recorder::create(&path, &header()).unwrap();
    fly(&header(), &mut recorder, duration_s);
    let status = recorder.finish();
    assert_eq!(status.lost_raw, 0, "{status:?}");
    (path, dir)
}
