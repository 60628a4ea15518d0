//! Frequency responses of several inputs and outputs, each conditioned on the other inputs, from
//! windows of several lengths.

use nalgebra::{Complex, DMatrix, DVector};

use super::spectrum::{Spectra, random_error};
use super::{Band, FrequencyError, SpectrumSettings, Window, spectra};
use crate::record::Experiment;

/// How to estimate responses.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponseSettings {
    /// Lengths of the windows, s. Several are combined point by point.
    pub windows_s: Vec<f64>,
    /// The frequencies wanted.
    pub band: Band,
    /// Part of a window shared with the next.
    pub overlap: f64,
}

impl ResponseSettings {
    /// Five windows over `band`, from 20 periods of its middle down to one of its first frequency,
    /// as far as `longest_s` allows; four fifths overlap.
    ///
    /// # Source
    /// Tischler & Remple, section 10.6: window lengths over a decade, of which the longest holds two
    /// periods of the lowest frequency.
    #[must_use]
    pub fn composite(band: Band, longest_s: f64) -> Self {
        let longest = (2.0 / band.first_hz).min(0.5 * longest_s);
        let shortest = (20.0 / band.last_hz).min(0.5 * longest);
        let ratio = (longest / shortest).powf(0.25);
        let windows_s = (0..5).map(|index| shortest * ratio.powi(index)).collect();
        Self { windows_s, band, overlap: 0.8 }
    }
}

/// Responses of all outputs to all inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct FrequencyResponse {
    /// The frequencies, Hz.
    pub frequencies_hz: Vec<f64>,
    /// Names of the inputs.
    pub input_names: Vec<String>,
    /// Names of the outputs.
    pub output_names: Vec<String>,
    /// At each frequency the responses, outputs × inputs, in output units per input unit.
    pub responses: Vec<DMatrix<Complex<f64>>>,
    /// At each frequency the partial coherence γ² of each output and input, the other inputs taken
    /// out of both; 0 to 1, outputs × inputs.
    pub coherence: Vec<DMatrix<f64>>,
    /// At each frequency the part of each output that all inputs together explain linearly, 0 to 1.
    pub multiple_coherence: Vec<DVector<f64>>,
    /// At each frequency the random error of each response as a part of its size.
    pub random_error: Vec<DMatrix<f64>>,
}

/// The responses that the experiments, repetitions of one another, show together.
///
/// At each frequency the spectra of all windows are averaged with the weight (ε/ε_least)⁻⁴, where ε
/// is the random error that the window's own coherence implies (Tischler & Remple eq. 10.19). The
/// average of spectral matrices is one itself, so every coherence stays between 0 and 1.
///
/// # Errors
/// [`FrequencyError`] where the experiments do not go together, no window fits, or the inputs cannot
/// be told apart.
pub fn frequency_response(
    experiments: &[Experiment],
    settings: &ResponseSettings,
) -> Result<FrequencyResponse, FrequencyError> {
    let first = check_alike(experiments)?;
    let inputs = first.inputs.ncols();
    let records: Vec<DMatrix<f64>> = experiments.iter().map(side_by_side).collect();
    let records: Vec<&DMatrix<f64>> = records.iter().collect();
    let windows = settings
        .windows_s
        .iter()
        .map(|&window_s| {
            let (overlap, band) = (settings.overlap, settings.band);
            let spectrum = SpectrumSettings { window_s, overlap, window: Window::Hann, band };
            Ok((window_s, spectra(&records, first.period_s, &spectrum)?))
        })
        .collect::<Result<Vec<_>, FrequencyError>>()?;
    if windows.is_empty() {
        return Err(FrequencyError::Window { window: 0, longest: first.samples() });
    }

    let frequencies_hz = settings.band.frequencies_hz();
    let mut response = FrequencyResponse {
        input_names: first.input_names.clone(),
        output_names: first.output_names.clone(),
        responses: Vec::new(),
        coherence: Vec::new(),
        multiple_coherence: Vec::new(),
        random_error: Vec::new(),
        frequencies_hz: frequencies_hz.clone(),
    };
    for (point, &frequency_hz) in frequencies_hz.iter().enumerate() {
        let dependent = |input: usize| FrequencyError::DependentInputs {
            input: first.input_names[input].clone(),
            frequency_hz,
        };
        let errors: Vec<f64> = windows
            .iter()
            .map(|(window_s, spectra)| {
                window_error(*window_s, spectra, point, inputs, frequency_hz)
            })
            .collect();
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let weights: Vec<f64> = if least.is_finite() {
            errors.iter().map(|error| (least.max(1e-9) / error.max(1e-9)).powi(4)).collect()
        } else {
            vec![1.0; windows.len()]
        };
        let total: f64 = weights.iter().sum();
        let mut density = DMatrix::zeros(records[0].ncols(), records[0].ncols());
        let mut averages = 0.0;
        for ((_, spectra), weight) in windows.iter().zip(&weights) {
            density += &spectra.densities[point] * Complex::from(weight / total);
            averages += spectra.averages * weight / total;
        }
        let conditioned = Conditioned::from(&density, inputs).map_err(dependent)?;
        let error = |coherence| random_error(coherence, averages, windows[0].1.error_constant);
        response.random_error.push(conditioned.coherence.map(error));
        response.responses.push(conditioned.responses);
        response.coherence.push(conditioned.coherence);
        response.multiple_coherence.push(conditioned.multiple);
    }
    Ok(response)
}

fn check_alike(experiments: &[Experiment]) -> Result<&Experiment, FrequencyError> {
    let refuse = |reason: String| FrequencyError::Experiments { reason };
    let Some(first) = experiments.first() else { return Err(refuse("there are none".to_owned())) };
    if first.inputs.ncols() == 0 {
        return Err(refuse(format!("`{}` has no inputs", first.name)));
    }
    for other in &experiments[1..] {
        let alike = other.input_names == first.input_names
            && other.output_names == first.output_names
            && (other.period_s - first.period_s).abs() < 1e-9 * first.period_s;
        if !alike {
            return Err(refuse(format!("`{}` and `{}` differ", first.name, other.name)));
        }
    }
    Ok(first)
}

fn side_by_side(experiment: &Experiment) -> DMatrix<f64> {
    let inputs = experiment.inputs.ncols();
    let mut record = DMatrix::zeros(experiment.samples(), inputs + experiment.outputs.ncols());
    record.columns_mut(0, inputs).copy_from(&experiment.inputs);
    record.columns_mut(inputs, experiment.outputs.ncols()).copy_from(&experiment.outputs);
    record
}

/// Mean random error over all responses; infinite where the window cannot see the frequency.
fn window_error(
    window_s: f64,
    spectra: &Spectra,
    point: usize,
    inputs: usize,
    frequency_hz: f64,
) -> f64 {
    // A Hann window resolves nothing within two bins of zero.
    if window_s * frequency_hz < 1.5 {
        return f64::INFINITY;
    }
    match Conditioned::from(&spectra.densities[point], inputs) {
        Ok(conditioned) => conditioned.coherence.map(|value| spectra.random_error(value)).mean(),
        Err(_) => f64::INFINITY,
    }
}

struct Conditioned {
    responses: DMatrix<Complex<f64>>,
    coherence: DMatrix<f64>,
    multiple: DVector<f64>,
}

/// An input of which the others explain all but this part cannot be told from them.
const OWN_PART: f64 = 1e-8;

impl Conditioned {
    /// Responses and partial coherences from the spectral matrix of inputs, then outputs. The error
    /// is the input that cannot be told from the others.
    ///
    /// # Source
    /// Equation (I19) of docs/equations.md.
    fn from(density: &DMatrix<Complex<f64>>, inputs: usize) -> Result<Self, usize> {
        let outputs = density.nrows() - inputs;
        let among = density.view((0, 0), (inputs, inputs)).into_owned();
        let across = density.view((0, inputs), (inputs, outputs)).into_owned();
        let still = |input: &usize| among[(*input, *input)].re <= 0.0;
        if let Some(input) = (0..inputs).find(still) {
            return Err(input);
        }
        // In units of each input's own power, so that units do not decide what is singular.
        let sizes = DVector::from_fn(inputs, |input, _| among[(input, input)].re.sqrt());
        let unit = DMatrix::from_fn(inputs, inputs, |row, column| {
            among[(row, column)] / (sizes[row] * sizes[column])
        });
        let inverse = unit.try_inverse().ok_or(inputs - 1)?;
        // What is left of each input's power once the others are taken out.
        let own = DVector::from_fn(inputs, |input, _| 1.0 / inverse[(input, input)].re);
        let lost = |input: &usize| own[*input].is_nan() || own[*input] < OWN_PART;
        if let Some(input) = (0..inputs).find(lost) {
            return Err(input);
        }
        let scaled =
            DMatrix::from_fn(inputs, outputs, |row, column| across[(row, column)] / sizes[row]);
        let gains = inverse * &scaled;
        let mut coherence = DMatrix::zeros(outputs, inputs);
        let mut multiple = DVector::zeros(outputs);
        for output in 0..outputs {
            let total = density[(inputs + output, inputs + output)].re;
            let explained: f64 = (0..inputs)
                .map(|input| (scaled[(input, output)].conj() * gains[(input, output)]).re)
                .sum();
            let left = (total - explained).max(0.0);
            multiple[output] = if total > 0.0 { 1.0 - left / total } else { 0.0 };
            for input in 0..inputs {
                let share = gains[(input, output)].norm_sqr() * own[input];
                coherence[(output, input)] =
                    if share + left > 0.0 { share / (share + left) } else { 0.0 };
            }
        }
        let responses = DMatrix::from_fn(outputs, inputs, |output, input| {
            gains[(input, output)] / sizes[input]
        });
        Ok(Self { responses, coherence, multiple })
    }
}
