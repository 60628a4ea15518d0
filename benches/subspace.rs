//! Time of one pass of subspace identification.
//!
//! `cargo bench --bench subspace`. Order 4, 1000 samples of one input and one output.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use hovernav_model::{LinearModel, TimeDomain};
use hovernav_sysid::methods::subspace::{
    RefineSettings, SubspaceSettings, Weighting, identify, refine,
};
use hovernav_sysid::record::Experiment;
use nalgebra::{DMatrix, DVector, dmatrix};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Two resonances under white input, with a tenth of noise.
fn record() -> Experiment {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let model = LinearModel {
        a: dmatrix![
            0.9, 0.3, 0.0, 0.0;
            -0.3, 0.9, 0.0, 0.0;
            0.0, 0.0, 0.6, 0.7;
            0.0, 0.0, -0.7, 0.6
        ],
        b: dmatrix![1.0; 0.5; 0.3; -0.8],
        c: dmatrix![1.0, 0.0, 1.0, 0.5],
        d: dmatrix![0.0],
        time: TimeDomain::Discrete { period_s: 0.03 },
    };
    let inputs = DMatrix::from_fn(1000, 1, |_, _| normal());
    let clean = model.simulate(&inputs, &DVector::zeros(4));
    let size = 0.1 * clean.norm() / 1000_f64.sqrt();
    let outputs = clean.map(|value| value + size * normal());
    let name = |name: &str| vec![name.to_owned()];
    Experiment::new("resonances", 0.03, name("u"), name("y"), inputs, outputs)
        .unwrap_or_else(|error| panic!("{error}"))
}

fn subspace(c: &mut Criterion) {
    let record = record();
    for weighting in [Weighting::N4sid, Weighting::Moesp, Weighting::Cva] {
        let settings =
            SubspaceSettings { order: Some(4), weighting, ..SubspaceSettings::default() };
        c.bench_function(&format!("{weighting:?} order 4, 1000 samples"), |b| {
            b.iter(|| identify(black_box(&record), &settings));
        });
    }
    let settings = SubspaceSettings { order: Some(4), ..SubspaceSettings::default() };
    if let Ok(start) = identify(&record, &settings) {
        c.bench_function("refinement order 4, 1000 samples", |b| {
            b.iter(|| refine(black_box(&start), &record, &RefineSettings::default()));
        });
    }
}

criterion_group!(benches, subspace);
criterion_main!(benches);
