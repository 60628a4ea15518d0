//! Time of the Riccati solvers.

use criterion::{Criterion, criterion_group, criterion_main};
use hovernav_design::{care, sampled_lqr};
use hovernav_model::{hover, shipped};
use nalgebra::{DMatrix, DVector};

fn riccati(criterion: &mut Criterion) {
    let model = hover::roll_pitch(&shipped::thesis()).expect("the thesis has roll and pitch");
    let q = DMatrix::from_diagonal(&DVector::from_row_slice(&[1.0, 1.0, 1.0, 1.0, 2.0, 1.0]));
    let r = DMatrix::from_diagonal(&DVector::from_row_slice(&[0.01, 0.001]));
    criterion.bench_function("care, n = 6", |bencher| {
        bencher.iter(|| care(model.a(), model.b(), &q, &r));
    });
    criterion.bench_function("sampled lqr, n = 6, with delay", |bencher| {
        bencher.iter(|| sampled_lqr(&model, &q, &r, 1.0 / 33.0, 0.01));
    });
}

criterion_group!(benches, riccati);
criterion_main!(benches);
