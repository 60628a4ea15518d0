//! Each loop by itself: Bode and Nichols.

use std::f64::consts::{PI, TAU};

use hovernav_design::{CheckedDesign, Nichols, ZONE, bode, logarithmic_frequencies};
use hovernav_model::StateSpace;

use crate::page::{Axis, Figure, Role, Row, Section, Series};

/// A figure for each loop: one margin is lost in four curves.
pub fn frequency_responses(checked: &CheckedDesign) -> anyhow::Result<Section> {
    let nyquist = PI / checked.design.period_s;
    let frequencies = logarithmic_frequencies(0.02, nyquist, 400);
    let ends = [frequencies[0], nyquist];
    let mut section = Section::new(
        "bode",
        "Bode",
        "Gain and phase around each loop, broken at its actuator with the others closed: how far the \
         phase is from −180° where the gain is 0 dB is the phase margin, how far the gain from 0 dB \
         where the phase is −180° the gain margin. The marks are the margins of the table.",
    );
    for channel in &checked.margins.channels {
        let model: StateSpace = checked.closed.channel(&channel.name)?;
        let response = bode(&model, &channel.name, 0, &frequencies)?;
        // The turn in which the crossover lies is the one to read a margin in.
        let crossover = channel.phase.map_or(1.0, |phase| phase.frequency_radps);
        let at = frequencies.partition_point(|&frequency| frequency < crossover);
        let turns = response.get(at).map_or(0.0, |(_, phase)| ((phase + 180.0) / 360.0).round());
        let points = || frequencies.iter().zip(&response);
        let critical =
            |level: f64| Series::curve(Role::Limit, ends.map(|f| (f, level))).named("critical");
        let crossings = channel.gain_up.iter().chain(&channel.gain_down);
        let gain_margins =
            crossings.map(|crossing| (crossing.frequency_radps, -20.0 * crossing.margin.log10()));
        let phase_margin = channel
            .phase
            .iter()
            .map(|phase| (phase.frequency_radps, phase.margin.to_degrees() - 180.0));
        let gain = Row { limits: Some([-60.0, 60.0]), ..Row::new("Gain", "dB") }
            .with(critical(0.0))
            .with(Series::curve(Role::Model, points().map(|(&f, &(db, _))| (f, db))))
            .with(Series::points(Role::Pole, gain_margins).named("gain margin"));
        let degrees = points().map(|(&f, &(_, degrees))| (f, degrees - 360.0 * turns));
        let phase = Row { limits: Some([-540.0, 180.0]), ..Row::new("Phase", "°") }
            .with(critical(-180.0))
            .with(Series::curve(Role::Model, degrees))
            .with(Series::points(Role::Pole, phase_margin).named("phase margin"));
        let axis = Axis::logarithmic("Frequency", "rad/s");
        let caption = format!(
            "{}: {:.1} dB, {:.1}°",
            channel.name,
            channel.smallest_gain_db(),
            channel.phase_deg()
        );
        section = section.with(Figure::against(axis, [gain, phase]).captioned(caption));
    }
    Ok(section.folded("A figure for each loop"))
}

/// Gain over phase of each loop, with the zone that it should keep out of.
pub fn nichols(checked: &CheckedDesign) -> anyhow::Result<Section> {
    let nyquist = PI / checked.design.period_s;
    let frequencies = logarithmic_frequencies(0.02, nyquist, 2000);
    let (zone_db, zone_deg) = ZONE;
    let mut section = Section::new(
        "nichols",
        "Nichols",
        "Gain over phase around each loop, the others closed. Through −180° and 0 dB a loop loses its stability; \
         the zone about it is an ellipse of 45° and 6 dB, the margins asked for, which a loop should not enter \
         on its way between them. The disk margin of the loop alone stands above each: gain and phase that may \
         both be off at once.",
    );
    for channel in &checked.margins.channels {
        let open = checked.closed.channel(&channel.name)?;
        let found = Nichols::of(&open, &channel.name, &frequencies)?;
        let zone = (0..=90).map(|step| (f64::from(step) * TAU / 90.0).sin_cos());
        let zone = zone.map(|(sin, cos)| (-180.0 + zone_deg * cos, zone_db * sin));
        let row = Row { limits: Some([-20.0, 20.0]), ..Row::new("Gain", "dB") }
            .with(Series::curve(Role::Limit, zone).named("zone to keep out of"))
            .with(Series::points(Role::Pole, [(-180.0, 0.0)].into_iter()).named("instability"))
            .with(Series::curve(Role::Model, unbroken(&found.curve)));
        let axis = Axis::linear("Phase", "°").within([-300.0, -60.0]);
        let [least, most] = found.disk_gain();
        let enters = if found.enters_zone() { "enters the zone" } else { "keeps out of the zone" };
        let caption = format!(
            "{}: {enters}; disk margin {:.2}, gain {least:.2} to {most:.2} with phase {:.0}°",
            channel.name,
            found.disk.value,
            found.disk_phase_deg()
        );
        section = section.with(Figure::against(axis, [row]).captioned(caption));
    }
    Ok(section.folded("A figure for each loop"))
}

/// What of the curve is on the chart, with a gap wherever it leaves on one side and comes back on the other.
fn unbroken(curve: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let shown: Vec<_> = curve.iter().copied().filter(|(_, gain)| gain.abs() < 25.0).collect();
    let mut parts = Vec::with_capacity(shown.len());
    for part in shown.chunk_by(|one, other| (one.0 - other.0).hypot(one.1 - other.1) < 60.0) {
        parts.extend_from_slice(part);
        parts.push((f64::NAN, f64::NAN));
    }
    parts
}
