//! The closed loop: vehicle, servos, sensors, estimator and autopilot.

use std::path::Path;
use std::str::FromStr;
use std::time::Instant;

use anyhow::ensure;
use hovernav::autopilot::{HoverConfig, Transition};
use hovernav::frames::Vector;
use hovernav::time::Time;
use hovernav_log::{Outage, Reference, score};
use hovernav_sim::{
    Disturbance, Feedback, Flight, FlightConfig, FlightEvent, HorizontalVertical, HoverStatistics,
    WindConfig,
};
use serde::Serialize;

use super::{Arguments, OUT, page};
use crate::summary::Summary;

/// A disturbance, and when if it was told.
#[derive(Clone, Copy)]
pub struct Thrown {
    disturbance: Disturbance,
    at_s: Option<f64>,
}

impl FromStr for Thrown {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "found \"{text}\", expected NAME=VALUE or NAME=VALUE@SECOND with NAME one of p, q, r, \
                 phi, theta, psi, u, v, w"
            )
        };
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
        let (name, value) = text.split_once('=').ok_or_else(expected)?;
        let (value, at_s) = match value.split_once('@') {
            None => (value, None),
            Some((value, at)) => (value, Some(number(at).ok_or_else(expected)?)),
        };
        let value = number(value).ok_or_else(expected)?;
        let mut disturbance = Disturbance::default();
        let axis = |axis: usize| {
            let mut components = [0.0; 3];
            components[axis] = value;
            components
        };
        let vector = |at: usize| {
            let [x, y, z] = axis(at);
            Vector::new(x, y, z)
        };
        match name.trim() {
            "phi" => disturbance.attitude_rad = axis(0),
            "theta" => disturbance.attitude_rad = axis(1),
            "psi" => disturbance.attitude_rad = axis(2),
            "p" => disturbance.rate_radps = vector(0),
            "q" => disturbance.rate_radps = vector(1),
            "r" => disturbance.rate_radps = vector(2),
            "u" => disturbance.velocity_mps = vector(0),
            "v" => disturbance.velocity_mps = vector(1),
            "w" => disturbance.velocity_mps = vector(2),
            _ => return Err(expected()),
        }
        Ok(Self { disturbance, at_s })
    }
}

/// Wind as the command line tells it.
#[derive(Clone, Copy)]
pub struct Blowing(WindConfig);

impl FromStr for Blowing {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "calm" {
            return Ok(Self(WindConfig::calm()));
        }
        let parts: Option<Vec<f64>> = text
            .split(',')
            .map(|part| part.trim().parse::<f64>().ok().filter(|value| value.is_finite()))
            .collect();
        let (speed, from_deg, gust) = match parts.as_deref() {
            Some(&[speed]) => (speed, 0.0, 0.5 * speed),
            Some(&[speed, from_deg]) => (speed, from_deg, 0.5 * speed),
            Some(&[speed, from_deg, gust]) => (speed, from_deg, gust),
            _ => (-1.0, 0.0, 0.0),
        };
        if !(0.0..=50.0).contains(&speed) || !(0.0..=20.0).contains(&gust) {
            return Err(format!(
                "found \"{text}\", expected calm, or SPEED[,FROM[,GUST]] with 0 to 50 m/s, degrees, 0 \
                 to 20 m/s"
            ));
        }
        let (east, north) = from_deg.to_radians().sin_cos();
        Ok(Self(WindConfig {
            steady_mps: Vector::new(-speed * north, -speed * east, 0.0),
            gust_sigma_mps: HorizontalVertical::new(gust, 0.5 * gust),
            passing_mps: speed.max(1.0),
            ..WindConfig::default()
        }))
    }
}

/// From when on the hover is judged, s.
pub const JUDGED_FROM_S: f64 = 25.0;

/// What the closed loop did, beside what the filter did.
#[derive(Debug, Serialize)]
pub struct Flown {
    /// What the autopilot flew on.
    feedback: &'static str,
    /// When it crashed.
    crashed_s: Option<f64>,
    /// What it was doing at the end.
    last_mode: String,
    transitions: Vec<Change>,
    disturbances: Vec<Back>,
    judged_from_s: f64,
    velocity_rms_mps: [f64; 3],
    attitude_rms_deg: [f64; 2],
    heading_worst_deg: f64,
    position_rms_m: [f64; 3],
    sticks_rms: [f64; 4],
}

#[derive(Debug, Serialize)]
pub struct Change {
    pub time_s: f64,
    pub from: String,
    pub to: String,
    pub reason: String,
}

#[derive(Debug, Serialize)]
pub struct Back {
    pub time_s: f64,
    /// Steepest tilt and fastest motion in the 20 s after it.
    pub tilt_worst_deg: f64,
    pub speed_worst_mps: f64,
}

impl Flown {
    fn new(config: &FlightConfig, flight: &Flight) -> Self {
        let held = flight.statistics(JUDGED_FROM_S);
        let HoverStatistics { velocity_rms_mps, attitude_rms_deg, position_rms_m, .. } = held;
        let change = |change: &Transition| Change {
            time_s: change.time.seconds(),
            from: format!("{:?}", change.from).to_lowercase(),
            to: format!("{:?}", change.to).to_lowercase(),
            reason: format!("{:?}", change.reason).to_lowercase(),
        };
        let thrown =
            config.events.iter().filter(|(_, order)| !matches!(order, FlightEvent::AddSticks(_)));
        let thrown = thrown.map(|(at_s, _)| {
            let after = flight.samples.iter().map(|sample| sample.truth);
            let after = after.filter(|truth| (0.0..20.0).contains(&(truth.time.seconds() - at_s)));
            let worst = after.fold((0.0, 0.0), |(tilt, speed), truth| {
                let angles = truth.body_to_ned.euler();
                let tilted = angles.roll_rad.hypot(angles.pitch_rad).to_degrees();
                (f64::max(tilt, tilted), f64::max(speed, truth.velocity_mps.norm()))
            });
            Back { time_s: *at_s, tilt_worst_deg: worst.0, speed_worst_mps: worst.1 }
        });
        Self {
            feedback: match config.feedback {
                Feedback::Estimator => "estimator",
                Feedback::Truth => "truth",
            },
            crashed_s: flight.crashed_s,
            last_mode: flight
                .samples
                .last()
                .map_or_else(|| "none".into(), |last| format!("{:?}", last.mode).to_lowercase()),
            transitions: flight.transitions.iter().map(change).collect(),
            disturbances: thrown.collect(),
            judged_from_s: JUDGED_FROM_S,
            velocity_rms_mps,
            attitude_rms_deg,
            heading_worst_deg: held.heading_worst_deg,
            position_rms_m,
            sticks_rms: held.sticks_rms,
        }
    }

    pub fn transitions(&self) -> &[Change] {
        &self.transitions
    }

    /// The hover in a line.
    pub fn in_words(&self) -> String {
        if let Some(crashed_s) = self.crashed_s {
            return format!("crashed at {crashed_s:.2} s");
        }
        let [u, v, w] = self.velocity_rms_mps;
        let [roll, pitch] = self.attitude_rms_deg;
        let [north, east, down] = self.position_rms_m;
        format!(
            "from {:.0} s on: u, v, w {u:.2}, {v:.2}, {w:.2} m/s, roll, pitch {roll:.1}°, {pitch:.1}°, \
             position {north:.1}, {east:.1}, {down:.1} m RMS, heading within {:.1}°",
            self.judged_from_s, self.heading_worst_deg
        )
    }
}

/// The flight that the arguments ask for.
fn config(arguments: &Arguments, warnings: &mut Vec<String>) -> anyhow::Result<FlightConfig> {
    let autopilot = match &arguments.autopilot {
        Some(path) => hovernav_log::read_autopilot(path)?,
        None => {
            let model = crate::model::open(arguments.model.as_deref().unwrap_or("raptor60"))?;
            if model.name() != "raptor60-hover" {
                warnings.push(format!(
                    "the autopilot is designed for {}, what flies is the nonlinear 60-class helicopter",
                    model.name()
                ));
            }
            let design = crate::design::design_for(&model);
            HoverConfig::new(design.period_s, design.synthesise(&model)?)
        }
    };
    let mut config = FlightConfig::new(autopilot);
    (config.dmu, config.gps) = arguments.sensors.sensors();
    config.dmu.rate_hz = 1.0 / autopilot.period_s;
    config.gps.outages_s.extend(arguments.outage.iter().map(|window| {
        let Outage { start, duration_s } = window.outage();
        start.seconds()..start.seconds() + duration_s
    }));
    if let Some(Blowing(wind)) = arguments.wind {
        config.wind = wind;
    }
    if arguments.truth {
        config.feedback = Feedback::Truth;
    }
    config.start = arguments.place;
    config.heading_rad = arguments.heading.to_radians();
    config.seed = arguments.seed;
    for (at, thrown) in arguments.disturbance.iter().enumerate() {
        let at_s = thrown.at_s.unwrap_or(30.0 + 20.0 * at as f64);
        let order = if arguments.truth { FlightEvent::Disturb } else { FlightEvent::Push };
        config.events.push((at_s, order(thrown.disturbance)));
    }
    if let Some(size) = arguments.test_points {
        // A pilot flies test points, not an autopilot that jumps with each fix.
        config.feedback = Feedback::Truth;
        config.events = FlightEvent::test_points(30.0, size);
    }
    config.events.sort_by(|(one, _), (other, _)| one.total_cmp(other));
    let last_s = config.events.last().map(|(at_s, _)| *at_s);
    config.duration_s = arguments.duration.unwrap_or(last_s.map_or(120.0, |last| last + 30.0));
    if let Some(last_s) = last_s {
        let what = if arguments.test_points.is_some() { "test point" } else { "disturbance" };
        ensure!(
            last_s < config.duration_s && config.events[0].0 >= 0.0,
            "{what} at {last_s} s: found a flight of {} s, expected it to happen within",
            config.duration_s
        );
    }
    Ok(config)
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    let mut warnings = Vec::new();
    let config = config(arguments, &mut warnings)?;
    let flight = config.fly()?;
    let out = arguments.out.clone().unwrap_or_else(|| OUT.into());
    let (mut dataset, truth) = flight.dataset();
    dataset.write(&out, &truth)?;

    let settings = dataset.settings()?;
    let run = dataset.estimate(&settings, |_| {});
    let flown = Flown::new(&config, &flight);
    let described = Path::new(&dataset.manifest.vehicle).to_path_buf();
    let mut summary = Summary::new(&described, &dataset, &run, false);
    summary.warnings.extend(warnings);
    if let Some(crashed_s) = flight.crashed_s {
        summary.warnings.push(format!("the vehicle crashed at {crashed_s:.2} s"));
    }
    let reference = Reference::open(&out, &dataset.manifest)?;
    let scored = reference.as_ref().map(|reference| score(&run.solutions, reference, Time::ZERO));
    summary.set_scores(scored.as_ref(), Vec::new());
    println!("{}", flown.in_words());
    if !arguments.no_report {
        let shown = page::Shown {
            config: &config,
            flight: &flight,
            flown: &flown,
            dataset: &dataset,
            run: &run,
            reference: reference.as_ref(),
            score: scored.as_ref(),
            summary: &summary,
        };
        page::write(&out.join("report.html"), &shown)?;
    }
    summary.flight = Some(flown);
    summary.wall_s = started.elapsed().as_secs_f64();
    summary.write(&out.join("summary.json"))?;
    print!("{}", summary.in_words(&out));
    Ok(())
}
