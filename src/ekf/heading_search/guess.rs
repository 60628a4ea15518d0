//! One guess at the attitude: a Kalman filter of nine states from fix to fix.
#![expect(clippy::indexing_slicing, reason = "indices below the constant lengths of the arrays")]

use super::super::scalar::Scalar;
use super::super::square;
use super::{GRAVITY_MPS2, GUESS_SIGMA_RAD};
use crate::frames::{Body, Ned, Rotation, Vector};

/// States, true minus estimated. Velocity, NED, m/s; attitude, the rotation in NED from the guess to the truth, rad;
/// and gyro bias, body, rad/s.
const STATES: usize = 9;
const ATTITUDE: usize = 3;
const BIAS: usize = 6;

/// Covariance of these states.
pub type Block = [[f32; STATES]; STATES];

/// Share of a velocity change that counts as error: fixes and samples differ in time.
const TIMING: f32 = 0.1;

/// Motion between two fixes, in the body axes at the start of the bank.
#[derive(Clone, Copy, Debug)]
pub(super) struct Felt {
    /// Velocity change by specific force, m/s.
    pub velocity_mps: [f32; 3],
    /// Duration, s.
    pub duration_s: f32,
    /// Integral of the direction cosines from the body's axes, s.
    pub turned_s: [[f32; 3]; 3],
    /// Variance by sensor noise of each angle, rad², and of each velocity, (m/s)².
    pub variances: [f32; 2],
}

impl Felt {
    /// No motion.
    pub const NONE: Self = Self {
        velocity_mps: [0.0; 3],
        duration_s: 0.0,
        turned_s: [[0.0; 3]; 3],
        variances: [0.0; 2],
    };
}

/// Velocity of a fix, NED.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured {
    /// Velocity, m/s, and its variance, (m/s)²; `None` for an axis that the fix does not measure.
    pub axes: [Option<(f32, f32)>; 3],
    /// Whether it is the mean since the previous fix, from positions.
    pub is_mean: bool,
    /// Velocity of the antenna against the inertial unit, in the body axes at the start of the bank, m/s.
    pub swing_mps: [f32; 3],
}

/// Result of a measurement.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surprise {
    /// Sum of the squared normalised innovations of the horizontal axes.
    pub horizontal_squares: f32,
    /// Minus twice the logarithm of the likelihood of all axes, up to a constant.
    pub minus_two_log: f32,
}

/// Prior common to all guesses at their first fix.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    /// Direction about which the attitude is open, NED.
    pub axis: [f32; 3],
    /// One-sigma of the attitude across it, rad.
    pub tilt_sigma_rad: f32,
    /// One-sigma of the gyro bias, rad/s.
    pub bias_sigma_radps: f32,
}

/// A guess at the attitude.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guess {
    pub weight: f64,
    /// From the body axes at the start of the bank.
    pub start_to_ned: Rotation<Body, Ned, f32>,
    velocity_mps: [f32; 3],
    bias_radps: [f32; 3],
    covariance: Block,
}

impl Guess {
    /// Empty guess, of weight zero.
    pub const NONE: Self = Self {
        weight: 0.0,
        start_to_ned: Rotation::IDENTITY,
        velocity_mps: [0.0; 3],
        bias_radps: [0.0; 3],
        covariance: [[0.0; STATES]; STATES],
    };

    /// Starts at a fix, with the present attitude of the guess.
    pub fn start(&mut self, measured: &Measured, prior: &Prior) {
        let [x, y, z] = measured.swing_mps;
        let swing = (self.start_to_ned * Vector::<Body, f32>::new(x, y, z)).to_array();
        self.velocity_mps = core::array::from_fn(|axis| {
            measured.axes[axis].map_or(0.0, |(value, _)| value - swing[axis])
        });
        self.bias_radps = [0.0; 3];
        self.covariance = [[0.0; STATES]; STATES];
        let (tilt, open) = (square(prior.tilt_sigma_rad), square(GUESS_SIGMA_RAD as f32));
        for row in 0..3 {
            let variance = measured.axes[row].map_or(square(UNKNOWN_MPS), |(_, variance)| variance);
            self.covariance[row][row] = variance;
            self.covariance[ATTITUDE + row][ATTITUDE + row] = tilt;
            self.covariance[BIAS + row][BIAS + row] = square(prior.bias_sigma_radps);
            for column in 0..3 {
                self.covariance[ATTITUDE + row][ATTITUDE + column] +=
                    (open - tilt) * prior.axis[row] * prior.axis[column];
            }
        }
    }

    /// Variances of the attitude about north, east and down, rad².
    pub fn attitude_variances(&self) -> [f32; 3] {
        self.variances(ATTITUDE)
    }

    /// Gyro bias, rad/s.
    pub fn bias_radps(&self) -> [f32; 3] {
        self.bias_radps
    }

    /// Covariance of velocity, attitude and gyro bias.
    pub fn covariance(&self) -> &Block {
        &self.covariance
    }

    fn variances(&self, first: usize) -> [f32; 3] {
        core::array::from_fn(|axis| self.covariance[first + axis][first + axis])
    }

    /// Subtracts a gyro bias that the caller from now on removes from the rates.
    pub fn correct_bias(&mut self, bias_radps: [f32; 3]) {
        for (own, bias) in self.bias_radps.iter_mut().zip(bias_radps) {
            *own -= bias;
        }
    }

    /// Integral of the rotation by the bias, in NED, for a bias along each body axis, s.
    fn turned_s(&self, felt: &Felt) -> [[f32; 3]; 3] {
        let rows = self.start_to_ned.rows();
        rows.map(|row| {
            core::array::from_fn(|axis| (0..3).map(|k| row[k] * felt.turned_s[k][axis]).sum())
        })
    }

    /// Velocity change by specific force, NED, m/s. The rotation by the bias grows evenly, so half of it acts on the
    /// force.
    fn force_mps(&self, felt: &Felt, turned_s: &[[f32; 3]; 3]) -> Vector<Ned, f32> {
        let turn = product(turned_s, self.bias_radps);
        let [x, y, z] = felt.velocity_mps;
        let force = self.start_to_ned * Vector::<Body, f32>::new(x, y, z);
        force - Vector::from(turn).cross(force) * 0.5
    }

    /// Velocity after the motion since the last fix, NED, m/s.
    pub fn velocity_after(&self, felt: &Felt) -> [f32; 3] {
        let force = self.force_mps(felt, &self.turned_s(felt)).to_array();
        let [north, east, down] = self.velocity_mps;
        [north + force[0], east + force[1], down + force[2] + GRAVITY_MPS2 * felt.duration_s]
    }

    /// Propagates to a fix, and fuses its velocity.
    ///
    /// # Source
    /// Equation (H5) of docs/equations.md.
    pub fn step(&mut self, felt: &Felt, measured: &Measured) -> Surprise {
        let turned_s = self.turned_s(felt);
        let force = self.force_mps(felt, &turned_s).to_array();
        let by_attitude = cross(force);
        let by_bias = turned_s.map(|row| row.map(|s| -s));
        let half = multiply(&by_attitude, &by_bias).map(|row| row.map(|value| 0.5 * value));
        let mut change = force;
        change[2] += GRAVITY_MPS2 * felt.duration_s;
        self.propagate(&by_attitude, &half, &by_bias, felt, change);

        let [x, y, z] = measured.swing_mps;
        let swing = (self.start_to_ned * Vector::<Body, f32>::new(x, y, z)).to_array();
        let swing_by_attitude = cross(swing);
        let mut error = [0.0; STATES];
        let mut surprise = Surprise { horizontal_squares: 0.0, minus_two_log: 0.0 };
        for (axis, told) in measured.axes.into_iter().enumerate() {
            let Some((value, variance)) = told else { continue };
            let mut sensitivity = [0.0; STATES];
            sensitivity[axis] = 1.0;
            let mut predicted = self.velocity_mps[axis] + swing[axis];
            sensitivity[ATTITUDE..BIAS].copy_from_slice(&swing_by_attitude[axis]);
            if measured.is_mean {
                // The mean over the interval lies half the velocity change before its end.
                predicted -= 0.5 * change[axis];
                for k in 0..3 {
                    sensitivity[ATTITUDE + k] -= 0.5 * by_attitude[axis][k];
                    sensitivity[BIAS + k] = -0.5 * half[axis][k];
                }
            }
            let expected: f32 = sensitivity.iter().zip(&error).map(|(h, x)| h * x).sum();
            let innovation = value - predicted - expected;
            let total = self.update(&sensitivity, innovation, variance, &mut error);
            let squared = square(innovation) / total;
            surprise.minus_two_log += squared + Scalar::ln(total);
            if axis < 2 {
                surprise.horizontal_squares += squared;
            }
        }
        for axis in 0..3 {
            self.velocity_mps[axis] += error[axis];
            self.bias_radps[axis] += error[BIAS + axis];
        }
        let turn = Vector::new(error[ATTITUDE], error[ATTITUDE + 1], error[ATTITUDE + 2]);
        self.start_to_ned = self.start_to_ned.turned_in_to(turn).renormalised();
        surprise
    }

    fn propagate(
        &mut self,
        by_attitude: &[[f32; 3]; 3],
        half: &[[f32; 3]; 3],
        by_bias: &[[f32; 3]; 3],
        felt: &Felt,
        change: [f32; 3],
    ) {
        // The transition is the identity except for the rows of velocity and attitude. The rows of velocity come first,
        // because they read the attitude before its change.
        let p = &mut self.covariance;
        let columns = |row: usize| {
            let [a, b, c] = by_attitude[row];
            let [d, e, f] = half[row];
            [a, b, c, d, e, f]
        };
        for row in 0..3 {
            let factors = columns(row);
            let moved: [f32; STATES] = core::array::from_fn(|column| {
                (0..6).map(|k| factors[k] * p[ATTITUDE + k][column]).sum()
            });
            add(&mut p[row], moved);
        }
        for row in 0..3 {
            let moved: [f32; STATES] = core::array::from_fn(|column| {
                (0..3).map(|k| by_bias[row][k] * p[BIAS + k][column]).sum()
            });
            add(&mut p[ATTITUDE + row], moved);
        }
        for line in p.iter_mut() {
            for row in 0..3 {
                let factors = columns(row);
                let moved: f32 = (0..6).map(|k| factors[k] * line[ATTITUDE + k]).sum();
                line[row] += moved;
            }
            for row in 0..3 {
                let moved: f32 = (0..3).map(|k| by_bias[row][k] * line[BIAS + k]).sum();
                line[ATTITUDE + row] += moved;
            }
        }
        let [angle_variance, velocity_variance] = felt.variances;
        let [north, east, _] = change;
        let velocity = velocity_variance + square(TIMING) * (square(north) + square(east));
        for axis in 0..3 {
            p[axis][axis] += velocity;
            p[ATTITUDE + axis][ATTITUDE + axis] += angle_variance;
            self.velocity_mps[axis] += change[axis];
        }
        let turn = Vector::from(product(by_bias, self.bias_radps));
        self.start_to_ned = self.start_to_ned.turned_in_to(turn);
    }

    /// Scalar Kalman update of the covariance and of the `error`; returns the innovation's variance.
    fn update(
        &mut self,
        sensitivity: &[f32; STATES],
        innovation: f32,
        variance: f32,
        error: &mut [f32; STATES],
    ) -> f32 {
        let seen: [f32; STATES] = core::array::from_fn(|row| {
            self.covariance[row].iter().zip(sensitivity).map(|(p, h)| p * h).sum()
        });
        let own: f32 = seen.iter().zip(sensitivity).map(|(seen, h)| seen * h).sum();
        let total = own + variance;
        for row in 0..STATES {
            error[row] += seen[row] / total * innovation;
            for column in 0..STATES {
                self.covariance[row][column] -= seen[row] * seen[column] / total;
            }
        }
        total
    }

    /// Whether rounding has left a valid covariance.
    pub fn is_sound(&self) -> bool {
        self.start_to_ned.is_finite()
            && self.velocity_mps.iter().chain(&self.bias_radps).all(|value| value.is_finite())
            && (0..STATES).all(|state| {
                let variance = self.covariance[state][state];
                variance >= 0.0 && variance.is_finite()
            })
    }
}

/// One-sigma of a velocity that no fix has measured, m/s.
const UNKNOWN_MPS: f32 = 10.0;

fn add(row: &mut [f32; STATES], moved: [f32; STATES]) {
    for (value, moved) in row.iter_mut().zip(moved) {
        *value += moved;
    }
}

/// The matrix whose product with a rotation ψ is ψ × v.
fn cross([x, y, z]: [f32; 3]) -> [[f32; 3]; 3] {
    [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
}

fn product(matrix: &[[f32; 3]; 3], vector: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum())
}

fn multiply(a: &[[f32; 3]; 3], b: &[[f32; 3]; 3]) -> [[f32; 3]; 3] {
    a.map(|row| core::array::from_fn(|column| (0..3).map(|k| row[k] * b[k][column]).sum()))
}
