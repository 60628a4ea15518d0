//! Whether the identified model may be flown by, and why not.

use hovernav_model::{DerivativeRole, Grade, KnownSign, Verdict};

use super::frequency_domain::FrequencyDomain;
use super::identify::Identification;
use super::uncertainty::{COST, ResponseUncertainty};
use crate::methods::prediction_error::{Estimate, Status};

/// What each stick does, and the rotor's springs: a design is made of these.
const CONTROL: [&str; 8] = ["Zcol", "Nped", "Blat", "Alon", "Llat", "Mlon", "Lb", "Ma"];
/// Bounds of a control derivative, percent of its value, up to which it is good, and of use.
const CONTROL_PERCENT: [f64; 2] = [15.0, 50.0];
/// A damping no better known than this, percent, is not known.
const DAMPING_PERCENT: f64 = 100.0;
/// How it answers to its own speed, over seconds. No better known than this, one sigma in percent of the value,
/// they are unknown.
const SLOW: [&str; 7] = ["Zw", "Xu", "Yv", "Lu", "Lv", "Mu", "Mv"];
const SLOW_PERCENT: f64 = 35.0;
/// Pairs more strongly correlated than this are one number, not two.
const SAME: f64 = 0.98;
/// Delays of sticks that are not a pilot's dream, s.
const DELAY_S: [f64; 2] = [-0.02, 0.15];
/// Correlation of innovations up to which they count as white.
const WHITE: f64 = 0.3;
/// Where a bound is this much of what was expected before the flight, the flight told nothing.
const UNTOLD: f64 = 0.95;
/// Growth of a mode, 1/s, that a hover does not have.
const GROWTH_PER_S: f64 = 3.0;

impl Identification {
    /// Whether the model may be flown by. `frequency` is what the frequency domain makes of the same
    /// flight, where it makes anything of it.
    #[must_use]
    pub fn verdict(&self, frequency: Option<&FrequencyDomain>) -> Verdict {
        let mut judge = Judge { grade: Grade::Good, reasons: Vec::new() };
        // The cause of much that follows comes first.
        if let Some(early_s) = self.answers_early_s {
            let early_ms = 1e3 * early_s;
            judge.say(Grade::DoNotFly, format!(
                "the sticks are recorded late: the vehicle answers {early_ms:.0} ms before they move, so that controls.csv is late by about {early_ms:.0} ms, and by what the servos take besides, up to 60 ms"
            ));
        }
        for estimate in self.parameters() {
            judge.parameter(estimate);
        }
        for (one, other, value) in self.strong_correlations(SAME) {
            judge.say(
                Grade::Care,
                format!("{one} and {other} cannot be told apart: their correlation is {value:.3}"),
            );
        }
        if !self.identified.converged {
            judge.say(Grade::Care, "the search ended before it converged".into());
        }
        if self.validation.is_none() {
            judge.say(Grade::Care, "nothing was held back to validate it on".into());
        }
        if let Some(frequency) = frequency {
            judge.second_opinion(frequency);
        }
        for axis in self.response_uncertainties() {
            judge.axis(&axis);
        }
        let vertical = self.identified.estimates.get("σ n_ew");
        if vertical.is_some_and(|error| error.status == Status::OnBound) {
            judge.say(
                Grade::Care,
                "collective to w: the error of the vertical velocity is found as large as its smoother \
                 states at most: gusts may be taken for it, and the collective for too weak"
                    .into(),
            );
        }
        let outputs = self.identified.structure.outputs.iter();
        for (output, correlation) in outputs.zip(&self.identified.innovations_correlation) {
            // Where the noise of an output is held it is no measure of what is left.
            let noise = self.identified.estimates.get(&format!("σ {output}"));
            if *correlation > WHITE && noise.is_some_and(Estimate::is_estimated) {
                judge.say(Grade::Care, format!(
                    "{output}: what the model leaves unexplained is not white, its correlation within a second is {correlation:.2}, above {WHITE}: it lacks something that moves {output}"
                ));
            }
        }
        for parameter in &self.identified.structure.parameters {
            let found = self.identified.estimates.get(&parameter.name);
            if let (Some(expected), Some(found)) = (parameter.prior, found) {
                judge.against_expected(found, expected);
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
            Err(error) => judge.say(Grade::DoNotFly, format!("its modes cannot be told: {error}")),
        }
        Verdict { grade: judge.grade, reasons: judge.reasons }
    }

    /// How far one of the [`parameters`](Self::parameters) can be relied on: by what the verdict says of it, and
    /// with care only where its bound is larger than it is, or than 35 % of it where it is slow.
    #[must_use]
    pub fn grade_of(&self, estimate: &Estimate) -> Grade {
        let mut judge = Judge { grade: Grade::Good, reasons: Vec::new() };
        judge.parameter(estimate);
        let own = self.identified.structure.parameter(&estimate.name);
        let expected = own.and_then(|own| self.identified.structure.parameters[own].prior);
        if let Some(expected) = expected {
            judge.against_expected(estimate, expected);
        }
        let correlated = self.strong_correlations(SAME);
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
}

struct Judge {
    grade: Grade,
    reasons: Vec<String>,
}

impl Judge {
    fn say(&mut self, grade: Grade, reason: String) {
        self.grade = self.grade.max(grade);
        self.reasons.push(reason);
    }

    fn second_opinion(&mut self, frequency: &FrequencyDomain) {
        for pair in frequency.costs.iter().filter(|pair| pair.time > COST) {
            let (stick, output, cost) = (&pair.stick, &pair.output, pair.time);
            self.say(Grade::Care, format!(
                "{stick} to {output}: the flight\u{2019}s frequency response is off the model\u{2019}s by a cost of {cost:.0}, above {COST}"
            ));
        }
        for own in frequency.disagreements() {
            self.say(Grade::Care, own);
        }
    }

    fn axis(&mut self, axis: &ResponseUncertainty) {
        let (stick, output) = (axis.stick, axis.output);
        let cost = axis.cost();
        if cost <= COST {
            return;
        }
        let mut why = format!("{:.0} by the bounds of the parameters", axis.within_bounds);
        if let Some(apart) = axis.between_structures {
            why +=
                &format!(", {apart:.0} by a stabiliser bar that the flight does not clearly tell");
        }
        if let Some(from) = axis.known_from_radps.filter(|_| axis.within_bounds > COST) {
            why += &format!("; from {from:.1} rad/s on less than {COST}");
        }
        self.say(
            Grade::Care,
            format!("{stick} to {output}: one response in ten is off by a cost above {cost:.0}, {COST} is allowed: {why}"),
        );
    }

    /// Whether the flight told more of a damping than was `expected` of it: value and one sigma.
    fn against_expected(&mut self, found: &Estimate, (expected, sigma): (f64, f64)) {
        let Estimate { name, value, bound, unit, .. } = found;
        if is_damping(name) && found.is_estimated() && *bound > UNTOLD * sigma {
            self.say(Grade::Care, format!(
                "{name} is not told by this flight: {value:.3} ± {bound:.3} {unit}, where {expected} ± {sigma} is usual"
            ));
        }
    }

    /// Names the slow ones among `parameters` that the flight did not tell, those left out too, less what is named
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
                    Status::Dropped => Some(format!("{} (left out)", own.name)),
                    _ if !own.is_estimated() || percent <= SLOW_PERCENT => None,
                    _ => Some(format!("{} ({percent:.0} %)", own.name)),
                }
            })
            .collect();
        if !unknown.is_empty() {
            self.say(Grade::Care, format!(
                "unknown: {}, one sigma in percent of the value above {SLOW_PERCENT}: this flight does not tell how it answers to its own speed over seconds",
                unknown.join(", ")
            ));
        }
    }

    /// Whether a stick goes the way that its derivative says.
    fn way(&mut self, Estimate { name, unit, value, bound, .. }: &Estimate) {
        let Some(known) = KnownSign::of(name) else { return };
        let stick = known.column;
        if matches!(known.role, DerivativeRole::Stick(_))
            && known.sign * value < -KnownSign::SIGMAS * bound
        {
            let (found, objection) = (shown(*value, *bound), known.objection());
            // An autopilot that has the height the wrong way round loses it at once.
            let grade = if stick == "collective" { Grade::DoNotFly } else { Grade::Care };
            self.say(grade, format!(
                "{name} is {found} {unit}, {objection}. Is {stick} the wrong way round in controls.csv?"
            ));
        }
    }

    fn parameter(&mut self, estimate: &Estimate) {
        let Estimate { name, unit, value, bound, .. } = estimate;
        self.way(estimate);
        let is_free = estimate.is_estimated();
        let percent = estimate.bound_percent();
        // A servo whose lag does not show ends at none.
        let is_lag = name.starts_with("lag_");
        if estimate.status == Status::OnBound && !is_lag {
            let grade =
                if CONTROL.contains(&name.as_str()) { Grade::DoNotFly } else { Grade::Care };
            self.say(grade, format!("{name} ended on the limit of its search, {value:.3} {unit}"));
        } else if CONTROL.contains(&name.as_str()) && !is_free {
            self.say(Grade::DoNotFly, format!("{name} is not known: its stick never moves"));
        } else if CONTROL.contains(&name.as_str()) {
            let found = shown(*value, *bound);
            let known = format!("{name} is {found} {unit}, known to {percent:.0} % only");
            if percent.is_nan() || percent > CONTROL_PERCENT[1] {
                self.say(Grade::DoNotFly, known);
            } else if percent > CONTROL_PERCENT[0] {
                self.say(Grade::Care, known);
            }
        } else if is_damping(name) && is_free {
            if *value >= 0.0 {
                let is_none = *value > KnownSign::UNDAMPED_PER_S;
                let grade = if is_none { Grade::DoNotFly } else { Grade::Care };
                let objection = KnownSign::of(name).map_or_else(String::new, |own| own.objection());
                self.say(grade, format!("{name} is {value:.3} ± {bound:.3} {unit}: {objection}"));
            } else if percent.is_nan() || percent > DAMPING_PERCENT {
                self.say(
                    Grade::Care,
                    format!("{name} is not known: {value:.3} ± {bound:.3} {unit}"),
                );
            }
        } else if name.starts_with("tau_") && unit == "s" && is_free && name.len() == 7 {
            let [least, most] = DELAY_S;
            if !(least..=most).contains(value) {
                self.say(
                    Grade::Care,
                    format!("{name}, a stick\u{2019}s delay, is {:.0} ms", 1e3 * value),
                );
            }
        }
    }
}

fn is_damping(name: &str) -> bool {
    KnownSign::of(name).is_some_and(|known| known.role == DerivativeRole::Damping)
}

/// A value beside its bound with as many decimals, three at least, as the bound has something to say in.
fn shown(value: f64, bound: f64) -> String {
    let decimals = if bound > 0.0 { (1.0 - bound.log10().floor()).clamp(3.0, 9.0) } else { 3.0 };
    let decimals = decimals as usize;
    format!("{value:.decimals$} ± {bound:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::helicopter::kind::Kind;

    #[test]
    fn no_search_can_end_at_a_rotor_that_turns_the_fuselage_the_wrong_way() {
        for kind in Kind::ALL {
            for parameter in kind.structure().parameters {
                let known = KnownSign::of(&parameter.name);
                if known.is_some_and(|known| matches!(known.role, DerivativeRole::Rotor(_))) {
                    assert!(parameter.lower > 0.0, "{kind}: {}", parameter.name);
                }
            }
        }
    }

    #[test]
    fn small_values_are_told_in_digits_that_say_something() {
        assert_eq!(shown(-3.681, 2.612), "-3.681 ± 2.612");
        assert_eq!(shown(0.203, 0.008), "0.2030 ± 0.0080");
        assert_eq!(shown(0.00012, 0.00013), "0.00012 ± 0.00013");
        assert_eq!(shown(1.0, f64::INFINITY), "1.000 ± inf");
        assert_eq!(shown(0.0, 0.0), "0.000 ± 0.000");
    }
}
