//! Sampled-data linear-quadratic regulators with integral action, for a plant behind a lagging servo
//! and one sample of delay.

use nalgebra::{DMatrix, DVector};

use super::plant::stepped;
use crate::{DesignError, dare};
use hovernav::autopilot::RegulatorGains;
use hovernav_model::{LinearModel, StateSpace};

/// Weights that a regulator minimises.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights<'a> {
    /// Weights of the measured states, which are the first states.
    pub states: &'a [f64],
    /// Indices of the integrated measured states.
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
/// Equation (L8) of docs/equations.md.
pub(super) fn regulate<const Y: usize, const H: usize, const U: usize>(
    part: &StateSpace,
    servo_s: f64,
    period_s: f64,
    tracking_time_s: f64,
    weights: &Weights<'_>,
) -> Result<RegulatorGains<Y, H, U>, DesignError> {
    let LinearModel { a: step, b: input, .. } = stepped(part, &[servo_s; U], period_s)?;
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
