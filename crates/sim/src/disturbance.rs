//! Disturbances of a vehicle in flight.

use hovernav::frames::{Body, Vector};

/// A disturbance in progress.
#[derive(Clone, Copy, Debug)]
pub(super) struct Push {
    disturbance: Disturbance,
    elapsed_s: f64,
}

/// Duration of a push, s: long enough for gyros and accelerometers to stay within their ranges.
const PUSH_S: f64 = 0.3;

impl Push {
    pub const fn new(disturbance: Disturbance) -> Self {
        Self { disturbance, elapsed_s: 0.0 }
    }

    /// Whether the whole push has acted.
    pub fn is_over(&self) -> bool {
        self.elapsed_s >= PUSH_S
    }

    /// Acceleration and angular rate over the next `step_s`.
    pub fn advance(&mut self, step_s: f64) -> (Vector<Body>, Vector<Body>) {
        let left_s = (PUSH_S - self.elapsed_s).min(step_s);
        self.elapsed_s += step_s;
        let per_s = left_s / (PUSH_S * step_s);
        let [roll, pitch, yaw] = self.disturbance.attitude_rad;
        (self.disturbance.velocity_mps * per_s, Vector::new(roll, pitch, yaw) * per_s)
    }
}

/// A step in the vehicle's state, as the disturbances of Paw (2005), table 6.1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// Roll, pitch and heading, rad.
    pub attitude_rad: [f64; 3],
    /// p, q, r, rad/s.
    pub rate_radps: Vector<Body>,
    /// u, v, w, m/s.
    pub velocity_mps: Vector<Body>,
}

impl Disturbance {
    /// The disturbance of one state alone by `size`; `None` for an unknown name. The states are `phi`, `theta`, `psi`,
    /// rad, `p`, `q`, `r`, rad/s, `u`, `v`, `w`, m/s.
    #[must_use]
    pub fn of_state(state: &str, size: f64) -> Option<Self> {
        let axes = [[size, 0.0, 0.0], [0.0, size, 0.0], [0.0, 0.0, size]];
        let vector = |axis: usize| {
            let [x, y, z] = axes[axis];
            Vector::new(x, y, z)
        };
        let none = Self::default();
        Some(match state {
            "phi" => Self { attitude_rad: axes[0], ..none },
            "theta" => Self { attitude_rad: axes[1], ..none },
            "psi" => Self { attitude_rad: axes[2], ..none },
            "p" => Self { rate_radps: vector(0), ..none },
            "q" => Self { rate_radps: vector(1), ..none },
            "r" => Self { rate_radps: vector(2), ..none },
            "u" => Self { velocity_mps: vector(0), ..none },
            "v" => Self { velocity_mps: vector(1), ..none },
            "w" => Self { velocity_mps: vector(2), ..none },
            _ => return None,
        })
    }
}
