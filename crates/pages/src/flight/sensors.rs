//! The sensors on the page: raw samples, spectrum, receiver, intervals, sticks.

use super::data::FlightData;
use super::motion::Clock;
use super::raw::Raw;
use crate::{Axis, Figure, Role, Row, Section, Series};

const AXES: [&str; 3] = ["x", "y", "z"];

/// The sections for the sensors in `data`.
pub fn sections(data: &FlightData<'_>, raw: Option<&Raw>, clock: Clock) -> Vec<Section> {
    let mut sections = Vec::new();
    if let Some(raw) = raw {
        sections.push(samples(raw));
        sections.push(vibration(raw));
    }
    if !data.fixes.is_empty() {
        sections.push(receiver(data, clock));
    }
    if let Some(raw) = raw {
        sections.push(intervals(data, raw, clock));
    }
    if !data.sticks.is_empty() {
        sections.push(sticks(data, clock));
    }
    sections
}

fn samples(raw: &Raw) -> Section {
    let row = |component: usize| {
        let (name, unit) =
            if component < 3 { ("Rate", "°/s") } else { ("Specific force", "m/s²") };
        let (time, values): (Vec<f64>, Vec<f64>) =
            raw.components[component].iter().copied().unzip();
        let points = &raw.clipped[component];
        let note = (!points.is_empty()).then(|| format!("{} samples clipped", points.len()));
        let row = Row { note, ..Row::new(&format!("{name} {}", AXES[component % 3]), unit) };
        row.with(Series::line(Role::Raw, &time, &values, None))
            .with(Series::points(Role::Clipped, points.iter().copied()))
    };
    Section::new(
        "samples",
        "Inertial samples",
        "Raw angular rates and specific forces in body axes (forward, right, down). \
         At rest and level, z reads −9.81 m/s². Crosses mark samples at the end of the range, whose \
         true value is unknown.",
    )
    .with(Figure::against_time([3, 4, 5, 0, 1, 2].map(row)))
}

fn vibration(raw: &Raw) -> Section {
    let row = |(name, unit, first): (&str, &'static str, usize)| {
        let roles = [Role::First, Role::Second, Role::Third];
        let mut row = Row { logarithmic: true, ..Row::new(name, unit) };
        for (axis, role) in roles.into_iter().enumerate() {
            let lines = raw.spectra[first + axis].iter().copied();
            row = row.with(Series::curve(role, lines).named(AXES[axis]));
        }
        row
    };
    let rows = [("Specific force", "m/s²/√Hz", 3), ("Rate", "°/s/√Hz", 0)].map(row);
    Section::new(
        "vibration",
        "Vibration",
        format!(
            "Vibration of the inertial unit over frequency, up to half its sample rate of {:.0} Hz. \
             Rotors and motors appear as peaks, sensor noise is flat. Vibration above half the rate \
             appears at a lower frequency (aliasing).",
            1.0 / raw.interval_s
        ),
    )
    .with(Figure::against(Axis::logarithmic("Frequency", "Hz"), rows))
}

fn receiver(data: &FlightData<'_>, clock: Clock) -> Section {
    let time: Vec<f64> = data.fixes.iter().map(|fix| clock.seconds(fix.time)).collect();
    let column = |pick: &dyn Fn(&hovernav::gps::Fix) -> Option<f64>| -> Vec<f64> {
        data.fixes.iter().map(|fix| pick(fix).unwrap_or(f64::NAN)).collect()
    };
    let line = |role, values: &[f64]| Series::line(role, &time, values, None);
    let level = |[north, east, _]: [f64; 3]| north.hypot(east);
    let horizontal = column(&|fix| fix.position_sigma_m.map(|sigma| level(sigma.to_array())));
    let vertical = column(&|fix| fix.position_sigma_m.map(|sigma| sigma.z()));
    let of_velocity = column(&|fix| fix.velocity_sigma_mps.map(|sigma| level(sigma.to_array())));
    let down = column(&|fix| fix.velocity_sigma_mps.map(|sigma| sigma.z()));
    let satellites = column(&|fix| fix.satellites.map(f64::from));
    let rows = [
        Row::new("Position 1σ", "m")
            .with(line(Role::First, &horizontal).named("Horizontal"))
            .with(line(Role::Second, &vertical).named("Vertical")),
        Row::new("Velocity 1σ", "m/s")
            .with(line(Role::First, &of_velocity).named("Horizontal"))
            .with(line(Role::Second, &down).named("Vertical")),
        Row::new("Satellites", "").with(line(Role::Input, &satellites).named("Satellites")),
    ];
    Section::new(
        "gps",
        "GPS quality",
        "One-sigma and number of satellites that the receiver reports for its fixes, if it does. \
         The reported sigma is often too small.",
    )
    .with(Figure::against_time(rows))
}

fn intervals(data: &FlightData<'_>, raw: &Raw, clock: Clock) -> Section {
    let row = |name: &str, points: Vec<(f64, f64)>| {
        let points = Series::points(Role::Test, points.into_iter());
        Row { logarithmic: true, ..Row::new(name, "ms") }.with(points.named("Interval"))
    };
    let of_fixes = data
        .fixes
        .windows(2)
        .map(|pair| (clock.seconds(pair[1].time), 1e3 * (pair[1].time - pair[0].time)));
    let rows = [
        row("Inertial", raw.intervals.clone()),
        row("GPS", of_fixes.filter(|(_, ms)| *ms > 0.0).collect()),
    ];
    Section::new(
        "intervals",
        "Sample intervals",
        "Time between successive samples. A flat line means a steady clock. A dot above it is a \
         gap, at the height of its length.",
    )
    .with(Figure::against_time(rows))
}

fn sticks(data: &FlightData<'_>, clock: Clock) -> Section {
    let names = ["Lateral", "Longitudinal", "Collective", "Pedal"];
    let rows = names.into_iter().zip(data.sticks).map(|(name, points)| {
        let (time, values): (Vec<f64>, Vec<f64>) =
            points.iter().map(|&(time, value)| (clock.seconds(time), value)).unzip();
        Row::new(name, "").with(Series::line(Role::Input, &time, &values, None).named("Stick"))
    });
    Section::new(
        "sticks",
        "Sticks",
        "Commands of the pilot or the autopilot, from −1 to 1 about trim.",
    )
    .with(Figure::against_time(rows))
}
