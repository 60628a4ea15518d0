//! The page of a design: margins, disturbances, poles, root locus, frequency responses.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use hovernav_design::hover::{Search, Wanted};
use hovernav_design::{
    ChannelMargins, CheckedDesign, Crossing, DisturbanceResponse, Margins, root_locus,
};
use hovernav_model::hover::unit_of;

use super::gusts::in_gusts;
use super::handling::handling;
use super::loops::{frequency_responses, nichols};
use super::robustness::{forward_flight, robustness};
use super::wanted::wanted;
use super::words::{findings, of_lag, of_notch};
use hovernav_pages::{
    Axis, Fact, Figure, Level, Page, Role, Row, Section, Series, Table, TableRow, TimeAxis, Verdict,
};

pub fn write(
    checked: &CheckedDesign,
    search: Option<&(Search, Wanted)>,
    path: &Path,
) -> anyhow::Result<()> {
    let rate_hz = 1.0 / checked.design.period_s;
    let slowest = checked.responses.iter().map(|r| r.recovered_s(0.05).unwrap_or(f64::INFINITY));
    let in_modes = checked.modes.iter().filter_map(|(_, margins)| margins.as_ref());
    let headlines = [
        Fact::new("weakest margins in any mode", weakest(in_modes)),
        Fact::new("slowest disturbance", format!("{:.1} s", slowest.fold(0.0, f64::max))),
        Fact::new("spectral radius", format!("{:.4}", checked.spectral_radius)),
        Fact::new(
            "derivatives with errors of 20 %",
            format!(
                "{} of {} stable in every mode",
                checked.perturbed.in_every_mode, checked.perturbed.of
            ),
        ),
    ];
    let [lowest, highest] = checked.margins.disk_gain();
    let mut facts = vec![
        Fact::new("model", checked.model.name()),
        Fact::new("source", checked.model.source()),
        Fact::new("loop", format!("{rate_hz:.1} Hz, one sample of delay")),
        Fact::new(
            "servos",
            format!(
                "{:.1} ms, tail {:.1} ms",
                1e3 * checked.design.servo_s,
                1e3 * checked.design.tail_servo_s
            ),
        ),
        Fact::new(
            "disk margin, all actuators at once",
            format!(
                "gain {lowest:.2} to {highest:.2}, phase {:.0}°",
                checked.margins.disk_phase_rad().to_degrees()
            ),
        ),
        Fact::new(
            "largest sensitivity",
            format!(
                "{:.2} at {:.2} rad/s",
                checked.margins.sensitivity.value, checked.margins.sensitivity.frequency_radps
            ),
        ),
    ];
    facts.extend(checked.modes.iter().map(|(mode, margins)| {
        let found = margins.as_ref().map_or_else(|| "unstable".into(), |found| weakest([found]));
        Fact::new(&format!("weakest margins holding {}", mode.name()), found)
    }));
    facts.push(Fact::new("lag of the estimator", of_lag(checked)));
    facts.extend(checked.notch.iter().map(|notch| Fact::new("notch", of_notch(notch))));
    facts.extend(checked.at_outputs.iter().map(|margins| {
        let found = weakest([margins]);
        Fact::new("weakest margins at a single output, holding velocity", found)
    }));
    let mut sections: Vec<Section> =
        search.iter().map(|(search, asked)| wanted(checked, search, asked)).collect();
    sections.extend(robustness(checked));
    sections.extend(forward_flight(checked));
    sections.extend([
        disturbances(checked),
        in_gusts(checked),
        handling(checked),
        closed_loop(checked).folded("One figure per disturbance"),
        open_loop(checked).folded("One figure per disturbance"),
    ]);
    if let Some(printed) = &checked.printed {
        let section = Section::new(
            "printed",
            "The design as printed",
            "The continuous gains of the thesis on its continuous model, as in its simulations, and their \
             behaviour in a sampled loop.",
        );
        let section = section.with(findings(printed, rate_hz)?);
        let section = with_responses(section, &printed.responses, true);
        sections.push(section.folded("Findings, and one figure per disturbance"));
    }
    sections.extend([frequency_responses(checked)?, nichols(checked)?]);
    sections.extend([poles(checked)?, loci(checked)?]);
    let page = Page {
        verdict: Some(verdict(checked)),
        title: &format!("Autopilot for {}", checked.model.name()),
        headlines: &headlines,
        warnings: &checked.warnings,
        facts: &facts,
        table: Some(margins(checked)),
        sections,
        time: Some(TimeAxis {
            label: "Time after the disturbance, s".into(),
            span: [0.0, 12.0],
            outages: Vec::new(),
            marks: Vec::new(),
        }),
    };
    Ok(page.write(path)?)
}

/// The smallest gain margin and phase margin of all loops of `modes`.
fn weakest<'a>(modes: impl IntoIterator<Item = &'a Margins>) -> String {
    let channels = modes.into_iter().flat_map(|margins| &margins.channels);
    let (gain_db, phase_deg) =
        channels.fold((f64::INFINITY, f64::INFINITY), |(gain, phase), own| {
            (f64::min(gain, own.smallest_gain_db()), f64::min(phase, own.phase_deg()))
        });
    format!("{gain_db:.1} dB, {phase_deg:.0}°")
}

/// The verdict of the design, as good as its weakest flight mode.
fn verdict(checked: &CheckedDesign) -> Verdict {
    let unstable = checked.spectral_radius >= 1.0
        || checked.modes.iter().any(|(_, margins)| margins.is_none());
    let (level, words) = if unstable {
        (Level::Bad, "Do not fly: a mode is unstable.")
    } else if checked.model.unflyable().is_some() {
        (Level::Bad, "Do not fly: the design is based on a model that must not be flown.")
    } else if !checked.warnings.is_empty() {
        (Level::Care, "Usable with care: it does not meet all requirements.")
    } else {
        (Level::Good, "Good: every mode has the required margins.")
    };
    Verdict {
        level,
        words: words.into(),
        reasons: checked.warnings.iter().take(3).cloned().collect(),
    }
}

fn margins(checked: &CheckedDesign) -> Table {
    let db = |crossing: &Option<Crossing>| match crossing {
        Some(crossing) => format!("{:.1}", crossing.margin_db()),
        None => "any".into(),
    };
    let row = |channel: &ChannelMargins| {
        TableRow::new(
            channel.name.clone(),
            vec![
                db(&channel.gain_up),
                db(&channel.gain_down),
                channel.phase.map_or("any".into(), |p| format!("{:.1}", p.margin.to_degrees())),
                channel.phase.map_or("-".into(), |p| format!("{:.2}", p.frequency_radps)),
                channel.delay_s.map_or("any".into(), |s| format!("{:.0}", 1e3 * s)),
                channel
                    .disturbance_rejection_bandwidth_radps
                    .map_or("-".into(), |bandwidth| format!("{bandwidth:.2}")),
            ],
        )
    };
    let heads = ["", "Gain up, dB", "down, dB", "Phase, °", "Crossover, rad/s", "Delay, ms"];
    Table {
        caption:
            "Margins when holding velocity, each loop broken at its actuator, with the other loops closed. Rejection: \
                  the frequency, rad/s, up to which disturbances there are halved in power"
                .into(),
        heads: heads.into_iter().chain(["Rejection"]).map(Into::into).collect(),
        rows: checked.margins.channels.iter().map(row).collect(),
    }
}

/// Degrees per radian.
const DEGREES: f64 = 180.0 / PI;

/// The name and size of a disturbance, with its unit, as in table 6.1 of the thesis.
fn titled(response: &DisturbanceResponse) -> String {
    let unit = unit_of(&response.state);
    format!("{}\u{a0}{}\u{a0}{unit}", response.state, response.size)
}

fn disturbances(checked: &CheckedDesign) -> Section {
    let seconds = |s: Option<f64>| s.map_or_else(|| "never".into(), |s| format!("{s:.2}"));
    let row = |(at, response): (usize, &DisturbanceResponse)| {
        let away = &checked.open_responses[at];
        let mut numbers = vec![
            seconds(away.settled_s()),
            seconds(response.recovered_s(0.05)),
            seconds(response.recovered_s(0.02)),
            seconds(response.settled_s()),
            seconds(checked.limited[at].recovered_s(0.05)),
        ];
        numbers.extend(response.stick_peaks().map(|peak| format!("{:.1}", 100.0 * peak)));
        if let Some(printed) = &checked.printed {
            numbers.push(seconds(printed.responses[at].settled_s()));
        }
        TableRow::new(titled(response), numbers)
    };
    let mut heads = vec![
        "",
        "Open loop, s",
        "To 5 %, s",
        "To 2 %, s",
        "All at trim, s",
        "With stops, s",
        "Lateral, %",
        "Longitudinal, %",
        "Collective, %",
        "Pedal, %",
    ];
    if checked.printed.is_some() {
        heads.push("As printed, s");
    }
    Section::new(
        "disturbances",
        "Disturbances",
        format!(
            "The nine disturbances of Paw (2005), table 6.1, one at a time, simulated for {:.0} s in the \
             linear loop. \"To 5 %\" and \"To 2 %\" are the times until the disturbed state is back within that \
             share of its size. \"All at trim\" is the time until the whole vehicle is back at trim. The stick \
             columns list the largest deflection, in percent of the travel on one side. \"With stops\" is the time \
             to 5 % with the flight regulators; each stick is then limited to ±100 % about trim and to four times \
             that per second.",
            CheckedDesign::FOLLOWED_S
        ),
    )
    .with(Table {
        caption: "Return to trim and control activity".into(),
        heads: heads.into_iter().map(Into::into).collect(),
        rows: checked.responses.iter().enumerate().map(row).collect(),
    })
}

fn open_loop(checked: &CheckedDesign) -> Section {
    let section = Section::new(
        "open-loop",
        "Open loop",
        "Each disturbance with all sticks at trim (appendix A of the thesis). A curve that leaves the chart \
         is not continued.",
    );
    with_responses(section, &checked.open_responses, false)
}

fn closed_loop(checked: &CheckedDesign) -> Section {
    let section = Section::new(
        "closed-loop",
        "Closed loop",
        "The same disturbances with the autopilot (appendix B), at the sample times of the loop: model, servos, \
         one sample of delay. Sticks are in percent of full travel about trim, with the position and rate limits \
         of flight.",
    );
    with_responses(section, &checked.limited, true)
}

/// Names of the lines of each colour; a name lists its line in each row, from top to bottom.
const NAMES: [&str; 4] =
    ["p, roll, u, lateral", "q, pitch, v, longitudinal", "r, heading, w, collective", "pedal"];
/// Colours of the lines, in the order of [`NAMES`].
const ROLES: [Role; 4] = [Role::First, Role::Second, Role::Third, Role::Fourth];

fn with_responses(
    section: Section,
    responses: &[DisturbanceResponse],
    with_sticks: bool,
) -> Section {
    let figure = |response: &DisturbanceResponse| {
        let time = &response.time_s;
        // A line that has left the chart is not continued.
        let state = |row: usize, scale: f64, most: f64| -> Vec<f64> {
            let mut has_left = false;
            let values = response.states.iter().map(|states| scale * states[row]);
            values
                .map(|value| {
                    let shown = if has_left { f64::NAN } else { value.clamp(-most, most) };
                    has_left |= value.abs() >= most;
                    shown
                })
                .collect()
        };
        let rows = [
            ("Rate", "°/s", 0, DEGREES, 400.0),
            ("Attitude", "°", 3, DEGREES, 90.0),
            ("Velocity", "m/s", 6, 1.0, 15.0),
        ];
        let mut rows: Vec<Row> = rows
            .into_iter()
            .map(|(quantity, unit, first, scale, most)| {
                let mut row = Row::new(quantity, unit);
                for (component, name) in NAMES.into_iter().take(3).enumerate() {
                    let values = state(first + component, scale, most);
                    let line = Series::line(ROLES[component], time, &values, None);
                    row = row.with(line.named(name));
                }
                Row { limits: Some([-most, most]), ..row }
            })
            .collect();
        if with_sticks {
            let mut row = Row { limits: Some([-130.0, 130.0]), ..Row::new("Sticks", "%") };
            let span = [0.0, time.last().copied().unwrap_or_default()];
            for stop in [-100.0, 100.0] {
                row = row.with(Series::curve(Role::Limit, span.map(|s| (s, stop))).named("stop"));
            }
            for (stick, name) in NAMES.into_iter().enumerate() {
                let values: Vec<f64> =
                    response.sticks.iter().map(|sticks| 100.0 * sticks[stick]).collect();
                row = row.with(Series::line(ROLES[stick], time, &values, None).named(name));
            }
            rows.push(row);
        }
        Figure::against_time(rows).captioned(titled(response))
    };
    responses.iter().map(figure).fold(section, Section::with)
}

/// The unit circle: a sampled loop is stable if all poles lie inside it.
fn unit_circle() -> Series {
    let points = (0..=180).map(|k| (f64::from(k) * TAU / 180.0).sin_cos());
    Series::curve(Role::Limit, points.map(|(sin, cos)| (cos, sin))).named("stable inside")
}

/// The z plane around the unit circle.
fn plane(rows: Row) -> Figure {
    let axis = Axis::plane("Real part", "").within([-1.7, 1.7]);
    Figure::against(axis, [Row { limits: Some([-1.15, 1.15]), ..rows }])
}

fn poles(checked: &CheckedDesign) -> anyhow::Result<Section> {
    let held = hovernav_design::zero_order_hold(&checked.model, checked.design.period_s, 0.0)?;
    let open: Vec<_> = held
        .modes()?
        .modes
        .into_iter()
        .map(|mode| (mode.eigenvalue.re, mode.eigenvalue.im))
        .collect();
    let closed: Vec<_> =
        checked.closed.closed_poles()?.into_iter().map(|pole| (pole.re, pole.im)).collect();
    let row = || {
        let open = Series::points(Role::AlternativePole, open.iter().copied());
        let closed = Series::points(Role::Pole, closed.iter().copied());
        Row::new("Imaginary part", "")
            .with(unit_circle())
            .with(open.named("model alone"))
            .with(closed.named("closed loop"))
    };
    let section = Section::new(
        "poles",
        "Poles",
        format!(
            "Poles of the model sampled at {:.1} Hz and of the closed loop, in the z plane. Poles inside the circle \
             are stable. Poles near 1 are slow; poles near 0 decay within a sample.",
            1.0 / checked.design.period_s
        ),
    );
    let near = Axis::plane("Real part", "").within([0.7, 1.02]);
    let near = Figure::against(near, [Row { limits: Some([-0.11, 0.11]), ..row() }]);
    Ok(section.with(plane(row())).with(near.captioned("Slow modes, near 1")))
}

fn loci(checked: &CheckedDesign) -> anyhow::Result<Section> {
    let mut section = Section::new(
        "root-locus",
        "Root locus",
        "Closed-loop poles as the gain of one loop grows from zero to four times its design value, with the \
         other loops closed as designed. Crosses mark the design gain. The gain margin ends where a branch leaves \
         the circle.",
    );
    let gains: Vec<f64> = (0..=160).map(|k| 4.0 * (f64::from(k) / 160.0).powi(2)).collect();
    for channel in &checked.margins.channels {
        let model = checked.closed.channel(&channel.name)?;
        let locus = root_locus(&model, &channel.name, 0, &gains)?;
        let mut row = Row::new("Imaginary part", "").with(unit_circle());
        let branches = locus.first().map_or(0, Vec::len);
        for branch in 0..branches {
            let points = locus.iter().map(|poles| (poles[branch].re, poles[branch].im));
            // A pole that does not move adds an invisible line.
            row = row.with(Series::curve(Role::Model, points).named("0 to 4 times the gain"));
        }
        let at = |gain: f64| gains.iter().position(|own| (own - gain).abs() < 1e-9);
        let mark = |row: Row, role, gain, name: &str| {
            let poles = at(gain).and_then(|at| locus.get(at)).into_iter().flatten();
            row.with(Series::points(role, poles.map(|pole| (pole.re, pole.im))).named(name))
        };
        let row = mark(row, Role::AlternativePole, 0.0, "loop open");
        let row = mark(row, Role::Pole, 1.0, "as designed");
        section = section.with(plane(row).captioned(channel.name.clone()));
    }
    Ok(section.folded("One figure per loop"))
}
