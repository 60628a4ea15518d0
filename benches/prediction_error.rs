//! Time to identify an R-50: 35 parameters, 14 noises, 2000 samples of 8 outputs.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use hovernav_sysid::methods::prediction_error::{Settings, identify};

#[path = "../tests/identification/r50_flight.rs"]
mod r50_flight;

fn r50(criterion: &mut Criterion) {
    let flight = [r50_flight::fly(7, 2000)];
    let wrong = r50_flight::wrong_start(0.2);
    let settings = Settings::innovations(vec![0.5; 6]);
    let mut group = criterion.benchmark_group("prediction_error");
    group.sample_size(10);
    group.bench_function("r50_35_parameters_2000_samples", |bencher| {
        bencher.iter(|| identify(black_box(&wrong), &flight, &settings));
    });
    group.finish();
}

criterion_group!(benches, r50);
criterion_main!(benches);
