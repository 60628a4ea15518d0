//! The page of a simulated flight: the estimate against the truth, and what the loop did.

use std::path::Path;

use hovernav::ekf::Notice;
use hovernav::time::Time;
use hovernav_log::{Dataset, Outage, Reference, Run, Score};
use hovernav_sim::{Flight, FlightConfig, FlightSample};

use super::hover::Flown;
use crate::report::page::{Section, Table, TableRow};
use crate::report::series::{Figure, Role, Row, Series};
use crate::report::{self, Fact, Report};
use crate::summary::Summary;

pub struct Shown<'a> {
    pub config: &'a FlightConfig,
    pub flight: &'a Flight,
    pub flown: &'a Flown,
    pub dataset: &'a Dataset,
    pub run: &'a Run,
    pub reference: Option<&'a Reference>,
    pub score: Option<&'a Score>,
    pub summary: &'a Summary,
}

pub fn write(path: &Path, shown: &Shown<'_>) -> anyhow::Result<()> {
    let solutions = &shown.run.solutions;
    let innovations: Vec<_> = shown
        .run
        .notices
        .iter()
        .filter_map(|notice| match notice {
            Notice::Updated(report) => Some(report),
            _ => None,
        })
        .flat_map(|report| report.innovations().copied())
        .collect();
    let reference: Vec<_> = shown.reference.map_or_else(Vec::new, |reference| {
        solutions.iter().map(|solution| (solution.time, reference.at(solution.time))).collect()
    });
    let outages: Vec<Outage> = (shown.config.gps.outages_s.iter())
        .map(|span| Outage { start: Time::ZERO + span.start, duration_s: span.end - span.start })
        .collect();
    let mut headlines = vec![Fact::new("held", shown.flown.in_words())];
    headlines.extend(shown.summary.headlines());
    let (facts, warnings) = (shown.summary.facts(), &shown.summary.warnings);
    let report = Report {
        title: "Simulated hover in closed loop",
        headlines: &headlines,
        facts: &facts,
        warnings,
        outages: &outages,
        solutions,
        fixes: &shown.dataset.fixes,
        innovations: &innovations,
        reference: &reference,
        score: shown.score,
        ..Report::default()
    };
    let mut page = report::flight::page(&report);
    let own = [rates(shown.flight), controls(shown.flight), wind(shown.flight), modes(shown.flown)];
    // After map, position, velocity, body velocity and attitude.
    page.sections.splice(5..5, own);
    page.write(path)
}

fn line(flight: &Flight, role: Role, value: impl Fn(&FlightSample) -> f64) -> Series {
    let time: Vec<f64> = flight.samples.iter().map(|m| m.truth.time.seconds()).collect();
    let values: Vec<f64> = flight.samples.iter().map(value).collect();
    Series::line(role, &time, &values, None)
}

fn rates(flight: &Flight) -> Section {
    let rows =
        ["Roll rate", "Pitch rate", "Yaw rate"].into_iter().enumerate().map(|(axis, name)| {
            let known = |sample: &FlightSample| {
                sample.solution.map_or(f64::NAN, |solution| {
                    solution.angular_rate_radps.to_array()[axis].to_degrees()
                })
            };
            let truth = |m: &FlightSample| m.truth.angular_rate_radps.to_array()[axis].to_degrees();
            Row::new(name, "°/s").with(line(flight, Role::Reference, truth)).with(line(
                flight,
                Role::Estimate,
                known,
            ))
        });
    Section::new(
        "rates",
        "Rates",
        "Body rates p, q, r as they were, and as the filter gave them to the autopilot.",
    )
    .with(Figure::against_time(rows))
}

fn controls(flight: &Flight) -> Section {
    let names = ["Lateral", "Longitudinal", "Collective", "Pedal"];
    let rows = names.into_iter().enumerate().map(|(stick, name)| {
        let command = |m: &FlightSample| 100.0 * m.sticks.to_array()[stick];
        let servo = |m: &FlightSample| 100.0 * m.servos.to_array()[stick];
        Row::new(name, "%")
            .with(line(flight, Role::Input, command).named("command"))
            .with(line(flight, Role::Second, servo).named("servo"))
    });
    Section::new(
        "controls",
        "Control activity",
        "What the autopilot, and before it the pilot, commands, and where the servos stand, percent \
         of full travel about trim.",
    )
    .with(Figure::against_time(rows))
}

fn wind(flight: &Flight) -> Section {
    let names = ["Wind north", "Wind east", "Wind down"];
    let rows = names.into_iter().enumerate().map(|(axis, name)| {
        Row::new(name, "m/s")
            .with(line(flight, Role::First, |m| m.wind_mps.to_array()[axis]).named("wind"))
    });
    let told = "Steady wind and Dryden gusts, as they act on the airframe; where the air goes to.";
    Section::new("wind", "Wind", told).with(Figure::against_time(rows))
}

fn modes(flown: &Flown) -> Section {
    let rows = flown.transitions().iter().map(|change| TableRow {
        name: format!("{:.2} s", change.time_s),
        numbers: vec![change.from.clone(), change.to.clone(), change.reason.clone()],
    });
    Section::new("modes", "Modes", "What the autopilot was doing, and why it changed.").with(
        Table {
            caption: "Changes of mode".into(),
            heads: ["", "From", "To", "Because of"].map(Into::into).into(),
            rows: rows.collect(),
        },
    )
}
