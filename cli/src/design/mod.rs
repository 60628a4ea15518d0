//! `hovernav design`: from a model to the autopilot's gains, checked at the loop's own rate.

mod handling;
mod loops;
mod page;
mod summary;
mod words;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context as _, bail};
use hovernav::autopilot::HoverConfig;
use hovernav_design::CheckedDesign;
use hovernav_design::hover::{HoverDesign, Search, Wanted};
use hovernav_model::{Grade, StateSpace, shipped};

use crate::emit::{self, Form};
use crate::output;

#[derive(clap::Args)]
pub struct Arguments {
    /// A model.toml, or a model that comes with hovernav: thesis, raptor60, r50
    model: String,
    /// Where to write; out/MODEL-autopilot unless given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// A TOML file of weights, poles, servos and period, as `weights` in summary.json has them; without
    /// it weights are searched for
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Design for a model whose own verdict is "do not fly"
    #[arg(long)]
    force: bool,
    /// Write the configuration in this form too, for programs that read no files; may be repeated
    #[arg(long, value_name = "FORM", value_delimiter = ',')]
    emit: Vec<Form>,
    /// Write no report.html
    #[arg(long)]
    no_report: bool,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    let model = shipped::open(&arguments.model)?;
    if !arguments.force {
        refuse_unflyable(&model, &arguments.model)?;
    }
    let (design, search) = match &arguments.weights {
        None => {
            let start = HoverDesign::for_model(&model);
            let working = output::Working::on("searching for weights");
            let search = start.searched(&model, &Wanted::default());
            drop(working);
            let search = search.with_context(|| arguments.model.clone())?;
            (search.design.clone(), Some(search))
        }
        Some(path) => (HoverDesign::read(path)?, None),
    };
    let mut checked = CheckedDesign::new(model, design).with_context(|| arguments.model.clone())?;
    if let Some(verdict) = checked.model.verdict().filter(|verdict| verdict.grade != Grade::Good) {
        let reasons = verdict.reasons.join("; ");
        checked
            .warnings
            .insert(0, format!("the model\u{2019}s verdict is \"{}\": {reasons}", verdict.grade));
    }
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
    emit::autopilot(&config, &remark, &arguments.emit, &out)?;
    if !arguments.no_report {
        page::write(&checked, &out.join("report.html"))?;
    }
    let mut summary = summary::summary(&checked, &arguments.model);
    if let Some(Search { shortfall, trials, .. }) = search {
        summary["search"] = serde_json::json!({ "trials": trials, "shortfall": shortfall[0], "at_start": shortfall[1] });
    }
    summary["wall_s"] = started.elapsed().as_secs_f64().into();
    output::write_json(&summary, &out.join("summary.json"))?;
    output::say_text(words::in_words(&checked, &out));
    Ok(())
}

/// Refuses a `model` that says itself that it is not to be flown by; `name` is how it was given.
pub fn refuse_unflyable(model: &StateSpace, name: &str) -> anyhow::Result<()> {
    match model.verdict() {
        Some(verdict) if verdict.grade == Grade::DoNotFly => bail!(
            "{name}: found the verdict \"do not fly\" ({}), expected a model to fly by; --force designs \
             all the same",
            verdict.reasons.join("; ")
        ),
        _ => Ok(()),
    }
}
