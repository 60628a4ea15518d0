//! The smoother, compared with the Rauch-Tung-Striebel smoother in the dense form of textbooks.

use approx::assert_abs_diff_eq;
use hovernav::ekf::covariance::{Gain, Sensitivity, Transition};
use hovernav::ekf::layout::{Base, Full, Layout};
use hovernav::ekf::{Ekf, EkfConfig, Smoother, Solution, Trace};
use hovernav::frames::{EulerAngles, Rotation, Vector};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::ins::{Mounting, NavState, Start};
use hovernav::time::Time;
use nalgebra::{SMatrix, SVector};

use super::field;

/// Steps of the filter, in dense form.
enum Deed<const N: usize> {
    Propagated { phi: SMatrix<f64, N, N>, q: SMatrix<f64, N, N> },
    Updated { h: SVector<f64, N>, gain: SVector<f64, N>, s: f64, innovation: f64 },
    Sampled(Box<Solution>),
}

/// Stores the steps of the filter, for the textbook and for the smoother.
struct Both<L, const N: usize> {
    deeds: Vec<Deed<N>>,
    smoother: Smoother<L, N>,
}

impl<L: Layout<N>, const N: usize> Trace<f64, N> for Both<L, N> {
    fn propagated(&mut self, step: &Transition<f64, N>) {
        let mut phi = SMatrix::<f64, N, N>::identity();
        let mut q = SMatrix::<f64, N, N>::zeros();
        let relaxation = step.relaxation.unwrap_or_default();
        for state in 9..N {
            phi[(state, state)] = relaxation.decay[state];
        }
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            phi[(3 + axis, next)] = step.force[last];
            phi[(3 + axis, last)] = -step.force[next];
            for k in 0..3 {
                phi[(axis, 9 + k)] = -step.turn[axis][k];
                phi[(3 + axis, 12 + k)] = -step.turn[axis][k];
            }
        }
        for axis in 0..3 {
            for state in 0..N {
                let moved = f64::from(state == 3 + axis) + phi[(3 + axis, state)];
                phi[(6 + axis, state)] += 0.5 * step.interval_s * moved;
            }
        }
        for (first, noise) in [(0, step.attitude_noise), (3, step.velocity_noise)] {
            let [nn, ne, nd, ee, ed, dd] = noise;
            let block = [[nn, ne, nd], [ne, ee, ed], [nd, ed, dd]];
            for i in 0..3 {
                for j in 0..3 {
                    q[(first + i, first + j)] = block[i][j];
                }
            }
        }
        for axis in 0..3 {
            q[(6 + axis, 6 + axis)] = step.position_noise[axis];
        }
        for state in 9..N {
            q[(state, state)] = relaxation.noise[state];
        }
        self.deeds.push(Deed::Propagated { phi, q });
        self.smoother.propagated(step);
    }

    fn updated(&mut self, sensitivity: &Sensitivity<f64>, gain: &Gain<f64, N>, innovation: f64) {
        let mut h = SVector::<f64, N>::zeros();
        for (state, derivative) in sensitivity.terms() {
            h[state] += derivative;
        }
        let s = gain.innovation_variance;
        self.deeds.push(Deed::Updated { h, gain: gain.gain.into(), s, innovation });
        self.smoother.updated(sensitivity, gain, innovation);
    }
}

/// Flies ten seconds of a tumbling, accelerating vehicle, and smooths them by both methods.
fn against_the_textbook<L: Layout<N>, const N: usize>() {
    let attitude = Rotation::from_euler(EulerAngles::from_degrees(3.0, -5.0, 40.0));
    let start = Start {
        state: NavState {
            time: Time::ZERO,
            position: field(),
            velocity_mps: Vector::new(1.0, -2.0, 0.3),
            body_to_ned: attitude,
        },
        attitude_sigma_rad: Vector::new(0.03, 0.03, 0.1),
        velocity_sigma_mps: Vector::new(0.3, 0.3, 0.5),
        position_sigma_m: Vector::new(2.0, 2.0, 3.0),
        gyro_bias_radps: Vector::ZERO,
        gyro_bias_sigma_radps: None,
    };
    let fix = |time_s: f64| Fix {
        time: Time::ZERO + time_s,
        position: field().displaced(Vector::new(
            time_s + (3.0 * time_s).sin(),
            -2.0 * time_s + (2.0 * time_s).cos(),
            0.3 * time_s,
        )),
        two_dimensional: false,
        horizontal_velocity_mps: Some([1.0 + 0.2 * (5.0 * time_s).sin(), -2.0]),
        down_velocity_mps: Some(0.3 + 0.1 * (7.0 * time_s).cos()),
        position_sigma_m: None,
        velocity_sigma_mps: None,
        satellites: None,
    };
    let mut filter = Ekf::<L, N>::new(EkfConfig::default(), Mounting::default(), start);
    // The first fix resets variances of states; from then on the dense form contains all steps.
    let _ = filter.update_gps(&fix(0.0));
    let first = *filter.covariance();
    let mut both = Both::<L, N> { deeds: Vec::new(), smoother: Smoother::with_capacity(200) };
    for step in 1..=200 {
        let time_s = 0.05 * f64::from(step);
        let sample = ImuSample::new(
            Time::ZERO + time_s,
            Motion::Rates {
                angular_rate_radps: Vector::new(
                    0.1 * (2.0 * time_s).sin(),
                    0.1 * (3.0 * time_s).cos(),
                    0.05,
                ),
                specific_force_mps2: Vector::new(
                    -0.8 + (1.5 * time_s).sin(),
                    -0.5 + (2.5 * time_s).cos(),
                    -9.7,
                ),
            },
        );
        filter.predict_traced(&sample, &mut both).unwrap();
        if step % 20 == 0 {
            filter.update_gps_traced(&fix(time_s), &mut both).unwrap();
        }
        if step % 7 == 0 {
            let own = filter.state().body_to_ned.turned_in_to(Vector::new(0.004, -0.006, 0.01));
            let _ = filter.update_attitude(sample.time, own, &mut both);
        }
        both.deeds.push(Deed::Sampled(Box::new(filter.solution())));
        both.smoother.sampled(&filter);
        if step % 9 == 0 {
            let _ = filter.update_baro(sample.time, 50.0 + 0.2 * time_s.sin(), &mut both);
        }
    }
    let smoothed = both.smoother.smooth();
    assert_eq!(smoothed.len(), 200);

    // Forward pass. An epoch is one propagation with everything that the filter does until the next propagation.
    struct Epoch<const N: usize> {
        phi: SMatrix<f64, N, N>,
        predicted: (SVector<f64, N>, SMatrix<f64, N, N>),
        filtered: (SVector<f64, N>, SMatrix<f64, N, N>),
        /// The estimate at a sample, with the sample's number and its solution. `None` where only the parameters
        /// advanced in time, before a measurement.
        sampled: Option<(SVector<f64, N>, usize, Solution)>,
    }
    let mut x = SVector::<f64, N>::zeros();
    let mut p = SMatrix::<f64, N, N>::from_fn(|i, j| first.entry(i, j));
    let mut epochs: Vec<Epoch<N>> = Vec::new();
    let (mut updates, mut samples) = (0, 0);
    for deed in &both.deeds {
        match deed {
            Deed::Propagated { phi, q } => {
                x = phi * x;
                p = phi * p * phi.transpose() + q;
                let sampled = None;
                epochs.push(Epoch { phi: *phi, predicted: (x, p), filtered: (x, p), sampled });
            }
            Deed::Updated { h, gain, s, innovation } => {
                updates += 1;
                let textbook = p * h / *s;
                assert!(
                    (textbook - gain).component_div(&(gain.abs().add_scalar(1e-3))).amax() < 1e-6
                );
                let noise = s - (h.transpose() * p * h)[0];
                let kept = SMatrix::<f64, N, N>::identity() - textbook * h.transpose();
                p = kept * p * kept.transpose() + textbook * textbook.transpose() * noise;
                x += textbook * *innovation;
                epochs.last_mut().unwrap().filtered = (x, p);
            }
            Deed::Sampled(solution) => {
                epochs.last_mut().unwrap().sampled = Some((x, samples, **solution));
                samples += 1;
            }
        }
    }
    assert!(updates >= 60);

    // Backward pass: Rauch, Tung and Striebel.
    let (mut x, mut p) = epochs.last().unwrap().filtered;
    for k in (0..epochs.len()).rev() {
        let epoch = &epochs[k];
        if let Some(next) = epochs.get(k + 1) {
            let (predicted, variance) = next.predicted;
            // Scaled to unit variances, so that units do not affect the inverse; exactly known states are separate.
            let scale = variance.diagonal().map(|v| if v > 0.0 { v.sqrt() } else { 1.0 });
            let mut unit =
                SMatrix::<f64, N, N>::from_fn(|i, j| variance[(i, j)] / (scale[i] * scale[j]));
            for i in 0..N {
                unit[(i, i)] = 1.0;
            }
            let inverse = unit.cholesky().unwrap().inverse();
            let inverse =
                SMatrix::<f64, N, N>::from_fn(|i, j| inverse[(i, j)] / (scale[i] * scale[j]));
            let gain = epoch.filtered.1 * next.phi.transpose() * inverse;
            x = epoch.filtered.0 + gain * (x - predicted);
            p = epoch.filtered.1 + gain * (p - variance) * gain.transpose();
        }
        let Some((estimate, sample, causal)) = &epoch.sampled else { continue };
        let correction = x - estimate;
        let block = |first: usize| [0, 1, 2].map(|axis| correction[first + axis]);
        let (k, found) = (sample, &smoothed[*sample]);
        let sigma = |state: usize| p[(state, state)].sqrt();
        let near = |found: [f64; 3], expected: [f64; 3], first: usize| {
            for axis in 0..3 {
                let off = (found[axis] - expected[axis]).abs() / sigma(first + axis);
                assert!(off < 1e-8, "state {} at sample {k}: {off:e} sigmas", first + axis);
            }
        };
        let attitude = causal.body_to_ned.turned_in_to(block(0).into());
        near((found.body_to_ned * attitude.inverse()).rotation_vector().to_array(), [0.0; 3], 0);
        near((found.velocity_mps - causal.velocity_mps).to_array(), block(3), 3);
        let position = causal.position.displaced(block(6).into());
        near(found.position.displacement_from(&position).to_array(), [0.0; 3], 6);
        near((found.gyro_bias_radps - causal.gyro_bias_radps).to_array(), block(9), 9);
        near((found.accel_bias_mps2 - causal.accel_bias_mps2).to_array(), block(12), 12);

        let same = |found: [f64; 3], first: usize| {
            for (axis, found) in found.into_iter().enumerate() {
                let off = (found / sigma(first + axis) - 1.0).abs();
                assert!(off < 1e-8, "sigma {} at sample {k}: {off:e}", first + axis);
            }
        };
        same(found.velocity_sigma_mps.to_array(), 3);
        same(found.position_sigma_m.to_array(), 6);
        same(found.gyro_bias_sigma_radps.to_array(), 9);
        same(found.accel_bias_sigma_mps2.to_array(), 12);
        let (sin, cos) = found.body_to_ned.euler().yaw_rad.sin_cos();
        let pitch = sin * sin * p[(0, 0)] - 2.0 * sin * cos * p[(0, 1)] + cos * cos * p[(1, 1)];
        assert_abs_diff_eq!(found.attitude_sigma_rad[1] / pitch.sqrt(), 1.0, epsilon = 1e-8);
    }
}

#[test]
fn the_smoother_is_the_rauch_tung_striebel_smoother() {
    against_the_textbook::<Full, 28>();
}

#[test]
fn with_the_base_states_alone_too() {
    against_the_textbook::<Base, 16>();
}
