//! Goals of a campaign, and the runs that meet them.

use std::fmt::Write as _;

use serde::Serialize;

use super::campaign::Outcome;
use super::catalogue::Kind;

/// Figure of one run, and whether the figure meets the goal.
type Judged = Option<(f64, bool)>;

/// A goal for every run that it applies to.
struct Goal {
    name: &'static str,
    judge: fn(&Outcome) -> Judged,
    /// Whether the largest figure is the worst.
    largest_is_worst: bool,
}

/// Number of runs that met a goal.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// The goal.
    pub goal: &'static str,
    /// Number of runs to which the goal applies.
    pub runs: usize,
    /// Number of runs that met the goal.
    pub met: usize,
    /// Worst figure.
    pub worst: f64,
    /// Run with the worst figure.
    pub worst_run: String,
}

fn below(value: f64, limit: f64) -> Judged {
    (!value.is_nan()).then_some((value, value <= limit))
}

fn above(value: f64, limit: f64) -> Judged {
    (!value.is_nan()).then_some((value, value >= limit))
}

fn has(outcome: &Outcome, kinds: &[Kind]) -> bool {
    outcome.kinds.iter().any(|kind| kinds.contains(kind))
}

/// Whether the solution has to be correct: a wrong set-up only has to be named or rejected.
fn is_sound(outcome: &Outcome) -> bool {
    !outcome.kinds.iter().any(|kind| kind.is_wrong_setup())
}

const GOALS: [Goal; 12] = [
    Goal {
        name: "finite and without panic",
        judge: |run| below(f64::from(u8::from(run.measures.nan || run.measures.panicked)), 0.0),
        largest_is_worst: true,
    },
    Goal {
        name: "not diverged",
        judge: |run| {
            let lost = f64::from(u8::from(run.measures.diverged));
            below(lost, 0.0).filter(|_| is_sound(run))
        },
        largest_is_worst: true,
    },
    Goal {
        name: "velocity and attitude inside 3 sigma, 97 % of all samples",
        judge: |run| above(100.0 * run.measures.inside_motion, 97.0).filter(|_| is_sound(run)),
        largest_is_worst: false,
    },
    Goal {
        name: "without fault: error over sigma from 0.8 to 1.3",
        judge: |run| {
            let figure = run.measures.normalised_motion;
            let known = run.kinds.is_empty() && !figure.is_nan();
            known.then_some((figure, (0.8..=1.3).contains(&figure)))
        },
        largest_is_worst: true,
    },
    Goal {
        name: "velocity back inside 3 sigma within 3 s of an outage's or gap's end",
        judge: |run| {
            let kinds = [Kind::Outage, Kind::Gap];
            below(run.measures.back_after_s, 3.0).filter(|_| has(run, &kinds))
        },
        largest_is_worst: true,
    },
    Goal {
        name: "clipping bursts change the velocity by at most 0.3 m/s",
        judge: |run| below(run.measures.pulled_mps, 0.3).filter(|_| has(run, &[Kind::ClipBurst])),
        largest_is_worst: true,
    },
    Goal {
        name: "GPS time wrong by 0.15 s costs at most 15 %",
        judge: |run| below(run.measures.cost[0], 1.15).filter(|_| has(run, &[Kind::GpsTime])),
        largest_is_worst: true,
    },
    Goal {
        name: "a step glitch changes the position by at most 3 m",
        judge: |run| below(run.measures.pulled_m, 3.0).filter(|_| has(run, &[Kind::GlitchStep])),
        largest_is_worst: true,
    },
    Goal {
        name: "30° of magnetic disturbance turn the yaw by at most 6°",
        judge: |run| {
            let kinds = [Kind::MagHeading, Kind::MagHeadingOnly];
            below(run.measures.pulled_yaw_deg, 6.0).filter(|_| has(run, &kinds))
        },
        largest_is_worst: true,
    },
    Goal {
        name: "vibration costs at most 50 %",
        judge: |run| below(run.measures.cost[0], 1.5).filter(|_| has(run, &[Kind::Vibration])),
        largest_is_worst: true,
    },
    Goal {
        name: "a fault that costs more than 20 % is named",
        judge: |run| {
            let cost = run.measures.largest_cost();
            let unnamed = if run.measures.named { 0.0 } else { cost };
            below(unnamed, 1.2).filter(|_| !run.kinds.is_empty() && cost > 1.2)
        },
        largest_is_worst: true,
    },
    Goal {
        name: "no warning without a fault",
        judge: |run| {
            below(run.measures.warnings.len() as f64, 0.0).filter(|_| run.kinds.is_empty())
        },
        largest_is_worst: true,
    },
];

/// Number of runs that met each goal.
#[must_use]
pub fn verdicts(outcomes: &[Outcome]) -> Vec<Verdict> {
    let verdict = |goal: &Goal| {
        let judged = outcomes.iter().filter_map(|run| Some((run, (goal.judge)(run)?)));
        let judged: Vec<(&Outcome, (f64, bool))> = judged.collect();
        let by_figure = |a: &&(&Outcome, (f64, bool)), b: &&(&Outcome, (f64, bool))| {
            let order = a.1.0.total_cmp(&b.1.0);
            if goal.largest_is_worst { order } else { order.reverse() }
        };
        let worst = judged.iter().max_by(by_figure);
        Verdict {
            goal: goal.name,
            runs: judged.len(),
            met: judged.iter().filter(|(_, (_, met))| *met).count(),
            worst: worst.map_or(f64::NAN, |(_, (figure, _))| *figure),
            worst_run: worst.map_or_else(String::new, |(run, _)| {
                format!("{} {} seed {}", run.flight, run.faults, run.seed)
            }),
        }
    };
    GOALS.iter().map(verdict).filter(|verdict| verdict.runs > 0).collect()
}

/// The goals as a table in Markdown.
#[must_use]
pub fn goals_markdown(outcomes: &[Outcome]) -> String {
    let mut text = String::from("| goal | runs | met | worst | in |\n|---|---|---|---|---|\n");
    for Verdict { goal, runs, met, worst, worst_run } in verdicts(outcomes) {
        let worst_run = if met == runs { String::new() } else { worst_run };
        let _ = writeln!(text, "| {goal} | {runs} | {met} | {worst:.2} | {worst_run} |");
    }
    text
}
