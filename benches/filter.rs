//! Time of the filter's kernels, compared with the dense textbook form.
//!
//! `cargo bench --bench filter`. On a machine with other work only the ratios within one run are meaningful; `cargo
//! bench --bench instructions` counts instead.

mod fixtures;

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use hovernav::ekf::layout::{Base, Full, Layout};
use hovernav::frames::Rotation;
use hovernav::scalar::Scalar;
use nalgebra::{SMatrix, UnitQuaternion, Vector3};

use fixtures::Hover;

fn kernels<T: Scalar, L: Layout<N>, const N: usize>(c: &mut Criterion, hover: &Hover, name: &str) {
    let step = fixtures::transition::<T, N>();
    let start = fixtures::covariance::<T, N>();
    let mut p = start;
    c.bench_function(&format!("predict {name}"), |b| {
        b.iter(|| {
            black_box(&mut p).propagate(black_box(&step));
            if p.variance(8) > 1e6 {
                p = start;
            }
        });
    });
    let arms = fixtures::arms::<T>();
    c.bench_function(&format!("update 3 axes {name}"), |b| {
        b.iter_batched_ref(
            || start,
            |p| fixtures::update::<T, L, N>(p, black_box(&arms)),
            BatchSize::SmallInput,
        );
    });

    let (filter, fix, samples) = hover.middle::<L, N, T>();
    c.bench_function(&format!("whole imu step {name}"), |b| {
        let mut flown = filter.clone();
        let mut next = samples.iter();
        b.iter(|| {
            let sample = next.next().unwrap_or_else(|| {
                flown = filter.clone();
                next = samples.iter();
                &samples[0]
            });
            black_box(flown.predict(black_box(sample))).is_ok()
        });
    });
    c.bench_function(&format!("whole gps fix {name}"), |b| {
        b.iter_batched_ref(
            || filter.clone(),
            |filter| filter.update_gps(black_box(&fix)),
            BatchSize::SmallInput,
        );
    });
    let mut group = c.benchmark_group("whole log");
    group.throughput(Throughput::Elements(hover.events.len() as u64)).sample_size(10);
    group.bench_function(name, |b| b.iter(|| hover.run::<L, N, T>()));
}

/// Φ P Φᵀ + Q and Joseph's form over whole matrices.
fn dense<const N: usize>(c: &mut Criterion) {
    type P<const N: usize> = SMatrix<f64, N, N>;
    let mut phi = P::<N>::identity();
    let mut h = SMatrix::<f64, 3, N>::zeros();
    for i in 0..3 {
        phi[(6 + i, 3 + i)] = 0.03;
        h[(i, 6 + i)] = 1.0;
        for k in 0..3 {
            phi[(i, 9 + k)] = -0.03 / 3.0;
            phi[(3 + i, 12 + k)] = -0.03 / 3.0;
            phi[(3 + i, k)] = 0.1;
            h[(i, k)] = 0.1;
        }
    }
    let q = P::<N>::identity() * 1e-6;
    let p = P::<N>::identity() * 0.01;
    c.bench_function(&format!("predict dense {N} f64"), |b| {
        b.iter(|| black_box(&phi) * black_box(&p) * black_box(&phi).transpose() + black_box(&q));
    });
    let r = SMatrix::<f64, 3, 3>::identity();
    c.bench_function(&format!("update 3 axes dense {N} f64"), |b| {
        b.iter(|| {
            let (p, h) = (black_box(&p), black_box(&h));
            let s = h * p * h.transpose() + r;
            let k = p * h.transpose() * s.try_inverse().unwrap();
            let a = P::<N>::identity() - k * h;
            a * p * a.transpose() + k * r * k.transpose()
        });
    });
}

fn attitude(c: &mut Criterion) {
    let (increment, frame) = (fixtures::INCREMENT_RAD, fixtures::FRAME_RAD);
    let mut body_to_ned = Rotation::IDENTITY;
    c.bench_function("quaternion step", |b| {
        b.iter(|| {
            let turns = (black_box(increment).into(), black_box(frame).into());
            body_to_ned = fixtures::turn(body_to_ned, turns.0, turns.1);
            body_to_ned
        });
    });
    let mut textbook = UnitQuaternion::<f64>::identity();
    c.bench_function("quaternion step textbook", |b| {
        b.iter(|| {
            let turn = |angle: [f64; 3]| UnitQuaternion::from_scaled_axis(Vector3::from(angle));
            textbook = turn(black_box(frame)).inverse() * textbook * turn(black_box(increment));
            textbook.renormalize();
            textbook
        });
    });
}

fn all(c: &mut Criterion) {
    let hover = Hover::open();
    kernels::<f64, Base, 16>(c, &hover, "15 f64");
    kernels::<f32, Base, 16>(c, &hover, "15 f32");
    kernels::<f64, Full, 28>(c, &hover, "26 f64");
    kernels::<f32, Full, 28>(c, &hover, "26 f32");
    dense::<15>(c);
    dense::<26>(c);
    attitude(c);
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(1));
    targets = all
}
criterion_main!(benches);
