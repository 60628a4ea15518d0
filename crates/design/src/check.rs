//! A hover design with all its checks before flight.

use super::disturbance::{DisturbanceResponse, TABLE_6_1};
use super::error::DesignError;
use super::handling::HandlingQualities;
use super::hover::{
    Cut, EstimatorLag, FlightMode, ForwardFlight, GustResponse, Gusts, HoverDesign,
    PerturbedStability, SampledRobustness,
};
use super::margins::{ChannelMargins, Loop, Margins};
use super::nichols::ZONE;
use super::notch::NotchCost;
use super::thesis::PrintedDesign;
use hovernav::autopilot::{Gains, HoverConfig, StickLimits};
use hovernav::controls::Sticks;
use hovernav_model::{StateSpace, shipped};

/// A design and its checks at the sample rate of the loop.
#[derive(Clone, Debug)]
pub struct CheckedDesign {
    /// Model of the design.
    pub model: StateSpace,
    /// Settings of the design.
    pub design: HoverDesign,
    /// Gains of the autopilot.
    pub gains: Gains,
    /// The closed loop, broken at the actuators for the margins.
    pub closed: Loop,
    /// Stability margins of the loop.
    pub margins: Margins,
    /// Margins in every flight mode, with the loops broken at the actuators; `None` where the mode is unstable.
    pub modes: Vec<(FlightMode, Option<Margins>)>,
    /// Lag of the estimator in the design, or the typical lag if the design includes none.
    pub lag: EstimatorLag,
    /// Smallest margins of each flight mode, dB and °, without and with [`lag`](Self::lag).
    pub by_lag: Vec<[(f64, f64); 2]>,
    /// Margins in the mode that holds velocity, with the loops broken at the measurements.
    pub at_outputs: Option<Margins>,
    /// Handling qualities of phi, theta and psi in the mode that holds attitude.
    pub handling: Vec<HandlingQualities>,
    /// Number of stable models among those with every derivative perturbed, in each flight mode.
    pub perturbed: PerturbedStability,
    /// Robustness on vehicles drawn from the covariance of the model's parameters, if the model has one.
    pub sampled: Option<SampledRobustness>,
    /// Spectral radius of the closed loop.
    pub spectral_radius: f64,
    /// Responses to [`TABLE_6_1`] with the sticks at trim.
    pub open_responses: Vec<DisturbanceResponse>,
    /// Responses to [`TABLE_6_1`] in closed loop, without limits of the sticks.
    pub responses: Vec<DisturbanceResponse>,
    /// Responses to [`TABLE_6_1`] in closed loop, with the autopilot's limits on stick travel and rate.
    pub limited: Vec<DisturbanceResponse>,
    /// Margins in forward flight, if models of it were given.
    pub forward: Option<ForwardFlight>,
    /// Phase loss by a notch before the estimator, if the design has a notch. The margins include it.
    pub notch: Option<NotchCost>,
    /// Gusts of the analysis.
    pub gusts: Gusts,
    /// Responses to the gusts in the modes that hold velocity and position; unstable modes are omitted.
    pub in_gusts: Vec<(FlightMode, GustResponse)>,
    /// The design printed in the thesis, if the model is the one printed there.
    pub printed: Option<CheckedPrintedDesign>,
    /// Warnings for the reader, one sentence each.
    pub warnings: Vec<String>,
}

/// The design printed in the thesis, and its responses to the disturbances.
#[derive(Clone, Debug)]
pub struct CheckedPrintedDesign {
    /// The design.
    pub design: PrintedDesign,
    /// Responses to [`TABLE_6_1`] in closed loop.
    pub responses: Vec<DisturbanceResponse>,
    /// Spectral radii of the roll-and-pitch loop and of the heave loop, with sticks held between samples of the loop.
    pub spectral_radii: [f64; 2],
}

/// Gain margin, dB, below which a loop causes a warning.
const MIN_GAIN_DB: f64 = ZONE.0;
/// Phase margin, °, below which a loop causes a warning.
const MIN_PHASE_DEG: f64 = ZONE.1;
/// Longest acceptable recovery from a disturbance, s.
const LONGEST_S: f64 = 8.0;
/// Speed, m/s, that an autopilot may command even if the margins in forward flight are too small.
const SLOW_MPS: f64 = 1.0;
/// Largest speed, m/s, that an autopilot may command.
const FASTEST_MPS: f64 = 15.0;
/// Number of frequencies for approximate margins.
const QUICK_FREQUENCIES: usize = 600;

impl CheckedDesign {
    /// Length of the simulated responses to disturbances, s.
    pub const FOLLOWED_S: f64 = 20.0;

    /// Designs the gains for `model`, closes the loop and checks it.
    ///
    /// # Errors
    /// [`DesignError`] where no design is possible for the model.
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
        let modes = design.margins_in_modes(&model, &gains)?;
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
                    "the model delays {sticks} by {:.0} ms, but the design includes only {:.0} ms: its margins \
                     are too optimistic",
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
                "the margins do not include the estimator lag: with a lag of {:.1} ms in rates, {:.1} ms in attitude \
                 and {:.1} ms in velocity the smallest are {gain_db:.1} dB and {phase_deg:.1}°",
                1e3 * lag.rate_s,
                1e3 * lag.attitude_s,
                1e3 * lag.velocity_s
            ));
        }
        for (mode, margins) in &modes {
            let Some(margins) = margins else {
                warnings.push(format!("holding {}, the loops are unstable", mode.name()));
                continue;
            };
            for channel in &margins.channels {
                let (gain_db, phase_deg) = (channel.smallest_gain_db(), channel.phase_deg());
                if gain_db < MIN_GAIN_DB || phase_deg < MIN_PHASE_DEG {
                    // Two decimals: a small deficit would otherwise be rounded to the expected value.
                    warnings.push(format!(
                        "holding {}, the {} loop has margins of {gain_db:.2} dB and {phase_deg:.2}°, expected at \
                         least {MIN_GAIN_DB} dB and {MIN_PHASE_DEG}°",
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
                "{} of {of} vehicles drawn from the covariance of the model\u{2019}s parameters are unstable in at \
                 least one flight mode",
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
                        "holding {} in gusts of {} m/s, {stick} moves by {:.0} % RMS: three times that exceeds \
                         its travel",
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
            forward: None,
            notch: None,
            gusts,
            in_gusts,
            printed,
            warnings,
        })
    }

    /// The checked design with its margins at the speeds of the models `at_speed`; without models the design itself.
    ///
    /// # Errors
    /// [`DesignError::At`] for models that contradict each other or cannot be used.
    pub fn with_forward(mut self, at_speed: &[StateSpace]) -> Result<Self, DesignError> {
        if at_speed.is_empty() {
            return Ok(self);
        }
        let forward = ForwardFlight::of(&self.design, &self.model, &self.gains, at_speed)?;
        // Hover itself has its own warnings.
        let weak = forward.points.iter().filter(|own| own.speed_mps != 0.0 && !own.has_margins());
        self.warnings.extend(weak.map(|point| {
            let found = point.weakest().map_or_else(
                || "a flight mode is unstable".to_owned(),
                |[gain_db, phase_deg, _]| {
                    format!("the weakest margins are {gain_db:.2} dB and {phase_deg:.2}°")
                },
            );
            let speed_mps = point.speed_mps;
            format!("at {speed_mps:.1} m/s {found}, expected at least {MIN_GAIN_DB} dB and {MIN_PHASE_DEG}°")
        }));
        self.warnings.extend(forward.apart_mps.iter().map(|[slow, fast]| {
            format!(
                "the models at {slow:.1} and {fast:.1} m/s have different states: no speed between them is checked"
            )
        }));
        self.forward = Some(forward);
        Ok(self)
    }

    /// The configuration of the autopilot with these gains. With models of forward flight, the largest commanded
    /// speed is the speed up to which the margins suffice, limited to 1 m/s to 15 m/s. It applies in every direction,
    /// also in those without a model.
    #[must_use]
    pub fn autopilot(&self) -> HoverConfig {
        let mut config = HoverConfig::new(self.design.period_s, self.gains);
        if let Some(allowed_mps) = self.forward.as_ref().and_then(ForwardFlight::allowed_mps) {
            config.guidance.speed_mps = allowed_mps.clamp(SLOW_MPS, FASTEST_MPS);
        }
        config
    }

    /// The flight mode and loop with the weakest margins relative to the required 6 dB and 45°. Unstable modes have no
    /// margins and are not considered; [`modes`](Self::modes) lists them. `None` where every mode is unstable.
    #[must_use]
    pub fn weakest(&self) -> Option<(FlightMode, &ChannelMargins)> {
        let of_modes = self.modes.iter().filter_map(|(mode, own)| Some((*mode, own.as_ref()?)));
        let channels =
            of_modes.flat_map(|(mode, own)| own.channels.iter().map(move |own| (mode, own)));
        let part = |own: &ChannelMargins| {
            (own.smallest_gain_db() / MIN_GAIN_DB).min(own.phase_deg() / MIN_PHASE_DEG)
        };
        channels.min_by(|(_, one), (_, other)| part(one).total_cmp(&part(other)))
    }

    /// The checked design with the phase loss by `notch`. The design must include the delay of the notch in its
    /// [`notch_s`](HoverDesign::notch_s).
    #[must_use]
    pub fn with_notch(mut self, notch: NotchCost) -> Self {
        if notch.delay_s == 0.0 {
            self.warnings.push(format!(
                "a notch at {} Hz cannot remove the rotor: sampled at {} Hz its vibration appears too close to the \
                 vehicle\u{2019}s own motion",
                notch.config.frequency_hz, notch.imu_hz
            ));
        }
        self.notch = Some(notch.on(&self.margins));
        self
    }
}

/// Warnings about the response to one disturbance. `linear` is the response without stick limits, `within` the response
/// with stick limits.
fn of_limits(linear: &DisturbanceResponse, within: &DisturbanceResponse) -> Vec<String> {
    let DisturbanceResponse { state, size, .. } = linear;
    let [free_s, within_s] = [linear, within].map(|own| own.recovered_s(0.05));
    let mut sentences = Vec::new();
    for (stick, peak) in Sticks::NAMES.into_iter().zip(linear.stick_peaks()) {
        if peak > 1.0 {
            let told = within_s.map_or_else(
                || "does not recover".to_owned(),
                |s| format!("recovers to within 5 % in {s:.1} s"),
            );
            let free = free_s.map_or_else(|| "never".to_owned(), |s| format!("in {s:.1} s"));
            sentences.push(format!(
                "{state} {size} commands {:.0} % of {stick}: limited to 100 % it {told}; \
                 without stops {free}",
                100.0 * peak
            ));
        }
    }
    let is_late = |s: Option<f64>| s.is_none_or(|s| s > LONGEST_S);
    if is_late(free_s) {
        sentences.push(format!("{state} {size} does not return to trim within 8 s"));
    } else if is_late(within_s) {
        sentences.push(format!(
            "{state} {size} does not return to trim within 8 s with limited stick travel and rate"
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
