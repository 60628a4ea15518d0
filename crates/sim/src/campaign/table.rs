//! The results of a campaign as tables: one row per flight, and percentiles of each measure.

use std::borrow::Cow;
use std::fmt::{self, Write as _};

use hovernav::controls::Sticks;

use super::{Campaign, CampaignResult, Failure, Outcome, SensorGrade, percentile};
use crate::flight::HoverStatistics;

/// The percentiles of all tables.
pub const PERCENTILES: [u32; 6] = [5, 25, 50, 75, 95, 99];

/// A quantity that is measured in every flight.
pub struct Measure {
    /// Name of the measure's column, with the unit last.
    pub name: &'static str,
    of: fn(&CampaignResult, &HoverStatistics) -> f64,
}

impl Measure {
    /// All measures, in the order of the columns.
    pub const ALL: [Self; 22] = [
        Self { name: "u_rms_mps", of: |_, held| held.velocity_rms_mps[0] },
        Self { name: "v_rms_mps", of: |_, held| held.velocity_rms_mps[1] },
        Self { name: "w_rms_mps", of: |_, held| held.velocity_rms_mps[2] },
        Self { name: "roll_rms_deg", of: |_, held| held.attitude_rms_deg[0] },
        Self { name: "pitch_rms_deg", of: |_, held| held.attitude_rms_deg[1] },
        Self { name: "heading_worst_deg", of: |_, held| held.heading_worst_deg },
        Self { name: "north_rms_m", of: |_, held| held.position_rms_m[0] },
        Self { name: "east_rms_m", of: |_, held| held.position_rms_m[1] },
        Self { name: "down_rms_m", of: |_, held| held.position_rms_m[2] },
        Self { name: "distance_worst_m", of: |result, _| result.distance_worst_m },
        Self { name: "tilt_worst_deg", of: |result, _| result.tilt_worst_deg },
        Self { name: "vn_error_rms_mps", of: |_, held| held.velocity_error_rms_mps[0] },
        Self { name: "ve_error_rms_mps", of: |_, held| held.velocity_error_rms_mps[1] },
        Self { name: "vd_error_rms_mps", of: |_, held| held.velocity_error_rms_mps[2] },
        Self { name: "roll_error_rms_deg", of: |_, held| held.attitude_error_rms_deg[0] },
        Self { name: "pitch_error_rms_deg", of: |_, held| held.attitude_error_rms_deg[1] },
        Self { name: "yaw_error_rms_deg", of: |_, held| held.attitude_error_rms_deg[2] },
        Self { name: "lateral_rms", of: |_, held| held.sticks_rms[0] },
        Self { name: "longitudinal_rms", of: |_, held| held.sticks_rms[1] },
        Self { name: "pedal_rms", of: |_, held| held.sticks_rms[3] },
        Self { name: "collective_rms", of: |_, held| held.sticks_rms[2] },
        Self { name: "collective_mean", of: |_, held| held.sticks_mean[2] },
    ];

    /// Number of measures whose columns precede the time of the power loss in the row of a flight.
    const FIRST: usize = 20;

    /// The value of one flight; NaN if the flight ended before the evaluation.
    #[must_use]
    pub fn of(&self, result: &CampaignResult) -> f64 {
        result.hover.as_ref().map_or(f64::NAN, |held| (self.of)(result, held))
    }

    /// The known values of all flights, or of those with one sensor grade.
    #[must_use]
    pub fn values(&self, results: &[CampaignResult], grade: Option<SensorGrade>) -> Vec<f64> {
        let own = results.iter().filter(|r| grade.is_none_or(|grade| grade == r.draw.grade));
        own.map(|result| self.of(result)).filter(|value| value.is_finite()).collect()
    }

    /// The values at each of [`PERCENTILES`]; NaN without a value.
    #[must_use]
    pub fn percentiles(
        &self,
        results: &[CampaignResult],
        grade: Option<SensorGrade>,
    ) -> [f64; PERCENTILES.len()] {
        let values = self.values(results, grade);
        PERCENTILES.map(|p| percentile(&values, f64::from(p) / 100.0))
    }
}

/// The number of flights with an outcome, in all or with one sensor grade.
#[must_use]
pub fn count(results: &[CampaignResult], outcome: Outcome, grade: Option<SensorGrade>) -> usize {
    let is_of = |result: &&CampaignResult| {
        result.outcome == outcome && grade.is_none_or(|grade| grade == result.draw.grade)
    };
    results.iter().filter(is_of).count()
}

/// The seeds of the flights with an outcome, in the order of `results`.
#[must_use]
pub fn seeds_of(results: &[CampaignResult], outcome: Outcome) -> Vec<u64> {
    let own = results.iter().filter(|result| result.outcome == outcome);
    own.map(|result| result.draw.seed).collect()
}

/// Outcomes of the flights with each failure that occurred, in the order of [`Outcome::ALL`].
#[must_use]
pub fn failures(results: &[CampaignResult]) -> Vec<(Failure, [usize; Outcome::ALL.len()])> {
    let counts = |failure: Failure| {
        Outcome::ALL.map(|outcome| {
            let own = results.iter().filter(|own| own.outcome == outcome);
            own.filter(|own| own.draw.failure() == failure).count()
        })
    };
    let all = Failure::ALL.into_iter().map(|failure| (failure, counts(failure)));
    all.filter(|(_, counts)| counts.iter().sum::<usize>() > 0).collect()
}

/// One value in the row of a flight. It is written as in `results.csv`.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Number of the flight.
    Seed(u64),
    /// A name or a text without a comma; empty for nothing.
    Name(Cow<'static, str>),
    /// A number in the unit of its column. A number that is not finite is unknown, and its field in the file is empty.
    Number(f64),
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Seed(seed) => write!(f, "{seed}"),
            Self::Name(name) => f.write_str(name),
            Self::Number(value) if value.is_finite() => write!(f, "{value}"),
            Self::Number(_) => Ok(()),
        }
    }
}

/// One column of `results.csv`.
pub struct Column {
    /// Name of the column, with the unit last.
    pub name: Cow<'static, str>,
    of: Box<dyn Fn(&CampaignResult) -> Cell + Send + Sync>,
}

impl Column {
    fn new(
        name: impl Into<Cow<'static, str>>,
        of: impl Fn(&CampaignResult) -> Cell + Send + Sync + 'static,
    ) -> Self {
        Self { name: name.into(), of: Box::new(of) }
    }

    fn number(
        name: impl Into<Cow<'static, str>>,
        of: impl Fn(&CampaignResult) -> Option<f64> + Send + Sync + 'static,
    ) -> Self {
        Self::new(name, move |result| Cell::Number(of(result).unwrap_or(f64::NAN)))
    }

    /// All columns of a `campaign`, in the order of the file.
    #[must_use]
    pub fn all(campaign: &Campaign) -> Vec<Self> {
        let start_s = |result: &CampaignResult| result.draw.outage_s.as_ref().map(|o| o.start);
        let length_s =
            |result: &CampaignResult| result.draw.outage_s.as_ref().map(|o| o.end - o.start);
        let mut columns = vec![
            Self::new("seed", |result| Cell::Seed(result.draw.seed)),
            Self::new("outcome", |result| Cell::Name(result.outcome.name().into())),
            Self::number("crashed_s", CampaignResult::crashed_s),
            Self::new("sensors", |result| Cell::Name(result.draw.grade.name().into())),
            Self::number("wind_n_mps", |result| Some(result.draw.wind_mps[0])),
            Self::number("wind_e_mps", |result| Some(result.draw.wind_mps[1])),
            Self::number("gust_mps", |result| Some(result.draw.gust_mps)),
            Self::number("outage_start_s", start_s),
            Self::number("outage_duration_s", length_s),
        ];
        columns.extend(campaign.airframe.columns().enumerate().map(|(index, name)| {
            Self::number(name, move |result| result.draw.drawn.get(index).copied())
        }));
        let measure =
            |measure: Measure| Self::number(measure.name, move |result| Some(measure.of(result)));
        let mut measures = Measure::ALL.into_iter();
        columns.extend(measures.by_ref().take(Measure::FIRST).map(measure));
        columns.push(Self::number("power_loss_s", |result| result.draw.power_loss_s));
        columns.extend(measures.map(measure));
        columns.push(Self::new("jam", |result| {
            let stick = result.draw.jam.and_then(|(stick, _)| Sticks::NAMES.get(stick).copied());
            Cell::Name(stick.unwrap_or_default().into())
        }));
        columns.push(Self::number("jam_s", |result| result.draw.jam.map(|(_, at_s)| at_s)));
        columns.push(Self::number("fuel_kg", |result| Some(result.draw.fuel_kg)));
        // A comma would begin the next column.
        columns.push(Self::new("cause", |result| {
            Cell::Name(result.cause().unwrap_or_default().replace(',', ";").into())
        }));
        columns
    }

    /// The value of one flight.
    #[must_use]
    pub fn of(&self, result: &CampaignResult) -> Cell {
        (self.of)(result)
    }
}

/// The content of `results.csv` of a `campaign`: one row per flight; unknown values are empty.
#[must_use]
pub fn results_csv(campaign: &Campaign, results: &[CampaignResult]) -> String {
    let columns = Column::all(campaign);
    let names: Vec<&str> = columns.iter().map(|column| &*column.name).collect();
    let mut text = names.join(",") + "\n";
    for result in results {
        for (index, column) in columns.iter().enumerate() {
            let comma = if index > 0 { "," } else { "" };
            let _ = write!(text, "{comma}{}", column.of(result));
        }
        text.push('\n');
    }
    text
}

/// The content of `percentiles.csv`: one row per measure and sensor grade; unknown values are empty.
#[must_use]
pub fn percentiles_csv(results: &[CampaignResult]) -> String {
    let mut text = String::from("measure,sensors,flights");
    for p in PERCENTILES {
        let _ = write!(text, ",p{p}");
    }
    text.push('\n');
    let grades = SensorGrade::ALL.map(Some);
    for measure in &Measure::ALL {
        for grade in [None].into_iter().chain(grades) {
            let flights = measure.values(results, grade).len();
            let sensors = grade.map_or("all", SensorGrade::name);
            let _ = write!(text, "{},{sensors},{flights}", measure.name);
            for value in measure.percentiles(results, grade) {
                let _ = write!(text, ",{}", Cell::Number(value));
            }
            text.push('\n');
        }
    }
    text
}
