//! The closed loop: the designed autopilot flies with servos, delay, sensors, estimator and wind.

mod campaign;
mod forward;
mod heading;
mod hover;
mod margins;
mod printed;
mod single;
mod start;
mod steps;

use hovernav::autopilot::{HoverConfig, SetPoint};
use hovernav::frames::Vector;
use hovernav_design::hover::HoverDesign;
use hovernav_model::shipped;
use hovernav_sim::Disturbance;

/// The autopilot of the 60-class helicopter.
fn autopilot() -> HoverConfig {
    let design = HoverDesign::default();
    HoverConfig::new(design.period_s, design.synthesise(&shipped::raptor60()).unwrap())
}

/// Holds zero velocity and heading: tests the regulators alone, without a position to return to.
const STOP: SetPoint =
    SetPoint::Velocity { forward_mps: 0.0, right_mps: 0.0, down_mps: 0.0, yaw_rate_radps: 0.0 };

/// States of the disturbances, in the order of [`disturbances`].
const STATES: [&str; 9] = ["phi", "theta", "psi", "p", "q", "r", "u", "v", "w"];

/// Paw (2005), table 6.1: each disturbance alone, by its state's name and size.
fn disturbances() -> [(&'static str, f64, Disturbance); 9] {
    let attitude = |attitude_rad| Disturbance { attitude_rad, ..Disturbance::default() };
    let rate = |p, q, r| Disturbance { rate_radps: Vector::new(p, q, r), ..Disturbance::default() };
    let velocity =
        |u, v, w| Disturbance { velocity_mps: Vector::new(u, v, w), ..Disturbance::default() };
    [
        ("phi", 0.5, attitude([0.5, 0.0, 0.0])),
        ("theta", 0.5, attitude([0.0, 0.5, 0.0])),
        ("psi", 0.3, attitude([0.0, 0.0, 0.3])),
        ("p", 1.0, rate(1.0, 0.0, 0.0)),
        ("q", 1.0, rate(0.0, 1.0, 0.0)),
        ("r", 1.0, rate(0.0, 0.0, 1.0)),
        ("u", 2.0, velocity(2.0, 0.0, 0.0)),
        ("v", 2.0, velocity(0.0, 2.0, 0.0)),
        ("w", 2.0, velocity(0.0, 0.0, 2.0)),
    ]
}

/// Last time, s, at which a value was further from zero than `band`; samples from 0 on.
fn settled_s(values: impl Iterator<Item = f64>, period_s: f64, band: f64) -> f64 {
    let last = values.enumerate().filter(|(_, value)| value.abs() > band).last();
    last.map_or(0.0, |(k, _)| (k + 1) as f64 * period_s)
}

/// Longest settling time of each disturbance: heave 2 s, yaw 1 s, all others 8 s.
fn allowed_s(name: &str) -> f64 {
    match name {
        "w" => 2.0,
        "psi" | "r" => 1.0,
        _ => 8.0,
    }
}
