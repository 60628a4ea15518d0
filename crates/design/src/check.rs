//! A hover design with everything that is checked of it before it is flown.

use super::disturbance::{DisturbanceResponse, TABLE_6_1};
use super::error::DesignError;
use super::handling::HandlingQualities;
use super::hover::{Cut, FlightMode, HoverDesign, PerturbedStability};
use super::margins::{Loop, Margins};
use super::thesis::PrintedDesign;
use hovernav::autopilot::Gains;
use hovernav::controls::Sticks;
use hovernav_model::{StateSpace, shipped};

/// A design and everything that was checked of it at the loop's own rate.
#[derive(Clone, Debug)]
pub struct CheckedDesign {
    /// What it is designed for.
    pub model: StateSpace,
    /// What was asked for.
    pub design: HoverDesign,
    /// What the autopilot flies with.
    pub gains: Gains,
    /// The loop, cut open at the actuators.
    pub closed: Loop,
    /// How far it is from instability.
    pub margins: Margins,
    /// The same in every mode that flies, cut at the actuators; `None` where the mode is unstable.
    pub modes: Vec<(FlightMode, Option<Margins>)>,
    /// And cut at what is measured, holding velocity.
    pub at_outputs: Option<Margins>,
    /// Handling qualities of phi, theta and psi, holding attitude.
    pub handling: Vec<HandlingQualities>,
    /// How many models with every derivative off it keeps stable.
    pub perturbed: PerturbedStability,
    /// Spectral radius of the closed loop.
    pub spectral_radius: f64,
    /// What becomes of [`TABLE_6_1`] with the sticks at trim.
    pub open_responses: Vec<DisturbanceResponse>,
    /// What becomes of it in the loops.
    pub responses: Vec<DisturbanceResponse>,
    /// For the model as the thesis prints it, its own design.
    pub printed: Option<CheckedPrintedDesign>,
    /// What a reader must know, one plain sentence each.
    pub warnings: Vec<String>,
}

/// The design that the thesis prints, and what becomes of the disturbances in it.
#[derive(Clone, Debug)]
pub struct CheckedPrintedDesign {
    /// The design.
    pub design: PrintedDesign,
    /// What becomes of [`TABLE_6_1`] in its loops.
    pub responses: Vec<DisturbanceResponse>,
    /// Spectral radii of roll and pitch, and of heave, held at the loop's rate.
    pub spectral_radii: [f64; 2],
}

/// The margins below which a loop is warned of.
const LEAST_GAIN_DB: f64 = 6.0;
const LEAST_PHASE_DEG: f64 = 45.0;

impl CheckedDesign {
    /// How long disturbances are followed, s.
    pub const FOLLOWED_S: f64 = 20.0;

    /// Designs the gains for `model`, closes the loop and checks it.
    ///
    /// # Errors
    /// [`DesignError`] where the model cannot be designed for.
    pub fn new(model: StateSpace, design: HoverDesign) -> Result<Self, DesignError> {
        let gains = design.synthesise(&model)?;
        let closed = design.close(&model, &gains)?;
        let poles = closed.closed_poles()?;
        let spectral_radius = poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
        let margins = closed.margins()?;
        let respond = |disturbance| design.respond(&model, &gains, disturbance, Self::FOLLOWED_S);
        let drift = |disturbance| design.drift(&model, disturbance, Self::FOLLOWED_S);
        let responses = TABLE_6_1.into_iter().map(respond).collect::<Result<Vec<_>, _>>()?;
        let open_responses = TABLE_6_1.into_iter().map(drift).collect::<Result<_, _>>()?;
        let in_mode = |mode| -> Result<_, DesignError> {
            Ok((mode, design.close_in(&model, &gains, mode, Cut::Actuators)?.margins().ok()))
        };
        let modes = FlightMode::ALL.into_iter().map(in_mode).collect::<Result<Vec<_>, _>>()?;
        let at_outputs =
            design.close_in(&model, &gains, FlightMode::Velocity, Cut::Outputs)?.margins().ok();
        let holding = design.close_in(&model, &gains, FlightMode::Attitude, Cut::Outputs)?;
        let handling = ["phi", "theta", "psi"]
            .into_iter()
            .map(|output| HandlingQualities::of(&holding, output))
            .collect::<Result<_, _>>()?;
        let perturbed = PerturbedStability::of(&design, &model, &gains)?;
        let printed = (model == shipped::thesis())
            .then(|| CheckedPrintedDesign::new(design.period_s))
            .transpose()?;

        let mut warnings: Vec<String> =
            model.step_taken_for_rate(design.period_s).iter().map(ToString::to_string).collect();
        let [cyclic_s, tail_s] = design.late_s(&model);
        for (sticks, late_s, counted_s) in [
            ("cyclic and collective", cyclic_s, design.servo_s),
            ("pedal", tail_s, design.tail_servo_s),
        ] {
            if late_s > counted_s + 1e-9 {
                warnings.push(format!(
                    "the model delays {sticks} by {:.0} ms, of which the design counts {:.0} ms: its margins \
                     are too good by the rest",
                    1e3 * (late_s + design.period_s),
                    1e3 * (counted_s + design.period_s)
                ));
            }
        }
        for (mode, margins) in &modes {
            let Some(margins) = margins else {
                warnings.push(format!("holding {} the loops are unstable", mode.name()));
                continue;
            };
            for channel in &margins.channels {
                let (gain_db, phase_deg) = (channel.smallest_gain_db(), channel.phase_deg());
                if gain_db < LEAST_GAIN_DB || phase_deg < LEAST_PHASE_DEG {
                    // Two digits: one that falls short by little would read as what is expected.
                    warnings.push(format!(
                        "holding {}, the {} loop has {gain_db:.2} dB and {phase_deg:.2}°, expected at \
                         least {LEAST_GAIN_DB} dB and {LEAST_PHASE_DEG}°",
                        mode.name(),
                        channel.name
                    ));
                }
            }
        }
        for response in &responses {
            let DisturbanceResponse { state, size, .. } = response;
            for (stick, peak) in Sticks::NAMES.into_iter().zip(response.stick_peaks()) {
                if peak > 1.0 {
                    warnings.push(format!(
                        "{state} {size} asks for {:.0} % of {stick}: the stick stops at 100 %, and the \
                         times below are those of a loop without stops",
                        100.0 * peak
                    ));
                }
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
            modes,
            at_outputs,
            handling,
            perturbed,
            spectral_radius,
            open_responses,
            responses,
            printed,
            warnings,
        })
    }
}

impl CheckedPrintedDesign {
    fn new(period_s: f64) -> Result<Self, DesignError> {
        let design = PrintedDesign::new()?;
        let respond = |(state, size)| design.respond(state, size, CheckedDesign::FOLLOWED_S, 0.01);
        let responses = TABLE_6_1.into_iter().map(respond).collect::<Result<_, _>>()?;
        let spectral_radii = design.spectral_radii(period_s)?;
        Ok(Self { responses, spectral_radii, design })
    }
}
