//! `--export`: the model and the responses in the formats of other programs.

use std::fmt::Write as _;
use std::path::Path;

use hovernav_model::StateSpace;
use hovernav_sysid::helicopter::FrequencyDomain;

use crate::output;

/// A file for another program.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
pub enum ExportFormat {
    /// The frequency responses of flight and model with their coherence, `responses.csv`
    Csv,
    /// The model as a MATLAB script, `model.m`
    Matlab,
}

/// Files of the formats.
const RESPONSES: &str = "responses.csv";
const SCRIPT: &str = "model.m";

/// Writes the requested files to `out`, and removes older ones that are not requested.
pub fn write(
    asked: &[ExportFormat],
    vehicle: &StateSpace,
    frequency: Option<&FrequencyDomain>,
    out: &Path,
) -> anyhow::Result<()> {
    let is_asked = |format| asked.contains(&format);
    let script = is_asked(ExportFormat::Matlab).then(|| vehicle.to_matlab());
    let table = frequency.filter(|_| is_asked(ExportFormat::Csv)).map(responses);
    for (name, text) in [(SCRIPT, script), (RESPONSES, table)] {
        match text {
            Some(text) => output::write(&out.join(name), text)?,
            None => output::remove_stale(out, [name]),
        }
    }
    Ok(())
}

/// Largest magnitude of a response that is only rounding error. It counts as absent: zero has no decibels.
const NONE: f64 = 1e-12;

/// One row per stick, output and frequency. Magnitudes are in dB of the output's unit, rad/s or m/s², per unit stick.
/// Empty where there is no response.
fn responses(frequency: &FrequencyDomain) -> String {
    let mut text = "stick,output,frequency_hz,flight_db,flight_deg,coherence,random_error,model_db,model_deg\n".to_owned();
    let measured = &frequency.measured;
    for (input, stick) in measured.input_names.iter().enumerate() {
        for (output, name) in measured.output_names.iter().enumerate() {
            for (at, frequency_hz) in measured.frequencies_hz.iter().enumerate() {
                let place = (output, input);
                let [flight, model] = [&measured.responses, &frequency.modelled].map(|of| {
                    let value = of[at][place];
                    let (size, phase_deg) = (value.norm(), value.arg().to_degrees());
                    if size > NONE {
                        format!("{:.4},{phase_deg:.3}", 20.0 * size.log10())
                    } else {
                        ",".to_owned()
                    }
                });
                let (coherence, error) =
                    (measured.coherence[at][place], measured.random_error[at][place]);
                let _ = writeln!(
                    text,
                    "{stick},{name},{frequency_hz:.5},{flight},{coherence:.4},{error:.4},{model}"
                );
            }
        }
    }
    text
}
