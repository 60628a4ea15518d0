//! Kinematic consistency of attitude, rates and velocity.
//!
//! Kinematics hold regardless of aerodynamics. A record that violates them has a wrong unit, sign, axis or clock, and
//! every model fitted to it is meaningless. Each relation is checked in its integrated form, in pieces without mean and
//! slope. Differentiation would amplify noise, and a bias or a slow drift is not a fault here.
//!
//! Source: R. Jategaonkar, *Flight Vehicle System Identification*, chapter 10 (data compatibility
//! check); M. Tischler & R. Remple, *Aircraft and Rotorcraft System Identification*, section 5.8.

use std::fmt;

use hovernav::earth::STANDARD_GRAVITY_MPS2;
use nalgebra::{DMatrix, DVector};

use crate::record::experiment::{Experiment, ExperimentError};
use hovernav_model::linalg::least_squares;

/// Names of the signals. Angles in rad, rates in rad/s, body-axis velocities in m/s, specific forces in m/s². A
/// relation is checked where all its signals are named.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct KinematicChannels<'a> {
    /// Roll φ, right wing down.
    pub roll: Option<&'a str>,
    /// Pitch θ, nose up.
    pub pitch: Option<&'a str>,
    /// Rate p about the forward axis.
    pub p: Option<&'a str>,
    /// Rate q about the right axis.
    pub q: Option<&'a str>,
    /// Rate r about the down axis.
    pub r: Option<&'a str>,
    /// Velocity u forward.
    pub u: Option<&'a str>,
    /// Velocity v to the right.
    pub v: Option<&'a str>,
    /// Velocity w down.
    pub w: Option<&'a str>,
    /// Specific force forward, right and down.
    pub specific_force: Option<[&'a str; 3]>,
}

/// Result of checking one relation.
#[derive(Debug, Clone, PartialEq)]
pub struct Relation {
    /// The relation, as an equation.
    pub equation: &'static str,
    /// Factor on the right-hand side that fits the left-hand side: 1 for a consistent record.
    pub scale: f64,
    /// Fraction of the left-hand side's movement that the right-hand side explains, 0 to 1.
    pub explained: f64,
    /// Time by which the left-hand side lags the right-hand side, s.
    pub skew_s: f64,
}

/// A fault of a relation.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum KinematicFault {
    /// The sides have opposite signs: a sign or an axis is wrong.
    Sign(Relation),
    /// The sides differ in size: a unit, a scale or the point of measurement is wrong.
    Scale(Relation),
    /// The sides are unrelated.
    Unrelated(Relation),
    /// One side is delayed: clocks or filters differ.
    Skew(Relation),
}

impl fmt::Display for KinematicFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sign(Relation { equation, scale, .. }) => {
                write!(f, "{equation} holds only with the sign reversed (factor {scale:.2})")
            }
            Self::Scale(Relation { equation, scale, .. }) => {
                write!(f, "{equation} holds only with the right-hand side times {scale:.2}")
            }
            Self::Unrelated(Relation { equation, explained, .. }) => {
                write!(f, "{equation} explains only {:.0} % of the measurement", 100.0 * explained)
            }
            Self::Skew(Relation { equation, skew_s, .. }) => {
                write!(f, "{equation}: the left-hand side is {skew_s:.3} s late")
            }
        }
    }
}

/// All checked relations, and their faults.
#[derive(Debug, Clone, PartialEq)]
pub struct KinematicReport {
    /// The relations.
    pub relations: Vec<Relation>,
    /// The faults; empty where the record is kinematically consistent.
    pub faults: Vec<KinematicFault>,
}

/// Length of the pieces, s: long compared with a manoeuvre, short compared with the drift of a bias.
const PIECE_S: f64 = 10.0;
/// Longest delay or lead that is searched, s.
const LONGEST_SKEW_S: f64 = 0.25;
/// Largest delay between the sides, samples; beyond it clocks or filters differ.
const MAX_SKEW: usize = 2;
/// Range of the factor of a correct kinematic relation.
const CLOSES: [f64; 2] = [0.85, 1.15];
/// Smallest explained fraction of a valid relation.
const RELATED: f64 = 0.8;
/// Smallest explained fraction that shows a reversed sign.
const REVERSED: f64 = 0.25;
/// Range of the factor of a correct balance of gravity and drag. This balance omits the forces of the rotor, so only
/// its sign and order of magnitude are checked.
const ROUGHLY: [f64; 2] = [0.3, 3.0];
/// Smallest explained fraction of a correct balance of gravity and drag.
const ROUGHLY_RELATED: f64 = 0.5;

/// Checks every kinematic relation whose signals are all named in `channels`.
///
/// Two relations are φ̇ = p + tan θ (q sin φ + r cos φ) and θ̇ = q cos φ − r sin φ. The others compare the body-axis
/// velocity with specific force and gravity. Without specific force, u̇ and v̇ are compared with gravity along the
/// tilted axes and drag. In hover they must at least agree in sign and magnitude.
///
/// # Errors
/// [`ExperimentError::UnknownSignal`] where a named signal is not in the record.
///
/// # Source
/// Equation (I3) of docs/equations.md.
pub fn check_kinematics(
    experiment: &Experiment,
    channels: &KinematicChannels<'_>,
) -> Result<KinematicReport, ExperimentError> {
    let get = |name: Option<&str>| name.map(|name| experiment.signal(name)).transpose();
    let (roll, pitch) = (get(channels.roll)?, get(channels.pitch)?);
    let (p, q, r) = (get(channels.p)?, get(channels.q)?, get(channels.r)?);
    let (u, v, w) = (get(channels.u)?, get(channels.v)?, get(channels.w)?);
    let force = match channels.specific_force {
        Some(names) => {
            let [x, y, z] = names.map(|name| experiment.signal(name));
            Some([x?, y?, z?])
        }
        None => None,
    };
    let samples = experiment.samples();
    let combine = |at: &dyn Fn(usize) -> f64| DVector::from_fn(samples, |sample, _| at(sample));
    let mut check = Check { period_s: experiment.period_s, relations: vec![], faults: vec![] };

    if let (Some(roll), Some(pitch), Some(p), Some(q), Some(r)) = (&roll, &pitch, &p, &q, &r) {
        let rate =
            combine(&|k| p[k] + pitch[k].tan() * (q[k] * roll[k].sin() + r[k] * roll[k].cos()));
        check.relate("φ̇ = p + tan θ (q sin φ + r cos φ)", roll, &rate, None);
        let rate = combine(&|k| q[k] * roll[k].cos() - r[k] * roll[k].sin());
        check.relate("θ̇ = q cos φ − r sin φ", pitch, &rate, None);
    }
    let (Some(roll), Some(pitch)) = (&roll, &pitch) else { return Ok(check.done()) };
    let gravity = [
        combine(&|k| -STANDARD_GRAVITY_MPS2 * pitch[k].sin()),
        combine(&|k| STANDARD_GRAVITY_MPS2 * pitch[k].cos() * roll[k].sin()),
        combine(&|k| STANDARD_GRAVITY_MPS2 * pitch[k].cos() * roll[k].cos()),
    ];
    match (&force, [&u, &v, &w], [&p, &q, &r]) {
        (Some([x, y, z]), [Some(u), Some(v), Some(w)], [Some(p), Some(q), Some(r)]) => {
            let force = combine(&|k| x[k] + gravity[0][k] + r[k] * v[k] - q[k] * w[k]);
            check.relate("u̇ = fx − g sin θ + r v − q w", u, &force, None);
            let force = combine(&|k| y[k] + gravity[1][k] + p[k] * w[k] - r[k] * u[k]);
            check.relate("v̇ = fy + g cos θ sin φ + p w − r u", v, &force, None);
            let force = combine(&|k| z[k] + gravity[2][k] + q[k] * u[k] - p[k] * v[k]);
            check.relate("ẇ = fz + g cos θ cos φ + q u − p v", w, &force, None);
        }
        _ => {
            if let Some(u) = &u {
                check.relate("u̇ ∼ −g sin θ + Xu u", u, &gravity[0], Some(u));
            }
            if let Some(v) = &v {
                check.relate("v̇ ∼ g cos θ sin φ + Yv v", v, &gravity[1], Some(v));
            }
        }
    }
    Ok(check.done())
}

struct Check {
    period_s: f64,
    relations: Vec<Relation>,
    faults: Vec<KinematicFault>,
}

impl Check {
    /// Compares `integral` with the running sum of `rate`; for a rough relation, `drag` times a fitted factor is added
    /// to `rate`.
    fn relate(
        &mut self,
        equation: &'static str,
        integral: &DVector<f64>,
        rate: &DVector<f64>,
        drag: Option<&DVector<f64>>,
    ) {
        let reach = (LONGEST_SKEW_S / self.period_s) as isize;
        let best = (-reach..=reach)
            .filter_map(|shift| Some((shift, self.fit(integral, rate, drag, shift)?)))
            .max_by(|(_, [_, one]), (_, [_, other])| one.total_cmp(other));
        let Some((shift, [scale, explained])) = best else { return };
        let relation =
            Relation { equation, scale, explained, skew_s: shift as f64 * self.period_s };
        let ([least, most], related) =
            if drag.is_some() { (ROUGHLY, ROUGHLY_RELATED) } else { (CLOSES, RELATED) };
        if scale < 0.0 && explained > REVERSED {
            self.faults.push(KinematicFault::Sign(relation.clone()));
        } else if explained < related {
            self.faults.push(KinematicFault::Unrelated(relation.clone()));
        } else {
            if !(least..=most).contains(&scale) {
                self.faults.push(KinematicFault::Scale(relation.clone()));
            }
            if drag.is_none() && shift.unsigned_abs() > MAX_SKEW {
                self.faults.push(KinematicFault::Skew(relation.clone()));
            }
        }
        self.relations.push(relation);
    }

    /// Factor and explained fraction with the left-hand side shifted by `shift` samples; `None` where nothing moves.
    fn fit(
        &self,
        integral: &DVector<f64>,
        rate: &DVector<f64>,
        drag: Option<&DVector<f64>>,
        shift: isize,
    ) -> Option<[f64; 2]> {
        let samples = integral.len() - shift.unsigned_abs();
        let (left_from, right_from) = (shift.max(0) as usize, (-shift).max(0) as usize);
        let mut columns = vec![self.running_sum(rate.rows(right_from, samples).as_slice())];
        if let Some(drag) = drag {
            columns.push(self.running_sum(drag.rows(left_from, samples).as_slice()));
        }
        let piece = ((PIECE_S / self.period_s) as usize).clamp(3, samples.max(3));
        let regressors = straightened(DMatrix::from_columns(&columns), piece);
        let left = DMatrix::from_columns(&[integral.rows(left_from, samples).into_owned()]);
        let left = straightened(left, piece);
        let moved = left.norm_squared();
        if moved <= 1e-20 || regressors.column(0).norm_squared() <= 1e-20 {
            return None;
        }
        let solution = least_squares(regressors.clone(), &left);
        let explained = 1.0 - (&left - regressors * &solution).norm_squared() / moved;
        Some([solution[(0, 0)], explained])
    }

    /// The integral from the first sample on, by the trapezoidal rule.
    fn running_sum(&self, values: &[f64]) -> DVector<f64> {
        let (mut sum, mut before) = (0.0, None);
        DVector::from_iterator(
            values.len(),
            values.iter().map(|value| {
                sum +=
                    0.5 * self.period_s * before.replace(*value).map_or(0.0, |last| last + value);
                sum
            }),
        )
    }

    fn done(self) -> KinematicReport {
        KinematicReport { relations: self.relations, faults: self.faults }
    }
}

/// Each column without mean and slope, piece by piece. Rows past the last whole piece are ignored, unless no piece is
/// whole.
fn straightened(mut signals: DMatrix<f64>, piece: usize) -> DMatrix<f64> {
    let piece = piece.min(signals.nrows());
    let rows = signals.nrows() / piece.max(1) * piece;
    signals = signals.rows(0, rows).into_owned();
    let middle = (piece as f64 - 1.0) / 2.0;
    let spread: f64 = (0..piece).map(|row| (row as f64 - middle).powi(2)).sum();
    for mut column in signals.column_iter_mut() {
        for part in column.as_mut_slice().chunks_exact_mut(piece) {
            let mean = part.iter().sum::<f64>() / piece as f64;
            let moment: f64 =
                part.iter().enumerate().map(|(row, value)| (row as f64 - middle) * value).sum();
            for (row, value) in part.iter_mut().enumerate() {
                *value -= mean + moment / spread * (row as f64 - middle);
            }
        }
    }
    signals
}
