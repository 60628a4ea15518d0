//! The handling qualities of a design, on its page.

use hovernav_design::{CheckedDesign, HandlingQualities};

use hovernav_pages::{Axis, Figure, Role, Row, Section, Series, Table, TableRow};

/// Level 1 limits of the rejection bandwidth of phi, theta, psi, rad/s, for large helicopters in hover.
///
/// # Source
/// Blanken, Lusardi, Ivler, Tischler and others (2009), *An investigation of rotorcraft stability-phase margin
/// requirements in hover*, AHS 65th Forum. The numbers are quoted from other papers and were not checked against this
/// paper.
const LEVEL_1_RADPS: [f64; 3] = [0.9, 0.5, 0.7];
/// Level 1 limit of the rejection peak, dB, from the same source as [`LEVEL_1_RADPS`].
const LEVEL_1_PEAK_DB: f64 = 5.0;

/// Handling qualities of the attitude loops, next to the limits for large helicopters.
pub fn handling(checked: &CheckedDesign) -> Section {
    let number = |value: Option<f64>, digits: usize| {
        value.map_or_else(|| "–".to_owned(), |value| format!("{value:.digits$}"))
    };
    let row = |(found, least): (&HandlingQualities, f64)| {
        TableRow::new(
            axis_of(found),
            vec![
                number(found.rejection_bandwidth_radps, 2),
                format!("{least}"),
                format!("{:.1}", found.rejection_peak_db),
                format!("{LEVEL_1_PEAK_DB}"),
                number(found.bandwidth_radps, 1),
                number(found.phase_delay_s.map(|delay_s| 1e3 * delay_s), 0),
            ],
        )
    };
    let heads = [
        "",
        "Rejection bandwidth, rad/s",
        "at least",
        "Rejection peak, dB",
        "at most",
        "Bandwidth, rad/s",
        "Phase delay, ms",
    ];
    Section::new(
        "handling",
        "Handling qualities",
        "Attitude loops: the frequency up to which attitude disturbances are attenuated, the largest \
         amplification, and the speed of the response to commands. The limits are for comparison only and do not \
         affect the verdict. They are quoted for helicopters of several tons in hover after Blanken and others \
         (2009) and were not checked against the paper. They are not part of ADS-33E-PRF. A small helicopter \
         responds faster and should be well within them.",
    )
    .with(Table {
        caption: "Disturbance rejection, bandwidth and phase delay of each attitude loop, with the other loops closed".into(),
        heads: heads.map(Into::into).into(),
        rows: checked.handling.iter().zip(LEVEL_1_RADPS).map(row).collect(),
    })
    .with(rejection(checked))
}

fn axis_of(found: &HandlingQualities) -> &'static str {
    match found.output.as_str() {
        "phi" => "roll",
        "theta" => "pitch",
        _ => "heading",
    }
}

/// Rejection peak over rejection bandwidth, one point per attitude. Each point should lie to the right of and below the
/// limit lines of its colour.
fn rejection(checked: &CheckedDesign) -> Figure {
    let found = checked.handling.iter().zip(LEVEL_1_RADPS);
    let found = found.zip([
        (Role::First, Role::FirstLimit),
        (Role::Second, Role::SecondLimit),
        (Role::Third, Role::ThirdLimit),
    ]);
    let right_radps = checked
        .handling
        .iter()
        .filter_map(|found| found.rejection_bandwidth_radps)
        .fold(2.0 * LEVEL_1_RADPS[0], |most, radps| most.max(1.1 * radps));
    let mut row = Row { limits: Some([0.0, 12.0]), ..Row::new("Rejection peak", "dB") };
    for ((found, min_radps), (role, limit)) in found {
        let corner =
            [(min_radps, 0.0), (min_radps, LEVEL_1_PEAK_DB), (right_radps, LEVEL_1_PEAK_DB)];
        let place = found.rejection_bandwidth_radps.map(|radps| (radps, found.rejection_peak_db));
        let name = axis_of(found);
        row = row
            .with(Series::curve(limit, corner).named(format!("limits of {name}")))
            .with(Series::points(role, place.into_iter()).named(name));
    }
    let axis = Axis::linear("Rejection bandwidth", "rad/s").within([0.0, 1.02 * right_radps]);
    Figure::against(axis, [row])
        .captioned("Largest amplification over rejection bandwidth, with the limits of each axis")
}
