//! The page of a simulated flight: the estimate against the truth, and the behaviour of the loop.

use std::path::Path;

use hovernav::ekf::Innovation;
use hovernav::time::Time;
use hovernav_dataset::{Dataset, Outage, Reference};
use hovernav_replay::Run;
use hovernav_score::Score;
use hovernav_sim::{Flight, FlightConfig, FlightSample};

use super::summary::{ClosedLoopSummary, Summary};
use hovernav_pages::flight::{self, FlightData};
use hovernav_pages::{Fact, Figure, Role, Row, Section, Series, Table, TableRow};

/// The contents of the page of a simulated flight.
pub struct SimulationPage<'a> {
    pub config: &'a FlightConfig,
    pub flight: &'a Flight,
    pub dataset: &'a Dataset,
    pub run: &'a Run,
    pub innovations: &'a [Innovation],
    pub reference: Option<&'a Reference>,
    pub score: Option<&'a Score>,
    pub summary: &'a Summary,
}

impl SimulationPage<'_> {
    /// Writes the page to `path`.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let solutions = &self.run.solutions;
        let outages: Vec<Outage> = (self.config.gps.outages_s.iter())
            .map(|span| Outage {
                start: Time::ZERO + span.start,
                duration_s: span.end - span.start,
            })
            .collect();
        let mut headlines = vec![Fact::new("closed loop", self.summary.flight.in_words())];
        headlines.extend(flight::headlines(&self.summary.run));
        let (facts, warnings) = (flight::facts(&self.summary.run), &self.summary.run.warnings);
        let data = FlightData {
            title: "Simulated hover in closed loop",
            verdict: self.summary.run.verdict.as_ref(),
            headlines: &headlines,
            facts: &facts,
            warnings,
            outages: &outages,
            solutions,
            fixes: &self.dataset.fixes,
            innovations: self.innovations,
            reference: &flight::reference_moments(solutions, self.reference),
            score: self.score,
            log: Some(self.dataset),
            baro: &self.dataset.baro,
            notices: &self.run.notices,
            findings: &self.summary.run.findings,
            ..FlightData::default()
        };
        let mut page = flight::page(&data);
        let own = [
            rates(self.flight),
            controls(self.flight),
            wind(self.flight),
            modes(&self.summary.flight),
        ];
        // Insert after map, position, velocity, body velocity and attitude.
        page.sections.splice(5..5, own);
        Ok(page.write(path)?)
    }
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
        "True body rates p, q, r, and the filter's estimates that the autopilot received.",
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
        "Commands of the pilot and then of the autopilot, and positions of the servos, in percent \
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
    let explanation = "Steady wind and Dryden gusts acting on the airframe, positive in the direction of the air's motion.";
    Section::new("wind", "Wind", explanation).with(Figure::against_time(rows))
}

fn modes(flight: &ClosedLoopSummary) -> Section {
    let rows = flight.transitions().iter().map(|change| {
        TableRow::new(
            format!("{:.2} s", change.time_s),
            vec![change.from.clone(), change.to.clone(), change.reason.clone()],
        )
    });
    Section::new("modes", "Modes", "Modes of the autopilot, and the reason for each change.").with(
        Table {
            caption: "Changes of mode".into(),
            heads: ["", "From", "To", "Reason"].map(Into::into).into(),
            rows: rows.collect(),
        },
    )
}
