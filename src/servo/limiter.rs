//! Range and rate limits of the servo commands, and the response to missing commands.

use super::config::{ChannelConfig, ConfigError};
use crate::controls::Channels;
use crate::time::Time;

/// Longest interval between calls, s, that the rate limit counts: a gap in the loop does not permit a jump.
const LONGEST_STEP_S: f64 = 0.1;

/// Limit applied to a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// The command is sent unchanged.
    None,
    /// The command is outside the range: the servo goes to the end of the range.
    Range,
    /// The command exceeds the rate limit of the servo.
    Rate,
    /// The command is not a number: the last width is sent again.
    Held,
    /// The command has not been a number for longer than the hold time. Within its rate limit the servo goes to its
    /// failsafe width, or to trim if no failsafe width is set.
    ToFailsafe,
}

/// The width for one servo, and the limit applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limited {
    /// The width, ms: finite and within the channel's range for any command.
    pub width_ms: f64,
    /// The limit applied to the command.
    pub limit: Limit,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Servo {
    width_ms: f64,
    /// Time without a command, s.
    without_s: f64,
}

/// Limits the servo commands to range and rate.
///
/// While a command is NaN or infinite, the last width is held for `hold_s`; then the servo goes to the channel's
/// failsafe width. The first call moves no servo, and neither does a call that is not later than the previous call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limiter {
    config: Channels<ChannelConfig>,
    /// Time for which the last width is held without a command, s.
    hold_s: f64,
    servos: Channels<Servo>,
    before: Option<Time>,
}

impl Limiter {
    /// Creates a limiter with every servo at trim.
    ///
    /// # Errors
    /// [`ConfigError`] for an invalid setting of a channel, or a `hold_s` outside 0 to 10 s.
    pub fn new(config: Channels<ChannelConfig>, hold_s: f64) -> Result<Self, ConfigError> {
        config.check()?;
        if !(0.0..=10.0).contains(&hold_s) {
            let (from, to) = (0.0, 10.0);
            return Err(ConfigError { channel: None, key: "hold_s", value: hold_s, from, to });
        }
        let servos = config.map(|channel| Servo { width_ms: channel.trim_ms, without_s: 0.0 });
        Ok(Self { config, hold_s, servos, before: None })
    }

    /// Sets the current widths of the servos, ms, as the start of the next command. The autopilot thus takes over from
    /// the pilot without a jump. A width that is not finite is ignored; other widths are limited to the range.
    pub fn start_from(&mut self, widths_ms: &Channels<f64>) {
        self.servos =
            self.servos.zip(self.config).zip(*widths_ms).map(|((servo, config), width_ms)| {
                let width_ms = if width_ms.is_finite() { width_ms } else { servo.width_ms };
                Servo { width_ms: width_ms.max(config.min_ms).min(config.max_ms), without_s: 0.0 }
            });
    }

    /// The widths to send at `now` for commanded widths, ms.
    pub fn apply(&mut self, commands_ms: &Channels<f64>, now: Time) -> Channels<Limited> {
        let elapsed_s = self.before.map_or(0.0, |before| (now - before).max(0.0));
        self.before = Some(now);
        let hold_s = self.hold_s;
        let limited =
            self.servos.zip(self.config).zip(*commands_ms).map(|((servo, config), command_ms)| {
                servo.step(&config, command_ms, elapsed_s, hold_s)
            });
        self.servos = limited.map(|(servo, _)| servo);
        limited.map(|(servo, limit)| Limited { width_ms: servo.width_ms, limit })
    }
}

impl Servo {
    fn step(
        self,
        config: &ChannelConfig,
        command_ms: f64,
        elapsed_s: f64,
        hold_s: f64,
    ) -> (Self, Limit) {
        let (goal_ms, without_s, reason) = if command_ms.is_finite() {
            let within_ms = command_ms.max(config.min_ms).min(config.max_ms);
            (within_ms, 0.0, if within_ms == command_ms { Limit::None } else { Limit::Range })
        } else {
            let without_s = self.without_s + elapsed_s;
            if without_s <= hold_s {
                (self.width_ms, without_s, Limit::Held)
            } else {
                (config.failsafe_ms(), without_s, Limit::ToFailsafe)
            }
        };
        let furthest_ms = config.rate_limit_ms_per_s * elapsed_s.min(LONGEST_STEP_S);
        let step_ms = (goal_ms - self.width_ms).max(-furthest_ms).min(furthest_ms);
        let arrives = self.width_ms + step_ms == goal_ms || step_ms == goal_ms - self.width_ms;
        // A servo that reaches its goal gets exactly the goal, without a rounding error.
        let width_ms = if arrives { goal_ms } else { self.width_ms + step_ms };
        let limit = if reason == Limit::None && !arrives { Limit::Rate } else { reason };
        (Self { width_ms, without_s }, limit)
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    use super::*;

    fn at(seconds: f64) -> Time {
        Time::from_seconds(seconds)
    }

    fn limiter() -> Limiter {
        Limiter::new(Channels::default(), 0.2).unwrap()
    }

    fn all(width_ms: f64) -> Channels<f64> {
        Channels::from_fn(|_| width_ms)
    }

    fn any_command() -> impl Strategy<Value = f64> {
        prop_oneof![8 => 0.0f64..3.0, 1 => any::<f64>(), 1 => Just(f64::NAN)]
    }

    proptest! {
        #[test]
        fn whatever_is_commanded_range_and_rate_hold(
            commands in prop::collection::vec((any_command(), -0.05f64..0.3), 1..60),
        ) {
            let mut limiter = limiter();
            let (mut now, mut before_ms, mut latest) = (at(10.0), 1.5, f64::NEG_INFINITY);
            for (command, step_s) in commands {
                now = now + step_s;
                let moved_s = if latest.is_finite() { (now.seconds() - latest).max(0.0) } else { 0.0 };
                let sent = limiter.apply(&all(command), now).lateral;
                prop_assert!((1.0..=2.0).contains(&sent.width_ms));
                prop_assert!(
                    (sent.width_ms - before_ms).abs() <= 10.0 * moved_s.min(0.1) + 1e-9,
                    "{} to {} in {} s", before_ms, sent.width_ms, moved_s
                );
                (before_ms, latest) = (sent.width_ms, now.seconds());
            }
        }
    }

    #[test]
    fn a_far_command_is_approached_at_the_rate_and_reached_exactly() {
        let mut limiter = limiter();
        let widths: [Limited; 4] =
            [0.0, 0.02, 0.04, 0.06].map(|t| limiter.apply(&all(1.95), at(t)).lateral);
        assert_eq!(widths[0], Limited { width_ms: 1.5, limit: Limit::Rate });
        assert_abs_diff_eq!(widths[1].width_ms, 1.7, epsilon = 1e-12);
        assert_abs_diff_eq!(widths[2].width_ms, 1.9, epsilon = 1e-12);
        assert_eq!(widths[3], Limited { width_ms: 1.95, limit: Limit::None });
    }

    #[test]
    fn without_a_command_the_servo_holds_and_then_goes_to_trim() {
        let mut limiter = limiter();
        limiter.start_from(&all(1.8));
        limiter.apply(&all(1.8), at(0.0));
        let sent = |limiter: &mut Limiter, t| limiter.apply(&all(f64::NAN), at(t)).pedal;
        assert_eq!(sent(&mut limiter, 0.1), Limited { width_ms: 1.8, limit: Limit::Held });
        assert_eq!(sent(&mut limiter, 0.19), Limited { width_ms: 1.8, limit: Limit::Held });
        let leaving = sent(&mut limiter, 0.21);
        assert_eq!(leaving.limit, Limit::ToFailsafe);
        assert_abs_diff_eq!(leaving.width_ms, 1.6, epsilon = 1e-12);
        assert_eq!(sent(&mut limiter, 0.3).width_ms, 1.5);
        assert_eq!(limiter.apply(&all(1.6), at(0.32)).pedal.limit, Limit::None);
    }

    #[test]
    fn a_throttle_with_a_failsafe_width_closes_when_commands_stay_away() {
        let closed = ChannelConfig { trim_ms: 1.5, failsafe_ms: Some(1.05), ..Default::default() };
        let config = Channels { throttle: closed, ..Channels::default() };
        let mut limiter = Limiter::new(config, 0.2).unwrap();
        limiter.start_from(&all(1.2));
        let widths: Vec<f64> = (0..20)
            .map(|step| limiter.apply(&all(f64::NAN), at(0.05 * f64::from(step))).throttle.width_ms)
            .collect();
        assert!(widths.windows(2).all(|pair| pair[1] <= pair[0]), "it never opens");
        assert_eq!(widths[19], 1.05);
    }

    #[test]
    fn time_that_stands_or_runs_back_moves_nothing() {
        let mut limiter = limiter();
        limiter.apply(&all(1.5), at(5.0));
        for t in [5.0, 4.0] {
            assert_eq!(limiter.apply(&all(2.0), at(t)).lateral.width_ms, 1.5);
        }
        assert!(limiter.apply(&all(2.0), at(4.01)).lateral.width_ms > 1.5);
    }

    #[test]
    fn taking_over_from_the_pilot_starts_where_the_servos_are() {
        let mut limiter = limiter();
        limiter.start_from(&Channels { throttle: f64::NAN, pedal: 9.0, ..all(1.7) });
        let sent = limiter.apply(&all(1.5), at(0.0)).map(|servo| servo.width_ms);
        assert_eq!(sent, Channels { throttle: 1.5, pedal: 2.0, ..all(1.7) });
    }

    #[test]
    fn a_hold_that_is_no_time_is_refused() {
        for hold_s in [f64::NAN, -1.0, 11.0] {
            assert_eq!(Limiter::new(Channels::default(), hold_s).unwrap_err().key, "hold_s");
        }
    }
}
