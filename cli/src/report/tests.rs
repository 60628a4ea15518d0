//! The page as a whole, on a flight of sines and noise.

use std::f64::consts::TAU;

use hovernav::earth::Geodetic;
use hovernav::ekf::{Channel, Verdict};
use hovernav::frames::{EulerAngles, Ned, Rotation, Vector, wrap_angle};
use hovernav_log::{Axis, AxisScore, ErrorPoint, Statistics};

use super::page::{Page, Section, Table, TableRow};
use super::series::{Figure, Role, Row, Series};
use super::*;

/// Normal numbers, the same on every run: the sum of twelve uniform ones (Knuth's generator).
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    fn vector<F>(&mut self, sigma: f64) -> Vector<F> {
        Vector::new(self.normal(), self.normal(), self.normal()) * sigma
    }
}

fn outage(start_s: f64, duration_s: f64) -> Outage {
    Outage { start: Time::from_seconds(start_s).unwrap(), duration_s }
}

/// A flight, as the filter, its sensors and a reference might have seen it.
#[derive(Default)]
struct Flight {
    solutions: Vec<Solution>,
    smoothed: Vec<Solution>,
    fixes: Vec<Fix>,
    innovations: Vec<Innovation>,
    reference: Vec<(Time, ReferenceMoment)>,
    score: Option<Score>,
    outages: Vec<Outage>,
}

fn truth(t: f64) -> (Vector<Ned>, Vector<Ned>, EulerAngles) {
    let at = |t: f64| {
        let climb = 25.0 / (1.0 + (-(t - 60.0) / 8.0).exp());
        Vector::new(60.0 * (t / 23.0).sin(), 40.0 * (t / 31.0).cos() + 0.1 * t, -climb)
    };
    let velocity = (at(t + 0.01) - at(t - 0.01)) * 50.0;
    let attitude = EulerAngles {
        roll_rad: 0.12 * (t / 4.0).sin() + 0.03 * (t * 1.3).sin(),
        pitch_rad: -0.05 + 0.09 * (t / 5.3).cos(),
        yaw_rad: wrap_angle(t / 40.0),
    };
    (at(t), velocity, attitude)
}

fn fly(duration_s: f64, rate_hz: f64) -> Flight {
    let origin = Geodetic::from_degrees(46.123_456, 8.654_321, 312.0).unwrap();
    let place = |offset| Geodetic::from_local_ned(&origin, offset).unwrap();
    let mut noise = Noise(7);
    let mut flight = Flight {
        outages: vec![
            outage(0.4 * duration_s, 0.05 * duration_s),
            outage(0.7 * duration_s, 0.1 * duration_s),
        ],
        ..Flight::default()
    };
    let mut errors: Vec<[[f64; 3]; 3]> = Vec::new();
    let (mut position_error, mut velocity_error) = (Vector::<Ned>::ZERO, Vector::<Ned>::ZERO);
    let mut last_fix_s = 0.0;
    let mut next_fix_s = 0.0;
    for sample in 0..(duration_s * rate_hz) as usize {
        let t = sample as f64 / rate_hz;
        let time = Time::from_seconds(t).unwrap();
        let (position, velocity, attitude) = truth(t);
        let age = t - last_fix_s;
        let position_sigma = 0.5 + 0.9 * (-t / 4.0).exp() + 0.1 * age + 0.01 * age * age;
        let velocity_sigma = 0.12 + 0.6 * (-t / 6.0).exp() + 0.02 * age;
        let attitude_sigma = [0.3, 0.3, 0.9 + 6.0 * (-t / 30.0).exp()].map(f64::to_radians);
        position_error = position_error * 0.999 + noise.vector(0.045 * position_sigma);
        velocity_error = velocity_error * 0.999 + noise.vector(0.045 * velocity_sigma);
        let attitude_error = [0, 1, 2].map(|axis| {
            0.8 * attitude_sigma[axis] * (t / (7.0 + axis as f64)).sin() + 1e-4 * noise.normal()
        });
        let estimated = EulerAngles {
            roll_rad: attitude.roll_rad + attitude_error[0],
            pitch_rad: attitude.pitch_rad + attitude_error[1],
            yaw_rad: wrap_angle(attitude.yaw_rad + attitude_error[2]),
        };
        let learnt = 1.0 - (-t / 40.0).exp();
        let solution = Solution {
            time,
            position: place(position + position_error),
            velocity_mps: velocity + velocity_error,
            body_to_ned: Rotation::from_euler(estimated),
            angular_rate_radps: noise.vector(0.01),
            position_sigma_m: Vector::new(1.0, 1.0, 1.6) * position_sigma,
            velocity_sigma_mps: Vector::new(1.0, 1.0, 1.3) * velocity_sigma,
            attitude_sigma_rad: attitude_sigma,
            gyro_bias_radps: Vector::new(0.004, -0.003, 0.002) * learnt + noise.vector(2e-5),
            accel_bias_mps2: Vector::new(0.06, -0.09, 0.03) * learnt + noise.vector(4e-4),
            gyro_bias_sigma_radps: Vector::new(1.0, 1.0, 1.5) * (3e-4 + 4e-3 * (-t / 40.0).exp()),
            accel_bias_sigma_mps2: Vector::new(1.0, 1.0, 0.4) * (0.02 + 0.08 * (-t / 40.0).exp()),
        };
        let smooth = Solution {
            position: place(position + position_error * 0.4),
            velocity_mps: velocity + velocity_error * 0.4,
            ..solution
        };
        if t >= next_fix_s {
            next_fix_s += 1.0;
            if !flight.outages.iter().any(|outage| outage.covers(time)) {
                last_fix_s = t;
                fix(&mut flight, &mut noise, &solution, position, velocity, place);
            }
        }
        flight.solutions.push(solution);
        flight.smoothed.push(smooth);
        let place = place(position);
        flight.reference.push((
            time,
            ReferenceMoment {
                position: [place.latitude_rad, place.longitude_rad, place.height_m],
                velocity_mps: velocity.to_array(),
                attitude_rad: [attitude.roll_rad, attitude.pitch_rad, attitude.yaw_rad],
                body_velocity_mps: (Rotation::from_euler(attitude).inverse() * velocity).to_array(),
            },
        ));
        let attitude_error_deg = attitude_error.map(f64::to_degrees);
        errors.push([position_error.to_array(), velocity_error.to_array(), attitude_error_deg]);
    }
    flight.score = Some(scored(&errors, &flight.solutions));
    flight
}

fn scored(errors: &[[[f64; 3]; 3]], solutions: &[Solution]) -> Score {
    use Axis::{Down, East, North, Pitch, Roll, VelocityDown, VelocityEast, VelocityNorth, Yaw};
    let groups =
        [[North, East, Down], [VelocityNorth, VelocityEast, VelocityDown], [Roll, Pitch, Yaw]];
    let axes = groups.into_iter().enumerate().flat_map(|(group, axes)| {
        (0..3).map(move |component| {
            let points = errors.iter().zip(solutions).map(|(error, solution)| {
                let sigma = match group {
                    0 => solution.position_sigma_m.to_array(),
                    1 => solution.velocity_sigma_mps.to_array(),
                    _ => solution.attitude_sigma_rad.map(f64::to_degrees),
                };
                let (error, sigma) = (error[group][component], Some(sigma[component]));
                ErrorPoint { time: solution.time, error, sigma }
            });
            let series: Vec<ErrorPoint> = points.collect();
            let errors: Vec<f64> = series.iter().map(|point| point.error).collect();
            AxisScore {
                axis: axes[component],
                statistics: Statistics::of(&errors).unwrap(),
                samples: errors.len(),
                within_3_sigma: Some(0.987),
                series,
            }
        })
    });
    Score { from: Time::ZERO, axes: axes.collect() }
}

/// Pushes a noisy fix and its six innovations; now and then one far off, which is refused.
fn fix(
    flight: &mut Flight,
    noise: &mut Noise,
    solution: &Solution,
    position: Vector<Ned>,
    velocity: Vector<Ned>,
    place: impl Fn(Vector<Ned>) -> Geodetic,
) {
    let number = flight.fixes.len();
    let (offset, verdict) = match number % 97 {
        40 => (Vector::new(35.0, -60.0, 12.0), Verdict::Rejected),
        80 => (Vector::new(9.0, 9.0, 14.0), Verdict::Reopened),
        _ => (Vector::ZERO, Verdict::Accepted),
    };
    let speed = velocity + noise.vector(0.15);
    flight.fixes.push(Fix {
        horizontal_velocity_mps: Some([speed.x(), speed.y()]),
        down_velocity_mps: Some(speed.z()),
        satellites: Some(9),
        ..Fix::at(solution.time, place(position + offset + noise.vector(1.0)))
    });
    let position_sigma = solution.position_sigma_m.to_array().map(|sigma| sigma.hypot(1.2));
    let velocity_sigma = solution.velocity_sigma_mps.to_array().map(|sigma| sigma.hypot(0.2));
    let channels = [
        (Channel::PositionNorth, position_sigma[0], offset.x(), verdict),
        (Channel::PositionEast, position_sigma[1], offset.y(), verdict),
        (Channel::PositionDown, position_sigma[2], offset.z(), verdict),
        (Channel::VelocityNorth, velocity_sigma[0], 0.0, Verdict::Accepted),
        (Channel::VelocityEast, velocity_sigma[1], 0.0, Verdict::Accepted),
        (Channel::VelocityDown, velocity_sigma[2], 0.0, Verdict::Accepted),
    ];
    flight.innovations.extend(channels.map(|(channel, sigma, far, verdict)| Innovation {
        time: solution.time,
        channel,
        innovation: far + sigma * noise.normal(),
        sigma,
        verdict,
    }));
}

impl Flight {
    fn report(&self) -> Report<'_> {
        Report {
            title: "A flight of sines",
            outages: &self.outages,
            solutions: &self.solutions,
            smoothed: &self.smoothed,
            fixes: &self.fixes,
            innovations: &self.innovations,
            reference: &self.reference,
            score: self.score.as_ref(),
            ..Report::default()
        }
    }
}

/// Writes the page to a file and reads it back.
fn written(report: &Report<'_>) -> String {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("report.html");
    write(&path, report).unwrap();
    std::fs::read_to_string(path).unwrap()
}

/// The page without the drawing script that it carries, which is not ours.
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
    let report =
        Report { headlines: &headlines, facts: &facts, warnings: &warnings, ..flight.report() };
    let page = written(&report);
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
    let page = written(&fly(20.0, 33.0).report());
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
fn names_and_warnings_cannot_become_markup() {
    let evil = "</script><script>alert('&')</script><img src=x onerror=alert(1)>{{data}}";
    let fact = [Fact::new(evil, evil)];
    let flight = fly(5.0, 10.0);
    let report = Report {
        title: evil,
        headlines: &fact,
        facts: &fact,
        warnings: &[evil.to_owned()],
        ..flight.report()
    };
    let page = written(&report);
    assert!(!page.contains("<script>alert") && !page.contains("<img"));
    assert_eq!(page.matches("</script>").count(), 3);
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
    let page = written(&flight.report());
    let data = data(&page);
    let text = data.to_string();
    assert!(text.contains("null") && !text.contains("NaN") && !text.contains("inf"));
    assert_eq!(data["time"]["outages"].as_array().unwrap().len(), 2);
    assert!(roles(&data, "position").contains(&"estimate"));
}

#[test]
fn whatever_is_missing_the_page_is_still_a_page() {
    let whole = fly(20.0, 33.0);
    let report = whole.report();
    let cases = [
        ("nothing", Report::default()),
        ("no-innovations", Report { innovations: &[], ..report }),
        ("no-fixes", Report { fixes: &[], innovations: &[], ..report }),
        ("no-reference", Report { reference: &[], score: None, smoothed: &[], ..report }),
        ("no-solution", Report { solutions: &[], smoothed: &[], ..report }),
        (
            "single-sample",
            Report {
                solutions: &whole.solutions[..1],
                smoothed: &[],
                fixes: &whole.fixes[..1],
                innovations: &whole.innovations[..1],
                reference: &whole.reference[..1],
                score: None,
                outages: &[],
                ..report
            },
        ),
    ];
    for (name, report) in cases {
        let page = written(&report);
        data(&page);
        for anchor in ALWAYS {
            assert!(page.contains(&format!("<section id=\"{anchor}\">")), "{anchor} in {name}");
        }
        assert_eq!(page.contains("<section id=\"errors\">"), report.score.is_some(), "{name}");
    }
}

#[test]
fn ten_minutes_at_a_hundred_hertz_stay_under_three_megabytes() {
    let flight = fly(600.0, 100.0);
    let page = written(&flight.report());
    let (before, after) = own(&page);
    assert!(before.len() + after.len() < 3_000_000, "{}", before.len() + after.len());
}

#[test]
fn a_path_that_cannot_be_written_is_named() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("no-such-directory/report.html");
    let error = write(&path, &Report::default()).unwrap_err();
    assert!(error.to_string().contains("no-such-directory"));
}

/// A page with every kind of abscissa and of part, and no time axis.
#[test]
fn a_page_without_a_flight_has_axes_of_its_own() {
    let frequency: Vec<f64> = (0..200).map(|index| 0.01 * 1.05_f64.powi(index)).collect();
    let lag = |gain: f64| {
        frequency.iter().map(move |w| (*w, 20.0 * (gain / (1.0 + w * w).sqrt()).log10()))
    };
    let turn = |from: f64| (0..=60).map(move |step| from + f64::from(step) / 60.0 * TAU);
    let figure = Figure::against(
        series::Axis::logarithmic("Frequency", "rad/s"),
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
        series::Axis::plane("Real part", "1/s"),
        [Row::new("Imaginary part", "1/s")
            .with(Series::curve(Role::Region, turn(0.0).map(|a| (a.cos() - 2.0, 0.5 * a.sin()))))
            .with(Series::points(Role::Pole, [(-2.0, 0.0)].into_iter()))],
    );
    let window = Figure::against(
        series::Axis::linear("Time", "s").within([10.0, 15.0]),
        [Row::new("Pedal", "").with(Series::curve(Role::Input, [(10.0, 0.0), (12.0, 0.1)]))],
    );
    let table = Table {
        caption: "Parameters <with> bounds".into(),
        heads: vec!["".into(), "Value".into()],
        rows: vec![TableRow { name: "Nr".into(), numbers: vec!["-5.1".into()] }],
    };
    let page = Page {
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
    for text in ["Response &amp; model", "Lu dropped: &lt;20 %", "&lt;with&gt;", "<h3>After</h3>"] {
        assert!(page.contains(text), "{text}");
    }
}
