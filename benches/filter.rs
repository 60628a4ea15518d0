//! What the filter's kernels cost, beside the dense textbook form.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use hovernav::ekf::covariance::{Covariance, Sensitivity, Transition};
use hovernav::ekf::layout::{Base, Full, Layout};
use hovernav::ekf::scalar::Scalar;
use nalgebra::SMatrix;

fn transition<T: Scalar, const N: usize>() -> Transition<T, N> {
    let mut decay = [T::ONE; N];
    let mut noise = [T::ZERO; N];
    for value in &mut decay[9..] {
        *value = T::of(0.9999);
    }
    for value in &mut noise[9..] {
        *value = T::of(1e-9);
    }
    let matrix = |scale: f64| {
        [[0.5, -0.8, 0.1], [0.8, 0.5, -0.05], [0.0, 0.1, 0.99]]
            .map(|row: [f64; 3]| row.map(|v| T::of(v * scale)))
    };
    Transition {
        interval_s: T::of(0.03),
        turn: matrix(0.03),
        force: [T::of(0.01), T::of(0.02), T::of(-0.3)],
        scaled_rotation: matrix(0.001),
        scaled_velocity: matrix(0.3),
        decay,
        attitude_noise: [1e-8, 0.0, 0.0, 1e-8, 0.0, 1e-8].map(T::of),
        velocity_noise: [1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4].map(T::of),
        noise,
    }
}

fn start<T: Scalar, const N: usize>() -> Covariance<T, N> {
    let mut p = Covariance::zero();
    for state in 0..N {
        p.set_variance(state, 0.01);
    }
    p
}

fn kernels<T: Scalar, L: Layout<N>, const N: usize>(c: &mut Criterion, name: &str) {
    let step = transition::<T, N>();
    let mut p = start::<T, N>();
    c.bench_function(&format!("predict {name}"), |b| {
        b.iter(|| {
            black_box(&mut p).propagate::<L>(black_box(&step));
            if p.variance(8) > 1e6 {
                p = start();
            }
        });
    });
    let mut p = start::<T, N>();
    for _ in 0..100 {
        p.propagate::<L>(&step);
    }
    let settled = p;
    let arms: [Sensitivity<T>; 3] = core::array::from_fn(|axis| {
        Sensitivity::default().with(6 + axis, 1.0).with_block(0, [0.1, 0.2, 0.3])
    });
    c.bench_function(&format!("update 3 axes {name}"), |b| {
        b.iter(|| {
            let mut p = *black_box(&settled);
            for arm in black_box(&arms) {
                let (projected, variance) = p.project(arm);
                black_box(p.update(arm, &projected, variance, T::of(1.0)));
            }
            p
        });
    });
}

fn dense(c: &mut Criterion) {
    type P = SMatrix<f64, 15, 15>;
    let mut phi = P::identity();
    for i in 0..3 {
        phi[(6 + i, 3 + i)] = 0.03;
        for k in 0..3 {
            phi[(i, 9 + k)] = -0.03 / 3.0;
            phi[(3 + i, 12 + k)] = -0.03 / 3.0;
            phi[(3 + i, k)] = 0.1;
        }
    }
    let q = P::identity() * 1e-6;
    let p = P::identity() * 0.01;
    c.bench_function("predict dense 15 f64", |b| {
        b.iter(|| black_box(&phi) * black_box(&p) * black_box(&phi).transpose() + black_box(&q));
    });
    let mut h = SMatrix::<f64, 3, 15>::zeros();
    for axis in 0..3 {
        h[(axis, 6 + axis)] = 1.0;
        for k in 0..3 {
            h[(axis, k)] = 0.1;
        }
    }
    let r = SMatrix::<f64, 3, 3>::identity();
    c.bench_function("update 3 axes dense 15 f64 (Joseph)", |b| {
        b.iter(|| {
            let (p, h) = (black_box(&p), black_box(&h));
            let s = h * p * h.transpose() + r;
            let k = p * h.transpose() * s.try_inverse().unwrap();
            let a = P::identity() - k * h;
            a * p * a.transpose() + k * r * k.transpose()
        });
    });
}

fn all(c: &mut Criterion) {
    kernels::<f64, Base, 16>(c, "15 f64");
    kernels::<f32, Base, 16>(c, "15 f32");
    kernels::<f64, Full, 26>(c, "26 f64");
    kernels::<f32, Full, 26>(c, "26 f32");
    dense(c);
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(std::time::Duration::from_millis(500)).measurement_time(std::time::Duration::from_secs(1));
    targets = all
}
criterion_main!(benches);
