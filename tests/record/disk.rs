//! A full disk, temporarily or permanently.

use std::io::{self, Write};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use hovernav_record::{Line, Record, Recorder, Status};

use crate::flight::{START, fly, header};

/// Error number of the operating system: no space left on device.
const ENOSPC: i32 = 28;

/// A disk with room for a number of bytes.
#[derive(Clone, Default)]
struct Disk {
    bytes: Arc<Mutex<Vec<u8>>>,
    size: Arc<AtomicUsize>,
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut taken = self.bytes.lock().unwrap();
        let room = self.size.load(Ordering::Relaxed).saturating_sub(taken.len());
        let count = bytes.len().min(room);
        if count == 0 {
            return Err(io::Error::from_raw_os_error(ENOSPC));
        }
        taken.extend_from_slice(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Disk {
    fn of(size: usize) -> Self {
        let disk = Self::default();
        disk.resize(size);
        disk
    }

    fn resize(&self, size: usize) {
        self.size.store(size, Ordering::Relaxed);
    }

    fn record(&self) -> Record {
        Record::read(&self.bytes.lock().unwrap(), Path::new("full.mcap")).unwrap()
    }
}

fn wait_until(recorder: &Recorder, reached: impl Fn(&Status) -> bool) {
    while !reached(&recorder.status()) {
        thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_disk_full_for_a_while_costs_nothing() {
    let disk = Disk::of(40_000);
    let header = header();
    let mut recorder = Recorder::start(disk.clone(), &header).unwrap();
    let flown = fly(&header, &mut recorder, 10.0);
    wait_until(&recorder, |status| status.failed_writes > 0);
    let status = recorder.status();
    assert_eq!((status.os_error, status.bytes_written), (Some(ENOSPC), 40_000));
    assert_eq!(disk.record().warnings.len(), 1, "cut off");
    disk.resize(usize::MAX);
    wait_until(&recorder, |status| status.bytes_waiting == 0 && status.queued == 0);
    let status = recorder.finish();
    assert_eq!((status.lost_raw, status.lost_decoded, status.bytes_waiting), (0, 0, 0));
    let record = disk.record();
    assert_eq!(record.solutions, flown);
    let kinds: Vec<&str> = record.events.iter().map(|event| event.kind.as_str()).collect();
    assert!(kinds.contains(&"record_refused") && kinds.contains(&"record_resumed"), "{kinds:?}");
    let refused = record.events.iter().find(|event| event.kind == "record_refused").unwrap();
    assert!(refused.text.contains("No space left"), "{refused:?}");
}

#[test]
fn a_disk_full_for_good_stops_the_record_and_not_the_flight() {
    let disk = Disk::of(40_000);
    let header = header();
    let mut recorder = Recorder::start(disk.clone(), &header).unwrap();
    let flown = fly(&header, &mut recorder, 10.0);
    assert!(flown.len() > 200);
    let status = recorder.finish();
    assert!(status.bytes_waiting > 0 && status.failed_writes > 0, "{status:?}");
    assert!(!disk.record().is_ended);
}

#[test]
fn every_loss_is_counted_and_reported_once_there_is_room() {
    let disk = Disk::of(40_000);
    let mut recorder = Recorder::start(disk.clone(), &header()).unwrap();
    // More data than memory holds: the queue empties until the disk is full, and then it fills.
    let (mut pushed, mut now) = (0u64, START);
    let mut push = |recorder: &mut Recorder| {
        now = now + 1e-3;
        pushed += 1;
        recorder.raw(Line::Dmu, &[0x55; 256], now);
    };
    while recorder.status().lost_raw < 10 {
        push(&mut recorder);
    }
    let lost = recorder.status().lost_raw;
    disk.resize(usize::MAX);
    wait_until(&recorder, |status| status.queued == 0);
    push(&mut recorder);
    let status = recorder.finish();
    assert_eq!((status.lost_raw, status.bytes_waiting), (lost, 0));
    let record = disk.record();
    assert_eq!(record.lost_raw, lost);
    assert_eq!(record.calls.len() as u64, pushed - lost);
    assert!(record.warnings[0].contains("had no room for"), "{:?}", record.warnings);
    assert!(record.events.iter().any(|event| event.kind == "entries_lost"));
}

#[test]
fn what_a_replay_can_compute_gives_way_first() {
    // No data leave the queue before everything is pushed: the disk rejects all writes after the start.
    let disk = Disk::of(usize::MAX);
    let header = header();
    let mut recorder = Recorder::start(disk.clone(), &header).unwrap();
    let mut now = START;
    while recorder.status().lost_decoded < 100 {
        now = now + 1e-3;
        recorder.raw(Line::Dmu, &[0x55; 30], now);
        for _ in 0..8 {
            recorder.push(now, hovernav_record::Entry::Controls([0.0; 4]));
        }
    }
    assert_eq!(recorder.status().lost_raw, 0);
    let lost = recorder.status().lost_decoded;
    wait_until(&recorder, |status| status.queued == 0);
    recorder.raw(Line::Dmu, &[], now);
    recorder.finish();
    assert_eq!(disk.record().lost_decoded, lost);
    assert_eq!(disk.record().warnings, Vec::<String>::new());
}

/// A slow disk: writing waits for the lock.
struct Hanging(Arc<Mutex<Vec<u8>>>);

impl Write for Hanging {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_disk_that_hangs_does_not_hold_the_loop() {
    let bytes = Arc::new(Mutex::new(Vec::new()));
    let mut recorder = Recorder::start(Hanging(Arc::clone(&bytes)), &header()).unwrap();
    let hanging = bytes.lock().unwrap();
    let mut now = START;
    // This loop would not end if one of these calls waited for the disk.
    while recorder.status().lost_raw < 1000 {
        now = now + 1e-3;
        recorder.raw(Line::Dmu, &[0x55; 30], now);
    }
    drop(hanging);
    let lost = recorder.finish().lost_raw;
    let record = Record::read(&bytes.lock().unwrap(), Path::new("slow.mcap")).unwrap();
    assert!(record.is_ended);
    // The status counts every loss. The record reports losses after which there was room again, which depends on the
    // scheduler.
    assert_eq!(lost, 1000);
    assert!(record.lost_raw <= lost, "{}", record.lost_raw);
}

#[test]
#[cfg(target_os = "linux")]
fn a_disk_full_from_the_start_is_an_error_at_once() {
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let error = Recorder::start(full, &header()).unwrap_err();
    assert_eq!(error.raw_os_error(), Some(ENOSPC));
}

#[test]
fn a_record_that_memory_cannot_hold_ends_on_a_disk_that_is_full_for_good() {
    let disk = Disk::of(40_000);
    let mut recorder = Recorder::start(disk, &header()).unwrap();
    let mut now = START;
    // The data fill the buffer in memory, and then the queue.
    while recorder.status().bytes_waiting < 8 << 20 || recorder.status().lost_raw < 10 {
        let lost = recorder.status().lost_raw;
        now = now + 1e-3;
        recorder.raw(Line::Dmu, &[0x55; 256], now);
        if recorder.status().lost_raw > lost {
            thread::sleep(Duration::from_millis(1));
        }
    }
    // This would not end if it waited for room on the disk.
    let status = recorder.finish();
    assert!(status.bytes_waiting >= 8 << 20 && status.queued > 0, "{status:?}");
}
