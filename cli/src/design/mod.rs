//! `hovernav design`: from a model to the autopilot's gains, checked at the loop's own rate.

mod page;
mod summary;
mod words;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context as _;
use hovernav::autopilot::HoverConfig;
use hovernav_design::CheckedDesign;
use hovernav_design::hover::HoverDesign;
use hovernav_model::shipped;

use crate::output;

#[derive(clap::Args)]
pub struct Arguments {
    /// A model.toml, or a model that comes with hovernav: thesis, raptor60, r50
    model: String,
    /// Where to write; out/MODEL-autopilot unless given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// A TOML file of weights, poles, servos and period, as `weights` in summary.json has them
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Write no report.html
    #[arg(long)]
    no_report: bool,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    let model = shipped::open(&arguments.model)?;
    let design = match &arguments.weights {
        None => HoverDesign::for_model(&model),
        Some(path) => HoverDesign::read(path)?,
    };
    let checked = CheckedDesign::new(model, design).with_context(|| arguments.model.clone())?;
    let out = arguments.out.clone().unwrap_or_else(|| {
        let stem = Path::new(&arguments.model).file_stem().unwrap_or_default();
        Path::new("out").join(format!("{}-autopilot", stem.to_string_lossy()))
    });
    output::create(&out)?;
    let config = HoverConfig::new(checked.design.period_s, checked.gains);
    let remark = format!(
        "Designed by hovernav {} for {} at {:.4} Hz.",
        env!("CARGO_PKG_VERSION"),
        checked.model.name(),
        1.0 / checked.design.period_s
    );
    hovernav_log::write_autopilot(&config, &out.join("autopilot.toml"), &remark)?;
    if !arguments.no_report {
        page::write(&checked, &out.join("report.html"))?;
    }
    let mut summary = summary::summary(&checked, &arguments.model);
    summary["wall_s"] = started.elapsed().as_secs_f64().into();
    output::write_json(&summary, &out.join("summary.json"))?;
    output::say_text(words::in_words(&checked, &out));
    Ok(())
}
