//! A page without a flight.

use std::f64::consts::TAU;

use crate::{Axis, Figure, Page, Role, Row, Section, Series, Table, TableRow};

/// The page's data.
fn data(page: &str) -> serde_json::Value {
    let (_, rest) = page.split_once("<script id=\"data\" type=\"application/json\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

/// A page with every kind of abscissa and of content, and no time axis.
#[test]
fn a_page_without_a_flight_has_axes_of_its_own() {
    let frequency: Vec<f64> = (0..200).map(|index| 0.01 * 1.05_f64.powi(index)).collect();
    let lag = |gain: f64| {
        frequency.iter().map(move |w| (*w, 20.0 * (gain / (1.0 + w * w).sqrt()).log10()))
    };
    let turn = |from: f64| (0..=60).map(move |step| from + f64::from(step) / 60.0 * TAU);
    let figure = Figure::against(
        Axis::logarithmic("Frequency", "rad/s"),
        [
            Row::new("Magnitude", "dB")
                .with(Series::curve(Role::Flight, lag(2.0)).named("Flight, coherent"))
                .with(Series::curve(Role::Model, lag(1.9)))
                .with(Series::curve(Role::Limit, [(0.01, -3.0), (160.0, -3.0)])),
            Row { limits: Some([0.0, 1.0]), ..Row::new("Coherence", "") }
                .with(Series::curve(Role::Flight, [(0.01, 0.9), (160.0, 0.2)])),
            Row::new("Nothing", "").with(Series::curve(Role::Model, [(f64::NAN, 0.0)])),
        ],
    );
    let poles = Figure::against(
        Axis::plane("Real part", "1/s"),
        [Row::new("Imaginary part", "1/s")
            .with(Series::curve(Role::Region, turn(0.0).map(|a| (a.cos() - 2.0, 0.5 * a.sin()))))
            .with(Series::points(Role::Pole, [(-2.0, 0.0)].into_iter()))],
    );
    let window = Figure::against(
        Axis::linear("Time", "s").within([10.0, 15.0]),
        [Row::new("Pedal", "").with(Series::curve(Role::Input, [(10.0, 0.0), (12.0, 0.1)]))],
    );
    let table = Table {
        caption: "Parameters <with> bounds".into(),
        heads: vec!["".into(), "Value".into(), "What it is".into()],
        rows: vec![TableRow::new("Nr", vec!["-5.1".into(), "yaw damping".into()])],
    };
    let page = Page {
        verdict: None,
        title: "A model",
        headlines: &[],
        warnings: &[],
        facts: &[],
        table: None,
        sections: vec![
            Section::new("response", "Response & model", "Both.").with(figure),
            Section::new("poles", "Poles", "Where they may be.")
                .with(poles.captioned("Before"))
                .with(window.captioned("After"))
                .with(table)
                .with(vec!["Lu dropped: <20 %".to_owned()]),
        ],
        time: None,
    };
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("axes.html");
    page.write(&path).unwrap();
    let page = std::fs::read_to_string(path).unwrap();
    let data = data(&page);
    let figures = data["figures"].as_array().unwrap();
    let names: Vec<&str> =
        figures.iter().map(|figure| figure["anchor"].as_str().unwrap()).collect();
    assert_eq!(names, ["response", "poles", "poles-2"]);
    assert!(names.iter().all(|name| page.contains(&format!("data-figure=\"{name}\""))));
    assert_eq!(figures[0]["rows"].as_array().unwrap().len(), 2);
    assert_eq!(figures[0]["abscissa"]["own"]["logarithmic"], true);
    assert_eq!(figures[1]["abscissa"]["own"]["to_scale"], true);
    assert!(data["time"].is_null() && !page.contains("All time axes move together"));
    for text in [
        "Response &amp; model",
        "Lu dropped: &lt;20 %",
        "&lt;with&gt;",
        "<h3>After</h3>",
        "<td>-5.1</td><td class=\"words\">yaw damping</td>",
        "aria-label=\"Poles, Before: Imaginary part, 1/s from",
    ] {
        assert!(page.contains(text), "{text}");
    }
}
