//! The page of a fleet of many logs: the worst logs first, then counts by finding and by vehicle.

use std::collections::BTreeMap;

use crate::{Fact, Level, Page, Section, Table, TableRow, Verdict};

/// Largest number of logs in the list of the worst logs, and in the list of unreadable logs.
const LISTED: usize = 200;

/// One log of a fleet.
#[derive(Clone, Debug, PartialEq)]
pub struct FleetLog {
    /// The log, as the user named it.
    pub path: String,
    /// The vehicle, in the words of the log; empty if unknown.
    pub vehicle: String,
    /// Duration, s.
    pub duration_s: f64,
    /// The verdict on the solution; `None` without one.
    pub level: Option<Level>,
    /// Kinds of its warnings, each once.
    pub kinds: Vec<String>,
    /// The main reason against the log, or the reason for a missing solution; empty for a good log.
    pub reason: String,
}

/// Numbers of logs by verdict.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    levels: [usize; Level::ALL.len()],
    without: usize,
    duration_s: f64,
}

impl Counts {
    fn add(&mut self, log: &FleetLog) {
        let counted = log.level.and_then(|level| self.levels.get_mut(level as usize));
        *counted.unwrap_or(&mut self.without) += 1;
        if log.duration_s.is_finite() {
            self.duration_s += log.duration_s;
        }
    }

    fn logs(&self) -> usize {
        self.levels.iter().sum::<usize>() + self.without
    }

    fn cells(&self) -> Vec<String> {
        let hours = format!("{:.1}", self.duration_s / 3600.0);
        let counts = [self.logs()].into_iter().chain(self.levels).chain([self.without]);
        counts.map(|count| count.to_string()).chain([hours]).collect()
    }
}

/// The heads of [`Counts::cells`].
const COUNTED: [&str; 7] = ["", "Logs", "Good", "With care", "Bad", "No solution", "Hours"];

/// The logs of a fleet, one after another. The memory does not grow with their number.
#[derive(Clone, Debug, Default)]
pub struct Fleet {
    all: Counts,
    by_vehicle: BTreeMap<String, Counts>,
    by_kind: BTreeMap<String, usize>,
    worst: Vec<FleetLog>,
    without: Vec<FleetLog>,
}

/// Number of vehicles with their own row; all other vehicles have one common row.
const VEHICLES: usize = 500;
/// The row of the vehicles beyond [`VEHICLES`].
const OTHERS: &str = "other vehicles";

impl Fleet {
    /// Adds a log.
    pub fn push(&mut self, log: FleetLog) {
        self.all.add(&log);
        let vehicle = match log.vehicle.as_str() {
            "" => "unknown",
            known if self.by_vehicle.len() < VEHICLES || self.by_vehicle.contains_key(known) => {
                known
            }
            _ => OTHERS,
        };
        self.by_vehicle.entry(vehicle.to_owned()).or_default().add(&log);
        for kind in &log.kinds {
            *self.by_kind.entry(kind.clone()).or_default() += 1;
        }
        match log.level {
            None if self.without.len() < LISTED => self.without.push(log),
            Some(level) if level > Level::Good => self.list(log),
            _ => {}
        }
    }

    /// Adds a log to the list of the worst, if it belongs there: by verdict, then by the number of kinds of warnings.
    fn list(&mut self, log: FleetLog) {
        let rank = |log: &FleetLog| (log.level, log.kinds.len());
        let place = self.worst.partition_point(|other| rank(other) >= rank(&log));
        if place < LISTED {
            self.worst.insert(place, log);
            self.worst.truncate(LISTED);
        }
    }

    /// The numbers of logs: good, with care, bad, without a solution.
    #[must_use]
    pub fn counts(&self) -> [usize; 4] {
        let [good, care, bad] = self.all.levels;
        [good, care, bad, self.all.without]
    }
}

/// The page of a fleet.
pub struct FleetPage<'a> {
    fleet: &'a Fleet,
    headlines: Vec<Fact>,
    warnings: Vec<String>,
}

impl<'a> FleetPage<'a> {
    /// The page of `fleet`, with `warnings` about its run, such as lost machines.
    #[must_use]
    pub fn new(fleet: &'a Fleet, warnings: &[String]) -> Self {
        let [good, care, bad, without] = fleet.counts();
        let headlines = vec![
            Fact::new("logs", fleet.all.logs()),
            Fact::new("good", good),
            Fact::new("with care", care),
            Fact::new("bad", bad),
            Fact::new("without a solution", without),
            Fact::new("duration", format!("{:.1} h", fleet.all.duration_s / 3600.0)),
        ];
        Self { fleet, headlines, warnings: warnings.to_vec() }
    }

    /// The page itself.
    #[must_use]
    pub fn page(&self) -> Page<'_> {
        Page {
            verdict: Some(self.verdict()),
            headlines: &self.headlines,
            warnings: &self.warnings,
            sections: vec![self.worst(), self.kinds(), self.vehicles(), self.without()],
            ..Page::titled("Fleet")
        }
    }

    fn verdict(&self) -> Verdict {
        let [good, care, bad, without] = self.fleet.counts();
        let logs = self.fleet.all.logs();
        let level = match () {
            () if bad + without > 0 => Level::Bad,
            () if care > 0 => Level::Care,
            () => Level::Good,
        };
        let words = match level {
            Level::Good => format!("All {logs} logs are good."),
            _ => format!("{} of {logs} logs need a look.", logs - good),
        };
        Verdict { level, words, reasons: Vec::new() }
    }

    fn worst(&self) -> Section {
        let row = |log: &FleetLog| TableRow {
            name: log.path.clone(),
            numbers: vec![log.kinds.join(", "), log.reason.clone()],
            judged: log.level,
        };
        let shown = format!("{} of {} logs", self.fleet.worst.len(), {
            let [_, care, bad, _] = self.fleet.counts();
            care + bad
        });
        Section::new(
            "worst",
            "Worst logs",
            "Logs whose solution needs care, by verdict and number of different warnings.",
        )
        .with(Table {
            caption: shown,
            heads: ["", "Warnings", "Main reason"].map(Into::into).into(),
            rows: self.fleet.worst.iter().map(row).collect(),
        })
    }

    fn kinds(&self) -> Section {
        let mut kinds: Vec<(&String, usize)> =
            self.fleet.by_kind.iter().map(|(kind, count)| (kind, *count)).collect();
        kinds.sort_by(|(a, some), (b, more)| more.cmp(some).then_with(|| a.cmp(b)));
        let logs = self.fleet.all.logs().max(1) as f64;
        let row = |(kind, count): (&String, usize)| {
            let share = format!("{:.1} %", 100.0 * count as f64 / logs);
            TableRow::new(kind.replace('_', " "), vec![count.to_string(), share])
        };
        Section::new("findings", "By finding", "Number of logs with each kind of warning.").with(
            Table {
                caption: "Logs with a warning".into(),
                heads: ["", "Logs", "Share"].map(Into::into).into(),
                rows: kinds.into_iter().map(row).collect(),
            },
        )
    }

    fn vehicles(&self) -> Section {
        let mut vehicles: Vec<(&String, &Counts)> = self.fleet.by_vehicle.iter().collect();
        let bad = |counts: &Counts| counts.levels[Level::Bad as usize] + counts.without;
        vehicles.sort_by(|(a, some), (b, more)| bad(more).cmp(&bad(some)).then_with(|| a.cmp(b)));
        let rows = vehicles.into_iter().map(|(name, counts)| TableRow::new(name, counts.cells()));
        Section::new("vehicles", "By vehicle", "Logs by vehicle, most trouble first.").with(Table {
            caption: "Logs of each vehicle".into(),
            heads: COUNTED.map(Into::into).into(),
            rows: rows.collect(),
        })
    }

    fn without(&self) -> Section {
        let row = |log: &FleetLog| TableRow::new(&log.path, vec![log.reason.clone()]);
        Section::new("without", "Without a solution", "Logs that gave no solution, and the reason.")
            .with(Table {
                caption: format!("{} of {} logs", self.fleet.without.len(), self.fleet.all.without),
                heads: ["", "Reason"].map(Into::into).into(),
                rows: self.fleet.without.iter().map(row).collect(),
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(index: usize, level: Option<Level>, kinds: &[&str]) -> FleetLog {
        FleetLog {
            path: format!("flight-{index}.ulg"),
            vehicle: format!("quad-{}", index % 3),
            duration_s: 360.0,
            level,
            kinds: kinds.iter().map(|&kind| kind.into()).collect(),
            reason: format!("reason {index}"),
        }
    }

    #[test]
    fn the_worst_logs_come_first_and_every_log_is_counted() {
        let mut fleet = Fleet::default();
        for index in 0..1000 {
            fleet.push(match index % 10 {
                0 => log(index, Some(Level::Care), &["outage"]),
                1 if index < 100 => log(index, Some(Level::Bad), &["outage", "glitch"]),
                2 if index < 200 => log(index, None, &[]),
                _ => log(index, Some(Level::Good), &[]),
            });
        }
        assert_eq!(fleet.counts(), [870, 100, 10, 20]);
        assert!(fleet.worst[..10].iter().all(|log| log.level == Some(Level::Bad)));
        assert_eq!(fleet.worst.len(), 110);
        let page = FleetPage::new(&fleet, &["worker 3 was lost".to_owned()]);
        let html = page.page().html().unwrap();
        for text in ["130 of 1000 logs need a look.", "reason 12", "worker 3", "100.0", "quad-2"] {
            assert!(html.contains(text), "{text}");
        }
    }

    #[test]
    fn a_fleet_of_any_size_is_a_short_page() {
        let mut fleet = Fleet::default();
        for index in 0..50_000 {
            let vehicle = format!("vehicle {index}");
            fleet.push(FleetLog { vehicle, ..log(index, Some(Level::Bad), &["outage"]) });
        }
        assert_eq!((fleet.worst.len(), fleet.by_vehicle.len()), (LISTED, VEHICLES + 1));
        assert_eq!(fleet.by_vehicle[OTHERS].logs(), 50_000 - VEHICLES);
        assert!(FleetPage::new(&Fleet::default(), &[]).page().html().is_ok());
    }
}
