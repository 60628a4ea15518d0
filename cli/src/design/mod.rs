//! `hovernav design`: from a model to the autopilot's gains, checked at the loop's own rate.

mod handling;
mod loops;
mod page;
mod summary;
mod words;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context as _, ensure};
use hovernav::autopilot::HoverConfig;
use hovernav_design::hover::{HoverDesign, Search, Wanted};
use hovernav_design::{CheckedDesign, DesignError};
use hovernav_model::{Grade, shipped};

use crate::arguments::refuse_unflyable;
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
    /// Design for a model whose own verdict is "do not fly", and write an autopilot that is unstable in a
    /// mode
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
        refuse_unflyable(&model, &arguments.model, "--force designs all the same")?;
    }
    let out = arguments.out.clone().unwrap_or_else(|| {
        let stem = Path::new(&arguments.model).file_stem().unwrap_or_default();
        Path::new("out").join(format!("{}-autopilot", stem.to_string_lossy()))
    });
    output::create(&out)?;
    let (design, search) = match &arguments.weights {
        None => {
            let start = HoverDesign::for_model(&model);
            let working = output::Working::on("searching for weights");
            let search = start.searched(&model, &Wanted::default());
            drop(working);
            let search = search.with_context(|| arguments.model.clone())?;
            (search.design.clone(), Some(search))
        }
        Some(path) => (read_weights(path)?, None),
    };
    let mut checked = CheckedDesign::new(model, design).with_context(|| arguments.model.clone())?;
    if let Some(verdict) = checked.model.verdict().filter(|verdict| verdict.grade != Grade::Good) {
        let reasons = verdict.reasons.join("; ");
        checked
            .warnings
            .insert(0, format!("the model\u{2019}s verdict is \"{}\": {reasons}", verdict.grade));
    }
    let config = HoverConfig::new(checked.design.period_s, checked.gains);
    let remark = format!(
        "Designed by hovernav {} for {} at {:.4} Hz.",
        env!("CARGO_PKG_VERSION"),
        checked.model.name(),
        1.0 / checked.design.period_s
    );
    let unstable = checked.modes.iter().filter(|(_, margins)| margins.is_none());
    let unstable: Vec<&str> = unstable.map(|(mode, _)| mode.name()).collect();
    let is_written = unstable.is_empty() || arguments.force;
    if is_written {
        hovernav_log::write_autopilot(&config, &out.join("autopilot.toml"), &remark)?;
        emit::autopilot(&config, &remark, &arguments.emit, &out)?;
    } else {
        // That of an earlier design would be taken for this one's.
        let _ = std::fs::remove_file(out.join("autopilot.toml"));
    }
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
    ensure!(
        is_written,
        "{}: holding {} the loops are unstable: no autopilot.toml is written; --force writes it all the same",
        arguments.model,
        unstable.join(" and ")
    );
    Ok(())
}

/// The design that the file spells; an error names the file.
fn read_weights(path: &Path) -> anyhow::Result<HoverDesign> {
    HoverDesign::read(path).map_err(|error| match error {
        DesignError::Toml(error) => error.into(),
        other => anyhow::Error::new(other).context(path.display().to_string()),
    })
}
