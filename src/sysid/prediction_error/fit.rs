//! How well an identified structure explains a record, with what noise alone would allow.

use std::cell::RefCell;
use std::fmt;

use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::{Distribution as _, StandardNormal};

use super::predictor::Predictor;
use super::problem::{Problem, solve};
use super::statistics::noise_of;
use super::sweep::{Pass, Record};
use super::{Estimates, Identified, PredictionErrorError};
use crate::sysid::Experiment;
use crate::sysid::structure::Structure;

/// Noise-only windows behind a noise floor.
const FLOOR_RUNS: usize = 100;

/// How one output is explained.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelFit {
    /// The output.
    pub name: String,
    /// 100 (1 − ‖y − ŷ‖ / ‖y − ȳ‖), ȳ the mean over each experiment.
    pub percent: f64,
    /// The fit a perfect model would reach against the identified process and measurement noise, in
    /// expectation.
    pub floor_percent: f64,
    /// Root mean square of y − ŷ, in the output's unit.
    pub residual_rms: f64,
}

/// A stretch of flight and what the model makes of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The experiment it is from.
    pub experiment: String,
    /// Its first sample in the experiment.
    pub first_sample: usize,
    /// Flight, samples × outputs.
    pub measured: DMatrix<f64>,
    /// Model, samples × outputs.
    pub model: DMatrix<f64>,
}

/// A fit, and the parameters' bounds without which it says nothing: a model can fit and be wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    window_s: f64,
    channels: Vec<ChannelFit>,
    estimates: Estimates,
    runs: Vec<Run>,
}

impl Fit {
    /// The fit of every output together with the parameters behind it.
    #[must_use]
    pub fn channels(&self) -> (&[ChannelFit], &Estimates) {
        (&self.channels, &self.estimates)
    }

    /// Length of the windows simulated, s.
    #[must_use]
    pub fn window_s(&self) -> f64 {
        self.window_s
    }

    /// Flight and model, window by window.
    #[must_use]
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }
}

impl fmt::Display for Fit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "fit over windows of {:.1} s, {} of them", self.window_s, self.runs.len())?;
        for channel in &self.channels {
            writeln!(
                f,
                "{:<8} {:>7.2} %  noise floor {:>7.2} %  residual {:.5}",
                channel.name, channel.percent, channel.floor_percent, channel.residual_rms
            )?;
        }
        write!(f, "{}", self.estimates)
    }
}

impl Identified {
    /// Simulates `experiments` in windows of `window_s`, each from an initial state of its own, without
    /// any correction from the measurements in between.
    ///
    /// Offsets and biases are those the predictor finds over the whole experiment; only the initial
    /// state is fitted to a window. A last piece shorter than a window is left out; a whole experiment
    /// shorter than a window is one window.
    ///
    /// # Errors
    /// [`PredictionErrorError::Experiment`] where a signal is missing, [`PredictionErrorError::Start`]
    /// where the model has no predictor.
    pub fn simulate(
        &self,
        experiments: &[Experiment],
        window_s: f64,
    ) -> Result<Fit, PredictionErrorError> {
        let failed = || PredictionErrorError::Start { structure: self.structure.name.clone() };
        let structure = self.structure.with_shown();
        let records = |structure: &Structure| {
            experiments
                .iter()
                .map(|experiment| Record::new(structure, experiment))
                .collect::<Result<Vec<_>, _>>()
        };
        let (narrow, records) = (records(&self.structure)?, records(&structure)?);
        let mut theta = self.theta.clone();
        theta.resize(theta.len() + structure.outputs.len() - self.structure.outputs.len(), 0.0);
        let first = theta.len() - structure.outputs.len();
        for (output, log) in theta[first..].iter_mut().enumerate() {
            // A σ that was not estimated says how much to trust an output, not how noisy it is.
            if !self.estimates.free.contains(&(first + output)) {
                *log = noise_of(&records, output, structure.outputs.len()).ln();
            }
        }
        let view = Identified { structure, theta, ..self.clone() };
        view.fit(&narrow, &records, self, window_s).ok_or_else(failed)
    }

    /// The fit of `self`, a model with the shown states as outputs, over `records` of these outputs;
    /// `narrow` are those of `model`, the one identified.
    fn fit(
        &self,
        narrow: &[Record],
        records: &[Record],
        model: &Self,
        window_s: f64,
    ) -> Option<Fit> {
        let whole = ((window_s / self.period_s).round() as usize).max(2);
        let predictor = |model: &Self| {
            let innovations = model.innovations_form;
            Predictor::new(&model.structure, &model.theta, self.period_s, innovations)
        };
        let noise = WindowNoise::new(self, &predictor(self)?, whole);
        let predictor = predictor(model)?;
        let open = Predictor::new(&self.structure, &noise.weighted(self), self.period_s, false)?;

        let p = self.structure.outputs.len();
        let (mut residual, mut deviation) = (vec![0.0; p], vec![0.0; p]);
        let (mut runs, mut floor, mut simulated) = (Vec::new(), vec![0.0; p], 0);
        for (narrow, record) in narrow.iter().zip(records) {
            let length = whole.min(record.samples);
            let own = model.own_values(narrow, &predictor)?;
            let inputs = record.delayed(&self.structure, &self.theta, self.period_s);
            let means: Vec<f64> = (0..p)
                .map(|output| {
                    let values = record.outputs.iter().skip(output).step_by(p);
                    values.sum::<f64>() / record.samples as f64
                })
                .collect();
            for first in (0..=record.samples - length).step_by(length) {
                let run = self.window(&open, record, &inputs, &own, first, length)?;
                for output in 0..p {
                    for sample in 0..length {
                        let measured = run.measured[(sample, output)];
                        residual[output] += (measured - run.model[(sample, output)]).powi(2);
                        deviation[output] += (measured - means[output]).powi(2);
                    }
                }
                simulated += length;
                runs.push(run);
            }
        }
        let per_sample = noise.residual_variances(self, &open)?;
        for (floor, variance) in floor.iter_mut().zip(&per_sample) {
            *floor = variance * simulated as f64;
        }
        let percent =
            |error: f64, output: usize| 100.0 * (1.0 - (error / deviation[output]).sqrt());
        let channels = (0..p)
            .map(|output| ChannelFit {
                name: self.structure.outputs[output].clone(),
                percent: percent(residual[output], output),
                floor_percent: percent(floor[output], output),
                residual_rms: (residual[output] / simulated as f64).sqrt(),
            })
            .collect();
        Some(Fit {
            window_s: whole as f64 * self.period_s,
            channels,
            estimates: self.estimates.clone(),
            runs,
        })
    }

    /// A record's own values by the model's predictor.
    fn own_values(&self, record: &Record, predictor: &Predictor) -> Option<Vec<f64>> {
        let records = std::slice::from_ref(record);
        let problem = Problem {
            structure: &self.structure,
            records,
            period_s: self.period_s,
            innovations: self.innovations_form,
            base: self.theta.clone(),
            free: Vec::new(),
            own: RefCell::default(),
        };
        let mut own = Problem::guess(&self.structure, record);
        let inputs = record.delayed(&self.structure, &self.theta, self.period_s);
        problem.solve_own(predictor, &inputs, record, &mut own)?;
        Some(own)
    }

    /// One window: the initial state by least squares, then the free run.
    fn window(
        &self,
        open: &Predictor,
        record: &Record,
        inputs: &(Vec<f64>, Vec<f64>),
        own: &[f64],
        first: usize,
        length: usize,
    ) -> Option<Run> {
        let (n, m) = (self.structure.states.len(), self.structure.inputs.len());
        let p = self.structure.outputs.len();
        let cut = |all: &[f64], width: usize| all[first * width..(first + length) * width].to_vec();
        let piece = record.piece(cut(&record.outputs, p), length);
        let inputs = (cut(&inputs.0, m), cut(&inputs.1, m));
        let mut own = own.to_vec();
        own[..n].fill(0.0);
        let mut pass = Pass {
            structure: &self.structure,
            predictor: open,
            forcing: None,
            record: &piece,
            inputs: &inputs,
            own: &own,
            own_columns: 0..n,
            keep: false,
        };
        let normal = pass.run();
        let step = solve(&normal.information, &normal.gradient)?;
        let mut solved = own.clone();
        for (value, step) in solved.iter_mut().zip(step.iter()) {
            *value = -step;
        }
        (pass.own, pass.own_columns, pass.keep) = (&solved, 0..0, true);
        let errors = DMatrix::from_column_slice(p, length, &pass.run().whitened);
        let measured = DMatrix::from_row_slice(length, p, &piece.outputs);
        // The open predictor's whitener is diagonal.
        let model = DMatrix::from_fn(length, p, |sample, output| {
            measured[(sample, output)] - errors[(output, sample)] / open.whitener[(output, output)]
        });
        Some(Run { experiment: record.name.clone(), first_sample: first, measured, model })
    }
}

/// What the identified noises do to an uncorrected window.
struct WindowNoise {
    /// Γₙ diag(σ).
    driven: DMatrix<f64>,
    measurement_sigma: Vec<f64>,
    /// Mean variance of each output's error over the window, from a known initial state.
    variances: Vec<f64>,
    length: usize,
}

impl WindowNoise {
    fn new(model: &Identified, predictor: &Predictor, length: usize) -> Self {
        let structure = &model.structure;
        let (n, m, q) = (structure.states.len(), structure.inputs.len(), structure.noises.len());
        let sigmas: Vec<f64> =
            model.theta[structure.parameters.len()..].iter().map(|log| log.exp()).collect();
        let (process, measurement) = sigmas.split_at(q);
        let mut driven = predictor.gamma.columns(m, q).into_owned();
        for (index, sigma) in process.iter().enumerate() {
            let present = if model.innovations_form { *sigma } else { 0.0 };
            driven.column_mut(index).scale_mut(present);
        }
        let step = &driven * driven.transpose();
        let mut covariance = DMatrix::zeros(n, n);
        let mut variances = vec![0.0; structure.outputs.len()];
        for _ in 0..length {
            let seen = &predictor.c * &covariance * predictor.c.transpose();
            for (output, variance) in variances.iter_mut().enumerate() {
                *variance += (seen[(output, output)] + measurement[output].powi(2)) / length as f64;
            }
            covariance = &predictor.phi * covariance * predictor.phi.transpose() + &step;
        }
        Self { driven, measurement_sigma: measurement.to_vec(), variances, length }
    }

    /// The parameter vector with the window's error in place of the measurement noise.
    fn weighted(&self, model: &Identified) -> Vec<f64> {
        let mut theta = model.theta.clone();
        let first = theta.len() - self.variances.len();
        for (log, variance) in theta[first..].iter_mut().zip(&self.variances) {
            *log = 0.5 * variance.ln();
        }
        theta
    }

    /// Expected variance of each output's residual after the initial state is fitted, by simulation
    /// from a fixed seed.
    fn residual_variances(&self, model: &Identified, open: &Predictor) -> Option<Vec<f64>> {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let (n, p) = (open.phi.nrows(), self.variances.len());
        let m = model.structure.inputs.len();
        let own = vec![0.0; n + model.structure.offsets.len() + model.structure.biases.len()];
        let inputs = (vec![0.0; self.length * m], vec![0.0; self.length * m]);
        let mut sums = vec![0.0; p];
        for _ in 0..FLOOR_RUNS {
            let mut state = DVector::zeros(n);
            let mut outputs = Vec::with_capacity(self.length * p);
            for _ in 0..self.length {
                let seen = &open.c * &state;
                for (output, sigma) in self.measurement_sigma.iter().enumerate() {
                    outputs.push(seen[output] + sigma * normal());
                }
                let kick = DVector::from_fn(self.driven.ncols(), |_, _| normal());
                state = &open.phi * state + &self.driven * kick;
            }
            let record = Record::of_outputs(outputs, self.length);
            let run = model.window(open, &record, &inputs, &own, 0, self.length)?;
            let error = run.measured - run.model;
            for (sum, column) in sums.iter_mut().zip(error.column_iter()) {
                *sum += column.norm_squared() / (FLOOR_RUNS * self.length) as f64;
            }
        }
        Some(sums)
    }
}
