//! Parameters from the response to signals that are injected on the sticks.
//!
//! A pilot or controller in hover responds to gusts, and perceives them before noisy measurements show them. The sticks
//! are therefore correlated with later innovations. The likelihood assumes that the controller, too, observes a gust only
//! in the innovations, and finds sticks that are too weak and too late. The injected signals are independent of gusts: at
//! the true parameters the innovations are uncorrelated with every response to them.
//!
//! # Source
//! Söderström and Stoica (1983), *Instrumental Variable Methods for System Identification*, chapter 4; refined, in a
//! closed loop: Gilson, Garnier, Young and Van den Hof (2008), *IET Control Theory & Applications* 2(1). Equation (I33)
//! of docs/equations.md.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::dropping::{Ended, described};
use super::error::PredictionErrorError;
use super::estimates::Status;
use super::identified::Identified;
use super::identify::{problem, records, with_known};
use super::problem::Problem;
use super::settings::Settings;
use super::statistics::{MAX_OVERCONFIDENCE, correlated_scatter, projected, shares};
use crate::methods::least_squares::Cost;
use crate::record::Experiment;

/// Time constants of the low-passes that represent the responses to an injected signal, s.
const LAGS_S: [f64; 4] = [0.1, 0.3, 1.0, 3.0];
/// Longest delay of the delayed signals that represent the rest of the responses, s.
const LATE_S: f64 = 0.3;
/// Number of delayed signals.
const DELAYED: usize = 10;
/// Largest number of steps of the search.
const STEPS: usize = 20;
/// Starts of the search: samples by which a delay is shorter than that of the likelihood, which is often too long.
const EARLIER: [f64; 4] = [0.0, 1.0, 2.0, 3.0];
/// Step of every parameter, in units of its bound, below which the search ends.
const SMALL: f64 = 0.02;

/// `found` with the parameters of its structure estimated again, from the response to the signal `injected`. This is an
/// input of the experiments, not of the structure. The noises keep their values. Results `known` of another method enter
/// as in [`identify_with`](super::identify_with). `None` where nothing was injected, or where no search converged.
///
/// The search starts at several delays, a sample apart. The result counts after which the innovations contain least of
/// the response to the injected signal.
///
/// # Errors
/// See [`PredictionErrorError`].
pub fn identify_from_injected(
    found: &Identified,
    injected: &str,
    known: &[(usize, f64, f64)],
    experiments: &[Experiment],
    settings: &Settings,
) -> Result<Option<Identified>, PredictionErrorError> {
    let structure = &with_known(&found.structure, known);
    let Some(basis) = Basis::of(experiments, injected) else { return Ok(None) };
    let explained = basis.explained(experiments);
    let (flown, responses) = (records(structure, experiments)?, records(structure, &explained)?);
    let mut flown = problem(structure, &flown, experiments, settings)?;
    let mut responses = problem(structure, &responses, &explained, settings)?;
    let own = found.estimates.free.iter().copied();
    let free: Vec<usize> = own.filter(|&index| index < structure.parameters.len()).collect();
    let lags = (settings.residual_correlation_s / flown.period_s).round() as usize;
    let mut best: Option<Solved> = None;
    for earlier in EARLIER {
        for problem in [&mut flown, &mut responses] {
            problem.base.clone_from(&found.theta);
            problem.free.clone_from(&free);
            for delay in structure.delays.iter().flatten().filter(|own| free.contains(own)) {
                let delay_s = found.theta[*delay] - earlier * problem.period_s;
                problem.base[*delay] = delay_s.max(problem.lower[*delay]);
            }
        }
        let solved = Solved::search(&flown, &responses, &basis, lags, settings.widened);
        let least = best.as_ref().map_or(f64::INFINITY, |best| best.left);
        best = solved.filter(|solved| solved.left < least).or(best);
    }
    let Some(best) = best else { return Ok(None) };
    let mut solved = best.put_into(found, &flown)?;
    solved.structure.clone_from(&found.structure);
    Ok(Some(solved))
}

/// Delayed copies and low-passes of an injected signal in each experiment.
struct Basis {
    all: Vec<DMatrix<f64>>,
    solver: Cholesky<f64, Dyn>,
}

impl Basis {
    /// `None` where nothing was injected.
    fn of(experiments: &[Experiment], injected: &str) -> Option<Self> {
        let mut all: Vec<DMatrix<f64>> =
            experiments.iter().map(|own| responses(own, injected)).collect();
        let squares = |all: &[DMatrix<f64>]| all.iter().map(|own| own.tr_mul(own)).sum();
        let size = DMatrix::diagonal(&squares(&all)).map(f64::sqrt);
        if size.min() <= 0.0 {
            return None;
        }
        for own in &mut all {
            own.column_iter_mut().zip(size.iter()).for_each(|(mut own, size)| own /= *size);
        }
        let regular = DMatrix::identity(size.len(), size.len()) * 1e-8;
        let solver = Cholesky::new(squares(&all) + regular)?;
        Some(Self { all, solver })
    }

    /// The part of every signal of `experiments` that is a linear response to the injected signal.
    fn explained(&self, experiments: &[Experiment]) -> Vec<Experiment> {
        let fitted = |signals: fn(&Experiment) -> &DMatrix<f64>| -> Vec<DMatrix<f64>> {
            let sums = experiments.iter().zip(&self.all);
            let sums = sums.map(|(own, basis)| basis.tr_mul(signals(own)));
            let weights = self.solver.solve(&sums.sum::<DMatrix<f64>>());
            self.all.iter().map(|basis| basis * &weights).collect()
        };
        let (inputs, outputs) = (fitted(|own| &own.inputs), fitted(|own| &own.outputs));
        let parts = experiments.iter().zip(inputs.into_iter().zip(outputs));
        let part = |(own, (inputs, outputs)): (&Experiment, _)| Experiment {
            inputs,
            outputs,
            ..own.clone()
        };
        parts.map(part).collect()
    }

    /// Squares of the part of the whitened innovations `errors` that is a response to the injected signal.
    fn left(&self, errors: &[DMatrix<f64>]) -> f64 {
        let sums = errors.iter().zip(&self.all).map(|(own, basis)| basis.tr_mul(own));
        let sums = sums.sum::<DMatrix<f64>>();
        self.solver.solve(&sums).dot(&sums)
    }
}

/// Delayed copies and low-passes of the signal `injected`, each without its mean. Zero where it is unknown.
fn responses(experiment: &Experiment, injected: &str) -> DMatrix<f64> {
    let (samples, period_s) = (experiment.samples(), experiment.period_s);
    let signal = experiment.signal(injected).unwrap_or_else(|_| DVector::zeros(samples));
    let apart = (LATE_S / DELAYED as f64 / period_s).ceil().max(1.0) as usize;
    let mut all = DMatrix::zeros(samples, DELAYED + LAGS_S.len());
    for (place, mut column) in all.column_iter_mut().enumerate() {
        if let Some(lag_s) = place.checked_sub(DELAYED).map(|lag| LAGS_S[lag]) {
            let mut lagged = 0.0;
            for (value, own) in column.iter_mut().zip(signal.iter()) {
                *value = lagged;
                lagged += (1.0 - (-period_s / lag_s).exp()) * (own - lagged);
            }
        } else {
            let late = (place * apart).min(samples);
            column.rows_mut(late, samples - late).copy_from(&signal.rows(0, samples - late));
        }
        column.add_scalar_mut(-column.mean());
    }
    all
}

/// Parameters estimated from the response to the injected signal.
struct Solved {
    theta: Vec<f64>,
    covariance: DMatrix<f64>,
    white_covariance: DMatrix<f64>,
    /// See [`Basis::left`].
    left: f64,
    steps: usize,
}

impl Solved {
    /// Newton's search for the parameters at which the innovations are uncorrelated with the instruments. The instruments
    /// are the sensitivities of the innovations to the parameters in the explained part of the flight.
    ///
    /// # Source
    /// Equation (I33) of docs/equations.md.
    fn search(
        flown: &Problem<'_>,
        responses: &Problem<'_>,
        basis: &Basis,
        lags: usize,
        widened: f64,
    ) -> Option<Self> {
        let count = flown.free.len();
        let mut theta: Vec<f64> = flown.free.iter().map(|&index| flown.base[index]).collect();
        let mut weights: Option<Vec<f64>> = None;
        let outputs = flown.structure.outputs.len();
        for steps in 1..=STEPS {
            let (_, _, passed) = flown.pass(&theta, true)?;
            let (_, _, alone) = responses.pass(&theta, true)?;
            let (mut slopes, mut white) =
                (DMatrix::zeros(count, count), DMatrix::zeros(count, count));
            let (mut gradient, mut scatter) = (DVector::zeros(count), DMatrix::zeros(count, count));
            for (normal, alone) in passed.normals.iter().zip(&alone.normals) {
                let (sensitivities, instruments) =
                    (projected(normal, count)?, projected(alone, count)?);
                let errors = DVector::from_column_slice(&normal.whitened);
                slopes += &instruments * sensitivities.transpose();
                white += &instruments * instruments.transpose();
                gradient += &instruments * &errors;
                scatter += correlated_scatter(&shares(&instruments, &errors, outputs), lags);
            }
            let widened = widened * widened;
            let weights = weights.get_or_insert_with(|| {
                let ratio = |place: usize| scatter[(place, place)] / white[(place, place)];
                let ratio = |place| ratio(place).clamp(1.0, MAX_OVERCONFIDENCE) * widened;
                (0..count).map(ratio).collect()
            });
            scatter *= widened;
            for (place, value, sigma, _) in flown.priors() {
                let information = weights[place] / (sigma * sigma);
                slopes[(place, place)] += information;
                white[(place, place)] += information;
                gradient[place] += information * (theta[place] - value);
                scatter[(place, place)] += weights[place] * information;
            }
            let scale = DMatrix::from_diagonal(&white.diagonal().map(|own| own.sqrt().recip()));
            let inverse = (&scale * slopes * &scale).try_inverse()?;
            let inverse = &scale * inverse * &scale;
            let step = &inverse * gradient;
            let covariance = &inverse * scatter * inverse.transpose();
            let white_covariance = &inverse * white * inverse.transpose();
            let mut largest = 0.0_f64;
            for (place, own) in theta.iter_mut().enumerate() {
                let index = flown.free[place];
                let before = *own;
                *own = (before - step[place]).max(flown.lower[index]).min(flown.upper[index]);
                largest = largest.max((*own - before).abs() / covariance[(place, place)].sqrt());
            }
            if !largest.is_finite() {
                return None;
            }
            if largest < SMALL {
                let errors = passed.normals.iter().map(|normal| {
                    let samples = normal.whitened.len() / outputs;
                    DMatrix::from_row_slice(samples, outputs, &normal.whitened)
                });
                let left = basis.left(&errors.collect::<Vec<_>>());
                return Some(Self { theta, covariance, white_covariance, left, steps });
            }
        }
        None
    }

    /// `found` with these parameters and their bounds.
    fn put_into(
        self,
        found: &Identified,
        flown: &Problem<'_>,
    ) -> Result<Identified, PredictionErrorError> {
        let mut estimates = found.estimates.clone();
        let places: Vec<usize> = (0..estimates.free.len())
            .filter(|&place| estimates.free[place] < flown.structure.parameters.len())
            .collect();
        let matrices = [
            (&mut estimates.covariance, &self.covariance),
            (&mut estimates.white_covariance, &self.white_covariance),
        ];
        for (whole, own) in matrices {
            for &place in &places {
                whole.row_mut(place).fill(0.0);
                whole.column_mut(place).fill(0.0);
            }
            for (row, &to_row) in places.iter().enumerate() {
                for (column, &to_column) in places.iter().enumerate() {
                    whole[(to_row, to_column)] = own[(row, column)];
                }
            }
        }
        for (place, &index) in flown.free.iter().enumerate() {
            let value = self.theta[place];
            let is_within = flown.lower[index] < value && value < flown.upper[index];
            let estimate = &mut estimates.list[index];
            estimate.value = value;
            estimate.status = if is_within { Status::Free } else { Status::OnBound };
            estimate.bound = self.covariance[(place, place)].sqrt();
            estimate.white_bound = self.white_covariance[(place, place)].sqrt();
        }
        let singular =
            || PredictionErrorError::Singular { structure: flown.structure.name.clone() };
        let ended = Ended {
            cost: flown.cost(&self.theta).ok_or_else(singular)?,
            iterations: found.iterations + self.steps,
            converged: found.converged,
        };
        let list = estimates.list.iter().enumerate();
        let dropped: Vec<usize> =
            list.filter(|(_, own)| own.status == Status::Dropped).map(|(index, _)| index).collect();
        described(flown, &self.theta, estimates, &ended, found.log.clone(), &dropped)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::methods::prediction_error::identify;
    use crate::methods::structure::{Parameter, Structure};

    pub const PERIOD_S: f64 = 0.03;
    pub const DELAY_S: f64 = 1.4 * PERIOD_S;

    /// w' = −0.8 w − 9 c, with c delayed by 1.4 samples. The stick is the injected signal plus feedback of w.
    pub fn flight(size: f64) -> Experiment {
        flown(size, 0.0)
    }

    /// The same in gusts, which the stick also counters.
    fn gusts(size: f64) -> Experiment {
        flown(size, 0.05)
    }

    fn flown(size: f64, gust: f64) -> Experiment {
        let samples = 1500;
        let noise = |sample: usize| ((sample * sample) as f64 * 0.618).fract() - 0.5;
        let injected = |sample: usize| if (sample / 60) % 3 == 1 { size } else { 0.0 };
        let (mut stick, mut w) = (vec![0.0; samples], 0.0);
        let mut outputs = DMatrix::zeros(samples, 1);
        let kept = f64::exp(-0.8 * PERIOD_S);
        for sample in 0..samples {
            outputs[(sample, 0)] = w + 0.002 * noise(sample);
            let gusts = gust * (noise(7 * sample + 3) + noise(5 * sample + 1));
            stick[sample] = injected(sample) + 0.1 * w + 4.0 * gusts;
            let late = |by: usize| sample.checked_sub(by).map_or(0.0, |at| stick[at]);
            let held = 0.6 * late(1) + 0.4 * late(2);
            w = kept * w - 9.0 * held * (1.0 - kept) / 0.8 + 0.002 * noise(3 * sample + 1) + gusts;
        }
        let inputs = DMatrix::from_fn(samples, 2, |sample, input| match input {
            0 => stick[sample],
            _ => injected(sample),
        });
        let names = ["c", "injected_c"].map(str::to_owned).to_vec();
        Experiment::new("held", PERIOD_S, names, vec!["w".to_owned()], inputs, outputs)
            .expect("finite")
    }

    pub fn structure() -> Structure {
        let parameters = vec![
            Parameter::new("Zw", "1/s", -0.7),
            Parameter::new("Zc", "m/s²", -8.0),
            Parameter::new("tau", "s", 0.01).within(-0.03, 0.2),
        ];
        let text = "inputs c\noutputs w\nnoise n\ndelay c tau\nw' = Zw*w + Zc*c + n";
        Structure::new("heave", parameters, text).expect("constant")
    }

    #[test]
    fn an_injected_signal_determines_the_parameters_from_wherever_the_search_ended() {
        let flight = [flight(0.1)];
        let settings = Settings::innovations(vec![0.1]);
        let mut found = identify(&structure(), &flight, &settings).expect("it is identifiable");
        for (zc, delay_s) in [(-9.0, DELAY_S), (-7.0, DELAY_S - 0.04), (-11.0, DELAY_S + 0.03)] {
            (found.theta[1], found.theta[2]) = (zc, delay_s);
            let solved = identify_from_injected(&found, "injected_c", &[], &flight, &settings);
            let solved = solved.expect("it has a predictor").expect("something was injected");
            for (name, value) in [("Zw", -0.8), ("Zc", -9.0), ("tau", DELAY_S)] {
                let own = solved.estimates.get(name).expect("it has one");
                assert!((own.value - value).abs() < 4.0 * own.bound, "{own:?}");
                assert!(own.bound < 0.05 * value.abs(), "{own:?}");
            }
        }
    }

    /// A gust moves the stick a sample before it moves w. The likelihood alone then finds a stick that is too weak.
    #[test]
    fn a_controller_that_foresees_gusts_does_not_weaken_its_stick() {
        let flight = [gusts(0.1)];
        let settings = Settings::innovations(vec![0.1]);
        let found = identify(&structure(), &flight, &settings).expect("it is identifiable");
        let solved = identify_from_injected(&found, "injected_c", &[], &flight, &settings);
        let solved = solved.expect("it has a predictor").expect("something was injected");
        let [before, after] =
            [&found, &solved].map(|own| own.estimates.get("Zc").expect("it has one"));
        assert!(before.value > -8.5, "{before:?}");
        assert!((after.value + 9.0).abs() < 3.0 * after.bound && after.bound < 0.5, "{after:?}");
    }

    #[test]
    fn where_nothing_was_injected_nothing_is_estimated() {
        let flight = [flight(0.0)];
        let settings = Settings::innovations(vec![0.1]);
        let structure = structure().with("tau", DELAY_S, false);
        let found = identify(&structure, &flight, &settings).expect("noise moves it");
        for injected in ["injected_c", "injected_d"] {
            let solved = identify_from_injected(&found, injected, &[], &flight, &settings);
            assert!(solved.expect("it has a predictor").is_none());
        }
    }
}
