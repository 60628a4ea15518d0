//! A table without names and with far more columns than sensors.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use hovernav_dataset::Dataset;
use hovernav_formats::{Options, Proposal, open};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

const ORIGINAL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../datasets/heli-hover");
/// Total number of columns; ten are used.
const COLUMNS: usize = 200;

fn rows(file: &str) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(Path::new(ORIGINAL).join(file)).unwrap();
    text.lines().skip(1).map(|l| l.split(',').map(|f| f.parse().unwrap()).collect()).collect()
}

#[test]
fn options_that_a_format_does_not_support_are_rejected() {
    let refusal = |options: &Options| open(ORIGINAL.as_ref(), options).unwrap_err().to_string();
    let mut options = Options::default();
    options.gps = Some(0);
    assert!(open(ORIGINAL.as_ref(), &options).is_ok());
    options.gps = Some(1);
    assert!(refusal(&options).contains("found no instance 1; a dataset directory has one of each"));
    options = Options::default();
    options.velocity = Some("/vel".to_owned());
    assert!(refusal(&options).contains("found no topic of velocity"));
}

/// Time, rates and specific force, then arbitrary numbers. Among them are the last fix, and a voltage and a
/// temperature that resemble a position.
#[test]
fn sensors_are_found_among_two_hundred_columns_without_names() {
    let original = Dataset::open(ORIGINAL.as_ref()).unwrap();
    let gps = rows("gps.csv");
    let mut noise = ChaCha8Rng::seed_from_u64(1);
    let mut noise = || f64::from(noise.next_u32()) / f64::from(u32::MAX) - 0.5;
    let mut text = String::new();
    for row in rows("imu.csv") {
        let fix = gps.iter().rev().find(|fix| fix[0] <= row[0]).unwrap_or(&gps[0]);
        let mut values: Vec<f64> = row[..7].to_vec();
        values.extend([12.4 + 0.2 * noise(), 35.0 + 0.1 * noise(), 101.0 * noise()]);
        values.extend(&fix[1..4]);
        values.resize_with(COLUMNS, || 100.0 * noise());
        let fields: Vec<String> = values.iter().map(f64::to_string).collect();
        writeln!(text, "{}", fields.join(";")).unwrap();
    }
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("wide.csv");
    fs::write(&file, text).unwrap();
    let proposal = Proposal::of(&[file]).unwrap();
    let told = proposal.to_string();
    assert!(told.contains("and 178 more"), "{told}");
    let out = place.path().join("mapped");
    proposal.write(&out, false).unwrap();
    let dataset = open(&out, &Options::default()).unwrap().dataset;
    assert_eq!((dataset.imu.len(), dataset.fixes.len()), (original.imu.len(), gps.len()), "{told}");
    for (a, b) in dataset.fixes.iter().zip(&original.fixes) {
        assert!(a.position.displacement_from(&b.position).norm() < 1e-6, "{told}");
    }
}
