//! The results of a campaign as tables.

use std::fmt::Write as _;
use std::path::Path;

use hovernav::controls::Sticks;
use hovernav_sim::HoverStatistics;
use hovernav_sim::campaign::{Campaign, CampaignResult, Failure, Outcome, SensorGrade, percentile};

use crate::output;

/// The percentiles of all tables.
pub const PERCENTILES: [u32; 6] = [5, 25, 50, 75, 95, 99];

/// A quantity that is measured in every flight.
pub struct Measure {
    /// Name of its column, with the unit last.
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

    /// Number of measures that precede the other columns of a flight.
    const FIRST: usize = 20;

    /// The value of one flight; NaN if the flight ended before the evaluation.
    pub fn of(&self, result: &CampaignResult) -> f64 {
        result.hover.as_ref().map_or(f64::NAN, |held| (self.of)(result, held))
    }

    /// The values of all flights, or of those with one sensor grade.
    pub fn values(&self, results: &[CampaignResult], grade: Option<SensorGrade>) -> Vec<f64> {
        let own = results.iter().filter(|r| grade.is_none_or(|grade| grade == r.draw.grade));
        own.map(|result| self.of(result)).filter(|value| value.is_finite()).collect()
    }

    /// The values at each of [`PERCENTILES`].
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
pub fn count(results: &[CampaignResult], outcome: Outcome, grade: Option<SensorGrade>) -> usize {
    let is_of = |result: &&CampaignResult| {
        result.outcome == outcome && grade.is_none_or(|grade| grade == result.draw.grade)
    };
    results.iter().filter(is_of).count()
}

/// Outcomes of the flights with each failure that occurred, in the order of [`Outcome::ALL`].
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

/// Writes one row per flight; unknown values stay empty.
pub fn write_results(
    path: &Path,
    campaign: &Campaign,
    results: &[CampaignResult],
) -> anyhow::Result<()> {
    let mut text = String::from("seed,outcome,crashed_s,sensors,wind_n_mps,wind_e_mps,gust_mps,");
    text += "outage_start_s,outage_duration_s";
    for name in campaign.airframe.columns() {
        let _ = write!(text, ",{name}");
    }
    let (first, last) = Measure::ALL.split_at(Measure::FIRST);
    for measure in first {
        let _ = write!(text, ",{}", measure.name);
    }
    text += ",power_loss_s";
    for measure in last {
        let _ = write!(text, ",{}", measure.name);
    }
    text += ",jam,jam_s,fuel_kg,cause\n";
    let known = |value: Option<f64>| match value.filter(|value| value.is_finite()) {
        Some(value) => value.to_string(),
        None => String::new(),
    };
    for result in results {
        let draw = &result.draw;
        let [north, east] = draw.wind_mps;
        let outage = draw.outage_s.as_ref();
        let _ = write!(
            text,
            "{},{},{},{},{north},{east},{},{},{}",
            draw.seed,
            result.outcome.name(),
            known(result.crashed_s()),
            draw.grade.name(),
            draw.gust_mps,
            known(outage.map(|outage| outage.start)),
            known(outage.map(|outage| outage.end - outage.start)),
        );
        for value in &draw.drawn {
            let _ = write!(text, ",{value}");
        }
        for measure in first {
            let _ = write!(text, ",{}", known(Some(measure.of(result))));
        }
        let _ = write!(text, ",{}", known(draw.power_loss_s));
        for measure in last {
            let _ = write!(text, ",{}", known(Some(measure.of(result))));
        }
        let stick = draw.jam.and_then(|(stick, _)| Sticks::NAMES.get(stick));
        let at_s = draw.jam.map(|(_, at_s)| at_s);
        let (stick, at_s) = (stick.unwrap_or(&""), known(at_s));
        // A comma would begin the next column.
        let cause = result.cause().unwrap_or_default().replace(',', ";");
        let _ = writeln!(text, ",{stick},{at_s},{},{cause}", draw.fuel_kg);
    }
    output::write(path, text)
}

/// Writes one row per measure and sensor grade.
pub fn write_percentiles(path: &Path, results: &[CampaignResult]) -> anyhow::Result<()> {
    let mut text = String::from("measure,sensors,flights");
    for p in PERCENTILES {
        let _ = write!(text, ",p{p}");
    }
    text.push('\n');
    let grades = SensorGrade::ALL.map(Some);
    for measure in &Measure::ALL {
        for grade in [None].into_iter().chain(grades) {
            let flights = measure.values(results, grade).len();
            let _ = write!(
                text,
                "{},{},{flights}",
                measure.name,
                grade.map_or("all", SensorGrade::name)
            );
            for value in measure.percentiles(results, grade) {
                let known = if value.is_finite() { value.to_string() } else { String::new() };
                let _ = write!(text, ",{known}");
            }
            text.push('\n');
        }
    }
    output::write(path, text)
}
