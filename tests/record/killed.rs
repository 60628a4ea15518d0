//! `kill -9` at any moment: the record opens, and at most the last 200 ms are lost.

use std::io::{BufRead, BufReader, Write};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use hovernav::time::Time;
use hovernav_log::record::{Call, Entry, Line, Record, Recorder};

use crate::flight::{START, header};

/// Where the process that is to be killed writes.
const CHILD: &str = "HOVERNAV_RECORD_CHILD";
/// How many are killed.
const KILLS: &str = "HOVERNAV_RECORD_KILLS";
const CYCLE: Duration = Duration::from_millis(30);

/// Records until it is killed, and tells of every entry before it hands it over: its time, and how
/// much later than asked this machine has woken a thread so far, both in ns.
#[test]
fn child() {
    let Some(path) = std::env::var_os(CHILD) else { return };
    let overslept = Arc::new(AtomicU64::new(0));
    let witness = Arc::clone(&overslept);
    thread::spawn(move || {
        loop {
            let (asked, before) = (Duration::from_millis(50), Instant::now());
            thread::park_timeout(asked);
            let late = before.elapsed().saturating_sub(asked).as_nanos() as u64;
            witness.fetch_max(late, Ordering::Relaxed);
        }
    });
    let mut recorder = Recorder::create(&PathBuf::from(path), &header()).unwrap();
    let (begun, mut told) = (Instant::now(), std::io::stderr());
    loop {
        let since_start = begun.elapsed();
        let now = START + since_start.as_secs_f64();
        let late = overslept.load(Ordering::Relaxed);
        writeln!(told, "entry {} {late}", now.nanoseconds()).unwrap();
        recorder.raw(Line::Dmu, &[0xFF; 30], now);
        recorder.push(now, Entry::Controls([0.1; 4]));
        thread::sleep(CYCLE);
    }
}

#[test]
fn a_killed_recorder_loses_at_most_200_ms() {
    let kills = std::env::var(KILLS).map_or(20, |count| count.parse().unwrap());
    let dir = tempfile::tempdir().unwrap();
    // A different moment each time, from before the file exists to a good second later.
    let mut moment = 0x9E37_79B9_7F4A_7C15u64;
    let (mut worst_ns, mut opened) = (0, 0);
    for kill in 0..kills {
        let path = dir.path().join(format!("{kill}.mcap"));
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "killed::child", "--nocapture", "--test-threads=1"])
            .env(CHILD, &path)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let told = BufReader::new(child.stderr.take().unwrap());
        let reader = thread::spawn(move || {
            let entries = told.lines().map_while(Result::ok).filter_map(|line| {
                let mut words = line.strip_prefix("entry ")?.split(' ');
                Some((words.next()?.parse::<i64>().ok()?, words.next()?.parse::<i64>().ok()?))
            });
            entries.collect::<Vec<_>>()
        });
        moment = moment.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        thread::sleep(Duration::from_micros(moment >> 44));
        child.kill().unwrap();
        child.wait().unwrap();
        let told = reader.join().unwrap();
        if !path.exists() {
            assert!(told.is_empty(), "an entry before the record");
            continue;
        }
        let record = Record::open(&path).unwrap();
        opened += 1;
        let recorded: Vec<Time> = record.calls.iter().map(|(time, _)| *time).collect();
        let times: Vec<Time> = told.iter().map(|(time, _)| Time::from_nanoseconds(*time)).collect();
        assert_eq!(recorded, times[..recorded.len()], "what is lost is at the end");
        assert!(record.calls.iter().all(|(_, call)| *call == Call::Dmu(vec![0xFF; 30])));
        if let (Some((first_lost, _)), Some((last, late))) = (told.get(recorded.len()), told.last())
        {
            // A machine too busy to wake threads in time is not the recorder's.
            worst_ns = worst_ns.max(last - first_lost);
            assert!(last - first_lost <= 200_000_000 + late, "{last} {first_lost} {late}");
        }
    }
    println!("{opened} of {kills} records, all opened; at most {} ms lost", worst_ns / 1_000_000);
    assert!(opened > kills / 4);
}
