//! Fit of an identified structure to a record, and the fit that noise alone allows.

use std::fmt;

use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng as _;
use rand_distr::{Distribution as _, StandardNormal};

use super::error::PredictionErrorError;
use super::estimates::Estimates;
use super::identified::Identified;
use super::own_rows::OwnRows;
use super::predictor::Predictor;
use super::problem::{Problem, solve};
use super::statistics::noise_of;
use super::sweep::{Pass, Record};
use crate::record::Experiment;

/// Number of simulated noise-only windows for a noise floor.
const FLOOR_RUNS: usize = 100;

/// Fit of one output.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelFit {
    /// The output.
    pub name: String,
    /// 100 (1 − ‖y − ŷ‖ / ‖y − ȳ‖), ȳ the mean over each experiment.
    pub percent: f64,
    /// Expected fit of a perfect model in the presence of the identified process and measurement noise.
    pub floor_percent: f64,
    /// Root mean square of y − ŷ, in the output's unit.
    pub residual_rms: f64,
}

impl ChannelFit {
    /// Root mean square of the residual that the identified noise alone causes in a perfect model, in the output's
    /// unit. Both fits are relative to the same deviation of the flight.
    #[must_use]
    pub fn floor_rms(&self) -> f64 {
        let floor = (100.0 - self.floor_percent) / (100.0 - self.percent);
        floor * self.residual_rms
    }
}

/// A window of flight data and its simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Name of the experiment.
    pub experiment: String,
    /// First sample of the window in the experiment.
    pub first_sample: usize,
    /// Measured outputs, samples × outputs.
    pub measured: DMatrix<f64>,
    /// Simulated outputs, samples × outputs.
    pub model: DMatrix<f64>,
}

/// A fit together with the bounds of the parameters: a model with large bounds can fit and be wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    window_s: f64,
    channels: Vec<ChannelFit>,
    estimates: Estimates,
    runs: Vec<Run>,
}

impl Fit {
    /// The fits of all outputs, and the parameters.
    #[must_use]
    pub fn channels(&self) -> (&[ChannelFit], &Estimates) {
        (&self.channels, &self.estimates)
    }

    /// Length of the simulated windows, s.
    #[must_use]
    pub fn window_s(&self) -> f64 {
        self.window_s
    }

    /// Measured and simulated outputs, window by window.
    #[must_use]
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }
}

impl fmt::Display for Fit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "fit over windows of {:.1} s, {} windows", self.window_s, self.runs.len())?;
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
    /// Simulates `experiments` in windows of `window_s`, each from its own initial state, without correction by the
    /// measurements inside the window.
    ///
    /// Biases are estimated by the predictor over the whole experiment; initial state and offsets are fitted to each
    /// window. A last piece shorter than a window is ignored; an experiment shorter than a window is one window.
    ///
    /// # Errors
    /// [`PredictionErrorError::Experiment`] where a signal is missing, [`PredictionErrorError::Start`]
    /// where the model has no predictor.
    pub fn simulate(
        &self,
        experiments: &[Experiment],
        window_s: f64,
    ) -> Result<Fit, PredictionErrorError> {
        let records = experiments
            .iter()
            .map(|experiment| Record::new(&self.structure, experiment))
            .collect::<Result<Vec<_>, _>>()?;
        self.fit(&records, window_s)
            .ok_or_else(|| PredictionErrorError::Start { structure: self.structure.name.clone() })
    }

    fn fit(&self, records: &[Record], window_s: f64) -> Option<Fit> {
        let whole = ((window_s / self.period_s).round() as usize).max(2);
        let innovations = self.innovations_form;
        let predictor = Predictor::new(&self.structure, &self.theta, self.period_s, innovations)?;
        let noise = WindowNoise::new(self, &predictor, records, whole);
        let lengths = records.iter().map(|record| whole.min(record.samples)).chain([whole]);
        let open = OpenLoop::new(self, &noise, lengths)?;
        let of_records = Problem::own_rows(&self.structure, &predictor, records);

        let p = self.structure.outputs.len();
        let (mut residual, mut deviation) = (vec![0.0; p], vec![0.0; p]);
        let (mut runs, mut floor, mut simulated) = (Vec::new(), vec![0.0; p], 0);
        for record in records {
            let length = whole.min(record.samples);
            let inputs = record.late(&self.structure, &self.theta, self.period_s);
            let mut own = Problem::guess(&self.structure, record);
            Problem::solve_own(
                &self.structure,
                &predictor,
                &of_records,
                &inputs,
                record,
                &mut own,
            )?;
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

    /// Simulates one window: least squares for the initial state, then simulation.
    fn window(
        &self,
        open: &OpenLoop,
        record: &Record,
        inputs: &(Vec<f64>, Vec<f64>),
        own: &[f64],
        first: usize,
        length: usize,
    ) -> Option<Run> {
        let (n, p) = (self.structure.states.len(), self.structure.outputs.len());
        let cut = |all: &[f64], width: usize| all[first * width..(first + length) * width].to_vec();
        let piece = record.piece(cut(&record.outputs, p), length);
        let (wide, slopes) = (open.predictor.d.ncols(), open.predictor.slopes);
        let inputs = (cut(&inputs.0, wide), cut(&inputs.1, slopes));
        let mut own = own.to_vec();
        own[..n].fill(0.0);
        let mut pass = Pass {
            structure: &self.structure,
            predictor: &open.predictor,
            forcing: None,
            record: &piece,
            inputs: &inputs,
            own: &own,
            own_rows: &open.fitted,
            keep: false,
        };
        let normal = pass.run();
        let step = solve(&normal.information, &normal.gradient)?;
        let mut solved = own.clone();
        for (&place, step) in open.fitted.columns.iter().zip(step.iter()) {
            solved[place] -= step;
        }
        (pass.own, pass.own_rows, pass.keep) = (&solved, &open.none, true);
        let errors = DMatrix::from_column_slice(p, length, &pass.run().whitened);
        let measured = DMatrix::from_row_slice(length, p, &piece.outputs);
        // The whitener of the open-loop predictor is diagonal.
        let whitener = &open.predictor.whitener;
        let model = DMatrix::from_fn(length, p, |sample, output| {
            measured[(sample, output)] - errors[(output, sample)] / whitener[(output, output)]
        });
        Some(Run { experiment: record.name.clone(), first_sample: first, measured, model })
    }
}

/// The model without corrections by measured outputs, for the simulation of windows.
struct OpenLoop {
    predictor: Predictor,
    /// Values fitted to a window: its initial state and offsets. Output errors are excluded, because they are not
    /// motion. Each window has its own constant forcing, because gusts last longer than a window.
    fitted: OwnRows,
    /// Empty set of fitted values, for a window whose initial state and offsets are known.
    none: OwnRows,
}

impl OpenLoop {
    fn new(
        model: &Identified,
        noise: &WindowNoise,
        lengths: impl Iterator<Item = usize> + Clone,
    ) -> Option<Self> {
        let structure = &model.structure;
        let predictor = Predictor::new(structure, &noise.weights, model.period_s, false)?;
        let n = structure.states.len();
        let motion = 0..n - structure.trailing_errors();
        let fitted = motion.chain(n..n + structure.offsets.len()).collect();
        Some(Self {
            fitted: OwnRows::new(structure, &predictor, fitted, lengths.clone()),
            none: OwnRows::new(structure, &predictor, Vec::new(), lengths),
            predictor,
        })
    }
}

/// Effect of the identified noises on a window simulated without corrections by measured outputs.
struct WindowNoise {
    /// Γₙ diag(σ).
    driven: DMatrix<f64>,
    measurement_sigma: Vec<f64>,
    /// The whole parameter vector, with other σ of the outputs. Each is the error of the output over the window from a
    /// known initial state. They weight the outputs in the fit of the initial state.
    weights: Vec<f64>,
    length: usize,
}

impl WindowNoise {
    fn new(model: &Identified, predictor: &Predictor, records: &[Record], length: usize) -> Self {
        let structure = &model.structure;
        let (n, m) = (structure.states.len(), predictor.d.ncols());
        let (p, q) = (structure.outputs.len(), structure.noises.len());
        let own = structure.parameters.len();
        let sigmas: Vec<f64> = model.theta[own..].iter().map(|log| log.exp()).collect();
        let (process, trusted) = sigmas.split_at(q);
        let mut driven = predictor.gamma.columns(m, q).into_owned();
        for (index, sigma) in process.iter().enumerate() {
            let present = if model.innovations_form { *sigma } else { 0.0 };
            driven.column_mut(index).scale_mut(present);
        }
        // A fixed σ is the weight of an output, not its noise.
        let held = |output: usize| !model.estimates.free.contains(&(own + q + output));
        let measurement_sigma: Vec<f64> = (0..p)
            .map(|output| if held(output) { noise_of(records, output, p) } else { trusted[output] })
            .collect();
        let mut variances: Vec<f64> = trusted.iter().map(|sigma| sigma * sigma).collect();
        let step = &driven * driven.transpose();
        let mut covariance = DMatrix::zeros(n, n);
        for _ in 0..length {
            let seen = &predictor.c * &covariance * predictor.c.transpose();
            for (output, variance) in variances.iter_mut().enumerate() {
                *variance += seen[(output, output)] / length as f64;
            }
            covariance = &predictor.phi * covariance * predictor.phi.transpose() + &step;
        }
        let mut weights = model.theta.clone();
        for (log, variance) in weights[own + q..].iter_mut().zip(&variances) {
            *log = 0.5 * variance.ln();
        }
        Self { driven, measurement_sigma, weights, length }
    }

    /// Expected variance of each output's residual after the initial state is fitted, from a simulation with a fixed
    /// seed.
    fn residual_variances(&self, model: &Identified, open: &OpenLoop) -> Option<Vec<f64>> {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let Predictor { phi, c, d, slopes, .. } = &open.predictor;
        let (n, p) = (phi.nrows(), self.measurement_sigma.len());
        let own = vec![0.0; n + model.structure.offsets.len() + model.structure.biases.len()];
        let inputs = (vec![0.0; self.length * d.ncols()], vec![0.0; self.length * slopes]);
        let mut sums = vec![0.0; p];
        for _ in 0..FLOOR_RUNS {
            let mut state = DVector::zeros(n);
            let mut outputs = Vec::with_capacity(self.length * p);
            for _ in 0..self.length {
                let seen = c * &state;
                for (output, sigma) in self.measurement_sigma.iter().enumerate() {
                    outputs.push(seen[output] + sigma * normal());
                }
                let kick = DVector::from_fn(self.driven.ncols(), |_, _| normal());
                state = phi * state + &self.driven * kick;
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
