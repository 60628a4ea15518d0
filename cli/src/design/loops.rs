//! Frequency responses of each loop: Bode and Nichols charts.

use std::f64::consts::{PI, TAU};

use hovernav_design::{CheckedDesign, Nichols, ZONE, bode, logarithmic_frequencies};
use hovernav_model::StateSpace;

use hovernav_pages::{Axis, Figure, Role, Row, Section, Series};

/// The frequency responses, with one figure per loop: margins of four loops in one chart are unreadable.
pub fn frequency_responses(checked: &CheckedDesign) -> anyhow::Result<Section> {
    let nyquist = PI / checked.design.period_s;
    let frequencies = logarithmic_frequencies(0.02, nyquist, 400);
    let ends = [frequencies[0], nyquist];
    let mut section = Section::new(
        "bode",
        "Bode",
        "Gain and phase of each loop, broken at its actuator, with the other loops closed. The phase margin is \
         the distance of the phase from −180° where the gain is 0 dB. The gain margin is the distance of the gain \
         from 0 dB where the phase is −180°. The marks are the margins of the table.",
    );
    for channel in &checked.margins.channels {
        let model: StateSpace = checked.closed.channel(&channel.name)?;
        let response = bode(&model, &channel.name, 0, &frequencies)?;
        // The phase is shown within the turn of 360° that contains the crossover, where the margin is read.
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
    Ok(section.folded("One figure per loop"))
}

/// Gain over phase of each loop, with the zone that it should avoid.
pub fn nichols(checked: &CheckedDesign) -> anyhow::Result<Section> {
    let nyquist = PI / checked.design.period_s;
    let frequencies = logarithmic_frequencies(0.02, nyquist, 2000);
    let (zone_db, zone_deg) = ZONE;
    let mut section = Section::new(
        "nichols",
        "Nichols",
        "Gain over phase of each loop, with the other loops closed. A loop through −180° and 0 dB is unstable. \
         The zone around this point is an ellipse of 45° and 6 dB, the required margins; a curve should not enter \
         it. Each caption states the disk margin of that loop alone: the allowed simultaneous error of gain and \
         phase.",
    );
    for channel in &checked.margins.channels {
        let open = checked.closed.channel(&channel.name)?;
        let found = Nichols::of(&open, &channel.name, &frequencies)?;
        let zone = (0..=90).map(|step| (f64::from(step) * TAU / 90.0).sin_cos());
        let zone = zone.map(|(sin, cos)| (-180.0 + zone_deg * cos, zone_db * sin));
        let row = Row { limits: Some([-20.0, 20.0]), ..Row::new("Gain", "dB") }
            .with(Series::curve(Role::Limit, zone).named("zone to avoid"))
            .with(Series::points(Role::Pole, [(-180.0, 0.0)].into_iter()).named("instability"))
            .with(Series::curve(Role::Model, unbroken(&found.curve)));
        let axis = Axis::linear("Phase", "°").within([-300.0, -60.0]);
        let [least, most] = found.disk_gain();
        let enters = if found.enters_zone() { "enters the zone" } else { "avoids the zone" };
        let caption = format!(
            "{}: {enters}; disk margin {:.2}, gain {least:.2} to {most:.2} with phase {:.0}°",
            channel.name,
            found.disk.value,
            found.disk_phase_deg()
        );
        section = section.with(Figure::against(axis, [row]).captioned(caption));
    }
    Ok(section.folded("One figure per loop"))
}

/// The part of the curve within the chart, with a gap wherever it leaves on one side and re-enters on the other.
fn unbroken(curve: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let shown: Vec<_> = curve.iter().copied().filter(|(_, gain)| gain.abs() < 25.0).collect();
    let mut parts = Vec::with_capacity(shown.len());
    for part in shown.chunk_by(|one, other| (one.0 - other.0).hypot(one.1 - other.1) < 60.0) {
        parts.extend_from_slice(part);
        parts.push((f64::NAN, f64::NAN));
    }
    parts
}
