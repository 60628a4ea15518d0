//! Tests of the kernels against the dense textbook forms.

use nalgebra::{SMatrix, SVector};
use proptest::prelude::*;

use super::*;
use crate::ekf::kernel::layout::{ATTITUDE, Base, Full, GYRO_BIAS, POSITION, VELOCITY};
use crate::matrix::add_scaled;

type Dense<const N: usize> = SMatrix<f64, N, N>;

impl<T: Scalar, const N: usize> Covariance<T, N> {
    /// The mirror is stale, so its entries are NaN and must not be read.
    fn from_dense(dense: &Dense<N>) -> Self {
        let entry = |i, j| if Self::keeps(i, j) { dense[(i, j)] } else { f64::NAN };
        let rows = std::array::from_fn(|i| std::array::from_fn(|j| T::of(entry(i, j))));
        Self { rows, mirrored: false }
    }

    fn keeps(row: usize, column: usize) -> bool {
        row < GYRO_BIAS || column >= GYRO_BIAS
    }

    fn dense(&self) -> Dense<N> {
        Dense::from_fn(|i, j| self.entry(i, j))
    }

    fn is_symmetric(&self) -> bool {
        let mirrors = |i: usize, j: usize| {
            self.rows[i][j] == self.rows[j][i] || !(self.mirrored || Self::keeps(i, j))
        };
        (0..N).all(|i| (0..i).all(|j| mirrors(i, j)))
    }
}

fn dense_sensitivity<T: Scalar, const N: usize>(sensitivity: &Sensitivity<T>) -> SVector<f64, N> {
    let mut dense = SVector::zeros();
    for (state, derivative) in sensitivity.terms() {
        dense[state] += derivative.wide();
    }
    dense
}

/// Numbers in (−1, 1) from a seed.
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(2) + 1;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// A dense positive definite matrix whose one-sigmas span five orders of magnitude.
fn random_covariance<const N: usize>(next: &mut impl FnMut() -> f64) -> Dense<N> {
    let sigmas = SVector::<f64, N>::from_fn(|_, _| 10f64.powf(2.5 * next()));
    let root = Dense::<N>::from_fn(|i, j| sigmas[i] * (next() + f64::from(u8::from(i == j))));
    let dense = root * root.transpose() + Dense::from_diagonal(&sigmas.map(|s| 0.01 * s * s));
    (dense + dense.transpose()) * 0.5
}

fn random_transition<const N: usize>(next: &mut impl FnMut() -> f64) -> Transition<f64, N> {
    let turn = std::array::from_fn(|_| std::array::from_fn(|_| next() * 0.03));
    let noise_block = |scale: f64, root: [f64; 3]| {
        let [a, b, c] = root;
        [a * a, a * b, a * c, b * b, b * c, c * c].map(|v| v * scale)
    };
    Transition {
        interval_s: 0.03,
        turn,
        force: [next() * 0.5, next() * 0.5, next() * 0.5],
        attitude_noise: noise_block(1e-6, [next(), next(), next()]),
        velocity_noise: noise_block(1e-3, [next(), next(), next()]),
        position_noise: std::array::from_fn(|_| 1e-4 * next().abs()),
        relaxation: (next() > 0.0).then(|| random_relaxation(next)),
    }
}

fn random_relaxation<const N: usize>(next: &mut impl FnMut() -> f64) -> Relaxation<f64, N> {
    Relaxation {
        decay: std::array::from_fn(|i| if i < GYRO_BIAS { 1.0 } else { 1.0 - 0.1 * next().abs() }),
        noise: std::array::from_fn(|i| if i < GYRO_BIAS { 0.0 } else { 1e-4 * next().abs() }),
    }
}

/// Textbook Φ from the blocks: position integrates the mean of the velocities at both ends.
fn dense_transition<const N: usize>(step: &Transition<f64, N>) -> Dense<N> {
    let relaxation = step.relaxation.unwrap_or_default();
    let mut phi = Dense::<N>::from_diagonal(&SVector::from(relaxation.decay));
    let [fn_, fe, fd] = step.force;
    let cross = [[0.0, fd, -fe], [-fd, 0.0, fn_], [fe, -fn_, 0.0]];
    for i in 0..3 {
        phi[(POSITION + i, VELOCITY + i)] = step.interval_s;
        for j in 0..3 {
            phi[(ATTITUDE + i, GYRO_BIAS + j)] = -step.turn[i][j];
            phi[(VELOCITY + i, ATTITUDE + j)] = cross[i][j];
            phi[(VELOCITY + i, ACCEL_BIAS + j)] = -step.turn[i][j];
        }
    }
    for i in 0..3 {
        for j in (0..N).filter(|j| !(VELOCITY..GYRO_BIAS).contains(j)) {
            phi[(POSITION + i, j)] += 0.5 * step.interval_s * phi[(VELOCITY + i, j)];
        }
    }
    phi
}

fn dense_noise<const N: usize>(step: &Transition<f64, N>) -> Dense<N> {
    let relaxation = step.relaxation.unwrap_or_default();
    let mut noise = Dense::<N>::from_diagonal(&SVector::from(relaxation.noise));
    for (axis, value) in step.position_noise.iter().enumerate() {
        noise[(POSITION + axis, POSITION + axis)] = *value;
    }
    for (first, [nn, ne, nd, ee, ed, dd]) in
        [(ATTITUDE, step.attitude_noise), (VELOCITY, step.velocity_noise)]
    {
        let block = [[nn, ne, nd], [ne, ee, ed], [nd, ed, dd]];
        for (i, line) in block.iter().enumerate() {
            for (j, value) in line.iter().enumerate() {
                noise[(first + i, first + j)] = *value;
            }
        }
    }
    noise
}

/// Largest difference, each entry in units of its two one-sigmas.
fn difference<const N: usize>(a: &Dense<N>, b: &Dense<N>) -> f64 {
    let mut worst = 0.0;
    for i in 0..N {
        for j in 0..N {
            let scale = (b[(i, i)] * b[(j, j)]).sqrt();
            worst = f64::max(worst, (a[(i, j)] - b[(i, j)]).abs() / scale);
        }
    }
    worst
}

fn propagation_error<const N: usize>(seed: u64) -> f64 {
    let mut next = numbers(seed);
    let start = random_covariance::<N>(&mut next);
    let step = random_transition::<N>(&mut next);
    let mut covariance = Covariance::<f64, N>::from_dense(&start);
    covariance.propagate(&step);
    assert!(covariance.is_symmetric());
    let phi = dense_transition(&step);
    difference(&covariance.dense(), &(phi * start * phi.transpose() + dense_noise(&step)))
}

/// The Joseph form (I − k h) P (I − k h)ᵀ + k R kᵀ (Groves 3.58).
fn joseph<const N: usize>(p: &Dense<N>, h: &SVector<f64, N>, noise: f64) -> Dense<N> {
    let gain = p * h / ((h.transpose() * p * h)[0] + noise);
    let left = Dense::identity() - gain * h.transpose();
    left * p * left.transpose() + gain * gain.transpose() * noise
}

fn random_sensitivity<T: Scalar>(
    terms: usize,
    states: usize,
    next: &mut impl FnMut() -> f64,
) -> Sensitivity<T> {
    (0..terms).fold(Sensitivity::default(), |sensitivity, _| {
        let state = ((next() + 1.0) * 0.5 * states as f64) as usize;
        sensitivity.with(state.min(states - 1), T::of(next()))
    })
}

proptest! {
    #[test]
    fn propagation_is_phi_p_phi_transposed_plus_q(seed: u64) {
        prop_assert!(propagation_error::<16>(seed) < 1e-12);
        prop_assert!(propagation_error::<28>(seed) < 1e-12);
    }

    #[test]
    fn the_update_is_the_joseph_form(seed: u64, terms in 1usize..=20, noise_power in -4.0..4.0) {
        let mut next = numbers(seed);
        let start = random_covariance::<26>(&mut next);
        let sensitivity = random_sensitivity::<f64>(terms, 26, &mut next);
        let h = dense_sensitivity::<f64, 26>(&sensitivity);
        let mut covariance = Covariance::<f64, 26>::from_dense(&start);
        let (projected, variance) = covariance.project(&sensitivity);
        prop_assert!((SVector::from(projected) - start * h).norm() <= 1e-12 * (start * h).norm());
        let noise = variance * 10f64.powf(noise_power);
        let gain = covariance.update(&sensitivity, &projected, variance, noise);
        prop_assert!(covariance.is_symmetric());
        prop_assert!(covariance.is_valid());
        let expected = joseph(&start, &h, noise);
        // Rounding is relative to the covariance before the update.
        let worst = (covariance.dense() - expected)
            .iter()
            .enumerate()
            .map(|(k, off)| off.abs() / (start[(k % 26, k % 26)] * start[(k / 26, k / 26)]).sqrt())
            .fold(0.0, f64::max);
        prop_assert!(worst < 1e-12, "off by {worst}");
        let expected = start * h / ((h.transpose() * start * h)[0] + noise);
        prop_assert!((SVector::from(gain.gain) - expected).norm() <= 1e-12 * expected.norm());
        prop_assert!(gain.innovation_variance == variance + noise);
    }
}

proptest! {
    /// Some measurements are fused, some rejected; a fused one may be far more accurate than the state.
    #[test]
    fn measurements_of_one_moment_are_those_taken_in_one_by_one(
        seed: u64,
        taken in proptest::array::uniform6(any::<bool>()),
        noise_powers in proptest::array::uniform6(-9.0..2.0),
    ) {
        let mut next = numbers(seed);
        let start = random_covariance::<28>(&mut next);
        let sensitivities: [_; MAX_AXES] =
            std::array::from_fn(|n| (n != 4).then(|| random_sensitivity::<f64>(9, 28, &mut next)));
        let innovations = std::array::from_fn(|_| next());
        let mut covariance = Covariance::<f64, 28>::from_dense(&start);
        let each = Sensitivities::Each(sensitivities.each_ref().map(Option::as_ref));
        let mut joint = Joint::<Full, f64, 28>::new(each, innovations);
        joint.project(&mut covariance, 0);
        let (mut expected, mut state) = (start, SVector::<f64, 28>::zeros());
        let (mut gains, mut found) = (Vec::new(), Vec::new());
        let mut on_fused = |_: usize, gain: &Gain<f64, 28>, _: f64| found.push(gain.gain);
        for n in 0..MAX_AXES {
            let Some(sensitivity) = &sensitivities[n] else { continue };
            let h = dense_sensitivity::<f64, 28>(sensitivity);
            let variance = (h.transpose() * expected * h)[0];
            // Rounding is relative to the covariance before the update.
            let before = (h.transpose() * start * h)[0];
            prop_assert!((joint.variance(n) - variance).abs() <= 1e-9 * before);
            let noise = before * 10f64.powf(noise_powers[n]);
            let left = innovations[n] - h.dot(&state);
            let scale = 1.0 + (h.component_mul(&state)).abs().sum();
            prop_assert!((joint.innovation(n) - left).abs() < 1e-6 * scale, "{} {left}", joint.innovation(n));
            if taken[n] {
                let gain = expected * h / (variance + noise);
                let sigma = joint.sigma(n, noise);
                joint.fuse(&mut covariance, n, noise, sigma, &mut on_fused);
                state += gain * left;
                gains.push(gain);
                expected = joseph(&expected, &h, noise);
            }
        }
        joint.settle(&mut covariance, &mut on_fused);
        prop_assert!(gains.len() == found.len());
        for (found, gain) in found.iter().zip(&gains) {
            prop_assert!(difference_of_gains(found, gain, &start) < 1e-6);
        }
        for (n, &corrected) in joint.correction().iter().enumerate() {
            let scale = start[(n, n)].sqrt() + gains.iter().map(|gain| gain[n].abs()).sum::<f64>();
            prop_assert!((corrected - state[n]).abs() < 1e-6 * scale, "{corrected} {}", state[n]);
        }
        prop_assert!(covariance.is_symmetric() && covariance.is_valid());
        prop_assert!(difference_from(&covariance.dense(), &expected, &start) < 1e-9);
    }
}

/// Largest difference of entries, in units of the one-sigmas of `scale`.
fn difference_from<const N: usize>(a: &Dense<N>, b: &Dense<N>, scale: &Dense<N>) -> f64 {
    let off = |(k, off): (usize, &f64)| {
        off.abs() / (scale[(k % N, k % N)] * scale[(k / N, k / N)]).sqrt()
    };
    (a - b).iter().enumerate().map(off).fold(0.0, f64::max)
}

/// Largest difference of gains, each in units of its state's one-sigma, relative to the largest gain in such units.
fn difference_of_gains<const N: usize>(a: &[f64; N], b: &SVector<f64, N>, scale: &Dense<N>) -> f64 {
    let unit = |n: usize| scale[(n, n)].sqrt();
    let largest = (0..N).map(|n| b[n].abs() / unit(n)).fold(0.0, f64::max);
    (0..N).map(|n| (a[n] - b[n]).abs() / unit(n)).fold(0.0, f64::max) / largest
}

#[derive(Clone, Copy)]
enum Form {
    Short,
    Stabilised,
    Joint,
}

/// Whether a covariance in `f32` stays positive definite over sixty measurements. Poorly known states, σ = 100, are
/// measured to a variance of `noise`, each time in a new mixture of `mixed` of them. `form` selects the filter's
/// updates or the short form P − k vᵀ.
fn stays_positive(form: Form, mixed: usize, noise: f32, seed: u64) -> bool {
    let mut covariance = Covariance::<f32, 16>::zero();
    for state in 0..16 {
        covariance.set_variance(state, 1e4);
    }
    let mut next = numbers(seed);
    (0..60).all(|_| {
        let sensitivity = (0..mixed).fold(Sensitivity::default(), |sensitivity, state| {
            sensitivity.with(state, (1.0 + next()) as f32)
        });
        let (projected, variance) = covariance.project(&sensitivity);
        match form {
            Form::Short => {
                let inverse = 1.0 / (variance + noise);
                for (row, &seen) in covariance.rows.iter_mut().zip(&projected) {
                    add_scaled(row, -seen * inverse, &projected);
                }
            }
            Form::Stabilised => {
                let _ = covariance.update(&sensitivity, &projected, variance, noise);
            }
            Form::Joint => {
                let one = [Some(&sensitivity), None, None, None, None, None];
                let mut joint =
                    Joint::<Base, f32, 16>::new(Sensitivities::Each(one), [0.0; MAX_AXES]);
                joint.project(&mut covariance, 0);
                let sigma = joint.sigma(0, noise);
                joint.fuse(&mut covariance, 0, noise, sigma, &mut |_, _, _| {});
                joint.settle(&mut covariance, &mut |_, _, _| {});
            }
        }
        covariance.dense().cholesky().is_some()
    })
}

#[test]
fn in_single_precision_the_update_stays_positive_where_the_short_form_does_not() {
    const TRIALS: usize = 50;
    let survivors = |mixed, noise| {
        let [short, ours, joint] = [Form::Short, Form::Stabilised, Form::Joint].map(|form| {
            let stays = |&seed: &u64| stays_positive(form, mixed, noise, seed);
            (0..TRIALS as u64).filter(stays).count()
        });
        println!(
            "{mixed} mixed, variance {noise}: short form {short}, stabilised {ours}, joint {joint} of \
             {TRIALS}"
        );
        (short, ours.min(joint))
    };
    for mixed in [3, 4, 6] {
        let (short, ours) = survivors(mixed, 0.03);
        assert!(short < TRIALS && ours == TRIALS);
        // At a third of that variance, 24 bits hardly hold the correlations.
        let (short, ours) = survivors(mixed, 0.01);
        assert!(short < TRIALS / 2 && ours > short + TRIALS / 3);
    }
}
