//! One pass of the predictor over a record: whitened innovations and their sensitivities, accumulated in normal
//! equations.

use nalgebra::{DMatrix, DMatrixView, DVector};

use super::late_input::LateInput;
use super::own_rows::OwnRows;
use super::predictor::{Derivative, Predictor};
use super::products::{BLOCK, Products, group};
use super::step::Step;
use crate::methods::structure::Structure;
use crate::record::{Experiment, ExperimentError};

/// An experiment sample by sample, in the structure's order of signals.
pub(super) struct Record {
    pub name: String,
    pub samples: usize,
    inputs: Vec<f64>,
    pub outputs: Vec<f64>,
    /// Whether the inputs move smoothly between samples. Otherwise they are held.
    is_smooth: bool,
}

impl Record {
    pub fn new(structure: &Structure, experiment: &Experiment) -> Result<Self, ExperimentError> {
        let chosen = experiment.select(&words(&structure.inputs), &words(&structure.outputs))?;
        Ok(Self {
            name: experiment.name.clone(),
            samples: chosen.samples(),
            inputs: chosen.inputs.transpose().as_slice().to_vec(),
            outputs: chosen.outputs.transpose().as_slice().to_vec(),
            is_smooth: experiment.is_smooth,
        })
    }

    /// A record of outputs only, samples × outputs row by row.
    pub fn of_outputs(outputs: Vec<f64>, samples: usize) -> Self {
        Self { name: String::new(), samples, inputs: Vec::new(), outputs, is_smooth: false }
    }

    /// A piece of this record, given by its outputs; its late inputs come from the whole record.
    pub fn piece(&self, outputs: Vec<f64>, samples: usize) -> Self {
        Self { name: self.name.clone(), ..Self::of_outputs(outputs, samples) }
    }

    /// The inputs after their delays and lags, and their derivatives with respect to each delay and lag.
    ///
    /// Each sample has the mean of every input over the interval to the next sample, then the excursion of every late input.
    /// The derivatives of a late input are those of mean and excursion with respect to the delay, then to the lag.
    ///
    /// A command is held between samples. Between the samples of a smooth input, holding would attenuate fast movements:
    /// there a polynomial through six samples gives the value.
    pub fn late(
        &self,
        structure: &Structure,
        theta: &[f64],
        period_s: f64,
    ) -> (Vec<f64>, Vec<f64>) {
        let (m, late) = (structure.inputs.len(), structure.late_inputs());
        let (width, count) = (m + late.len(), 4 * late.len());
        let mut values = vec![0.0; width * self.samples];
        let mut slopes = vec![0.0; count * self.samples];
        for (into, own) in values.chunks_exact_mut(width).zip(self.inputs.chunks_exact(m)) {
            into[..m].copy_from_slice(own);
        }
        let last = self.samples as f64 - 1.0;
        for (place, &input) in late.iter().enumerate() {
            let of = |which: &[Option<usize>]| which[input].map_or(0.0, |own| theta[own]);
            let (delay_s, lag_s) = (of(&structure.delays), of(&structure.lags));
            let whole = (delay_s / period_s).floor();
            let fraction = delay_s / period_s - whole;
            let command = |sample: usize, older: f64| {
                let at = (sample as f64 - whole - older).clamp(0.0, last);
                self.inputs[at as usize * m + input]
            };
            let weights = between(fraction);
            let old_s = if self.is_smooth { 0.0 } else { fraction * period_s };
            let commands = |sample: usize| {
                if !self.is_smooth {
                    return [1.0, 0.0].map(|older| [command(sample, older), 0.0]);
                }
                let terms = weights.iter().map(|&(older, weight, change)| {
                    let own = command(sample, older);
                    [weight * own, change * own / period_s]
                });
                [terms.fold([0.0; 2], |sum, term| [sum[0] + term[0], sum[1] + term[1]]); 2]
            };
            let mut input_now = LateInput::new(period_s, lag_s, old_s, commands(0)[0][0]);
            for sample in 0..self.samples {
                let [old, new] = commands(sample);
                let [mean, excursion] = input_now.step(old, new);
                values[sample * width + input] = mean[0];
                values[sample * width + m + place] = excursion[0];
                slopes[sample * count + 4 * place..][..4].copy_from_slice(&[
                    mean[1],
                    excursion[1],
                    mean[2],
                    excursion[2],
                ]);
            }
        }
        (values, slopes)
    }
}

/// Weights of the values around a fraction of a sample. Each entry contains the age relative to the newer neighbour,
/// samples; the weight; and its derivative with respect to the fraction.
type Weights = Vec<(f64, f64, f64)>;

/// Lagrange's polynomial through six values, the middle two of which are the neighbours.
fn between(fraction: f64) -> Weights {
    const NODES: [f64; 6] = [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0];
    let weight = |node: f64| {
        let others = || NODES.into_iter().filter(move |other| *other != node);
        let factor = |other: f64| (fraction - other) / (node - other);
        let change = others().map(|omitted| {
            let rest = others().filter(|other| *other != omitted);
            rest.map(factor).product::<f64>() / (node - omitted)
        });
        (node, others().map(factor).product(), change.sum())
    };
    NODES.map(weight).to_vec()
}

/// Forcing of the sensitivities by the estimated parameters.
///
/// With z = [x u du/dτ o ν], u the means and then the excursions, τ the delays and lags: dν = −C s − `output` z, s⁺ = Φ s
/// + K dν + `state` z.
pub(super) struct Forcing {
    pub count: usize,
    /// Length of the group of `count` sensitivities.
    group: usize,
    /// (states · group) × z, with the rows of a state adjacent.
    state: DMatrix<f64>,
    /// Entries of the matrix: parameter, output, index in z, value.
    output: Vec<(usize, usize, usize, f64)>,
}

impl Forcing {
    pub fn new(predictor: &Predictor, derivatives: &[Derivative], offsets: usize) -> Self {
        let (n, m, p) = (predictor.phi.nrows(), predictor.d.ncols(), predictor.c.nrows());
        let count = derivatives.len();
        let group = group(count);
        let offset_first = predictor.gamma.ncols() - offsets;
        let measured = n + m + predictor.slopes;
        let mut state = DMatrix::zeros(n * group, measured + offsets + p);
        let mut output = Vec::new();
        for (index, change) in derivatives.iter().enumerate() {
            for row in 0..n {
                let mut into = state.row_mut(row * group + index);
                into.columns_mut(0, n).copy_from(&change.phi.row(row));
                into.columns_mut(n, m).copy_from(&change.gamma.row(row).columns(0, m));
                for &(input, place) in &change.shifts {
                    into[n + m + place] = predictor.gamma[(row, input)];
                }
                into.columns_mut(measured, offsets)
                    .copy_from(&change.gamma.row(row).columns(offset_first, offsets));
                into.columns_mut(measured + offsets, p).copy_from(&change.gain.row(row));
            }
            for row in 0..p {
                let direct = (0..n).map(|column| (column, change.c[(row, column)]));
                let through = (0..m).map(|input| (n + input, change.d[(row, input)]));
                let late = change
                    .shifts
                    .iter()
                    .map(|&(input, place)| (n + m + place, predictor.d[(row, input)]));
                for (column, value) in direct.chain(through).chain(late) {
                    if value != 0.0 {
                        output.push((index, row, column, value));
                    }
                }
            }
        }
        Self { count, group, state, output }
    }
}

/// Normal equations of one pass; columns are the parameters, then the record's own unknowns.
pub(super) struct Normal {
    /// ½ Σ νᵀ S⁻¹ ν.
    pub half_squares: f64,
    pub gradient: DVector<f64>,
    pub information: DMatrix<f64>,
    /// Σ e eᵀ of the whitened innovations e.
    pub scatter: DMatrix<f64>,
    /// Whitened innovations, samples × outputs row by row, if requested.
    pub whitened: Vec<f64>,
    /// Whitened sensitivities, (samples · outputs) × columns row by row, if requested.
    pub sensitivities: Vec<f64>,
}

/// Inputs of a pass.
pub(super) struct Pass<'a> {
    pub structure: &'a Structure,
    pub predictor: &'a Predictor,
    pub forcing: Option<&'a Forcing>,
    pub record: &'a Record,
    /// The inputs after delays and lags, and their derivatives.
    pub inputs: &'a (Vec<f64>, Vec<f64>),
    /// The record's own values: x0, offsets, biases.
    pub own: &'a [f64],
    /// Own values with a column in the normal equations, and the sensitivities of the innovations to them.
    pub own_rows: &'a OwnRows,
    /// Whether the pass keeps the whitened innovations and sensitivities.
    pub keep: bool,
}

impl Pass<'_> {
    pub fn run(&self) -> Normal {
        let structure = self.structure;
        let (n, m) = (structure.states.len(), self.predictor.d.ncols());
        let (p, o) = (structure.outputs.len(), structure.offsets.len());
        let parameters = self.forcing.map_or(0, |forcing| forcing.count);
        let group = self.forcing.map_or(0, |forcing| forcing.group);
        let (samples, own) = (self.record.samples, self.own_rows.columns.len());
        let columns = parameters + own;
        let width = n + m + self.predictor.slopes + o + p;

        let mut predicted = Step::new(self.predictor, &self.own[..n], o);
        let mut products = Products::new(self.predictor, group);
        let all = n * group;
        let mut sensitivity = vec![0.0; all];
        let mut z = DMatrix::zeros(width, BLOCK);
        // One column per step of a block. Each column contains the forcing of its step, and then the sensitivities
        // after that step.
        let mut forced = DMatrix::zeros(all, BLOCK);
        // Sensitivities, one column per output of each sample of a block. Rows: the parameters first, then the own
        // values.
        let mut rows = DMatrix::zeros(columns, p * BLOCK);
        let mut errors = DVector::zeros(p * BLOCK);
        let mut raw = vec![0.0; p * group];
        let mut normal = Normal {
            half_squares: 0.0,
            gradient: DVector::zeros(columns),
            information: DMatrix::zeros(columns, columns),
            scatter: DMatrix::zeros(p, p),
            whitened: Vec::new(),
            sensitivities: Vec::new(),
        };

        for first in (0..samples).step_by(BLOCK) {
            let length = BLOCK.min(samples - first);
            for step in 0..length {
                let z = &mut z.as_mut_slice()[step * width..(step + 1) * width];
                self.measured(first + step, z);
                predicted.advance(z);
            }
            if let Some(forcing) = self.forcing {
                forced.gemm(1.0, &forcing.state, &z, 0.0);
            }
            for step in 0..length {
                let z = &z.as_slice()[step * width..(step + 1) * width];
                let errors = &mut errors.as_mut_slice()[step * p..(step + 1) * p];
                predicted.whiten(&z[width - p..], errors);
                if parameters == 0 {
                    continue;
                }
                let (before, next) = forced.as_mut_slice().split_at_mut(step * all);
                let sensitivity = before.rchunks_exact(all).next().unwrap_or(&sensitivity);
                products.observe(sensitivity, &mut raw);
                self.add_direct(z, &mut raw);
                let step_rows = step * p * columns..(step + 1) * p * columns;
                let step_rows = &mut rows.as_mut_slice()[step_rows];
                products.whiten(&raw, parameters, step_rows, columns);
                products.propagate(sensitivity, &raw, &mut next[..all]);
            }
            sensitivity.copy_from_slice(&forced.as_slice()[(length - 1) * all..length * all]);
            if own > 0 {
                let of_own = self.own_rows.of(first, length).chunks_exact(own);
                for (into, of_own) in rows.as_mut_slice().chunks_exact_mut(columns).zip(of_own) {
                    into[parameters..].copy_from_slice(of_own);
                }
            }
            let used = rows.columns(0, p * length);
            let errors = errors.rows(0, p * length);
            normal.half_squares += 0.5 * errors.norm_squared();
            normal.gradient.gemv(1.0, &used, &errors, 1.0);
            if parameters > 0 {
                let values = rows.as_slice();
                let long = p * length;
                let turned =
                    DMatrixView::from_slice_with_strides(values, long, columns, columns, 1);
                let mut of_parameters = normal.information.rows_mut(0, parameters);
                of_parameters.gemm(1.0, &used.rows(0, parameters), &turned, 1.0);
            }
            let shaped = DMatrix::from_column_slice(p, length, errors.as_slice());
            normal.scatter.gemm(1.0, &shaped, &shaped.transpose(), 1.0);
            if self.keep {
                normal.whitened.extend_from_slice(errors.as_slice());
                normal.sensitivities.extend(used.iter());
            }
        }
        let across = normal.information.view((0, parameters), (parameters, own)).transpose();
        normal.information.view_mut((parameters, 0), (own, parameters)).copy_from(&across);
        let own_information = self.own_rows.information(samples);
        normal
            .information
            .view_mut((parameters, parameters), (own, own))
            .copy_from(own_information);
        // The initial value of a disturbance can hardly be separated from an offset. Its prior is 0 with a sigma of 1
        // m/s² or rad/s².
        for state in structure.disturbances() {
            let start = self.own[state];
            normal.half_squares += 0.5 * start * start;
            if let Some(place) = self.own_rows.columns.iter().position(|&own| own == state) {
                normal.gradient[parameters + place] += start;
                normal.information[(parameters + place, parameters + place)] += 1.0;
            }
        }
        normal
    }

    /// Fills z for `sample`, except x. The measured outputs minus their biases take the place of ν.
    fn measured(&self, sample: usize, z: &mut [f64]) {
        let structure = self.structure;
        let (n, m) = (structure.states.len(), self.predictor.d.ncols());
        let (p, o) = (structure.outputs.len(), structure.offsets.len());
        let (late, slopes) = (self.inputs, self.predictor.slopes);
        let first = n + m + slopes;
        z[n..n + m].copy_from_slice(&late.0[sample * m..(sample + 1) * m]);
        z[n + m..first].copy_from_slice(&late.1[sample * slopes..(sample + 1) * slopes]);
        z[first..first + o].copy_from_slice(&self.own[n..n + o]);
        let outputs = &mut z[first + o..];
        outputs.copy_from_slice(&self.record.outputs[sample * p..(sample + 1) * p]);
        for (index, &row) in structure.bias_rows.iter().enumerate() {
            outputs[row] -= self.own[n + o + index];
        }
    }

    /// Adds the part of dν that does not come through the state.
    fn add_direct(&self, z: &[f64], raw: &mut [f64]) {
        let Some(forcing) = self.forcing else { return };
        for &(parameter, row, column, value) in &forcing.output {
            raw[row * forcing.group + parameter] -= value * z[column];
        }
    }
}

fn words(names: &[String]) -> Vec<&str> {
    names.iter().map(String::as_str).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_fast_smooth_input_keeps_its_size_half_way_between_two_samples() {
        let sine = |angle: f64, weights: Weights| {
            let terms = weights.into_iter().map(|(older, weight, change)| {
                [weight * (-older * angle).sin(), change * (-older * angle).sin()]
            });
            terms.fold([0.0; 2], |sum, term| [sum[0] + term[0], sum[1] + term[1]])
        };
        for fraction in [0.0, 0.3, 0.5, 0.9] {
            let angle = 1.0;
            let [value, slope] = sine(angle, between(fraction));
            assert_abs_diff_eq!(value, (-fraction * angle).sin(), epsilon = 4e-3);
            assert_abs_diff_eq!(slope, -angle * (-fraction * angle).cos(), epsilon = 0.03);
            assert_abs_diff_eq!(
                between(fraction).iter().map(|own| own.1).sum::<f64>(),
                1.0,
                epsilon = 1e-12
            );
        }
    }
}
