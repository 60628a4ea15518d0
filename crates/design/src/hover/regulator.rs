//! Sampled-data linear-quadratic regulators with integral action, for a plant behind a lagging servo
//! and one sample of delay.

use nalgebra::{DMatrix, DVector};

use crate::{DesignError, dare};
use hovernav::autopilot::RegulatorGains;
use hovernav::controls::Sticks;
use hovernav_model::StateSpace;

/// A continuous model whose sticks count from −1 to 1, with names.
#[derive(Clone, Debug)]
pub(super) struct Plant {
    pub names: Vec<String>,
    pub inputs: Vec<String>,
    pub a: DMatrix<f64>,
    pub b: DMatrix<f64>,
}

/// What every hover model has.
const MEASURED: [&str; 8] = ["p", "q", "phi", "theta", "u", "v", "w", "r"];
const STICKS: [&str; 4] = Sticks::NAMES;
/// Flapping and bar.
const ROTOR: [&str; 4] = ["a", "b", "c", "d"];

impl Plant {
    /// `model` with every stick scaled to −1…1, and with a heading if it has none.
    pub fn of(model: &StateSpace) -> Result<Self, DesignError> {
        model.require_continuous()?;
        for name in MEASURED {
            model.state(name)?;
        }
        let mut names: Vec<String> = model.states().iter().map(|s| s.name.clone()).collect();
        let mut a = model.a().clone();
        let mut b = DMatrix::zeros(names.len(), STICKS.len());
        for (column, name) in STICKS.into_iter().enumerate() {
            let input = model.input(name)?;
            let full = match model.inputs()[input].unit.as_str() {
                "stick" => 1.0,
                "percent" | "%" => 100.0,
                unit => {
                    return Err(DesignError::InputUnit { input: name.into(), unit: unit.into() });
                }
            };
            b.set_column(column, &(model.b().column(input) * full));
        }
        if !names.iter().any(|name| name == "psi") {
            let n = names.len();
            let rate = model.state("r")?;
            a = a.insert_row(n, 0.0).insert_column(n, 0.0);
            a[(n, rate)] = 1.0;
            b = b.insert_row(n, 0.0);
            names.push("psi".into());
        }
        Ok(Self { names, inputs: STICKS.map(String::from).to_vec(), a, b })
    }

    /// The states of flapping and bar it has.
    pub fn rotor_states(&self) -> Vec<&str> {
        self.named(|name| ROTOR.contains(&name))
    }

    /// The states it has that are neither measured nor the rotor's.
    pub fn other_states(&self) -> Vec<&str> {
        self.named(|name| name != "psi" && !MEASURED.contains(&name) && !ROTOR.contains(&name))
    }

    fn named(&self, keep: impl Fn(&str) -> bool) -> Vec<&str> {
        self.names.iter().map(String::as_str).filter(|name| keep(name)).collect()
    }

    pub fn index(&self, name: &str) -> usize {
        self.names.iter().position(|own| own == name).unwrap_or_default()
    }

    /// The states `measured`, then `hidden`, by `inputs` alone.
    pub fn part(&self, measured: &[&str], hidden: &[&str], inputs: &[&str]) -> Self {
        let rows: Vec<usize> = measured.iter().chain(hidden).map(|name| self.index(name)).collect();
        let columns: Vec<usize> = inputs
            .iter()
            .filter_map(|name| self.inputs.iter().position(|own| own == name))
            .collect();
        Self {
            names: rows.iter().map(|&row| self.names[row].clone()).collect(),
            inputs: inputs.iter().map(|&name| name.into()).collect(),
            a: self.a.select_rows(&rows).select_columns(&rows),
            b: self.b.select_rows(&rows).select_columns(&columns),
        }
    }

    /// The exact step over `period_s` of this plant behind first-order servos, commands held: states
    /// are the plant's, then where the servos stand.
    pub fn stepped(&self, servos_s: &[f64], period_s: f64) -> (DMatrix<f64>, DMatrix<f64>) {
        let (n, m) = self.b.shape();
        let mut generator = DMatrix::zeros(n + 2 * m, n + 2 * m);
        generator.view_mut((0, 0), (n, n)).copy_from(&self.a);
        generator.view_mut((0, n), (n, m)).copy_from(&self.b);
        for (servo, lag_s) in servos_s.iter().enumerate() {
            generator[(n + servo, n + servo)] = -1.0 / lag_s;
            generator[(n + servo, n + m + servo)] = 1.0 / lag_s;
        }
        let step = (generator * period_s).exp();
        (step.view((0, 0), (n + m, n + m)).into(), step.view((0, n + m), (n + m, m)).into())
    }
}

/// What a regulator minimises.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights<'a> {
    /// Of the measured states, which stand first.
    pub states: &'a [f64],
    /// Which measured states are integrated.
    pub integrated: &'a [usize],
    pub integrals: &'a [f64],
    pub sticks: &'a [f64],
    pub decay_per_s: f64,
}

/// The regulator of `part`, whose first `Y` states are measured.
///
/// # Source
/// Delay and servo as states: Franklin, Powell and Workman, *Digital Control of Dynamic Systems*,
/// section 4.3. Prescribed degree of stability: Anderson and Moore, *Optimal Control*, section 3.5.
pub(super) fn regulate<const Y: usize, const H: usize, const U: usize>(
    part: &Plant,
    servo_s: f64,
    period_s: f64,
    tracking_time_s: f64,
    weights: &Weights<'_>,
) -> Result<RegulatorGains<Y, H, U>, DesignError> {
    let (step, input) = part.stepped(&[servo_s; U], period_s);
    let moving = step.nrows();
    let (delay, integrals) = (moving, moving + U);
    let size = integrals + weights.integrated.len();
    let mut a = DMatrix::zeros(size, size);
    a.view_mut((0, 0), (moving, moving)).copy_from(&step);
    a.view_mut((0, delay), (moving, U)).copy_from(&input);
    let mut q = DVector::zeros(size);
    for (state, &weight) in weights.states.iter().enumerate() {
        q[state] = weight;
    }
    for (k, (&state, &weight)) in weights.integrated.iter().zip(weights.integrals).enumerate() {
        a[(integrals + k, integrals + k)] = 1.0;
        a[(integrals + k, state)] = period_s;
        q[integrals + k] = weight;
    }
    let mut b = DMatrix::zeros(size, U);
    b.view_mut((delay, 0), (U, U)).fill_with_identity();
    let r = DMatrix::from_diagonal(&DVector::from_row_slice(weights.sticks));
    let growth = (weights.decay_per_s * period_s).exp();
    let q = DMatrix::from_diagonal(&q);
    let gain = dare(&(a * growth), &(b * growth), &q, &r, None)?.gain;

    let hidden = moving - Y;
    let mut gains = RegulatorGains { tracking_time_s, ..RegulatorGains::default() };
    for u in 0..U {
        for y in 0..Y {
            gains.measured[u][y] = gain[(u, y)];
        }
        for h in 0..hidden {
            gains.hidden[u][h] = gain[(u, Y + h)];
        }
        for other in 0..U {
            gains.pending[u][other] = gain[(u, delay + other)];
        }
        for (k, &state) in weights.integrated.iter().enumerate() {
            gains.integral_per_s[u][state] = gain[(u, integrals + k)];
        }
    }
    for h in 0..hidden {
        for y in 0..Y {
            gains.hidden_from_measured[h][y] = step[(Y + h, y)];
        }
        for other in 0..hidden {
            gains.hidden_from_hidden[h][other] = step[(Y + h, Y + other)];
        }
        for u in 0..U {
            gains.hidden_from_pending[h][u] = input[(Y + h, u)];
        }
    }
    Ok(gains)
}
