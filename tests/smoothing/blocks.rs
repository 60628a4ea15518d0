//! Smoothing a log block by block gives the same bits as in one piece.

use std::path::Path;

use hovernav::ekf::layout::Full;
use hovernav::ekf::{Estimator, Smoother};
use hovernav::event::Event;
use hovernav_dataset::Dataset;
use hovernav_replay::{Keep, estimate, estimate_each, smooth, smoothing_bytes};

fn heli_hover() -> Dataset {
    Dataset::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/heli-hover")).unwrap()
}

#[test]
fn blocks_change_no_bit_of_a_smoothed_log() {
    let mut dataset = heli_hover();
    let config = dataset.settings().unwrap();
    let mut estimator = Estimator::<Full, 28>::new(config);
    let mut smoother = Smoother::<Full, 28>::with_capacity(dataset.imu.len());
    for event in dataset.events() {
        estimator.push_traced(&event, &mut smoother, |_| ());
        if let (Event::Imu(_), Some(filter)) = (event, estimator.filter()) {
            smoother.sampled(filter);
        }
    }
    let whole = smoother.smooth();
    let blocks = smooth(&dataset, &config, |_| ()).solutions;
    assert!(whole.len() > 9000, "the log has more than two blocks");
    assert_eq!(whole.len(), blocks.len());
    let differs = whole.iter().zip(&blocks).find(|(whole, block)| whole != block);
    assert_eq!(differs, None);
}

#[test]
fn what_smoothing_takes_grows_with_the_solution_and_hardly_beyond() {
    let mut dataset = heli_hover();
    let sample = dataset.imu[0];
    dataset.imu = vec![sample; 10 * 3600 * 33];
    // Ten hours at 33 Hz.
    assert!(smoothing_bytes(&dataset) < 400_000_000, "{}", smoothing_bytes(&dataset));
}

#[test]
fn every_solution_is_handed_out_while_the_log_is_flown() {
    let mut dataset = heli_hover();
    let config = dataset.settings().unwrap();
    let mut handed_out = Vec::new();
    let run = estimate_each(
        &dataset,
        &config,
        Keep::Thinned,
        |_| (),
        |solution| {
            handed_out.push(*solution);
            Ok::<(), ()>(())
        },
    );
    let run = run.unwrap();
    assert_eq!(run.solutions_thinned, 0);
    assert!(
        run.solutions == handed_out && handed_out == estimate(&dataset, &config, |_| ()).solutions
    );
    let refused = estimate_each(&dataset, &config, Keep::All, |_| (), |_| Err("the disk is full"));
    assert_eq!(refused.err(), Some("the disk is full"));
}
