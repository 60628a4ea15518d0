#![doc = include_str!("../README.md")]

mod dense;
mod distribution;
mod flight;
mod flight_loop;
mod instructions;
mod kernels;
mod machine;
mod receiver;
mod worst;

use serde::Serialize;

pub use distribution::Distribution;
pub use instructions::{Work, count_instructions};
pub use machine::Machine;
pub use worst::Worst;

/// The period of a loop of 33 Hz, s.
pub const PERIOD_S: f64 = 0.0303;

/// A timed piece of work.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Timed {
    /// Name.
    pub name: &'static str,
    /// Number of error states of the filter; 0 for work without a filter.
    pub states: usize,
    /// Distribution of the execution time.
    pub time: Distribution,
    /// Instructions per call, if counted.
    pub instructions: Option<u64>,
}

/// The results.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The machine.
    pub machine: Machine,
    /// Number of timed cycles of the loop.
    pub cycles: u64,
    /// The period of the loop, s: the budget.
    pub period_s: f64,
    /// Time to read the clock, ns; already subtracted.
    pub clock_ns: f64,
    /// Prediction, each update, and the dense textbook form of both.
    pub steps: Vec<Timed>,
    /// The work of one cycle of the loop: decode, estimate, control, servos, telemetry, record.
    pub cycle: Timed,
    /// The worst case among the tested inputs.
    pub worst: Worst,
    /// Fraction of the period that the longest cycle took.
    pub share_of_period: f64,
    /// The reason, if instructions were not counted.
    pub uncounted: Option<String>,
}

/// Times everything over `cycles` cycles of the loop. `on_step` receives the name of the next step.
///
/// # Errors
/// If the synthetic flight fails, which is an error of this crate.
pub fn run(cycles: u64, mut on_step: impl FnMut(&str)) -> Result<Report, String> {
    let machine = Machine::prepare();
    let clock_ns = distribution::clock_ns();
    on_step("predictions and updates");
    let mut steps = kernels::full(cycles, clock_ns)?;
    steps.extend(kernels::without_height_aids(cycles, clock_ns)?);
    steps.extend(kernels::base(cycles, clock_ns)?);
    on_step("the dense textbook form");
    steps.extend(dense::all(cycles.min(20_000), clock_ns));
    on_step("the flight loop");
    let time = flight_loop::time(cycles, clock_ns)?;
    let share_of_period = time.max_ns * 1e-9 / PERIOD_S;
    let cycle = Timed { name: "cycle of the flight loop", states: 26, time, instructions: None };
    on_step("the worst case");
    let worst = worst::search(clock_ns)?;
    Ok(Report {
        machine,
        cycles,
        period_s: PERIOD_S,
        clock_ns,
        steps,
        cycle,
        worst,
        share_of_period,
        uncounted: None,
    })
}
