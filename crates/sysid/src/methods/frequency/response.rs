//! Frequency responses of several inputs and outputs, each conditioned on the other inputs, from
//! windows of several lengths.

use nalgebra::{Complex, DMatrix, DVector};
use rayon::prelude::*;

use super::conditioning::{Conditioned, Counts};
use super::spectrum::{Spectra, random_error};
use super::{Band, FrequencyError, SpectrumSettings, Window, spectra};
use crate::record::Experiment;

/// Settings of the response estimation.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponseSettings {
    /// Lengths of the windows, s. Several are combined point by point.
    pub windows_s: Vec<f64>,
    /// Frequencies of the result.
    pub band: Band,
    /// Fraction of a window that the next window shares.
    pub overlap: f64,
}

impl ResponseSettings {
    /// Five windows for `band`, from 20 periods of its last frequency to two periods of its first frequency. The
    /// longest window is at most half of `longest_s`, the shortest at most half of the longest. They overlap by four
    /// fifths.
    ///
    /// # Source
    /// Tischler & Remple, section 10.6: window lengths over a decade, the longest with two periods of the lowest
    /// frequency.
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
    /// Responses at each frequency, outputs × inputs, in output units per input unit.
    pub responses: Vec<DMatrix<Complex<f64>>>,
    /// Partial coherence γ² at each frequency, 0 to 1, outputs × inputs, with the other inputs removed from both
    /// signals.
    pub coherence: Vec<DMatrix<f64>>,
    /// Multiple coherence at each frequency, 0 to 1: fraction of each output that all inputs together explain linearly.
    pub multiple_coherence: Vec<DVector<f64>>,
    /// Random error of each response at each frequency, as a fraction of its magnitude.
    pub random_error: Vec<DMatrix<f64>>,
    /// Power density of each input at each frequency, conditioned on the other inputs, in its unit squared per Hz.
    pub input_power: Vec<DVector<f64>>,
}

impl FrequencyResponse {
    /// The responses at about `count` logarithmically spaced frequencies, selected from the existing ones.
    #[must_use]
    pub fn logarithmic(&self, count: usize) -> Self {
        let (Some(first), Some(last)) = (self.frequencies_hz.first(), self.frequencies_hz.last())
        else {
            return self.clone();
        };
        let steps = count.max(2) - 1;
        let mut kept: Vec<usize> = (0..=steps)
            .map(|step| first * (last / first).powf(step as f64 / steps as f64))
            .map(|hz| self.frequencies_hz.partition_point(|own| *own < hz * (1.0 - 1e-9)))
            .map(|place| place.min(self.frequencies_hz.len() - 1))
            .collect();
        kept.dedup();
        Self {
            frequencies_hz: picked(&self.frequencies_hz, &kept),
            input_names: self.input_names.clone(),
            output_names: self.output_names.clone(),
            responses: picked(&self.responses, &kept),
            coherence: picked(&self.coherence, &kept),
            multiple_coherence: picked(&self.multiple_coherence, &kept),
            random_error: picked(&self.random_error, &kept),
            input_power: picked(&self.input_power, &kept),
        }
    }

    /// The responses of the outputs to the inputs that the two functions accept by name.
    #[must_use]
    pub fn selected(
        &self,
        is_output: impl Fn(&str) -> bool,
        is_input: impl Fn(&str) -> bool,
    ) -> Self {
        let places = |names: &[String], is: &dyn Fn(&str) -> bool| -> Vec<usize> {
            (0..names.len()).filter(|&place| is(&names[place])).collect()
        };
        let outputs = places(&self.output_names, &is_output);
        let inputs = places(&self.input_names, &is_input);
        fn select<T: nalgebra::Scalar>(
            all: &[DMatrix<T>],
            outputs: &[usize],
            inputs: &[usize],
        ) -> Vec<DMatrix<T>> {
            all.iter().map(|one| one.select_rows(outputs).select_columns(inputs)).collect()
        }
        Self {
            frequencies_hz: self.frequencies_hz.clone(),
            input_names: picked(&self.input_names, &inputs),
            output_names: picked(&self.output_names, &outputs),
            responses: select(&self.responses, &outputs, &inputs),
            coherence: select(&self.coherence, &outputs, &inputs),
            multiple_coherence: self
                .multiple_coherence
                .iter()
                .map(|own| own.select_rows(&outputs))
                .collect(),
            random_error: select(&self.random_error, &outputs, &inputs),
            input_power: self.input_power.iter().map(|own| own.select_rows(&inputs)).collect(),
        }
    }

    /// Sets the coherence of the responses that `is_ignored` accepts, by output and input, to zero.
    pub fn ignore(&mut self, is_ignored: impl Fn((usize, usize)) -> bool) {
        for output in 0..self.output_names.len() {
            for input in (0..self.input_names.len()).filter(|&input| is_ignored((output, input))) {
                self.coherence.iter_mut().for_each(|own| own[(output, input)] = 0.0);
            }
        }
    }

    /// The responses with zero coherence at all frequencies where the power of an input has a gap. In a gap it is below
    /// the fraction `part` of its largest power within a third of an octave.
    ///
    /// An input with steps of T seconds has almost no power at multiples of 1/T. At these frequencies windows leak
    /// power from neighbouring frequencies, which is coherent but wrong.
    #[must_use]
    pub fn without_gaps(mut self, part: f64) -> Self {
        let third = 2f64.cbrt();
        for input in 0..self.input_names.len() {
            for (place, &own_hz) in self.frequencies_hz.iter().enumerate() {
                let near = |hz: f64| (own_hz / third..=own_hz * third).contains(&hz);
                let around = self.frequencies_hz.iter().zip(&self.input_power);
                let most = around.filter(|(hz, _)| near(**hz)).map(|(_, power)| power[input]);
                if self.input_power[place][input] < part * most.fold(0.0, f64::max) {
                    self.coherence[place].column_mut(input).fill(0.0);
                }
            }
        }
        self
    }
}

fn picked<T: Clone>(all: &[T], places: &[usize]) -> Vec<T> {
    places.iter().map(|&place| all[place].clone()).collect()
}

/// Responses estimated from all experiments together; the experiments are repetitions of one another.
///
/// The spectra of all windows are averaged at each frequency with the weight (ε/ε_least)⁻⁴ (Tischler & Remple eq.
/// 10.19). The random error ε follows from the window's coherence. An average of spectral matrices is itself a spectral
/// matrix, so every coherence stays between 0 and 1.
///
/// # Errors
/// [`FrequencyError`] where the experiments have different signals or periods, no window fits, or the inputs cannot be
/// separated.
pub fn frequency_response(
    experiments: &[Experiment],
    settings: &ResponseSettings,
) -> Result<FrequencyResponse, FrequencyError> {
    joint_response(experiments, &[], settings)
}

/// Frequency responses for flights in closed loop, with respect to the component of the inputs that follows the
/// `references`. The references are those inputs of the experiments that were injected from outside; the other inputs
/// acted on the vehicle. There must be at least as many references as inputs. Without references every input is its own
/// reference, and this is [`frequency_response`].
///
/// A controller responds to gusts with the inputs. The ratio of output to input spectra therefore describes the
/// controller as much as the vehicle. The references are independent of the gusts.
///
/// # Errors
/// As [`frequency_response`]; [`FrequencyError::Experiments`] where a reference is not among the inputs.
///
/// # Source
/// Tischler & Remple, section 5.8 and chapter 9, the joint input–output method. With as many references as inputs it is
/// the quotient of the responses of output and input to them.
pub fn joint_response(
    experiments: &[Experiment],
    references: &[&str],
    settings: &ResponseSettings,
) -> Result<FrequencyResponse, FrequencyError> {
    let first = check_alike(experiments)?;
    let is_reference = |name: &&String| references.iter().any(|reference| reference == name);
    let input_names: Vec<String> =
        first.input_names.iter().filter(|name| !is_reference(name)).cloned().collect();
    let counts = Counts { references: references.len(), inputs: input_names.len() };
    if let Some(missing) =
        references.iter().find(|name| !first.input_names.iter().any(|n| n == *name))
    {
        let reason = format!("`{}` has no input `{missing}` to use as a reference", first.name);
        return Err(FrequencyError::Experiments { reason });
    }
    if counts.inputs == 0 || (counts.references > 0 && counts.references < counts.inputs) {
        let (references, inputs) = (counts.references, counts.inputs);
        let reason = format!("`{}` has {references} references for {inputs} inputs", first.name);
        return Err(FrequencyError::Experiments { reason });
    }
    let order: Vec<&str> =
        references.iter().copied().chain(input_names.iter().map(String::as_str)).collect();
    let records: Vec<DMatrix<f64>> =
        experiments.iter().map(|experiment| side_by_side(experiment, &order)).collect();
    let records: Vec<&DMatrix<f64>> = records.iter().collect();
    let windows = settings
        .windows_s
        .par_iter()
        .map(|&window_s| {
            let (overlap, band) = (settings.overlap, settings.band);
            let spectrum = SpectrumSettings { window_s, overlap, window: Window::Hann, band };
            Ok((window_s, spectra(&records, first.period_s, &spectrum)?))
        })
        .collect::<Vec<Result<_, FrequencyError>>>();
    let windows = windows.into_iter().collect::<Result<Vec<_>, _>>()?;
    if windows.is_empty() {
        return Err(FrequencyError::Window { window: 0, longest: first.samples() });
    }

    let frequencies_hz = settings.band.frequencies_hz();
    let mut response = FrequencyResponse {
        input_names: input_names.clone(),
        output_names: first.output_names.clone(),
        responses: Vec::new(),
        coherence: Vec::new(),
        multiple_coherence: Vec::new(),
        random_error: Vec::new(),
        input_power: Vec::new(),
        frequencies_hz: frequencies_hz.clone(),
    };
    for (point, &frequency_hz) in frequencies_hz.iter().enumerate() {
        let dependent = |input: usize| FrequencyError::DependentInputs {
            input: order[input].to_owned(),
            frequency_hz,
        };
        let errors: Vec<f64> = windows
            .iter()
            .map(|(window_s, spectra)| {
                window_error(*window_s, spectra, point, counts, frequency_hz)
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
        let conditioned = Conditioned::from(&density, counts).map_err(dependent)?;
        let error = |coherence| random_error(coherence, averages, windows[0].1.error_constant);
        response.random_error.push(conditioned.coherence.map(error));
        response.responses.push(conditioned.responses);
        response.coherence.push(conditioned.coherence);
        response.multiple_coherence.push(conditioned.multiple);
        response.input_power.push(conditioned.input_power);
    }
    Ok(response)
}

fn check_alike(experiments: &[Experiment]) -> Result<&Experiment, FrequencyError> {
    let reject = |reason: String| FrequencyError::Experiments { reason };
    let Some(first) = experiments.first() else {
        return Err(reject("found no experiments".to_owned()));
    };
    if first.inputs.ncols() == 0 {
        return Err(reject(format!("`{}` has no inputs", first.name)));
    }
    for other in &experiments[1..] {
        let alike = other.input_names == first.input_names
            && other.output_names == first.output_names
            && (other.period_s - first.period_s).abs() < 1e-9 * first.period_s;
        if !alike {
            return Err(reject(format!("`{}` and `{}` differ", first.name, other.name)));
        }
    }
    Ok(first)
}

/// Samples × signals: the inputs in the order of `names`, then the outputs.
fn side_by_side(experiment: &Experiment, names: &[&str]) -> DMatrix<f64> {
    let of_inputs = names.iter().filter_map(|name| {
        let place = experiment.input_names.iter().position(|known| known == name)?;
        Some(experiment.inputs.column(place))
    });
    let columns: Vec<_> = of_inputs.chain(experiment.outputs.column_iter()).collect();
    DMatrix::from_fn(experiment.samples(), columns.len(), |row, column| columns[column][row])
}

/// Mean random error over all responses; infinite where the window does not resolve the frequency.
fn window_error(
    window_s: f64,
    spectra: &Spectra,
    point: usize,
    counts: Counts,
    frequency_hz: f64,
) -> f64 {
    // A Hann window does not resolve frequencies within 1.5 bins of zero.
    if window_s * frequency_hz < 1.5 {
        return f64::INFINITY;
    }
    match Conditioned::from(&spectra.densities[point], counts) {
        Ok(conditioned) => conditioned.coherence.map(|value| spectra.random_error(value)).mean(),
        Err(_) => f64::INFINITY,
    }
}
