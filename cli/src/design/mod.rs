//! `hovernav design`: from a model to the autopilot's gains, checked at the loop's own rate.

mod page;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context as _;
use hovernav::autopilot::{Gains, HoverConfig};
use hovernav_design::hover::HoverDesign;
use hovernav_design::thesis::PrintedDesign;
use hovernav_design::{ChannelMargins, DisturbanceResponse, Loop, Margins, TABLE_6_1};
use hovernav_model::StateSpace;
use serde_json::{Value, json};

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

/// How long disturbances are followed, s.
const FOLLOWED_S: f64 = 20.0;

/// A design and everything that was checked of it.
pub struct Checked {
    pub model: StateSpace,
    pub design: HoverDesign,
    pub gains: Gains,
    pub closed: Loop,
    pub margins: Margins,
    /// Spectral radius of the closed loop.
    pub radius: f64,
    /// What becomes of [`TABLE_6_1`] with the sticks at trim, and in the loops.
    pub open_responses: Vec<DisturbanceResponse>,
    pub responses: Vec<DisturbanceResponse>,
    /// For the model as the thesis prints it, its own design.
    pub printed: Option<Printed>,
    pub warnings: Vec<String>,
}

/// The design that the thesis prints, and what becomes of the disturbances in it.
pub struct Printed {
    pub design: PrintedDesign,
    pub responses: Vec<DisturbanceResponse>,
    /// Spectral radii of roll and pitch, and of heave, held at the loop's rate.
    pub radii: [f64; 2],
}

/// The design for a model: its own weights where the library has some for it.
pub fn design_for(model: &StateSpace) -> HoverDesign {
    match model.name() {
        "thesis-hover" => HoverDesign::thesis(),
        _ => HoverDesign::default(),
    }
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    let model = crate::model::open(&arguments.model)?;
    let design = match &arguments.weights {
        None => design_for(&model),
        Some(path) => HoverDesign::read(path)?,
    };
    let checked = Checked::new(model, design).with_context(|| arguments.model.clone())?;
    let out = arguments.out.clone().unwrap_or_else(|| {
        let stem = Path::new(&arguments.model).file_stem().unwrap_or_default();
        Path::new("out").join(format!("{}-autopilot", stem.to_string_lossy()))
    });
    std::fs::create_dir_all(&out).with_context(|| format!("cannot create {}", out.display()))?;
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
    let mut summary = checked.summary(&arguments.model);
    summary["wall_s"] = started.elapsed().as_secs_f64().into();
    crate::summary::write_json(&summary, &out.join("summary.json"))?;
    print!("{}", checked.in_words(&out));
    Ok(())
}

impl Checked {
    pub fn new(model: StateSpace, design: HoverDesign) -> anyhow::Result<Self> {
        let gains = design.synthesise(&model)?;
        let closed = design.close(&model, &gains)?;
        let poles = closed.closed_poles()?;
        let radius = poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
        let margins = closed.margins()?;
        let respond = |disturbance| design.respond(&model, &gains, disturbance, FOLLOWED_S);
        let drift = |disturbance| design.drift(&model, disturbance, FOLLOWED_S);
        let responses = TABLE_6_1.into_iter().map(respond).collect::<Result<Vec<_>, _>>()?;
        let open_responses = TABLE_6_1.into_iter().map(drift).collect::<Result<_, _>>()?;
        let printed = (model == hovernav_model::shipped::thesis())
            .then(|| Printed::new(design.period_s))
            .transpose()?;

        let mut warnings: Vec<String> =
            model.step_taken_for_rate(design.period_s).iter().map(ToString::to_string).collect();
        for channel in &margins.channels {
            let (gain_db, phase_deg) = (smallest_gain_db(channel), phase_deg(channel));
            if gain_db < 6.0 || phase_deg < 45.0 {
                warnings.push(format!(
                    "the {} loop has {gain_db:.1} dB and {phase_deg:.0}°, expected 6 dB and 45°",
                    channel.name
                ));
            }
        }
        for response in responses.iter().filter(|r| r.recovered_s(0.05).is_none_or(|s| s > 8.0)) {
            let DisturbanceResponse { state, size, .. } = response;
            warnings.push(format!("{state} {size} is not back at trim within 8 s"));
        }
        Ok(Self {
            model,
            design,
            gains,
            closed,
            margins,
            radius,
            open_responses,
            responses,
            printed,
            warnings,
        })
    }

    fn summary(&self, input: &str) -> Value {
        let margins: serde_json::Map<String, Value> = self
            .margins
            .channels
            .iter()
            .map(|channel| {
                let ChannelMargins { name, gain_up, gain_down, phase, delay_s, .. } = channel;
                let db = |crossing: &hovernav_design::Crossing| 20.0 * crossing.margin.log10();
                let value = json!({
                    "gain_up_db": gain_up.as_ref().map(db),
                    "gain_down_db": gain_down.as_ref().map(db),
                    "phase_deg": phase.map(|phase| phase.margin.to_degrees()),
                    "crossover_radps": phase.map(|phase| phase.frequency_radps),
                    "delay_s": delay_s,
                    "disturbance_rejection_bandwidth_radps":
                        channel.disturbance_rejection_bandwidth_radps,
                });
                (name.clone(), value)
            })
            .collect();
        let disturbances = |responses: &[DisturbanceResponse]| -> Value {
            let told = responses.iter().map(|response| {
                let value = json!({
                    "size": response.size,
                    "settled_s": response.settled_s(),
                    "recovered_s": response.recovered_s(0.05),
                    "stick_peaks": response.stick_peaks(),
                });
                (response.state.clone(), value)
            });
            Value::Object(told.collect())
        };
        let mut summary = json!({
            "tool": "hovernav",
            "version": env!("CARGO_PKG_VERSION"),
            "input": input,
            "duration_s": FOLLOWED_S,
            "wall_s": 0.0,
            "imu_samples": 0,
            "gps_fixes_used": 0,
            "gps_fixes_rejected": 0,
            "model": self.model.name(),
            "period_s": self.design.period_s,
            "closed_loop_spectral_radius": self.radius,
            "margins": margins,
            "disk_margin": {
                "gain": self.margins.disk_gain(),
                "phase_deg": self.margins.disk_phase_rad().to_degrees(),
            },
            "sensitivity_peak": self.margins.sensitivity.value,
            "disturbances": disturbances(&self.responses),
            "weights": self.design,
            "warnings": self.warnings,
        });
        if let Some(printed) = &self.printed {
            let rows = |gain: &hovernav_design::Regulator| -> Vec<Vec<f64>> {
                gain.gain.row_iter().map(|row| row.iter().copied().collect()).collect()
            };
            summary["printed_design"] = json!({
                "roll_pitch_gain": rows(&printed.design.roll_pitch),
                "yaw_gain": rows(&printed.design.yaw),
                "disturbances": disturbances(&printed.responses),
                "spectral_radius_held": {
                    "roll_pitch": printed.radii[0],
                    "heave": printed.radii[1],
                },
            });
        }
        summary
    }

    fn in_words(&self, out: &Path) -> String {
        let mut text = format!(
            "{}: {} at {:.1} Hz, spectral radius of the closed loop {:.4}\n\n",
            out.display(),
            self.model.name(),
            1.0 / self.design.period_s,
            self.radius
        );
        let _ = writeln!(
            text,
            "{:>14}  {:>8}  {:>8}  {:>7}  {:>9}",
            "loop", "gain up", "down", "phase", "delay"
        );
        for channel in &self.margins.channels {
            let ChannelMargins { name, gain_up, gain_down, delay_s, .. } = channel;
            let db = |crossing: &Option<hovernav_design::Crossing>| match crossing {
                Some(crossing) => format!("{:.1} dB", 20.0 * crossing.margin.log10()),
                None => "any".into(),
            };
            let delay = delay_s.map_or_else(|| "any".into(), |s| format!("{:.0} ms", 1e3 * s));
            let (up, down, phase) = (db(gain_up), db(gain_down), phase_deg(channel));
            let _ = writeln!(text, "{name:>14}  {up:>8}  {down:>8}  {phase:>6.1}°  {delay:>9}");
        }
        let _ =
            writeln!(text, "\n{:>14}  {:>12}  {:>14}", "disturbance", "within 5 %", "all at trim");
        for response in &self.responses {
            let seconds = |s: Option<f64>| s.map_or_else(|| "-".into(), |s| format!("{s:.2} s"));
            let name = format!("{} {}", response.state, response.size);
            let (own, all) = (seconds(response.recovered_s(0.05)), seconds(response.settled_s()));
            let _ = writeln!(text, "{name:>14}  {own:>12}  {all:>14}");
        }
        if let Some(printed) = &self.printed {
            text.push_str(&printed.in_words(1.0 / self.design.period_s));
        }
        for warning in &self.warnings {
            let _ = writeln!(text, "\nwarning: {warning}");
        }
        text
    }
}

impl Printed {
    fn new(period_s: f64) -> anyhow::Result<Self> {
        let design = PrintedDesign::new()?;
        let respond = |(state, size)| design.respond(state, size, FOLLOWED_S, 0.01);
        let responses = TABLE_6_1.into_iter().map(respond).collect::<Result<_, _>>()?;
        let radii = design.spectral_radii(period_s)?;
        Ok(Self { responses, radii, design })
    }

    /// What the thesis prints and what comes out, one sentence a line.
    pub fn findings(&self, rate_hz: f64) -> anyhow::Result<Vec<String>> {
        let row = |row: Vec<f64>| {
            row.iter().map(|value| five_digits(*value)).collect::<Vec<_>>().join(", ")
        };
        let rows = |gain: &hovernav_design::Regulator| {
            let rows = gain.gain.row_iter().map(|own| row(own.iter().copied().collect()));
            rows.collect::<Vec<_>>().join("; ")
        };
        let poles = self.design.heave_poles()?;
        let [pole, ..] = &poles[..] else { return Ok(Vec::new()) };
        let [(roll_pitch, roll_pitch_seen), (yaw, yaw_seen)] = self.design.reach()?;
        let [roll_pitch_radius, heave_radius] = self.radii;
        Ok(vec![
            format!("roll and pitch, K = [{}]", rows(&self.design.roll_pitch)),
            format!("yaw, K = [{}]", rows(&self.design.yaw)),
            format!("heave, closed-loop poles {:.2} ± {:.2}i", pole.re, pole.im.abs()),
            format!(
                "ranks of controllability and observability: roll and pitch {} and {}, yaw {} and {}",
                roll_pitch.rank, roll_pitch_seen.rank, yaw.rank, yaw_seen.rank
            ),
            format!(
                "held at {rate_hz:.0} Hz it is unstable: spectral radius {roll_pitch_radius:.1} in roll \
                 and pitch, {heave_radius:.1} in heave"
            ),
        ])
    }

    fn in_words(&self, rate_hz: f64) -> String {
        let findings = self.findings(rate_hz).unwrap_or_default();
        let lines: String = findings.iter().map(|finding| format!("  {finding}\n")).collect();
        format!("\nthe design as printed, continuous:\n{lines}")
    }
}

/// As many digits as the thesis prints.
fn five_digits(value: f64) -> String {
    let size = value.abs().max(1e-12).log10().floor();
    format!("{value:.*}", (4.0 - size).clamp(0.0, 6.0) as usize)
}

/// The smaller of gain up and gain down, dB.
pub fn smallest_gain_db(channel: &ChannelMargins) -> f64 {
    let margins = [channel.gain_up, channel.gain_down];
    let db = margins.into_iter().flatten().map(|crossing| (20.0 * crossing.margin.log10()).abs());
    db.fold(f64::INFINITY, f64::min)
}

/// Phase margin, °, infinite where there is none to speak of.
pub fn phase_deg(channel: &ChannelMargins) -> f64 {
    channel.phase.map_or(f64::INFINITY, |phase| phase.margin.to_degrees())
}
