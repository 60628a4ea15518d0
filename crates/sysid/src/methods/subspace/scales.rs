//! Scaling of signals to unit size, and back.

use nalgebra::DMatrix;

use super::error::SubspaceError;
use crate::methods::innovation::InnovationModel;
use crate::record::Experiment;

/// Root mean square of each signal, so that units do not affect the weights.
pub(super) struct Scales {
    inputs: Vec<f64>,
    outputs: Vec<f64>,
}

impl Scales {
    /// The scales of a record in which every signal moves.
    pub fn of(experiment: &Experiment) -> Result<Self, SubspaceError> {
        let samples = experiment.samples() as f64;
        let size = |signals: &DMatrix<f64>| -> Vec<f64> {
            signals.column_iter().map(|column| (column.norm_squared() / samples).sqrt()).collect()
        };
        let (inputs, outputs) = (size(&experiment.inputs), size(&experiment.outputs));
        let still = |column: usize, signals: &DMatrix<f64>| {
            let column = signals.column(column);
            column.max() - column.min() <= 1e-12 * column.amax()
        };
        for (column, name) in experiment.input_names.iter().enumerate() {
            if still(column, &experiment.inputs) {
                return Err(SubspaceError::NotExciting {
                    experiment: experiment.name.clone(),
                    input: name.clone(),
                });
            }
        }
        for (column, name) in experiment.output_names.iter().enumerate() {
            if still(column, &experiment.outputs) {
                return Err(SubspaceError::ConstantOutput {
                    experiment: experiment.name.clone(),
                    output: name.clone(),
                });
            }
        }
        Ok(Self { inputs, outputs })
    }

    /// The record with every signal scaled to unit size.
    pub fn applied(&self, experiment: &Experiment) -> Experiment {
        let mut unit = experiment.clone();
        for (mut column, scale) in unit.inputs.column_iter_mut().zip(&self.inputs) {
            column /= *scale;
        }
        for (mut column, scale) in unit.outputs.column_iter_mut().zip(&self.outputs) {
            column /= *scale;
        }
        unit
    }

    /// Converts a model of the scaled record into a model of the record itself.
    pub fn restore(&self, model: &mut InnovationModel) {
        let InnovationModel { system, gain } = model;
        for (input, scale) in self.inputs.iter().enumerate() {
            system.b.column_mut(input).unscale_mut(*scale);
            system.d.column_mut(input).unscale_mut(*scale);
        }
        for (output, scale) in self.outputs.iter().enumerate() {
            system.c.row_mut(output).scale_mut(*scale);
            system.d.row_mut(output).scale_mut(*scale);
            gain.column_mut(output).unscale_mut(*scale);
        }
    }
}
