//! Response of a design to gusts, on its page.

use hovernav_design::CheckedDesign;
use hovernav_design::hover::{FlightMode, GustResponse, Gusts};

use hovernav_pages::{Section, Table, TableRow};

/// Standard deviations in gusts, for each mode that holds velocity.
pub fn in_gusts(checked: &CheckedDesign) -> Section {
    let Gusts { sigma_mps: [horizontal, vertical], length_m, passing_mps } = checked.gusts;
    let row = |(mode, found): &(FlightMode, GustResponse)| {
        let degrees = |values: &[f64]| -> Vec<String> {
            values.iter().map(|value| format!("{:.1}", value.to_degrees())).collect()
        };
        let mut numbers: Vec<String> =
            found.states[6..].iter().map(|value| format!("{value:.2}")).collect();
        numbers.extend(degrees(&found.states[3..6]));
        numbers.extend(degrees(&found.states[..3]));
        numbers.extend(found.sticks.map(|stick| format!("{:.1}", 100.0 * stick)));
        TableRow::new(format!("holding {}", mode.name()), numbers)
    };
    let heads = [
        "",
        "u, m/s",
        "v",
        "w",
        "Roll, °",
        "Pitch",
        "Heading",
        "p, °/s",
        "q",
        "r",
        "Lateral, %",
        "Longitudinal",
        "Collective",
        "Pedal",
    ];
    Section::new(
        "gusts",
        "Gusts",
        format!(
            "Dryden gusts of {horizontal} m/s along each horizontal axis and {vertical} m/s vertically, one \
             sigma. Their scale lengths are {} and {} m, and they pass at {passing_mps} m/s along the nose. The \
             table lists the steady-state response of the linear loops. Estimation errors add to it in flight.",
            length_m[0], length_m[1]
        ),
    )
    .with(Table {
        caption: "Standard deviations about trim".into(),
        heads: heads.map(Into::into).into(),
        rows: checked.in_gusts.iter().map(row).collect(),
    })
}
