//! The page of a recorded flight: modes and their causes, commands and the motion flown.

use std::path::Path;

use hovernav::autopilot::{Check, Mode};
use hovernav::controls::Sticks;
use hovernav::earth::{Geodetic, LocalEarth};
use hovernav::ekf::Solution;
use hovernav_record::{Cycle, Level, Record, RecordedCycle};

use super::summary::RecordSummary;
use super::verdict;
use hovernav_pages::{
    Abscissa, Fact, Figure, Page, Role, Row, Section, Series, Table, TableRow, TimeAxis,
};

/// The contents of the page of a recorded flight.
pub struct RecordPage<'a> {
    pub record: &'a Record,
    pub summary: &'a RecordSummary,
}

impl RecordPage<'_> {
    /// Writes the page to `path`.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let record = self.record;
        let facts = self.summary.facts();
        let told: Vec<String> = verdict::of_flight(record)
            .filter(|event| event.level >= Level::Error)
            .map(|event| verdict::sentence(event, 1, record))
            .collect();
        let warnings: Vec<String> = told.into_iter().chain(self.summary.warnings.clone()).collect();
        let headlines = [Fact::new("replay", &self.summary.replay)];
        let start_s = record.header.start.seconds();
        let page = Page {
            verdict: Some(self.summary.verdict.clone()),
            title: &format!("Flight of {}", record.header.config.navigation.name),
            headlines: &headlines,
            warnings: &warnings,
            facts: &facts,
            table: None,
            sections: vec![
                self.modes(),
                self.place(),
                self.sticks(),
                self.velocity(),
                self.attitude(),
                self.uncertainty(),
                self.readiness(),
                self.timing(),
                self.events(),
            ],
            time: Some(TimeAxis {
                label: "time since the start of the loop, s".into(),
                span: [start_s, record.end.seconds()],
                outages: Vec::new(),
                marks: Vec::new(),
            }),
        };
        Ok(page.write(path)?)
    }

    fn cycles(&self, role: Role, value: impl Fn(&Cycle) -> f64) -> Series {
        let cycles = &self.record.cycles;
        let time: Vec<f64> = cycles.iter().map(|recorded| recorded.time.seconds()).collect();
        let values: Vec<f64> = cycles.iter().map(|recorded| value(&recorded.cycle)).collect();
        Series::line(role, &time, &values, None)
    }

    fn solutions(
        &self,
        role: Role,
        value: impl Fn(&Solution) -> f64,
        sigma: Option<&dyn Fn(&Solution) -> f64>,
    ) -> Series {
        let solutions = &self.record.solutions;
        let time: Vec<f64> = solutions.iter().map(|solution| solution.time.seconds()).collect();
        let values: Vec<f64> = solutions.iter().map(&value).collect();
        let bound: Option<Vec<f64>> =
            sigma.map(|sigma| solutions.iter().map(|solution| 3.0 * sigma(solution)).collect());
        Series::line(role, &time, &values, bound.as_deref())
    }

    fn modes(&self) -> Section {
        let rank = |mode: Mode| {
            Mode::ALL.iter().position(|own| *own == mode).map_or(f64::NAN, |rank| rank as f64)
        };
        let names: Vec<String> = Mode::ALL
            .iter()
            .enumerate()
            .map(|(rank, mode)| format!("{rank} {}", mode.name()))
            .collect();
        let figure = Figure::against_time([
            Row::new("Mode", "")
                .with(self.cycles(Role::Input, |cycle| rank(cycle.mode)).named("mode")),
            Row::new("Switch", "").with(
                self.cycles(Role::Input, |cycle| f64::from(u8::from(cycle.switch_on)))
                    .named("closed"),
            ),
        ]);
        let rows = self.summary.modes.iter().map(|span| {
            TableRow::new(
                span.mode,
                vec![format!("{:.2}", span.start_s), format!("{:.2}", span.end_s - span.start_s)],
            )
        });
        let explanation = format!(
            "Flight mode: {}. The events list the reason for each change.",
            names.join(", ")
        );
        Section::new("modes", "Modes", explanation).with(figure).with(Table {
            caption: "Modes in order".into(),
            heads: ["", "from, s", "for, s"].map(Into::into).into(),
            rows: rows.collect(),
        })
    }

    fn sticks(&self) -> Section {
        let names = ["Lateral", "Longitudinal", "Collective", "Pedal"];
        let of = |sticks: Option<Sticks>, stick: usize| {
            sticks.map_or(f64::NAN, |sticks| 100.0 * sticks.to_array()[stick])
        };
        let rows = names.into_iter().enumerate().map(|(stick, name)| {
            Row::new(name, "%")
                .with(self.cycles(Role::First, |cycle| of(cycle.sticks, stick)).named("commanded"))
                .with(self.cycles(Role::Second, |cycle| of(cycle.pilot, stick)).named("pilot"))
        });
        let explanation = "Commands to the servos and positions of the pilot's sticks, in percent \
                           of full travel about trim.";
        Section::new("sticks", "Sticks", explanation).with(Figure::against_time(rows))
    }

    /// The track from above and the height, with the geofence.
    fn place(&self) -> Section {
        let config = &self.record.header.config;
        let site = config.site.and_then(|site| {
            Geodetic::from_degrees(site.latitude_deg, site.longitude_deg, site.height_m)
        });
        let geofence =
            config.autopilot.as_ref().and_then(|own| own.geofence).filter(|_| site.is_some());
        let solutions = &self.record.solutions;
        let first = solutions.first().map(|solution| solution.position);
        // Without a geofence, the site is a region of several kilometres, so the first position is the origin.
        let origin = if geofence.is_some() { site } else { first };
        let local = origin.map(|origin| (origin, LocalEarth::at(&origin)));
        let at = |solution: &Solution| match &local {
            Some((origin, local)) => local.displacement(origin, &solution.position).to_array(),
            None => [f64::NAN; 3],
        };
        let time: Vec<f64> = solutions.iter().map(|solution| solution.time.seconds()).collect();
        let column = |axis: usize| solutions.iter().map(|one| at(one)[axis]).collect::<Vec<f64>>();
        let (north, east) = (column(0), column(1));
        let mut map = Row::new("North", "m")
            .with(Series::track(Role::Estimate, &time, [&north, &east]).named("flown"));
        let mut height = Row::new("Height", "m")
            .with(self.solutions(Role::Estimate, |one| -at(one)[2], None).named("flown"));
        if let Some(geofence) = geofence {
            let circle = (0..=180).map(|step| {
                let (sin, cos) = (f64::from(step) * std::f64::consts::PI / 90.0).sin_cos();
                (geofence.radius_m * sin, geofence.radius_m * cos)
            });
            map = map.with(Series::curve(Role::Second, circle).named("geofence"));
            let ends = [self.record.header.start.seconds(), self.record.end.seconds()];
            let top = [geofence.height_m; 2];
            height = height.with(Series::line(Role::Second, &ends, &top, None).named("geofence"));
        }
        let from =
            if geofence.is_some() { "the centre of the geofence" } else { "the first position" };
        let explanation =
            format!("Track from above, with equal scales, and height, both relative to {from}.");
        Section::new("place", "Position", explanation)
            .with(Figure::new(Abscissa::EastM, [map]))
            .with(Figure::against_time([height]))
    }

    fn velocity(&self) -> Section {
        let names = ["North", "East", "Down"];
        let rows = names.into_iter().enumerate().map(|(axis, name)| {
            let asked = |cycle: &Cycle| {
                if cycle.mode.holds_velocity() {
                    cycle.asked_velocity_mps.to_array()[axis]
                } else {
                    f64::NAN
                }
            };
            let sigma = |solution: &Solution| solution.velocity_sigma_mps.to_array()[axis];
            let flown = |solution: &Solution| solution.velocity_mps.to_array()[axis];
            Row::new(name, "m/s")
                .with(self.solutions(Role::Estimate, flown, Some(&sigma)).named("flown"))
                .with(self.cycles(Role::Second, asked).named("commanded"))
        });
        let explanation = "Estimated velocity with ±3σ, and the velocity commanded by guidance.";
        Section::new("velocity", "Velocity", explanation).with(Figure::against_time(rows))
    }

    fn attitude(&self) -> Section {
        let angle = |axis: usize| {
            move |solution: &Solution| {
                let angles = solution.body_to_ned.euler();
                [angles.roll_rad, angles.pitch_rad, angles.yaw_rad][axis].to_degrees()
            }
        };
        let sigma =
            |axis: usize| move |solution: &Solution| solution.attitude_sigma_rad[axis].to_degrees();
        let (roll, pitch, yaw) = (sigma(0), sigma(1), sigma(2));
        let asked = |cycle: &Cycle| {
            if cycle.mode == Mode::Manual { f64::NAN } else { cycle.asked_heading_rad.to_degrees() }
        };
        let rows = [
            Row::new("Roll", "°")
                .with(self.solutions(Role::Estimate, angle(0), Some(&roll)).named("flown")),
            Row::new("Pitch", "°")
                .with(self.solutions(Role::Estimate, angle(1), Some(&pitch)).named("flown")),
            Row::new("Heading", "°")
                .with(self.solutions(Role::Estimate, angle(2), Some(&yaw)).named("flown"))
                .with(self.cycles(Role::Second, asked).named("commanded")),
        ];
        let explanation = "Estimated attitude with ±3σ, and the commanded heading.";
        Section::new("attitude", "Attitude", explanation).with(Figure::against_time(rows))
    }

    fn uncertainty(&self) -> Section {
        let largest = |sigma: [f64; 3]| sigma.into_iter().fold(0.0, f64::max);
        let rows = [
            Row::new("Position", "m")
                .with(self.one_sigma(|solution| largest(solution.position_sigma_m.to_array()))),
            Row::new("Velocity", "m/s")
                .with(self.one_sigma(|solution| largest(solution.velocity_sigma_mps.to_array()))),
            Row::new("Tilt", "°").with(self.one_sigma(|solution| {
                let [roll, pitch, _] = solution.attitude_sigma_rad;
                roll.max(pitch).to_degrees()
            })),
            Row::new("Heading", "°")
                .with(self.one_sigma(|solution| solution.attitude_sigma_rad[2].to_degrees())),
        ];
        let explanation = "One-sigma of the estimate: the largest of the axes; for tilt, the larger of roll and pitch. \
                           The autopilot selects its mode by these values.";
        Section::new("uncertainty", "Uncertainty", explanation).with(Figure::against_time(rows))
    }

    /// A one-sigma of the solutions over time.
    fn one_sigma(&self, value: impl Fn(&Solution) -> f64) -> Series {
        self.solutions(Role::Estimate, value, None).named("one-sigma")
    }

    fn readiness(&self) -> Section {
        let cycles = self.aligned_cycles();
        let time: Vec<f64> = cycles.iter().map(|recorded| recorded.time.seconds()).collect();
        let failed =
            |recorded: &RecordedCycle| f64::from(recorded.cycle.failed_checks.count_ones());
        let failing: Vec<f64> = cycles.iter().map(failed).collect();
        let figure = Figure::against_time([Row::new("Checks", "")
            .with(Series::line(Role::Input, &time, &failing, None).named("failing"))]);
        let share = |bit: usize| {
            let fails = |recorded: &&RecordedCycle| recorded.cycle.failed_checks & 1 << bit != 0;
            let failing = cycles.iter().filter(fails).count();
            match cycles.len() {
                0 => "–".into(),
                count => format!("{:.1} %", 100.0 * failing as f64 / count as f64),
            }
        };
        let rows = Check::ALL
            .iter()
            .enumerate()
            .map(|(bit, check)| TableRow::new(check.name(), vec![share(bit)]));
        let explanation = match cycles.first() {
            Some(first) => format!(
                "Checks that would have kept the autopilot from taking over at each time, from the end of \
                 alignment at {:.1} s on.",
                first.time.seconds()
            ),
            None => {
                "The estimator never aligned, or there was no autopilot: a takeover was impossible."
                    .into()
            }
        };
        Section::new("readiness", "Readiness", explanation).with(figure).with(Table {
            caption: "Share of the time since alignment in which each check fails".into(),
            heads: ["", "fails"].map(Into::into).into(),
            rows: rows.collect(),
        })
    }

    /// The cycles from the first solution on. Without a solution the autopilot cannot be ready.
    fn aligned_cycles(&self) -> &[RecordedCycle] {
        let cycles = &self.record.cycles;
        let aligned = self.record.solutions.first().map(|solution| solution.time);
        let before = aligned.map_or(cycles.len(), |aligned| {
            cycles.partition_point(|recorded| recorded.time < aligned)
        });
        &cycles[before..]
    }

    fn timing(&self) -> Section {
        let work = |cycle: &Cycle| cycle.work_s.map_or(f64::NAN, |work_s| 1e3 * work_s);
        let to_servos = |cycle: &Cycle| cycle.turnaround_s.map_or(f64::NAN, |took_s| 1e3 * took_s);
        let rows = [
            Row::new("Work", "ms").with(self.cycles(Role::Estimate, work).named("work")),
            Row::new("To servos", "ms")
                .with(self.cycles(Role::Estimate, to_servos).named("to the servos")),
            Row::new("Late in a row", "")
                .with(self.cycles(Role::Input, |cycle| f64::from(cycle.late_cycles)).named("late")),
        ];
        let explanation = "Computing time of each cycle, time until the servos received their command, and number of consecutive \
             late cycles.";
        Section::new("timing", "Timing of the loop", explanation).with(Figure::against_time(rows))
    }

    fn events(&self) -> Section {
        let rows = self.record.events.iter().map(|event| {
            TableRow::new(
                format!("{:.3} s", event.time.seconds()),
                vec![event.level.name().into(), event.part.clone(), event.text.clone()],
            )
        });
        Section::new("events", "Events", "Events of the flight in words.").with(Table {
            caption: format!("{} events", self.record.events.len()),
            heads: ["When", "Level", "Part", "Event"].map(Into::into).into(),
            rows: rows.collect(),
        })
    }
}
