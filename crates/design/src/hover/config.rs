//! Weights of a hover design.

use std::path::Path;

use super::estimator::EstimatorLag;
use crate::DesignError;
use hovernav::autopilot::GuidanceConfig;
use hovernav_model::StateSpace;

/// Weights of the design, and the dynamics between a command and the model.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct HoverDesign {
    /// Sample period of the loop, s.
    pub period_s: f64,
    /// Time constant of the servos of cyclic and collective, s.
    pub servo_s: f64,
    /// Time constant of the tail servo, s.
    pub tail_servo_s: f64,
    /// Lag of the loops' measurements against the motion: zero in [`default`](Self::default), the measured lag in
    /// [`for_model`](Self::for_model).
    pub estimator: EstimatorLag,
    /// Delay of the loops' measurements by a notch on the rotor's harmonics, s: see [`NotchCost`](crate::NotchCost).
    pub notch_s: f64,
    /// Anti-windup time constant, s, with which integrals track a limited command. A heading integral with an
    /// integration time above ten times this value is tracked more slowly. Its tracking time is half its integration
    /// time, at most 500 s.
    pub tracking_s: f64,
    /// Weights of the roll and pitch regulator that also controls velocity.
    pub roll_pitch: RollPitchWeights,
    /// Weights of the roll and pitch regulator that controls attitude only.
    pub attitude: AttitudeWeights,
    /// Weights of the yaw regulator.
    pub yaw: YawWeights,
    /// Poles of the heave loop.
    pub heave: HeavePoles,
    /// Guidance towards a held position, which closes the position loop.
    #[serde(skip)]
    pub guidance: GuidanceConfig,
}

/// Weights of the velocity regulator. Sticks count from −1 to 1.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub struct RollPitchWeights {
    /// Weights of the squares of p, q, φ, θ, u, v, per (rad/s)², rad², (m/s)².
    pub states: [f64; 6],
    /// Weights of the squared integrals of u and v, per m².
    pub integrals: [f64; 2],
    /// Weights of the squares of lateral and longitudinal stick.
    pub sticks: [f64; 2],
    /// Smallest decay rate of every disturbance, α, 1/s.
    pub decay_per_s: f64,
}

/// Weights of the attitude regulator.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub struct AttitudeWeights {
    /// Weights of the squares of p, q, φ, θ.
    pub states: [f64; 4],
    /// Weights of the squared integrals of φ and θ.
    pub integrals: [f64; 2],
    /// Weights of the squares of lateral and longitudinal stick.
    pub sticks: [f64; 2],
    /// As [`RollPitchWeights::decay_per_s`].
    pub decay_per_s: f64,
}

/// Weights of the yaw regulator.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub struct YawWeights {
    /// Weights of the squares of r and ψ.
    pub states: [f64; 2],
    /// Weight of the squared integral of ψ.
    pub integral: f64,
    /// Weight of the square of the pedal.
    pub stick: f64,
    /// As [`RollPitchWeights::decay_per_s`].
    pub decay_per_s: f64,
}

/// Poles of the heave loop, for its PID.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub struct HeavePoles {
    /// Natural frequency, rad/s.
    pub frequency_radps: f64,
    /// Damping ratio.
    pub damping: f64,
    /// Derivative gain over proportional gain, s.
    pub derivative_s: f64,
    /// Time constant of the derivative's filter, s.
    pub derivative_filter_s: f64,
}

impl Default for HoverDesign {
    /// Design for a 60-class helicopter at 33 Hz with the servos of `hovernav-sim`.
    fn default() -> Self {
        Self {
            period_s: 1.0 / 33.0,
            servo_s: 0.02,
            tail_servo_s: 0.0133,
            estimator: EstimatorLag::NONE,
            notch_s: 0.0,
            tracking_s: 0.5,
            roll_pitch: RollPitchWeights {
                states: [1.0, 1.0, 10.0, 15.0, 0.6, 0.6],
                integrals: [0.2, 0.2],
                sticks: [10.0, 10.0],
                decay_per_s: 0.1,
            },
            attitude: AttitudeWeights {
                states: [0.1, 0.1, 3.0, 3.0],
                integrals: [1.0, 1.0],
                sticks: [1.0, 1.0],
                decay_per_s: 0.0,
            },
            yaw: YawWeights { states: [0.03, 10.0], integral: 10.0, stick: 0.05, decay_per_s: 0.0 },
            heave: HeavePoles {
                frequency_radps: 3.0,
                damping: 1.0,
                derivative_s: 0.0,
                derivative_filter_s: 0.05,
            },
            guidance: GuidanceConfig::default(),
        }
    }
}

/// Largest lag that replaces a delay, s.
const MAX_LAG_S: f64 = 0.15;

impl HoverDesign {
    /// Design for the model printed by Paw (2005), as found by [`searched`](Self::searched). Every mode of this model
    /// is unstable, and full stick is 100 in the unit of its inputs, percent. Every flight mode has margins of 45° and
    /// 6 dB, and every disturbance decays within 8 s. Nine of ten models with every derivative off by up to 20 % stay
    /// stable. The design does not include the lag of an estimator: the usual lag leaves 35° and 5.7 dB. A search that
    /// includes the lag reaches 38° and 7.7 dB.
    #[must_use]
    pub fn thesis() -> Self {
        Self {
            roll_pitch: RollPitchWeights {
                states: [0.013338, 1.02044, 0.064631, 0.111824, 0.0022167, 0.0079018],
                integrals: [0.010578, 0.00134866],
                sticks: [2.2383, 10.0],
                decay_per_s: 0.0099506,
            },
            attitude: AttitudeWeights {
                states: [0.0694, 0.1045, 0.216, 0.0731],
                integrals: [0.6345, 0.0664],
                sticks: [6.562, 5.364],
                decay_per_s: 0.0,
            },
            yaw: YawWeights {
                states: [0.549, 11.24],
                integral: 0.00778,
                stick: 1700.0,
                decay_per_s: 0.0036,
            },
            heave: HeavePoles { frequency_radps: 2.597, damping: 1.062, ..Self::default().heave },
            estimator: EstimatorLag::NONE,
            ..Self::default()
        }
    }

    /// The design for `model`: [`thesis`](Self::thesis) for the model of the thesis, otherwise the default with the lag
    /// of the estimator. A model may contain delays and lags of its sticks. Their sum minus one sample of the loop
    /// replaces the servo lag if it is larger.
    #[must_use]
    pub fn for_model(model: &StateSpace) -> Self {
        if model.name() == "thesis-hover" {
            return Self::thesis();
        }
        let design = Self { estimator: EstimatorLag::default(), ..Self::default() };
        design.as_late_as(design.late_s(model))
    }

    /// The same design behind servos with at least these lags, s, of cyclic and collective and of the pedal.
    #[must_use]
    pub(crate) fn as_late_as(&self, [cyclic_s, tail_s]: [f64; 2]) -> Self {
        Self {
            servo_s: self.servo_s.max(cyclic_s.min(MAX_LAG_S)),
            tail_servo_s: self.tail_servo_s.max(tail_s.min(MAX_LAG_S)),
            ..self.clone()
        }
    }

    /// Largest sum of stick delay and lag in `model` minus one sample of the loop, s. The first value is that of cyclic
    /// and collective, the second that of the pedal; 0 where the model contains no delay and lag.
    pub(crate) fn late_s(&self, model: &StateSpace) -> [f64; 2] {
        let of = |name: String| {
            let found = model.parameters().iter().find(|known| known.name == name);
            found.map_or(0.0, |parameter| parameter.value)
        };
        let late = |sticks: &[&str]| {
            let delays = sticks.iter().map(|at| of(format!("tau_{at}")) + of(format!("lag_{at}")));
            delays.fold(0.0, |most, delay_s| f64::max(most, delay_s - self.period_s))
        };
        [late(&["lat", "lon", "col"]), late(&["ped"])]
    }

    /// Reads weights, poles and times from a TOML file. Missing values and sections are those of
    /// [`for_model`](Self::for_model), including the lags of the servos and of the estimator.
    ///
    /// # Errors
    /// [`DesignError::Toml`], [`DesignError::Surplus`] for one weight too many, and [`DesignError::Range`] for invalid
    /// values: a weight below zero makes the cost indefinite.
    pub fn read(path: &Path, model: &StateSpace) -> Result<Self, DesignError> {
        let text = hovernav_toml::read_text(path)?;
        let (_, unread): (Self, Vec<String>) = hovernav_toml::parse(&text, path)?;
        if let Some(place) = unread.into_iter().next() {
            return Err(DesignError::Surplus { path: path.into(), place });
        }
        let given = hovernav_toml::parse_table(&text, path)?;
        let design = hovernav_toml::overlaid(&Self::for_model(model), given)
            .map_err(|error| hovernav_toml::TomlError::at(path, &text, 0, &error.to_string()))?;
        design.check()?;
        Ok(design)
    }

    pub(super) fn check(&self) -> Result<(), DesignError> {
        const WEIGHT: &str = "above 0, at most 1e12";
        let Self { roll_pitch, attitude, yaw, heave, .. } = self;
        within("period_s", &[self.period_s], [1e-3, 0.2], "0.001 to 0.2 s")?;
        within("servo_s", &[self.servo_s], [1e-6, 10.0], "above 0, at most 10 s")?;
        within("tail_servo_s", &[self.tail_servo_s], [1e-6, 10.0], "above 0, at most 10 s")?;
        let EstimatorLag { rate_s, attitude_s, velocity_s } = self.estimator;
        within("estimator", &[rate_s, attitude_s, velocity_s], [0.0, 0.5], "0 to 0.5 s")?;
        within("notch_s", &[self.notch_s], [0.0, 0.2], "0 to 0.2 s")?;
        within("tracking_s", &[self.tracking_s], [1e-3, 1e3], "0.001 to 1000 s")?;
        let weight = |name, values: &[f64]| within(name, values, [1e-12, 1e12], WEIGHT);
        weight("roll_pitch.states", &roll_pitch.states)?;
        weight("roll_pitch.integrals", &roll_pitch.integrals)?;
        weight("roll_pitch.sticks", &roll_pitch.sticks)?;
        weight("attitude.states", &attitude.states)?;
        weight("attitude.integrals", &attitude.integrals)?;
        weight("attitude.sticks", &attitude.sticks)?;
        weight("yaw.states", &yaw.states)?;
        weight("yaw.integral", &[yaw.integral])?;
        weight("yaw.stick", &[yaw.stick])?;
        let decay = |name, value: f64| within(name, &[value], [0.0, 10.0], "0 to 10 1/s");
        decay("roll_pitch.decay_per_s", roll_pitch.decay_per_s)?;
        decay("attitude.decay_per_s", attitude.decay_per_s)?;
        decay("yaw.decay_per_s", yaw.decay_per_s)?;
        let frequency = [heave.frequency_radps];
        within("heave.frequency_radps", &frequency, [0.01, 100.0], "0.01 to 100 rad/s")?;
        within("heave.damping", &[heave.damping], [0.01, 100.0], "0.01 to 100")?;
        within("heave.derivative_s", &[heave.derivative_s], [-10.0, 10.0], "-10 to 10 s")?;
        within("heave.derivative_filter_s", &[heave.derivative_filter_s], [0.0, 10.0], "0 to 10 s")
    }
}

/// Rejects the first of `values` outside `[lowest, highest]`, and NaN.
fn within(
    name: &'static str,
    values: &[f64],
    [lowest, highest]: [f64; 2],
    expected: &'static str,
) -> Result<(), DesignError> {
    match values.iter().find(|value| !(lowest..=highest).contains(*value)) {
        Some(&value) => Err(DesignError::Range { name, value, expected }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav_model::{Parameter, shipped};

    /// An empty file must not reset the identified servo lags.
    #[test]
    fn what_a_file_leaves_out_is_as_the_model_has_it() {
        let late = Parameter { name: "tau_col".into(), value: 0.09, unit: "s".into() };
        let model = shipped::raptor60().with_parameters(vec![late], None).unwrap();
        let path =
            std::env::temp_dir().join(format!("hovernav-weights-{}.toml", std::process::id()));
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            let design = HoverDesign::read(&path, &model);
            std::fs::remove_file(&path).unwrap();
            design
        };
        let own = HoverDesign::for_model(&model);
        assert!(own.servo_s > 2.0 * HoverDesign::default().servo_s);
        assert_eq!(read("").unwrap(), own);
        let given = read("servo_s = 0.03\nnotch_s = 0.001").unwrap();
        assert_eq!(given, HoverDesign { servo_s: 0.03, notch_s: 0.001, ..own });
        assert!(matches!(read("servo_s = -1.0"), Err(DesignError::Range { name: "servo_s", .. })));
        assert!(matches!(read("none = 1"), Err(DesignError::Toml(_))));
        let told = read("tracking_s = 1e300").unwrap_err().to_string();
        assert_eq!(told, "tracking_s: found 1e300, expected 0.001 to 1000 s");
    }
}
