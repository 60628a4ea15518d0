//! `hovernav estimate`: runs the filter over a log, scores the solution and draws the page.

mod arguments;
mod columns;
#[cfg_attr(not(feature = "export"), path = "no_export.rs")]
mod export;
mod files;
mod table;

use std::path::Path;
use std::time::Instant;

use hovernav::ekf::{EstimatorConfig, Solution};
use hovernav_dataset::{Dataset, Outage};
use hovernav_formats::{Changes, Pass, RunSummary};
use hovernav_pages::flight::LogPage;
use hovernav_replay::Keep;

pub use self::arguments::Arguments;
use self::files::Files;
use crate::emit;
use crate::memory;
use crate::output::{self, Working};
use crate::summary::InWords as _;

/// Largest number of inertial samples in memory: 36 MB, two hours at 33 Hz. In a longer log, samples and sticks stay in
/// their file and are read again for each pass.
const SAMPLES_IN_MEMORY: usize = 1 << 18;

/// Samples between two updates of the progress bar.
const SAMPLES_A_STEP: usize = 4096;

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    export::check(&arguments.export, arguments.log.len())?;
    if let [log] = &arguments.log[..] {
        let out = arguments.out.clone();
        let out = out.unwrap_or_else(|| Path::new("out").join(output::name_of(log)));
        let summary = estimate(arguments, log, &out)?;
        // With `--export -`, standard output contains only the solution.
        if !export::is_piped(&arguments.export) {
            summary.say(&out);
        }
        return Ok(());
    }
    table::run(arguments)
}

/// Runs the filter over `log` and writes the results to `out`.
fn estimate(arguments: &Arguments, log: &Path, out: &Path) -> anyhow::Result<RunSummary> {
    let started = Instant::now();
    let mut options = arguments.sensors.options();
    options.samples_in_memory = Some(SAMPLES_IN_MEMORY);
    let reading = Working::on("reading");
    let mut read = memory::open(log, &options, 1)?;
    drop(reading);
    if let Some(config) = &arguments.config {
        read.dataset.configure(config)?;
    }
    let outages: Vec<Outage> = arguments.outage.iter().map(|window| window.outage()).collect();
    let changes = Changes {
        configured: arguments.config.is_some(),
        outages: &outages,
        gps_rate_hz: arguments.gps_rate,
    };
    // Output that went to a pipe cannot be replaced, so the filter runs only once then.
    let once = export::is_piped(&arguments.export);
    let estimated = read.estimate(log, &changes, once, |dataset, config, keep| {
        fly(arguments, log, out, dataset, config, keep)
    })?;

    let judging = Working::on("scoring");
    let judged = read.judge(log, &changes, arguments.smooth, &estimated)?;
    let (config, notch) = (&estimated.config, read.dataset.manifest.imu.notch);
    let remark = format!("From {} by hovernav {}.", log.display(), env!("CARGO_PKG_VERSION"));
    emit::estimator(config, notch, &remark, &arguments.emit, out)?;
    if !arguments.no_report {
        let page = LogPage::new(&read, &estimated, &judged, &outages)?;
        page.page().write(&out.join(output::REPORT))?;
    }
    let page = arguments.no_report.then_some(output::REPORT);
    output::remove_stale(out, export::not_asked(&arguments.export).into_iter().chain(page));
    drop(judging);
    let mut summary = judged.summary;
    summary.wall_s = started.elapsed().as_secs_f64();
    output::write_json(&summary, &out.join("summary.json"))?;
    Ok(summary)
}

/// Runs the filter over `dataset`, read from `log`, and writes the solution to `out`.
fn fly(
    arguments: &Arguments,
    log: &Path,
    out: &Path,
    dataset: &Dataset,
    config: &EstimatorConfig,
    keep: Keep,
) -> anyhow::Result<Pass> {
    let bar = output::bar(dataset.sample_count());
    let progress = |done: usize| {
        if done.is_multiple_of(SAMPLES_A_STEP) {
            bar.set_position(done as u64);
        }
        anyhow::Ok(())
    };
    if arguments.smooth {
        memory::check_smoothing(log, dataset)?;
    }
    let mut files = Files::new(arguments, &dataset.manifest, out);
    let each = |solution: &Solution| files.push(solution);
    let pass = Pass::over(dataset, config, keep, arguments.smooth, progress, each)?;
    files.finish()?;
    bar.finish_and_clear();
    Ok(pass)
}
