//! The page of `hovernav bench`.

use std::path::Path;

use hovernav_bench::{Report, Timed};

use hovernav_pages::{
    Axis, Fact, Figure, Page, Role, Row, Section, Series, Table, TableRow, digits,
};

/// Writes the page.
pub fn write(report: &Report, path: &Path) -> anyhow::Result<()> {
    let machine = &report.machine;
    let facts = [
        Fact::new("processor", &machine.processor),
        Fact::new("processors", machine.processors),
        Fact::new("system", &machine.system),
        Fact::new("priority", &machine.priority),
        Fact::new("memory", &machine.memory),
        Fact::new("clock", format!("{} ns, subtracted", digits(report.clock_ns))),
        Fact::new("cycles", report.cycles),
        Fact::new("worst inputs", &report.worst.inputs),
    ];
    let headlines = [
        Fact::new("cycle, p99.9", rare_us(report.cycle.time.p99_9_ns)),
        Fact::new("longest cycle", format!("{:.1} µs", 1e-3 * report.cycle.time.max_ns)),
        Fact::new("of the period", format!("{:.3} %", 100.0 * report.share_of_period)),
        Fact::new("worst inputs", format!("{:.1} µs", 1e-3 * report.worst.time_ns)),
    ];
    let row = |timed: &Timed| {
        TableRow::new(
            format!("{}, {} states", timed.name, timed.states),
            [
                Some(timed.time.p50_ns),
                timed.time.p99_ns,
                timed.time.p99_9_ns,
                Some(timed.time.max_ns),
            ]
            .map(super::rare)
            .into_iter()
            .chain([timed.instructions.map_or_else(String::new, |count| count.to_string())])
            .collect(),
        )
    };
    let all = report.steps.iter().chain([&report.cycle]);
    let table = Table {
        caption: "Times, ns, and instructions".into(),
        heads: ["", "p50", "p99", "p99.9", "max", "instructions"].map(str::to_owned).into(),
        rows: all.map(row).collect(),
    };
    Page {
        title: "hovernav on this machine",
        headlines: &headlines,
        verdict: None,
        warnings: &[],
        facts: &facts,
        table: Some(table),
        sections: vec![
            section(
                "cycle",
                "The flight loop",
                "Cycles per million that took longer than a given time: decode, estimate, control, servos, telemetry, record.",
                [&report.cycle],
            ),
            section(
                "steps",
                "The filter's steps, 26 states",
                "Calls per million that took longer than a given time.",
                report.steps.iter().filter(|timed| {
                    timed.states == 26
                        && ["inertial step", "fix: position and velocity", "attitude"]
                            .contains(&timed.name)
                }),
            ),
        ],
        time: None,
    }
    .write(path)?;
    Ok(())
}

/// A high percentile of the time, µs, if there were enough calls.
fn rare_us(ns: Option<f64>) -> String {
    ns.map_or_else(|| "too few cycles".to_owned(), |ns| format!("{:.2} µs", 1e-3 * ns))
}

/// A section with the tails of time distributions.
fn section<'a>(
    anchor: &'static str,
    title: &'static str,
    explanation: &str,
    timed: impl IntoIterator<Item = &'a Timed>,
) -> Section {
    let roles = [Role::First, Role::Second, Role::Third];
    let curve = |(timed, role): (&Timed, Role)| {
        let points = timed.time.tail.iter().map(|&(ns, longer)| (1e-3 * ns, 1e6 * longer));
        Series::curve(role, points).named(timed.name)
    };
    let row = timed
        .into_iter()
        .zip(roles)
        .map(curve)
        // A label that fits one line next to numbers of six digits.
        .fold(Row { logarithmic: true, ..Row::new("per million", "") }, Row::with);
    Section::new(anchor, title, explanation)
        .with(Figure::against(Axis::logarithmic("time", "µs"), [row]))
}
