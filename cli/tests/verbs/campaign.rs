//! Campaigns of simulated flights, as a user runs them.

use std::fs;

use crate::common::{place, succeeds, summary, text};

#[test]
fn shards_of_a_campaign_are_the_campaign() {
    let fly = |name: &str, shard: &str| {
        let out = place(name);
        let own = ["--flights", "6", "--duration", "40", "--shard", shard, "--no-report"];
        succeeds(&[&["campaign", "--out", text(&out)][..], &own].concat());
        let results = fs::read_to_string(out.join("results.csv")).expect("results");
        assert!(
            fs::read_to_string(out.join("percentiles.csv")).expect("a table").lines().count() > 20
        );
        let mut rows: Vec<String> = results.lines().map(Into::into).collect();
        (rows.remove(0), rows)
    };
    let (head, mut whole) = fly("campaign", "1/1");
    let (_, mut parts) = fly("campaign_1", "1/2");
    parts.extend(fly("campaign_2", "2/2").1);
    whole.sort();
    parts.sort();
    assert_eq!(whole, parts);
    assert_eq!(whole.len(), 6);
    assert!(head.starts_with("seed,outcome,crashed_s,sensors,wind_n_mps"));
    assert!(whole.iter().all(|row| row.split(',').count() == head.split(',').count()));
}

#[test]
fn the_seed_of_a_campaign_is_the_number_of_its_first_flight() {
    let fly = |name: &str, further: &[&str]| {
        let out = place(name);
        let own = ["campaign", "--duration", "30", "--no-report", "--out", text(&out)];
        succeeds(&[&own[..], further].concat());
        let results = fs::read_to_string(out.join("results.csv")).expect("results");
        let rows: Vec<String> = results.lines().skip(1).map(Into::into).collect();
        (rows, summary(&out)["seed"].as_u64())
    };
    let (rows, seed) = fly("campaign_seed", &["--flights", "3"]);
    assert_eq!(seed, Some(1));
    assert_eq!(fly("campaign_seed_1", &["--flights", "3", "--seed", "1"]).0, rows);
    let (further, seed) = fly("campaign_seed_2", &["--flights", "2", "--seed", "2"]);
    assert_eq!((&further[..], seed), (&rows[1..], Some(2)));
}

#[test]
fn a_campaign_with_the_design_of_another_helicopter_says_so() {
    let out = place("campaign_another");
    let own = ["--flights", "1", "--duration", "30", "--model", "thesis", "--out", text(&out)];
    let words = succeeds(&[&["campaign"][..], &own].concat());
    let expected = "the autopilot is designed for thesis-hover, but the simulated aircraft is the nonlinear 60-class";
    assert!(words.contains(&format!("warning: {expected}")), "{words}");
    assert!(summary(&out)["warnings"][0].as_str().is_some_and(|text| text.starts_with(expected)));
    assert!(fs::read_to_string(out.join("report.html")).expect("a page").contains(expected));
}
