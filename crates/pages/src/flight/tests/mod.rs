//! The page of a flight as a whole.

mod synthetic;

use hovernav::ekf::Solution;
use hovernav::frames::Vector;
use hovernav::time::Time;
use hovernav_dataset::Outage;
use hovernav_formats::{Onboard, OnboardMoment};
use hovernav_score::Verdict;

use self::synthetic::fly;
use super::data::FlightData;
use super::sections::page;
use crate::Fact;

/// Writes the page to a file and reads it back.
fn written(shown: &FlightData<'_>) -> String {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("report.html");
    page(shown).write(&path).unwrap();
    std::fs::read_to_string(path).unwrap()
}

/// The page without the third-party plotting script in it.
fn own(page: &str) -> (&str, &str) {
    let start = page.find("/**\n* plotly.js").expect("the page carries plotly.js");
    let end = start + page[start..].find("</script>").unwrap();
    (&page[..start], &page[end..])
}

/// The page's data.
fn data(page: &str) -> serde_json::Value {
    let (_, rest) = page.split_once("<script id=\"data\" type=\"application/json\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

fn roles<'d>(data: &'d serde_json::Value, anchor: &str) -> Vec<&'d str> {
    let figures = data["figures"].as_array().unwrap();
    let figure = figures.iter().find(|figure| figure["anchor"] == anchor).expect(anchor);
    let rows = figure["rows"].as_array().unwrap();
    let series = rows.iter().flat_map(|row| row["series"].as_array().unwrap());
    series.map(|series| series["role"].as_str().unwrap()).collect()
}

/// The ordinates of each series of a role.
fn lines_of(data: &serde_json::Value, anchor: &str, role: &str) -> Vec<Vec<serde_json::Value>> {
    let figures = data["figures"].as_array().unwrap();
    let figure = figures.iter().find(|figure| figure["anchor"] == anchor).expect(anchor);
    let rows = figure["rows"].as_array().unwrap();
    let series = rows.iter().flat_map(|row| row["series"].as_array().unwrap());
    let of_role = series.filter(|series| series["role"] == role);
    of_role.map(|series| series["y"].as_array().unwrap().clone()).collect()
}

const ALWAYS: [&str; 8] =
    ["map", "position", "velocity", "body-velocity", "attitude", "biases", "innovations", "test"];

#[test]
fn a_whole_flight_fills_every_section() {
    let flight = fly(300.0, 33.0);
    let headlines = [
        Fact::new("Duration", "300.0 s"),
        Fact::new("Fixes used", "252"),
        Fact::new("Fixes rejected", "3"),
        Fact::new("Horizontal RMSE", "0.64 m"),
        Fact::new("Velocity RMSE north / east / down", "0.052 / 0.055 / 0.061 m/s"),
        Fact::new("Roll / pitch / yaw RMSE", "0.21 / 0.20 / 0.94 °"),
    ];
    let facts = [
        Fact::new("Input", "flights/2026-07-14-hover-test-points"),
        Fact::new("Inertial samples", "9900 at 33.0 Hz"),
        Fact::new("GPS", "255 fixes at 1.0 Hz"),
        Fact::new("Alignment", "levelled at rest for 12.4 s; heading from the unit, ±2.1°"),
        Fact::new("Point of the solution", "centre of gravity"),
    ];
    let warnings = [
        "3 fixes lay outside the gate of 5σ and were not used".to_owned(),
        "GPS withheld for 15.0 s from 120.0 s on, as asked".to_owned(),
    ];
    let shown =
        FlightData { headlines: &headlines, facts: &facts, warnings: &warnings, ..flight.data() };
    let page = written(&shown);
    let data = data(&page);
    for anchor in ALWAYS.into_iter().chain(["errors"]) {
        assert!(page.contains(&format!("<section id=\"{anchor}\">")), "{anchor}");
        assert!(page.contains(&format!("data-figure=\"{anchor}\"")), "{anchor}");
        assert!(!roles(&data, anchor).is_empty(), "{anchor}");
    }
    for anchor in ["map", "position", "velocity", "body-velocity", "attitude"] {
        for role in ["estimate", "smoothed", "reference"] {
            assert!(roles(&data, anchor).contains(&role), "{role} in {anchor}");
        }
    }
    for anchor in ["map", "position"] {
        assert!(
            roles(&data, anchor).contains(&"gps") && roles(&data, anchor).contains(&"gps_rejected")
        );
    }
    for role in ["innovation", "rejected", "reopened", "bound"] {
        assert!(roles(&data, "innovations").contains(&role), "{role}");
    }
    for text in [
        "Velocity north, m/s",
        "98.7 % inside",
        "0.64 m",
        "levelled at rest",
        "withheld for 15.0 s",
    ] {
        assert!(page.contains(text), "{text}");
    }
}

#[test]
fn the_page_loads_nothing_from_elsewhere() {
    let page = written(&fly(20.0, 33.0).data());
    let (before, after) = own(&page);
    for own in [before, after] {
        for reference in ["http:", "https:", "src=", "@import", "url(", "fetch(", "<link"] {
            assert!(!own.contains(reference), "{reference}");
        }
    }
    assert!(before.contains("default-src 'none'"));
    assert!(after.contains("showSendToCloud: false, plotlyServerURL: \"\""));
    assert_eq!(page.matches("</script>").count(), 3);
}

#[test]
fn an_onboard_solution_in_messages_of_one_quantity_each_is_drawn_as_lines() {
    let flight = fly(20.0, 33.0);
    let moment = |(number, solution): (usize, &Solution)| {
        let at = OnboardMoment::at(solution.time);
        if number % 2 == 0 {
            OnboardMoment { position: Some(solution.position), ..at }
        } else {
            OnboardMoment { velocity_mps: Some(solution.velocity_mps), ..at }
        }
    };
    let moments = flight.solutions.iter().enumerate().map(moment).collect();
    let onboard = Onboard { moments, ..Onboard::default() };
    let page = written(&FlightData { onboard: Some(&onboard), ..flight.data() });
    let data = data(&page);
    for (anchor, rows) in [("map", 1), ("position", 3), ("velocity", 3)] {
        let lines = lines_of(&data, anchor, "onboard");
        assert_eq!(lines.len(), rows, "{anchor}");
        for line in lines {
            assert!(line.len() > 300 && line.iter().all(|value| value.is_number()), "{anchor}");
        }
    }
}

#[test]
fn names_and_warnings_cannot_become_markup() {
    let evil = "</script><script>alert('&')</script><img src=x onerror=alert(1)>{{data}}";
    let fact = [Fact::new(evil, evil)];
    let flight = fly(5.0, 10.0);
    let warnings = [evil.to_owned()];
    let verdict = Verdict::of_run(&[], &warnings, &[]);
    let shown = FlightData {
        title: evil,
        verdict: Some(&verdict),
        headlines: &fact,
        facts: &fact,
        warnings: &warnings,
        ..flight.data()
    };
    let page = written(&shown);
    assert!(!page.contains("<script>alert") && !page.contains("<img"));
    assert_eq!(page.matches("</script>").count(), 3);
    // The verdict states the warning; the list of warnings does not repeat it.
    assert_eq!(page.matches("&lt;/script&gt;&lt;script&gt;alert(&#39;&amp;&#39;)").count(), 7);
    assert_eq!(page.matches("{{data}}").count(), 7);
}

#[test]
fn unknown_numbers_are_written_as_null() {
    let mut flight = fly(20.0, 33.0);
    flight.solutions[0].position.latitude_rad = f64::NAN;
    flight.solutions[100].position.height_m = f64::NAN;
    flight.solutions[200].velocity_mps = Vector::new(f64::INFINITY, f64::NEG_INFINITY, f64::NAN);
    flight.solutions[300].position_sigma_m = Vector::new(f64::NAN, f64::INFINITY, 1.0);
    flight.fixes[3].position.latitude_rad = f64::NAN;
    flight.innovations[0].innovation = f64::NAN;
    flight.innovations[1].sigma = 0.0;
    let score = flight.score.as_mut().unwrap();
    score.axes[0].series[50].error = f64::NAN;
    score.axes[1].series[51].sigma = None;
    score.axes[2].statistics.rmse = f64::NAN;
    flight.reference[60].1.position = [f64::NAN; 3];
    flight.outages.push(Outage { start: Time::ZERO, duration_s: f64::NAN });
    let page = written(&flight.data());
    let data = data(&page);
    let text = data.to_string();
    assert!(text.contains("null") && !text.contains("NaN") && !text.contains("inf"));
    assert_eq!(data["time"]["outages"].as_array().unwrap().len(), 2);
    assert!(roles(&data, "position").contains(&"estimate"));
}

#[test]
fn whatever_is_missing_the_page_is_still_a_page() {
    let whole = fly(20.0, 33.0);
    let shown = whole.data();
    let cases = [
        ("nothing", FlightData::default()),
        ("no-innovations", FlightData { innovations: &[], ..shown }),
        ("no-fixes", FlightData { fixes: &[], innovations: &[], ..shown }),
        ("no-reference", FlightData { reference: &[], score: None, smoothed: &[], ..shown }),
        ("no-solution", FlightData { solutions: &[], smoothed: &[], ..shown }),
        (
            "single-sample",
            FlightData {
                solutions: &whole.solutions[..1],
                smoothed: &[],
                fixes: &whole.fixes[..1],
                innovations: &whole.innovations[..1],
                reference: &whole.reference[..1],
                score: None,
                outages: &[],
                ..shown
            },
        ),
    ];
    for (name, shown) in cases {
        let page = written(&shown);
        data(&page);
        for anchor in ALWAYS {
            assert!(page.contains(&format!("<section id=\"{anchor}\">")), "{anchor} in {name}");
        }
        assert_eq!(page.contains("<section id=\"errors\">"), shown.score.is_some(), "{name}");
    }
}

#[test]
fn ten_minutes_at_a_hundred_hertz_stay_under_three_megabytes() {
    let flight = fly(600.0, 100.0);
    let page = written(&flight.data());
    let (before, after) = own(&page);
    assert!(before.len() + after.len() < 3_000_000, "{}", before.len() + after.len());
}

#[test]
fn a_path_that_cannot_be_written_is_named() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("no-such-directory/report.html");
    let error = page(&FlightData::default()).write(&path).unwrap_err();
    assert!(error.to_string().contains("no-such-directory"));
}
