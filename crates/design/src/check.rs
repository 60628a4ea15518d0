//! A hover design with everything that is checked of it before it is flown.

use super::disturbance::{DisturbanceResponse, TABLE_6_1};
use super::error::DesignError;
use super::handling::HandlingQualities;
use super::hover::{
    Cut, EstimatorLag, FlightMode, GustResponse, Gusts, HoverDesign, PerturbedStability,
    SampledRobustness,
};
use super::margins::{Loop, Margins};
use super::notch::NotchCost;
use super::thesis::PrintedDesign;
use hovernav::autopilot::{Gains, StickLimits};
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
    /// The lag of the estimator that the design counts, or where it counts none, what it usually is.
    pub lag: EstimatorLag,
    /// The weakest margins of each of these modes, dB and °, were the motion known without it, and with it.
    pub by_lag: Vec<[(f64, f64); 2]>,
    /// And cut at what is measured, holding velocity.
    pub at_outputs: Option<Margins>,
    /// Handling qualities of phi, theta and psi, holding attitude.
    pub handling: Vec<HandlingQualities>,
    /// How many models with every derivative off it keeps stable.
    pub perturbed: PerturbedStability,
    /// What it is worth on vehicles drawn from the covariance of the model's parameters, where the model tells.
    pub sampled: Option<SampledRobustness>,
    /// Spectral radius of the closed loop.
    pub spectral_radius: f64,
    /// What becomes of [`TABLE_6_1`] with the sticks at trim.
    pub open_responses: Vec<DisturbanceResponse>,
    /// What becomes of it in the loops, were the sticks without stops.
    pub responses: Vec<DisturbanceResponse>,
    /// What becomes of it within the sticks' travel and rate, by the autopilot's own limits.
    pub limited: Vec<DisturbanceResponse>,
    /// What a notch before the estimator costs, where there is one: the margins count it.
    pub notch: Option<NotchCost>,
    /// The gusts that the design is looked at in.
    pub gusts: Gusts,
    /// What they make of it, where it holds velocity and where it holds a place; none where that is unstable.
    pub in_gusts: Vec<(FlightMode, GustResponse)>,
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
/// How long a disturbance may take, s.
const LONGEST_S: f64 = 8.0;
/// Frequencies at which margins are looked at that are told in passing.
const QUICK_FREQUENCIES: usize = 600;

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
        let limits = StickLimits::default();
        let within = |disturbance| {
            design.respond_within(&model, &gains, disturbance, Self::FOLLOWED_S, &limits)
        };
        let limited = TABLE_6_1.into_iter().map(within).collect::<Result<Vec<_>, _>>()?;
        let gusts = Gusts::default();
        let in_gusts: Vec<_> = [FlightMode::Velocity, FlightMode::Position]
            .into_iter()
            .filter_map(|mode| {
                let found = design.in_gusts(&model, &gains, mode, &gusts);
                found.ok().map(|found| (mode, found))
            })
            .collect();
        let drift = |disturbance| design.drift(&model, disturbance, Self::FOLLOWED_S);
        let responses = TABLE_6_1.into_iter().map(respond).collect::<Result<Vec<_>, _>>()?;
        let open_responses = TABLE_6_1.into_iter().map(drift).collect::<Result<_, _>>()?;
        let in_mode = |mode| -> Result<_, DesignError> {
            Ok((mode, design.close_in(&model, &gains, mode, Cut::Actuators)?.margins().ok()))
        };
        let modes = FlightMode::ALL.into_iter().map(in_mode).collect::<Result<Vec<_>, _>>()?;
        let is_counted = design.estimator != EstimatorLag::NONE;
        let lag = if is_counted { design.estimator } else { EstimatorLag::default() };
        let by_lag = FlightMode::ALL
            .into_iter()
            .map(|mode| {
                let weakest = |estimator| -> Result<_, DesignError> {
                    let seen = HoverDesign { estimator, ..design.clone() };
                    let closed = seen.close_in(&model, &gains, mode, Cut::Actuators)?;
                    Ok(closed.weakest(QUICK_FREQUENCIES))
                };
                Ok([weakest(EstimatorLag::NONE)?, weakest(lag)?])
            })
            .collect::<Result<Vec<_>, DesignError>>()?;
        let at_outputs =
            design.close_in(&model, &gains, FlightMode::Velocity, Cut::Outputs)?.margins().ok();
        let holding = design.close_in(&model, &gains, FlightMode::Attitude, Cut::Outputs)?;
        let handling = ["phi", "theta", "psi"]
            .into_iter()
            .map(|output| HandlingQualities::of(&holding, output))
            .collect::<Result<_, _>>()?;
        let perturbed = PerturbedStability::of(&design, &model, &gains)?;
        let sampled = SampledRobustness::of(&design, &model, &gains)?;
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
        if !is_counted {
            let all = || by_lag.iter().map(|[_, with]| *with);
            let phase_deg = all().map(|(_, phase)| phase).fold(f64::INFINITY, f64::min);
            let gain_db = all().map(|(gain, _)| gain).fold(f64::INFINITY, f64::min);
            warnings.push(format!(
                "the margins count no lag of the estimator: with {:.1} ms of rates, {:.1} ms of attitude and \
                 {:.1} ms of velocity the weakest are {gain_db:.1} dB and {phase_deg:.1}°",
                1e3 * lag.rate_s,
                1e3 * lag.attitude_s,
                1e3 * lag.velocity_s
            ));
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
        if let Some(SampledRobustness { of, stable, .. }) = sampled.as_ref()
            && stable < of
        {
            warnings.push(format!(
                "{} of {of} vehicles drawn from the covariance of the model\u{2019}s parameters are unstable in a \
                 mode that flies",
                of - stable
            ));
        }
        for (response, within) in responses.iter().zip(&limited) {
            warnings.extend(of_limits(response, within));
        }
        for (mode, found) in &in_gusts {
            for (stick, rms) in Sticks::NAMES.into_iter().zip(found.sticks) {
                if 3.0 * rms > 1.0 {
                    warnings.push(format!(
                        "holding {} in gusts of {} m/s, {stick} moves by {:.0} % RMS: three times that is more \
                         than its travel",
                        mode.name(),
                        gusts.sigma_mps[0],
                        100.0 * rms
                    ));
                }
            }
        }
        Ok(Self {
            model,
            design,
            gains,
            closed,
            margins,
            modes,
            lag,
            by_lag,
            at_outputs,
            handling,
            perturbed,
            sampled,
            spectral_radius,
            open_responses,
            responses,
            limited,
            notch: None,
            gusts,
            in_gusts,
            printed,
            warnings,
        })
    }

    /// The same, told what the notch costs whose delay the design counts as its
    /// [`notch_s`](HoverDesign::notch_s).
    #[must_use]
    pub fn with_notch(mut self, notch: NotchCost) -> Self {
        if notch.delay_s == 0.0 {
            self.warnings.push(format!(
                "a notch at {} Hz leaves the rotor in: in samples of {} Hz it appears too near to the vehicle\u{2019}s \
                 own motion",
                notch.config.frequency_hz, notch.imu_hz
            ));
        }
        self.notch = Some(notch.on(&self.margins));
        self
    }
}

/// What a reader must know of a disturbance without stops, `linear`, and `within` the sticks' limits.
fn of_limits(linear: &DisturbanceResponse, within: &DisturbanceResponse) -> Vec<String> {
    let DisturbanceResponse { state, size, .. } = linear;
    let [free_s, within_s] = [linear, within].map(|own| own.recovered_s(0.05));
    let mut sentences = Vec::new();
    for (stick, peak) in Sticks::NAMES.into_iter().zip(linear.stick_peaks()) {
        if peak > 1.0 {
            let told = within_s.map_or_else(
                || "does not come back".to_owned(),
                |s| format!("is back within 5 % in {s:.1} s"),
            );
            let free = free_s.map_or_else(|| "never".to_owned(), |s| format!("in {s:.1} s"));
            sentences.push(format!(
                "{state} {size} asks for {:.0} % of {stick}: the stick stops at 100 %, and with that it {told}; \
                 without stops, {free}",
                100.0 * peak
            ));
        }
    }
    let is_late = |s: Option<f64>| s.is_none_or(|s| s > LONGEST_S);
    if is_late(free_s) {
        sentences.push(format!("{state} {size} is not back at trim within 8 s"));
    } else if is_late(within_s) {
        sentences.push(format!(
            "{state} {size} is not back at trim within 8 s where the sticks have their stops and rates"
        ));
    }
    sentences
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
