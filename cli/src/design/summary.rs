//! `summary.json` of a design.

use hovernav::controls::Sticks;
use hovernav_design::hover::{FlightMode, SampledMode, SampledRobustness};
use hovernav_design::{
    ChannelMargins, CheckedDesign, Crossing, DISTURBED, DisturbanceResponse, Margins, Regulator,
};
use serde_json::{Value, json};

/// The contents of `summary.json`.
pub fn summary(checked: &CheckedDesign, input: &str) -> Value {
    let margins: serde_json::Map<String, Value> = checked
        .margins
        .channels
        .iter()
        .map(|channel| {
            let ChannelMargins { name, gain_up, gain_down, phase, delay_s, .. } = channel;
            let value = json!({
                "gain_up_db": gain_up.as_ref().map(Crossing::margin_db),
                "gain_down_db": gain_down.as_ref().map(Crossing::margin_db),
                "phase_deg": phase.map(|phase| phase.margin.to_degrees()),
                "crossover_radps": phase.map(|phase| phase.frequency_radps),
                "delay_s": delay_s,
                "disturbance_rejection_bandwidth_radps":
                    channel.disturbance_rejection_bandwidth_radps,
            });
            (name.clone(), value)
        })
        .collect();
    let disturbances = |responses: &[DisturbanceResponse]| -> Value {
        let entries = responses.iter().map(|response| {
            let value = json!({
                "size": response.size,
                "settled_s": response.settled_s(),
                "recovered_s": response.recovered_s(0.05),
                "recovered_to_2_percent_s": response.recovered_s(0.02),
                "stick_peaks": response.stick_peaks(),
            });
            (response.state.clone(), value)
        });
        Value::Object(entries.collect())
    };
    let limited: serde_json::Map<String, Value> = checked
        .limited
        .iter()
        .map(|response| {
            let value = json!({
                "recovered_s": response.recovered_s(0.05),
                "recovered_to_2_percent_s": response.recovered_s(0.02),
                "settled_s": response.settled_s(),
                "stick_peaks": response.stick_peaks(),
            });
            (response.state.clone(), value)
        })
        .collect();
    let in_gusts: serde_json::Map<String, Value> = checked
        .in_gusts
        .iter()
        .map(|(mode, found)| {
            let states = DISTURBED.into_iter().zip(found.states);
            let all = states.chain(Sticks::NAMES.into_iter().zip(found.sticks));
            let rms: serde_json::Map<String, Value> =
                all.map(|(name, rms)| (name.to_owned(), rms.into())).collect();
            (mode.name().to_owned(), Value::Object(rms))
        })
        .collect();
    let by_lag: serde_json::Map<String, Value> = FlightMode::ALL
        .into_iter()
        .zip(&checked.by_lag)
        .map(|(mode, by_lag)| {
            let [without, with] = by_lag
                .map(|(gain_db, phase_deg)| json!({ "gain_db": gain_db, "phase_deg": phase_deg }));
            (mode.name().to_owned(), json!({ "without": without, "with": with }))
        })
        .collect();
    let weakest = |margins: &Margins| {
        let channels = || margins.channels.iter();
        json!({
            "gain_db": channels().map(ChannelMargins::smallest_gain_db).fold(f64::INFINITY, f64::min),
            "phase_deg": channels().map(ChannelMargins::phase_deg).fold(f64::INFINITY, f64::min),
        })
    };
    let modes: serde_json::Map<String, Value> = checked
        .modes
        .iter()
        .map(|(mode, margins)| {
            (mode.name().to_owned(), margins.as_ref().map_or(Value::Null, weakest))
        })
        .collect();
    let handling: serde_json::Map<String, Value> = checked
        .handling
        .iter()
        .map(|found| {
            let value = json!({
                "disturbance_rejection_bandwidth_radps": found.rejection_bandwidth_radps,
                "disturbance_rejection_peak_db": found.rejection_peak_db,
                "bandwidth_radps": found.bandwidth_radps,
                "phase_delay_s": found.phase_delay_s,
            });
            (found.output.clone(), value)
        })
        .collect();
    let perturbed: serde_json::Map<String, Value> = (checked.perturbed.modes.iter())
        .map(|(mode, stable)| (mode.name().to_owned(), (*stable).into()))
        .collect();
    let mut summary = json!({
        "tool": "hovernav",
        "version": env!("CARGO_PKG_VERSION"),
        "input": input,
        "duration_s": CheckedDesign::FOLLOWED_S,
        "wall_s": 0.0,
        "imu_samples": 0,
        "gps_fixes_used": 0,
        "gps_fixes_rejected": 0,
        "model": checked.model.name(),
        "period_s": checked.design.period_s,
        "closed_loop_spectral_radius": checked.spectral_radius,
        "margins": margins,
        "disk_margin": {
            "gain": checked.margins.disk_gain(),
            "phase_deg": checked.margins.disk_phase_rad().to_degrees(),
        },
        "modes": modes,
        "handling": handling,
        "weakest": checked.weakest().map(|(mode, channel)| json!({
            "mode": mode.name(),
            "loop": channel.name,
            "gain_db": channel.smallest_gain_db(),
            "phase_deg": channel.phase_deg(),
        })),
        "perturbed": {
            "off": checked.perturbed.off,
            "of": checked.perturbed.of,
            "stable": checked.perturbed.in_every_mode,
            "modes": perturbed,
        },
        "sampled": checked.sampled.as_ref().map(sampled),
        "at_outputs": checked.at_outputs.as_ref().map(weakest),
        "sensitivity_peak": checked.margins.sensitivity.value,
        "disturbances": disturbances(&checked.responses),
        "disturbances_within_stick_limits": limited,
        "gusts": {
            "sigma_mps": checked.gusts.sigma_mps,
            "length_m": checked.gusts.length_m,
            "passing_mps": checked.gusts.passing_mps,
            "rms": in_gusts,
        },
        "estimator_lag": {
            "rate_s": checked.lag.rate_s,
            "attitude_s": checked.lag.attitude_s,
            "velocity_s": checked.lag.velocity_s,
            "modes": by_lag,
        },
        "weights": checked.design,
        "warnings": checked.warnings,
    });
    if let Some(notch) = &checked.notch {
        let costs = notch.at_crossover.iter().map(|(name, radps, lag_rad)| {
            let value = json!({ "crossover_radps": radps, "phase_lost_deg": lag_rad.to_degrees() });
            (name.clone(), value)
        });
        summary["notch"] = json!({
            "frequency_hz": notch.config.frequency_hz,
            "width_hz": notch.config.width_hz,
            "harmonics": notch.config.harmonics,
            "imu_hz": notch.imu_hz,
            "delay_s": notch.delay_s,
            "loops": Value::Object(costs.collect()),
        });
    }
    if let Some(forward) = &checked.forward {
        let points = forward.points.iter().map(|point| {
            let [gain_db, phase_deg, disk] =
                point.weakest().map_or([None; 3], |weakest| weakest.map(Some));
            json!({
                "speed_mps": point.speed_mps,
                "interpolated": !point.is_given,
                "stable": point.weakest().is_some(),
                "gain_db": gain_db,
                "phase_deg": phase_deg,
                "disk": disk,
            })
        });
        summary["forward_flight"] = json!({
            "fastest_mps": forward.fastest_mps[0],
            "fastest_backwards_mps": forward.fastest_mps[1],
            "points": points.collect::<Vec<_>>(),
        });
    }
    if let Some(printed) = &checked.printed {
        let rows = |gain: &Regulator| -> Vec<Vec<f64>> {
            gain.gain.row_iter().map(|row| row.iter().copied().collect()).collect()
        };
        summary["printed_design"] = json!({
            "roll_pitch_gain": rows(&printed.design.roll_pitch),
            "yaw_gain": rows(&printed.design.yaw),
            "disturbances": disturbances(&printed.responses),
            "spectral_radius_held": {
                "roll_pitch": printed.spectral_radii[0],
                "heave": printed.spectral_radii[1],
            },
        });
    }
    summary
}

/// Stability and margins of vehicles drawn from the covariance of the model's parameters.
fn sampled(found: &SampledRobustness) -> Value {
    let margins =
        |(gain_db, phase_deg): (f64, f64)| json!({ "gain_db": gain_db, "phase_deg": phase_deg });
    let modes = found.modes.iter().map(|own| {
        let SampledMode { mode, stable, twentieth, worst, proven } = own;
        let value = json!({
            "stable": stable,
            "twentieth": margins(*twentieth),
            "worst": margins(*worst),
            "proven_sigmas": proven.map(|proven| proven.sigmas),
            "proven_at_radps": proven.map(|proven| proven.frequency_radps),
        });
        (mode.name().to_owned(), value)
    });
    json!({
        "of": found.of,
        "stable": found.stable,
        "directions": found.directions,
        "within_proven": found.within_proven,
        "modes": Value::Object(modes.collect()),
    })
}
