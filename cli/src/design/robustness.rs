//! Robustness of a design to the uncertainty of its model, on its page.

use hovernav_design::CheckedDesign;
use hovernav_design::hover::{SampledMode, SampledRobustness};

use super::words;
use hovernav_pages::{Section, Table, TableRow};

/// Sampled and proven robustness to the uncertainty of the identified parameters; `None` if the model has no
/// covariance.
pub fn robustness(checked: &CheckedDesign) -> Option<Section> {
    let found = checked.sampled.as_ref()?;
    let SampledRobustness { of, directions, .. } = found;
    let row = |own: &SampledMode| {
        let SampledMode { mode, stable, twentieth, worst, proven } = own;
        let number = |value: f64| {
            if value.is_finite() { format!("{value:.1}") } else { "any".into() }
        };
        let mut cells = vec![format!("{stable} of {of}")];
        cells.extend([twentieth.0, twentieth.1, worst.0, worst.1].map(number));
        let sigmas = |sigmas: f64| {
            if sigmas < 1e3 { format!("{sigmas:.2}") } else { "over 1000".into() }
        };
        cells.push(proven.map_or_else(|| "none".into(), |proven| sigmas(proven.sigmas)));
        cells.push(proven.map_or_else(|| "-".into(), |own| format!("{:.2}", own.frequency_radps)));
        TableRow::new(format!("holding {}", mode.name()), cells)
    };
    let heads = [
        "",
        "Stable",
        "One in twenty below, dB",
        "below, °",
        "Worst, dB",
        "Worst, °",
        "Proven, sigmas",
        "at, rad/s",
    ];
    let section = Section::new(
        "robustness",
        "Uncertainty of the identification",
        format!(
            "{of} vehicles are drawn from the covariance of the model\u{2019}s parameters, including correlations. Each \
             one flies with the gains as designed; the table lists the weakest margins of any loop. Proven is the \
             radius, in sigmas of the covariance, within which all parameters together may vary in any direction \
             while the loops stay stable: an upper bound of the structured singular value. A vehicle drawn in \
             {directions} directions deviates by about {:.1} sigmas. A smaller proven radius therefore covers few of \
             the drawn vehicles; every vehicle within the radius is stable.",
            (*directions as f64).sqrt()
        ),
    );
    Some(section.with(words::sampled(found).to_vec()).with(Table {
        caption: "Stability and margins of the drawn vehicles, and the proven radius".into(),
        heads: heads.map(Into::into).into(),
        rows: found.modes.iter().map(row).collect(),
    }))
}
