//! Responses at one frequency from a spectral matrix, each conditioned on the other inputs.

use nalgebra::{Complex, DMatrix, DVector};

/// Number of references, which come first, and of inputs, which follow them; the outputs come last.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counts {
    /// Number of references; 0 where every input is its own reference.
    pub references: usize,
    pub inputs: usize,
}

/// Responses and coherences at one frequency.
pub(super) struct Conditioned {
    /// Responses, outputs × inputs.
    pub responses: DMatrix<Complex<f64>>,
    /// Partial coherence, outputs × inputs.
    pub coherence: DMatrix<f64>,
    /// Multiple coherence: fraction of each output that all inputs together explain.
    pub multiple: DVector<f64>,
    /// Power of each input, conditioned on the others.
    pub input_power: DVector<f64>,
}

/// Fraction of a signal's power that is independent of the others, below which the signal counts as their combination.
const OWN_PART: f64 = 1e-8;

impl Conditioned {
    /// Responses and partial coherences from the spectral matrix of references, inputs and outputs. Only the component
    /// of the inputs that follows the references counts. Without references the whole input counts. The error is the
    /// index of a signal that is a combination of the others.
    ///
    /// # Source
    /// Equations (I19) and (I29) of docs/equations.md.
    pub fn from(density: &DMatrix<Complex<f64>>, counts: Counts) -> Result<Self, usize> {
        let Counts { references, inputs } = counts;
        let driven = density.ncols() - references;
        let own = density.view((references, references), (driven, driven)).into_owned();
        let followed = if references == 0 {
            own.clone()
        } else {
            let among = density.view((0, 0), (references, references)).into_owned();
            let across = density.view((0, references), (references, driven)).into_owned();
            across.adjoint() * Unmixed::from(&among)?.solve(&across)
        };
        let outputs = driven - inputs;
        let among = followed.view((0, 0), (inputs, inputs)).into_owned();
        let across = followed.view((0, inputs), (inputs, outputs)).into_owned();
        let unmixed = Unmixed::from(&among).map_err(|input| references + input)?;
        let gains = unmixed.solve(&across);

        let sticks = own.view((0, 0), (inputs, inputs));
        let input_power = DVector::from_fn(inputs, |input, _| unmixed.own_power(input));
        let mut coherence = DMatrix::zeros(outputs, inputs);
        let mut multiple = DVector::zeros(outputs);
        for output in 0..outputs {
            let gains = gains.column(output);
            let total = own[(inputs + output, inputs + output)].re;
            let answered = gains.dotc(&own.view((0, inputs + output), (inputs, 1))).re;
            let modelled = gains.dotc(&(sticks * gains)).re;
            let left = (total - 2.0 * answered + modelled).max(0.0);
            let explained =
                if references == 0 { total - left } else { gains.dotc(&(&among * gains)).re };
            multiple[output] = share(explained.max(0.0), left);
            for input in 0..inputs {
                let part = gains[input].norm_sqr() * input_power[input];
                coherence[(output, input)] = share(part, left);
            }
        }
        Ok(Self { responses: gains.transpose(), coherence, multiple, input_power })
    }
}

/// `part` as a fraction of `part` and `rest` together; 0 where both are 0.
fn share(part: f64, rest: f64) -> f64 {
    if part + rest > 0.0 { part / (part + rest) } else { 0.0 }
}

/// The inverse of a spectral matrix, each signal scaled by its own power so that units do not affect singularity.
struct Unmixed {
    inverse: DMatrix<Complex<f64>>,
    sizes: DVector<f64>,
}

impl Unmixed {
    /// Inverts the spectral matrix `among`. The error is the index of a signal that does not move, or that the others
    /// explain.
    fn from(among: &DMatrix<Complex<f64>>) -> Result<Self, usize> {
        let count = among.nrows();
        if let Some(still) = (0..count).find(|&signal| among[(signal, signal)].re <= 0.0) {
            return Err(still);
        }
        let sizes = DVector::from_fn(count, |signal, _| among[(signal, signal)].re.sqrt());
        let unit = DMatrix::from_fn(count, count, |row, column| {
            among[(row, column)] / (sizes[row] * sizes[column])
        });
        let inverse = unit.try_inverse().ok_or(count - 1)?;
        let unmixed = Self { inverse, sizes };
        let lost = |signal: &usize| {
            let own = unmixed.inverse[(*signal, *signal)].re.recip();
            own.is_nan() || own < OWN_PART
        };
        (0..count).find(lost).map_or(Ok(unmixed), Err)
    }

    /// The inverse of the spectral matrix times `right`.
    fn solve(&self, right: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
        let scaled = |matrix: &DMatrix<Complex<f64>>| {
            DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |row, column| {
                matrix[(row, column)] / self.sizes[row]
            })
        };
        scaled(&(&self.inverse * scaled(right)))
    }

    /// Power of a signal, conditioned on the others.
    fn own_power(&self, signal: usize) -> f64 {
        self.sizes[signal].powi(2) / self.inverse[(signal, signal)].re
    }
}
