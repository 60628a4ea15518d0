//! `hovernav campaign`: many simulated closed-loop flights with random conditions.

mod again;
mod words;

use std::path::PathBuf;
use std::str::FromStr;
use std::time::Instant;

use anyhow::{Context as _, ensure};
use hovernav::autopilot::HoverConfig;
use hovernav_design::hover::HoverDesign;
use hovernav_model::shipped;
use hovernav_pages::campaign::CampaignPage;
use hovernav_sim::campaign::{
    Campaign, CampaignResult, Measure, Outcome, PERCENTILES, count, failures, percentiles_csv,
    results_csv, seeds_of,
};
use serde_json::{Value, json};

use crate::arguments::{FORCED, designed_for_another, finite, flown, refuse_unflyable, within};
use crate::{output, simulate};

#[derive(clap::Args)]
pub struct Arguments {
    /// Number of flights, over all shards
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    flights: u64,
    /// Seed of the first flight; each further flight increments it. The same seed gives the same flights
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(0..=u64::MAX / 2))]
    seed: u64,
    /// Duration of each flight, s
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = within(30.0, 3600.0, "s"))]
    duration: f64,
    /// Fly only the Kth of N shards of the flights; the results.csv of all shards together equal those of an unsharded
    /// run
    #[arg(long, value_name = "K/N", default_value = "1/1")]
    shard: Shard,
    /// Model to design the autopilot for: a model.toml, raptor60, thesis or r50; if the model has a covariance,
    /// airframes are drawn from it
    #[arg(long, default_value = "raptor60")]
    model: String,
    /// Vehicle to fly: raptor60, the nonlinear 60-class helicopter, or a linear model of any vehicle, a model.toml, r50
    /// or thesis [default: --model]
    #[arg(long, value_name = "VEHICLE")]
    vehicle: Option<String>,
    /// Relative error, one sigma, of a property that differs from flight to flight, independent of the others; may be
    /// repeated. NAME is that of a column of results.csv, without "factor_" [default: 0.05 for mass, 0.1 for others, or
    /// the covariance of the model]
    #[arg(long, value_name = "NAME=SHARE")]
    spread: Vec<Spread>,
    /// The autopilot.toml to fly with, instead of a design for the model
    #[arg(long, value_name = "FILE")]
    autopilot: Option<PathBuf>,
    /// Largest steady wind, m/s; gusts are a quarter of the wind
    #[arg(long, value_name = "MPS", default_value_t = 5.0, value_parser = within(0.0, 20.0, "m/s"))]
    wind: f64,
    /// Fraction of flights with one GPS outage of 5 to 20 s
    #[arg(long, value_name = "SHARE", default_value_t = 0.25, value_parser = within(0.0, 1.0, ""))]
    outages: f64,
    /// Fraction of flights with one engine stop, not reported to the autopilot
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = within(0.0, 1.0, ""))]
    power_loss: f64,
    /// Fraction of flights in which the servo of one stick jams, not reported to the autopilot
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = within(0.0, 1.0, ""))]
    jams: f64,
    /// Fuel in a full tank, kg: each flight starts with a random amount between its consumption and a full tank; 0 for
    /// an aircraft without fuel [default: 0.4, or 0 for a linear model, which has no mass]
    #[arg(long, value_name = "KG", value_parser = within(0.0, 2.0, "kg"))]
    fuel: Option<f64>,
    /// Fly only the flight of this seed, and write its record, estimate and page to DIR/seed-SEED
    #[arg(long, value_name = "SEED", conflicts_with_all = ["flights", "seed", "shard"])]
    record: Option<u64>,
    /// Directory to write
    #[arg(long, value_name = "DIR", default_value = "out/campaign")]
    out: PathBuf,
    /// Do not write report.html
    #[arg(long)]
    no_report: bool,
}

/// The fraction of the flights that this machine flies: shard K of N.
#[derive(Clone, Copy)]
struct Shard {
    own: u64,
    of: u64,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(own, of)| {
            let (own, of) = (own.parse::<u64>().ok()?, of.parse::<u64>().ok()?);
            (1 <= own && own <= of).then_some(Self { own, of })
        });
        numbers.ok_or_else(|| format!("found \"{text}\", expected K/N with K from 1 to N"))
    }
}

/// A relative error of a property, in the form NAME=SHARE.
#[derive(Clone)]
struct Spread {
    name: String,
    share: f64,
}

impl FromStr for Spread {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('=').and_then(|(name, share)| {
            let share = finite(share).filter(|share| (0.0..=1.0).contains(share))?;
            Some(Self { name: name.trim().to_owned(), share })
        });
        parts.ok_or_else(|| format!("found \"{text}\", expected NAME=SHARE with SHARE from 0 to 1"))
    }
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    let Shard { own, of } = arguments.shard;
    let mut warnings = Vec::new();
    let campaign = campaign(arguments, &mut warnings)?;
    if let Some(seed) = arguments.record {
        let out = arguments.out.join(format!("seed-{seed}"));
        let flight = campaign.flight(&campaign.draw(seed))?;
        return simulate::record(&flight, &out, !arguments.no_report, warnings, started);
    }
    output::create(&arguments.out)?;

    let seeds: Vec<u64> = Campaign::seeds(arguments.seed, arguments.flights, own, of).collect();
    ensure!(
        !seeds.is_empty(),
        "shard {own}/{of}: contains none of the {} flights",
        arguments.flights
    );
    let bar = output::bar(seeds.len());
    let flown = campaign.fly_all(&seeds, || bar.inc(1));
    bar.finish_and_clear();
    let results = flown?;
    let flying_s = started.elapsed().as_secs_f64();

    let again = again::command();
    output::write(&arguments.out.join("results.csv"), results_csv(&campaign, &results))?;
    output::write(&arguments.out.join("percentiles.csv"), percentiles_csv(&results))?;
    if !arguments.no_report {
        let page = CampaignPage::new(&campaign, &results, &warnings);
        page.page().write(&arguments.out.join(output::REPORT))?;
    } else {
        output::remove_stale(&arguments.out, [output::REPORT]);
    }
    let mut summary = summary(arguments, &campaign, &results, &again, (flying_s, started));
    summary["warnings"] = json!(warnings);
    output::write_json(&summary, &arguments.out.join("summary.json"))?;

    output::say_text(words::in_words(&campaign, &results, &again));
    for warning in &warnings {
        output::warn(warning);
    }
    let cores = rayon::current_num_threads();
    output::say(format_args!(
        "{}: {} flights of {:.0} s in {flying_s:.1} s on {cores} threads, {:.0} times real time",
        arguments.out.display(),
        results.len(),
        campaign.duration_s,
        results.len() as f64 * campaign.duration_s / flying_s
    ));
    Ok(())
}

fn campaign(arguments: &Arguments, warnings: &mut Vec<String>) -> anyhow::Result<Campaign> {
    let model = shipped::open(&arguments.model)?;
    let flown = flown(arguments.vehicle.as_deref(), Some(&arguments.model))?;
    let autopilot = match &arguments.autopilot {
        Some(path) => hovernav_record::read_autopilot(path)?,
        None => {
            refuse_unflyable(&model, &arguments.model, FORCED)?;
            warnings.extend(designed_for_another(&model, flown.as_ref()));
            let design = HoverDesign::for_model(&model);
            let gains = design.synthesise(&model).with_context(|| arguments.model.clone())?;
            HoverConfig::new(design.period_s, gains)
        }
    };
    let mut campaign = match &flown {
        None => {
            let mut campaign = Campaign::of_model(&model, autopilot);
            campaign.fuel_kg = arguments.fuel.unwrap_or(campaign.fuel_kg);
            campaign
        }
        Some(flown) => {
            let lacks = |what| format!("{}: a linear model has no {what}", flown.name());
            ensure!(arguments.power_loss == 0.0, "--power-loss: {}", lacks("engine"));
            ensure!(arguments.fuel.unwrap_or(0.0) == 0.0, "--fuel: {}", lacks("mass"));
            Campaign::linear(autopilot, flown)?
        }
    };
    for Spread { name, share } in &arguments.spread {
        let airframe = std::mem::take(&mut campaign.airframe);
        campaign.airframe = airframe.with_spread(name, *share).context("--spread")?;
    }
    campaign.duration_s = arguments.duration;
    campaign.max_wind_mps = arguments.wind;
    campaign.outage_share = arguments.outages;
    campaign.power_loss_share = arguments.power_loss;
    campaign.jam_share = arguments.jams;
    Ok(campaign)
}

fn summary(
    arguments: &Arguments,
    campaign: &Campaign,
    results: &[CampaignResult],
    again: &str,
    (flying_s, started): (f64, Instant),
) -> Value {
    let outcomes: serde_json::Map<String, Value> = (Outcome::ALL.into_iter())
        .map(|outcome| (outcome.name().into(), count(results, outcome, None).into()))
        .collect();
    let failures: serde_json::Map<String, Value> = failures(results)
        .into_iter()
        .map(|(failure, counts)| {
            let own = Outcome::ALL.into_iter().zip(counts);
            let own = own.map(|(outcome, count)| (outcome.name().into(), count.into()));
            (failure.name(), Value::Object(own.collect()))
        })
        .collect();
    let crashes: Vec<Value> = results
        .iter()
        .filter_map(|result| {
            let (seed, cause) = (result.draw.seed, result.cause()?);
            Some(json!({ "seed": seed, "cause": cause, "again": format!("{again} {seed}") }))
        })
        .collect();
    let percentiles: serde_json::Map<String, Value> = Measure::ALL
        .iter()
        .map(|measure| {
            let found = measure.percentiles(results, None);
            let found =
                PERCENTILES.iter().zip(found).map(|(p, value)| (format!("p{p}"), json!(value)));
            (measure.name.into(), Value::Object(found.collect()))
        })
        .collect();
    json!({
        "tool": "hovernav",
        "version": env!("CARGO_PKG_VERSION"),
        "input": arguments.model,
        "duration_s": campaign.duration_s,
        "wall_s": started.elapsed().as_secs_f64(),
        "imu_samples": 0,
        "gps_fixes_used": 0,
        "gps_fixes_rejected": 0,
        "flights": results.len(),
        "seed": arguments.seed,
        "shard": format!("{}/{}", arguments.shard.own, arguments.shard.of),
        "threads": rayon::current_num_threads(),
        "flights_per_second": results.len() as f64 / flying_s,
        "identified": campaign.airframe.identified(),
        "vehicle": campaign.nominal.model.as_ref().map_or("60-class helicopter", |own| own.name()),
        "outcomes": outcomes,
        "failures": failures,
        "crashes": crashes,
        "degraded_seeds": seeds_of(results, Outcome::Degraded),
        "not_engaged_seeds": seeds_of(results, Outcome::NotEngaged),
        "percentiles": percentiles,
    })
}
