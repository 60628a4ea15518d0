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

/// One thing that was timed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Timed {
    /// What it is.
    pub name: &'static str,
    /// States of the filter's error; 0 where there is no filter in it.
    pub states: usize,
    /// How long it took.
    pub time: Distribution,
    /// Instructions a call, where they were counted.
    pub instructions: Option<u64>,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// On what.
    pub machine: Machine,
    /// Cycles of the loop that were flown.
    pub cycles: u64,
    /// The period of the loop, s: the budget.
    pub period_s: f64,
    /// What reading the clock takes, ns: already taken off.
    pub clock_ns: f64,
    /// Prediction, each update, and the dense textbook form of both.
    pub steps: Vec<Timed>,
    /// The body of the loop: decode, estimate, control, servos, telemetry, record.
    pub cycle: Timed,
    /// The worst case that was found by searching inputs.
    pub worst: Worst,
    /// Share of the period that the longest cycle took.
    pub share_of_period: f64,
    /// Why instructions were not counted, if they were not.
    pub uncounted: Option<String>,
}

/// Times everything over `cycles` cycles of the loop. `tell` hears what is timed next.
///
/// # Errors
/// A sentence, where the made-up flight does not fly: a fault of this crate.
pub fn run(cycles: u64, mut tell: impl FnMut(&str)) -> Result<Report, String> {
    let machine = Machine::prepare();
    let clock_ns = distribution::clock_ns();
    tell("predictions and updates");
    let mut steps = kernels::full(cycles, clock_ns)?;
    steps.extend(kernels::without_height_aids(cycles, clock_ns)?);
    steps.extend(kernels::base(cycles, clock_ns)?);
    tell("the dense textbook form");
    steps.extend(dense::all(cycles.min(20_000), clock_ns));
    tell("the flight loop");
    let time = flight_loop::time(cycles, clock_ns)?;
    let share_of_period = time.max_ns * 1e-9 / PERIOD_S;
    let cycle = Timed { name: "cycle of the flight loop", states: 26, time, instructions: None };
    tell("the worst case");
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
