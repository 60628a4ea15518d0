//! Structures of hover models: the position of each derivative in the matrices.
//!
//! Units follow from the states (m/s, rad/s, rad) and from the given unit of the stick. Paw's derivatives are per
//! percent of stick.

use nalgebra::{DMatrix, dmatrix};

use super::error::ModelError;
use super::linear::TimeDomain;
use super::signal::Signal;
use super::state_space::StateSpace;
use hovernav::controls::Sticks;

/// States of hover models with their units. They are velocity and rate in body axes, attitude, flapping, the tilt of
/// the stabiliser bar and the low-passed rate of the yaw gyro. Flapping a is positive backwards, b to the right.
pub const STATES: [(&str, &str); 14] = [
    ("u", "m/s"),
    ("v", "m/s"),
    ("w", "m/s"),
    ("p", "rad/s"),
    ("q", "rad/s"),
    ("r", "rad/s"),
    ("phi", "rad"),
    ("theta", "rad"),
    ("psi", "rad"),
    ("a", "rad"),
    ("b", "rad"),
    ("c", "rad"),
    ("d", "rad"),
    ("rfb", "rad/s"),
];

/// The unit of the state `name` of a hover model, from [`STATES`]; empty for an unknown state.
#[must_use]
pub fn unit_of(name: &str) -> &'static str {
    STATES.into_iter().find(|(state, _)| *state == name).map_or("", |(_, unit)| unit)
}

/// Derivatives of the hybrid hover model: fuselage and first-order flapping.
///
/// # Source
/// Paw (2005), equations 3.50–3.57, doi:10.32657/10356/47095; flapping in the form of Mettler.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HybridDerivatives {
    /// Time constant of flapping, including the effect of the stabilizer bar, s.
    pub tau_f: f64,
    /// Longitudinal flapping due to lateral flapping, dimensionless.
    pub ab: f64,
    /// Lateral flapping due to longitudinal flapping, dimensionless.
    pub ba: f64,
    /// Lateral flapping due to lateral stick, rad per stick unit.
    pub blat: f64,
    /// Longitudinal flapping due to longitudinal stick, rad per stick unit.
    pub alon: f64,
    /// Forward force due to forward velocity, divided by mass, 1/s.
    pub xu: f64,
    /// Forward force due to longitudinal flapping, divided by mass, m/s² per rad; −g in hover.
    pub xa: f64,
    /// Side force due to side velocity, divided by mass, 1/s.
    pub yv: f64,
    /// Side force due to lateral flapping, divided by mass, m/s² per rad; g in hover.
    pub yb: f64,
    /// Vertical force due to vertical velocity, divided by mass, 1/s.
    pub zw: f64,
    /// Vertical force due to collective, divided by mass, m/s² per stick unit.
    pub zcol: f64,
    /// Rolling moment due to forward velocity, divided by inertia, rad/s² per m/s.
    pub lu: f64,
    /// Rolling moment due to side velocity, divided by inertia, rad/s² per m/s.
    pub lv: f64,
    /// Rolling moment due to longitudinal flapping, divided by inertia, 1/s².
    pub la: f64,
    /// Rolling moment due to lateral flapping, divided by inertia, 1/s².
    pub lb: f64,
    /// Pitching moment due to forward velocity, divided by inertia, rad/s² per m/s.
    pub mu: f64,
    /// Pitching moment due to side velocity, divided by inertia, rad/s² per m/s.
    pub mv: f64,
    /// Pitching moment due to longitudinal flapping, divided by inertia, 1/s².
    pub ma: f64,
    /// Pitching moment due to lateral flapping, divided by inertia, 1/s².
    pub mb: f64,
    /// Yawing moment due to yaw rate, divided by inertia, 1/s.
    pub nr: f64,
    /// Yawing moment due to collective, divided by inertia, rad/s² per stick unit.
    pub ncol: f64,
    /// Yawing moment due to pedal, divided by inertia, rad/s² per stick unit.
    pub nped: f64,
    /// Gravity, m/s².
    pub gravity_mps2: f64,
}

impl HybridDerivatives {
    /// The continuous model with 10 states: b, a, p, q, phi, theta, u, v, w, r. Its inputs are lateral, longitudinal,
    /// collective, pedal in `stick_unit`.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`] where a derivative is not finite or the time constant is zero.
    ///
    /// # Source
    /// Equation (V14) of docs/equations.md.
    pub fn state_space(&self, stick_unit: &str) -> Result<StateSpace, ModelError> {
        let Self { tau_f, xu, xa, yv, yb, zw, lu, lv, la, lb, mu, mv, ma, mb, nr, .. } = *self;
        let (g, k) = (self.gravity_mps2, 1.0 / tau_f);
        let (ab, ba) = (self.ab * k, self.ba * k);
        let a = dmatrix![
            -k, ba, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
            ab, -k, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
            lb, la, 0.0, 0.0, 0.0, 0.0, lu, lv, 0.0, 0.0;
            mb, ma, 0.0, 0.0, 0.0, 0.0, mu, mv, 0.0, 0.0;
            0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
            0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
            0.0, xa, 0.0, 0.0, 0.0, -g, xu, 0.0, 0.0, 0.0;
            yb, 0.0, 0.0, 0.0, g, 0.0, 0.0, yv, 0.0, 0.0;
            0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, zw, 0.0;
            0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, nr;
        ];
        let mut b = DMatrix::zeros(10, 4);
        b[(0, 0)] = self.blat * k;
        b[(1, 1)] = self.alon * k;
        b[(8, 2)] = self.zcol;
        b[(9, 2)] = self.ncol;
        b[(9, 3)] = self.nped;
        let states = ["b", "a", "p", "q", "phi", "theta", "u", "v", "w", "r"];
        continuous("hybrid-hover", &states, stick_unit, a, b)
    }
}

/// Derivatives of the reduced hover model: without flapping states, the cyclic acts on rates and velocities directly.
///
/// # Source
/// Paw (2005), section 5.6.1.3.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReducedDerivatives {
    /// Rolling moment due to roll rate, divided by inertia, 1/s.
    pub lp: f64,
    /// Rolling moment due to pitch rate, divided by inertia, 1/s.
    pub lq: f64,
    /// Pitching moment due to roll rate, divided by inertia, 1/s.
    pub mp: f64,
    /// Pitching moment due to pitch rate, divided by inertia, 1/s.
    pub mq: f64,
    /// Rolling moment due to forward velocity, divided by inertia, rad/s² per m/s.
    pub lu: f64,
    /// Rolling moment due to side velocity, divided by inertia, rad/s² per m/s.
    pub lv: f64,
    /// Pitching moment due to forward velocity, divided by inertia, rad/s² per m/s.
    pub mu: f64,
    /// Pitching moment due to side velocity, divided by inertia, rad/s² per m/s.
    pub mv: f64,
    /// Forward force due to forward velocity, divided by mass, 1/s.
    pub xu: f64,
    /// Side force due to side velocity, divided by mass, 1/s.
    pub yv: f64,
    /// Cyclic derivatives: rows p, q, u, v; columns lateral, longitudinal, per stick unit.
    pub cyclic: [[f64; 2]; 4],
    /// Vertical force due to vertical velocity, divided by mass, 1/s.
    pub zw: f64,
    /// Vertical force due to collective, divided by mass, m/s² per stick unit.
    pub zcol: f64,
    /// Yawing moment due to yaw rate, divided by inertia, 1/s.
    pub nr: f64,
    /// Yawing moment due to collective, divided by inertia, rad/s² per stick unit.
    pub ncol: f64,
    /// Yawing moment due to pedal, divided by inertia, rad/s² per stick unit.
    pub nped: f64,
    /// Gravity, m/s².
    pub gravity_mps2: f64,
}

impl ReducedDerivatives {
    /// The derivatives printed by Paw, per percent of stick. Their signs are those that reproduce his eigenvalues and
    /// his gain. He calls them continuous; see [`StateSpace::step_taken_for_rate`].
    ///
    /// # Source
    /// Equation (V15) of docs/equations.md.
    #[must_use]
    pub const fn thesis() -> Self {
        Self {
            lp: 0.78230,
            lq: -0.0632,
            mp: 0.0374,
            mq: 0.6981,
            lu: -3.5817e-3,
            lv: -4.6147e-3,
            mu: -5.4394e-3,
            mv: -6.9948e-3,
            xu: 0.99274,
            yv: 0.99262,
            cyclic: [[1.3795, 0.20969], [0.86529, 1.6047], [-4.1164, 3.2734], [6.8492, -6.9214]],
            zw: 0.98902,
            zcol: 0.3207,
            nr: 0.30926,
            ncol: 0.043484,
            nped: -6.5782,
            gravity_mps2: 9.81,
        }
    }

    /// The continuous model with 8 states: p, q, phi, theta, u, v, w, r. Its inputs are lateral, longitudinal,
    /// collective, pedal in `stick_unit`.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`] where a derivative is not finite.
    pub fn state_space(&self, stick_unit: &str) -> Result<StateSpace, ModelError> {
        let Self { lp, lq, mp, mq, lu, lv, mu, mv, xu, yv, zw, nr, gravity_mps2: g, .. } = *self;
        let a = dmatrix![
            lp, lq, 0.0, 0.0, lu, lv, 0.0, 0.0;
            mp, mq, 0.0, 0.0, mu, mv, 0.0, 0.0;
            1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
            0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
            0.0, 0.0, 0.0, -g, xu, 0.0, 0.0, 0.0;
            0.0, 0.0, g, 0.0, 0.0, yv, 0.0, 0.0;
            0.0, 0.0, 0.0, 0.0, 0.0, 0.0, zw, 0.0;
            0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, nr;
        ];
        let mut b = DMatrix::zeros(8, 4);
        for (row, cyclic) in [0, 1, 4, 5].into_iter().zip(self.cyclic) {
            b[(row, 0)] = cyclic[0];
            b[(row, 1)] = cyclic[1];
        }
        b[(6, 2)] = self.zcol;
        b[(7, 2)] = self.ncol;
        b[(7, 3)] = self.nped;
        let states = ["p", "q", "phi", "theta", "u", "v", "w", "r"];
        continuous("reduced-hover", &states, stick_unit, a, b)
    }
}

/// The hover model without its fast states: flapping a and b, bar c and d, yaw-rate feedback rfb. They are removed by
/// [`StateSpace::residualised`].
///
/// # Errors
/// [`ModelError::NoSteadyValue`] where the fast states have no steady state.
pub fn quasi_steady(model: &StateSpace) -> Result<StateSpace, ModelError> {
    let fast: Vec<&str> = ["a", "b", "c", "d", "rfb"]
        .into_iter()
        .filter(|fast| model.states().iter().any(|state| state.name == *fast))
        .collect();
    model.residualised(&fast)
}

/// Roll and pitch subsystem of a hover model: p, q, phi, theta, u, v from the cyclic. [`quasi_steady`] removes the fast
/// states first, also in [`heave`] and [`yaw`].
///
/// # Errors
/// [`ModelError::Unknown`] where the model lacks one of these states or inputs, as in [`heave`] and [`yaw`].
pub fn roll_pitch(model: &StateSpace) -> Result<StateSpace, ModelError> {
    quasi_steady(model)?
        .subsystem(&["p", "q", "phi", "theta", "u", "v"], &["lateral", "longitudinal"])
}

/// Heave subsystem of a hover model: w from the collective.
///
/// # Errors
/// As [`roll_pitch`].
pub fn heave(model: &StateSpace) -> Result<StateSpace, ModelError> {
    quasi_steady(model)?.subsystem(&["w"], &["collective"])
}

/// Yaw subsystem of a hover model with heading: r and psi from collective and pedal, as in Paw's heading hold. Heading
/// is the integral of r. For a discrete model this integral is exact if r is constant between samples.
///
/// # Errors
/// As [`roll_pitch`].
pub fn yaw(model: &StateSpace) -> Result<StateSpace, ModelError> {
    let rate = quasi_steady(model)?.subsystem(&["r"], &["collective", "pedal"])?;
    let (per_rate, own) = match model.time() {
        TimeDomain::Continuous => (1.0, 0.0),
        TimeDomain::Discrete { period_s } => (period_s, 1.0),
    };
    let a = dmatrix![rate.a()[(0, 0)], 0.0; per_rate, own];
    let b = rate.b().clone().insert_row(1, 0.0);
    let states = vec![rate.states()[0].clone(), Signal::new("psi", "rad")];
    let yaw = StateSpace::new(model.name(), model.time(), states, rate.inputs().to_vec(), a, b)?;
    Ok(yaw.with_source(model.source()))
}

fn continuous(
    name: &str,
    states: &[&str],
    stick_unit: &str,
    a: DMatrix<f64>,
    b: DMatrix<f64>,
) -> Result<StateSpace, ModelError> {
    let states = states.iter().map(|state| Signal::new(state, unit_of(state))).collect();
    let inputs = Sticks::NAMES.map(|stick| Signal::new(stick, stick_unit)).to_vec();
    StateSpace::new(name, TimeDomain::Continuous, states, inputs, a, b)
}
