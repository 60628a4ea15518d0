//! Simulated flights and campaigns of them, as a user runs them.

use std::fs;

use crate::common::{hovernav, place, refusal, succeeds, summary, text};

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
fn a_campaign_with_the_design_of_another_helicopter_reports_it() {
    let out = place("campaign_another");
    let own = ["--flights", "1", "--duration", "30", "--model", "thesis", "--out", text(&out)];
    let run = hovernav(&[&["campaign", "--vehicle", "raptor60"][..], &own].concat());
    let words = String::from_utf8(run.stderr).expect("text");
    let expected = "the autopilot is designed for thesis-hover, but the simulated aircraft is the nonlinear 60-class";
    assert!(words.contains(&format!("warning: {expected}")), "{words}");
    assert!(summary(&out)["warnings"][0].as_str().is_some_and(|text| text.starts_with(expected)));
    assert!(fs::read_to_string(out.join("report.html")).expect("a page").contains(expected));
}

#[test]
fn a_linear_model_flies_itself_and_what_it_lacks_is_refused() {
    let out = place("campaign_linear");
    let all = ["campaign", "--flights", "4", "--duration", "40", "--out", text(&out)];
    let words = succeeds(&[&all[..], &["--model", "r50", "--no-report"]].concat());
    let summary = summary(&out);
    assert_eq!(summary["vehicle"], "mettler-r50-hover");
    assert_eq!(summary["outcomes"]["crashed"], 0, "{words}");
    let results = fs::read_to_string(out.join("results.csv")).expect("results");
    let head = results.lines().next().expect("a head");
    assert!(head.contains(",p_b,") && head.ends_with("fuel_kg,cause"), "{head}");
    for (own, expected) in [
        (
            &["--model", "r50", "--power-loss", "0.5"][..],
            "--power-loss: mettler-r50-hover: a linear model has no engine",
        ),
        (
            &["--model", "r50", "--fuel", "0.3"],
            "--fuel: mettler-r50-hover: a linear model has no mass",
        ),
        (&["--model", "r50", "--spread", "mass=0.1"], "--spread: found \"mass\", expected one of"),
        (&["--vehicle", "nowhere.toml"], "nowhere.toml"),
    ] {
        let message = refusal(&[&all[..], own].concat());
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn a_crashed_flight_is_listed_with_its_cause_and_recorded_on_request() {
    let out = place("campaign_crashes");
    let own = ["campaign", "--jams", "1", "--out", text(&out)];
    let words = succeeds(&[&own[..], &["--flights", "8"]].concat());
    let summary = summary(&out);
    let crash = &summary["crashes"][0];
    let (seed, cause) = (&crash["seed"].to_string(), crash["cause"].as_str().expect("a cause"));
    assert!(words.contains(&format!("crash of seed {seed}: {cause}")), "{words}");
    assert!(cause.contains("s after ") && cause.contains("jammed"), "{cause}");
    assert!(words.contains("lateral jams") && summary["failures"]["lateral jams"].is_object());
    let page = fs::read_to_string(out.join("report.html")).expect("a page");
    assert!(page.contains("<section id=\"crashes\">") && page.contains(cause));
    // The command that is printed and in the summary flies this seed again; the page names its option.
    let again = crash["again"].as_str().expect("a command");
    assert_eq!(again, format!("hovernav {} --record {seed}", own.join(" ")));
    assert!(words.contains(again), "{words}");
    assert!(page.contains("with --record SEED flies one again"));
    let again: Vec<&str> = again.split(' ').skip(1).chain(["--no-report"]).collect();
    let message = refusal(&again);
    let (what, _) = cause.split_once(" at ").expect("a time");
    assert!(message.contains("the vehicle crashed at") && message.contains(what), "{message}");
    assert!(out.join(format!("seed-{seed}")).join("reference.csv").exists());
}

#[test]
fn a_campaign_without_a_flight_to_evaluate_reports_it() {
    let out = place("campaign_none");
    // The autopilot of the large R-50 is too slow for a small helicopter.
    let own = ["campaign", "--model", "r50", "--vehicle", "raptor60", "--flights", "3"];
    let words = succeeds(&[&own[..], &["--no-report", "--out", text(&out)]].concat());
    assert_eq!(summary(&out)["outcomes"]["crashed"], 3, "{words}");
    assert!(words.contains("no flight lasted until the evaluation") && !words.contains("NaN"));
    assert!(words.contains("under the pilot"), "{words}");
}

#[test]
fn a_flight_without_judged_samples_or_fixes_is_not_called_good() {
    let dir = place("short_flight");
    let arguments = ["simulate", "--wind", "calm", "--no-report", "--duration"];
    let said = succeeds(&[&arguments[..], &["10", "--out", text(&dir)]].concat());
    assert!(said.contains("no statistics: the evaluation of the hover begins at 25 s"), "{said}");
    assert!(summary(&dir)["flight"]["velocity_rms_mps"].is_null());
    let truth = ["30", "--truth", "--outage", "0:1000", "--out", text(&dir)];
    succeeds(&[&arguments[..], &truth].concat());
    let verdict = &summary(&dir)["verdict"];
    assert_ne!(verdict["level"], "good", "{verdict}");
}

#[test]
fn a_flight_near_a_pole_is_rejected() {
    let run = hovernav(&["simulate", "--place", "89.9,0,50", "--no-report"]);
    let error = String::from_utf8(run.stderr).expect("text");
    assert_eq!(run.status.code(), Some(2), "{error}");
    assert!(error.contains("found latitude 89.9°, expected at most 89.8°"), "{error}");
}
