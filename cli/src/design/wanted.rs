//! Requirements of a weight search and its results, on the page.

use hovernav_design::hover::{Search, Wanted};
use hovernav_design::{ChannelMargins, CheckedDesign};

use hovernav_pages::{Section, Table, TableRow};

/// The requirements of the search next to the results. An unmet requirement is a compromise with the other
/// requirements.
pub fn wanted(checked: &CheckedDesign, search: &Search, wanted: &Wanted) -> Section {
    let back = |names: &[&str], wanted_s: f64| {
        let own = checked.responses.iter().filter(|own| names.contains(&own.state.as_str()));
        let found_s =
            own.map(|own| own.recovered_s(0.02).unwrap_or(f64::INFINITY)).fold(0.0, f64::max);
        let found = if found_s.is_finite() { format!("{found_s:.2} s") } else { "never".into() };
        row(
            format!("{} within 2 %", names.join(", ")),
            format!("at most {wanted_s} s"),
            found,
            found_s <= wanted_s,
        )
    };
    let mut rows = vec![
        back(&["phi", "theta", "p", "q", "u", "v"], wanted.settled_s[0]),
        back(&["psi", "r"], wanted.settled_s[1]),
        back(&["w"], wanted.settled_s[2]),
    ];
    for (mode, margins) in &checked.modes {
        let channels = || margins.iter().flat_map(|margins| &margins.channels);
        let gain_db =
            channels().map(ChannelMargins::smallest_gain_db).fold(f64::INFINITY, f64::min);
        let phase_deg = channels().map(ChannelMargins::phase_deg).fold(f64::INFINITY, f64::min);
        let found = match margins {
            Some(_) => format!("{phase_deg:.1}°, {gain_db:.1} dB"),
            None => "unstable".into(),
        };
        rows.push(row(
            format!("weakest margins holding {}", mode.name()),
            format!("{}°, {} dB", wanted.phase_deg, wanted.gain_db),
            found,
            margins.is_some() && phase_deg >= wanted.phase_deg && gain_db >= wanted.gain_db,
        ));
    }
    let perturbed = &checked.perturbed;
    rows.extend(perturbed.modes.iter().map(|(mode, stable)| {
        row(
            format!(
                "stable holding {} with errors of up to {:.0} % in every derivative",
                mode.name(),
                100.0 * wanted.off
            ),
            format!("{0} of {0}", perturbed.of),
            format!("{stable} of {}", perturbed.of),
            *stable == perturbed.of,
        )
    }));
    rows.extend(checked.sampled.iter().map(|sampled| {
        row(
            "stable with vehicles drawn from the covariance of the model\u{2019}s parameters"
                .into(),
            format!("{0} of {0}", sampled.of),
            format!("{} of {}", sampled.stable, sampled.of),
            sampled.stable == sampled.of,
        )
    }));
    let peak = checked.responses.iter().flat_map(|own| own.stick_peaks()).fold(0.0, f64::max);
    rows.push(row(
        "largest stick deflection in a disturbance".into(),
        "at most 100 %".into(),
        format!("{:.0} %", 100.0 * peak),
        peak <= 1.0,
    ));
    let [at_end, at_start] = search.shortfall;
    Section::new(
        "wanted",
        "Requirements",
        format!(
            "The search optimises the weights for all requirements at once; it tried {} designs. Unmet requirements \
             were traded for the others. The sum of the shortfalls is {at_end:.2}; it was {at_start:.2} for the \
             initial weights. The search aims higher than required: the requirements are 45° and 6 dB, and 8, 1 and \
             2 s.",
            search.trials
        ),
    )
    .with(Table {
        caption: "Goals and results, in the linear loops".into(),
        heads: ["", "Goal", "Result", ""].map(Into::into).into(),
        rows,
    })
}

fn row(what: String, wanted: String, found: String, is_reached: bool) -> TableRow {
    let verdict = if is_reached { "reached" } else { "falls short" };
    TableRow::new(what, vec![wanted, found, verdict.into()])
}
