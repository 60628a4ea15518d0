//! `hovernav campaign`: many simulated closed-loop flights with random conditions.

use std::path::PathBuf;
use std::str::FromStr;
use std::time::Instant;

use anyhow::{Context as _, ensure};
use hovernav::autopilot::HoverConfig;
use hovernav_design::hover::HoverDesign;
use hovernav_model::shipped;
use hovernav_pages::campaign::CampaignPage;
use hovernav_sim::campaign::{
    Campaign, CampaignResult, Measure, Outcome, PERCENTILES, count, percentiles_csv, results_csv,
};
use serde_json::{Value, json};

use crate::arguments::{FORCED, designed_for_another, refuse_unflyable, within};
use crate::output;

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
    /// Model to design the autopilot for: a model.toml or raptor60; if the model has a covariance, airframes are drawn
    /// from it
    #[arg(long, default_value = "raptor60")]
    model: String,
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
    /// an aircraft without fuel
    #[arg(long, value_name = "KG", default_value_t = 0.4, value_parser = within(0.0, 2.0, "kg"))]
    fuel: f64,
    /// Directory to write
    #[arg(long, value_name = "DIR", default_value = "out/campaign")]
    out: PathBuf,
    /// Do not write report.html
    #[arg(long)]
    no_report: bool,
}

/// The share of the flights that this machine flies.
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

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    let Shard { own, of } = arguments.shard;
    let mut warnings = Vec::new();
    let campaign = campaign(arguments, &mut warnings)?;
    output::create(&arguments.out)?;

    let seeds: Vec<u64> = Campaign::seeds(arguments.seed, arguments.flights, own, of).collect();
    ensure!(
        !seeds.is_empty(),
        "shard {own}/{of}: found none of the {} flights in it",
        arguments.flights
    );
    let bar = output::bar(seeds.len());
    let flown = campaign.fly_all(&seeds, || bar.inc(1));
    bar.finish_and_clear();
    let results = flown?;
    let flying_s = started.elapsed().as_secs_f64();

    output::write(&arguments.out.join("results.csv"), results_csv(&results))?;
    output::write(&arguments.out.join("percentiles.csv"), percentiles_csv(&results))?;
    if !arguments.no_report {
        let page = CampaignPage::new(&campaign, &results, &warnings);
        page.page().write(&arguments.out.join(output::REPORT))?;
    } else {
        output::remove_stale(&arguments.out, [output::REPORT]);
    }
    let mut summary = summary(arguments, &campaign, &results, (flying_s, started));
    summary["warnings"] = json!(warnings);
    output::write_json(&summary, &arguments.out.join("summary.json"))?;

    output::say_text(in_words(&results));
    for warning in &warnings {
        output::say(format_args!("warning: {warning}"));
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
    let autopilot = match &arguments.autopilot {
        Some(path) => hovernav_record::read_autopilot(path)?,
        None => {
            refuse_unflyable(&model, &arguments.model, FORCED)?;
            warnings.extend(designed_for_another(&model));
            let design = HoverDesign::for_model(&model);
            let gains = design.synthesise(&model).with_context(|| arguments.model.clone())?;
            HoverConfig::new(design.period_s, gains)
        }
    };
    let mut campaign = Campaign::of_model(&model, autopilot);
    campaign.duration_s = arguments.duration;
    campaign.most_wind_mps = arguments.wind;
    campaign.outage_share = arguments.outages;
    campaign.power_loss_share = arguments.power_loss;
    campaign.jam_share = arguments.jams;
    campaign.fuel_kg = arguments.fuel;
    Ok(campaign)
}

fn summary(
    arguments: &Arguments,
    campaign: &Campaign,
    results: &[CampaignResult],
    (flying_s, started): (f64, Instant),
) -> Value {
    let outcomes: serde_json::Map<String, Value> = (Outcome::ALL.into_iter())
        .map(|outcome| (outcome.name().into(), count(results, outcome, None).into()))
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
        "outcomes": outcomes,
        "percentiles": percentiles,
    })
}

fn in_words(results: &[CampaignResult]) -> String {
    let mut text = String::new();
    for outcome in Outcome::ALL {
        let found = count(results, outcome, None);
        if found > 0 {
            text += &format!("{:<32} {found}\n", outcome.name());
        }
    }
    let heads = PERCENTILES.map(|p| format!("{:>9}", format!("{p} %"))).join("");
    text += &format!("{:<32}{heads}\n", "percentile");
    for measure in &Measure::ALL {
        let numbers = measure.percentiles(results, None).map(|value| format!("{value:>9.3}"));
        text += &format!("  {:<30}{}\n", measure.name, numbers.join(""));
    }
    text
}
