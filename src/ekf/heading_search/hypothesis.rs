//! One hypothesis of the attitude: a Kalman filter of nine states from fix to fix.

use crate::earth::STANDARD_GRAVITY_MPS2;
use crate::frames::{Body, Ned, Rotation, Vector};
use crate::matrix::{add_scaled, combined, dot, product, skew, square, times};
use crate::scalar::Scalar;

/// Number of hypotheses.
pub(super) const HYPOTHESES: usize = 12;
/// One-sigma of the heading of a hypothesis at its start, rad: neighbours overlap at one sigma.
pub(super) const HYPOTHESIS_SIGMA_RAD: f64 = core::f64::consts::PI / HYPOTHESES as f64;
/// Gravity, m/s².
const GRAVITY_MPS2: f32 = STANDARD_GRAVITY_MPS2 as f32;

/// States, true minus estimated. Velocity, NED, m/s; attitude, the rotation in NED from the hypothesis to the truth,
/// rad; and gyro bias, body, rad/s.
pub const STATES: usize = 9;
/// Index of the first attitude error.
const ATTITUDE: usize = 3;

/// One value for each state.
type Row = [f32; STATES];

/// Covariance of the states of a hypothesis.
pub type Block = [Row; STATES];

/// Fraction of a velocity change that counts as error: fixes and samples differ in time.
const TIMING: f32 = 0.1;

/// Motion between two fixes, in the body axes at the start of the bank.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeasuredMotion {
    /// Velocity change by specific force, m/s.
    pub velocity_mps: Vector<Body, f32>,
    /// Duration, s.
    pub duration_s: f32,
    /// Integral of the direction cosines from the body axes of each sample, s.
    pub turned_s: [[f32; 3]; 3],
    /// Variance by sensor noise of each angle, rad², and of each velocity, (m/s)².
    pub variances: [f32; 2],
}

impl MeasuredMotion {
    /// No motion.
    pub const NONE: Self = Self {
        velocity_mps: Vector::ZERO,
        duration_s: 0.0,
        turned_s: [[0.0; 3]; 3],
        variances: [0.0; 2],
    };

    /// Velocity change by gravity, m/s.
    fn fall_mps(&self) -> Vector<Ned, f32> {
        Vector::new(0.0, 0.0, GRAVITY_MPS2 * self.duration_s)
    }
}

/// Velocity of a fix, NED.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured {
    /// Velocity, m/s, and its variance, (m/s)²; `None` for an axis that the fix does not measure.
    pub axes: [Option<(f32, f32)>; 3],
    /// Whether the velocity is the mean since the previous fix, from positions.
    pub is_mean: bool,
    /// Velocity of the antenna relative to the inertial unit, in the body axes at the start of the bank, m/s.
    pub swing_mps: Vector<Body, f32>,
}

/// Likelihood of a measurement.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surprise {
    /// Sum of the squared normalised innovations of the horizontal axes.
    pub horizontal_squares: f32,
    /// Minus twice the logarithm of the likelihood of all axes, up to a constant.
    pub minus_two_log: f32,
}

/// Prior common to all hypotheses at their first fix.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    /// Axis about which the attitude is unknown, NED.
    pub axis: Vector<Ned, f32>,
    /// One-sigma of the attitude across `axis`, rad.
    pub tilt_sigma_rad: f32,
    /// One-sigma of the gyro bias, rad/s.
    pub bias_sigma_radps: f32,
}

/// A hypothesis of the attitude.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hypothesis {
    pub weight: f64,
    /// Attitude: rotation to NED from the body axes at the time when the bank of hypotheses started.
    pub start_to_ned: Rotation<Body, Ned, f32>,
    velocity_mps: Vector<Ned, f32>,
    bias_radps: Vector<Body, f32>,
    covariance: Block,
}

impl Hypothesis {
    /// Empty hypothesis, of weight zero.
    pub const NONE: Self = Self {
        weight: 0.0,
        start_to_ned: Rotation::IDENTITY,
        velocity_mps: Vector::ZERO,
        bias_radps: Vector::ZERO,
        covariance: [[0.0; STATES]; STATES],
    };

    /// Starts at a fix, with the present attitude of the hypothesis.
    pub fn start(&mut self, measured: &Measured, prior: &Prior) {
        let swing = (self.start_to_ned * measured.swing_mps).to_array();
        let velocity = |axis| match at(&measured.axes, axis) {
            Some((value, _)) => value - at(&swing, axis),
            None => 0.0,
        };
        self.velocity_mps = Vector::new(velocity(0), velocity(1), velocity(2));
        self.bias_radps = Vector::ZERO;
        self.covariance = [[0.0; STATES]; STATES];
        let (tilt, open) = (square(prior.tilt_sigma_rad), square(HYPOTHESIS_SIGMA_RAD as f32));
        let [north, east, down] =
            measured.axes.map(|axis| axis.map_or(square(UNKNOWN_MPS), |(_, variance)| variance));
        let bias = square(prior.bias_sigma_radps);
        self.add_noise([north, east, down, tilt, tilt, tilt, bias, bias, bias]);
        let axis = prior.axis.to_array();
        for (row, a) in self.covariance.iter_mut().skip(ATTITUDE).zip(axis) {
            for (value, b) in row.iter_mut().skip(ATTITUDE).zip(axis) {
                *value += (open - tilt) * a * b;
            }
        }
    }

    /// Variances of the attitude about north, east and down, rad².
    pub fn attitude_variances(&self) -> [f32; 3] {
        let [_, _, _, north, east, down, ..] = self.variances();
        [north, east, down]
    }

    /// Gyro bias, rad/s.
    pub fn bias_radps(&self) -> Vector<Body, f32> {
        self.bias_radps
    }

    /// Covariance of velocity, attitude and gyro bias.
    pub fn covariance(&self) -> &Block {
        &self.covariance
    }

    fn variances(&self) -> Row {
        let mut variances = [0.0; STATES];
        for (state, (variance, row)) in variances.iter_mut().zip(&self.covariance).enumerate() {
            *variance = row.get(state).copied().unwrap_or_default();
        }
        variances
    }

    fn add_noise(&mut self, noise: Row) {
        for (state, (row, noise)) in self.covariance.iter_mut().zip(noise).enumerate() {
            if let Some(variance) = row.get_mut(state) {
                *variance += noise;
            }
        }
    }

    /// Subtracts a gyro bias that the caller removes from the rates from now on.
    pub fn correct_bias(&mut self, bias_radps: Vector<Body, f32>) {
        self.bias_radps -= bias_radps;
    }

    /// Integral of the direction cosines from body to NED, s. Its product with a gyro bias is the rotation in NED by
    /// that bias.
    fn turned_s(&self, felt: &MeasuredMotion) -> [[f32; 3]; 3] {
        product(&self.start_to_ned.rows(), &felt.turned_s)
    }

    /// Velocity change by specific force, NED, m/s. The rotation by the bias grows at a constant rate, so on average
    /// half of it acts on the force.
    fn force_mps(&self, felt: &MeasuredMotion, turned_s: &[[f32; 3]; 3]) -> Vector<Ned, f32> {
        let force = self.start_to_ned * felt.velocity_mps;
        force - self.turn(turned_s).cross(force) * 0.5
    }

    /// Rotation by the estimated gyro bias, NED, rad: the product of `turned_s` with the bias.
    fn turn(&self, turned_s: &[[f32; 3]; 3]) -> Vector<Ned, f32> {
        times(turned_s, &self.bias_radps.to_array()).into()
    }

    /// Velocity after the motion since the last fix, NED, m/s.
    pub fn velocity_after(&self, felt: &MeasuredMotion) -> Vector<Ned, f32> {
        self.velocity_mps + self.force_mps(felt, &self.turned_s(felt)) + felt.fall_mps()
    }

    /// Propagates to a fix, and fuses its velocity.
    ///
    /// # Source
    /// Equation (H5) of docs/equations.md.
    pub fn step(&mut self, felt: &MeasuredMotion, measured: &Measured) -> Surprise {
        let turned_s = self.turned_s(felt);
        let force = self.force_mps(felt, &turned_s);
        // A rotation ψ changes a vector v by ψ × v.
        let by_attitude = skew((-force).to_array());
        let by_bias = turned_s.map(|row| row.map(|s| -s));
        let half = product(&by_attitude, &by_bias).map(|row| row.map(|value| 0.5 * value));
        let change = force + felt.fall_mps();
        self.propagate(&by_attitude, &half, &by_bias, felt, change);

        let swing = self.start_to_ned * measured.swing_mps;
        let swing_by_attitude = skew((-swing).to_array());
        let (velocity_mps, change) = ((self.velocity_mps + swing).to_array(), change.to_array());
        let mut error = [0.0; STATES];
        let mut surprise = Surprise { horizontal_squares: 0.0, minus_two_log: 0.0 };
        for (axis, velocity) in measured.axes.into_iter().enumerate() {
            let Some((value, variance)) = velocity else { continue };
            let mut predicted = at(&velocity_mps, axis);
            let ([x, y, z], [i, j, k]) = (at(&UNITS, axis), at(&swing_by_attitude, axis));
            let mut sensitivity = [x, y, z, i, j, k, 0.0, 0.0, 0.0];
            if measured.is_mean {
                // The mean velocity over the interval differs from that at its end by half the velocity change.
                predicted -= 0.5 * at(&change, axis);
                let slopes = at(&by_attitude, axis).into_iter().chain(at(&half, axis));
                for (sensitivity, slope) in sensitivity.iter_mut().skip(ATTITUDE).zip(slopes) {
                    *sensitivity -= 0.5 * slope;
                }
            }
            let innovation = value - predicted - dot(&sensitivity, &error);
            let total = self.update(&sensitivity, innovation, variance, &mut error);
            let squared = square(innovation) / total;
            surprise.minus_two_log += squared + Scalar::ln(total);
            if axis < 2 {
                surprise.horizontal_squares += squared;
            }
        }
        let [north, east, down, x, y, z, p, q, r] = error;
        self.velocity_mps += Vector::new(north, east, down);
        self.bias_radps += Vector::new(p, q, r);
        self.start_to_ned = self.start_to_ned.turned_in_to(Vector::new(x, y, z)).renormalised();
        surprise
    }

    fn propagate(
        &mut self,
        by_attitude: &[[f32; 3]; 3],
        half: &[[f32; 3]; 3],
        by_bias: &[[f32; 3]; 3],
        felt: &MeasuredMotion,
        change: Vector<Ned, f32>,
    ) {
        // The transition is the identity except for the rows of velocity and attitude. The rows of velocity come first,
        // because they read the attitude before its change.
        let [v0, v1, v2, a0, a1, a2, b0, b1, b2] = &mut self.covariance;
        let rows =
            || by_attitude.iter().zip(half).map(|(&[a, b, c], &[d, e, f])| [a, b, c, d, e, f]);
        for (row, factors) in [v0, v1, v2].into_iter().zip(rows()) {
            add_scaled(row, 1.0, &combined(factors, [&*a0, &*a1, &*a2, &*b0, &*b1, &*b2]));
        }
        for (row, factors) in [a0, a1, a2].into_iter().zip(by_bias) {
            add_scaled(row, 1.0, &combined(*factors, [&*b0, &*b1, &*b2]));
        }
        for line in &mut self.covariance {
            let [v0, v1, v2, a0, a1, a2, b0, b1, b2] = line;
            let bias = [*b0, *b1, *b2];
            let driving = [*a0, *a1, *a2, *b0, *b1, *b2];
            for (value, factors) in [v0, v1, v2].into_iter().zip(rows()) {
                *value += dot(&factors, &driving);
            }
            for (value, factors) in [a0, a1, a2].into_iter().zip(by_bias) {
                *value += dot(factors, &bias);
            }
        }
        let [angle, velocity_variance] = felt.variances;
        let [north, east, _] = change.to_array();
        let velocity = velocity_variance + square(TIMING) * (square(north) + square(east));
        self.add_noise([velocity, velocity, velocity, angle, angle, angle, 0.0, 0.0, 0.0]);
        self.velocity_mps += change;
        self.start_to_ned = self.start_to_ned.turned_in_to(self.turn(by_bias));
    }

    /// Scalar Kalman update of the covariance and of the `error`; returns the innovation's variance.
    fn update(
        &mut self,
        sensitivity: &Row,
        innovation: f32,
        variance: f32,
        error: &mut Row,
    ) -> f32 {
        let seen = times(&self.covariance, sensitivity);
        let total = dot(&seen, sensitivity) + variance;
        for ((row, own), error) in self.covariance.iter_mut().zip(seen).zip(error) {
            *error += own / total * innovation;
            for (value, other) in row.iter_mut().zip(seen) {
                *value -= own * other / total;
            }
        }
        total
    }

    /// Whether attitude, velocity, bias and variances are still valid: rounding may have spoilt them.
    pub fn is_sound(&self) -> bool {
        self.start_to_ned.is_finite()
            && self.velocity_mps.is_finite()
            && self.bias_radps.is_finite()
            && self.variances().iter().all(|variance| *variance >= 0.0 && variance.is_finite())
    }
}

/// One-sigma of a velocity that no fix has measured, m/s.
const UNKNOWN_MPS: f32 = 10.0;

/// Unit vectors north, east and down.
const UNITS: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// An element of an array of three, zero beyond its end.
pub(super) fn at<V: Copy + Default>(values: &[V; 3], axis: usize) -> V {
    values.get(axis).copied().unwrap_or_default()
}
