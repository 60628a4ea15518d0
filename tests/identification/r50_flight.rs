//! An R-50 in a closed loop at 100 Hz, excited by multisines, with process and measurement noise.

use hovernav_sysid::helicopter::ModelStructure;
use hovernav_sysid::methods::structure::Structure;
use hovernav_sysid::record::Experiment;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::{Distribution as _, StandardNormal};

pub const PERIOD_S: f64 = 0.01;
/// Standard deviation of the measurement noise, in the order of the structure's outputs: m/s, m/s, m/s, rad/s …
pub const MEASUREMENT_SIGMA: [f64; 8] = [0.03, 0.03, 0.03, 0.01, 0.01, 0.01, 0.003, 0.003];
/// Standard deviation of the process noise per sample, m/s² and rad/s².
pub const PROCESS_SIGMA: [f64; 6] = [0.2, 0.2, 0.3, 0.3, 0.2, 0.3];

/// Flies Mettler's R-50 for `samples`.
pub fn fly(seed: u64, samples: usize) -> Experiment {
    let structure = ModelStructure::built_in("r50").unwrap().equations;
    let matrices = structure.at(&structure.start());
    let (n, m) = (structure.states.len(), structure.inputs.len());
    // The discretisation is exact for held inputs: the exponential of the augmented matrix.
    let mut augmented = DMatrix::zeros(n + m + 6, n + m + 6);
    augmented.view_mut((0, 0), (n, n)).copy_from(&matrices.a);
    augmented.view_mut((0, n), (n, m)).copy_from(&matrices.b);
    augmented.view_mut((0, n + m), (n, 6)).copy_from(&structure.noise_input(&structure.start()));
    let map = (augmented * PERIOD_S).exp();
    let (phi, gamma) = (map.view((0, 0), (n, n)), map.view((0, n), (n, m + 6)));

    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let mut state = DVector::<f64>::zeros(n);
    let mut inputs = DMatrix::zeros(samples, m);
    let mut outputs = DMatrix::zeros(samples, 8);
    for sample in 0..samples {
        let time_s = sample as f64 * PERIOD_S;
        let seen = &matrices.c * &state;
        for output in 0..8 {
            outputs[(sample, output)] = seen[output] + MEASUREMENT_SIGMA[output] * normal();
        }
        let [u, v, phi_rad, theta_rad] = [0, 1, 6, 7].map(|output| seen[output]);
        let stick = [
            multisine(time_s, 0) - 0.8 * phi_rad - 0.08 * v,
            multisine(time_s, 1) + 0.8 * theta_rad - 0.04 * u,
            multisine(time_s, 2),
            multisine(time_s, 3),
        ];
        let mut driven = DVector::zeros(m + 6);
        for input in 0..m {
            inputs[(sample, input)] = stick[input];
            driven[input] = stick[input];
        }
        for (noise, sigma) in PROCESS_SIGMA.iter().enumerate() {
            driven[m + noise] = sigma * normal();
        }
        state = phi * state + gamma * driven;
    }
    Experiment::new("r50", PERIOD_S, structure.inputs, structure.outputs, inputs, outputs)
        .expect("a simulated flight is finite")
}

/// Sum of eight sines with frequencies of 0.5 to 17.4 rad/s. Each axis has its own frequencies, so that the responses
/// to the axes are separable.
fn multisine(time_s: f64, axis: usize) -> f64 {
    (0..8)
        .map(|harmonic| {
            let rate = 0.5 * 1.6_f64.powi(harmonic) * (1.0 + 0.1 * axis as f64);
            let phase = f64::from(harmonic * harmonic) * 0.8 + axis as f64;
            0.05 * (rate * time_s + phase).sin()
        })
        .sum()
}

/// The structure with start values wrong by `fraction`, alternately up and down.
pub fn wrong_start(fraction: f64) -> Structure {
    let mut structure = ModelStructure::built_in("r50").unwrap().equations;
    for (index, parameter) in structure.parameters.iter_mut().enumerate() {
        let sign = if index % 2 == 0 { 1.0 } else { -1.0 };
        parameter.start *= 1.0 + sign * fraction;
    }
    structure
}
