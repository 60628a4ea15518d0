//! Suitability of the identified model for flight control design, with the reasons.

use std::ops::RangeInclusive;

use hovernav_model::{DerivativeRole, Grade, KnownSign, Verdict};

use super::frequency_domain::FrequencyDomain;
use super::identify::Identification;
use super::model_structure::is_known;
use super::next;
use super::uncertainty::{COST, ResponseUncertainty};
use crate::methods::prediction_error::{ChannelFit, Estimate, Fit, Status};
use crate::methods::structure::Structure;
use crate::methods::validate::GOOD_FIT_PERCENT;

/// Control derivatives and rotor springs: the essentials of a control design.
const CONTROL: [&str; 8] = ["Zcol", "Nped", "Blat", "Alon", "Llat", "Mlon", "Lb", "Ma"];
/// Bounds of a control derivative, percent of its value: good up to the first, usable up to the second.
const CONTROL_PERCENT: [f64; 2] = [15.0, 50.0];
/// Largest bound of a known damping derivative, percent of its value.
const DAMPING_PERCENT: f64 = 100.0;
/// Speed derivatives, which act over seconds.
const SLOW: [&str; 7] = ["Zw", "Xu", "Yv", "Lu", "Lv", "Mu", "Mv"];
/// One sigma, percent of the value, above which a speed derivative is unknown.
const SLOW_PERCENT: f64 = 35.0;
/// Correlation above which two parameters cannot be separated.
const SAME: f64 = 0.98;
/// Range of plausible sums of a stick's delay and lag, s. A flight can leave the two parts unknown.
const LATENESS_S: RangeInclusive<f64> = -0.02..=0.15;
/// Largest correlation of innovations that count as white.
const WHITE: f64 = 0.3;
/// Bound of a parameter, as a fraction of its prior sigma, above which the parameter is not identified.
const UNIDENTIFIED: f64 = 0.95;
/// Outputs that respond to a stick without an integration, each with its stick.
const DIRECT: [(&str, &str); 4] =
    [("p", "lateral"), ("q", "longitudinal"), ("w", "collective"), ("r", "pedal")];
/// Difference between the fit of a perfect model and the fit found, percent, above which the model is incomplete.
const SHORT_PERCENT: f64 = 20.0;
/// Difference between the fit of a perfect model and the fit found, percent, above which the model is worthless.
const WORTHLESS_PERCENT: f64 = 50.0;
/// Speed derivatives that are dampings, with known sign and size.
const DAMPED: [&str; 3] = ["Zw", "Xu", "Yv"];
/// Frequency, rad/s, below which the gain of an attitude loop makes the response of roll and pitch irrelevant.
const ATTITUDE_RADPS: f64 = 2.0;
/// Fastest possible growth of a mode of a hovering helicopter, 1/s.
const GROWTH_PER_S: f64 = 3.0;

impl Identification {
    /// Suitability of the model for flight control design. `frequency` is the identification of the same flight in the
    /// frequency domain, if it succeeded.
    #[must_use]
    pub fn verdict(&self, frequency: Option<&FrequencyDomain>) -> Verdict {
        let axes = self.response_uncertainties();
        let structure = &self.identified.structure;
        let mut judge = Judge::with(&axes, structure);
        // The cause of many later findings comes first.
        if let Some(early_s) = self.answers_early_s {
            let early_ms = 1e3 * early_s;
            judge.say(Grade::DoNotFly, format!(
                "the sticks are recorded late: the vehicle responds {early_ms:.0} ms before they move. controls.csv is late by about {early_ms:.0} ms plus the lag of the servos, up to 60 ms"
            ));
        }
        if !structure.sticks_act(&self.identified.values()) {
            judge.say(Grade::DoNotFly, "no stick acts on the model".into());
        }
        for estimate in self.parameters() {
            judge.parameter(estimate);
        }
        for (one, other, value) in self.inseparable() {
            // If two parameters act together on a known response, neither of them matters on its own.
            let is_known = [one, other].iter().all(|own| judge.knows_response_of(own));
            judge.say(
                if is_known { Grade::Good } else { Grade::Care },
                format!(
                    "{one} and {other} cannot be separated: their correlation is {value:.3}. {}",
                    next::sweep(next::stick_of(one))
                ),
            );
        }
        if !self.identified.converged {
            judge.say(Grade::Care, "the search ended before it converged".into());
        }
        if self.validation.is_none() {
            judge.say(
                Grade::Care,
                format!("no data were held back for validation. {}", next::again("each stick")),
            );
        }
        if let Some(frequency) = frequency {
            judge.second_opinion(frequency);
        }
        if let Some(validation) = &self.validation {
            judge.held_back(validation);
        }
        for axis in &axes {
            judge.axis(axis);
        }
        let vertical = self.identified.estimates.get("σ n_ew");
        // The frequency responses do not depend on the model of the velocity error.
        let confirmed = frequency.is_some_and(|frequency| {
            let mut pairs = frequency.costs.iter().filter(|pair| pair.stick == "collective");
            pairs.any(|pair| pair.output == "az" && pair.time <= COST)
        });
        if vertical.is_some_and(|error| error.status == Status::OnBound) && !confirmed {
            judge.say(Grade::Care, format!(
                "collective to w: the estimated error of the vertical velocity reached the limit that its smoother states. Gusts may count as this error, and the collective may appear too weak. {}",
                next::steps("collective")
            ));
        }
        let outputs = self.identified.structure.outputs.iter();
        for (output, correlation) in outputs.zip(&self.identified.innovations_correlation) {
            // A fixed output noise does not measure the residual.
            let noise = self.identified.estimates.get(&format!("σ {output}"));
            if *correlation > WHITE && noise.is_some_and(Estimate::is_estimated) {
                judge.say(Grade::Care, format!(
                    "{output}: the innovations are not white: their correlation within 1 s is {correlation:.2}, above {WHITE}. The model lacks an effect that moves {output}. Next: fly in calmer air, or identify a model with more states"
                ));
            }
        }
        for parameter in &self.identified.structure.parameters {
            let found = self.identified.estimates.get(&parameter.name);
            if let (Some(expected), Some(found)) = (parameter.prior, found) {
                judge.against_expected(found, expected);
            }
        }
        for stick in &structure.inputs {
            let delay = self.identified.delay(stick).filter(|delay| delay.is_estimated());
            let lag_s = self.identified.lag(stick).map_or(0.0, |lag| lag.value);
            let late_s = delay.map_or(0.0, |delay| delay.value + lag_s);
            if !LATENESS_S.contains(&late_s) {
                let late = format!("{stick} acts after {:.0} ms", 1e3 * late_s);
                judge.say(Grade::Care, format!("{late}: an implausible delay and lag"));
            }
        }
        judge.slow(self.parameters());
        match self.identified.poles() {
            Ok(poles) => {
                let fastest = poles.iter().map(|pole| pole.value.re).fold(f64::MIN, f64::max);
                if fastest > GROWTH_PER_S {
                    judge.say(Grade::DoNotFly, format!("a mode grows at {fastest:.1} 1/s"));
                }
            }
            Err(error) => {
                judge.say(Grade::DoNotFly, format!("its modes cannot be computed: {error}"));
            }
        }
        // A good verdict has no reasons against it, as model files require.
        let reasons = if judge.grade == Grade::Good { Vec::new() } else { judge.reasons };
        Verdict { grade: judge.grade, reasons }
    }

    /// Reliability of one of the [`parameters`](Self::parameters) alone. The grade is care or worse where the bound
    /// exceeds the value (for a speed derivative, 35 % of the value). The [`verdict`](Self::verdict) accepts a
    /// parameter of grade care where the response that it acts on is known.
    #[must_use]
    pub fn grade_of(&self, estimate: &Estimate) -> Grade {
        let mut judge = Judge::with(&[], &self.identified.structure);
        judge.parameter(estimate);
        let own = self.identified.structure.parameter(&estimate.name);
        let expected = own.and_then(|own| self.identified.structure.parameters[own].prior);
        if let Some(expected) = expected {
            judge.against_expected(estimate, expected);
        }
        let correlated = self.inseparable();
        let is_one_of =
            |(one, other, _): &(&str, &str, f64)| [*one, *other].contains(&&*estimate.name);
        let is_slow = SLOW.contains(&&*estimate.name);
        let known = if is_slow { SLOW_PERCENT } else { DAMPING_PERCENT };
        let is_vague = estimate.is_estimated() && estimate.bound_percent() > known;
        if is_vague || correlated.iter().any(is_one_of) {
            judge.grade = judge.grade.max(Grade::Care);
        }
        judge.grade
    }

    /// Pairs of parameters that cannot be separated, except harmless pairs. A pair is harmless if both parameters are
    /// well known. The delay and lag of one stick are harmless too, because only their sum matters.
    fn inseparable(&self) -> Vec<(&str, &str, f64)> {
        let is_known = |name: &str| {
            let own = self.identified.estimates.get(name);
            own.is_some_and(|own| own.bound_percent() <= CONTROL_PERCENT[0])
        };
        let is_late = |name: &str| name.starts_with("tau_") || name.starts_with("lag_");
        let ending = |name: &str| name.rsplit('_').next().map(str::to_owned);
        let mut pairs = self.strong_correlations(SAME);
        pairs.retain(|(one, other, _)| {
            let is_one_lateness = is_late(one) && is_late(other) && ending(one) == ending(other);
            let is_harmless = is_one_lateness || (is_known(one) && is_known(other));
            !is_harmless
        });
        pairs
    }
}

struct Judge {
    grade: Grade,
    reasons: Vec<String>,
    /// Sticks whose on-axis response is known in the band in which a hover is flown.
    known: Vec<&'static str>,
    /// Control derivatives that no built-in structure has.
    own_control: Vec<String>,
}

impl Judge {
    fn with(axes: &[ResponseUncertainty], structure: &Structure) -> Self {
        let is_certain =
            |axis: &&ResponseUncertainty| axis.cost() <= COST || known_from(axis).is_some();
        let known = axes.iter().filter(is_certain).map(|axis| axis.stick);
        let names = structure.control_derivatives().into_iter();
        let names = names.map(|place| &structure.parameters[place].name);
        Self {
            grade: Grade::Good,
            reasons: Vec::new(),
            known: known.collect(),
            own_control: names.filter(|name| !is_known(name)).cloned().collect(),
        }
    }

    /// Whether the on-axis response is known for the stick to which the derivative `name` belongs.
    fn knows_response_of(&self, name: &str) -> bool {
        self.known.contains(&next::stick_of(name))
    }

    fn say(&mut self, grade: Grade, reason: String) {
        self.grade = self.grade.max(grade);
        self.reasons.push(reason);
    }

    fn second_opinion(&mut self, frequency: &FrequencyDomain) {
        for pair in frequency.costs.iter().filter(|pair| pair.time > COST) {
            let (stick, output, cost) = (&pair.stick, &pair.output, pair.time);
            self.say(Grade::Care, format!(
                "{stick} to {output}: the model does not match the flight\u{2019}s frequency response: cost J {cost:.0}, above {COST}. {}", next::sweep(stick)
            ));
        }
        for own in frequency.parameters.iter().filter(|own| own.disagrees()) {
            let next = next::steps(next::stick_of(&own.name));
            self.say(Grade::Care, format!("{}. {next}", own.in_words()));
        }
    }

    /// Judges the model by `fit`, the fit to the validation data of the model that was identified without them.
    fn held_back(&mut self, fit: &Fit) {
        let is_direct = |channel: &&ChannelFit| DIRECT.iter().any(|(own, _)| *own == channel.name);
        for channel in fit.channels().0.iter().filter(is_direct) {
            let ChannelFit { name, percent, floor_percent: floor, .. } = channel;
            let stick = DIRECT.iter().find(|(own, _)| own == name).map_or("", |(_, stick)| stick);
            let found = format!("held-back flight: {name} fits to {percent:.0} %");
            let next = next::steps(stick);
            if *percent < 0.0 && *percent < floor - WORTHLESS_PERCENT {
                self.say(Grade::DoNotFly, format!(
                    "{found}, worse than no model; a perfect one would reach {floor:.0} %. {next}"
                ));
            } else if *percent < GOOD_FIT_PERCENT && *percent < floor - SHORT_PERCENT {
                self.say(
                    Grade::Care,
                    format!("{found}; a perfect model would reach {floor:.0} %. {next}"),
                );
            } else if *percent < 0.0 {
                self.say(
                    Grade::Care,
                    format!("{found}: gusts and noise move it more than the sticks do. {next}"),
                );
            }
        }
    }

    fn axis(&mut self, axis: &ResponseUncertainty) {
        let (stick, output) = (axis.stick, axis.output);
        let cost = axis.cost();
        if cost <= COST {
            return;
        }
        if let Some(from) = known_from(axis) {
            return self.say(Grade::Good, format!(
                "{stick} to {output}: the response is known from {from:.1} rad/s on; below, an attitude loop suppresses it"
            ));
        }
        let mut why = format!("{:.0} from the parameter bounds", axis.within_bounds);
        if let Some(apart) = axis.between_structures {
            why += &format!(
                ", {apart:.0} from a stabiliser bar that the flight neither confirms nor excludes"
            );
        }
        if let Some(from) = axis.known_from_radps.filter(|_| axis.within_bounds > COST) {
            why += &format!("; from {from:.1} rad/s on below {COST}");
        }
        self.say(
            Grade::Care,
            format!("{stick} to {output}: the response is uncertain: with 10 % probability its cost J exceeds {cost:.0}, {COST} is allowed ({why}). {}", next::sweep(stick)),
        );
    }

    /// Reports a damping derivative about which the flight adds no information: its bound is hardly below the one sigma
    /// of its prior. `expected` is the value of the prior, `sigma` its one sigma.
    fn against_expected(&mut self, found: &Estimate, (expected, sigma): (f64, f64)) {
        let Estimate { name, value, bound, unit, .. } = found;
        if is_damping(name) && found.is_estimated() && *bound > UNIDENTIFIED * sigma {
            self.say(Grade::Care, format!(
                "{name} is not identified by this flight: {value:.3} ± {bound:.3} {unit}; {expected} ± {sigma} is typical. {}",
                next::slow(next::stick_of(name))
            ));
        }
    }

    /// Reports the speed derivatives among `parameters` that are unknown or were dropped, unless a reason names them
    /// already.
    fn slow(&mut self, parameters: &[Estimate]) {
        let is_named = |name: &str| {
            let named = format!("{name} is ");
            self.reasons.iter().any(|reason| reason.starts_with(&named))
        };
        let slow =
            parameters.iter().filter(|own| SLOW.contains(&&*own.name) && !is_named(&own.name));
        let unknown: Vec<String> = slow
            .filter_map(|own| {
                let percent = own.bound_percent();
                match own.status {
                    Status::Dropped => Some(format!("{} (dropped)", own.name)),
                    _ if !own.is_estimated() || percent <= SLOW_PERCENT => None,
                    _ => Some(format!("{} ({percent:.0} %)", own.name)),
                }
            })
            .collect();
        if !unknown.is_empty() {
            // The speed moments are small, of either sign. Where they matter, an earlier reason reports an uncertain
            // response.
            let matters = unknown.iter().any(|own| DAMPED.iter().any(|name| own.starts_with(name)));
            let grade = if matters { Grade::Care } else { Grade::Good };
            self.say(grade, format!(
                "unknown: {} (one sigma above {SLOW_PERCENT} % of the value). This flight does not show how the vehicle responds to its own speed over seconds. {}",
                unknown.join(", "), next::slow("lateral and longitudinal")
            ));
        }
    }

    /// Reports a control derivative of the wrong sign.
    fn way(&mut self, Estimate { name, unit, value, bound, .. }: &Estimate) {
        let Some(known) = KnownSign::of(name) else { return };
        let stick = known.column;
        if matches!(known.role, DerivativeRole::Stick(_))
            && known.sign * value < -KnownSign::SIGMAS * bound
        {
            let (found, objection) = (shown(*value, *bound), known.objection());
            // With a reversed collective an autopilot loses the height immediately.
            let grade = if stick == "collective" { Grade::DoNotFly } else { Grade::Care };
            self.say(grade, format!(
                "{name} is {found} {unit}, {objection}. Is the sign of {stick} reversed in the log?"
            ));
        }
    }

    fn is_control(&self, name: &str) -> bool {
        CONTROL.contains(&name) || self.own_control.iter().any(|own| own == name)
    }

    fn parameter(&mut self, estimate: &Estimate) {
        let Estimate { name, unit, value, bound, .. } = estimate;
        self.way(estimate);
        let is_free = estimate.is_estimated();
        let percent = estimate.bound_percent();
        // The estimated lag of a fast servo may end on its lower limit, zero.
        let is_lag = name.starts_with("lag_");
        if estimate.status == Status::OnBound && !is_lag {
            let grade = if self.is_control(name) { Grade::DoNotFly } else { Grade::Care };
            self.say(
                grade,
                format!(
                    "{name} ended on the limit of its search range, {value:.3} {unit}. {}",
                    next::steps(next::stick_of(name))
                ),
            );
        } else if self.is_control(name) && estimate.status == Status::Held && *value != 0.0 {
            self.say(
                Grade::Care,
                format!("{name} was not identified: it keeps its initial value, {value:.3} {unit}"),
            );
        } else if self.is_control(name)
            && estimate.status == Status::Dropped
            && !CONTROL.contains(&name.as_str())
        {
            let next = next::steps(next::stick_of(name));
            self.say(
                Grade::Care,
                format!("{name} was dropped: this flight does not show its effect. {next}"),
            );
        } else if self.is_control(name) && !is_free {
            self.say(
                Grade::DoNotFly,
                format!(
                    "{name} is unknown: its stick never moves. {}",
                    next::again(next::stick_of(name))
                ),
            );
        } else if self.is_control(name) {
            let found = shown(*value, *bound);
            let next = next::repetitions(next::stick_of(name), percent / CONTROL_PERCENT[0]);
            let known = format!("{name} is {found} {unit}, known only to {percent:.0} %. {next}");
            if percent.is_nan() || percent > CONTROL_PERCENT[1] {
                self.say(Grade::DoNotFly, known);
            } else if percent > CONTROL_PERCENT[0] {
                // A design depends on the response. The response is unchanged where errors of the control and damping
                // derivatives compensate.
                let is_enough = self.knows_response_of(name);
                self.say(if is_enough { Grade::Good } else { Grade::Care }, known);
            }
        } else if is_damping(name) && is_free {
            if *value >= 0.0 {
                let is_none = *value > KnownSign::UNDAMPED_PER_S;
                let grade = if is_none { Grade::DoNotFly } else { Grade::Care };
                let objection = KnownSign::of(name).map_or_else(String::new, |own| own.objection());
                self.say(grade, format!("{name} is {value:.3} ± {bound:.3} {unit}: {objection}"));
            } else if percent.is_nan() || percent > DAMPING_PERCENT {
                let next = next::slow(next::stick_of(name));
                self.say(
                    Grade::Care,
                    format!("{name} is unknown: {value:.3} ± {bound:.3} {unit}. {next}"),
                );
            }
        }
    }
}

/// Lowest frequency of the known response of roll or pitch, rad/s. `None` unless an attitude loop suppresses all lower
/// frequencies.
fn known_from(axis: &ResponseUncertainty) -> Option<f64> {
    let is_rotation = matches!(axis.output, "p" | "q");
    let is_one_structure = axis.between_structures.is_none_or(|cost| cost <= COST);
    axis.known_from_radps.filter(|from| is_rotation && is_one_structure && *from <= ATTITUDE_RADPS)
}

fn is_damping(name: &str) -> bool {
    KnownSign::of(name).is_some_and(|known| known.role == DerivativeRole::Damping)
}

/// A value and its bound with at least three decimals, and enough for two significant digits of the bound.
fn shown(value: f64, bound: f64) -> String {
    let decimals = if bound > 0.0 { (1.0 - bound.log10().floor()).clamp(3.0, 9.0) } else { 3.0 };
    let decimals = decimals as usize;
    format!("{value:.decimals$} ± {bound:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::helicopter::model_structure::ModelStructure;

    #[test]
    fn no_search_can_end_at_a_rotor_that_turns_the_fuselage_the_wrong_way() {
        for structure in ModelStructure::all() {
            for parameter in &structure.equations.parameters {
                let known = KnownSign::of(&parameter.name);
                if known.is_some_and(|known| matches!(known.role, DerivativeRole::Rotor(_))) {
                    assert!(parameter.lower > 0.0, "{}: {}", structure.name(), parameter.name);
                }
            }
        }
    }

    #[test]
    fn small_values_are_reported_in_digits_that_say_something() {
        assert_eq!(shown(-3.681, 2.612), "-3.681 ± 2.612");
        assert_eq!(shown(0.203, 0.008), "0.2030 ± 0.0080");
        assert_eq!(shown(0.00012, 0.00013), "0.00012 ± 0.00013");
        assert_eq!(shown(1.0, f64::INFINITY), "1.000 ± inf");
        assert_eq!(shown(0.0, 0.0), "0.000 ± 0.000");
    }
}
