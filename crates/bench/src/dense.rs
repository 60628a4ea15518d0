//! Reference: the covariance equations of textbooks, with dense matrices.

use std::hint::black_box;

use nalgebra::SMatrix;

use crate::Timed;
use crate::distribution::{Pace, Times};

type P<const N: usize> = SMatrix<f64, N, N>;

fn transition<const N: usize>() -> P<N> {
    let mut phi = P::<N>::identity();
    for i in 0..3 {
        phi[(6 + i, 3 + i)] = 0.03;
        for k in 0..3 {
            phi[(i, 9 + k)] = -0.01;
            phi[(3 + i, 12 + k)] = -0.01;
            phi[(3 + i, k)] = 0.1;
        }
    }
    phi
}

/// Textbook propagation Φ P Φᵀ + Q.
pub fn propagate<const N: usize>(phi: &P<N>, p: &P<N>, q: &P<N>) -> P<N> {
    phi * p * phi.transpose() + q
}

/// Textbook update in Joseph form with three axes at once.
fn update<const N: usize>(h: &SMatrix<f64, 3, N>, p: &P<N>) -> P<N> {
    let r = SMatrix::<f64, 3, 3>::identity();
    let s = h * p * h.transpose() + r;
    let gain = p * h.transpose() * s.try_inverse().unwrap_or(r);
    let a = P::<N>::identity() - gain * h;
    a * p * a.transpose() + gain * r * gain.transpose()
}

fn time<const N: usize>(calls: u64, clock_ns: f64) -> [Timed; 2] {
    let (phi, q) = (transition::<N>(), P::<N>::identity() * 1e-6);
    let start = P::<N>::identity() * 0.01;
    let mut h = SMatrix::<f64, 3, N>::zeros();
    for axis in 0..3 {
        h[(axis, 6 + axis)] = 1.0;
        for k in 0..3 {
            h[(axis, k)] = 0.1;
        }
    }
    let (mut steps, mut updates) = (Times::with_capacity(calls), Times::with_capacity(calls));
    let mut pace = Pace::begin();
    for _ in 0..calls {
        pace.rest();
        let p = black_box(start);
        black_box(steps.time(|| propagate(black_box(&phi), &p, black_box(&q))));
        black_box(updates.time(|| update(black_box(&h), &p)));
    }
    [("dense covariance, one step", steps), ("dense covariance, three axes", updates)].map(
        |(name, times)| Timed {
            name,
            states: N,
            time: times.distribution(clock_ns),
            instructions: None,
        },
    )
}

/// Times of both steps for both filter sizes.
pub fn all(calls: u64, clock_ns: f64) -> Vec<Timed> {
    time::<26>(calls, clock_ns).into_iter().chain(time::<15>(calls, clock_ns)).collect()
}
