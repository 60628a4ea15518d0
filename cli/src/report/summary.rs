//! The result of a recorded flight, for `summary.json` and the terminal.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use hovernav_dataset::Dataset;
use hovernav_dataset::statistics::quantile;
use hovernav_record::{Cycle, Record, Reproduction, StickReproduction};
use hovernav_replay::FixTally;
use serde::Serialize;

use super::verdict::{self, Grounds};
use crate::output;
use hovernav_pages::{Fact, Verdict};

/// A span of time in one mode.
#[derive(Clone, Debug, Serialize)]
pub struct ModeSpan {
    pub mode: &'static str,
    pub start_s: f64,
    pub end_s: f64,
}

/// An event, for programs.
#[derive(Clone, Debug, Serialize)]
pub struct EventSummary {
    pub time_s: f64,
    pub level: &'static str,
    pub kind: String,
    /// The sensor or function that caused the event.
    pub part: String,
    pub text: String,
}

/// The result of a recorded flight.
#[derive(Serialize)]
pub struct RecordSummary {
    tool: &'static str,
    version: &'static str,
    input: PathBuf,
    pub verdict: Verdict,
    duration_s: f64,
    pub wall_s: f64,
    imu_samples: usize,
    gps_fixes_used: usize,
    gps_fixes_rejected: usize,
    gps_fixes: usize,
    pub is_ended: bool,
    /// Description of the repair and of the loss before it, if the record was repaired.
    repaired: Option<String>,
    pub replay: String,
    pub cycles: usize,
    autopilot_s: f64,
    engagements: usize,
    /// Computing time of a cycle, s.
    work_p50_s: Option<f64>,
    work_p99_s: Option<f64>,
    work_max_s: Option<f64>,
    /// Time from an inertial packet to the servos, s.
    turnaround_p50_s: Option<f64>,
    turnaround_p99_9_s: Option<f64>,
    turnaround_max_s: Option<f64>,
    pub modes: Vec<ModeSpan>,
    pub events: Vec<EventSummary>,
    pub warnings: Vec<String>,
}

impl RecordSummary {
    pub fn new(
        input: &Path,
        record: &Record,
        dataset: &Dataset,
        reproduction: Reproduction,
        sticks: Option<StickReproduction>,
        fixes: FixTally,
    ) -> Self {
        let modes = spans(record);
        let flown = || modes.iter().filter(|span| !["manual", "neutral"].contains(&span.mode));
        let mut work = values(record, |cycle| cycle.work_s);
        let mut turnaround = values(record, |cycle| cycle.turnaround_s);
        let events = record.events.iter().map(|event| EventSummary {
            time_s: event.time.seconds(),
            level: event.level.name(),
            kind: event.kind.clone(),
            part: event.part.clone(),
            text: event.text.clone(),
        });
        let replay = in_words(reproduction, sticks);
        // The sum of an empty iterator is −0.
        let autopilot_s = flown().map(|span| span.end_s - span.start_s).sum::<f64>() + 0.0;
        let engagements = modes
            .windows(2)
            .filter(|pair| pair[0].mode == "manual" && pair[1].mode != "manual")
            .count();
        let is_reproduced = reproduction.first_difference.is_none()
            && sticks.is_none_or(|sticks| sticks.first_difference.is_none());
        let grounds = Grounds { replay: &replay, is_reproduced, engagements, autopilot_s };
        Self {
            verdict: verdict::of_record(record, &grounds),
            tool: "hovernav",
            version: env!("CARGO_PKG_VERSION"),
            input: input.to_path_buf(),
            duration_s: record.end - record.header.start,
            wall_s: 0.0,
            imu_samples: dataset.imu.len(),
            gps_fixes_used: fixes.used,
            gps_fixes_rejected: fixes.rejected,
            gps_fixes: dataset.fixes.len(),
            is_ended: record.is_ended,
            repaired: record.repair.as_ref().map(ToString::to_string),
            replay,
            cycles: record.cycles.len(),
            autopilot_s,
            engagements,
            work_p50_s: quantile(&mut work, 0.5),
            work_p99_s: quantile(&mut work, 0.99),
            work_max_s: quantile(&mut work, 1.0),
            turnaround_p50_s: quantile(&mut turnaround, 0.5),
            turnaround_p99_9_s: quantile(&mut turnaround, 0.999),
            turnaround_max_s: quantile(&mut turnaround, 1.0),
            events: events.collect(),
            warnings: record.warnings.clone(),
            modes,
        }
    }

    pub fn facts(&self) -> Vec<Fact> {
        let ms = |seconds: Option<f64>| {
            seconds.map_or("–".into(), |seconds| format!("{:.2}", 1e3 * seconds))
        };
        let work = [self.work_p50_s, self.work_p99_s, self.work_max_s].map(ms);
        let turnaround =
            [self.turnaround_p50_s, self.turnaround_p99_9_s, self.turnaround_max_s].map(ms);
        let repaired = self.repaired.iter().map(|how| Fact::new("repaired", how));
        let facts = vec![
            Fact::new("input", self.input.display()),
            Fact::new("duration", format!("{:.1} s", self.duration_s)),
            Fact::new("inertial samples", self.imu_samples),
            Fact::new("fixes", self.gps_fixes),
            Fact::new(
                "flown by the autopilot",
                format!(
                    "{:.1} s in {} engagement{}",
                    self.autopilot_s,
                    self.engagements,
                    if self.engagements == 1 { "" } else { "s" }
                ),
            ),
            Fact::new(
                "computing time of a cycle, p50 / p99 / max",
                format!("{} ms", work.join(" / ")),
            ),
            Fact::new(
                "packet to servos, p50 / p99.9 / max",
                format!("{} ms", turnaround.join(" / ")),
            ),
            Fact::new("replay", &self.replay),
        ];
        facts.into_iter().chain(repaired).collect()
    }

    /// Writes the summary to standard output, and the warnings to standard error.
    pub fn say(&self, out: &Path) {
        let mut text = format!("{}\n", self.verdict.words);
        for reason in &self.verdict.reasons {
            let _ = writeln!(text, "  - {reason}");
        }
        for fact in self.facts() {
            let _ = writeln!(text, "{:<38} {}", fact.label, fact.value);
        }
        for event in self.events.iter().filter(|event| event.level != "info") {
            let _ = writeln!(text, "{:10.3}  {}: {}", event.time_s, event.level, event.text);
        }
        output::say_text(text);
        self.warnings.iter().for_each(output::warn);
        output::say(format_args!("{:<38} {} ({:.3} s)", "written", out.display(), self.wall_s));
    }
}

/// The values of `of` for all cycles that have one.
fn values(record: &Record, of: impl Fn(&Cycle) -> Option<f64>) -> Vec<f64> {
    record.cycles.iter().filter_map(|recorded| of(&recorded.cycle)).collect()
}

/// The spans of the modes, in order.
fn spans(record: &Record) -> Vec<ModeSpan> {
    let mut spans: Vec<ModeSpan> = Vec::new();
    for recorded in &record.cycles {
        let (mode, time_s) = (recorded.cycle.mode.name(), recorded.time.seconds());
        match spans.last_mut() {
            Some(span) if span.mode == mode => span.end_s = time_s,
            Some(span) => {
                span.end_s = time_s;
                spans.push(ModeSpan { mode, start_s: time_s, end_s: time_s });
            }
            None => spans.push(ModeSpan { mode, start_s: time_s, end_s: time_s }),
        }
    }
    spans
}

fn in_words(reproduction: Reproduction, sticks: Option<StickReproduction>) -> String {
    let solutions = match reproduction.first_difference {
        None => format!("{} solutions identical to the bit", reproduction.compared),
        Some(first) => format!("the solution first differs at {:.6} s", first.time.seconds()),
    };
    match sticks {
        None => solutions,
        Some(StickReproduction { compared, first_difference: None }) => {
            format!("{solutions}, and so are the sticks of {compared} cycles")
        }
        Some(StickReproduction { first_difference: Some(time), .. }) => {
            format!("{solutions}, a stick first differs at {:.6} s", time.seconds())
        }
    }
}
