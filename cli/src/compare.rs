//! `hovernav compare`: differences between solutions.

use std::path::PathBuf;
use std::time::Instant;

use hovernav_dataset::LogError;
use hovernav_formats::{Comparison, NamedTrajectory};
use hovernav_pages::compare::ComparisonPage;

use crate::arguments::AxesArgument;
use crate::memory;
use crate::output::{self, Working};

#[derive(clap::Args)]
pub struct Arguments {
    /// Solution files, output directories of estimate, or directories that init made for other files; the others are
    /// compared with the first
    #[arg(required = true, num_args = 2..=4)]
    solution: Vec<PathBuf>,
    /// Directory to write
    #[arg(long, value_name = "DIR", default_value = "out/compare")]
    out: PathBuf,
    /// Align the others with the first: rotate about the vertical and translate, by least squares
    #[arg(long)]
    align: bool,
    /// Axes of trajectories in local metres: enu with a forward-left-up body, ned with a forward-right-down body
    #[arg(long, value_enum, default_value_t = AxesArgument::Enu)]
    axes: AxesArgument,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    let working = Working::on("comparing");
    let axes = arguments.axes.into();
    let open = |path: &PathBuf| NamedTrajectory::open(path, axes);
    let opened: Result<Vec<NamedTrajectory>, LogError> =
        arguments.solution.iter().map(open).collect();
    let comparison =
        Comparison::of(opened.map_err(memory::in_terms_of_features)?, arguments.align)?;
    output::create(&arguments.out)?;
    ComparisonPage::new(&comparison).page().write(&arguments.out.join(output::REPORT))?;
    let mut summary = comparison.to_json();
    summary["wall_s"] = started.elapsed().as_secs_f64().into();
    output::write_json(&summary, &arguments.out.join("summary.json"))?;
    drop(working);
    for difference in &comparison.differences {
        let (of, from) = (comparison.name(difference.of), comparison.name(difference.from));
        output::say(format_args!("{of} less {from}"));
        for axis in &difference.score.axes {
            let (name, size) = (axis.axis.name(), &axis.statistics);
            output::say(format_args!("  {name:<30} {:>9.3} rms {:>9.3} max", size.rmse, size.max));
        }
        if let Some(relative) = &difference.relative {
            for (unit, size) in relative.sizes() {
                let name = format!("relative, over {:.0} s, {unit}", relative.over_s);
                output::say(format_args!(
                    "  {name:<30} {:>9.3} rms {:>9.3} max",
                    size.rmse, size.max
                ));
            }
        }
    }
    output::say(format_args!("{:<32} {}", "written", arguments.out.display()));
    Ok(())
}
