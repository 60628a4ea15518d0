//! What the sensors themselves said: raw samples, spectrum, receiver, intervals, sticks.

use hovernav::ekf::Notice;
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;

use super::data::FlightData;
use super::motion::Clock;
use super::spectrum;
use crate::page::{Axis, Figure, Role, Row, Section, Series};

const AXES: [&str; 3] = ["x", "y", "z"];

/// Samples as rates: seconds of the page, °/s and m/s², one component at a time in memory.
struct Raw<'a> {
    samples: &'a [ImuSample],
    time: Vec<f64>,
    /// Median interval, s.
    interval_s: f64,
}

impl<'a> Raw<'a> {
    fn of(samples: &'a [ImuSample], clock: Clock) -> Self {
        let mut raw = Self { samples, time: Vec::new(), interval_s: 0.0 };
        raw.time = raw.known().map(|(sample, _)| clock.seconds(sample.time)).collect();
        let mut intervals: Vec<f64> =
            samples.windows(2).map(|pair| pair[1].time - pair[0].time).collect();
        raw.interval_s = hovernav_log::statistics::quantile(&mut intervals, 0.5).unwrap_or(0.0);
        raw
    }

    /// Samples whose rates are known, each with the interval before it, s.
    fn known(&self) -> impl Iterator<Item = (&'a ImuSample, f64)> {
        let before =
            std::iter::once(None).chain(self.samples.iter().map(|before| Some(before.time)));
        let both = self.samples.iter().zip(before);
        both.filter_map(|(sample, before)| match before {
            Some(before) => Some((sample, sample.time - before)),
            // The first increment's interval is not known.
            None => matches!(sample.motion, Motion::Rates { .. }).then_some((sample, 0.0)),
        })
    }

    /// Angular rates x, y, z, °/s, then specific forces, m/s².
    fn component(&self, component: usize) -> Vec<f64> {
        let values = self.known().map(|(sample, interval_s)| {
            let mean = sample.motion.mean_rates(interval_s);
            match component {
                0..3 => mean.angular_rate_radps.to_array()[component].to_degrees(),
                _ => mean.specific_force_mps2.to_array()[component % 3],
            }
        });
        values.collect()
    }
}

/// The sections of what `data` has of its sensors.
pub fn sections(data: &FlightData<'_>, clock: Clock) -> Vec<Section> {
    let mut sections = Vec::new();
    if !data.imu.is_empty() {
        let raw = Raw::of(data.imu, clock);
        sections.push(samples(data, &raw, clock));
        sections.push(vibration(&raw));
    }
    if !data.fixes.is_empty() {
        sections.push(receiver(data, clock));
    }
    if !data.imu.is_empty() {
        sections.push(intervals(data, clock));
    }
    if !data.controls.is_empty() {
        sections.push(sticks(data, clock));
    }
    sections
}

fn samples(data: &FlightData<'_>, raw: &Raw<'_>, clock: Clock) -> Section {
    let clipped = |component: usize, values: &[f64]| {
        let times = data.notices.iter().filter_map(move |notice| match notice {
            Notice::SampleSuspect { time, suspicion } => {
                let axes = [suspicion.gyro_clipped, suspicion.accel_clipped];
                axes[component / 3][component % 3].then_some(clock.seconds(*time))
            }
            _ => None,
        });
        let points = times.filter_map(|time| {
            let index = raw.time.partition_point(|known| *known < time - 1e-9);
            Some((time, *values.get(index)?))
        });
        points.collect::<Vec<_>>()
    };
    let row = |component: usize| {
        let (name, unit) =
            if component < 3 { ("Rate", "°/s") } else { ("Specific force", "m/s²") };
        let values = raw.component(component);
        let points = clipped(component, &values);
        let note = (!points.is_empty()).then(|| format!("{} samples clipped", points.len()));
        let row = Row { note, ..Row::new(&format!("{name} {}", AXES[component % 3]), unit) };
        row.with(Series::line(Role::Raw, &raw.time, &values, None))
            .with(Series::points(Role::Clipped, points.into_iter()))
    };
    Section::new(
        "samples",
        "Inertial samples",
        "Angular rates and specific forces as the unit sent them, in body axes (forward, right, down); \
         at rest and level z reads −9.81 m/s². Crosses stand at samples at the end of the range, where \
         the true value is not known.",
    )
    .with(Figure::against_time([3, 4, 5, 0, 1, 2].map(row)))
}

fn vibration(raw: &Raw<'_>) -> Section {
    let row = |(name, unit, first): (&str, &'static str, usize)| {
        let roles = [Role::First, Role::Second, Role::Third];
        let mut row = Row { logarithmic: true, ..Row::new(name, unit) };
        for (axis, role) in roles.into_iter().enumerate() {
            let lines = spectrum::density(&raw.component(first + axis), raw.interval_s);
            row = row.with(Series::curve(role, lines.unwrap_or_default()).named(AXES[axis]));
        }
        row
    };
    let rows = [("Specific force", "m/s²/√Hz", 3), ("Rate", "°/s/√Hz", 0)].map(row);
    Section::new(
        "vibration",
        "Vibration",
        format!(
            "How much the unit shakes at each frequency, up to half its rate of {:.0} Hz. Rotor and \
             motors stand out as peaks, sensor noise is flat; what vibrates faster than half the rate \
             is folded down and cannot be told apart.",
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
        "What the receiver says of its own fixes, where it says anything: its one-sigma and how many \
         satellites it used. Receivers are often too sure of themselves.",
    )
    .with(Figure::against_time(rows))
}

fn intervals(data: &FlightData<'_>, clock: Clock) -> Section {
    let row = |name: &str, times: Vec<Time>| {
        let x: Vec<f64> = times.iter().skip(1).map(|time| clock.seconds(*time)).collect();
        let y = times.windows(2).map(|pair| 1e3 * (pair[1] - pair[0]));
        let points = Series::points(Role::Test, x.into_iter().zip(y.filter(|ms| *ms > 0.0)));
        Row { logarithmic: true, ..Row::new(name, "ms") }.with(points.named("Interval"))
    };
    let rows = [
        row("Inertial", data.imu.iter().map(|sample| sample.time).collect()),
        row("GPS", data.fixes.iter().map(|fix| fix.time).collect()),
    ];
    Section::new(
        "intervals",
        "Sample intervals",
        "The time from each sample to the next. A level line is a steady clock; a dot above it is a \
         gap, as high as the gap is long.",
    )
    .with(Figure::against_time(rows))
}

fn sticks(data: &FlightData<'_>, clock: Clock) -> Section {
    let time: Vec<f64> = data.controls.iter().map(|(time, _)| clock.seconds(*time)).collect();
    let names = ["Lateral", "Longitudinal", "Collective", "Pedal"];
    let rows = names.into_iter().enumerate().map(|(stick, name)| {
        let values: Vec<f64> = data.controls.iter().map(|(_, sticks)| sticks[stick]).collect();
        Row::new(name, "").with(Series::line(Role::Input, &time, &values, None).named("Stick"))
    });
    Section::new(
        "sticks",
        "Sticks",
        "What the pilot or the autopilot commanded, each from −1 to 1 about trim.",
    )
    .with(Figure::against_time(rows))
}
