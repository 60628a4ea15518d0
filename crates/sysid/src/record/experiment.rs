//! An experiment: uniformly sampled inputs and outputs, and the operations on them.

use std::ops::Range;

use nalgebra::{DMatrix, DVector, RowDVector};
use thiserror::Error;

/// Reasons why a record is not a valid [`Experiment`], or why a part of it does not exist.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ExperimentError {
    /// The sample period is not a positive, finite number of seconds.
    #[error(
        "experiment `{experiment}`: found a sample period of {period_s} s, expected a positive, finite one"
    )]
    Period {
        /// The experiment's name.
        experiment: String,
        /// The given period, s.
        period_s: f64,
    },
    /// Inputs and outputs differ in length.
    #[error(
        "experiment `{experiment}`: found {inputs} samples of the inputs and {outputs} of the outputs, expected equal numbers"
    )]
    Length {
        /// The experiment's name.
        experiment: String,
        /// Samples (rows) of the inputs.
        inputs: usize,
        /// Samples (rows) of the outputs.
        outputs: usize,
    },
    /// The experiment has no samples or no outputs.
    #[error(
        "experiment `{experiment}`: found {samples} samples of {outputs} outputs, expected at least one of each"
    )]
    Empty {
        /// The experiment's name.
        experiment: String,
        /// Samples (rows).
        samples: usize,
        /// Outputs (columns).
        outputs: usize,
    },
    /// The number of names differs from the number of columns.
    #[error("experiment `{experiment}`: found {names} names for {columns} {kind} columns")]
    Names {
        /// The experiment's name.
        experiment: String,
        /// `input` or `output`.
        kind: &'static str,
        /// Number of names.
        names: usize,
        /// Number of columns.
        columns: usize,
    },
    /// Two signals have the same name.
    #[error("experiment `{experiment}`: two signals are named `{signal}`")]
    DuplicateName {
        /// The experiment's name.
        experiment: String,
        /// The duplicate name.
        signal: String,
    },
    /// A value is NaN or infinite.
    #[error("experiment `{experiment}`: `{signal}` is {value} at sample {sample}")]
    NotFinite {
        /// The experiment's name.
        experiment: String,
        /// The invalid signal.
        signal: String,
        /// Row of the value.
        sample: usize,
        /// The value.
        value: f64,
    },
    /// The requested samples do not exist, or their range is empty.
    #[error("experiment `{experiment}`: no samples {start}..{end} in a record of {samples}")]
    Range {
        /// The experiment's name.
        experiment: String,
        /// First requested sample.
        start: usize,
        /// One past the last requested sample.
        end: usize,
        /// Number of samples of the record.
        samples: usize,
    },
    /// No signal of this name.
    #[error("experiment `{experiment}`: no signal `{signal}`; the signals are {known}")]
    UnknownSignal {
        /// The experiment's name.
        experiment: String,
        /// The requested name.
        signal: String,
        /// The existing names.
        known: String,
    },
}

/// One experiment: uniformly sampled inputs and outputs.
///
/// Rows are samples and columns are signals, in the units of the recording. [`Experiment::new`] checks that all values
/// are finite and consistent; the rest of the crate relies on that.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// Name in messages.
    pub name: String,
    /// Time between two samples, s.
    pub period_s: f64,
    /// One name per input column.
    pub input_names: Vec<String>,
    /// One name per output column.
    pub output_names: Vec<String>,
    /// Inputs, samples × inputs.
    pub inputs: DMatrix<f64>,
    /// Outputs, samples × outputs.
    pub outputs: DMatrix<f64>,
    /// Whether the inputs move smoothly between samples, as after decimation. Otherwise each value is held until the
    /// next sample.
    pub is_smooth: bool,
}

/// The trim of an experiment: one constant per signal.
#[derive(Debug, Clone, PartialEq)]
pub struct Offsets {
    /// One per input, in the input's unit.
    pub inputs: DVector<f64>,
    /// One per output, in the output's unit.
    pub outputs: DVector<f64>,
}

impl Experiment {
    /// A checked experiment. Inputs may have no columns (a time series). Outputs must have at least one column.
    ///
    /// # Errors
    /// [`ExperimentError`] for the first fault: the period, the lengths, the names, or the signal and sample of a value
    /// that is not finite.
    ///
    /// # Example
    /// ```
    /// use hovernav_sysid::record::Experiment;
    /// use nalgebra::dmatrix;
    ///
    /// let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>();
    /// let doublet = Experiment::new(
    ///     "yaw doublet",
    ///     0.0303,
    ///     names(&["pedal"]),
    ///     names(&["r_radps"]),
    ///     dmatrix![0.1; -0.1; 0.0],
    ///     dmatrix![0.0; 0.02; f64::NAN],
    /// );
    /// assert_eq!(
    ///     doublet.unwrap_err().to_string(),
    ///     "experiment `yaw doublet`: `r_radps` is NaN at sample 2"
    /// );
    /// ```
    pub fn new(
        name: impl Into<String>,
        period_s: f64,
        input_names: Vec<String>,
        output_names: Vec<String>,
        inputs: DMatrix<f64>,
        outputs: DMatrix<f64>,
    ) -> Result<Self, ExperimentError> {
        let experiment = Self {
            name: name.into(),
            period_s,
            input_names,
            output_names,
            inputs,
            outputs,
            is_smooth: false,
        };
        experiment.check()?;
        Ok(experiment)
    }

    fn check(&self) -> Result<(), ExperimentError> {
        let experiment = || self.name.clone();
        if !(self.period_s.is_finite() && self.period_s > 0.0) {
            return Err(ExperimentError::Period {
                experiment: experiment(),
                period_s: self.period_s,
            });
        }
        let (inputs, outputs) = (self.inputs.nrows(), self.outputs.nrows());
        if inputs != outputs {
            return Err(ExperimentError::Length { experiment: experiment(), inputs, outputs });
        }
        if self.outputs.is_empty() {
            return Err(ExperimentError::Empty {
                experiment: experiment(),
                samples: outputs,
                outputs: self.outputs.ncols(),
            });
        }
        for (kind, names, columns) in [
            ("input", self.input_names.len(), self.inputs.ncols()),
            ("output", self.output_names.len(), self.outputs.ncols()),
        ] {
            if names != columns {
                return Err(ExperimentError::Names {
                    experiment: experiment(),
                    kind,
                    names,
                    columns,
                });
            }
        }
        let names: Vec<_> = self.input_names.iter().chain(&self.output_names).collect();
        for (index, name) in names.iter().enumerate() {
            if names[..index].contains(name) {
                return Err(ExperimentError::DuplicateName {
                    experiment: experiment(),
                    signal: (*name).clone(),
                });
            }
        }
        for (names, signals) in
            [(&self.input_names, &self.inputs), (&self.output_names, &self.outputs)]
        {
            for (signal, column) in names.iter().zip(signals.column_iter()) {
                if let Some(sample) = column.iter().position(|value| !value.is_finite()) {
                    return Err(ExperimentError::NotFinite {
                        experiment: experiment(),
                        signal: signal.clone(),
                        sample,
                        value: column[sample],
                    });
                }
            }
        }
        Ok(())
    }

    /// Number of samples.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.outputs.nrows()
    }

    /// Length of the record, s: samples times the period.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.samples() as f64 * self.period_s
    }

    /// The samples of one signal, input or output.
    ///
    /// # Errors
    /// [`ExperimentError::UnknownSignal`], with the existing names.
    pub fn signal(&self, name: &str) -> Result<DVector<f64>, ExperimentError> {
        let find = |names: &[String]| names.iter().position(|known| known == name);
        if let Some(column) = find(&self.input_names) {
            return Ok(self.inputs.column(column).into_owned());
        }
        if let Some(column) = find(&self.output_names) {
            return Ok(self.outputs.column(column).into_owned());
        }
        Err(ExperimentError::UnknownSignal {
            experiment: self.name.clone(),
            signal: name.to_owned(),
            known: [&self.input_names[..], &self.output_names[..]].concat().join(", "),
        })
    }

    /// The record with these inputs and outputs only, in this order. An output may become an input: a measured output
    /// may be the input of a sub-model.
    ///
    /// # Errors
    /// [`ExperimentError::UnknownSignal`] or [`ExperimentError::DuplicateName`].
    pub fn select(&self, inputs: &[&str], outputs: &[&str]) -> Result<Self, ExperimentError> {
        let gather = |names: &[&str]| -> Result<DMatrix<f64>, ExperimentError> {
            let mut columns = DMatrix::zeros(self.samples(), names.len());
            for (index, name) in names.iter().enumerate() {
                columns.set_column(index, &self.signal(name)?);
            }
            Ok(columns)
        };
        let owned = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        let chosen = Self::new(
            self.name.clone(),
            self.period_s,
            owned(inputs),
            owned(outputs),
            gather(inputs)?,
            gather(outputs)?,
        )?;
        Ok(Self { is_smooth: self.is_smooth, ..chosen })
    }

    /// The samples of a range of rows, as an experiment of the same name.
    ///
    /// # Errors
    /// [`ExperimentError::Range`] where the range is empty or reaches past the end.
    pub fn slice(&self, rows: Range<usize>) -> Result<Self, ExperimentError> {
        if rows.start >= rows.end || rows.end > self.samples() {
            return Err(ExperimentError::Range {
                experiment: self.name.clone(),
                start: rows.start,
                end: rows.end,
                samples: self.samples(),
            });
        }
        let cut = |signals: &DMatrix<f64>| signals.rows(rows.start, rows.len()).into_owned();
        Ok(Self { inputs: cut(&self.inputs), outputs: cut(&self.outputs), ..self.labels() })
    }

    /// The first half for estimation, the second for validation. An odd sample goes to the second.
    ///
    /// # Errors
    /// [`ExperimentError::Range`] where there are fewer than two samples.
    pub fn halves(&self) -> Result<(Self, Self), ExperimentError> {
        let middle = self.samples() / 2;
        Ok((self.slice(0..middle)?, self.slice(middle..self.samples())?))
    }

    /// The mean of each signal.
    #[must_use]
    pub fn means(&self) -> Offsets {
        let means = |signals: &DMatrix<f64>| signals.row_mean().transpose();
        Offsets { inputs: means(&self.inputs), outputs: means(&self.outputs) }
    }

    /// The record as deviations from a trim: `offsets` are subtracted from every sample.
    ///
    /// Use the offsets of the estimation data for validation data too: the model has to explain the mean of the
    /// validation data.
    ///
    /// # Panics
    /// Where `offsets` and this experiment have different numbers of signals.
    #[must_use]
    pub fn about(&self, offsets: &Offsets) -> Self {
        let shift = |signals: &DMatrix<f64>, offsets: &DVector<f64>| {
            assert_eq!(signals.ncols(), offsets.len(), "one offset per signal");
            let row: RowDVector<f64> = offsets.transpose();
            DMatrix::from_fn(signals.nrows(), signals.ncols(), |sample, signal| {
                signals[(sample, signal)] - row[signal]
            })
        };
        Self {
            inputs: shift(&self.inputs, &offsets.inputs),
            outputs: shift(&self.outputs, &offsets.outputs),
            ..self.labels()
        }
    }

    /// The record without the least-squares line through each signal.
    ///
    /// For slow sensor drift only: it also removes the motion of an integrating system.
    #[must_use]
    pub fn detrended(&self) -> Self {
        Self {
            inputs: without_line(&self.inputs),
            outputs: without_line(&self.outputs),
            ..self.labels()
        }
    }

    /// Name, period and signal names with empty signals, for functional update.
    fn labels(&self) -> Self {
        Self {
            name: self.name.clone(),
            period_s: self.period_s,
            input_names: self.input_names.clone(),
            output_names: self.output_names.clone(),
            inputs: DMatrix::zeros(0, 0),
            outputs: DMatrix::zeros(0, 0),
            is_smooth: self.is_smooth,
        }
    }
}

fn without_line(signals: &DMatrix<f64>) -> DMatrix<f64> {
    let samples = signals.nrows();
    let middle = (samples as f64 - 1.0) / 2.0;
    let spread: f64 = (0..samples).map(|sample| (sample as f64 - middle).powi(2)).sum();
    let mut straight = signals.clone();
    for mut column in straight.column_iter_mut() {
        let mean = column.mean();
        let slope = if spread > 0.0 {
            let moment: f64 = column
                .iter()
                .enumerate()
                .map(|(sample, value)| (sample as f64 - middle) * (value - mean))
                .sum();
            moment / spread
        } else {
            0.0
        };
        for (sample, value) in column.iter_mut().enumerate() {
            *value -= mean + slope * (sample as f64 - middle);
        }
    }
    straight
}
