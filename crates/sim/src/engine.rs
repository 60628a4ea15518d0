//! The engine with its governor, and the rotors that it drives.

use super::check::{Checked, positive, size};
use hovernav_model::helicopter::{HelicopterParameters, RotorDrive};

/// Engine, governor and rotors. The default is that of a 60-class helicopter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineConfig {
    /// Time constant of the governor's speed control, s.
    pub governor_time_s: f64,
    /// Relative loss of rotor speed at full collective above trim.
    pub droop: f64,
    /// Inertia of both rotors, their shafts and gears, referred to the main shaft, kg·m².
    pub inertia_kgm2: f64,
    /// Largest torque at the main shaft, N·m.
    pub max_torque_nm: f64,
}

impl Default for EngineConfig {
    /// Values of a 60-class helicopter. Blades, bar and tail have an inertia of about 0.1 kg·m². A glow engine of 15 cm³
    /// has 2.1 kW: 13 N·m at 160 rad/s.
    fn default() -> Self {
        Self { governor_time_s: 0.5, droop: 0.03, inertia_kgm2: 0.1, max_torque_nm: 13.0 }
    }
}

impl EngineConfig {
    pub(super) fn check(&self) -> Checked {
        const SENSOR: &str = "engine";
        positive(SENSOR, "time constant of the governor", self.governor_time_s)?;
        size(SENSOR, "droop", self.droop)?;
        positive(SENSOR, "inertia of the rotors", self.inertia_kgm2)?;
        positive(SENSOR, "most torque", self.max_torque_nm)
    }
}

/// A running engine.
#[derive(Clone, Copy, Debug)]
pub(super) struct Engine {
    config: EngineConfig,
    /// Nominal speed of the main rotor, rad/s.
    nominal_radps: f64,
    /// Speed of the main rotor divided by the nominal speed.
    speed: f64,
    powered: bool,
}

impl Engine {
    /// An engine at its nominal speed.
    pub fn new(config: &EngineConfig, helicopter: &HelicopterParameters) -> Self {
        let nominal_radps = helicopter.main_rotor.speed_radps;
        Self { config: *config, nominal_radps, speed: 1.0, powered: true }
    }

    /// Stops the engine; the rotors turn freely.
    pub const fn stop(&mut self) {
        self.powered = false;
    }

    /// Drive of the rotors.
    pub const fn drive(&self) -> RotorDrive {
        RotorDrive { speed: self.speed, powered: self.powered }
    }

    /// Advances by `step_s`, with the collective stick at `collective` and a rotor torque of `torque_nm`.
    ///
    /// The governor commands the torque that corrects the speed within its time constant, up to the engine's limit. A
    /// freewheel prevents braking.
    ///
    /// # Source
    /// Equation (V16) of docs/equations.md.
    pub fn advance(&mut self, collective: f64, torque_nm: f64, step_s: f64) {
        let EngineConfig { governor_time_s, droop, inertia_kgm2, max_torque_nm } = self.config;
        let gap = 1.0 - droop * collective.max(-1.0) - self.speed;
        let angular_momentum = inertia_kgm2 * self.nominal_radps;
        let wanted_nm = torque_nm + angular_momentum * gap / governor_time_s;
        if self.powered && (0.0..=max_torque_nm).contains(&wanted_nm) {
            self.speed += (1.0 - (-step_s / governor_time_s).exp()) * gap;
            return;
        }
        let given_nm = if self.powered { wanted_nm.clamp(0.0, max_torque_nm) } else { 0.0 };
        let change = (given_nm - torque_nm) / angular_momentum * step_s;
        self.speed = (self.speed + change).max(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn engine() -> Engine {
        Engine::new(&EngineConfig::default(), &HelicopterParameters::raptor60())
    }

    #[test]
    fn the_governor_closes_a_gap_with_its_time_constant() {
        let mut engine = engine();
        for _ in 0..50 {
            engine.advance(0.5, 5.6, 0.01);
        }
        let expected = 0.015 * (1.0 - (-1f64).exp());
        assert_abs_diff_eq!(1.0 - engine.speed, expected, epsilon = 1e-12);
    }

    #[test]
    fn without_power_the_rotors_lose_what_their_torque_takes() {
        let mut engine = engine();
        engine.stop();
        for _ in 0..100 {
            engine.advance(0.0, 4.0, 0.01);
        }
        let EngineConfig { inertia_kgm2, .. } = EngineConfig::default();
        assert_abs_diff_eq!(engine.speed, 1.0 - 4.0 / (inertia_kgm2 * 160.0), epsilon = 1e-12);
        assert!(!engine.drive().powered);
    }

    #[test]
    fn a_profile_drag_that_goes_with_the_square_leaves_a_hyperbola() {
        let mut engine = engine();
        engine.stop();
        let (drag_nm, step_s) = (3.0, 1e-4);
        for _ in 0..20_000 {
            engine.advance(0.0, drag_nm * engine.speed * engine.speed, step_s);
        }
        let per_s = drag_nm / (EngineConfig::default().inertia_kgm2 * 160.0);
        assert_abs_diff_eq!(engine.speed, 1.0 / (1.0 + 2.0 * per_s), epsilon = 1e-4);
    }

    #[test]
    fn an_engine_at_its_limit_lets_the_speed_fall_and_a_freewheel_lets_it_rise() {
        let (mut short, mut driven) = (engine(), engine());
        short.advance(0.0, 14.0, 0.1);
        driven.advance(0.0, -2.0, 0.1);
        assert_abs_diff_eq!(short.speed, 1.0 - 1.0 / 16.0 * 0.1, epsilon = 1e-12);
        assert_abs_diff_eq!(driven.speed, 1.0 + 2.0 / 16.0 * 0.1, epsilon = 1e-12);
    }
}
