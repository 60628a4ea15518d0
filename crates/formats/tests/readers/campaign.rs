//! Damaged files of every format, as `.ci/more` runs them: no panic, no hang, and no wrong position without a warning.
//!
//! `HOVERNAV_MUTATIONS` is the number of damaged files, 20 000 by default.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;

use hovernav::ekf::EstimatorConfig;
use hovernav_findings::check_fitness;
use hovernav_formats::{Log, Options, open};
use hovernav_replay::estimate;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::alike::{FORMATS, Flight, written};
use crate::faults::{gga, pvt};

/// Longest time for one file, s. It contains 20 s of flight, and takes some milliseconds.
const LONGEST_S: u64 = 20;
/// Largest error of a position, m. The flight is 3 m long, and the filter's one-sigma covers a drift without fixes.
const LARGEST_ERROR_M: f64 = 50.0;
const LARGEST_SIGMA_M: f64 = 10.0;
/// Largest memory of all readers, kB.
const MAX_MEMORY_KB: u64 = 500_000;

/// Outcome of a damaged file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    Refused,
    /// The file was read like the undamaged file, with the same warnings.
    Unnoticed,
    Warned,
    /// A wrong position with small one-sigmas, which neither the reader reported nor the filter rejected.
    Wrong(String),
}

fn below(random: &mut ChaCha8Rng, limit: usize) -> usize {
    random.next_u64() as usize % limit.max(1)
}

/// Damages `bytes` as disks, serial lines and power failures do.
fn damage(bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    let at = below(random, bytes.len());
    let length = 1 << below(random, 14);
    let end = (at + length).min(bytes.len());
    match below(random, 5) {
        0 => bytes.truncate(at),
        1 => {
            for _ in 0..=below(random, 20) {
                let at = below(random, bytes.len());
                bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= 1 << (at % 8));
            }
        }
        2 => bytes[at..end].fill(0),
        3 => {
            let block = bytes[at..end].to_vec();
            let to = below(random, bytes.len());
            bytes.splice(to..to, block);
        }
        _ => {
            let to = below(random, bytes.len());
            let length = (end - at).min(bytes.len() - to);
            bytes.copy_within(at..at + length, to);
        }
    }
}

/// Reads a log and estimates its flight; `whole` contains the warnings of the undamaged log.
fn examined(path: &Path, whole: &[String]) -> Outcome {
    let Ok(Log { dataset, .. }) = open(path, &Options::default()) else { return Outcome::Refused };
    let is_named = dataset.warnings.iter().any(|warning| !whole.contains(warning));
    let outcome = if is_named { Outcome::Warned } else { Outcome::Unnoticed };
    let away_m = |lat_deg: f64, lon_deg: f64| {
        f64::hypot(lat_deg - 47.0, (lon_deg - 8.0) * 0.682).to_radians() * 6.37e6
    };
    if dataset.imu.is_empty() {
        let far = dataset.fixes.iter().map(|fix| fix.position).find(|position| {
            away_m(position.latitude_deg(), position.longitude_deg()) > LARGEST_ERROR_M
        });
        return match far.filter(|_| !is_named) {
            Some(far) => Outcome::Wrong(format!("a fix at {far:?}")),
            None => outcome,
        };
    }
    let Ok(findings) = check_fitness(&dataset, path) else { return Outcome::Refused };
    let run = estimate(&dataset, &EstimatorConfig::default(), |_| {});
    let wrong = run.solutions.iter().find(|solution| {
        let position = solution.position;
        let sigma = solution.position_sigma_m.to_array();
        away_m(position.latitude_deg(), position.longitude_deg()) > LARGEST_ERROR_M
            && sigma[0].hypot(sigma[1]) < LARGEST_SIGMA_M
    });
    match wrong {
        Some(wrong) if !is_named && findings.is_empty() && run.fixes_compared.rejected == 0 => {
            Outcome::Wrong(format!("{:?} at {:?}", wrong.position, wrong.time))
        }
        _ => outcome,
    }
}

/// Runs [`examined`] in a separate thread, so that a hang or a panic names the file.
fn watched(path: PathBuf, whole: Vec<String>, name: &str) -> Outcome {
    let (done, outcome) = mpsc::channel();
    std::thread::spawn(move || done.send(examined(&path, &whole)));
    let found = outcome.recv_timeout(Duration::from_secs(LONGEST_S));
    found.unwrap_or_else(|error| panic!("{name}: {error}: a panic, or more than {LONGEST_S} s"))
}

/// Peak memory of this process, kB, if the system states it.
fn peak_kb() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse().ok()
}

#[test]
#[ignore = "minutes; .ci/more runs it"]
fn twenty_thousand_damaged_files_give_no_panic_no_hang_and_no_silent_wrong_position() {
    let count = std::env::var("HOVERNAV_MUTATIONS").ok().and_then(|text| text.parse().ok());
    let count: u64 = count.unwrap_or(20_000);
    let flight = Flight::at_rest(1.0);
    let folder = tempfile::tempdir().unwrap();
    let capture = folder.path().join("capture");
    let lines: Vec<u8> = (1000..1300).flat_map(|t| [pvt(t), gga(t)].concat()).collect();
    fs::write(&capture, lines).unwrap();
    let logs = FORMATS.map(|format| written(&flight, format));
    // Format, log, and the files in it that are damaged.
    let mut cases: Vec<(&str, PathBuf, Vec<PathBuf>)> = logs
        .iter()
        .map(|log| {
            let tables =
                |folder: &Path| ["imu.csv", "gps.csv"].map(|name| folder.join(name)).to_vec();
            let files = match log.format {
                "dataset" => tables(&log.path),
                "text" => tables(log.path.parent().unwrap()),
                _ => vec![log.path.clone()],
            };
            (log.format, log.path.clone(), files)
        })
        .collect();
    cases.push(("capture", capture.clone(), vec![capture]));
    let mut tally: BTreeMap<(&str, Outcome), usize> = BTreeMap::new();
    let mut wrong = Vec::new();
    for (format, log, files) in &cases {
        let whole = open(log, &Options::default()).unwrap().dataset.warnings;
        let seeds: Vec<Vec<u8>> = files.iter().map(|file| fs::read(file).unwrap()).collect();
        assert_ne!(watched(log.clone(), whole.clone(), format), Outcome::Refused, "{format}");
        for seed in 0..count.div_ceil(cases.len() as u64) {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let which = below(&mut random, files.len());
            let mut bytes = seeds[which].clone();
            damage(&mut bytes, &mut random);
            fs::write(&files[which], &bytes).unwrap();
            let name = format!("{format}, seed {seed}");
            let outcome = match watched(log.clone(), whole.clone(), &name) {
                Outcome::Wrong(what) => {
                    wrong.push(format!("{name}: {what}"));
                    Outcome::Wrong(String::new())
                }
                outcome => outcome,
            };
            *tally.entry((format, outcome)).or_default() += 1;
            fs::write(&files[which], &seeds[which]).unwrap();
        }
    }
    for ((format, outcome), count) in &tally {
        println!("{format}: {outcome:?}: {count}");
    }
    println!("peak memory: {:?} kB", peak_kb());
    assert!(wrong.is_empty(), "{} silent wrong positions: {wrong:#?}", wrong.len());
    assert!(peak_kb().is_none_or(|peak_kb| peak_kb < MAX_MEMORY_KB), "{:?}", peak_kb());
}

#[test]
#[ignore = "seconds; .ci/more runs it"]
fn files_made_to_be_slow_are_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log");
    let fix = pvt(1000);
    // The file has a whole frame, then starts of frames with the largest length.
    for start in [&[0xD3, 0x03, 0xFF][..], &[0xB5, 0x62, 1, 7, 0xF0, 0x1F], b"$$"] {
        fs::write(&path, [&fix[..], &start.repeat(4_000_000 / start.len())].concat()).unwrap();
        watched(path.clone(), Vec::new(), &format!("{start:?}"));
    }
    let mut writer = mcap::WriteOptions::new().create(fs::File::create(&path).unwrap()).unwrap();
    for schema in ["sensor_msgs/msg/NavSatFix", "std_msgs/msg/Empty"] {
        let schema = writer.add_schema(schema, "ros2msg", b"").unwrap();
        for number in 0..32_000_u16 {
            let name = format!("/{schema}/{number}");
            let channel = writer.add_channel(schema, &name, "cdr", &BTreeMap::new()).unwrap();
            let header = mcap::records::MessageHeader {
                channel_id: channel,
                sequence: 0,
                log_time: 1,
                publish_time: 1,
            };
            writer.write_to_known_channel(&header, &[0, 1, 0, 0]).unwrap();
        }
    }
    writer.finish().unwrap();
    drop(writer);
    watched(path, Vec::new(), "64 000 channels");
}
