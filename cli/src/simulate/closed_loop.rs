//! The closed loop: vehicle, servos, sensors, estimator and autopilot.

use std::path::Path;
use std::time::Instant;

use anyhow::{bail, ensure};
use hovernav::autopilot::{GuidanceConfig, HoverConfig, SetPoint};
use hovernav_dataset::Outage;
use hovernav_design::hover::HoverDesign;
use hovernav_model::shipped;
use hovernav_sim::{Feedback, FlightConfig, FlightEvent};

use super::arguments::{Arguments, OUT, WindArgument};
use super::estimate::Estimate;
use super::page::SimulationPage;
use super::summary::{ClosedLoopSummary, Summary};
use super::{excitation, velocity};
use crate::arguments::{FORCED, HELICOPTER, designed_for_another, flown, refuse_unflyable};
use crate::output;
use crate::summary::InWords as _;

/// Fraction of the progress bar for the flight itself.
const FLYING: f64 = 0.75;

/// The flight configuration of the arguments.
fn config(arguments: &Arguments, warnings: &mut Vec<String>) -> anyhow::Result<FlightConfig> {
    let flown = flown(arguments.vehicle.as_deref(), arguments.model.as_deref())?;
    let autopilot = match &arguments.autopilot {
        Some(path) => hovernav_record::read_autopilot(path)?,
        None => {
            let name = arguments.model.as_deref().unwrap_or(HELICOPTER);
            let model = shipped::open(name)?;
            refuse_unflyable(&model, name, FORCED)?;
            warnings.extend(designed_for_another(&model, flown.as_ref()));
            let design = HoverDesign::for_model(&model);
            HoverConfig::new(design.period_s, design.synthesise(&model)?)
        }
    };
    let mut config = FlightConfig::new(autopilot);
    config.model = flown;
    (config.dmu, config.gps) = arguments.sensors.sensors();
    config.dmu.rate_hz = 1.0 / autopilot.period_s;
    config.gps.outages_s.extend(arguments.outage.iter().map(|window| {
        let Outage { start, duration_s } = window.outage();
        start.seconds()..start.seconds() + duration_s
    }));
    if let Some(WindArgument(wind)) = arguments.wind {
        config.wind = wind;
    }
    if arguments.truth {
        config.feedback = Feedback::Truth;
    }
    config.start_at(arguments.place);
    config.heading_rad = arguments.heading.to_radians();
    config.seed = arguments.seed;
    for (at, disturbance) in arguments.disturbance.iter().enumerate() {
        let at_s = disturbance.at_s.unwrap_or(30.0 + 20.0 * at as f64);
        let event = if arguments.truth { FlightEvent::Disturb } else { FlightEvent::Push };
        config.events.push((at_s, event(disturbance.disturbance)));
    }
    if let Some(size) = arguments.test_points {
        // Test points are flown by a pilot. The autopilot on estimates would react to every fix.
        config.feedback = Feedback::Truth;
        config.events = FlightEvent::test_points(30.0, size);
    }
    config.events.extend(excitation::events(&arguments.excite));
    config.events.extend(velocity::events(&arguments.velocity));
    refuse_too_fast(&config)?;
    config.events.extend(arguments.fault.iter().map(|fault| (fault.at_s, fault.event)));
    config.events.sort_by(|(one, _), (other, _)| one.total_cmp(other));
    let ends = config.events.iter().map(|(at_s, event)| match event {
        FlightEvent::Excite(excitation) => {
            (at_s + excitation.maneuver.duration_s(), "end of a test input")
        }
        FlightEvent::AddSticks(_) => (*at_s, "test point"),
        FlightEvent::Jam(_) | FlightEvent::PowerLoss => (*at_s, "fault"),
        FlightEvent::SetPoint(_) => (*at_s, "set-point"),
        _ => (*at_s, "disturbance"),
    });
    let last = ends.max_by(|(one, _), (other, _)| one.total_cmp(other));
    let by_itself_s = last.map_or(120.0, |(last_s, _)| last_s + 30.0);
    config.duration_s = arguments.duration.unwrap_or(by_itself_s);
    if let Some((last_s, what)) = last {
        ensure!(
            last_s < config.duration_s,
            "{what} at {last_s} s: found a flight of {} s, expected the event before its end",
            config.duration_s
        );
    }
    Ok(config)
}

/// Rejects a set-point that is faster than the autopilot's own limits.
fn refuse_too_fast(config: &FlightConfig) -> anyhow::Result<()> {
    let GuidanceConfig { speed_mps, climb_mps, yaw_rate_radps, .. } = config.autopilot.guidance;
    for (at_s, event) in &config.events {
        let FlightEvent::SetPoint(SetPoint::Velocity {
            forward_mps,
            right_mps,
            down_mps,
            yaw_rate_radps: turn_radps,
        }) = event
        else {
            continue;
        };
        ensure!(
            *at_s > config.engage_s,
            "set-point at {at_s} s: found a set-point before the autopilot engages at {} s, expected one after it",
            config.engage_s
        );
        for (name, found, limit, unit, key) in [
            ("a speed", forward_mps.hypot(*right_mps), speed_mps, "m/s", "speed_mps"),
            ("a climb or sink rate", down_mps.abs(), climb_mps, "m/s", "climb_mps"),
            (
                "a turn rate",
                turn_radps.abs().to_degrees(),
                yaw_rate_radps.to_degrees(),
                "°/s",
                "yaw_rate_radps",
            ),
        ] {
            ensure!(
                found <= limit,
                "set-point at {at_s} s: found {name} of {found:.2} {unit}, expected at most {limit:.2} {unit}, the {key} \
                 of [guidance] of the autopilot"
            );
        }
    }
    Ok(())
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    let mut warnings = Vec::new();
    let config = config(arguments, &mut warnings)?;
    #[cfg(feature = "lines")]
    if let Some(fly_config) = arguments.config.as_deref().filter(|_| arguments.lines) {
        return super::lines::run(arguments, config, fly_config);
    }
    let out = arguments.out.clone().unwrap_or_else(|| OUT.into());
    record(&config, &out, !arguments.no_report, warnings, started)
}

/// Flies `config` and writes the flight, its estimate and, if `has_page`, its page to `out`.
///
/// # Errors
/// A flight that is impossible, or that crashes; the record of a crashed flight is written first.
pub fn record(
    config: &FlightConfig,
    out: &Path,
    has_page: bool,
    warnings: Vec<String>,
    started: Instant,
) -> anyhow::Result<()> {
    // One step of the bar is a second of flight. The rest of the bar, 1 − `FLYING`, shows the estimation afterwards.
    let bar = output::bar((config.duration_s / FLYING).ceil() as usize);
    let flight = config.fly_with(|second| bar.set_position(second as u64))?;
    let (mut dataset, truth) = flight.dataset();
    dataset.write(out, &truth)?;

    let samples = dataset.imu.len() as f64;
    let Estimate { run, innovations, reference, score, summary } =
        Estimate::of(&mut dataset, out, |done| {
            let share = FLYING + (1.0 - FLYING) * done as f64 / samples;
            bar.set_position((share * config.duration_s / FLYING) as u64);
        })?;
    bar.finish_and_clear();
    let mut summary = Summary { run: summary, flight: ClosedLoopSummary::new(config, &flight) };
    summary.run.warnings.extend(warnings);
    summary.run.warnings.extend(flight.aborted.iter().map(|(at_s, why)| {
        format!("a test input ended early at {at_s:.2} s: {}", excitation::in_words(*why))
    }));
    let crash = flight.crashed_s.zip(flight.crash);
    if let Some((crashed_s, crash)) = crash {
        summary.run.warnings.push(format!("the vehicle crashed at {crashed_s:.2} s: it {crash}"));
    }
    summary.run.conclude(&innovations);
    crate::output::say(format_args!("{}", summary.flight.in_words()));
    if has_page {
        let page = SimulationPage {
            config,
            flight: &flight,
            dataset: &dataset,
            run: &run,
            innovations: &innovations,
            reference: reference.as_ref(),
            score: score.as_ref(),
            summary: &summary,
        };
        page.write(&out.join(output::REPORT))?;
    } else {
        output::remove_stale(out, [output::REPORT]);
    }
    summary.run.wall_s = started.elapsed().as_secs_f64();
    output::write_json(&summary, &out.join("summary.json"))?;
    summary.run.say(out);
    if let Some((crashed_s, crash)) = crash {
        bail!(
            "the vehicle crashed at {crashed_s:.2} s: it {crash}; the flight until then is in {}",
            out.display()
        );
    }
    Ok(())
}
