//! Linear-quadratic regulator with integral action, and a prediction of the states that no sensor measures.

use super::check::{ConfigError, finite, within};
use crate::matrix::{add_scaled, difference, dot, times};
use crate::scalar::Scalar;

/// Gains of a [`Regulator`] with `Y` measured states, `H` hidden states and `U` controls, at one sample period.
///
/// Hidden states of the design's plant are not measured, but follow from the measured states and the commands:
/// flapping, stabilizer bar, servo positions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(deny_unknown_fields),
    serde(bound(
        serialize = "T: serde::Serialize, [[T; Y]; U]: serde::Serialize, [[T; H]; U]: serde::Serialize, \
                     [[T; U]; U]: serde::Serialize, [[T; Y]; H]: serde::Serialize, \
                     [[T; H]; H]: serde::Serialize, [[T; U]; H]: serde::Serialize",
        deserialize = "T: serde::Deserialize<'de>, [[T; Y]; U]: serde::Deserialize<'de>, \
                       [[T; H]; U]: serde::Deserialize<'de>, \
                       [[T; U]; U]: serde::Deserialize<'de>, \
                       [[T; Y]; H]: serde::Deserialize<'de>, \
                       [[T; H]; H]: serde::Deserialize<'de>, \
                       [[T; U]; H]: serde::Deserialize<'de>"
    ))
)]
pub struct RegulatorGains<const Y: usize, const H: usize, const U: usize, T = f64> {
    /// Gain from each measured state to the stick, one row per control.
    pub measured: [[T; Y]; U],
    /// Gain from each hidden state to the stick, one row per control.
    pub hidden: [[T; H]; U],
    /// Gain from the pending command, sent in the last sample, to the stick. It accounts for the delay of one sample.
    pub pending: [[T; U]; U],
    /// Gain from the time integral of each measured state's error to the stick, per s; zero except for states that must
    /// have no steady error.
    pub integral_per_s: [[T; Y]; U],
    /// Gain over one sample from each hidden state to each hidden state, one row per resulting hidden state.
    pub hidden_from_hidden: [[T; H]; H],
    /// Gain over one sample from each measured state to each hidden state, one row per hidden state.
    pub hidden_from_measured: [[T; Y]; H],
    /// Gain over one sample from each command that acts during the sample to each hidden state.
    pub hidden_from_pending: [[T; U]; H],
    /// Anti-windup time constant, s, with which the integrals follow a limited command.
    pub tracking_time_s: T,
}

impl<const Y: usize, const H: usize, const U: usize, T: Scalar> Default
    for RegulatorGains<Y, H, U, T>
{
    /// Gains of zero.
    fn default() -> Self {
        Self {
            measured: [[T::ZERO; Y]; U],
            hidden: [[T::ZERO; H]; U],
            pending: [[T::ZERO; U]; U],
            integral_per_s: [[T::ZERO; Y]; U],
            hidden_from_hidden: [[T::ZERO; H]; H],
            hidden_from_measured: [[T::ZERO; Y]; H],
            hidden_from_pending: [[T::ZERO; U]; H],
            tracking_time_s: T::ONE,
        }
    }
}

impl<const Y: usize, const H: usize, const U: usize, T: Scalar> RegulatorGains<Y, H, U, T> {
    /// The same gains in another number type.
    #[must_use]
    pub fn cast<V: Scalar>(&self) -> RegulatorGains<Y, H, U, V> {
        let number = |value: T| V::of(value.wide());
        RegulatorGains {
            measured: self.measured.map(|row| row.map(number)),
            hidden: self.hidden.map(|row| row.map(number)),
            pending: self.pending.map(|row| row.map(number)),
            integral_per_s: self.integral_per_s.map(|row| row.map(number)),
            hidden_from_hidden: self.hidden_from_hidden.map(|row| row.map(number)),
            hidden_from_measured: self.hidden_from_measured.map(|row| row.map(number)),
            hidden_from_pending: self.hidden_from_pending.map(|row| row.map(number)),
            tracking_time_s: number(self.tracking_time_s),
        }
    }

    pub(super) fn check(&self, what: &'static str) -> Result<(), ConfigError> {
        let all = self
            .measured
            .as_flattened()
            .iter()
            .chain(self.hidden.as_flattened())
            .chain(self.pending.as_flattened())
            .chain(self.integral_per_s.as_flattened())
            .chain(self.hidden_from_hidden.as_flattened())
            .chain(self.hidden_from_measured.as_flattened())
            .chain(self.hidden_from_pending.as_flattened());
        for &gain in all {
            finite(what, gain)?;
        }
        within(what, self.tracking_time_s, 1e-3, 1e6, "a tracking time from 0.001 s")
    }
}

/// State feedback u = −K·(x − reference) + integral. x holds the measured states, the hidden states and the pending
/// command. A model predicts the hidden states from the measured states and the commands.
///
/// The prediction has no correction gain: the measured states enter it directly. An error of the initial hidden states
/// decays as fast as the dynamics of rotor and servos. Commands are deviations from trim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regulator<const Y: usize, const H: usize, const U: usize, T = f64> {
    gains: RegulatorGains<Y, H, U, T>,
    period_s: T,
    hidden: [T; H],
    pending: [T; U],
    integral: [T; U],
    measured: [T; Y],
    error: [T; Y],
    wanted: [T; U],
}

impl<const Y: usize, const H: usize, const U: usize, T: Scalar> Regulator<Y, H, U, T> {
    /// Creates a regulator at trim, with one sample every `period_s`.
    ///
    /// # Errors
    /// [`ConfigError`] for a gain that is not finite, or a time out of range.
    pub fn new(gains: RegulatorGains<Y, H, U, T>, period_s: T) -> Result<Self, ConfigError> {
        gains.check("regulator gains")?;
        within("sample period", period_s, 1e-4, 1.0, "0.0001 to 1 s")?;
        Ok(Self::unchecked(gains, period_s))
    }

    pub(super) const fn unchecked(gains: RegulatorGains<Y, H, U, T>, period_s: T) -> Self {
        Self {
            gains,
            period_s,
            hidden: [T::ZERO; H],
            pending: [T::ZERO; U],
            integral: [T::ZERO; U],
            measured: [T::ZERO; Y],
            error: [T::ZERO; Y],
            wanted: [T::ZERO; U],
        }
    }

    /// Restarts at trim, with the `pending` commands.
    pub fn start(&mut self, pending: [T; U]) {
        *self = Self { pending, ..Self::unchecked(self.gains, self.period_s) };
    }

    /// Command for this sample before its limits, as a deviation from trim. Call [`advance`](Self::advance) next.
    ///
    /// # Source
    /// Equation (C3) of docs/equations.md.
    #[must_use]
    pub fn command(&mut self, measured: &[T; Y], reference: &[T; Y]) -> [T; U] {
        self.measured = *measured;
        self.error = difference(measured, reference);
        let gains = &self.gains;
        let rows = gains.measured.iter().zip(&gains.hidden).zip(&gains.pending);
        let mut wanted = self.integral;
        for (wanted, ((measured, hidden), pending)) in wanted.iter_mut().zip(rows) {
            *wanted -= dot(measured, &self.error)
                + dot(hidden, &self.hidden)
                + dot(pending, &self.pending);
        }
        self.wanted = wanted;
        wanted
    }

    /// Updates the hidden states, the pending command and the integrals at the end of the sample. `applied` is the
    /// command after its limits.
    ///
    /// # Source
    /// Equation (C4) of docs/equations.md.
    pub fn advance(&mut self, applied: &[T; U]) {
        let gains = &self.gains;
        let mut hidden = times(&gains.hidden_from_hidden, &self.hidden);
        add_scaled(&mut hidden, T::ONE, &times(&gains.hidden_from_measured, &self.measured));
        add_scaled(&mut hidden, T::ONE, &times(&gains.hidden_from_pending, &self.pending));
        self.hidden = hidden;
        self.pending = *applied;
        add_scaled(&mut self.integral, -self.period_s, &times(&gains.integral_per_s, &self.error));
        let follow = (self.period_s / gains.tracking_time_s).min(T::ONE);
        add_scaled(&mut self.integral, follow, &difference(applied, &self.wanted));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    const PERIOD_S: f64 = 1.0 / 33.0;

    /// A double integrator with a servo lag and a command delay of one sample. The gains account for both.
    fn gains() -> RegulatorGains<2, 1, 1> {
        RegulatorGains {
            measured: [[6.0, 3.6]],
            hidden: [[0.1]],
            pending: [[0.1]],
            integral_per_s: [[3.0, 0.0]],
            hidden_from_hidden: [[0.4]],
            hidden_from_measured: [[0.0, 0.0]],
            hidden_from_pending: [[0.6]],
            tracking_time_s: 0.5,
        }
    }

    fn run(regulator: &mut Regulator<2, 1, 1>, disturbance: f64, limit: f64) -> [f64; 2] {
        let [mut place, mut speed, mut servo, mut pending] = [1.0, 0.0, 0.0, 0.0];
        for _ in 0..1000 {
            let [wanted] = regulator.command(&[place, speed], &[0.0; 2]);
            let applied = wanted.clamp(-limit, limit);
            regulator.advance(&[applied]);
            servo = 0.4 * servo + 0.6 * pending;
            pending = applied;
            speed += PERIOD_S * (servo + disturbance);
            place += PERIOD_S * speed;
        }
        [place, speed]
    }

    #[test]
    fn integral_action_takes_a_constant_disturbance_out() {
        let mut regulator = Regulator::new(gains(), PERIOD_S).unwrap();
        let [place, speed] = run(&mut regulator, 0.5, 10.0);
        assert!(place.abs() < 1e-3 && speed.abs() < 1e-3, "{place} {speed}");
    }

    #[test]
    fn a_limited_command_still_comes_to_rest() {
        let mut regulator = Regulator::new(gains(), PERIOD_S).unwrap();
        let [place, speed] = run(&mut regulator, 0.5, 0.9);
        assert!(place.abs() < 0.01 && speed.abs() < 0.01, "{place} {speed}");
    }

    #[test]
    fn the_hidden_state_follows_the_command_that_acts() {
        let mut regulator = Regulator::new(gains(), PERIOD_S).unwrap();
        for _ in 0..40 {
            let _ = regulator.command(&[0.0; 2], &[0.0; 2]);
            regulator.advance(&[0.25]);
        }
        assert_abs_diff_eq!(regulator.hidden[0], 0.25, epsilon = 1e-12);
    }

    #[test]
    fn a_gain_that_is_no_number_is_refused() {
        let mut bad = gains();
        bad.hidden_from_pending[0][0] = f64::NAN;
        assert!(Regulator::new(bad, PERIOD_S).is_err());
    }
}
