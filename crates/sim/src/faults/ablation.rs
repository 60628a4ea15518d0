//! Ablation: the effect of each mechanism of the estimator. Each mechanism is switched off alone, on many flights and
//! faults.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use hovernav::ekf::{EkfConfig, EstimatorConfig, Mechanisms};
use hovernav_dataset::{Dataset, LogError};
use hovernav_findings::{check_fitness, ignore};
use hovernav_replay::estimate;
use rayon::prelude::*;

use super::campaign::{name, scratch};
use super::fault::Fault;
use super::flights::{Clean, Flight};
use super::measure::measure;

/// A change of the settings that switches something off.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    /// Name, unique.
    pub name: &'static str,
    change: Change,
}

#[derive(Clone, Copy, Debug)]
enum Change {
    Nothing,
    Mechanism,
    Only(Mechanisms),
    Setting(fn(&mut EkfConfig)),
}

/// Cuts that switch something off by setting a value to zero, and the cut of all mechanisms at once.
const OTHERS: [(&str, Change); 8] = [
    (
        "slow_fix_errors",
        Change::Setting(|config| {
            (config.gps.position_wander_share, config.gps.velocity_wander_share) = (0.0, 0.0);
        }),
    ),
    ("delay", Change::Setting(|config| config.gps.delay_sigma_s = 0.0)),
    ("latency", Change::Setting(|config| config.gps.position_latency_sigma_s = 0.0)),
    ("smoothed_velocity", Change::Setting(|config| config.gps.velocity_smoothing_s = 0.0)),
    (
        "vibration",
        Change::Setting(|config| {
            (config.imu.gyro_vibration_share, config.imu.accel_vibration_share) = (0.0, 0.0);
        }),
    ),
    ("turn_errors", Change::Setting(|config| config.imu.turn_error_share = 0.0)),
    ("net_turns", Change::Setting(|config| config.imu.net_turn_error_share = 0.0)),
    ("all", Change::Only(Mechanisms::NONE)),
];

impl Cut {
    /// No cut: the unchanged estimator.
    pub const NONE: Self = Self { name: "none", change: Change::Nothing };

    /// All cuts, without [`Cut::NONE`]: each mechanism, some settings, and all mechanisms together.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mechanisms = Mechanisms::LIST.iter();
        let mechanisms = mechanisms.map(|&(name, _)| Self { name, change: Change::Mechanism });
        mechanisms.chain(OTHERS.map(|(name, change)| Self { name, change })).collect()
    }

    fn apply(&self, mut config: EstimatorConfig) -> EstimatorConfig {
        match self.change {
            Change::Nothing => {}
            Change::Mechanism => {
                config.ekf.mechanisms.set(self.name, false);
            }
            Change::Only(mechanisms) => config.ekf.mechanisms = mechanisms,
            Change::Setting(change) => change(&mut config.ekf),
        }
        config
    }
}

/// Flights, faults and cuts of an ablation.
#[derive(Clone, Debug)]
pub struct Ablation {
    /// Flights.
    pub flights: Vec<Flight>,
    /// Faults in addition to the flights without fault.
    pub cells: Vec<Vec<Fault>>,
    /// Number of seeds, from 1, at least one. A flight or fault without random values is run with one seed only.
    pub seeds: u64,
    /// Cuts; [`Cut::NONE`] is added.
    pub cuts: Vec<Cut>,
}

/// Names of the compared errors, in the order of [`Ablated::errors`].
pub const ERRORS: [&str; 6] =
    ["velocity_mps", "vertical_velocity_mps", "horizontal_m", "height_m", "tilt_deg", "yaw_deg"];
/// Differences of the [`ERRORS`], in their own units, below which a run counts as unchanged.
const MIN: [f64; 6] = [0.005, 0.005, 0.1, 0.1, 0.05, 0.1];
/// Smallest ratio of an error with a cut to the error without cut that counts as worse; the inverse of the ratio counts
/// as better.
const CHANGED: f64 = 1.05;

/// Result of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Ablated {
    /// Flight, faults and seed, separated by a vertical bar.
    pub run: String,
    /// Name of the cut.
    pub cut: String,
    /// Root mean square errors; NaN if unknown: of velocity, m/s, vertical velocity, m/s, horizontal position, m,
    /// height, m, tilt, °, and yaw, °.
    pub errors: [f64; 6],
    /// Fraction of the samples of velocity and attitude inside 3 sigma.
    pub inside: f64,
}

impl Ablated {
    fn is_fault(&self) -> bool {
        !self.run.contains("||")
    }
}

impl Ablation {
    /// Runs all combinations on all processors, except the runs named in `known`. `finished` receives the results of a
    /// run, one for each cut. Results do not depend on the number of processors; their order does.
    ///
    /// # Errors
    /// [`LogError`] for a flight that cannot be read or a copy that cannot be written.
    pub fn run(
        &self,
        known: &(impl Fn(&str) -> bool + Sync),
        finished: &(impl Fn(Vec<Ablated>) + Sync),
    ) -> Result<(), LogError> {
        self.flights.par_iter().try_for_each(|flight| {
            let seeds = if flight.is_drawn() { self.seeds } else { 1 };
            (1..=seeds).into_par_iter().try_for_each(|seed| {
                let scratch = scratch()?;
                let clean = flight.clean(seed, scratch.path())?;
                let none = Vec::new();
                let mut jobs = clean.jobs(&self.cells, self.seeds);
                jobs.push((&none, seed));
                jobs.into_par_iter().try_for_each(|(faults, seed)| {
                    let run = format!("{}|{}|{seed}", clean.name, name(faults));
                    if known(&run) {
                        return Ok(());
                    }
                    let Some((dataset, config)) = opened(&clean, faults, seed)? else {
                        return Ok(());
                    };
                    let cuts = std::iter::once(Cut::NONE).chain(self.cuts.iter().copied());
                    let rows = cuts.map(|cut| {
                        let flown = estimate(&dataset, &cut.apply(config), |_| {});
                        let reference = clean.reference.as_ref();
                        let of = measure(&flown.solutions, reference, &[], clean.end_s);
                        Ablated {
                            run: run.clone(),
                            cut: cut.name.into(),
                            errors: [
                                of.velocity_rmse_mps,
                                of.vertical_velocity_rmse_mps,
                                of.horizontal_rmse_m,
                                of.height_rmse_m,
                                of.tilt_rmse_deg,
                                of.yaw_rmse_deg,
                            ],
                            inside: of.inside_motion,
                        }
                    });
                    finished(rows.collect());
                    Ok(())
                })
            })
        })
    }
}

/// The flight with faults, and its settings. `None` if the flight lacks the sensor of a fault, or the log with faults
/// is rejected.
fn opened(
    clean: &Clean,
    faults: &[Fault],
    seed: u64,
) -> Result<Option<(Dataset, EstimatorConfig)>, LogError> {
    let Some((_, scratch)) = clean.copy(faults, seed)? else { return Ok(None) };
    let Ok(mut dataset) = Dataset::open(scratch.path()) else { return Ok(None) };
    let Ok(denied) = check_fitness(&dataset, scratch.path()) else { return Ok(None) };
    ignore(&mut dataset, denied);
    let config = dataset.settings()?;
    Ok(Some((dataset, config)))
}

/// The results as CSV, without a header.
#[must_use]
pub fn ablation_csv(rows: &[Ablated]) -> String {
    rows.iter().fold(String::new(), |mut text, row| {
        let errors = row.errors.map(|error| format!("{error:.5e}")).join(",");
        let _ = writeln!(text, "{},{},{errors},{:.5}", row.run, row.cut, row.inside);
        text
    })
}

/// The results in the text of [`ablation_csv`]. Incomplete lines, as an interrupted ablation may leave, are skipped.
#[must_use]
pub fn read_ablation(text: &str) -> Vec<Ablated> {
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let [run, cut, errors @ .., inside] = &fields[..] else { return None };
        let errors: Vec<f64> = errors.iter().map_while(|error| error.parse().ok()).collect();
        Some(Ablated {
            run: (*run).to_owned(),
            cut: (*cut).to_owned(),
            errors: errors.try_into().ok()?,
            inside: inside.parse().ok()?,
        })
    };
    text.lines().filter_map(row).collect()
}

/// Effect of one cut on a set of runs.
#[derive(Default)]
struct Effect {
    /// Number of worse and number of better runs: first without faults, then with faults.
    counts: [[usize; 2]; 2],
    /// Largest loss and largest gain, each as a ratio and as text.
    most: [(f64, String); 2],
    /// Sum of the changes of the fraction inside 3 sigma, and number of runs.
    inside: (f64, f64),
}

impl Effect {
    fn add(&mut self, without: &Ablated, row: &Ablated) {
        let mut largest = 1.0_f64;
        let mut words = String::new();
        for ((name, least), (before, after)) in
            ERRORS.iter().zip(MIN).zip(without.errors.iter().zip(row.errors))
        {
            let ratio = after / before;
            let counts = (after - before).abs() > least && ratio.is_finite();
            if counts && ratio.ln().abs() > largest.ln().abs() {
                let (quantity, unit) = name.rsplit_once('_').unwrap_or_default();
                let quantity = quantity.replace('_', " ");
                let unit = unit.replace("mps", "m/s").replace("deg", "°");
                largest = ratio;
                words = format!("{}: {quantity} {before:.3} → {after:.3} {unit}", row.run);
            }
        }
        let counts = &mut self.counts[usize::from(row.is_fault())];
        let [loss, gain] = &mut self.most;
        if largest >= CHANGED {
            counts[0] += 1;
            if largest > loss.0.max(1.0) {
                *loss = (largest, words);
            }
        } else if largest <= 1.0 / CHANGED {
            counts[1] += 1;
            if 1.0 / largest > gain.0.max(1.0) {
                *gain = (1.0 / largest, words);
            }
        }
        if (row.inside - without.inside).is_finite() {
            self.inside.0 += row.inside - without.inside;
            self.inside.1 += 1.0;
        }
    }
}

/// A table with a row for each cut. It has the number of runs that get worse or better by more than 5 % in their most
/// changed error. It also has the largest loss and gain, and the mean change of the fraction inside 3 sigma.
#[must_use]
pub fn ablation_markdown(rows: &[Ablated]) -> String {
    let without: BTreeMap<&str, &Ablated> =
        rows.iter().filter(|row| row.cut == Cut::NONE.name).map(|row| (&*row.run, row)).collect();
    let mut effects: BTreeMap<&str, Effect> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.cut != Cut::NONE.name) {
        if let Some(without) = without.get(&*row.run) {
            effects.entry(&row.cut).or_default().add(without, row);
        }
    }
    let mut text = String::from(
        "| off | flights worse / better | faults worse / better | inside 3σ, points | largest loss when off | \
         largest gain when off |\n|---|---|---|---|---|---|\n",
    );
    for (cut, effect) in effects {
        let [[flights_worse, flights_better], [faults_worse, faults_better]] = effect.counts;
        let [loss, gain] = effect.most.map(|(_, words)| words.replace('|', " "));
        let (sum, count) = effect.inside;
        let points = 100.0 * sum / count.max(1.0);
        let _ = writeln!(
            text,
            "| {cut} | {flights_worse} / {flights_better} | {faults_worse} / {faults_better} | {points:+.2} | {loss} | \
             {gain} |"
        );
    }
    text
}
