//! `hovernav design`: computes the autopilot's gains for a model and checks them at the sample rate of the loop.

mod gusts;
mod handling;
mod loops;
mod page;
mod robustness;
mod summary;
mod wanted;
mod words;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::ensure;
use hovernav::imu::NotchConfig;
use hovernav_design::hover::{HoverDesign, Search, Wanted};
use hovernav_design::{CheckedDesign, DesignError, NotchCost};
use hovernav_model::{Grade, StateSpace, Unflyable, shipped};

use crate::arguments::{finite, refuse_unflyable};
use crate::emit::{self, Form};
use crate::output;

#[derive(clap::Args)]
pub struct Arguments {
    /// A model.toml, or a model that is part of hovernav: thesis, raptor60, r50
    model: String,
    /// A model of the same vehicle in forward flight: a model.toml of `hovernav identify --speed`, or raptor60@SPEED in
    /// m/s; may be repeated. The gains then keep their margins from hover to the fastest model, and autopilot.toml allows
    /// this speed, in every direction. Backward and sideways flight have no model of their own
    #[arg(long = "at", value_name = "MODEL")]
    ahead: Vec<String>,
    /// Directory to write [default: out/MODEL-autopilot]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// TOML file with weights, poles, servos and period, with the keys of `weights` in summary.json; omitted keys keep
    /// the values that a search starts from. Without this option, the weights are found by a search
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Include the delay of a notch filter on the rotor's harmonics, as in [imu.notch]: frequency, width at half power
    /// and number of harmonics [default width: 4 Hz, harmonics: 1]
    #[arg(long, value_name = "HZ[:WIDTH[:HARMONICS]]", value_parser = notch)]
    notch: Option<NotchConfig>,
    /// Sample rate of the inertial unit whose data the notch filters, Hz [default: rate of the loop]
    #[arg(long, value_name = "HZ", requires = "notch")]
    imu_rate: Option<f64>,
    /// Design for a model even if it must not be flown: one with the verdict "do not fly", without its verdict, or with
    /// a derivative of impossible sign for a helicopter. Write the autopilot even if it is unstable in a mode
    #[arg(long)]
    force: bool,
    /// Also write the configuration in this form, for programs that read no files; may be repeated
    #[arg(long, value_name = "FORM", value_delimiter = ',')]
    emit: Vec<Form>,
    /// Do not write report.html
    #[arg(long)]
    no_report: bool,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    let model = open(&arguments.model)?;
    let ahead =
        arguments.ahead.iter().map(|name| open(name)).collect::<anyhow::Result<Vec<_>>>()?;
    if !arguments.force {
        let names = [&arguments.model].into_iter().chain(&arguments.ahead);
        for (model, name) in [&model].into_iter().chain(&ahead).zip(names) {
            refuse_unflyable(model, name, "--force designs for it anyway")?;
        }
    }
    let out = arguments.out.clone().unwrap_or_else(|| {
        let stem = Path::new(&arguments.model).file_stem().unwrap_or_default();
        Path::new("out").join(format!("{}-autopilot", stem.to_string_lossy()))
    });
    output::create(&out)?;
    // A file of an earlier design could be mistaken for the result of this one.
    let _ = std::fs::remove_file(out.join("autopilot.toml"));
    let start = match &arguments.weights {
        None => HoverDesign::for_model(&model),
        Some(path) => read_weights(path, &model)?,
    };
    let notch = arguments
        .notch
        .map(|config| NotchCost::new(config, arguments.imu_rate.unwrap_or(1.0 / start.period_s)));
    let notch = notch.transpose()?;
    let start = HoverDesign {
        notch_s: notch.as_ref().map_or(start.notch_s, |notch| notch.delay_s),
        ..start
    };
    let (design, search) = match &arguments.weights {
        None => {
            let working = output::Working::on("searching for weights");
            let wanted = Wanted::default();
            let search = start.searched(&model, &ahead, &wanted);
            drop(working);
            let search = search.map_err(|error| named(error, &arguments.model))?;
            (search.design.clone(), Some((search, wanted)))
        }
        Some(_) => (start, None),
    };
    let checked =
        CheckedDesign::new(model, design).map_err(|error| named(error, &arguments.model))?;
    let mut checked = checked.with_forward(&ahead)?;
    if let Some(notch) = notch {
        checked = checked.with_notch(notch);
    }
    for own in ahead.iter().chain([&checked.model]) {
        if let Some(verdict) = own.verdict().filter(|verdict| verdict.grade != Grade::Good) {
            let (name, grade, reasons) = (own.name(), verdict.grade, verdict.reasons.join("; "));
            let warning = format!("the verdict of the model {name} is \"{grade}\": {reasons}");
            checked.warnings.insert(0, warning);
        }
    }
    // The verdict of the model is already among the warnings.
    if let Some(why @ (Unflyable::NoVerdict { .. } | Unflyable::Sign(_))) =
        checked.model.unflyable()
    {
        checked.warnings.insert(0, format!("the model must not be flown: {why}"));
    }
    let config = checked.autopilot();
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
        hovernav_record::write_autopilot(&config, &out.join("autopilot.toml"), &remark)?;
        emit::autopilot(&config, &remark, &arguments.emit, &out)?;
    }
    if !arguments.no_report {
        page::write(&checked, search.as_ref(), &out.join(output::REPORT))?;
    } else {
        output::remove_stale(&out, [output::REPORT]);
    }
    let mut summary = summary::summary(&checked, &arguments.model);
    if let Some((Search { shortfall, trials, .. }, _)) = search {
        summary["search"] = serde_json::json!({ "trials": trials, "shortfall": shortfall[0], "at_start": shortfall[1] });
    }
    summary["wall_s"] = started.elapsed().as_secs_f64().into();
    output::write_json(&summary, &out.join("summary.json"))?;
    output::say_text(words::in_words(&checked, &out));
    ensure!(
        is_written,
        "{}: the loops are unstable in the mode {}: no autopilot.toml is written; --force writes it anyway",
        arguments.model,
        unstable.join(" and ")
    );
    Ok(())
}

/// The model with this name or in this file, which must describe the whole hover.
fn open(name: &str) -> anyhow::Result<StateSpace> {
    ensure!(
        shipped::by_name(name).is_some() || name.contains('@') || Path::new(name).exists(),
        "{name}: no such file, expected a model.toml, or thesis, raptor60, raptor60@SPEED or r50"
    );
    let model = shipped::open(name)?;
    let has = |state: &str| model.states().iter().any(|signal| signal.name == state);
    let missing: Vec<&str> = ["p", "q", "r", "w"].into_iter().filter(|state| !has(state)).collect();
    ensure!(
        missing.is_empty(),
        "{name}: found a model without {}, expected a model of the whole hover, for example from \
         `hovernav identify --model hybrid`",
        missing.join(", ")
    );
    Ok(model)
}

fn notch(text: &str) -> Result<NotchConfig, String> {
    let expected = || {
        format!(
            "found \"{text}\", expected HZ[:WIDTH[:HARMONICS]], frequencies above 0 and 1 to 4 harmonics"
        )
    };
    let numbers: Option<Vec<f64>> = text.split(':').map(finite).collect();
    let config = match numbers.as_deref() {
        Some(&[hz]) => NotchConfig::at_hz(hz),
        Some(&[hz, width]) => NotchConfig::at_hz(hz).with_width_hz(width),
        Some(&[hz, width, harmonics])
            if (1.0..=4.0).contains(&harmonics) && harmonics.fract() == 0.0 =>
        {
            NotchConfig::at_hz(hz).with_width_hz(width).with_harmonics(harmonics as u32)
        }
        _ => return Err(expected()),
    };
    let is_one = config.frequency_hz > 0.0 && config.out_of_range().is_none();
    is_one.then_some(config).ok_or_else(expected)
}

/// `error` with the name of the model, unless it already has one.
fn named(error: DesignError, model: &str) -> anyhow::Error {
    match error {
        error @ DesignError::At { .. } => error.into(),
        other => anyhow::Error::new(other).context(model.to_owned()),
    }
}

/// The design in a file. An error names the file.
fn read_weights(path: &Path, model: &StateSpace) -> anyhow::Result<HoverDesign> {
    HoverDesign::read(path, model).map_err(|error| match error {
        // These errors already name the file.
        DesignError::Toml(error) => error.into(),
        surplus @ DesignError::Surplus { .. } => surplus.into(),
        other => anyhow::Error::new(other).context(path.display().to_string()),
    })
}
