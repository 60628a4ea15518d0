//! A flight record that another program has copied.

use std::io::Write as _;
use std::path::Path;

use hovernav::time::Time;
use hovernav_formats::{Format, Options, open};
use hovernav_record::{Entry, FlyConfig, Header, Record, Recorder, repair};

/// An MCAP record: its kind, its length and its content.
fn piece(kind: u8, content: &[u8]) -> Vec<u8> {
    [&[kind][..], &(content.len() as u64).to_le_bytes(), content].concat()
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat()
}

/// The chunk `body`, compressed with lz4.
fn compressed(body: &[u8]) -> Vec<u8> {
    const HEAD: usize = 40;
    let mut packed = lz4_flex::frame::FrameEncoder::new(Vec::new());
    packed.write_all(&body[HEAD..]).unwrap();
    let packed = packed.finish().unwrap();
    let length = (packed.len() as u64).to_le_bytes();
    // Two times, length and checksum of the content.
    piece(6, &[&body[..28], &text("lz4"), &length, &packed].concat())
}

/// The record `bytes` as another program writes it: with its own header, and compressed chunks.
fn copied(bytes: &[u8]) -> Vec<u8> {
    let mut copy = bytes[..8].to_vec();
    copy.extend(piece(1, &[text(""), text("another program")].concat()));
    let mut rest = &bytes[8..];
    while rest.len() > 9 {
        let length = u64::from_le_bytes(rest[1..9].try_into().unwrap()) as usize;
        let (one, after) = rest.split_at(9 + length);
        match one[0] {
            1 => {}
            6 => copy.extend(compressed(&one[9..])),
            _ => copy.extend(one),
        }
        rest = after;
    }
    copy.extend(rest);
    copy
}

#[test]
fn a_record_copied_by_another_program_with_compressed_chunks_opens() {
    let place = tempfile::tempdir().unwrap();
    // A record is named after its file.
    let [path, copy, mended] = ["original", "copy", "mended"].map(|name| {
        let directory = place.path().join(name);
        std::fs::create_dir(&directory).unwrap();
        directory.join("flight.mcap")
    });
    let start = Time::from_seconds(1000.0);
    let header = Header::new(FlyConfig::default(), start, 1_790_000_000_000_000_000);
    let mut recorder = Recorder::create(&path, &header).unwrap();
    for moment in 0..100 {
        let stick = f64::from(moment) / 100.0;
        recorder.push(start + stick, Entry::Controls([stick, 0.0, 0.0, 0.0]));
    }
    recorder.finish();
    let bytes = copied(&std::fs::read(&path).unwrap());
    std::fs::write(&copy, &bytes).unwrap();

    let original = Record::open(&path).unwrap();
    assert_eq!(original.controls.len(), 100);
    assert_eq!(Record::open(&copy).unwrap(), original);
    let log = open(&copy, &Options::default()).unwrap();
    assert_eq!((log.format, log.record.as_ref()), (Format::Record, Some(&original)));

    // A record that is repaired is uncompressed, with the same content.
    repair(&copy, &mended).unwrap();
    assert_eq!(Record::open(&mended).unwrap().controls, original.controls);

    // A damaged byte costs its chunk, and is reported, unless it is not read.
    let mut bytes = bytes;
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    if let Ok(damaged) = Record::read(&bytes, Path::new("copy")) {
        assert!(damaged.controls == original.controls || !damaged.warnings.is_empty());
    }
}
