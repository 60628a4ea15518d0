//! A campaign in words.

use hovernav_pages::campaign::{LISTED, listed};
use hovernav_sim::campaign::{
    Campaign, CampaignResult, Failure, Measure, Outcome, PERCENTILES, count, failures, seeds_of,
};

/// Outcomes, failures, crashes with their causes, and percentiles.
pub fn in_words(campaign: &Campaign, results: &[CampaignResult], again: &str) -> String {
    let mut text = String::new();
    for outcome in Outcome::ALL {
        let found = count(results, outcome, None);
        if found > 0 {
            text += &format!("{:<32} {found}\n", outcome.name());
        }
    }
    let failures = failures(results);
    if failures.iter().any(|(failure, _)| *failure != Failure::None) {
        let heads = Outcome::ALL.map(|outcome| format!("{:>12}", outcome.name())).join("");
        text += &format!("{:<32}{heads}\n", "failure");
        for (failure, counts) in failures {
            let numbers = counts.map(|count| format!("{count:>12}")).join("");
            text += &format!("  {:<30}{numbers}\n", failure.name());
        }
    }
    text += &failed(results, again);
    if results.iter().all(|result| result.hover.is_none()) {
        let from_s = campaign.judged_from_s;
        return text + &format!("no flight lasted until the evaluation, from {from_s:.0} s on\n");
    }
    let heads = PERCENTILES.map(|p| format!("{:>9}", format!("{p} %"))).join("");
    text += &format!("{:<32}{heads}\n", "percentile");
    for measure in &Measure::ALL {
        let numbers = measure.percentiles(results, None).map(|value| format!("{value:>9.3}"));
        text += &format!("  {:<30}{}\n", measure.name, numbers.join(""));
    }
    text
}

/// The crashed flights, a line each, the seeds of all other failed flights, and the command that flies one of them
/// again.
fn failed(results: &[CampaignResult], again: &str) -> String {
    let crashed = || results.iter().filter_map(|own| Some((own.draw.seed, own.cause()?)));
    let mut text: String = crashed()
        .take(LISTED)
        .map(|(seed, cause)| format!("crash of seed {seed}: {cause}\n"))
        .collect();
    let further = crashed().count().saturating_sub(LISTED);
    if further > 0 {
        text += &format!("{further} further crashes: see results.csv\n");
    }
    for outcome in [Outcome::Degraded, Outcome::NotEngaged] {
        let seeds = seeds_of(results, outcome);
        if !seeds.is_empty() {
            text += &format!("{:<32} {}\n", format!("seeds, {}", outcome.name()), listed(&seeds));
        }
    }
    let failed = results.iter().find(|one| one.cause().is_some());
    let failed = failed.or_else(|| results.iter().find(|one| one.outcome != Outcome::Hovered));
    if let Some(one) = failed {
        text += &format!("{:<32} {again} {}\n", "fly one again", one.draw.seed);
    }
    text
}
