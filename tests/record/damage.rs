//! Records that were cut off or damaged, and files that are not records.

use std::path::Path;

use hovernav::time::Time;
use hovernav_findings::findings;
use hovernav_record::{Entry, Record, RecordInfo, Recorder, repair};
use hovernav_replay::estimate;

use crate::flight::{START, header};
use crate::replay::recorded;

fn read(bytes: &[u8]) -> Result<Record, String> {
    Record::read(bytes, Path::new("flight.mcap")).map_err(|error| error.to_string())
}

#[test]
fn a_record_cut_off_at_any_byte_gives_all_that_was_whole() {
    let (path, _dir) = recorded(1.0);
    let bytes = std::fs::read(path).unwrap();
    let whole = read(&bytes).unwrap();
    let mut calls = 0;
    for length in 0..bytes.len() {
        match read(&bytes[..length]) {
            Ok(record) => {
                assert_eq!(record.calls, whole.calls[..record.calls.len()]);
                assert_eq!(record.solutions, whole.solutions[..record.solutions.len()]);
                assert!(record.calls.len() >= calls);
                calls = record.calls.len();
            }
            Err(error) => {
                assert!(calls == 0 && error.starts_with("flight.mcap: at byte "), "{error}");
                assert!(error.contains("expected"), "{error}");
            }
        }
    }
    assert_eq!(calls, whole.calls.len());
}

#[test]
fn a_spoilt_byte_never_becomes_a_wrong_value() {
    let (path, _dir) = recorded(1.0);
    let mut bytes = std::fs::read(path).unwrap();
    let whole = read(&bytes).unwrap();
    for index in (0..bytes.len()).step_by(3) {
        bytes[index] ^= 1 << (index % 8);
        if let Ok(record) = read(&bytes) {
            let mut originals = whole.calls.iter();
            assert!(record.calls.iter().all(|call| originals.any(|original| original == call)));
            let is_less = record.calls.len() < whole.calls.len();
            assert!(!is_less || !record.warnings.is_empty(), "byte {index}");
            assert_eq!(record.header, whole.header);
        }
        bytes[index] ^= 1 << (index % 8);
    }
}

/// Cuts at any position, also between two records.
#[test]
fn a_record_that_is_cut_off_reports_it() {
    let (path, _dir) = recorded(1.0);
    let bytes = std::fs::read(path).unwrap();
    let (at, length) = *chunks(&bytes).last().unwrap();
    for end in [at + length - 1, at + length, at + length + 1] {
        let record = read(&bytes[..end]).unwrap();
        assert!(!record.is_ended);
        let told = record.warnings.iter().any(|warning| warning.contains("cut off"));
        assert!(told, "{end}: {:?}", record.warnings);
    }
}

/// Offset of each chunk of a record, and its length including its header.
fn chunks(bytes: &[u8]) -> Vec<(usize, usize)> {
    let mut at = 8;
    let mut found = Vec::new();
    while at + 9 <= bytes.len() - 8 {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize + 9;
        if bytes[at] == mcap::records::op::CHUNK {
            found.push((at, length));
        }
        at += length;
    }
    found
}

/// A record of a second in chunks of 20 cycles.
fn of_many_chunks(dir: &Path) -> Vec<u8> {
    let path = dir.join("flight.mcap");
    let mut recorder = Recorder::create(&path, &header()).unwrap();
    for moment in 0..240 {
        let stick = f64::from(moment) / 240.0;
        recorder.push(START + stick, Entry::Controls([stick, 0.0, 0.0, 0.0]));
        // A chunk is written every 50 ms.
        if moment % 20 == 19 {
            std::thread::sleep(std::time::Duration::from_millis(70));
        }
    }
    recorder.finish();
    std::fs::read(path).unwrap()
}

#[test]
fn a_chunk_whose_length_is_damaged_costs_that_chunk_alone() {
    let dir = tempfile::tempdir().unwrap();
    let good = of_many_chunks(dir.path());
    let whole = read(&good).unwrap();
    let chunks = chunks(&good);
    assert!(chunks.len() > 4, "{chunks:?}");
    let (at, _) = chunks[chunks.len() / 2];
    let (next, _) = chunks[chunks.len() / 2 + 1];
    // Lengths that are longer than the file, too long, too short, or 0.
    for (byte, bits) in [(8, 0x40), (3, 0x01), (2, 0x01), (1, 0x03), (2, 0xff)] {
        let mut bytes = good.clone();
        bytes[at + byte] ^= bits;
        let record = read(&bytes).unwrap();
        let lost = whole.controls.len() - record.controls.len();
        // A chunk that is complete according to its own lengths is kept, independent of the bytes before it.
        assert!(lost < 100, "{byte}: {lost} of {}", whole.controls.len());
        assert!(record.is_ended);
        assert_eq!(record.controls.last(), whole.controls.last());
        let read_on = "bytes skipped, reading continues at the chunk at byte ";
        let told = record.warnings.iter().find(|one| one.contains(read_on));
        let told = told.unwrap_or_else(|| panic!("{byte}: {:?}", record.warnings));
        if byte == 8 {
            assert!(lost > 0 && told.contains(&format!("at byte {at}: ")), "{told}");
            assert!(told.ends_with(&format!("{read_on}{next}")), "{told}");
        }

        let damaged = dir.path().join(format!("damaged-{byte}-{bits}.mcap"));
        let mended = dir.path().join(format!("mended-{byte}-{bits}.mcap"));
        std::fs::write(&damaged, &bytes).unwrap();
        let repaired = repair(&damaged, &mended).unwrap();
        assert!(repaired.warnings.iter().any(|one| one.contains(read_on)), "{repaired:?}");
        let again = Record::open(&mended).unwrap();
        assert_eq!(again.controls, record.controls);
    }
}

/// The damage is a length that points to a later record, and a chunk that claims to be the end of the file.
#[test]
fn a_length_that_grew_and_a_false_end_cost_no_more_than_what_they_hide() {
    let dir = tempfile::tempdir().unwrap();
    let bytes = of_many_chunks(dir.path());
    let whole = read(&bytes).unwrap();
    let chunks = chunks(&bytes);
    let middle = chunks.len() / 2;
    let (at, length) = chunks[middle];
    let (later, _) = chunks[middle + 2];
    let grown = |length: u64| {
        let mut spoilt = bytes.clone();
        spoilt[at + 1..at + 9].copy_from_slice(&length.to_le_bytes());
        spoilt
    };
    let mut false_end = bytes.clone();
    false_end[at] = mcap::records::op::FOOTER;
    for spoilt in [grown((length - 9 + 1000) as u64), grown((later - at - 9) as u64), false_end] {
        let found = read(&spoilt).unwrap();
        assert!(
            found.warnings.iter().any(|one| one.contains(&at.to_string())),
            "{:?}",
            found.warnings
        );
        assert_eq!(found.controls.last(), whole.controls.last());
        let lost = whole.controls.len() - found.controls.len();
        assert!((1..100).contains(&lost), "{lost} of {}", whole.controls.len());
    }
}

#[test]
fn nonsense_with_a_good_checksum_is_skipped_or_reported() {
    let (path, _dir) = recorded(1.0);
    let bytes = std::fs::read(path).unwrap();
    let crc32 = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
    let mut random = 1u64;
    let mut below = |end: usize| {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (random >> 33) as usize % end
    };
    let (mut read_whole, mut refused) = (0, 0);
    for round in 0..600 {
        let mut spoilt = bytes.clone();
        let mut at = mcap::MAGIC.len();
        while at < spoilt.len() - mcap::MAGIC.len() {
            let length = u64::from_le_bytes(spoilt[at + 1..at + 9].try_into().unwrap()) as usize;
            let (kind, body) = (spoilt[at], at + 9);
            // The offsets are those of a chunk's two times, length, checksum, compression, and length again.
            let (checksum, records) = (body + 24, body + 40);
            if kind == mcap::records::op::CHUNK {
                for _ in 0..1 + round % 4 {
                    spoilt[records + below(length - 40)] = below(256) as u8;
                }
                let sum = crc32.checksum(&spoilt[records..body + length]);
                spoilt[checksum..checksum + 4].copy_from_slice(&sum.to_le_bytes());
            }
            at = body + length;
        }
        match read(&spoilt) {
            Ok(record) => {
                read_whole += 1;
                let _ = RecordInfo(&record).to_string();
                let _ = record.reproduced_by(&record.solutions);
                let _ = record.dataset();
            }
            Err(error) => {
                refused += 1;
                assert!(error.starts_with("flight.mcap: "), "{error}");
            }
        }
    }
    assert!(read_whole > 50 && refused > 50, "{read_whole} {refused}");
}

#[test]
fn what_is_no_record_is_named_with_the_byte() {
    let found = |bytes: &[u8]| read(bytes).unwrap_err();
    assert_eq!(found(b""), "flight.mcap: at byte 0: found nothing, expected an MCAP file");
    assert_eq!(
        found(b"t_s,gyro_x_radps\n"),
        "flight.mcap: at byte 0: found \"t_s,gyro\", expected an MCAP file"
    );
    let mut foreign = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
    foreign.finish().unwrap();
    let foreign = foreign.into_inner().into_inner();
    let error = found(&foreign);
    assert!(error.ends_with("expected a flight record of hovernav"), "{error}");
}

#[test]
fn a_record_of_nothing_but_its_configuration_opens() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("empty.mcap");
    Recorder::create(&path, &header()).unwrap().finish();
    let record = Record::open(&path).unwrap();
    assert!(record.is_ended && record.calls.is_empty() && record.warnings.is_empty());
    assert!(record.dataset().unwrap().imu.is_empty());
}

#[test]
fn damage_to_the_first_chunks_costs_them_and_not_the_record() {
    let (path, _dir) = recorded(12.0);
    let mut bytes = std::fs::read(path).unwrap();
    let whole = read(&bytes).unwrap();
    // The damage is in the configuration, and in the names of the topics.
    for at in [200, 1_000, 3_000] {
        bytes[at] ^= 0x10;
    }
    let record = read(&bytes).unwrap();
    assert_eq!(record.header, whole.header);
    assert!(!record.warnings.is_empty());
    assert!(record.solutions.len() > whole.solutions.len() / 4, "{}", record.solutions.len());
    let mut originals = whole.calls.iter();
    assert!(record.calls.iter().all(|call| originals.any(|original| original == call)));
}

/// Viewers that open a file by its summary require this.
#[test]
fn a_repaired_record_has_a_summary_and_every_whole_message() {
    let (path, dir) = recorded(1.0);
    let bytes = std::fs::read(path).unwrap();
    let (cut, out) = (dir.path().join("cut.mcap"), dir.path().join("whole.mcap"));
    std::fs::write(&cut, &bytes[..bytes.len() * 2 / 3]).unwrap();
    let is_summed = |path: &Path| {
        mcap::Summary::read(&std::fs::read(path).unwrap()).is_ok_and(|summary| summary.is_some())
    };
    assert!(!is_summed(&cut));
    let repaired = repair(&cut, &out).unwrap();
    assert!(repaired.warnings.iter().any(|warning| warning.contains("cut off")), "{repaired:?}");
    assert!(is_summed(&out));

    let before = Record::open(&cut).unwrap();
    let after = Record::open(&out).unwrap();
    let but = Record {
        repair: None,
        damages: before.damages.clone(),
        warnings: before.warnings.clone(),
        ..after.clone()
    };
    assert_eq!(Record { header: before.header.clone(), ..but }, before);

    // The file is complete, and states that the original record was not.
    let told = after.repair.as_ref().unwrap();
    assert_eq!(*told, repaired.repair);
    assert_eq!(told.bytes, (bytes.len() * 2 / 3) as u64);
    assert!(!after.is_ended && after.damages.is_empty() && !told.was_ended);
    let lost: usize = before.damages.iter().map(|damage| damage.bytes).sum();
    assert_eq!(told.bytes_lost, lost as u64);
    assert!(after.warnings.len() >= before.warnings.len(), "{:?}", after.warnings);
    assert!(after.warnings[0].contains("before its repair, at byte "), "{:?}", after.warnings);
    let info = RecordInfo(&after).to_string();
    assert!(info.contains("cut off") && info.contains("repaired  by hovernav "), "{info}");

    // If the repaired record is damaged and repaired again, it reports both repairs.
    let mut spoilt = std::fs::read(&out).unwrap();
    spoilt.truncate(spoilt.len() - 20);
    let (twice, again) = (dir.path().join("spoilt.mcap"), dir.path().join("again.mcap"));
    std::fs::write(&twice, spoilt).unwrap();
    repair(&twice, &again).unwrap();
    let told = Record::open(&again).unwrap().repair.unwrap();
    assert_eq!(told.damages.len(), before.damages.len() + 1, "{told:?}");
    assert_eq!((told.bytes, told.was_ended), ((bytes.len() * 2 / 3) as u64, false));

    // Repairing a complete record adds no warning to the new one.
    let (path, _dir) = recorded(0.3);
    repair(&path, &dir.path().join("same.mcap")).unwrap();
    let same = Record::open(&dir.path().join("same.mcap")).unwrap();
    assert!(same.is_ended && same.warnings.is_empty(), "{:?}", same.warnings);
    assert_eq!(same.repair.map(|repair| repair.bytes_lost), Some(0));
    assert!(repair(&cut, &out).unwrap_err().to_string().contains("whole.mcap"));
}

/// One call has a time that no flight has. No output may hang or need unlimited memory.
#[test]
fn a_time_that_cannot_be_costs_little() {
    let (path, _dir) = recorded(20.0);
    let whole = Record::open(&path).unwrap();
    let settings = whole.header.settings().unwrap();
    for nanoseconds in [i64::MAX, i64::MIN, -1, i64::MAX / 2, 3_600_000_000_000_000] {
        let mut record = whole.clone();
        let middle = record.calls.len() / 2;
        record.calls[middle].0 = Time::from_nanoseconds(nanoseconds);
        let dataset = record.dataset().unwrap();
        assert!(dataset.imu.len() <= whole.calls.len());
        let _ = hovernav_findings::Survey::of(&dataset).to_string();
        let run = estimate(&dataset, &settings, |_| {});
        let _ = findings(&dataset, &run);
        assert!(run.solutions.len() <= dataset.imu.len());
        assert!(run.solutions.iter().all(|solution| solution.velocity_mps.is_finite()));
    }
}
