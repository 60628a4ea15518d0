//! Time of the flight loop, whose budget is 30 ms per sample, and of a complete flight in closed loop.
//!
//! `cargo bench --bench hover`.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use hovernav::autopilot::{HoverAutopilot, HoverConfig, Inputs};
use hovernav::controls::Sticks;
use hovernav::ekf::Estimator;
use hovernav::ekf::layout::{Base, Full, Layout};
use hovernav_design::hover::HoverDesign;
use hovernav_model::shipped;
use hovernav_sim::{Flight, FlightConfig};

fn config() -> FlightConfig {
    let design = HoverDesign::default();
    let gains = design.synthesise(&shipped::raptor60()).expect("the shipped model is one of hover");
    FlightConfig::new(HoverConfig::new(design.period_s, gains))
}

/// An engaged autopilot.
fn engaged(config: &HoverConfig, inputs: &Inputs<'_>) -> HoverAutopilot {
    let mut autopilot = HoverAutopilot::new(*config).expect("checked by the design");
    autopilot.step(&Inputs { engage: false, ..*inputs });
    autopilot.step(inputs);
    autopilot
}

/// The filter's step on a sample, its solution, and the autopilot's step on the solution.
fn loop_step<L: Layout<N>, const N: usize>(
    c: &mut Criterion,
    name: &str,
    config: &FlightConfig,
    flight: &Flight,
) {
    let settings = config.settings().expect("the default sensors can be described");
    let mut estimator = Estimator::<L, N>::with_layout(settings);
    let (dataset, _) = flight.dataset();
    let (before, after) = dataset.imu.split_at(dataset.imu.len() / 2);
    for event in dataset.events().take_while(|event| event.time() < after[0].time) {
        estimator.push(&event, |_| {});
    }
    assert_eq!(before.len() + after.len(), dataset.imu.len());
    let filter = estimator.filter().expect("aligned long ago");
    let solution = filter.solution();
    let pilot = Some(Sticks::NEUTRAL);
    let inputs = Inputs { now: solution.time, solution: Some(&solution), pilot, engage: true };
    let autopilot = engaged(&config.autopilot, &inputs);
    let start = (filter.clone(), autopilot, after.iter());
    let mut running = start.clone();
    c.bench_function(&format!("filter and autopilot step, {name}"), |b| {
        b.iter(|| {
            let (filter, autopilot, samples) = &mut running;
            let Some(sample) = samples.next() else {
                running = start.clone();
                return None;
            };
            filter.predict(black_box(sample)).ok()?;
            let solution = filter.solution();
            let now = solution.time;
            Some(autopilot.step(&Inputs { now, solution: Some(&solution), pilot, engage: true }))
        });
    });
}

fn hover(c: &mut Criterion) {
    let config = config();
    let short = FlightConfig { duration_s: 120.0, ..config.clone() };
    let flight = short.fly().expect("the default flight flies");
    let solution = flight.samples.last().and_then(|m| m.solution).expect("aligned long ago");
    let pilot = Some(Sticks::NEUTRAL);
    let inputs = Inputs { now: solution.time, solution: Some(&solution), pilot, engage: true };
    let mut autopilot = engaged(&config.autopilot, &inputs);
    c.bench_function("autopilot step", |b| b.iter(|| autopilot.step(black_box(&inputs))));
    loop_step::<Base, 16>(c, "15 states", &short, &flight);
    loop_step::<Full, 28>(c, "26 states", &short, &flight);
    c.bench_function("closed-loop flight of 300 s", |b| b.iter(|| config.fly()));
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = hover
}
criterion_main!(benches);
