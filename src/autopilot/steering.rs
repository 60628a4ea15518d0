//! The pilot's sticks as requests to the autopilot: it holds position, and flies in the direction of a deflected stick.

use super::check::{ConfigError, within};
use super::guidance::SetPoint;
use crate::controls::Sticks;
use crate::scalar::Scalar;

/// Motion that the sticks request while the autopilot flies.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct SteeringConfig {
    /// Dead band: a stick closer than this to its position at engagement requests nothing; 0.01 to 0.5.
    pub dead_band: f64,
    /// Deflection of a stick that requests the full speed; above the dead band, at most 1.
    pub full_stick: f64,
    /// Horizontal speed at full stick, m/s, forward and sideways.
    pub speed_mps: f64,
    /// Climb or sink rate at full stick, m/s.
    pub climb_mps: f64,
    /// Turn rate at full stick, rad/s.
    pub yaw_rate_radps: f64,
    /// Signs of lateral, longitudinal, collective and pedal: 1 where a positive stick means right, forward, up, right;
    /// else −1.
    pub signs: Sticks,
}

impl Default for SteeringConfig {
    fn default() -> Self {
        Self {
            dead_band: 0.08,
            full_stick: 0.6,
            speed_mps: 2.0,
            climb_mps: 0.8,
            yaw_rate_radps: 0.4,
            signs: Sticks::from_array([1.0; 4]),
        }
    }
}

impl SteeringConfig {
    /// Checks that every value is finite and in its range.
    ///
    /// # Errors
    /// [`ConfigError`] with the first value that is out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        within("steering.dead_band", self.dead_band, 0.01, 0.5, "0.01 to 0.5")?;
        let least = self.dead_band + 0.05;
        within("steering.full_stick", self.full_stick, least, 1.0, "above the dead band, to 1")?;
        within("steering.speed_mps", self.speed_mps, 0.1, 10.0, "0.1 to 10 m/s")?;
        within("steering.climb_mps", self.climb_mps, 0.1, 3.0, "0.1 to 3 m/s")?;
        within("steering.yaw_rate_radps", self.yaw_rate_radps, 0.05, 2.0, "0.05 to 2 rad/s")?;
        for sign in self.signs.to_array() {
            if libm::fabs(sign) != 1.0 {
                let what = "steering.signs";
                return Err(ConfigError { what, found: sign, expected: "1 or -1" });
            }
        }
        Ok(())
    }
}

/// Turns stick movements into set-points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steering {
    config: SteeringConfig,
    /// Positions of the sticks at engagement.
    neutral: Sticks,
    moving: bool,
}

impl Steering {
    /// Creates the steering; `neutral` are the pilot's sticks at engagement.
    ///
    /// # Errors
    /// [`ConfigError`] with the first invalid value of `config`.
    pub fn new(config: SteeringConfig, neutral: Sticks) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self { config, neutral, moving: false })
    }

    /// Restarts the steering with `neutral`, the pilot's sticks at engagement.
    pub fn engage(&mut self, neutral: Sticks) {
        (self.neutral, self.moving) = (neutral, false);
    }

    /// Set-point that the sticks `pilot` request now: a velocity while a stick is outside its dead band. When the last
    /// stick returns into its dead band, the set-point is [`SetPoint::Hold`], once; after that it is `None`. Loss of
    /// the pilot's signal counts as sticks at neutral.
    pub fn set_point(&mut self, pilot: Option<Sticks>) -> Option<SetPoint> {
        let pilot = pilot.filter(|sticks| sticks.is_finite()).unwrap_or(self.neutral);
        let asked = pilot
            .zip(self.neutral, |now, neutral| self.share(now - neutral))
            .zip(self.config.signs, |share, sign| share * sign);
        let moves = asked != Sticks::NEUTRAL;
        let stops = core::mem::replace(&mut self.moving, moves) && !moves;
        if stops {
            return Some(SetPoint::Hold);
        }
        moves.then(|| {
            // Both cyclic sticks at full deflection request no more speed than one.
            let length = Scalar::hypot(asked.longitudinal, asked.lateral).max(1.0);
            SetPoint::Velocity {
                forward_mps: self.config.speed_mps * asked.longitudinal / length,
                right_mps: self.config.speed_mps * asked.lateral / length,
                down_mps: -self.config.climb_mps * asked.collective,
                yaw_rate_radps: self.config.yaw_rate_radps * asked.pedal,
            }
        })
    }

    /// Request of a stick, −1 to 1: 0 inside the dead band, and growing from its edge.
    fn share(&self, stick: f64) -> f64 {
        let beyond = libm::fabs(stick) - self.config.dead_band;
        if beyond <= 0.0 {
            return 0.0;
        }
        libm::copysign(beyond / (self.config.full_stick - self.config.dead_band), stick)
            .clamp(-1.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn steering() -> Steering {
        let neutral = Sticks { collective: 0.2, lateral: -0.1, ..Sticks::NEUTRAL };
        Steering::new(SteeringConfig::default(), neutral).unwrap()
    }

    #[test]
    fn inside_the_dead_band_nothing_is_asked_for() {
        let mut steering = steering();
        let near = Sticks { collective: 0.26, lateral: -0.15, pedal: 0.07, longitudinal: -0.07 };
        assert_eq!(steering.set_point(Some(near)), None);
        assert_eq!(steering.set_point(None), None);
    }

    #[test]
    fn a_stick_asks_for_its_own_motion_from_the_edge_of_the_band_without_a_step() {
        let mut steering = steering();
        let neutral = steering.neutral;
        let at = |longitudinal| Sticks { longitudinal, ..neutral };
        let mut speeds = Vec::new();
        for stick in [0.0801, 0.34, 0.6, 0.9] {
            let Some(SetPoint::Velocity { forward_mps, right_mps, down_mps, yaw_rate_radps }) =
                steering.set_point(Some(at(stick)))
            else {
                panic!("a velocity")
            };
            assert_eq!([right_mps, down_mps, yaw_rate_radps], [0.0; 3]);
            speeds.push(forward_mps);
        }
        assert!(speeds[0] < 1e-3);
        assert_abs_diff_eq!(speeds[1], 1.0, epsilon = 1e-12);
        assert_eq!(speeds[2..], [2.0, 2.0]);
    }

    #[test]
    fn release_asks_to_hold_once_and_a_lost_pilot_is_a_release() {
        for released in [Some(steering().neutral), None] {
            let mut steering = steering();
            assert!(steering.set_point(Some(Sticks { pedal: -0.5, ..steering.neutral })).is_some());
            assert_eq!(steering.set_point(released), Some(SetPoint::Hold));
            assert_eq!(steering.set_point(released), None);
        }
    }

    #[test]
    fn both_cyclic_sticks_together_are_no_faster() {
        let mut steering = steering();
        let corner = Sticks { lateral: 0.9, longitudinal: 1.0, ..steering.neutral };
        let Some(SetPoint::Velocity { forward_mps, right_mps, .. }) =
            steering.set_point(Some(corner))
        else {
            panic!("a velocity")
        };
        assert_abs_diff_eq!(forward_mps.hypot(right_mps), 2.0, epsilon = 1e-12);
    }

    #[test]
    fn settings_that_cannot_be_are_named() {
        let good = SteeringConfig::default();
        for (bad, what) in [
            (SteeringConfig { dead_band: f64::NAN, ..good }, "steering.dead_band"),
            (SteeringConfig { full_stick: 0.05, ..good }, "steering.full_stick"),
            (SteeringConfig { signs: Sticks::NEUTRAL, ..good }, "steering.signs"),
        ] {
            assert_eq!(bad.check().unwrap_err().what, what);
        }
    }
}
