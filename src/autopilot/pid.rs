//! The digital PID controller.

use super::check::{ConfigError, finite, within};
use crate::scalar::Scalar;

/// Gains of a [`Pid`]. The unit of `proportional` is the unit of the command divided by the unit of the error. The unit
/// of the other gains has the additional factor s or 1/s in the field's name.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(deny_unknown_fields)
)]
pub struct PidGains<T = f64> {
    /// Proportional gain: command per error.
    pub proportional: T,
    /// Integral gain: command per error and second.
    pub integral_per_s: T,
    /// Derivative gain, s: command per rate of change of the measured value.
    pub derivative_s: T,
    /// Time constant of the low-pass on the derivative, s; 0 or more.
    pub derivative_filter_s: T,
    /// Time constant with which the integral follows a limited command, s; above 0. A smaller time constant makes the
    /// integral recover faster from saturation.
    pub tracking_time_s: T,
}

impl<T: Scalar> PidGains<T> {
    /// The same gains in another number type.
    #[must_use]
    pub fn cast<U: Scalar>(&self) -> PidGains<U> {
        let number = |value: T| U::of(value.wide());
        PidGains {
            proportional: number(self.proportional),
            integral_per_s: number(self.integral_per_s),
            derivative_s: number(self.derivative_s),
            derivative_filter_s: number(self.derivative_filter_s),
            tracking_time_s: number(self.tracking_time_s),
        }
    }

    pub(super) fn check(&self, what: &'static str) -> Result<(), ConfigError> {
        finite(what, self.proportional)?;
        finite(what, self.integral_per_s)?;
        finite(what, self.derivative_s)?;
        within(what, self.derivative_filter_s, 0.0, 1e3, "a filter time from 0 to 1000 s")?;
        within(what, self.tracking_time_s, 1e-3, 1e6, "a tracking time from 0.001 s")
    }
}

/// PID controller with a filtered derivative of the measurement, tracking anti-windup and bumpless
/// start, at a fixed sample period.
///
/// The derivative acts on the measurement alone, so a step of the set-point causes no kick of the command. Gains may
/// have either sign, like the gain of the plant.
///
/// ```
/// use hovernav::autopilot::{Pid, PidGains};
/// let gains = PidGains {
///     proportional: 2.0,
///     integral_per_s: 1.0,
///     derivative_s: 0.0,
///     derivative_filter_s: 0.0,
///     tracking_time_s: 0.5,
/// };
/// let mut pid = Pid::new(gains, 0.03)?;
/// pid.start(0.5, 0.0, 1.0); // takes over at a command of 0.5
/// assert_eq!(pid.command(0.0, 1.0), 0.5);
/// # Ok::<(), hovernav::autopilot::ConfigError>(())
/// ```
///
/// # Source
/// Åström and Hägglund, *Advanced PID Control* (2006), sections 3.3 to 3.5 and 13.3: backward
/// difference for the derivative, forward difference for the integral, back-calculation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pid<T = f64> {
    gains: PidGains<T>,
    period_s: T,
    integral: T,
    derivative: T,
    before: Option<T>,
    error: T,
    wanted: T,
}

impl<T: Scalar> Pid<T> {
    /// Creates a controller at rest, with one sample every `period_s`.
    ///
    /// # Errors
    /// [`ConfigError`] for a gain that is not finite, or a time out of range.
    pub fn new(gains: PidGains<T>, period_s: T) -> Result<Self, ConfigError> {
        gains.check("PID gains")?;
        within("sample period", period_s, 1e-4, 1.0, "0.0001 to 1 s")?;
        Ok(Self::unchecked(gains, period_s))
    }

    pub(super) const fn unchecked(gains: PidGains<T>, period_s: T) -> Self {
        Self {
            gains,
            period_s,
            integral: T::ZERO,
            derivative: T::ZERO,
            before: None,
            error: T::ZERO,
            wanted: T::ZERO,
        }
    }

    /// Takes over without a jump: the next [`command`](Self::command) with this set-point and measurement returns
    /// `command`.
    pub fn start(&mut self, command: T, set_point: T, measured: T) {
        self.integral = command - self.gains.proportional * (set_point - measured);
        self.derivative = T::ZERO;
        self.before = Some(measured);
        self.error = T::ZERO;
        self.wanted = command;
    }

    /// Command for this sample, before its limits. Call [`advance`](Self::advance) next.
    ///
    /// # Source
    /// Equation (C1) of docs/equations.md.
    #[must_use]
    pub fn command(&mut self, set_point: T, measured: T) -> T {
        let gains = &self.gains;
        let moved = measured - self.before.unwrap_or(measured);
        self.derivative = (gains.derivative_filter_s * self.derivative
            - gains.derivative_s * moved)
            / (gains.derivative_filter_s + self.period_s);
        self.before = Some(measured);
        self.error = set_point - measured;
        self.wanted = gains.proportional * self.error + self.integral + self.derivative;
        self.wanted
    }

    /// Updates the integral at the end of the sample. `applied` is the command after its limits.
    ///
    /// # Source
    /// Equation (C2) of docs/equations.md.
    pub fn advance(&mut self, applied: T) {
        let follow = (self.period_s / self.gains.tracking_time_s).min(T::ONE);
        self.integral += self.gains.integral_per_s * self.period_s * self.error
            + follow * (applied - self.wanted);
    }

    /// Integral part of the command.
    #[must_use]
    pub const fn integral(&self) -> T {
        self.integral
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    const PERIOD_S: f64 = 1.0 / 33.0;
    const GAINS: PidGains = PidGains {
        proportional: 3.0,
        integral_per_s: 4.0,
        derivative_s: 0.2,
        derivative_filter_s: 0.05,
        tracking_time_s: 0.3,
    };

    /// Response of the first-order plant y' = −y + u. The command u of the PID is limited to ±`limit`, and constant
    /// over a sample.
    fn run(pid: &mut Pid, mut y: f64, set_point: impl Fn(f64) -> f64, limit: f64) -> Vec<f64> {
        (0..400)
            .map(|k| {
                let command = pid.command(set_point(f64::from(k) * PERIOD_S), y);
                let applied = command.clamp(-limit, limit);
                pid.advance(applied);
                let keep = (-PERIOD_S).exp();
                y = y * keep + applied * (1.0 - keep);
                y
            })
            .collect()
    }

    #[test]
    fn integral_action_leaves_no_error_under_a_constant_set_point() {
        let mut pid = Pid::new(GAINS, PERIOD_S).unwrap();
        let y = run(&mut pid, 0.0, |_| 0.7, 10.0);
        assert_abs_diff_eq!(*y.last().unwrap(), 0.7, epsilon = 1e-3);
    }

    #[test]
    fn a_limited_command_does_not_wind_the_integral_up() {
        let overshoot = |tracking_time_s| {
            let gains = PidGains { tracking_time_s, ..GAINS };
            let mut pid = Pid::new(gains, PERIOD_S).unwrap();
            // A set-point out of reach for 4 s, then a set-point within reach.
            let y = run(&mut pid, 0.0, |t| if t < 4.0 { 5.0 } else { 0.2 }, 1.0);
            y.iter().skip(200).fold(f64::NEG_INFINITY, |most, &y| most.max(y))
        };
        assert!(overshoot(0.3) < 0.35, "{}", overshoot(0.3));
        assert!(overshoot(1e6) > 0.9, "{}", overshoot(1e6));
    }

    #[test]
    fn it_takes_over_at_the_command_it_is_given() {
        let mut pid = Pid::new(GAINS, PERIOD_S).unwrap();
        pid.start(-0.3, 1.0, 0.4);
        assert_abs_diff_eq!(pid.command(1.0, 0.4), -0.3, epsilon = 1e-15);
    }

    #[test]
    fn a_stepping_set_point_does_not_kick_the_derivative() {
        let mut pid = Pid::new(GAINS, PERIOD_S).unwrap();
        pid.start(0.0, 0.0, 0.0);
        assert_abs_diff_eq!(pid.command(1.0, 0.0), GAINS.proportional, epsilon = 1e-15);
    }

    #[test]
    fn the_derivative_settles_on_the_slope_of_a_ramp() {
        let gains = PidGains { proportional: 0.0, integral_per_s: 0.0, ..GAINS };
        let mut pid = Pid::new(gains, PERIOD_S).unwrap();
        let last = (0..100).map(|k| pid.command(0.0, 2.0 * f64::from(k) * PERIOD_S)).last();
        assert_abs_diff_eq!(last.unwrap(), -2.0 * gains.derivative_s, epsilon = 1e-9);
    }

    #[test]
    fn gains_that_are_no_numbers_are_refused_by_name() {
        let rejected = Pid::new(PidGains { integral_per_s: f64::NAN, ..GAINS }, PERIOD_S);
        assert!(matches!(rejected, Err(ConfigError { what: "PID gains", .. })));
        assert!(Pid::new(PidGains { tracking_time_s: 0.0, ..GAINS }, PERIOD_S).is_err());
        assert!(Pid::new(GAINS, f64::INFINITY).is_err());
    }
}
