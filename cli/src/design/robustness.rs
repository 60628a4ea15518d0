//! What a design is worth on vehicles that its model may stand for, on its page.

use hovernav_design::CheckedDesign;
use hovernav_design::hover::{SampledMode, SampledRobustness};

use super::words;
use crate::page::{Section, Table, TableRow};

/// Sampled and proven robustness to what the identification of the model leaves open, where the model tells.
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
        "What the identification leaves open",
        format!(
            "{of} vehicles drawn from the covariance of the model\u{2019}s parameters, correlations kept, each under \
             the gains as designed, and the weakest margins of any loop of each. Proven is how far all parameters \
             together may be off, in sigmas of the covariance and whichever way, with the loops sure to stay stable: an \
             upper bound of the structured singular value. A vehicle drawn in {directions} directions is off by about \
             {:.1} sigmas, so a bound below that proves nothing of most vehicles drawn; none that lies within it may \
             be unstable.",
            (*directions as f64).sqrt()
        ),
    );
    Some(section.with(words::sampled(found).to_vec()).with(Table {
        caption: "Stability and margins of the vehicles drawn, and the proven radius".into(),
        heads: heads.map(Into::into).into(),
        rows: found.modes.iter().map(row).collect(),
    }))
}
