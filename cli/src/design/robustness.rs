//! Robustness of a design to the uncertainty of its model and to the speed of the vehicle, on its page.

use hovernav_design::hover::{ForwardPoint, SampledMode, SampledRobustness};
use hovernav_design::{CheckedDesign, ZONE};

use super::words;
use hovernav_pages::{Axis, Figure, Role, Row, Section, Series, Table, TableRow};

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

/// Weakest margins over forward speed; `None` without models of forward flight.
pub fn forward_flight(checked: &CheckedDesign) -> Option<Section> {
    let forward = checked.forward.as_ref()?;
    let row = |point: &ForwardPoint| {
        let cells = match point.weakest() {
            Some([gain_db, phase_deg, disk]) => {
                vec![format!("{gain_db:.1}"), format!("{phase_deg:.1}"), format!("{disk:.2}")]
            }
            None => vec!["unstable".into(), "-".into(), "-".into()],
        };
        let origin = if point.is_given { "given" } else { "interpolated" };
        TableRow::new(format!("{:.1} m/s", point.speed_mps), [cells, vec![origin.into()]].concat())
    };
    let curve = |which: usize| {
        let known = forward.points.iter().filter_map(|own| Some((own.speed_mps, own.weakest()?)));
        known.map(move |(speed_mps, weakest)| (speed_mps, weakest[which]))
    };
    let ends = || forward.points.first().into_iter().chain(forward.points.last());
    let limit = |level: f64| {
        Series::curve(Role::Limit, ends().map(move |own| (own.speed_mps, level))).named("required")
    };
    let rows = [("Gain", "dB", ZONE.0), ("Phase", "°", ZONE.1)].into_iter().enumerate();
    let rows = rows.map(|(which, (name, unit, least))| {
        Row::new(name, unit).with(limit(least)).with(Series::curve(Role::Model, curve(which)))
    });
    Some(
        Section::new(
            "forward",
            "Forward flight",
            format!(
                "The same gains from hover to the fastest model: the weakest margins of any loop in any flight mode, and \
                 the disk margin of all actuators at once. Between two given models of the same states every derivative \
                 is interpolated. Result: {}.",
                words::allowed(checked, forward)
            ),
        )
        .with(Table {
            caption: "Weakest margins at each speed".into(),
            heads: ["", "Gain, dB", "Phase, °", "Disk", "Model"].map(Into::into).into(),
            rows: forward.points.iter().map(row).collect(),
        })
        .with(
            Figure::against(Axis::linear("Forward speed", "m/s"), rows)
                .captioned("Weakest gain margin and phase margin over speed"),
        ),
    )
}
