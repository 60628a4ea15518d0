//! The airframe of a vehicle: the nonlinear helicopter with its engine, or a linear model.

use super::engine::{Engine, EngineConfig};
use hovernav::controls::Sticks;
use hovernav::frames::{Ned, Vector};
use hovernav_model::helicopter::{Helicopter, HelicopterState, StateDerivative};
use hovernav_model::{LinearAirframe, StateSpace};

/// Model of the forces and moments at given positions of the servos.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "one for each vehicle, never moved")]
pub(super) enum Airframe {
    /// The nonlinear helicopter.
    Helicopter { helicopter: Helicopter, engine: Engine },
    /// A linear model about hover. Engine, ground cushion and skids are not part of it.
    Linear(LinearAirframe),
}

impl Airframe {
    pub fn helicopter(helicopter: Helicopter, engine: &EngineConfig) -> Self {
        let engine = Engine::new(engine, helicopter.parameters());
        Self::Helicopter { helicopter, engine }
    }

    /// Hover in calm air, heading north.
    pub fn hover(&self) -> HelicopterState {
        match self {
            Self::Helicopter { helicopter, .. } => *helicopter.hover(),
            Self::Linear(_) => HelicopterState::LEVEL,
        }
    }

    /// Stick positions in hover.
    pub fn hover_sticks(&self) -> Sticks {
        match self {
            Self::Helicopter { helicopter, .. } => helicopter.hover_sticks(),
            Self::Linear(_) => Sticks::NEUTRAL,
        }
    }

    /// Gravity that the airframe's equations use, m/s².
    pub fn gravity_mps2(&self) -> f64 {
        match self {
            Self::Helicopter { helicopter, .. } => helicopter.parameters().gravity_mps2,
            Self::Linear(_) => hovernav::earth::STANDARD_GRAVITY_MPS2,
        }
    }

    /// Derivative of `motion` with the servos at `servos`, in a wind of `wind_mps`.
    pub fn derivative(
        &self,
        motion: &HelicopterState,
        servos: &Sticks,
        wind_mps: Vector<Ned>,
    ) -> StateDerivative {
        match self {
            Self::Helicopter { helicopter, engine } => {
                helicopter.driven(motion, servos, wind_mps, engine.drive())
            }
            Self::Linear(linear) => linear.derivative(motion, servos, wind_mps),
        }
    }

    /// Advances the engine by `step_s`.
    pub fn advance(&mut self, collective: f64, torque_nm: f64, step_s: f64) {
        if let Self::Helicopter { engine, .. } = self {
            engine.advance(collective, torque_nm, step_s);
        }
    }
}

/// Response delays of one stick: transport delay and first-order lag, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lateness {
    pub delay_s: f64,
    /// Lag of the first-order response; `None` where the model does not state it.
    pub lag_s: Option<f64>,
}

impl Lateness {
    /// Delay and lag of each stick of `model`. The delay `period_s` of the flight computer is subtracted, because the
    /// flight computer adds it.
    pub fn of(model: &StateSpace, period_s: f64) -> [Self; 4] {
        ["lat", "lon", "col", "ped"].map(|stick| {
            let known = |kind: &str| {
                let name = format!("{kind}_{stick}");
                let own = model.parameters().iter().find(|own| own.name == name);
                own.map(|own| own.value.max(0.0))
            };
            let (delay_s, lag_s) = (known("tau"), known("lag"));
            let stated_s = delay_s.unwrap_or(period_s) - period_s;
            let lag_s = match (delay_s, lag_s) {
                (None, None) => None,
                // A delay shorter than that of the flight computer shortens the lag, so that the sum of delay and lag
                // is kept.
                _ => Some((lag_s.unwrap_or(0.0) + stated_s.min(0.0)).max(0.0)),
            };
            Self { delay_s: stated_s.max(0.0), lag_s }
        })
    }
}
