//! `hovernav bench`: execution times of the filter and the flight loop on this machine.

mod page;

use std::path::PathBuf;

use anyhow::{anyhow, bail};
use hovernav_bench::{Report, Timed, Work, count_instructions};

use crate::output;

#[derive(clap::Args)]
pub struct Arguments {
    /// Number of loop cycles to time
    #[arg(long, value_name = "N", default_value_t = 1_000_000,
          value_parser = clap::value_parser!(u64).range(1_000..=100_000_000))]
    cycles: u64,
    /// Do not count instructions under valgrind
    #[arg(long)]
    no_count: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// Write bench.html, a page with the distributions, into this directory
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// The work to run under valgrind: its index, its repetitions, and 1 to run it or 0 for the empty loop
    #[arg(long, num_args = 3, hide = true)]
    perform: Option<Vec<u64>>,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if let Some(which) = arguments.perform.as_deref() {
        return perform(which);
    }
    if cfg!(debug_assertions) {
        output::say("this build is not optimised: its times do not apply to a release build");
    }
    // The directory is created first, so that an error does not follow minutes of timing.
    if let Some(directory) = &arguments.out {
        output::create(directory)?;
    }
    let working = output::Working::on("timing");
    let mut report = hovernav_bench::run(arguments.cycles, |_| {}).map_err(|text| anyhow!(text))?;
    drop(working);
    let counted =
        if arguments.no_count { Err("not asked for".to_owned()) } else { count(&mut report) };
    report.uncounted = counted.err();
    if let Some(directory) = &arguments.out {
        page::write(&report, &directory.join("bench.html"))?;
    }
    if arguments.json {
        return output::print_json(&report);
    }
    print(&report);
    if let Some(why) = &report.uncounted {
        output::say(format_args!("\ninstructions not counted: {why}"));
    }
    Ok(())
}

/// Runs one work for [`count`], in a process of its own.
fn perform(which: &[u64]) -> anyhow::Result<()> {
    let [place, times, works] = *which else { bail!("expected three numbers") };
    let work = usize::try_from(place).ok().and_then(|place| Work::ALL.get(place));
    let work = work.ok_or_else(|| {
        anyhow!("found an unknown work, expected a number below {}", Work::ALL.len())
    })?;
    work.perform(times, works == 1).map_err(|text| anyhow!(text))
}

/// Adds instruction counts to the times of the report.
fn count(report: &mut Report) -> Result<(), String> {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let _working = output::Working::on("counting instructions");
    let counts = count_instructions(&program, |place, times, works| {
        let numbers = [place.to_string(), times.to_string(), u8::from(works).to_string()];
        ["bench", "--perform"].map(str::to_owned).into_iter().chain(numbers).collect()
    })?;
    for timed in &mut report.steps {
        timed.instructions = counts
            .iter()
            .find(|(work, _)| (work.name, work.states) == (timed.name, timed.states))
            .map(|(_, instructions)| *instructions);
    }
    Ok(())
}

fn print(report: &Report) {
    let machine = &report.machine;
    let (processor, count) = (&machine.processor, machine.processors);
    output::print(format_args!("{processor}, {count} processors; {}\n", machine.system));
    output::print(format_args!("{}; memory {}\n", machine.priority, machine.memory));
    output::print(format_args!(
        "reading the clock takes {:.0} ns; this is subtracted from each time\n\n",
        report.clock_ns
    ));
    output::print(format_args!(
        "{:<32} {:>6} {:>9} {:>9} {:>9} {:>10} {:>12}\n",
        "ns", "states", "p50", "p99", "p99.9", "max", "instructions"
    ));
    for timed in report.steps.iter().chain([&report.cycle]) {
        output::print(line(timed));
    }
    output::print(format_args!(
        "\nthe longest of {} cycles took {:.3} % of the loop's {:.1} ms",
        report.cycle.time.calls,
        100.0 * report.share_of_period,
        1e3 * report.period_s,
    ));
    if let Some(p99_9_ns) = report.cycle.time.p99_9_ns {
        let share = 100.0 * p99_9_ns * 1e-9 / report.period_s;
        output::print(format_args!(", 99.9 % of them at most {share:.3} %"));
    }
    output::print("\n");
    let worst = &report.worst;
    output::print(format_args!(
        "worst of {} combinations of inputs to the estimator: {:.1} µs ({:.1} for an inertial sample alone):\n{}\n",
        worst.tried,
        1e-3 * worst.time_ns,
        1e-3 * worst.ordinary_ns,
        worst.inputs,
    ));
}

fn line(timed: &Timed) -> String {
    let Timed { name, states, time, instructions } = timed;
    let instructions = instructions.map_or(String::new(), |count| count.to_string());
    let [p99, p99_9] = [time.p99_ns, time.p99_9_ns].map(rare);
    format!(
        "{name:<32} {states:>6} {:>9.0} {p99:>9} {p99_9:>9} {:>10.0} {instructions:>12}\n",
        time.p50_ns, time.max_ns
    )
}

/// A high percentile of the time, ns; empty if there were too few calls.
fn rare(ns: Option<f64>) -> String {
    ns.map_or_else(String::new, |ns| format!("{ns:.0}"))
}
