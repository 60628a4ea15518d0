//! The page of a campaign: outcomes of the flights, accuracy of the hover, and their causes.

use hovernav_sim::campaign::{
    Campaign, CampaignResult, HoverBounds, Measure, Outcome, PERCENTILES, SensorGrade, UNCERTAIN,
    count, failures, seeds_of,
};

use crate::{
    Axis, Fact, Figure, Level, Page, Role, Row, Section, Series, Table, TableRow, Verdict,
};

/// Largest number of crashes that are listed; results.csv contains all.
pub const LISTED: usize = 20;

const ROLES: [Role; 3] = [Role::First, Role::Second, Role::Third];

/// The page of a campaign.
pub struct CampaignPage<'a> {
    campaign: &'a Campaign,
    results: &'a [CampaignResult],
    headlines: [Fact; 3],
    facts: Vec<Fact>,
    warnings: Vec<String>,
}

impl<'a> CampaignPage<'a> {
    /// The page of the `results` of a `campaign`, with `warnings` about its settings.
    #[must_use]
    pub fn new(campaign: &'a Campaign, results: &'a [CampaignResult], warnings: &[String]) -> Self {
        let share = |outcome| 100.0 * count(results, outcome, None) as f64 / results.len() as f64;
        let headlines = [
            Fact::new("flights", format!("{} of {:.0} s", results.len(), campaign.duration_s)),
            Fact::new("hover at the end", format!("{:.2} %", share(Outcome::Hovered))),
            Fact::new("crashed", format!("{:.2} %", share(Outcome::Crashed))),
        ];
        let mut warnings = warnings.to_vec();
        if results.len() < 100 {
            warnings.push("fewer than 100 flights: the outer percentiles are unreliable".into());
        }
        Self { campaign, results, headlines, facts: facts(campaign, results), warnings }
    }

    /// The page itself.
    #[must_use]
    pub fn page(&self) -> Page<'_> {
        let Self { campaign, results, .. } = *self;
        Page {
            verdict: Some(verdict(campaign, results)),
            headlines: &self.headlines,
            warnings: &self.warnings,
            facts: &self.facts,
            table: Some(percentiles(results)),
            sections: [outcomes(results)]
                .into_iter()
                .chain(failed(results))
                .chain([distributions(results), causes(campaign, results)])
                .collect(),
            ..Page::titled("Campaign")
        }
    }
}

/// The settings of a campaign.
fn facts(campaign: &Campaign, results: &[CampaignResult]) -> Vec<Fact> {
    let identified = campaign.airframe.identified();
    let seeds = || results.iter().map(|result| result.draw.seed);
    let (first, last) = (seeds().min().unwrap_or_default(), seeds().max().unwrap_or_default());
    vec![
        Fact::new("seeds", format!("{first} to {last}")),
        Fact::new("evaluated", format!("from {:.0} s on", campaign.judged_from_s)),
        Fact::new("wind", format!("0 to {} m/s from any direction", campaign.max_wind_mps)),
        Fact::new(
            "gusts",
            format!(
                "{:.0} % of the wind, at least {} m/s",
                100.0 * campaign.gust_share,
                campaign.min_gust_mps
            ),
        ),
        Fact::new(
            "GPS outage",
            format!(
                "in {:.0} % of the flights, {} to {} s",
                100.0 * campaign.outage_share,
                campaign.outage_s.start,
                campaign.outage_s.end
            ),
        ),
        Fact::new(
            "engine and servos",
            format!(
                "the engine stops in {:.0} % of the flights, a servo jams in {:.0} %",
                100.0 * campaign.power_loss_share,
                100.0 * campaign.jam_share
            ),
        ),
        Fact::new(
            "fuel",
            format!(
                "a tank of {} kg, half of it in the nominal mass; the start amount is random, from the \
                 consumption of the flight to a full tank",
                campaign.fuel_kg
            ),
        ),
        Fact::new(
            "airframe drawn from",
            if identified.is_empty() {
                match &campaign.nominal.model {
                    None => {
                        format!("5 % in mass, 10 % in {}, one sigma", UNCERTAIN[1..].join(", "))
                    }
                    Some(_) => "10 % in every derivative, one sigma, or as --spread states".into(),
                }
            } else {
                format!("the identified covariance of {}", identified.join(", "))
            },
        ),
    ]
}

/// The number of flights that ended in a hover, and the criteria for a hover.
fn verdict(campaign: &Campaign, results: &[CampaignResult]) -> Verdict {
    let of = |outcome| count(results, outcome, None);
    let (crashed, hovered) = (of(Outcome::Crashed), of(Outcome::Hovered));
    let (level, words) = if crashed > 0 {
        (Level::Bad, format!("{crashed} of {} flights crashed.", results.len()))
    } else if hovered < results.len() {
        (
            Level::Care,
            format!("No flight crashed; {hovered} of {} hovered at the end.", results.len()),
        )
    } else {
        (Level::Good, "Every flight hovered at the end.".into())
    };
    let HoverBounds { lasts_s, speed_mps, tilt_rad, distance_m, turned_rad } = campaign.hover;
    let bounds = format!(
        "A flight counts as a hover if it ends in position mode. Its last {lasts_s:.0} s must stay below {speed_mps} m/s \
         and {:.0}° of tilt, within {distance_m:.0} m and {:.0}° of heading of the state at {:.0} s.",
        tilt_rad.to_degrees(),
        turned_rad.to_degrees(),
        campaign.judged_from_s
    );
    Verdict { level, words, reasons: vec![bounds] }
}

fn percentiles(results: &[CampaignResult]) -> Table {
    let row = |measure: &Measure| {
        TableRow::new(in_words(measure.name), measure.percentiles(results, None).map(number).into())
    };
    Table {
        caption: "Percentiles over all flights that lasted until the evaluation".into(),
        heads: [String::new()].into_iter().chain(PERCENTILES.map(|p| format!("{p} %"))).collect(),
        rows: Measure::ALL.iter().map(row).collect(),
    }
}

/// A number of a table; a dash where no flight has it.
fn number(value: f64) -> String {
    if value.is_finite() { format!("{value:.3}") } else { "–".into() }
}

/// A column name in words: `vn_error_rms_mps` becomes "north velocity, error, RMS, m/s".
fn in_words(column: &str) -> String {
    let mut words = Vec::new();
    for word in column.split('_') {
        words.push(match word {
            "u" => "velocity u",
            "v" => "velocity v",
            "w" => "velocity w",
            "vn" => "north velocity",
            "ve" => "east velocity",
            "vd" => "down velocity",
            "north" => "position north",
            "east" => "position east",
            "down" => "position down",
            "lateral" => "lateral stick",
            "longitudinal" => "longitudinal stick",
            "rms" => "RMS",
            "mps" => "m/s",
            "deg" => "°",
            other => other,
        });
    }
    words.join(", ")
}

fn outcomes(results: &[CampaignResult]) -> Section {
    let grades = SensorGrade::ALL;
    let row = |outcome: Outcome| {
        let mut numbers =
            grades.map(|grade| count(results, outcome, Some(grade)).to_string()).to_vec();
        numbers.push(count(results, outcome, None).to_string());
        TableRow::new(outcome.name().replace('_', " "), numbers)
    };
    let heads = [""].into_iter().chain(grades.map(SensorGrade::name)).chain(["all"]);
    Section::new(
        "outcomes",
        "Outcomes",
        "Outcomes by sensor grade: hovering at a position, flying in a mode without position hold, \
         never handed to the autopilot, crashed.",
    )
    .with(Table {
        caption: "Flights".into(),
        heads: heads.map(Into::into).collect(),
        rows: Outcome::ALL.into_iter().map(row).collect(),
    })
    .with(Table {
        caption: "Flights by failure; the worst counts where there are two".into(),
        heads: [String::new()]
            .into_iter()
            .chain(Outcome::ALL.map(|outcome| outcome.name().replace('_', " ")))
            .collect(),
        rows: (failures(results).into_iter())
            .map(|(failure, counts)| {
                TableRow::new(failure.name(), counts.map(|count| count.to_string()).to_vec())
            })
            .collect(),
    })
}

/// The first [`LISTED`] of `seeds`, and the number of the others.
#[must_use]
pub fn listed(seeds: &[u64]) -> String {
    let shown: Vec<String> = seeds.iter().take(LISTED).map(ToString::to_string).collect();
    match seeds.len().saturating_sub(LISTED) {
        0 => shown.join(", "),
        further => format!("{} and {further} more", shown.join(", ")),
    }
}

/// The crashed flights with their causes, and the seeds of all other failed flights; `None` without a failed flight.
fn failed(results: &[CampaignResult]) -> Option<Section> {
    results.iter().find(|one| one.outcome != Outcome::Hovered)?;
    let rows: Vec<TableRow> = results
        .iter()
        .filter_map(|own| Some(TableRow::new(own.draw.seed.to_string(), vec![own.cause()?])))
        .take(LISTED)
        .collect();
    let others = [Outcome::Degraded, Outcome::NotEngaged].map(|outcome| {
        let seeds = seeds_of(results, outcome);
        let name = outcome.name().replace('_', " ");
        (!seeds.is_empty()).then(|| TableRow::new(name, vec![listed(&seeds)]))
    });
    let others: Vec<TableRow> = others.into_iter().flatten().collect();
    let explanation = "Flights that did not hover at the end: crashes with the last event before each, and the seeds of \
                       the others. Seed by seed in results.csv. The command of this campaign with --record SEED flies \
                       one again, with record and page.";
    let crashes = Table {
        caption: format!("The first {LISTED} crashes"),
        heads: ["Seed", "Crash"].map(Into::into).into(),
        rows,
    };
    let others = Table {
        caption: "Others that failed".into(),
        heads: ["", "Seeds"].map(Into::into).into(),
        rows: others,
    };
    let tables = [crashes, others].into_iter().filter(|table| !table.rows.is_empty());
    Some(tables.fold(Section::new("crashes", "Failed flights", explanation), Section::with))
}

fn distributions(results: &[CampaignResult]) -> Section {
    let section = Section::new(
        "distributions",
        "Distributions",
        "Share of the flights below a value, by sensor grade. A curve further to the left is \
         better.",
    );
    let shown = [
        ("Velocity u", "m/s", "u_rms_mps"),
        ("Velocity v", "m/s", "v_rms_mps"),
        ("Velocity w", "m/s", "w_rms_mps"),
        ("Roll", "°", "roll_rms_deg"),
        ("Position north", "m", "north_rms_m"),
        ("Position down", "m", "down_rms_m"),
        ("Error of velocity north", "m/s", "vn_error_rms_mps"),
        ("Error of roll", "°", "roll_error_rms_deg"),
    ];
    let figure = |(quantity, unit, name): (&str, &'static str, &str)| {
        let measure = Measure::ALL.iter().find(|measure| measure.name == name)?;
        let mut row = Row { limits: Some([0.0, 100.0]), ..Row::new("Flights", "%") };
        for (role, grade) in ROLES.into_iter().zip(SensorGrade::ALL) {
            let mut values = measure.values(results, Some(grade));
            values.sort_by(f64::total_cmp);
            let last = values.len().max(2) - 1;
            let share = (0..values.len()).map(|rank| 100.0 * rank as f64 / last as f64);
            let step = (values.len() / 500).max(1);
            let points = values.iter().copied().zip(share).step_by(step);
            row = row.with(Series::curve(role, points).named(grade.name()));
        }
        let all = measure.percentiles(results, None);
        let axis = Axis::linear(&format!("{quantity}, RMS"), unit).within([0.0, 1.3 * all[5]]);
        Some(Figure::against(axis, [row]).captioned(format!("{quantity}, RMS")))
    };
    shown.into_iter().filter_map(figure).fold(section, Section::with)
}

fn causes(campaign: &Campaign, results: &[CampaignResult]) -> Section {
    let speed = |result: &CampaignResult| result.draw.wind_mps[0].hypot(result.draw.wind_mps[1]);
    let length = |result: &CampaignResult| {
        result.draw.outage_s.as_ref().map(|outage| outage.end - outage.start)
    };
    let against = |axis: Axis, x: &dyn Fn(&CampaignResult) -> Option<f64>, caption: &str| {
        let mut row = Row::new("Farthest", "m");
        let roles = [Role::Innovation, Role::Gps, Role::Pole];
        for (role, grade) in roles.into_iter().zip(SensorGrade::ALL) {
            let own = results.iter().filter(|r| r.draw.grade == grade && r.hover.is_some());
            let points = own.filter_map(|r| Some((x(r)?, r.distance_worst_m)));
            row = row.with(Series::points(role, points).named(grade.name()));
        }
        Figure::against(axis, [row]).captioned(caption)
    };
    let mass = results.iter().filter_map(|result| {
        let held = result.hover.as_ref()?;
        let fuel_kg = result.draw.fuel_kg - 0.5 * campaign.fuel_kg;
        let factor = result.draw.drawn.first()?;
        let of_nominal = factor + fuel_kg / campaign.nominal.helicopter.mass_kg;
        Some((of_nominal, 100.0 * held.sticks_mean[2]))
    });
    let by_mass = Row::new("Collective", "%")
        .with(Series::points(Role::Gps, mass).named("mean relative to the rigged trim"));
    let by_mass = Figure::against(
        Axis::linear("Mass at the start, relative to the assumed mass", ""),
        [by_mass],
    )
    .captioned("Collective that compensates the error of mass");
    let calm = |result: &CampaignResult| result.draw.outage_s.is_none().then(|| speed(result));
    let section = Section::new(
        "causes",
        "Causes",
        "Largest distance of each flight from its position at the start of the evaluation, and its mean \
         collective. One dot per flight.",
    )
    .with(against(Axis::linear("Wind", "m/s"), &calm, "By wind, flights without GPS outage"))
    .with(against(Axis::linear("GPS outage", "s"), &length, "By the length of the GPS outage"));
    // A linear model has no mass.
    if campaign.nominal.model.is_some() { section } else { section.with(by_mass) }
}
